#version 450 core
#extension GL_ARB_compute_shader : require
#extension GL_ARB_shader_storage_buffer_object : require
layout(local_size_x = 64, local_size_y = 1, local_size_z = 1) in;

struct Sprite {
    vec4 world_to_texture[3];
    uvec4 region;
    uvec4 sections;
    uvec2 size;
    uint packing;
    uint depth_complexity;
    uint depth_base;
    float depth_step;
};
const uint SPRITE_OUTSIDE = 0u;
const uint SPRITE_BORDER = 1u;
const uint SPRITE_INSIDE = 2u;

layout(std430) readonly buffer type_6_block_0Compute { Sprite _group_0_binding_0_cs[]; };

layout(std430) readonly buffer type_7_block_1Compute { uint _group_0_binding_1_cs[]; };

layout(std430) readonly buffer type_12_block_2Compute { vec4 _group_0_binding_2_cs[]; };

layout(std430) buffer type_14_block_3Compute { uint _group_0_binding_3_cs[]; };


vec3 sprite_texture(uint i, vec3 world) {
    vec4 p_2 = vec4(world, 1.0);
    vec4 _e8 = _group_0_binding_0_cs[i].world_to_texture[0];
    vec4 _e14 = _group_0_binding_0_cs[i].world_to_texture[1];
    vec4 _e20 = _group_0_binding_0_cs[i].world_to_texture[2];
    return vec3(dot(_e8, p_2), dot(_e14, p_2), dot(_e20, p_2));
}

uint prefix(uint section, uint texel) {
    uint _e7 = _group_0_binding_1_cs[(section + (texel / 2u))];
    return ((_e7 >> (16u * (texel % 2u))) & 65535u);
}

uint words_of_range(uint i_1) {
    float _e6 = _group_0_binding_0_cs[i_1].depth_step;
    return ((_e6 == 0.0) ? 2u : 1u);
}

uvec2 in_runs(uint i_2, uvec2 p) {
    uint low = 0u;
    uint high = 0u;
    uvec4 sections = _group_0_binding_0_cs[i_2].sections;
    uint _e11 = _group_0_binding_1_cs[(sections.x + p.y)];
    low = _e11;
    uint begin = low;
    uint _e21 = _group_0_binding_1_cs[((sections.x + p.y) + 1u)];
    high = _e21;
    while(true) {
        uint _e23 = low;
        uint _e24 = high;
        if ((_e23 < _e24)) {
        } else {
            break;
        }
        {
            uint _e26 = low;
            uint _e27 = high;
            uint middle = ((_e26 + _e27) / 2u);
            uint _e37 = _group_0_binding_1_cs[(sections.y + (3u * middle))];
            if (((_e37 & 65535u) <= p.x)) {
                low = (middle + 1u);
            } else {
                high = middle;
            }
        }
    }
    uint _e44 = low;
    if ((_e44 == begin)) {
        return uvec2(0u);
    }
    uint _e50 = low;
    uint run = (sections.y + (3u * (_e50 - 1u)));
    uint place = _group_0_binding_1_cs[run];
    uint along = (p.x - (place & 65535u));
    if ((along >= (place >> 16u))) {
        return uvec2(0u);
    }
    uint count_1 = _group_0_binding_1_cs[(run + 1u)];
    uint _e73 = words_of_range(i_2);
    uint _e78 = _group_0_binding_1_cs[(run + 2u)];
    return uvec2((sections.z + (_e73 * (_e78 + (along * count_1)))), count_1);
}

uvec2 sprite_ranges(uint i_3, uvec2 p_1) {
    uint end = 0u;
    uvec4 sections_1 = _group_0_binding_0_cs[i_3].sections;
    uint width = _group_0_binding_0_cs[i_3].region.z;
    uint texel_2 = ((p_1.y * width) + p_1.x);
    uint _e18 = _group_0_binding_0_cs[i_3].packing;
    switch(_e18) {
        case 0u: {
            uint _e24 = _group_0_binding_0_cs[i_3].depth_complexity;
            return uvec2((sections_1.x + texel_2), (_e24 / 2u));
        }
        case 1u: {
            uint at = (sections_1.x + (2u * texel_2));
            uint _e36 = _group_0_binding_1_cs[at];
            uint _e43 = _group_0_binding_1_cs[(at + 1u)];
            return uvec2((sections_1.x + (2u * _e36)), _e43);
        }
        case 2u: {
            uint before = _group_0_binding_1_cs[(sections_1.x + p_1.y)];
            uint _e52 = prefix(sections_1.y, texel_2);
            uint first_1 = (before + _e52);
            uint _e61 = _group_0_binding_1_cs[((sections_1.x + p_1.y) + 1u)];
            end = _e61;
            if (((p_1.x + 1u) < width)) {
                uint _e70 = prefix(sections_1.y, (texel_2 + 1u));
                end = (before + _e70);
            }
            uint _e73 = words_of_range(i_3);
            uint _e76 = end;
            return uvec2((sections_1.z + (_e73 * first_1)), (_e76 - first_1));
        }
        default: {
            uvec2 _e79 = in_runs(i_3, p_1);
            return _e79;
        }
    }
}

