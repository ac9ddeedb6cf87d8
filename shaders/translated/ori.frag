#version 450 core
#extension GL_ARB_shader_storage_buffer_object : require
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

layout(std140) uniform Frame_block_0Fragment { Frame _group_0_binding_0_fs; };

layout(std140) uniform Impostor_block_1Fragment { Impostor _group_0_binding_1_fs; };

layout(std430) readonly buffer type_6_block_2Fragment { Map _group_0_binding_2_fs[]; };

layout(std430) readonly buffer type_7_block_3Fragment { Instance _group_0_binding_3_fs[]; };

layout(std430) readonly buffer type_9_block_4Fragment { vec2 _group_0_binding_4_fs[]; };

uniform sampler2DArray _group_0_binding_5_fs;

uniform sampler2DArray _group_0_binding_6_fs;

uniform sampler2DArray _group_0_binding_7_fs;

uniform sampler2DArray _group_0_binding_8_fs;

layout(location = 0) smooth in vec3 _vs2fs_location0;
layout(location = 1) flat in uint _vs2fs_location1;
layout(location = 0) out vec4 _fs2p_location0;

vec3 turned(vec3 v, vec4 q) {
    return (v + (2.0 * cross(q.xyz, (cross(q.xyz, v) + (q.w * v)))));
}

vec3 turned_back(vec3 v_1, vec4 q_1) {
    return (v_1 + (2.0 * cross(q_1.xyz, (cross(q_1.xyz, v_1) - (q_1.w * v_1)))));
}

vec2 texel(uint map, ivec2 at) {
    bool local_3 = false;
    if (!(any(lessThan(at, ivec2(0))))) {
        uint _e11 = _group_0_binding_1_fs.side;
        local_3 = any(greaterThanEqual(at, ivec2(int(_e11))));
    } else {
        local_3 = true;
    }
    bool _e17 = local_3;
    if (_e17) {
        return vec2(3e38, -0.5);
    }
    uint _e23 = _group_0_binding_1_fs.codes;
    float last = float((_e23 - 1u));
    vec4 _e29 = texelFetch(_group_0_binding_5_fs, ivec3(at, map), 0);
    float code = floor(((_e29.x * last) + 0.5));
    uint _e37 = _group_0_binding_1_fs.depths;
    if ((code < float(_e37))) {
        float _e43 = _group_0_binding_2_fs[map].step_;
        return vec2((code * _e43), 0.5);
    }
    float reach = (((last - code) + 0.5) / 16.0);
    return vec2(3e38, ((-0.5 * (1.0 - reach)) / reach));
}

float straight_on(uint map_1, ivec2 a, float depth, ivec2 k) {
    vec2 _e7 = texel(map_1, ((2 * a) - k));
    float before_1 = _e7.x;
    float _e16 = _group_0_binding_1_fs.wall;
    return ((abs((before_1 - depth)) <= _e16) ? ((2.0 * depth) - before_1) : depth);
}

ivec2 corner_of(ivec2 first, uint k_1) {
    return (first + ivec2(uvec2((k_1 & 1u), (k_1 >> 1u))));
}

