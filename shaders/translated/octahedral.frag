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
struct Fragment {
    vec4 color;
    float depth;
};
layout(std140) uniform Frame_block_0Fragment { Frame _group_0_binding_0_fs; };

layout(std140) uniform Impostor_block_1Fragment { Impostor _group_0_binding_1_fs; };

uniform sampler2D _group_0_binding_2_fs;

uniform sampler2D _group_0_binding_3_fs;

uniform sampler2D _group_0_binding_4_fs;

layout(location = 0) smooth in vec3 _vs2fs_location0;
layout(location = 0) out vec4 _fs2p_location0;

vec3 towards_eye() {
    float _e3 = _group_0_binding_0_fs.eye.w;
    if ((_e3 > 0.0)) {
        vec4 _e8 = _group_0_binding_0_fs.eye;
        vec4 _e12 = _group_0_binding_1_fs.window;
        return normalize((_e8.xyz - _e12.xyz));
    }
    vec4 _e18 = _group_0_binding_0_fs.eye;
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
    uint _e3 = _group_0_binding_1_fs.frames;
    float last = float((_e3 - 1u));
    d_1 = direction;
    uint _e10 = _group_0_binding_1_fs.hemi;
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
    uint _e36 = _group_0_binding_1_fs.hemi;
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
    uint _e3 = _group_0_binding_1_fs.frames;
    vec2 e_1 = (((point / vec2(float((_e3 - 1u)))) * 2.0) - vec2(1.0));
    uint _e16 = _group_0_binding_1_fs.hemi;
    if ((_e16 > 0u)) {
        vec2 p_1 = (vec2((e_1.x + e_1.y), (e_1.x - e_1.y)) * 0.5);
        return normalize(vec3(p_1.x, max(((1.0 - abs(p_1.x)) - abs(p_1.y)), 0.0), p_1.y));
    }
    float y = ((1.0 - abs(e_1.x)) - abs(e_1.y));
    vec2 _e53 = sign_of(e_1);
    vec2 p_2 = ((y < 0.0) ? ((vec2(1.0) - abs(e_1.yx)) * _e53) : e_1);
    return normalize(vec3(p_2.x, y, p_2.y));
}

void add(inout Blend blend_1, vec2 point_1, float weight, vec3 origin, vec3 ray_1, float depth) {
    bool local_1 = false;
    float t = 0.0;
    vec2 uv = vec2(0.0);
    vec2 atlas = vec2(0.0);
    uint i = 0u;
    bool local_2 = false;
    vec3 _e6 = direction_of(point_1);
    float slope = dot(ray_1, _e6);
    if (!((weight <= 0.0))) {
        local_1 = (slope > (-0.05 * length(ray_1)));
    } else {
        local_1 = true;
    }
    bool _e18 = local_1;
    if (_e18) {
        return;
    }
    float _e20 = blend_1.weight;
    blend_1.weight = (_e20 + weight);
    vec3 _e22 = right_of(_e6);
    vec3 up = cross(_e6, _e22);
    float radius = _group_0_binding_1_fs.window.w;
    vec4 _e30 = _group_0_binding_1_fs.window;
    vec3 start = (origin - _e30.xyz);
    float middle = (-(dot(start, _e6)) / slope);
    float _e40 = _group_0_binding_0_fs.eye.w;
    float far = ((_e40 > 0.0) ? (depth + middle) : 1.0);
    float _e47 = _group_0_binding_0_fs.sample_size;
    uint _e51 = _group_0_binding_1_fs.tile;
    float texels = (((_e47 * far) * float(_e51)) / (2.0 * radius));
    uint _e62 = _group_0_binding_1_fs.levels;
    float level = clamp(log2(max(texels, 1.0)), 0.0, float((_e62 - 1u)));
    uint _e70 = _group_0_binding_1_fs.tile;
    float edge = (0.5 / float((_e70 >> uint(ceil(level)))));
    t = middle;
    bool loop_init = true;
    while(true) {
        if (!loop_init) {
            uint _e131 = i;
            i = (_e131 + 1u);
        }
        loop_init = false;
        uint _e86 = i;
        uint _e89 = _group_0_binding_1_fs.steps;
        if ((_e86 <= _e89)) {
        } else {
            break;
        }
        {
            float _e91 = t;
            vec3 p_3 = ((start + (ray_1 * _e91)) / vec3(radius));
            uv = (vec2((dot(p_3, _e22) + 1.0), (1.0 - dot(p_3, up))) * 0.5);
            vec2 _e105 = uv;
            uint _e114 = _group_0_binding_1_fs.frames;
            atlas = ((point_1 + clamp(_e105, vec2(edge), vec2((1.0 - edge)))) / vec2(float(_e114)));
            vec2 _e120 = atlas;
            vec4 _e121 = textureLod(_group_0_binding_3_fs, vec2(_e120), level);
            float height = ((_e121.w * 2.0) - 1.0);
            t = (middle + ((height * radius) / slope));
        }
    }
    vec2 _e133 = uv;
    if (!(any(lessThan(_e133, vec2(0.0))))) {
        vec2 _e141 = uv;
        local_2 = any(greaterThan(_e141, vec2(1.0)));
    } else {
        local_2 = true;
    }
    bool _e147 = local_2;
    if (_e147) {
        return;
    }
    vec2 _e150 = atlas;
    vec4 color_2 = textureLod(_group_0_binding_2_fs, vec2(_e150), level);
    float w = (color_2.w * weight);
    float _e155 = blend_1.coverage;
    blend_1.coverage = (_e155 + w);
    float _e158 = blend_1.t;
    float _e159 = t;
    blend_1.t = (_e158 + (_e159 * w));
    vec3 _e163 = blend_1.color;
    blend_1.color = (_e163 + (color_2.xyz * w));
    vec3 _e168 = blend_1.normal;
    vec2 _e171 = atlas;
    vec4 _e172 = textureLod(_group_0_binding_3_fs, vec2(_e171), level);
    blend_1.normal = (_e168 + (((_e172.xyz * 2.0) - vec3(1.0)) * w));
    vec3 _e182 = blend_1.emissive;
    vec2 _e185 = atlas;
    vec4 _e186 = textureLod(_group_0_binding_4_fs, vec2(_e185), level);
    uint _e190 = _group_0_binding_1_fs.emits;
    blend_1.emissive = (_e182 + (_e186.xyz * (w * float(_e190))));
    return;
}

