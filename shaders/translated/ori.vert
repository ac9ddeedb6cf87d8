#version 450 core
#extension GL_ARB_shader_storage_buffer_object : require
uniform uint naga_vs_first_instance;

struct Frame {
    mat4x4 clip;
    vec4 depth;
    vec4 eye;
    vec4 to_sun;
    vec4 sun;
    vec4 sky;
    vec4 ground;
    float near;
    float far;
    float sample_size;
    uint shading;
};
struct Impostor {
    vec4 centre;
    vec4 extent;
    uint side;
    uint squares;
    uint depths;
    uint codes;
    uint levels;
    uint emits;
    uint strategy;
    uint steps;
    uint halvings;
    float wall;
};
struct Map {
    vec4 rows[3];
    vec4 window;
    float deep;
    float step_;
    float texel;
    uint first;
};
struct Instance {
    vec4 place;
    vec4 rotation;
    uvec4 maps;
};
struct Ray {
    vec3 origin;
    vec3 direction;
};
struct Proxy {
    vec4 clip;
    vec3 position;
    uint instance;
};
struct Seen {
    uint map;
    float t;
};
struct Fragment {
    vec4 color;
    float depth;
};
const uint MAPS = 8u;
const uint NO_MAP = 65535u;

layout(std140) uniform Frame_block_0Vertex { Frame _group_0_binding_0_vs; };

layout(std140) uniform Impostor_block_1Vertex { Impostor _group_0_binding_1_vs; };

layout(std430) readonly buffer type_7_block_2Vertex { Instance _group_0_binding_3_vs[]; };

layout(location = 0) smooth out vec3 _vs2fs_location0;
layout(location = 1) flat out uint _vs2fs_location1;

vec3 turned(vec3 v, vec4 q) {
    return (v + (2.0 * cross(q.xyz, (cross(q.xyz, v) + (q.w * v)))));
}

vec3 turned_back(vec3 v_1, vec4 q_1) {
    return (v_1 + (2.0 * cross(q_1.xyz, (cross(q_1.xyz, v_1) - (q_1.w * v_1)))));
}

ivec2 corner_of(ivec2 first, uint k_1) {
    return (first + ivec2(uvec2((k_1 & 1u), (k_1 >> 1u))));
}

float rising_root(float e, float f, float g) {
    float under_1 = ((f * f) - ((4.0 * e) * g));
    if (!((under_1 > 0.0))) {
        return 3e38;
    }
    float root = sqrt(under_1);
    if ((f >= 0.0)) {
        return ((-2.0 * e) / (f + root));
    }
    if ((g == 0.0)) {
        return 3e38;
    }
    return ((root - f) / (2.0 * g));
}

bool shows(vec2 texels_1[4], uint bits_2, vec2 at_1) {
    vec2 all_texels[4] = vec2[4](vec2(0.0), vec2(0.0), vec2(0.0), vec2(0.0));
    vec4 weights = vec4(0.0);
    float edge = 0.0;
    uint own = 0u;
    float most = -1.0;
    uint k_3 = 0u;
    bool local_5 = false;
    bool local_6 = false;
    all_texels = texels_1;
    vec2 p_1 = clamp(at_1, vec2(0.0), vec2(1.0));
    weights = vec4(((1.0 - p_1.x) * (1.0 - p_1.y)), (p_1.x * (1.0 - p_1.y)), ((1.0 - p_1.x) * p_1.y), (p_1.x * p_1.y));
    bool loop_init = true;
    while(true) {
        if (!loop_init) {
            uint _e72 = k_3;
            k_3 = (_e72 + 1u);
        }
        loop_init = false;
        uint _e39 = k_3;
        if ((_e39 < 4u)) {
        } else {
            break;
        }
        {
            float _e42 = edge;
            uint _e43 = k_3;
            float _e45 = weights[_e43];
            uint _e46 = k_3;
            float _e49 = all_texels[_e46].y;
            edge = (_e42 + (_e45 * _e49));
            uint _e52 = k_3;
            float _e55 = all_texels[_e52].x;
            if ((_e55 < 1e38)) {
                uint _e60 = k_3;
                float _e62 = weights[_e60];
                float _e63 = most;
                local_5 = (_e62 > _e63);
            } else {
                local_5 = false;
            }
            bool _e66 = local_5;
            if (_e66) {
                uint _e67 = k_3;
                own = _e67;
                uint _e68 = k_3;
                float _e70 = weights[_e68];
                most = _e70;
            }
        }
    }
    float _e74 = edge;
    if ((_e74 > 0.0)) {
        uint _e79 = own;
        local_6 = (((bits_2 >> _e79) & 1u) == 1u);
    } else {
        local_6 = false;
    }
    bool _e86 = local_6;
    return _e86;
}