vec4 corners_of(uint map_2, ivec2 first_1, vec2 texels[4], uint bits_1) {
    vec4 depths = vec4(0.0);
    vec4 out_ = vec4(0.0);
    uint k_2 = 0u;
    float sum = 0.0;
    bool local_4 = false;
    depths = vec4(texels[0].x, texels[1].x, texels[2].x, texels[3].x);
    if ((bits_1 == 15u)) {
        vec4 _e16 = depths;
        return _e16;
    }
    vec4 _e17 = depths;
    out_ = _e17;
    bool loop_init = true;
    while(true) {
        if (!loop_init) {
            uint _e100 = k_2;
            k_2 = (_e100 + 1u);
        }
        loop_init = false;
        uint _e21 = k_2;
        if ((_e21 < 4u)) {
        } else {
            break;
        }
        {
            uint _e24 = k_2;
            if ((((bits_1 >> _e24) & 1u) == 1u)) {
                continue;
            }
            uint _e30 = k_2;
            uint a_1 = (_e30 ^ 1u);
            uint _e33 = k_2;
            uint b = (_e33 ^ 2u);
            uint _e36 = k_2;
            uint c = (_e36 ^ 3u);
            bvec3 has = bvec3((((bits_1 >> a_1) & 1u) == 1u), (((bits_1 >> b) & 1u) == 1u), (((bits_1 >> c) & 1u) == 1u));
            if (all(has)) {
                uint _e56 = k_2;
                float _e59 = depths[a_1];
                float _e61 = depths[b];
                float _e64 = depths[c];
                out_[_e56] = ((_e59 + _e61) - _e64);
                continue;
            }
            uint _e66 = k_2;
            ivec2 _e67 = corner_of(first_1, _e66);
            sum = 0.0;
            if (has.x) {
                ivec2 _e71 = corner_of(first_1, a_1);
                float _e73 = depths[a_1];
                float _e74 = straight_on(map_2, _e71, _e73, _e67);
                sum = _e74;
            }
            if (has.y) {
                ivec2 _e76 = corner_of(first_1, b);
                float _e78 = depths[b];
                float _e79 = straight_on(map_2, _e76, _e78, _e67);
                float _e80 = sum;
                sum = (has.x ? ((_e80 + _e79) * 0.5) : _e79);
            }
            uint _e86 = k_2;
            float _e89 = depths[c];
            float _e90 = sum;
            if (!(has.x)) {
                local_4 = has.y;
            } else {
                local_4 = true;
            }
            bool _e97 = local_4;
            out_[_e86] = (_e97 ? _e90 : _e89);
        }
    }
    vec4 _e102 = out_;
    return _e102;
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
    bool loop_init_1 = true;
    while(true) {
        if (!loop_init_1) {
            uint _e72 = k_3;
            k_3 = (_e72 + 1u);
        }
        loop_init_1 = false;
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

float meet(uint map_3, ivec2 first_2, Ray ray, float start, float end) {
    vec2 texels_2[4] = vec2[4](vec2(0.0), vec2(0.0), vec2(0.0), vec2(0.0));
    uint taken = 0u;
    float nearest = 3e38;
    uint k_4 = 0u;
    bool local_7 = false;
    uint bits_3 = 0u;
    uint l = 0u;
    bool local_8 = false;
    bool local_9 = false;
    bool local_10 = false;
    bool local_11 = false;
    vec2 _e5 = texel(map_3, first_2);
    vec2 _e10 = texel(map_3, (first_2 + ivec2(1, 0)));
    vec2 _e15 = texel(map_3, (first_2 + ivec2(0, 1)));
    vec2 _e20 = texel(map_3, (first_2 + ivec2(1, 1)));
    texels_2 = vec2[4](_e5, _e10, _e15, _e20);
    vec3 begin = (ray.origin + (ray.direction * start));
    vec3 d = ray.direction;
    vec2 corner = (begin.xy - (vec2(first_2) + vec2(0.5)));
    bool loop_init_2 = true;
    while(true) {
        if (!loop_init_2) {
            uint _e183 = k_4;
            k_4 = (_e183 + 1u);
        }
        loop_init_2 = false;
        uint _e40 = k_4;
        if ((_e40 < 4u)) {
        } else {
            break;
        }
        {
            uint _e43 = taken;
            uint _e44 = k_4;
            if (!((((_e43 >> _e44) & 1u) == 1u))) {
                uint _e53 = k_4;
                float _e56 = texels_2[_e53].x;
                local_7 = (_e56 > 1e38);
            } else {
                local_7 = true;
            }
            bool _e60 = local_7;
            if (_e60) {
                continue;
            }
            bits_3 = 0u;
            l = 0u;
            bool loop_init_3 = true;
            while(true) {
                if (!loop_init_3) {
                    uint _e99 = l;
                    l = (_e99 + 1u);
                }
                loop_init_3 = false;
                uint _e65 = l;
                if ((_e65 < 4u)) {
                } else {
                    break;
                }
                {
                    uint _e68 = taken;
                    uint _e69 = l;
                    if ((((_e68 >> _e69) & 1u) == 0u)) {
                        uint _e77 = l;
                        float _e80 = texels_2[_e77].x;
                        uint _e81 = k_4;
                        float _e84 = texels_2[_e81].x;
                        float _e89 = _group_0_binding_1_fs.wall;
                        local_8 = (abs((_e80 - _e84)) <= _e89);
                    } else {
                        local_8 = false;
                    }
                    bool _e92 = local_8;
                    if (_e92) {
                        uint _e93 = bits_3;
                        uint _e95 = l;
                        bits_3 = (_e93 | (1u << _e95));
                    }
                }
            }
            uint _e101 = taken;
            uint _e102 = bits_3;
            taken = (_e101 | _e102);
            vec2 _e104[4] = texels_2;
            uint _e105 = bits_3;
            vec4 _e106 = corners_of(map_3, first_2, _e104, _e105);
            float b_1 = (_e106.y - _e106.x);
            float c_1 = (_e106.z - _e106.x);
            float g_1 = (((_e106.x - _e106.y) - _e106.z) + _e106.w);
            float e_1 = (begin.z - (((_e106.x + (b_1 * corner.x)) + (c_1 * corner.y)) + ((g_1 * corner.x) * corner.y)));
            float f_1 = (d.z - (((b_1 * d.x) + (c_1 * d.y)) + (g_1 * ((corner.x * d.y) + (corner.y * d.x)))));
            float _e155 = rising_root(e_1, f_1, ((-(g_1) * d.x) * d.y));
            if ((_e155 >= 0.0)) {
                local_9 = ((start + _e155) <= end);
            } else {
                local_9 = false;
            }
            bool _e163 = local_9;
            if (_e163) {
                float _e167 = nearest;
                local_10 = ((start + _e155) < _e167);
            } else {
                local_10 = false;
            }
            bool _e170 = local_10;
            if (_e170) {
                vec2 _e173[4] = texels_2;
                uint _e174 = bits_3;
                bool _e178 = shows(_e173, _e174, (corner + (d.xy * _e155)));
                local_11 = _e178;
            } else {
                local_11 = false;
            }
            bool _e180 = local_11;
            if (_e180) {
                nearest = (start + _e155);
            }
        }
    }
    float _e185 = nearest;
    return _e185;
}

float search_pyramid(uint map_4, Ray ray_1, float t0_, float t1_) {
    uint level = 0u;
    float t = 0.0;
    uint i = 0u;
    bool local_12 = false;
    bool local_13 = false;
    vec3 o = ray_1.origin;
    vec3 d_1 = ray_1.direction;
    float pace = max(max(abs(d_1.x), abs(d_1.y)), (0.05 * abs(d_1.z)));
    float nudge = (0.0005 / pace);
    float slack = (0.002 / pace);
    uint n = _group_0_binding_1_fs.squares;
    uint top = uint(findLSB(n));
    vec2 begin_1 = (o.xy - vec2(0.5));
    bvec2 still = equal(d_1.xy, vec2(0.0));
    vec2 over = (vec2(1.0) / mix(d_1.xy, vec2(1.0), still));
    ivec2 ahead = ivec2(greaterThan(d_1.xy, vec2(0.0)));
    level = min(2u, top);
    t = min((t0_ + nudge), ((t0_ + t1_) * 0.5));
    bool loop_init_4 = true;
    while(true) {
        if (!loop_init_4) {
            uint _e165 = i;
            i = (_e165 + 1u);
        }
        loop_init_4 = false;
        uint _e55 = i;
        if ((_e55 < (8u * n))) {
            float _e61 = t;
            local_12 = (_e61 < t1_);
        } else {
            local_12 = false;
        }
        bool _e64 = local_12;
        if (_e64) {
        } else {
            break;
        }
        {
            float _e66 = t;
            ivec2 cell = min(max(ivec2((begin_1 + (d_1.xy * _e66))), ivec2(0)), ivec2((int(n) - 1)));
            float _e77 = t;
            float before_2 = max((_e77 - nudge), t0_);
            float enter = (o.z + (d_1.z * before_2));
            while(true) {
                uint _e84 = level;
                ivec2 square = (cell >> uvec2(_e84));
                uint _e88 = level;
                vec2 sides = ((vec2(((square + ahead) << uvec2(_e88))) - begin_1) * over);
                vec2 ends = mix(sides, vec2(t1_), still);
                float _e100 = t;
                float end_3 = max(min(min(ends.x, ends.y), t1_), _e100);
                uint _e102 = level;
                uint m = (n >> _e102);
                uint skipped = ((((n * n) - (m * m)) / 3u) * 4u);
                uint _e115 = _group_0_binding_2_fs[map_4].first;
                vec2 range = _group_0_binding_4_fs[(((_e115 + skipped) + (uint(square.y) * m)) + uint(square.x))];
                float leave = (o.z + (d_1.z * end_3));
                if (!(((max(enter, leave) + 0.002) < range.x))) {
                    local_13 = ((min(enter, leave) - 0.002) > range.y);
                } else {
                    local_13 = true;
                }
                bool _e144 = local_13;
                if (_e144) {
                    t = (end_3 + nudge);
                    uint _e146 = level;
                    level = min((_e146 + 1u), top);
                    break;
                }
                uint _e150 = level;
                if ((_e150 == 0u)) {
                    float _e155 = meet(map_4, cell, ray_1, (before_2 - slack), (end_3 + slack));
                    if ((_e155 < 1e38)) {
                        return _e155;
                    }
                    t = (end_3 + nudge);
                    level = min(1u, top);
                    break;
                }
                uint _e161 = level;
                level = (_e161 - 1u);
            }
        }
    }
    return 3e38;
}

float height(uint map_5, vec2 at_2) {
    vec2 texels_3[4] = vec2[4](vec2(0.0), vec2(0.0), vec2(0.0), vec2(0.0));
    vec4 weights_1 = vec4(0.0);
    float edge_1 = 0.0;
    float own_1 = 3e38;
    float most_1 = -1.0;
    uint k_5 = 0u;
    bool local_14 = false;
    float sum_1 = 0.0;
    float weight = 0.0;
    uint k_6 = 0u;
    vec2 p_2 = (at_2 - vec2(0.5));
    vec2 low = floor(p_2);
    vec2 f_2 = (p_2 - low);
    ivec2 first_3 = ivec2(low);
    vec2 _e8 = texel(map_5, first_3);
    vec2 _e13 = texel(map_5, (first_3 + ivec2(1, 0)));
    vec2 _e18 = texel(map_5, (first_3 + ivec2(0, 1)));
    vec2 _e23 = texel(map_5, (first_3 + ivec2(1, 1)));
    texels_3 = vec2[4](_e8, _e13, _e18, _e23);
    weights_1 = vec4(((1.0 - f_2.x) * (1.0 - f_2.y)), (f_2.x * (1.0 - f_2.y)), ((1.0 - f_2.x) * f_2.y), (f_2.x * f_2.y));
    bool loop_init_5 = true;
    while(true) {
        if (!loop_init_5) {
            uint _e92 = k_5;
            k_5 = (_e92 + 1u);
        }
        loop_init_5 = false;
        uint _e56 = k_5;
        if ((_e56 < 4u)) {
        } else {
            break;
        }
        {
            float _e59 = edge_1;
            uint _e60 = k_5;
            float _e62 = weights_1[_e60];
            uint _e63 = k_5;
            float _e66 = texels_3[_e63].y;
            edge_1 = (_e59 + (_e62 * _e66));
            uint _e69 = k_5;
            float _e72 = texels_3[_e69].x;
            if ((_e72 < 1e38)) {
                uint _e77 = k_5;
                float _e79 = weights_1[_e77];
                float _e80 = most_1;
                local_14 = (_e79 > _e80);
            } else {
                local_14 = false;
            }
            bool _e83 = local_14;
            if (_e83) {
                uint _e84 = k_5;
                float _e87 = texels_3[_e84].x;
                own_1 = _e87;
                uint _e88 = k_5;
                float _e90 = weights_1[_e88];
                most_1 = _e90;
            }
        }
    }
    float _e94 = edge_1;
    if (!((_e94 > 0.0))) {
        return 3e38;
    }
    bool loop_init_6 = true;
    while(true) {
        if (!loop_init_6) {
            uint _e135 = k_6;
            k_6 = (_e135 + 1u);
        }
        loop_init_6 = false;
        uint _e105 = k_6;
        if ((_e105 < 4u)) {
        } else {
            break;
        }
        {
            uint _e108 = k_6;
            float _e111 = texels_3[_e108].x;
            float _e112 = own_1;
            float _e117 = _group_0_binding_1_fs.wall;
            if ((abs((_e111 - _e112)) <= _e117)) {
                float _e119 = sum_1;
                uint _e120 = k_6;
                float _e122 = weights_1[_e120];
                uint _e123 = k_6;
                float _e126 = texels_3[_e123].x;
                sum_1 = (_e119 + (_e122 * _e126));
                float _e129 = weight;
                uint _e130 = k_6;
                float _e132 = weights_1[_e130];
                weight = (_e129 + _e132);
            }
        }
    }
    float _e137 = sum_1;
    float _e138 = weight;
    return (_e137 / _e138);
}

float below(uint map_6, Ray ray_2, float t_1) {
    vec3 p_3 = (ray_2.origin + (ray_2.direction * t_1));
    float _e9 = height(map_6, p_3.xy);
    return (p_3.z - _e9);
}

float search_linear(uint map_7, Ray ray_3, float t0_1, float t1_1) {
    float above = 0.0;
    float under = 3e38;
    uint i_1 = 0u;
    uint i_2 = 0u;
    uint _e7 = _group_0_binding_1_fs.steps;
    float step_ = ((t1_1 - t0_1) / float(_e7));
    above = t0_1;
    bool loop_init_7 = true;
    while(true) {
        if (!loop_init_7) {
            uint _e28 = i_1;
            i_1 = (_e28 + 1u);
        }
        loop_init_7 = false;
        uint _e15 = i_1;
        uint _e18 = _group_0_binding_1_fs.steps;
        if ((_e15 <= _e18)) {
        } else {
            break;
        }
        {
            uint _e20 = i_1;
            float t_2 = (t0_1 + (step_ * float(_e20)));
            float _e24 = below(map_7, ray_3, t_2);
            if ((_e24 >= 0.0)) {
                under = t_2;
                break;
            }
            above = t_2;
        }
    }
    float _e30 = under;
    if ((_e30 > 1e38)) {
        return 3e38;
    }
    bool loop_init_8 = true;
    while(true) {
        if (!loop_init_8) {
            uint _e50 = i_2;
            i_2 = (_e50 + 1u);
        }
        loop_init_8 = false;
        uint _e36 = i_2;
        uint _e39 = _group_0_binding_1_fs.halvings;
        if ((_e36 < _e39)) {
        } else {
            break;
        }
        {
            float _e41 = above;
            float _e42 = under;
            float middle = ((_e41 + _e42) * 0.5);
            float _e46 = below(map_7, ray_3, middle);
            if ((_e46 >= 0.0)) {
                under = middle;
            } else {
                above = middle;
            }
        }
    }
    float _e54 = above;
    vec3 a_2 = (ray_3.origin + (ray_3.direction * _e54));
    float _e59 = under;
    vec3 b_2 = (ray_3.origin + (ray_3.direction * _e59));
    float _e63 = height(map_7, a_2.xy);
    float _e65 = height(map_7, b_2.xy);
    float _e70 = _group_0_binding_1_fs.wall;
    if (!((abs((_e63 - _e65)) <= _e70))) {
        return 3e38;
    }
    float _e74 = under;
    return _e74;
}

float trace(uint map_8, Ray ray_4, float start_1, float end_1) {
    vec4 window = _group_0_binding_2_fs[map_8].window;
    vec3 low_1 = vec3(window.xy, 0.0);
    float _e15 = _group_0_binding_2_fs[map_8].deep;
    vec3 high = vec3(window.zw, _e15);
    bvec3 still_1 = equal(ray_4.direction, vec3(0.0));
    if (any(bvec3(still_1.x && bvec3(lessThan(ray_4.origin, low_1).x || greaterThan(ray_4.origin, high).x, lessThan(ray_4.origin, low_1).y || greaterThan(ray_4.origin, high).y, lessThan(ray_4.origin, low_1).z || greaterThan(ray_4.origin, high).z).x, still_1.y && bvec3(lessThan(ray_4.origin, low_1).x || greaterThan(ray_4.origin, high).x, lessThan(ray_4.origin, low_1).y || greaterThan(ray_4.origin, high).y, lessThan(ray_4.origin, low_1).z || greaterThan(ray_4.origin, high).z).y, still_1.z && bvec3(lessThan(ray_4.origin, low_1).x || greaterThan(ray_4.origin, high).x, lessThan(ray_4.origin, low_1).y || greaterThan(ray_4.origin, high).y, lessThan(ray_4.origin, low_1).z || greaterThan(ray_4.origin, high).z).z))) {
        return 3e38;
    }
    vec3 over_1 = (vec3(1.0) / mix(ray_4.direction, vec3(1.0), still_1));
    vec3 a_3 = mix(((low_1 - ray_4.origin) * over_1), vec3(start_1), still_1);
    vec3 b_3 = mix(((high - ray_4.origin) * over_1), vec3(end_1), still_1);
    vec3 first_4 = min(a_3, b_3);
    vec3 last_1 = max(a_3, b_3);
    float t0_2 = max(max(first_4.x, first_4.y), max(first_4.z, start_1));
    float t1_2 = min(min(last_1.x, last_1.y), min(last_1.z, end_1));
    if (!((t0_2 <= t1_2))) {
        return 3e38;
    }
    uint _e65 = _group_0_binding_1_fs.steps;
    if ((_e65 > 0u)) {
        float _e68 = search_linear(map_8, ray_4, t0_2, t1_2);
        return _e68;
    }
    float _e69 = search_pyramid(map_8, ray_4, t0_2, t1_2);
    return _e69;
}

float slope(float before, float at_3, float after) {
    bool local_15 = false;
    float _e7 = _group_0_binding_1_fs.wall;
    bool has_before = (abs((before - at_3)) <= _e7);
    float _e13 = _group_0_binding_1_fs.wall;
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

float squareness(uint map_9, vec3 p) {
    vec2 u = vec2(0.5, 0.0);
    vec2 v_2 = vec2(0.0, 0.5);
    float _e10 = height(map_9, (p.xy - u));
    float _e14 = height(map_9, (p.xy + u));
    float _e15 = slope(_e10, p.z, _e14);
    float _e18 = height(map_9, (p.xy - v_2));
    float _e22 = height(map_9, (p.xy + v_2));
    float _e23 = slope(_e18, p.z, _e22);
    return (1.0 / sqrt((((_e15 * _e15) + (_e23 * _e23)) + 1.0)));
}

Ray map_ray(uint map_10, Ray ray_5) {
    vec4 r[3] = _group_0_binding_2_fs[map_10].rows;
    vec4 o_1 = vec4(ray_5.origin, 1.0);
    return Ray(vec3(dot(r[0], o_1), dot(r[1], o_1), dot(r[2], o_1)), vec3(dot(r[0].xyz, ray_5.direction), dot(r[1].xyz, ray_5.direction), dot(r[2].xyz, ray_5.direction)));
}

uint map_of(uint instance, uint k_7) {
    uint pair = _group_0_binding_3_fs[instance].maps[(k_7 >> 1u)];
    return (((k_7 & 1u) == 1u) ? (pair >> 16u) : (pair & 65535u));
}

Seen see(uint instance_1, Ray ray_6, float start_2, float end_2) {
    float found[8] = float[8](0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    float nearest_1 = 3e38;
    Seen best = Seen(65535u, 3e38);
    float least = 3e38;
    uint k_8 = 0u;
    float rank = 0.0;
    bool local_16 = false;
    uint k_9 = 0u;
    bool local_17 = false;
    bool loop_init_9 = true;
    while(true) {
        if (!loop_init_9) {
            uint _e76 = k_8;
            k_8 = (_e76 + 1u);
        }
        loop_init_9 = false;
        uint _e15 = k_8;
        if ((_e15 < MAPS)) {
        } else {
            break;
        }
        {
            uint _e18 = k_8;
            found[_e18] = 3e38;
            uint _e21 = k_8;
            uint _e22 = map_of(instance_1, _e21);
            if ((_e22 == NO_MAP)) {
                continue;
            }
            Ray _e25 = map_ray(_e22, ray_6);
            float _e26 = trace(_e22, _e25, start_2, end_2);
            if ((_e26 > 1e38)) {
                continue;
            }
            uint _e29 = k_8;
            found[_e29] = _e26;
            float _e31 = nearest_1;
            nearest_1 = min(_e31, _e26);
            rank = _e26;
            uint _e36 = _group_0_binding_1_fs.strategy;
            switch(_e36) {
                case 1u: {
                    rank = ((_e25.direction.z == 0.0) ? 1e38 : (-(_e25.origin.z) / _e25.direction.z));
                    break;
                }
                case 4u: {
                    float _e53 = squareness(_e22, (_e25.origin + (_e25.direction * _e26)));
                    rank = -(_e53);
                    break;
                }
                case 5u: {
                    Map m_1 = _group_0_binding_2_fs[_e22];
                    float _e67 = squareness(_e22, (_e25.origin + (_e25.direction * _e26)));
                    rank = (_e26 - ((0.03125 * (m_1.deep * m_1.texel)) * _e67));
                    break;
                }
                default: {
                    break;
                }
            }
            float _e70 = rank;
            float _e71 = least;
            if ((_e70 < _e71)) {
                best = Seen(_e22, _e26);
                float _e74 = rank;
                least = _e74;
            }
        }
    }
    uint _e80 = _group_0_binding_1_fs.strategy;
    if ((_e80 == 3u)) {
        uint _e86 = best.map;
        local_16 = (_e86 != NO_MAP);
    } else {
        local_16 = false;
    }
    bool _e90 = local_16;
    if (_e90) {
        bool loop_init_10 = true;
        while(true) {
            if (!loop_init_10) {
                uint _e127 = k_9;
                k_9 = (_e127 + 1u);
            }
            loop_init_10 = false;
            uint _e93 = k_9;
            if ((_e93 < MAPS)) {
            } else {
                break;
            }
            {
                uint _e96 = k_9;
                uint _e97 = map_of(instance_1, _e96);
                uint _e98 = k_9;
                float _e100 = found[_e98];
                if ((_e100 < 1e38)) {
                    uint _e105 = k_9;
                    float _e107 = found[_e105];
                    float _e108 = nearest_1;
                    float _e111 = _group_0_binding_1_fs.wall;
                    float _e115 = _group_0_binding_2_fs[_e97].texel;
                    local_17 = !((_e107 > (_e108 + (_e111 * _e115))));
                } else {
                    local_17 = false;
                }
                bool _e121 = local_17;
                if (_e121) {
                    uint _e122 = k_9;
                    float _e124 = found[_e122];
                    return Seen(_e97, _e124);
                }
            }
        }
    }
    Seen _e129 = best;
    return _e129;
}

vec3 lit(vec3 base, vec3 normal, vec3 position) {
    vec3 out_1 = vec3(0.0);
    bool local_18 = false;
    vec4 _e5 = _group_0_binding_0_fs.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    vec4 _e12 = _group_0_binding_0_fs.ground;
    vec4 _e16 = _group_0_binding_0_fs.sky;
    vec3 ambient = mix(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    vec4 _e26 = _group_0_binding_0_fs.sun;
    out_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = _group_0_binding_0_fs.sun.w;
    if ((_e35 > 0.0)) {
        local_18 = (sun > 0.0);
    } else {
        local_18 = false;
    }
    bool _e43 = local_18;
    if (_e43) {
        vec4 _e46 = _group_0_binding_0_fs.eye;
        float _e51 = _group_0_binding_0_fs.eye.w;
        vec3 to_eye = normalize((_e46.xyz - (position * _e51)));
        vec4 _e57 = _group_0_binding_0_fs.to_sun;
        vec3 h = normalize((_e57.xyz + to_eye));
        vec3 _e61 = out_1;
        vec4 _e64 = _group_0_binding_0_fs.sun;
        float _e69 = _group_0_binding_0_fs.sun.w;
        float _e76 = _group_0_binding_0_fs.to_sun.w;
        out_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal, h), 0.0), _e76)) * sun)));
    }
    vec3 _e82 = out_1;
    return _e82;
}