vec2 sprite_range(uint i_4, uint first, uint k) {
    bool local_1 = false;
    uint _e6 = _group_0_binding_0_cs[i_4].packing;
    if ((_e6 == 0u)) {
        uint _e13 = _group_0_binding_0_cs[i_4].region.z;
        uint _e18 = _group_0_binding_0_cs[i_4].region.w;
        uint n_1 = (_e13 * _e18);
        uint at_1 = (first + ((2u * k) * n_1));
        uint _e26 = _group_0_binding_1_cs[at_1];
        uint _e31 = _group_0_binding_1_cs[(at_1 + n_1)];
        return vec2(uintBitsToFloat(_e26), uintBitsToFloat(_e31));
    }
    uint _e37 = _group_0_binding_0_cs[i_4].packing;
    if ((_e37 > 1u)) {
        float _e45 = _group_0_binding_0_cs[i_4].depth_step;
        local_1 = (_e45 > 0.0);
    } else {
        local_1 = false;
    }
    bool _e49 = local_1;
    if (_e49) {
        uint word = _group_0_binding_1_cs[(first + k)];
        uint _e62 = _group_0_binding_0_cs[i_4].depth_base;
        uvec2 steps = (uvec2((word & 65535u), (word >> 16u)) + uvec2(_e62));
        float _e69 = _group_0_binding_0_cs[i_4].depth_step;
        return (vec2(steps) * _e69);
    }
    uint at_2 = (first + (2u * k));
    uint _e76 = _group_0_binding_1_cs[at_2];
    uint _e82 = _group_0_binding_1_cs[(at_2 + 1u)];
    return vec2(uintBitsToFloat(_e76), uintBitsToFloat(_e82));
}

bool sprite_contains(uint i_5, vec3 point) {
    bool local_2 = false;
    bool local_3 = false;
    bool local_4 = false;
    uint k_1 = 0u;
    bool local_5 = false;
    if ((point.x >= 0.0)) {
        local_2 = (point.x < 1.0);
    } else {
        local_2 = false;
    }
    bool _e11 = local_2;
    if (_e11) {
        local_3 = (point.y >= 0.0);
    } else {
        local_3 = false;
    }
    bool _e18 = local_3;
    if (_e18) {
        local_4 = (point.y < 1.0);
    } else {
        local_4 = false;
    }
    bool _e25 = local_4;
    if (!(_e25)) {
        return false;
    }
    uvec2 _e32 = _group_0_binding_0_cs[i_5].size;
    uvec2 texel_3 = uvec2((point.xy * vec2(_e32)));
    uvec4 _e39 = _group_0_binding_0_cs[i_5].region;
    if (any(lessThan(texel_3, _e39.xy))) {
        return false;
    }
    uvec4 _e47 = _group_0_binding_0_cs[i_5].region;
    uvec2 p_3 = (texel_3 - _e47.xy);
    uvec4 _e53 = _group_0_binding_0_cs[i_5].region;
    if (any(greaterThanEqual(p_3, _e53.zw))) {
        return false;
    }
    uvec2 _e58 = sprite_ranges(i_5, p_3);
    bool loop_init = true;
    while(true) {
        if (!loop_init) {
            uint _e84 = k_1;
            k_1 = (_e84 + 1u);
        }
        loop_init = false;
        uint _e61 = k_1;
        if ((_e61 < _e58.y)) {
        } else {
            break;
        }
        {
            uint _e65 = k_1;
            vec2 _e66 = sprite_range(i_5, _e58.x, _e65);
            if (!((_e66.x > point.z))) {
                local_5 = (_e66.x == 1.0);
            } else {
                local_5 = true;
            }
            bool _e77 = local_5;
            if (_e77) {
                return false;
            }
            if ((point.z <= _e66.y)) {
                return true;
            }
        }
    }
    return false;
}