float slope(float before, float at_3, float after) {
    bool local_15 = false;
    float _e7 = _group_0_binding_1_vs.wall;
    bool has_before = (abs((before - at_3)) <= _e7);
    float _e13 = _group_0_binding_1_vs.wall;
    bool has_after = (abs((after - at_3)) <= _e13);
    if (has_before) {
        local_15 = has_after;
    } else {
        local_15 = false;
    }
    bool _e18 = local_15;
    if (_e18) {
        return (after - before);
    }
    if (has_before) {
        return (2.0 * (at_3 - before));
    }
    if (has_after) {
        return (2.0 * (after - at_3));
    }
    return 0.0;
}

uint map_of(uint instance, uint k_7) {
    uint pair = _group_0_binding_3_vs[instance].maps[(k_7 >> 1u)];
    return (((k_7 & 1u) == 1u) ? (pair >> 16u) : (pair & 65535u));
}

vec3 lit(vec3 base, vec3 normal, vec3 position) {
    vec3 out_1 = vec3(0.0);
    bool local_18 = false;
    vec4 _e5 = _group_0_binding_0_vs.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    vec4 _e12 = _group_0_binding_0_vs.ground;
    vec4 _e16 = _group_0_binding_0_vs.sky;
    vec3 ambient = mix(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    vec4 _e26 = _group_0_binding_0_vs.sun;
    out_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = _group_0_binding_0_vs.sun.w;
    if ((_e35 > 0.0)) {
        local_18 = (sun > 0.0);
    } else {
        local_18 = false;
    }
    bool _e43 = local_18;
    if (_e43) {
        vec4 _e46 = _group_0_binding_0_vs.eye;
        float _e51 = _group_0_binding_0_vs.eye.w;
        vec3 to_eye = normalize((_e46.xyz - (position * _e51)));
        vec4 _e57 = _group_0_binding_0_vs.to_sun;
        vec3 h = normalize((_e57.xyz + to_eye));
        vec3 _e61 = out_1;
        vec4 _e64 = _group_0_binding_0_vs.sun;
        float _e69 = _group_0_binding_0_vs.sun.w;
        float _e76 = _group_0_binding_0_vs.to_sun.w;
        out_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal, h), 0.0), _e76)) * sun)));
    }
    vec3 _e82 = out_1;
    return _e82;
}

void main() {
    uint index = uint(gl_VertexID);
    uint number = (uint(gl_InstanceID) + naga_vs_first_instance);
    bool local = false;
    bool local_1 = false;
    bool local_2 = false;
    uvec3 bits = uvec3(0u);
    vec4 clip = vec4(0.0);
    uint face = (index / 6u);
    uint corner = (index % 6u);
    if (!((corner == 1u))) {
        local = (corner == 2u);
    } else {
        local = true;
    }
    bool _e14 = local;
    if (!(_e14)) {
        local_1 = (corner == 4u);
    } else {
        local_1 = true;
    }
    bool _e21 = local_1;
    if (!((corner == 2u))) {
        local_2 = (corner >= 4u);
    } else {
        local_2 = true;
    }
    bool _e31 = local_2;
    uvec2 across = uvec2(uint(_e21), uint(_e31));
    uint axis = (face >> 1u);
    uint side = (face & 1u);
    uvec2 along = ((side == 1u) ? across : across.yx);
    bits[axis] = side;
    bits[((axis + 1u) % 3u)] = along.x;
    bits[((axis + 2u) % 3u)] = along.y;
    uvec3 _e58 = bits;
    vec4 _e67 = _group_0_binding_1_vs.extent;
    vec3 position_2 = (((vec3(_e58) * 2.0) - vec3(1.0)) * _e67.xyz);
    Instance instance_3 = _group_0_binding_3_vs[number];
    vec4 _e77 = _group_0_binding_1_vs.centre;
    vec3 _e81 = turned((position_2 + _e77.xyz), instance_3.rotation);
    vec3 world = (instance_3.place.xyz + (_e81 * instance_3.place.w));
    mat4x4 _e88 = _group_0_binding_0_vs.clip;
    clip = (_e88 * vec4(world, 1.0));
    float _e95 = clip.w;
    clip.z = (0.5 * _e95);
    vec4 _e98 = clip;
    Proxy _tmp_return = Proxy(_e98, position_2, number);
    gl_Position = _tmp_return.clip;
    _vs2fs_location0 = _tmp_return.position;
    _vs2fs_location1 = _tmp_return.instance;
    return;
}