vec3 lit(vec3 base, vec3 normal, vec3 position) {
    vec3 color_1 = vec3(0.0);
    bool local_3 = false;
    vec4 _e5 = _group_0_binding_0_fs.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    vec4 _e12 = _group_0_binding_0_fs.ground;
    vec4 _e16 = _group_0_binding_0_fs.sky;
    vec3 ambient = mix(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    vec4 _e26 = _group_0_binding_0_fs.sun;
    color_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = _group_0_binding_0_fs.sun.w;
    if ((_e35 > 0.0)) {
        local_3 = (sun > 0.0);
    } else {
        local_3 = false;
    }
    bool _e43 = local_3;
    if (_e43) {
        vec4 _e46 = _group_0_binding_0_fs.eye;
        float _e51 = _group_0_binding_0_fs.eye.w;
        vec3 to_eye = normalize((_e46.xyz - (position * _e51)));
        vec4 _e57 = _group_0_binding_0_fs.to_sun;
        vec3 h = normalize((_e57.xyz + to_eye));
        vec3 _e61 = color_1;
        vec4 _e64 = _group_0_binding_0_fs.sun;
        float _e69 = _group_0_binding_0_fs.sun.w;
        float _e76 = _group_0_binding_0_fs.to_sun.w;
        color_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal, h), 0.0), _e76)) * sun)));
    }
    vec3 _e82 = color_1;
    return _e82;
}

void main() {
    Card in_ = Card(gl_FragCoord, _vs2fs_location0);
    vec3 ray = vec3(0.0);
    Blend blend = Blend(vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);
    bool local = false;
    vec3 color = vec3(0.0);
    vec3 _e1 = towards_eye();
    vec4 _e5 = _group_0_binding_0_fs.eye;
    ray = (in_.position - _e5.xyz);
    float _e12 = _group_0_binding_0_fs.eye.w;
    if ((_e12 == 0.0)) {
        ray = -(_e1);
    }
    vec3 _e16 = ray;
    vec4 _e19 = _group_0_binding_0_fs.depth;
    vec3 _e21 = ray;
    ray = (_e16 / vec3(dot(_e19.xyz, _e21)));
    vec4 _e27 = _group_0_binding_0_fs.depth;
    float depth_1 = dot(_e27, vec4(in_.position, 1.0));
    vec2 _e32 = grid_of(_e1);
    uint _e36 = _group_0_binding_1_fs.frames;
    vec2 cell = min(floor(_e32), vec2(float((_e36 - 2u))));
    vec2 f = (_e32 - cell);
    bool across = (f.x >= f.y);
    vec2 side = (across ? vec2(1.0, 0.0) : vec2(0.0, 1.0));
    vec3 _e70 = ray;
    add(blend, cell, (1.0 - max(f.x, f.y)), in_.position, _e70, depth_1);
    vec3 _e77 = ray;
    add(blend, (cell + side), abs((f.x - f.y)), in_.position, _e77, depth_1);
    vec3 _e85 = ray;
    add(blend, (cell + vec2(1.0)), min(f.x, f.y), in_.position, _e85, depth_1);
    float _e87 = blend.coverage;
    if (!((_e87 <= 0.0))) {
        float _e94 = blend.coverage;
        float _e96 = blend.weight;
        local = (_e94 < (0.5 * _e96));
    } else {
        local = true;
    }
    bool _e101 = local;
    if (_e101) {
        discard;
    }
    float _e103 = blend.coverage;
    float share = (1.0 / _e103);
    vec3 _e107 = ray;
    float _e109 = blend.t;
    vec3 position_1 = (in_.position + (_e107 * (_e109 * share)));
    mat4x4 _e115 = _group_0_binding_0_fs.clip;
    vec4 clip = (_e115 * vec4(position_1, 1.0));
    vec3 _e120 = blend.color;
    color = (_e120 * share);
    uint _e125 = _group_0_binding_0_fs.shading;
    if ((_e125 == 1u)) {
        vec3 _e128 = color;
        vec3 _e130 = blend.normal;
        vec3 _e132 = lit(_e128, normalize(_e130), position_1);
        vec3 _e134 = blend.emissive;
        color = (_e132 + (_e134 * share));
    }
    vec3 _e137 = color;
    Fragment _tmp_return = Fragment(vec4(_e137, 1.0), (clip.z / clip.w));
    _fs2p_location0 = _tmp_return.color;
    gl_FragDepth = _tmp_return.depth;
    return;
}

