// language: metal2.0
#include <metal_stdlib>
#include <simd/simd.h>

using metal::uint;

struct _mslBufferSizes {
    uint size0;
    uint size1;
    uint size2;
    uint size3;
};

struct type_2 {
    metal::float4 inner[3];
};
struct Sprite {
    type_2 world_to_texture;
    metal::uint4 region;
    metal::uint4 sections;
    metal::uint2 size;
    uint packing;
    uint depth_complexity;
    uint depth_base;
    float depth_step;
    char _pad8[8];
};
typedef Sprite type_6[1];
typedef uint type_7[1];
typedef metal::float4 type_12[1];
typedef metal::atomic_uint type_14[1];
constant uint SPRITE_OUTSIDE = 0u;
constant uint SPRITE_BORDER = 1u;
constant uint SPRITE_INSIDE = 2u;

metal::float3 sprite_texture(
    uint i,
    metal::float3 world,
    device type_6 const& sprites,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float4 p_2 = metal::float4(world, 1.0);
    metal::float4 _e8 = sprites[i].world_to_texture.inner[0];
    metal::float4 _e14 = sprites[i].world_to_texture.inner[1];
    metal::float4 _e20 = sprites[i].world_to_texture.inner[2];
    return metal::float3(metal::dot(_e8, p_2), metal::dot(_e14, p_2), metal::dot(_e20, p_2));
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / metal::select(rhs, 1u, rhs == 0u);
}

uint naga_mod(uint lhs, uint rhs) {
    return lhs % metal::select(rhs, 1u, rhs == 0u);
}

uint prefix(
    uint section,
    uint texel,
    device type_7 const& sprite_data,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint _e7 = sprite_data[section + naga_div(texel, 2u)];
    return (_e7 >> (16u * naga_mod(texel, 2u))) & 65535u;
}

uint words_of_range(
    uint i_1,
    device type_6 const& sprites,
    constant _mslBufferSizes& _buffer_sizes
) {
    float _e6 = sprites[i_1].depth_step;
    return (_e6 == 0.0) ? 2u : 1u;
}

