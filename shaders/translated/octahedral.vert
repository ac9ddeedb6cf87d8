#version 450 core
struct Frame {
    mat4x4 clip;
    vec4 depth;
    vec4 eye;
    vec4 to_sun;
    vec4 sun;
    vec4 sky;
    vec4 ground;
    uint shading;
    float sample_size;
};
struct Impostor {
    vec4 window;
    vec4 card[4];
    uint corners;
    uint frames;
    uint tile;
    uint levels;
    uint hemi;
    uint steps;
    uint emits;
};
struct Card {
    vec4 clip;
    vec3 position;
};
struct Blend {
    vec3 color;
    vec3 normal;
    vec3 emissive;
    float t;
    float coverage;
    float weight;
};
struct Camera {
    vec2 point;
    vec3 right;
    vec3 up;
    vec3 start;
    vec3 ray;
    float middle;
    float slope;
    float level;
    float edge;
};
struct Met {
    vec2 atlas;
    bool covered;
    float gap;
    bool below;
};
struct Fragment {
    vec4 color;
    float depth;
};
const uint BISECTIONS = 5u;

layout(std140) uniform Frame_block_0Vertex { Frame _group_0_binding_0_vs; };

layout(std140) uniform Impostor_block_1Vertex { Impostor _group_0_binding_1_vs; };

layout(location = 0) smooth out vec3 _vs2fs_location0;

vec3 towards_eye() {
    float _e3 = _group_0_binding_0_vs.eye.w;
    if ((_e3 > 0.0)) {
        vec4 _e8 = _group_0_binding_0_vs.eye;
        vec4 _e12 = _group_0_binding_1_vs.window;
        return normalize((_e8.xyz - _e12.xyz));
    }
    vec4 _e18 = _group_0_binding_0_vs.eye;
    return _e18.xyz;
}

vec3 right_of(vec3 d) {
    if ((dot(d.xz, d.xz) < 1e-12)) {
        return normalize(cross(vec3(0.0, 0.0, 1.0), d));
    }
    return normalize(cross(vec3(0.0, 1.0, 0.0), d));
}

vec2 sign_of(vec2 v) {
    return mix(vec2(1.0), vec2(-1.0), lessThan(v, vec2(0.0)));
}

vec2 grid_of(vec3 direction) {
    vec3 d_1 = vec3(0.0);
    vec2 e = vec2(0.0);
    uint _e3 = _group_0_binding_1_vs.frames;
    float last = float((_e3 - 1u));
    d_1 = direction;
    uint _e10 = _group_0_binding_1_vs.hemi;
    if ((_e10 > 0u)) {
        float _e15 = d_1.y;
        d_1.y = max(_e15, 0.001);
    }
    vec3 _e18 = d_1;
    float _e20 = d_1.x;
    float _e23 = d_1.y;
    float _e27 = d_1.z;
    vec3 p = (_e18 / vec3(((abs(_e20) + abs(_e23)) + abs(_e27))));
    e = p.xz;
    uint _e36 = _group_0_binding_1_vs.hemi;
    if ((_e36 > 0u)) {
        e = vec2((p.x + p.z), (p.x - p.z));
    } else {
        if ((p.y < 0.0)) {
            vec2 _e55 = sign_of(p.xz);
            e = ((vec2(1.0) - abs(p.zx)) * _e55);
        }
    }
    vec2 _e57 = e;
    return clamp((((_e57 * 0.5) + vec2(0.5)) * last), vec2(0.0), vec2(last));
}

vec3 direction_of(vec2 point) {
    uint _e3 = _group_0_binding_1_vs.frames;
    vec2 e_1 = (((point / vec2(float((_e3 - 1u)))) * 2.0) - vec2(1.0));
    uint _e16 = _group_0_binding_1_vs.hemi;
    if ((_e16 > 0u)) {
        vec2 p_1 = (vec2((e_1.x + e_1.y), (e_1.x - e_1.y)) * 0.5);
        return normalize(vec3(p_1.x, max(((1.0 - abs(p_1.x)) - abs(p_1.y)), 0.0), p_1.y));
    }
    float y = ((1.0 - abs(e_1.x)) - abs(e_1.y));
    vec2 _e53 = sign_of(e_1);
    vec2 p_2 = ((y < 0.0) ? ((vec2(1.0) - abs(e_1.yx)) * _e53) : e_1);
    return normalize(vec3(p_2.x, y, p_2.y));
}

vec3 lit(vec3 base, vec3 normal, vec3 position) {
    vec3 color_1 = vec3(0.0);
    bool local_7 = false;
    vec4 _e5 = _group_0_binding_0_vs.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    vec4 _e12 = _group_0_binding_0_vs.ground;
    vec4 _e16 = _group_0_binding_0_vs.sky;
    vec3 ambient = mix(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    vec4 _e26 = _group_0_binding_0_vs.sun;
    color_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = _group_0_binding_0_vs.sun.w;
    if ((_e35 > 0.0)) {
        local_7 = (sun > 0.0);
    } else {
        local_7 = false;
    }
    bool _e43 = local_7;
    if (_e43) {
        vec4 _e46 = _group_0_binding_0_vs.eye;
        float _e51 = _group_0_binding_0_vs.eye.w;
        vec3 to_eye = normalize((_e46.xyz - (position * _e51)));
        vec4 _e57 = _group_0_binding_0_vs.to_sun;
        vec3 h = normalize((_e57.xyz + to_eye));
        vec3 _e61 = color_1;
        vec4 _e64 = _group_0_binding_0_vs.sun;
        float _e69 = _group_0_binding_0_vs.sun.w;
        float _e76 = _group_0_binding_0_vs.to_sun.w;
        color_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal, h), 0.0), _e76)) * sun)));
    }
    vec3 _e82 = color_1;
    return _e82;
}

void main() {
    uint index = uint(gl_VertexID);
    uint triangle = (index / 3u);
    uint k_1 = (index % 3u);
    uint corner = ((k_1 == 0u) ? 0u : (triangle + k_1));
    vec4 pair = _group_0_binding_1_vs.card[(corner / 2u)];
    vec2 at = (((corner & 1u) == 1u) ? pair.zw : pair.xy);
    vec3 _e23 = towards_eye();
    vec3 _e24 = right_of(_e23);
    vec3 offset = ((_e23 + (_e24 * at.x)) + (cross(_e23, _e24) * at.y));
    vec4 _e34 = _group_0_binding_1_vs.window;
    float _e39 = _group_0_binding_1_vs.window.w;
    vec3 position_1 = (_e34.xyz + (offset * _e39));
    mat4x4 _e44 = _group_0_binding_0_vs.clip;
    Card _tmp_return = Card((_e44 * vec4(position_1, 1.0)), position_1);
    gl_Position = _tmp_return.clip;
    _vs2fs_location0 = _tmp_return.position;
    return;
}