uint sprite_zone(uint i_6, vec3 world_1, float half_) {
    uint count = 0u;
    uint k_2 = 0u;
    bool loop_init_1 = true;
    while(true) {
        if (!loop_init_1) {
            uint _e38 = k_2;
            k_2 = (_e38 + 1u);
        }
        loop_init_1 = false;
        uint _e7 = k_2;
        if ((_e7 < 8u)) {
        } else {
            break;
        }
        {
            uint _e10 = k_2;
            uint _e14 = k_2;
            uint _e20 = k_2;
            vec3 corner = ((vec3(float((_e10 & 1u)), float(((_e14 >> 1u) & 1u)), float((_e20 >> 2u))) * 2.0) - vec3(1.0));
            uint _e30 = count;
            vec3 _e33 = sprite_texture(i_6, (world_1 + (corner * half_)));
            bool _e34 = sprite_contains(i_6, _e33);
            count = (_e30 + uint(_e34));
        }
    }
    uint _e40 = count;
    if ((_e40 == 0u)) {
        return SPRITE_OUTSIDE;
    }
    uint _e46 = count;
    return ((_e46 == 8u) ? SPRITE_INSIDE : SPRITE_BORDER);
}

vec2 sprite_enter(uint i_7, vec3 origin, vec3 direction) {
    float t = 0.0;
    float last = 3.4e38;
    uint k_3 = 0u;
    bool local_6 = false;
    ivec2 texel_1 = ivec2(0);
    vec2 found = vec2(0.0);
    bool touched = false;
    uint n = 0u;
    vec2 part = vec2(0.0);
    bool local_7 = false;
    bool local_8 = false;
    bool local_9 = false;
    bool local_10 = false;
    bool local_11 = false;
    vec2 none = vec2(1.0, 0.0);
    uvec2 _e9 = _group_0_binding_0_cs[i_7].size;
    vec3 size = vec3(vec2(_e9), 1.0);
    uvec4 _e16 = _group_0_binding_0_cs[i_7].region;
    vec3 end_1 = vec3(vec2(_e16.zw), 1.0);
    vec3 _e21 = sprite_texture(i_7, origin);
    uvec4 _e26 = _group_0_binding_0_cs[i_7].region;
    vec3 o = ((_e21 * size) - vec3(vec2(_e26.xy), 0.0));
    vec3 _e33 = sprite_texture(i_7, (origin + direction));
    vec3 _e34 = sprite_texture(i_7, origin);
    vec3 d = ((_e33 - _e34) * size);
    bool loop_init_2 = true;
    while(true) {
        if (!loop_init_2) {
            uint _e85 = k_3;
            k_3 = (_e85 + 1u);
        }
        loop_init_2 = false;
        uint _e43 = k_3;
        if ((_e43 < 3u)) {
        } else {
            break;
        }
        {
            uint _e46 = k_3;
            if ((d[_e46] == 0.0)) {
                uint _e50 = k_3;
                if ((o[_e50] >= 0.0)) {
                    uint _e56 = k_3;
                    uint _e58 = k_3;
                    local_6 = (o[_e56] < end_1[_e58]);
                } else {
                    local_6 = false;
                }
                bool _e62 = local_6;
                if (!(_e62)) {
                    return none;
                }
            } else {
                uint _e64 = k_3;
                uint _e67 = k_3;
                float a = (-(o[_e64]) / d[_e67]);
                uint _e70 = k_3;
                uint _e72 = k_3;
                uint _e75 = k_3;
                float b = ((end_1[_e70] - o[_e72]) / d[_e75]);
                float _e78 = t;
                t = max(_e78, min(a, b));
                float _e81 = last;
                last = min(_e81, max(a, b));
            }
        }
    }
    uvec4 _e90 = _group_0_binding_0_cs[i_7].region;
    ivec2 limit = ivec2(_e90.zw);
    float _e95 = t;
    texel_1 = min(max(ivec2(floor((o.xy + (d.xy * _e95)))), ivec2(0)), (limit - ivec2(1)));
    ivec2 step_ = ivec2(sign(d.xy));
    found = none;
    while(true) {
        float _e111 = t;
        float _e112 = last;
        if ((_e111 < _e112)) {
        } else {
            break;
        }
        {
            ivec2 _e114 = texel_1;
            vec2 border = vec2((_e114 + max(step_, ivec2(0))));
            vec2 next = mix(((border - o.xy) / d.xy), vec2(3.4e38), equal(step_, ivec2(0)));
            float _e133 = last;
            float until = min(min(next.x, next.y), _e133);
            float _e135 = t;
            if ((_e135 < until)) {
                ivec2 _e137 = texel_1;
                uvec2 _e139 = sprite_ranges(i_7, uvec2(_e137));
                touched = false;
                n = 0u;
                bool loop_init_3 = true;
                while(true) {
                    if (!loop_init_3) {
                        uint _e228 = n;
                        n = (_e228 + 1u);
                    }
                    loop_init_3 = false;
                    uint _e144 = n;
                    if ((_e144 < _e139.y)) {
                    } else {
                        break;
                    }
                    {
                        uint _e147 = n;
                        uint _e151 = n;
                        uint k_4 = ((d.z < 0.0) ? ((_e139.y - 1u) - _e151) : _e147);
                        vec2 _e158 = sprite_range(i_7, _e139.x, k_4);
                        float _e159 = t;
                        part = vec2(_e159, until);
                        if ((d.z == 0.0)) {
                            vec2 _e165 = part;
                            if ((_e158.x <= o.z)) {
                                local_7 = (o.z <= _e158.y);
                            } else {
                                local_7 = false;
                            }
                            bool _e175 = local_7;
                            part = (_e175 ? _e165 : none);
                        } else {
                            vec2 at_3 = ((_e158 - vec2(o.z)) / vec2(d.z));
                            float _e183 = t;
                            part = vec2(max(_e183, min(at_3.x, at_3.y)), min(until, max(at_3.x, at_3.y)));
                        }
                        if (!((_e158.x == 1.0))) {
                            float _e200 = part.x;
                            float _e202 = part.y;
                            local_8 = (_e200 >= _e202);
                        } else {
                            local_8 = true;
                        }
                        bool _e205 = local_8;
                        if (_e205) {
                            continue;
                        }
                        float _e207 = found.x;
                        float _e209 = found.y;
                        if ((_e207 > _e209)) {
                            vec2 _e211 = part;
                            found = _e211;
                        } else {
                            float _e213 = part.x;
                            float _e215 = found.y;
                            if ((_e213 <= _e215)) {
                                float _e219 = found.y;
                                float _e221 = part.y;
                                found.y = max(_e219, _e221);
                            } else {
                                vec2 _e223 = found;
                                return _e223;
                            }
                        }
                        float _e225 = found.y;
                        touched = (_e225 >= until);
                    }
                }
                float _e231 = found.x;
                float _e233 = found.y;
                if ((_e231 <= _e233)) {
                    bool _e237 = touched;
                    local_9 = !(_e237);
                } else {
                    local_9 = false;
                }
                bool _e240 = local_9;
                if (_e240) {
                    vec2 _e241 = found;
                    return _e241;
                }
                t = until;
            }
            uint along_1 = uint((next.y < next.x));
            int _e247 = texel_1[along_1];
            texel_1[along_1] = (_e247 + step_[along_1]);
            if (!((step_[along_1] == 0))) {
                int _e257 = texel_1[along_1];
                local_10 = (_e257 < 0);
            } else {
                local_10 = true;
            }
            bool _e261 = local_10;
            if (!(_e261)) {
                int _e266 = texel_1[along_1];
                local_11 = (_e266 >= limit[along_1]);
            } else {
                local_11 = true;
            }
            bool _e270 = local_11;
            if (_e270) {
                break;
            }
        }
    }
    vec2 _e271 = found;
    return _e271;
}

void main() {
    uvec3 id = gl_GlobalInvocationID;
    uvec3 groups = gl_NumWorkGroups;
    bool local = false;
    uint i_8 = (((id.y * groups.x) * 64u) + id.x);
    if ((i_8 < uint(_group_0_binding_2_cs.length()))) {
        vec4 _e17 = _group_0_binding_2_cs[i_8];
        bool _e19 = sprite_contains(0u, _e17.xyz);
        local = _e19;
    } else {
        local = false;
    }
    bool _e21 = local;
    if (_e21) {
        uint _e30 = atomicOr(_group_0_binding_3_cs[(i_8 / 32u)], (1u << (i_8 % 32u)));
        return;
    } else {
        return;
    }
}