vec3 shade(Seen seen, Instance instance_2, vec3 local_19, vec3 position_1, float depth_1) {
    Map map_11 = _group_0_binding_2_fs[seen.map];
    vec4 p_4 = vec4(local_19, 1.0);
    uint _e20 = _group_0_binding_1_fs.side;
    vec2 uv = (vec2(dot(map_11.rows[0], p_4), dot(map_11.rows[1], p_4)) / vec2(float(_e20)));
    float _e26 = _group_0_binding_0_fs.sample_size;
    float _e30 = _group_0_binding_0_fs.eye.w;
    float sample_ = ((_e26 * ((_e30 > 0.0) ? depth_1 : 1.0)) / (map_11.texel * instance_2.place.w));
    uint _e46 = _group_0_binding_1_fs.levels;
    float level_1 = clamp(log2(max(sample_, 1.0)), 0.0, float((_e46 - 1u)));
    vec4 _e55 = textureLod(_group_0_binding_6_fs, vec3(uv, seen.map), level_1);
    vec3 base_1 = _e55.xyz;
    uint _e59 = _group_0_binding_0_fs.shading;
    if ((_e59 == 0u)) {
        return base_1;
    }
    vec4 _e65 = textureLod(_group_0_binding_7_fs, vec3(uv, seen.map), level_1);
    vec2 bent = (((_e65.xy * 255.0) - vec2(127.0)) / vec2(127.0));
    float out_2 = sqrt(max((1.0 - dot(bent, bent)), 0.0));
    vec3 normal_1 = normalize((((map_11.rows[0].xyz * bent.x) - (map_11.rows[1].xyz * bent.y)) - (map_11.rows[2].xyz * out_2)));
    vec4 _e101 = textureLod(_group_0_binding_8_fs, vec3(uv, seen.map), level_1);
    uint _e105 = _group_0_binding_1_fs.emits;
    vec3 glow = (_e101.xyz * float(_e105));
    vec3 _e109 = turned(normal_1, instance_2.rotation);
    vec3 _e110 = lit(base_1, _e109, position_1);
    return (_e110 + glow);
}