metal::uint2 in_runs(
    uint i_2,
    metal::uint2 p,
    device type_6 const& sprites,
    device type_7 const& sprite_data,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint low = {};
    uint high = {};
    metal::uint4 sections = sprites[i_2].sections;
    uint _e11 = sprite_data[sections.x + p.y];
    low = _e11;
    uint begin = low;
    uint _e21 = sprite_data[(sections.x + p.y) + 1u];
    high = _e21;
    uint2 loop_bound = uint2(4294967295u);
    while(true) {
        if (metal::all(loop_bound == uint2(0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        uint _e23 = low;
        uint _e24 = high;
        if (_e23 < _e24) {
        } else {
            break;
        }
        {
            uint _e26 = low;
            uint _e27 = high;
            uint middle = naga_div(_e26 + _e27, 2u);
            uint _e37 = sprite_data[sections.y + (3u * middle)];
            if ((_e37 & 65535u) <= p.x) {
                low = middle + 1u;
            } else {
                high = middle;
            }
        }
    }
    uint _e44 = low;
    if (_e44 == begin) {
        return metal::uint2(0u);
    }
    uint _e50 = low;
    uint run = sections.y + (3u * (_e50 - 1u));
    uint place = sprite_data[run];
    uint along = p.x - (place & 65535u);
    if (along >= (place >> 16u)) {
        return metal::uint2(0u);
    }
    uint count_1 = sprite_data[run + 1u];
    uint _e73 = words_of_range(i_2, sprites, _buffer_sizes);
    uint _e78 = sprite_data[run + 2u];
    return metal::uint2(sections.z + (_e73 * (_e78 + (along * count_1))), count_1);
}

metal::uint2 sprite_ranges(
    uint i_3,
    metal::uint2 p_1,
    device type_6 const& sprites,
    device type_7 const& sprite_data,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint end = {};
    metal::uint4 sections_1 = sprites[i_3].sections;
    uint width = sprites[i_3].region.z;
    uint texel_2 = (p_1.y * width) + p_1.x;
    uint _e18 = sprites[i_3].packing;
    switch(_e18) {
        case 0u: {
            uint _e24 = sprites[i_3].depth_complexity;
            return metal::uint2(sections_1.x + texel_2, naga_div(_e24, 2u));
        }
        case 1u: {
            uint at = sections_1.x + (2u * texel_2);
            uint _e36 = sprite_data[at];
            uint _e43 = sprite_data[at + 1u];
            return metal::uint2(sections_1.x + (2u * _e36), _e43);
        }
        case 2u: {
            uint before = sprite_data[sections_1.x + p_1.y];
            uint _e52 = prefix(sections_1.y, texel_2, sprite_data, _buffer_sizes);
            uint first_1 = before + _e52;
            uint _e61 = sprite_data[(sections_1.x + p_1.y) + 1u];
            end = _e61;
            if ((p_1.x + 1u) < width) {
                uint _e70 = prefix(sections_1.y, texel_2 + 1u, sprite_data, _buffer_sizes);
                end = before + _e70;
            }
            uint _e73 = words_of_range(i_3, sprites, _buffer_sizes);
            uint _e76 = end;
            return metal::uint2(sections_1.z + (_e73 * first_1), _e76 - first_1);
        }
        default: {
            metal::uint2 _e79 = in_runs(i_3, p_1, sprites, sprite_data, _buffer_sizes);
            return _e79;
        }
    }
}

metal::float2 sprite_range(
    uint i_4,
    uint first,
    uint k,
    device type_6 const& sprites,
    device type_7 const& sprite_data,
    constant _mslBufferSizes& _buffer_sizes
) {
    bool local_1 = {};
    uint _e6 = sprites[i_4].packing;
    if (_e6 == 0u) {
        uint _e13 = sprites[i_4].region.z;
        uint _e18 = sprites[i_4].region.w;
        uint n_1 = _e13 * _e18;
        uint at_1 = first + ((2u * k) * n_1);
        uint _e26 = sprite_data[at_1];
        uint _e31 = sprite_data[at_1 + n_1];
        return metal::float2(as_type<float>(_e26), as_type<float>(_e31));
    }
    uint _e37 = sprites[i_4].packing;
    if (_e37 > 1u) {
        float _e45 = sprites[i_4].depth_step;
        local_1 = _e45 > 0.0;
    } else {
        local_1 = false;
    }
    bool _e49 = local_1;
    if (_e49) {
        uint word = sprite_data[first + k];
        uint _e62 = sprites[i_4].depth_base;
        metal::uint2 steps = metal::uint2(word & 65535u, word >> 16u) + metal::uint2(_e62);
        float _e69 = sprites[i_4].depth_step;
        return static_cast<metal::float2>(steps) * _e69;
    }
    uint at_2 = first + (2u * k);
    uint _e76 = sprite_data[at_2];
    uint _e82 = sprite_data[at_2 + 1u];
    return metal::float2(as_type<float>(_e76), as_type<float>(_e82));
}

metal::uint2 naga_f2u32(metal::float2 value) {
    return static_cast<metal::uint2>(metal::clamp(value, 0.0, 4294967000.0));
}

bool sprite_contains(
    uint i_5,
    metal::float3 point,
    device type_6 const& sprites,
    device type_7 const& sprite_data,
    constant _mslBufferSizes& _buffer_sizes
) {
    bool local_2 = {};
    bool local_3 = {};
    bool local_4 = {};
    uint k_1 = 0u;
    bool local_5 = {};
    if (point.x >= 0.0) {
        local_2 = point.x < 1.0;
    } else {
        local_2 = false;
    }
    bool _e11 = local_2;
    if (_e11) {
        local_3 = point.y >= 0.0;
    } else {
        local_3 = false;
    }
    bool _e18 = local_3;
    if (_e18) {
        local_4 = point.y < 1.0;
    } else {
        local_4 = false;
    }
    bool _e25 = local_4;
    if (!(_e25)) {
        return false;
    }
    metal::uint2 _e32 = sprites[i_5].size;
    metal::uint2 texel_3 = naga_f2u32(point.xy * static_cast<metal::float2>(_e32));
    metal::uint4 _e39 = sprites[i_5].region;
    if (metal::any(texel_3 < _e39.xy)) {
        return false;
    }
    metal::uint4 _e47 = sprites[i_5].region;
    metal::uint2 p_3 = texel_3 - _e47.xy;
    metal::uint4 _e53 = sprites[i_5].region;
    if (metal::any(p_3 >= _e53.zw)) {
        return false;
    }
    metal::uint2 _e58 = sprite_ranges(i_5, p_3, sprites, sprite_data, _buffer_sizes);
    uint2 loop_bound_1 = uint2(4294967295u);
    bool loop_init = true;
    while(true) {
        if (metal::all(loop_bound_1 == uint2(0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init) {
            uint _e84 = k_1;
            k_1 = _e84 + 1u;
        }
        loop_init = false;
        uint _e61 = k_1;
        if (_e61 < _e58.y) {
        } else {
            break;
        }
        {
            uint _e65 = k_1;
            metal::float2 _e66 = sprite_range(i_5, _e58.x, _e65, sprites, sprite_data, _buffer_sizes);
            if (!((_e66.x > point.z))) {
                local_5 = _e66.x == 1.0;
            } else {
                local_5 = true;
            }
            bool _e77 = local_5;
            if (_e77) {
                return false;
            }
            if (point.z <= _e66.y) {
                return true;
            }
        }
    }
    return false;
}

uint sprite_zone(
    uint i_6,
    metal::float3 world_1,
    float half_,
    device type_6 const& sprites,
    device type_7 const& sprite_data,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint count = 0u;
    uint k_2 = 0u;
    uint2 loop_bound_2 = uint2(4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (metal::all(loop_bound_2 == uint2(0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e38 = k_2;
            k_2 = _e38 + 1u;
        }
        loop_init_1 = false;
        uint _e7 = k_2;
        if (_e7 < 8u) {
        } else {
            break;
        }
        {
            uint _e10 = k_2;
            uint _e14 = k_2;
            uint _e20 = k_2;
            metal::float3 corner = (metal::float3(static_cast<float>(_e10 & 1u), static_cast<float>((_e14 >> 1u) & 1u), static_cast<float>(_e20 >> 2u)) * 2.0) - metal::float3(1.0);
            uint _e30 = count;
            metal::float3 _e33 = sprite_texture(i_6, world_1 + (corner * half_), sprites, _buffer_sizes);
            bool _e34 = sprite_contains(i_6, _e33, sprites, sprite_data, _buffer_sizes);
            count = _e30 + static_cast<uint>(_e34);
        }
    }
    uint _e40 = count;
    if (_e40 == 0u) {
        return SPRITE_OUTSIDE;
    }
    uint _e46 = count;
    return (_e46 == 8u) ? SPRITE_INSIDE : SPRITE_BORDER;
}

metal::int2 naga_f2i32(metal::float2 value) {
    return static_cast<metal::int2>(metal::clamp(value, -2147483600.0, 2147483500.0));
}

metal::float2 sprite_enter(
    uint i_7,
    metal::float3 origin,
    metal::float3 direction,
    device type_6 const& sprites,
    device type_7 const& sprite_data,
    constant _mslBufferSizes& _buffer_sizes
) {
    float t = 0.0;
    float last = 340000000000000000000000000000000000000.0;
    uint k_3 = 0u;
    bool local_6 = {};
    metal::int2 texel_1 = {};
    metal::float2 found = {};
    bool touched = {};
    uint n = {};
    metal::float2 part = {};
    bool local_7 = {};
    bool local_8 = {};
    bool local_9 = {};
    bool local_10 = {};
    bool local_11 = {};
    metal::float2 none = metal::float2(1.0, 0.0);
    metal::uint2 _e9 = sprites[i_7].size;
    metal::float3 size = metal::float3(static_cast<metal::float2>(_e9), 1.0);
    metal::uint4 _e16 = sprites[i_7].region;
    metal::float3 end_1 = metal::float3(static_cast<metal::float2>(_e16.zw), 1.0);
    metal::float3 _e21 = sprite_texture(i_7, origin, sprites, _buffer_sizes);
    metal::uint4 _e26 = sprites[i_7].region;
    metal::float3 o = (_e21 * size) - metal::float3(static_cast<metal::float2>(_e26.xy), 0.0);
    metal::float3 _e33 = sprite_texture(i_7, origin + direction, sprites, _buffer_sizes);
    metal::float3 _e34 = sprite_texture(i_7, origin, sprites, _buffer_sizes);
    metal::float3 d = (_e33 - _e34) * size;
    uint2 loop_bound_3 = uint2(4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (metal::all(loop_bound_3 == uint2(0u))) { break; }
        loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
        if (!loop_init_2) {
            uint _e85 = k_3;
            k_3 = _e85 + 1u;
        }
        loop_init_2 = false;
        uint _e43 = k_3;
        if (_e43 < 3u) {
        } else {
            break;
        }
        {
            uint _e46 = k_3;
            if (d[_e46] == 0.0) {
                uint _e50 = k_3;
                if (o[_e50] >= 0.0) {
                    uint _e56 = k_3;
                    uint _e58 = k_3;
                    local_6 = o[_e56] < end_1[_e58];
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
                float a = -(o[_e64]) / d[_e67];
                uint _e70 = k_3;
                uint _e72 = k_3;
                uint _e75 = k_3;
                float b = (end_1[_e70] - o[_e72]) / d[_e75];
                float _e78 = t;
                t = metal::max(_e78, metal::min(a, b));
                float _e81 = last;
                last = metal::min(_e81, metal::max(a, b));
            }
        }
    }
    metal::uint4 _e90 = sprites[i_7].region;
    metal::int2 limit = static_cast<metal::int2>(_e90.zw);
    float _e95 = t;
    texel_1 = metal::clamp(naga_f2i32(metal::floor(o.xy + (d.xy * _e95))), metal::int2(0), as_type<metal::int2>(as_type<metal::uint2>(limit) - as_type<metal::uint2>(metal::int2(1))));
    metal::int2 step = naga_f2i32(metal::sign(d.xy));
    found = none;
    uint2 loop_bound_4 = uint2(4294967295u);
    while(true) {
        if (metal::all(loop_bound_4 == uint2(0u))) { break; }
        loop_bound_4 -= uint2(loop_bound_4.y == 0u, 1u);
        float _e111 = t;
        float _e112 = last;
        if (_e111 < _e112) {
        } else {
            break;
        }
        {
            metal::int2 _e114 = texel_1;
            metal::float2 border = static_cast<metal::float2>(as_type<metal::int2>(as_type<metal::uint2>(_e114) + as_type<metal::uint2>(metal::max(step, metal::int2(0)))));
            metal::float2 next = metal::select((border - o.xy) / d.xy, metal::float2(340000000000000000000000000000000000000.0), step == metal::int2(0));
            float _e133 = last;
            float until = metal::min(metal::min(next.x, next.y), _e133);
            float _e135 = t;
            if (_e135 < until) {
                metal::int2 _e137 = texel_1;
                metal::uint2 _e139 = sprite_ranges(i_7, static_cast<metal::uint2>(_e137), sprites, sprite_data, _buffer_sizes);
                touched = false;
                n = 0u;
                uint2 loop_bound_5 = uint2(4294967295u);
                bool loop_init_3 = true;
                while(true) {
                    if (metal::all(loop_bound_5 == uint2(0u))) { break; }
                    loop_bound_5 -= uint2(loop_bound_5.y == 0u, 1u);
                    if (!loop_init_3) {
                        uint _e228 = n;
                        n = _e228 + 1u;
                    }
                    loop_init_3 = false;
                    uint _e144 = n;
                    if (_e144 < _e139.y) {
                    } else {
                        break;
                    }
                    {
                        uint _e147 = n;
                        uint _e151 = n;
                        uint k_4 = (d.z < 0.0) ? ((_e139.y - 1u) - _e151) : _e147;
                        metal::float2 _e158 = sprite_range(i_7, _e139.x, k_4, sprites, sprite_data, _buffer_sizes);
                        float _e159 = t;
                        part = metal::float2(_e159, until);
                        if (d.z == 0.0) {
                            metal::float2 _e165 = part;
                            if (_e158.x <= o.z) {
                                local_7 = o.z <= _e158.y;
                            } else {
                                local_7 = false;
                            }
                            bool _e175 = local_7;
                            part = _e175 ? _e165 : none;
                        } else {
                            metal::float2 at_3 = (_e158 - metal::float2(o.z)) / metal::float2(d.z);
                            float _e183 = t;
                            part = metal::float2(metal::max(_e183, metal::min(at_3.x, at_3.y)), metal::min(until, metal::max(at_3.x, at_3.y)));
                        }
                        if (!((_e158.x == 1.0))) {
                            float _e200 = part.x;
                            float _e202 = part.y;
                            local_8 = _e200 >= _e202;
                        } else {
                            local_8 = true;
                        }
                        bool _e205 = local_8;
                        if (_e205) {
                            continue;
                        }
                        float _e207 = found.x;
                        float _e209 = found.y;
                        if (_e207 > _e209) {
                            metal::float2 _e211 = part;
                            found = _e211;
                        } else {
                            float _e213 = part.x;
                            float _e215 = found.y;
                            if (_e213 <= _e215) {
                                float _e219 = found.y;
                                float _e221 = part.y;
                                found.y = metal::max(_e219, _e221);
                            } else {
                                metal::float2 _e223 = found;
                                return _e223;
                            }
                        }
                        float _e225 = found.y;
                        touched = _e225 >= until;
                    }
                }
                float _e231 = found.x;
                float _e233 = found.y;
                if (_e231 <= _e233) {
                    bool _e237 = touched;
                    local_9 = !(_e237);
                } else {
                    local_9 = false;
                }
                bool _e240 = local_9;
                if (_e240) {
                    metal::float2 _e241 = found;
                    return _e241;
                }
                t = until;
            }
            uint along_1 = static_cast<uint>(next.y < next.x);
            int _e247 = texel_1[along_1];
            texel_1[along_1] = as_type<int>(as_type<uint>(_e247) + as_type<uint>(step[along_1]));
            if (!((step[along_1] == 0))) {
                int _e257 = texel_1[along_1];
                local_10 = _e257 < 0;
            } else {
                local_10 = true;
            }
            bool _e261 = local_10;
            if (!(_e261)) {
                int _e266 = texel_1[along_1];
                local_11 = _e266 >= limit[along_1];
            } else {
                local_11 = true;
            }
            bool _e270 = local_11;
            if (_e270) {
                break;
            }
        }
    }
    metal::float2 _e271 = found;
    return _e271;
}

struct classifyInput {
};
kernel void classify(
  metal::uint3 id [[thread_position_in_grid]]
, metal::uint3 groups [[threadgroups_per_grid]]
, device type_6 const& sprites [[user(fake0)]]
, device type_7 const& sprite_data [[user(fake0)]]
, device type_12 const& points [[user(fake0)]]
, device type_14& inside [[user(fake0)]]
, constant _mslBufferSizes& _buffer_sizes [[user(fake0)]]
) {
    bool local = {};
    uint i_8 = ((id.y * groups.x) * 64u) + id.x;
    if (i_8 < (1 + (_buffer_sizes.size2 - 0 - 16) / 16)) {
        metal::float4 _e17 = points[i_8];
        bool _e19 = sprite_contains(0u, _e17.xyz, sprites, sprite_data, _buffer_sizes);
        local = _e19;
    } else {
        local = false;
    }
    bool _e21 = local;
    if (_e21) {
        uint _e30 = metal::atomic_fetch_or_explicit(&inside[naga_div(i_8, 32u)], 1u << naga_mod(i_8, 32u), metal::memory_order_relaxed);
        return;
    } else {
        return;
    }
}