void main() {
    Proxy in_ = Proxy(gl_FragCoord, _vs2fs_location0, _vs2fs_location1);
    vec3 direction = vec3(0.0);
    Instance instance_3 = _group_0_binding_3_fs[in_.instance];
    float scale = instance_3.place.w;
    vec4 _e9 = _group_0_binding_0_fs.depth;
    vec3 _e12 = turned_back(_e9.xyz, instance_3.rotation);
    vec4 _e15 = _group_0_binding_0_fs.eye;
    float _e22 = _group_0_binding_0_fs.eye.w;
    vec3 _e26 = turned_back((_e15.xyz - (instance_3.place.xyz * _e22)), instance_3.rotation);
    vec4 _e32 = _group_0_binding_1_fs.centre;
    vec3 from_eye = (in_.position - ((_e26 / vec3(scale)) - _e32.xyz));
    float _e40 = _group_0_binding_0_fs.eye.w;
    direction = ((_e40 > 0.0) ? from_eye : -(_e26));
    vec3 _e45 = direction;
    vec3 _e46 = direction;
    direction = (_e45 / vec3(dot(_e12, _e46)));
    vec3 _e51 = direction;
    vec3 _e56 = direction;
    Ray ray_7 = Ray((in_.position - (_e51 * dot(_e12, in_.position))), _e56);
    vec4 _e62 = _group_0_binding_1_fs.centre;
    vec3 _e65 = turned(_e62.xyz, instance_3.rotation);
    vec3 centre = (instance_3.place.xyz + (_e65 * scale));
    vec4 _e70 = _group_0_binding_0_fs.depth;
    float middle_1 = (dot(_e70, vec4(centre, 1.0)) / scale);
    float _e78 = _group_0_binding_0_fs.near;
    float _e83 = _group_0_binding_0_fs.far;
    Seen _e86 = see(in_.instance, ray_7, ((_e78 / scale) - middle_1), ((_e83 / scale) - middle_1));
    if ((_e86.map == NO_MAP)) {
        discard;
    }
    vec4 _e97 = _group_0_binding_1_fs.centre;
    vec3 local_20 = ((ray_7.origin + (ray_7.direction * _e86.t)) + _e97.xyz);
    vec3 _e103 = turned(local_20, instance_3.rotation);
    vec3 position_2 = (instance_3.place.xyz + (_e103 * scale));
    mat4x4 _e108 = _group_0_binding_0_fs.clip;
    vec4 clip_1 = (_e108 * vec4(position_2, 1.0));
    float depth_2 = ((middle_1 + _e86.t) * scale);
    vec4 _e117 = _group_0_binding_1_fs.centre;
    vec3 _e120 = shade(_e86, instance_3, (local_20 - _e117.xyz), position_2, depth_2);
    Fragment _tmp_return = Fragment(vec4(_e120, 1.0), (clip_1.z / clip_1.w));
    _fs2p_location0 = _tmp_return.color;
    gl_FragDepth = _tmp_return.depth;
    return;
}

