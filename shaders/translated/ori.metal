// language: metal2.0
#include <metal_stdlib>
#include <simd/simd.h>

using metal::uint;

struct _mslBufferSizes {
    uint size2;
    uint size3;
    uint size4;
};

struct Frame {
    metal::float4x4 clip;
    metal::float4 depth;
    metal::float4 eye;
    metal::float4 to_sun;
    metal::float4 sun;
    metal::float4 sky;
    metal::float4 ground;
    float near;
    float far;
    float sample_size;
    uint shading;
};
struct Impostor {
    metal::float4 centre;
    metal::float4 extent;
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
    char _pad12[8];
};
struct type_4 {
    metal::float4 inner[3];
};
struct Map {
    type_4 rows;
    metal::float4 window;
    float deep;
    float step;
    float texel;
    uint first;
};
struct Instance {
    metal::float4 place;
    metal::float4 rotation;
    metal::uint4 maps;
};
typedef Map type_6[1];
typedef Instance type_7[1];
typedef metal::float2 type_9[1];
struct Ray {
    metal::float3 origin;
    metal::float3 direction;
};
struct Proxy {
    metal::float4 clip;
    metal::packed_float3 position;
    uint instance;
};
struct type_17 {
    metal::float2 inner[4];
};
struct Seen {
    uint map;
    float t;
};
struct type_19 {
    float inner[8];
};
struct Fragment {
    metal::float4 color;
    float depth;
    char _pad2[12];
};
constant uint MAPS = 8u;
constant uint NO_MAP = 65535u;

metal::float3 turned(
    metal::float3 v,
    metal::float4 q
) {
    return v + (2.0 * metal::cross(q.xyz, metal::cross(q.xyz, v) + (q.w * v)));
}

metal::float3 turned_back(
    metal::float3 v_1,
    metal::float4 q_1
) {
    return v_1 + (2.0 * metal::cross(q_1.xyz, metal::cross(q_1.xyz, v_1) - (q_1.w * v_1)));
}

metal::float2 texel(
    uint map,
    metal::int2 at,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    bool local_3 = {};
    if (!(metal::any(at < metal::int2(0)))) {
        uint _e11 = impostor.side;
        local_3 = metal::any(at >= metal::int2(static_cast<int>(_e11)));
    } else {
        local_3 = true;
    }
    bool _e17 = local_3;
    if (_e17) {
        return metal::float2(300000000000000000000000000000000000000.0, -0.5);
    }
    uint _e23 = impostor.codes;
    float last = static_cast<float>(_e23 - 1u);
    metal::float4 _e29 = depth_codes.read(metal::uint2(at), map, 0);
    float code = metal::floor((_e29.x * last) + 0.5);
    uint _e37 = impostor.depths;
    if (code < static_cast<float>(_e37)) {
        float _e43 = maps[map].step;
        return metal::float2(code * _e43, 0.5);
    }
    float reach = ((last - code) + 0.5) / 16.0;
    return metal::float2(300000000000000000000000000000000000000.0, (-0.5 * (1.0 - reach)) / reach);
}

float straight_on(
    uint map_1,
    metal::int2 a,
    float depth,
    metal::int2 k,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float2 _e7 = texel(map_1, as_type<metal::int2>(as_type<metal::uint2>(as_type<metal::int2>(as_type<uint>(2) * as_type<metal::uint2>(a))) - as_type<metal::uint2>(k)), impostor, maps, depth_codes, _buffer_sizes);
    float before_1 = _e7.x;
    float _e16 = impostor.wall;
    return (metal::abs(before_1 - depth) <= _e16) ? ((2.0 * depth) - before_1) : depth;
}

metal::int2 corner_of(
    metal::int2 first,
    uint k_1
) {
    return as_type<metal::int2>(as_type<metal::uint2>(first) + as_type<metal::uint2>(static_cast<metal::int2>(metal::uint2(k_1 & 1u, k_1 >> 1u))));
}

metal::float4 corners_of(
    uint map_2,
    metal::int2 first_1,
    type_17 texels,
    uint bits_1,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float4 depths = {};
    metal::float4 out = {};
    uint k_2 = 0u;
    float sum = {};
    bool local_4 = {};
    depths = metal::float4(texels.inner[0].x, texels.inner[1].x, texels.inner[2].x, texels.inner[3].x);
    if (bits_1 == 15u) {
        metal::float4 _e16 = depths;
        return _e16;
    }
    metal::float4 _e17 = depths;
    out = _e17;
    uint2 loop_bound = uint2(4294967295u);
    bool loop_init = true;
    while(true) {
        if (metal::all(loop_bound == uint2(0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        if (!loop_init) {
            uint _e100 = k_2;
            k_2 = _e100 + 1u;
        }
        loop_init = false;
        uint _e21 = k_2;
        if (_e21 < 4u) {
        } else {
            break;
        }
        {
            uint _e24 = k_2;
            if (((bits_1 >> _e24) & 1u) == 1u) {
                continue;
            }
            uint _e30 = k_2;
            uint a_1 = _e30 ^ 1u;
            uint _e33 = k_2;
            uint b = _e33 ^ 2u;
            uint _e36 = k_2;
            uint c = _e36 ^ 3u;
            metal::bool3 has = metal::bool3(((bits_1 >> a_1) & 1u) == 1u, ((bits_1 >> b) & 1u) == 1u, ((bits_1 >> c) & 1u) == 1u);
            if (metal::all(has)) {
                uint _e56 = k_2;
                float _e59 = depths[a_1];
                float _e61 = depths[b];
                float _e64 = depths[c];
                out[_e56] = (_e59 + _e61) - _e64;
                continue;
            }
            uint _e66 = k_2;
            metal::int2 _e67 = corner_of(first_1, _e66);
            sum = 0.0;
            if (has.x) {
                metal::int2 _e71 = corner_of(first_1, a_1);
                float _e73 = depths[a_1];
                float _e74 = straight_on(map_2, _e71, _e73, _e67, impostor, maps, depth_codes, _buffer_sizes);
                sum = _e74;
            }
            if (has.y) {
                metal::int2 _e76 = corner_of(first_1, b);
                float _e78 = depths[b];
                float _e79 = straight_on(map_2, _e76, _e78, _e67, impostor, maps, depth_codes, _buffer_sizes);
                float _e80 = sum;
                sum = has.x ? ((_e80 + _e79) * 0.5) : _e79;
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
            out[_e86] = _e97 ? _e90 : _e89;
        }
    }
    metal::float4 _e102 = out;
    return _e102;
}

float rising_root(
    float e,
    float f,
    float g
) {
    float under_1 = (f * f) - ((4.0 * e) * g);
    if (!((under_1 > 0.0))) {
        return 300000000000000000000000000000000000000.0;
    }
    float root = metal::sqrt(under_1);
    if (f >= 0.0) {
        return (-2.0 * e) / (f + root);
    }
    if (g == 0.0) {
        return 300000000000000000000000000000000000000.0;
    }
    return (root - f) / (2.0 * g);
}

bool shows(
    type_17 texels_1,
    uint bits_2,
    metal::float2 at_1
) {
    type_17 all_texels = {};
    metal::float4 weights = {};
    float edge = 0.0;
    uint own = 0u;
    float most = -1.0;
    uint k_3 = 0u;
    bool local_5 = {};
    bool local_6 = {};
    all_texels = texels_1;
    metal::float2 p_1 = metal::clamp(at_1, metal::float2(0.0), metal::float2(1.0));
    weights = metal::float4((1.0 - p_1.x) * (1.0 - p_1.y), p_1.x * (1.0 - p_1.y), (1.0 - p_1.x) * p_1.y, p_1.x * p_1.y);
    uint2 loop_bound_1 = uint2(4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (metal::all(loop_bound_1 == uint2(0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e72 = k_3;
            k_3 = _e72 + 1u;
        }
        loop_init_1 = false;
        uint _e39 = k_3;
        if (_e39 < 4u) {
        } else {
            break;
        }
        {
            float _e42 = edge;
            uint _e43 = k_3;
            float _e45 = weights[_e43];
            uint _e46 = k_3;
            float _e49 = all_texels.inner[_e46].y;
            edge = _e42 + (_e45 * _e49);
            uint _e52 = k_3;
            float _e55 = all_texels.inner[_e52].x;
            if (_e55 < 100000000000000000000000000000000000000.0) {
                uint _e60 = k_3;
                float _e62 = weights[_e60];
                float _e63 = most;
                local_5 = _e62 > _e63;
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
    if (_e74 > 0.0) {
        uint _e79 = own;
        local_6 = ((bits_2 >> _e79) & 1u) == 1u;
    } else {
        local_6 = false;
    }
    bool _e86 = local_6;
    return _e86;
}

float meet(
    uint map_3,
    metal::int2 first_2,
    Ray ray,
    float start,
    float end,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    type_17 texels_2 = {};
    uint taken = 0u;
    float nearest = 300000000000000000000000000000000000000.0;
    uint k_4 = 0u;
    bool local_7 = {};
    uint bits_3 = {};
    uint l = {};
    bool local_8 = {};
    bool local_9 = {};
    bool local_10 = {};
    bool local_11 = {};
    metal::float2 _e5 = texel(map_3, first_2, impostor, maps, depth_codes, _buffer_sizes);
    metal::float2 _e10 = texel(map_3, as_type<metal::int2>(as_type<metal::uint2>(first_2) + as_type<metal::uint2>(metal::int2(1, 0))), impostor, maps, depth_codes, _buffer_sizes);
    metal::float2 _e15 = texel(map_3, as_type<metal::int2>(as_type<metal::uint2>(first_2) + as_type<metal::uint2>(metal::int2(0, 1))), impostor, maps, depth_codes, _buffer_sizes);
    metal::float2 _e20 = texel(map_3, as_type<metal::int2>(as_type<metal::uint2>(first_2) + as_type<metal::uint2>(metal::int2(1, 1))), impostor, maps, depth_codes, _buffer_sizes);
    texels_2 = type_17 {{_e5, _e10, _e15, _e20}};
    metal::float3 begin = ray.origin + (ray.direction * start);
    metal::float3 d = ray.direction;
    metal::float2 corner = begin.xy - (static_cast<metal::float2>(first_2) + metal::float2(0.5));
    uint2 loop_bound_2 = uint2(4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (metal::all(loop_bound_2 == uint2(0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
        if (!loop_init_2) {
            uint _e183 = k_4;
            k_4 = _e183 + 1u;
        }
        loop_init_2 = false;
        uint _e40 = k_4;
        if (_e40 < 4u) {
        } else {
            break;
        }
        {
            uint _e43 = taken;
            uint _e44 = k_4;
            if (!((((_e43 >> _e44) & 1u) == 1u))) {
                uint _e53 = k_4;
                float _e56 = texels_2.inner[_e53].x;
                local_7 = _e56 > 100000000000000000000000000000000000000.0;
            } else {
                local_7 = true;
            }
            bool _e60 = local_7;
            if (_e60) {
                continue;
            }
            bits_3 = 0u;
            l = 0u;
            uint2 loop_bound_3 = uint2(4294967295u);
            bool loop_init_3 = true;
            while(true) {
                if (metal::all(loop_bound_3 == uint2(0u))) { break; }
                loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
                if (!loop_init_3) {
                    uint _e99 = l;
                    l = _e99 + 1u;
                }
                loop_init_3 = false;
                uint _e65 = l;
                if (_e65 < 4u) {
                } else {
                    break;
                }
                {
                    uint _e68 = taken;
                    uint _e69 = l;
                    if (((_e68 >> _e69) & 1u) == 0u) {
                        uint _e77 = l;
                        float _e80 = texels_2.inner[_e77].x;
                        uint _e81 = k_4;
                        float _e84 = texels_2.inner[_e81].x;
                        float _e89 = impostor.wall;
                        local_8 = metal::abs(_e80 - _e84) <= _e89;
                    } else {
                        local_8 = false;
                    }
                    bool _e92 = local_8;
                    if (_e92) {
                        uint _e93 = bits_3;
                        uint _e95 = l;
                        bits_3 = _e93 | (1u << _e95);
                    }
                }
            }
            uint _e101 = taken;
            uint _e102 = bits_3;
            taken = _e101 | _e102;
            type_17 _e104 = texels_2;
            uint _e105 = bits_3;
            metal::float4 _e106 = corners_of(map_3, first_2, _e104, _e105, impostor, maps, depth_codes, _buffer_sizes);
            float b_1 = _e106.y - _e106.x;
            float c_1 = _e106.z - _e106.x;
            float g_1 = ((_e106.x - _e106.y) - _e106.z) + _e106.w;
            float e_1 = begin.z - (((_e106.x + (b_1 * corner.x)) + (c_1 * corner.y)) + ((g_1 * corner.x) * corner.y));
            float f_1 = ray.direction.z - (((b_1 * ray.direction.x) + (c_1 * ray.direction.y)) + (g_1 * ((corner.x * ray.direction.y) + (corner.y * ray.direction.x))));
            float _e155 = rising_root(e_1, f_1, (-(g_1) * ray.direction.x) * ray.direction.y);
            if (_e155 >= 0.0) {
                local_9 = (start + _e155) <= end;
            } else {
                local_9 = false;
            }
            bool _e163 = local_9;
            if (_e163) {
                float _e167 = nearest;
                local_10 = (start + _e155) < _e167;
            } else {
                local_10 = false;
            }
            bool _e170 = local_10;
            if (_e170) {
                type_17 _e173 = texels_2;
                uint _e174 = bits_3;
                bool _e178 = shows(_e173, _e174, corner + (d.xy * _e155));
                local_11 = _e178;
            } else {
                local_11 = false;
            }
            bool _e180 = local_11;
            if (_e180) {
                nearest = start + _e155;
            }
        }
    }
    float _e185 = nearest;
    return _e185;
}

metal::int2 naga_f2i32(metal::float2 value) {
    return static_cast<metal::int2>(metal::clamp(value, -2147483600.0, 2147483500.0));
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / metal::select(rhs, 1u, rhs == 0u);
}

float search_pyramid(
    uint map_4,
    Ray ray_1,
    float t0_,
    float t1_,
    constant Impostor& impostor,
    device type_6 const& maps,
    device type_9 const& ranges,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint level = {};
    float t = {};
    uint i = 0u;
    bool local_12 = {};
    bool local_13 = {};
    metal::float3 o = ray_1.origin;
    metal::float3 d_1 = ray_1.direction;
    float pace = metal::max(metal::max(metal::abs(ray_1.direction.x), metal::abs(ray_1.direction.y)), 0.05 * metal::abs(ray_1.direction.z));
    float nudge = 0.0005 / pace;
    float slack = 0.002 / pace;
    uint n = impostor.squares;
    uint top = (((metal::ctz(n) + 1) % 33) - 1);
    metal::float2 begin_1 = o.xy - metal::float2(0.5);
    metal::bool2 still = d_1.xy == metal::float2(0.0);
    metal::float2 over = metal::float2(1.0) / metal::select(d_1.xy, metal::float2(1.0), still);
    metal::int2 ahead = static_cast<metal::int2>(d_1.xy > metal::float2(0.0));
    level = metal::min(2u, top);
    t = metal::min(t0_ + nudge, (t0_ + t1_) * 0.5);
    uint2 loop_bound_4 = uint2(4294967295u);
    bool loop_init_4 = true;
    while(true) {
        if (metal::all(loop_bound_4 == uint2(0u))) { break; }
        loop_bound_4 -= uint2(loop_bound_4.y == 0u, 1u);
        if (!loop_init_4) {
            uint _e165 = i;
            i = _e165 + 1u;
        }
        loop_init_4 = false;
        uint _e55 = i;
        if (_e55 < (8u * n)) {
            float _e61 = t;
            local_12 = _e61 < t1_;
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
            metal::int2 cell = metal::clamp(naga_f2i32(begin_1 + (d_1.xy * _e66)), metal::int2(0), metal::int2(as_type<int>(as_type<uint>(static_cast<int>(n)) - as_type<uint>(1))));
            float _e77 = t;
            float before_2 = metal::max(_e77 - nudge, t0_);
            float enter = ray_1.origin.z + (ray_1.direction.z * before_2);
            uint2 loop_bound_5 = uint2(4294967295u);
            while(true) {
                if (metal::all(loop_bound_5 == uint2(0u))) { break; }
                loop_bound_5 -= uint2(loop_bound_5.y == 0u, 1u);
                uint _e84 = level;
                metal::int2 square = cell >> metal::uint2(_e84);
                uint _e88 = level;
                metal::float2 sides = (static_cast<metal::float2>(as_type<metal::int2>(as_type<metal::uint2>(square) + as_type<metal::uint2>(ahead)) << metal::uint2(_e88)) - begin_1) * over;
                metal::float2 ends = metal::select(sides, metal::float2(t1_), still);
                float _e100 = t;
                float end_3 = metal::max(metal::min(metal::min(ends.x, ends.y), t1_), _e100);
                uint _e102 = level;
                uint m = n >> _e102;
                uint skipped = naga_div((n * n) - (m * m), 3u) * 4u;
                uint _e115 = maps[map_4].first;
                metal::float2 range = ranges[((_e115 + skipped) + (static_cast<uint>(square.y) * m)) + static_cast<uint>(square.x)];
                float leave = ray_1.origin.z + (ray_1.direction.z * end_3);
                if (!(((metal::max(enter, leave) + 0.002) < range.x))) {
                    local_13 = (metal::min(enter, leave) - 0.002) > range.y;
                } else {
                    local_13 = true;
                }
                bool _e144 = local_13;
                if (_e144) {
                    t = end_3 + nudge;
                    uint _e146 = level;
                    level = metal::min(_e146 + 1u, top);
                    break;
                }
                uint _e150 = level;
                if (_e150 == 0u) {
                    float _e155 = meet(map_4, cell, ray_1, before_2 - slack, end_3 + slack, impostor, maps, depth_codes, _buffer_sizes);
                    if (_e155 < 100000000000000000000000000000000000000.0) {
                        return _e155;
                    }
                    t = end_3 + nudge;
                    level = metal::min(1u, top);
                    break;
                }
                uint _e161 = level;
                level = _e161 - 1u;
            }
        }
    }
    return 300000000000000000000000000000000000000.0;
}

float height(
    uint map_5,
    metal::float2 at_2,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    type_17 texels_3 = {};
    metal::float4 weights_1 = {};
    float edge_1 = 0.0;
    float own_1 = 300000000000000000000000000000000000000.0;
    float most_1 = -1.0;
    uint k_5 = 0u;
    bool local_14 = {};
    float sum_1 = 0.0;
    float weight = 0.0;
    uint k_6 = 0u;
    metal::float2 p_2 = at_2 - metal::float2(0.5);
    metal::float2 low = metal::floor(p_2);
    metal::float2 f_2 = p_2 - low;
    metal::int2 first_3 = naga_f2i32(low);
    metal::float2 _e8 = texel(map_5, first_3, impostor, maps, depth_codes, _buffer_sizes);
    metal::float2 _e13 = texel(map_5, as_type<metal::int2>(as_type<metal::uint2>(first_3) + as_type<metal::uint2>(metal::int2(1, 0))), impostor, maps, depth_codes, _buffer_sizes);
    metal::float2 _e18 = texel(map_5, as_type<metal::int2>(as_type<metal::uint2>(first_3) + as_type<metal::uint2>(metal::int2(0, 1))), impostor, maps, depth_codes, _buffer_sizes);
    metal::float2 _e23 = texel(map_5, as_type<metal::int2>(as_type<metal::uint2>(first_3) + as_type<metal::uint2>(metal::int2(1, 1))), impostor, maps, depth_codes, _buffer_sizes);
    texels_3 = type_17 {{_e8, _e13, _e18, _e23}};
    weights_1 = metal::float4((1.0 - f_2.x) * (1.0 - f_2.y), f_2.x * (1.0 - f_2.y), (1.0 - f_2.x) * f_2.y, f_2.x * f_2.y);
    uint2 loop_bound_6 = uint2(4294967295u);
    bool loop_init_5 = true;
    while(true) {
        if (metal::all(loop_bound_6 == uint2(0u))) { break; }
        loop_bound_6 -= uint2(loop_bound_6.y == 0u, 1u);
        if (!loop_init_5) {
            uint _e92 = k_5;
            k_5 = _e92 + 1u;
        }
        loop_init_5 = false;
        uint _e56 = k_5;
        if (_e56 < 4u) {
        } else {
            break;
        }
        {
            float _e59 = edge_1;
            uint _e60 = k_5;
            float _e62 = weights_1[_e60];
            uint _e63 = k_5;
            float _e66 = texels_3.inner[_e63].y;
            edge_1 = _e59 + (_e62 * _e66);
            uint _e69 = k_5;
            float _e72 = texels_3.inner[_e69].x;
            if (_e72 < 100000000000000000000000000000000000000.0) {
                uint _e77 = k_5;
                float _e79 = weights_1[_e77];
                float _e80 = most_1;
                local_14 = _e79 > _e80;
            } else {
                local_14 = false;
            }
            bool _e83 = local_14;
            if (_e83) {
                uint _e84 = k_5;
                float _e87 = texels_3.inner[_e84].x;
                own_1 = _e87;
                uint _e88 = k_5;
                float _e90 = weights_1[_e88];
                most_1 = _e90;
            }
        }
    }
    float _e94 = edge_1;
    if (!((_e94 > 0.0))) {
        return 300000000000000000000000000000000000000.0;
    }
    uint2 loop_bound_7 = uint2(4294967295u);
    bool loop_init_6 = true;
    while(true) {
        if (metal::all(loop_bound_7 == uint2(0u))) { break; }
        loop_bound_7 -= uint2(loop_bound_7.y == 0u, 1u);
        if (!loop_init_6) {
            uint _e135 = k_6;
            k_6 = _e135 + 1u;
        }
        loop_init_6 = false;
        uint _e105 = k_6;
        if (_e105 < 4u) {
        } else {
            break;
        }
        {
            uint _e108 = k_6;
            float _e111 = texels_3.inner[_e108].x;
            float _e112 = own_1;
            float _e117 = impostor.wall;
            if (metal::abs(_e111 - _e112) <= _e117) {
                float _e119 = sum_1;
                uint _e120 = k_6;
                float _e122 = weights_1[_e120];
                uint _e123 = k_6;
                float _e126 = texels_3.inner[_e123].x;
                sum_1 = _e119 + (_e122 * _e126);
                float _e129 = weight;
                uint _e130 = k_6;
                float _e132 = weights_1[_e130];
                weight = _e129 + _e132;
            }
        }
    }
    float _e137 = sum_1;
    float _e138 = weight;
    return _e137 / _e138;
}

float below(
    uint map_6,
    Ray ray_2,
    float t_1,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float3 p_3 = ray_2.origin + (ray_2.direction * t_1);
    float _e9 = height(map_6, p_3.xy, impostor, maps, depth_codes, _buffer_sizes);
    return p_3.z - _e9;
}

float search_linear(
    uint map_7,
    Ray ray_3,
    float t0_1,
    float t1_1,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    float above = {};
    float under = 300000000000000000000000000000000000000.0;
    uint i_1 = 0u;
    uint i_2 = 0u;
    uint _e7 = impostor.steps;
    float step = (t1_1 - t0_1) / static_cast<float>(_e7);
    above = t0_1;
    uint2 loop_bound_8 = uint2(4294967295u);
    bool loop_init_7 = true;
    while(true) {
        if (metal::all(loop_bound_8 == uint2(0u))) { break; }
        loop_bound_8 -= uint2(loop_bound_8.y == 0u, 1u);
        if (!loop_init_7) {
            uint _e28 = i_1;
            i_1 = _e28 + 1u;
        }
        loop_init_7 = false;
        uint _e15 = i_1;
        uint _e18 = impostor.steps;
        if (_e15 <= _e18) {
        } else {
            break;
        }
        {
            uint _e20 = i_1;
            float t_2 = t0_1 + (step * static_cast<float>(_e20));
            float _e24 = below(map_7, ray_3, t_2, impostor, maps, depth_codes, _buffer_sizes);
            if (_e24 >= 0.0) {
                under = t_2;
                break;
            }
            above = t_2;
        }
    }
    float _e30 = under;
    if (_e30 > 100000000000000000000000000000000000000.0) {
        return 300000000000000000000000000000000000000.0;
    }
    uint2 loop_bound_9 = uint2(4294967295u);
    bool loop_init_8 = true;
    while(true) {
        if (metal::all(loop_bound_9 == uint2(0u))) { break; }
        loop_bound_9 -= uint2(loop_bound_9.y == 0u, 1u);
        if (!loop_init_8) {
            uint _e50 = i_2;
            i_2 = _e50 + 1u;
        }
        loop_init_8 = false;
        uint _e36 = i_2;
        uint _e39 = impostor.halvings;
        if (_e36 < _e39) {
        } else {
            break;
        }
        {
            float _e41 = above;
            float _e42 = under;
            float middle = (_e41 + _e42) * 0.5;
            float _e46 = below(map_7, ray_3, middle, impostor, maps, depth_codes, _buffer_sizes);
            if (_e46 >= 0.0) {
                under = middle;
            } else {
                above = middle;
            }
        }
    }
    float _e54 = above;
    metal::float3 a_2 = ray_3.origin + (ray_3.direction * _e54);
    float _e59 = under;
    metal::float3 b_2 = ray_3.origin + (ray_3.direction * _e59);
    float _e63 = height(map_7, a_2.xy, impostor, maps, depth_codes, _buffer_sizes);
    float _e65 = height(map_7, b_2.xy, impostor, maps, depth_codes, _buffer_sizes);
    float _e70 = impostor.wall;
    if (!((metal::abs(_e63 - _e65) <= _e70))) {
        return 300000000000000000000000000000000000000.0;
    }
    float _e74 = under;
    return _e74;
}

float trace(
    uint map_8,
    Ray ray_4,
    float start_1,
    float end_1,
    constant Impostor& impostor,
    device type_6 const& maps,
    device type_9 const& ranges,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float4 window = maps[map_8].window;
    metal::float3 low_1 = metal::float3(window.xy, 0.0);
    float _e15 = maps[map_8].deep;
    metal::float3 high = metal::float3(window.zw, _e15);
    metal::bool3 still_1 = ray_4.direction == metal::float3(0.0);
    if (metal::any(still_1 & ((ray_4.origin < low_1) | (ray_4.origin > high)))) {
        return 300000000000000000000000000000000000000.0;
    }
    metal::float3 over_1 = metal::float3(1.0) / metal::select(ray_4.direction, metal::float3(1.0), still_1);
    metal::float3 a_3 = metal::select((low_1 - ray_4.origin) * over_1, metal::float3(start_1), still_1);
    metal::float3 b_3 = metal::select((high - ray_4.origin) * over_1, metal::float3(end_1), still_1);
    metal::float3 first_4 = metal::min(a_3, b_3);
    metal::float3 last_1 = metal::max(a_3, b_3);
    float t0_2 = metal::max(metal::max(first_4.x, first_4.y), metal::max(first_4.z, start_1));
    float t1_2 = metal::min(metal::min(last_1.x, last_1.y), metal::min(last_1.z, end_1));
    if (!((t0_2 <= t1_2))) {
        return 300000000000000000000000000000000000000.0;
    }
    uint _e65 = impostor.steps;
    if (_e65 > 0u) {
        float _e68 = search_linear(map_8, ray_4, t0_2, t1_2, impostor, maps, depth_codes, _buffer_sizes);
        return _e68;
    }
    float _e69 = search_pyramid(map_8, ray_4, t0_2, t1_2, impostor, maps, ranges, depth_codes, _buffer_sizes);
    return _e69;
}

float slope(
    float before,
    float at_3,
    float after,
    constant Impostor& impostor
) {
    bool local_15 = {};
    float _e7 = impostor.wall;
    bool has_before = metal::abs(before - at_3) <= _e7;
    float _e13 = impostor.wall;
    bool has_after = metal::abs(after - at_3) <= _e13;
    if (has_before) {
        local_15 = has_after;
    } else {
        local_15 = false;
    }
    bool _e18 = local_15;
    if (_e18) {
        return after - before;
    }
    if (has_before) {
        return 2.0 * (at_3 - before);
    }
    if (has_after) {
        return 2.0 * (after - at_3);
    }
    return 0.0;
}

float squareness(
    uint map_9,
    metal::float3 p,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float2 u = metal::float2(0.5, 0.0);
    metal::float2 v_2 = metal::float2(0.0, 0.5);
    float _e10 = height(map_9, p.xy - u, impostor, maps, depth_codes, _buffer_sizes);
    float _e14 = height(map_9, p.xy + u, impostor, maps, depth_codes, _buffer_sizes);
    float _e15 = slope(_e10, p.z, _e14, impostor);
    float _e18 = height(map_9, p.xy - v_2, impostor, maps, depth_codes, _buffer_sizes);
    float _e22 = height(map_9, p.xy + v_2, impostor, maps, depth_codes, _buffer_sizes);
    float _e23 = slope(_e18, p.z, _e22, impostor);
    return 1.0 / metal::sqrt(((_e15 * _e15) + (_e23 * _e23)) + 1.0);
}

Ray map_ray(
    uint map_10,
    Ray ray_5,
    device type_6 const& maps,
    constant _mslBufferSizes& _buffer_sizes
) {
    type_4 r = maps[map_10].rows;
    metal::float4 o_1 = metal::float4(ray_5.origin, 1.0);
    return Ray {metal::float3(metal::dot(r.inner[0], o_1), metal::dot(r.inner[1], o_1), metal::dot(r.inner[2], o_1)), metal::float3(metal::dot(r.inner[0].xyz, ray_5.direction), metal::dot(r.inner[1].xyz, ray_5.direction), metal::dot(r.inner[2].xyz, ray_5.direction))};
}

uint map_of(
    uint instance,
    uint k_7,
    device type_7 const& instances,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint pair = instances[instance].maps[k_7 >> 1u];
    return ((k_7 & 1u) == 1u) ? (pair >> 16u) : (pair & 65535u);
}

Seen see(
    uint instance_1,
    Ray ray_6,
    float start_2,
    float end_2,
    constant Impostor& impostor,
    device type_6 const& maps,
    device type_7 const& instances,
    device type_9 const& ranges,
    metal::texture2d_array<float, metal::access::sample> depth_codes,
    constant _mslBufferSizes& _buffer_sizes
) {
    type_19 found = {};
    float nearest_1 = 300000000000000000000000000000000000000.0;
    Seen best = Seen {65535u, 300000000000000000000000000000000000000.0};
    float least = 300000000000000000000000000000000000000.0;
    uint k_8 = 0u;
    float rank = {};
    bool local_16 = {};
    uint k_9 = 0u;
    bool local_17 = {};
    uint2 loop_bound_10 = uint2(4294967295u);
    bool loop_init_9 = true;
    while(true) {
        if (metal::all(loop_bound_10 == uint2(0u))) { break; }
        loop_bound_10 -= uint2(loop_bound_10.y == 0u, 1u);
        if (!loop_init_9) {
            uint _e76 = k_8;
            k_8 = _e76 + 1u;
        }
        loop_init_9 = false;
        uint _e15 = k_8;
        if (_e15 < MAPS) {
        } else {
            break;
        }
        {
            uint _e18 = k_8;
            found.inner[_e18] = 300000000000000000000000000000000000000.0;
            uint _e21 = k_8;
            uint _e22 = map_of(instance_1, _e21, instances, _buffer_sizes);
            if (_e22 == NO_MAP) {
                continue;
            }
            Ray _e25 = map_ray(_e22, ray_6, maps, _buffer_sizes);
            float _e26 = trace(_e22, _e25, start_2, end_2, impostor, maps, ranges, depth_codes, _buffer_sizes);
            if (_e26 > 100000000000000000000000000000000000000.0) {
                continue;
            }
            uint _e29 = k_8;
            found.inner[_e29] = _e26;
            float _e31 = nearest_1;
            nearest_1 = metal::min(_e31, _e26);
            rank = _e26;
            uint _e36 = impostor.strategy;
            switch(_e36) {
                case 1u: {
                    rank = (_e25.direction.z == 0.0) ? 100000000000000000000000000000000000000.0 : (-(_e25.origin.z) / _e25.direction.z);
                    break;
                }
                case 4u: {
                    float _e53 = squareness(_e22, _e25.origin + (_e25.direction * _e26), impostor, maps, depth_codes, _buffer_sizes);
                    rank = -(_e53);
                    break;
                }
                case 5u: {
                    Map m_1 = maps[_e22];
                    float _e67 = squareness(_e22, _e25.origin + (_e25.direction * _e26), impostor, maps, depth_codes, _buffer_sizes);
                    rank = _e26 - ((0.03125 * (m_1.deep * m_1.texel)) * _e67);
                    break;
                }
                default: {
                    break;
                }
            }
            float _e70 = rank;
            float _e71 = least;
            if (_e70 < _e71) {
                best = Seen {_e22, _e26};
                float _e74 = rank;
                least = _e74;
            }
        }
    }
    uint _e80 = impostor.strategy;
    if (_e80 == 3u) {
        uint _e86 = best.map;
        local_16 = _e86 != NO_MAP;
    } else {
        local_16 = false;
    }
    bool _e90 = local_16;
    if (_e90) {
        uint2 loop_bound_11 = uint2(4294967295u);
        bool loop_init_10 = true;
        while(true) {
            if (metal::all(loop_bound_11 == uint2(0u))) { break; }
            loop_bound_11 -= uint2(loop_bound_11.y == 0u, 1u);
            if (!loop_init_10) {
                uint _e127 = k_9;
                k_9 = _e127 + 1u;
            }
            loop_init_10 = false;
            uint _e93 = k_9;
            if (_e93 < MAPS) {
            } else {
                break;
            }
            {
                uint _e96 = k_9;
                uint _e97 = map_of(instance_1, _e96, instances, _buffer_sizes);
                uint _e98 = k_9;
                float _e100 = found.inner[_e98];
                if (_e100 < 100000000000000000000000000000000000000.0) {
                    uint _e105 = k_9;
                    float _e107 = found.inner[_e105];
                    float _e108 = nearest_1;
                    float _e111 = impostor.wall;
                    float _e115 = maps[_e97].texel;
                    local_17 = !((_e107 > (_e108 + (_e111 * _e115))));
                } else {
                    local_17 = false;
                }
                bool _e121 = local_17;
                if (_e121) {
                    uint _e122 = k_9;
                    float _e124 = found.inner[_e122];
                    return Seen {_e97, _e124};
                }
            }
        }
    }
    Seen _e129 = best;
    return _e129;
}

metal::float3 lit(
    metal::float3 base,
    metal::float3 normal,
    metal::float3 position,
    constant Frame& frame
) {
    metal::float3 out_1 = {};
    bool local_18 = {};
    metal::float4 _e5 = frame.to_sun;
    float sun = metal::max(metal::dot(normal, _e5.xyz), 0.0);
    metal::float4 _e12 = frame.ground;
    metal::float4 _e16 = frame.sky;
    metal::float3 ambient = metal::mix(_e12.xyz, _e16.xyz, 0.5 + (0.5 * normal.y));
    metal::float4 _e26 = frame.sun;
    out_1 = base * ((_e26.xyz * sun) + ambient);
    float _e35 = frame.sun.w;
    if (_e35 > 0.0) {
        local_18 = sun > 0.0;
    } else {
        local_18 = false;
    }
    bool _e43 = local_18;
    if (_e43) {
        metal::float4 _e46 = frame.eye;
        float _e51 = frame.eye.w;
        metal::float3 to_eye = metal::normalize(_e46.xyz - (position * _e51));
        metal::float4 _e57 = frame.to_sun;
        metal::float3 h = metal::normalize(_e57.xyz + to_eye);
        metal::float3 _e61 = out_1;
        metal::float4 _e64 = frame.sun;
        float _e69 = frame.sun.w;
        float _e76 = frame.to_sun.w;
        out_1 = _e61 + (_e64.xyz * ((_e69 * metal::pow(metal::max(metal::dot(normal, h), 0.0), _e76)) * sun));
    }
    metal::float3 _e82 = out_1;
    return _e82;
}

metal::float3 shade(
    Seen seen,
    Instance instance_2,
    metal::float3 local_19,
    metal::float3 position_1,
    float depth_1,
    constant Frame& frame,
    constant Impostor& impostor,
    device type_6 const& maps,
    metal::texture2d_array<float, metal::access::sample> color,
    metal::texture2d_array<float, metal::access::sample> normals,
    metal::texture2d_array<float, metal::access::sample> emissive,
    metal::sampler smooth_sampler,
    constant _mslBufferSizes& _buffer_sizes
) {
    Map map_11 = maps[seen.map];
    metal::float4 p_4 = metal::float4(local_19, 1.0);
    uint _e20 = impostor.side;
    metal::float2 uv = metal::float2(metal::dot(map_11.rows.inner[0], p_4), metal::dot(map_11.rows.inner[1], p_4)) / metal::float2(static_cast<float>(_e20));
    float _e26 = frame.sample_size;
    float _e30 = frame.eye.w;
    float sample = (_e26 * ((_e30 > 0.0) ? depth_1 : 1.0)) / (map_11.texel * instance_2.place.w);
    uint _e46 = impostor.levels;
    float level_1 = metal::clamp(metal::log2(metal::max(sample, 1.0)), 0.0, static_cast<float>(_e46 - 1u));
    metal::float4 _e55 = color.sample(smooth_sampler, uv, seen.map, metal::level(level_1));
    metal::float3 base_1 = _e55.xyz;
    uint _e59 = frame.shading;
    if (_e59 == 0u) {
        return base_1;
    }
    metal::float4 _e65 = normals.sample(smooth_sampler, uv, seen.map, metal::level(level_1));
    metal::float2 bent = ((_e65.xy * 255.0) - metal::float2(127.0)) / metal::float2(127.0);
    float out_2 = metal::sqrt(metal::max(1.0 - metal::dot(bent, bent), 0.0));
    metal::float3 normal_1 = metal::normalize(((map_11.rows.inner[0].xyz * bent.x) - (map_11.rows.inner[1].xyz * bent.y)) - (map_11.rows.inner[2].xyz * out_2));
    metal::float4 _e101 = emissive.sample(smooth_sampler, uv, seen.map, metal::level(level_1));
    uint _e105 = impostor.emits;
    metal::float3 glow = _e101.xyz * static_cast<float>(_e105);
    metal::float3 _e109 = turned(normal_1, instance_2.rotation);
    metal::float3 _e110 = lit(base_1, _e109, position_1, frame);
    return _e110 + glow;
}
uint naga_mod(uint lhs, uint rhs) {
    return lhs % metal::select(rhs, 1u, rhs == 0u);
}


struct box_vertexInput {
};
struct box_vertexOutput {
    metal::float4 clip [[position]];
    metal::float3 position [[user(loc0), center_perspective]];
    uint instance [[user(loc1), flat]];
};
vertex box_vertexOutput box_vertex(
  uint index [[vertex_id]]
, uint number [[instance_id]]
, constant Frame& frame [[user(fake0)]]
, constant Impostor& impostor [[user(fake0)]]
, device type_7 const& instances [[user(fake0)]]
, constant _mslBufferSizes& _buffer_sizes [[user(fake0)]]
) {
    bool local = {};
    bool local_1 = {};
    bool local_2 = {};
    metal::uint3 bits = metal::uint3(0u);
    metal::float4 clip = {};
    uint face = naga_div(index, 6u);
    uint corner_1 = naga_mod(index, 6u);
    if (!((corner_1 == 1u))) {
        local = corner_1 == 2u;
    } else {
        local = true;
    }
    bool _e14 = local;
    if (!(_e14)) {
        local_1 = corner_1 == 4u;
    } else {
        local_1 = true;
    }
    bool _e21 = local_1;
    if (!((corner_1 == 2u))) {
        local_2 = corner_1 >= 4u;
    } else {
        local_2 = true;
    }
    bool _e31 = local_2;
    metal::uint2 across = metal::uint2(static_cast<uint>(_e21), static_cast<uint>(_e31));
    uint axis = face >> 1u;
    uint side = face & 1u;
    metal::uint2 along = (side == 1u) ? across : across.yx;
    bits[axis] = side;
    bits[naga_mod(axis + 1u, 3u)] = along.x;
    bits[naga_mod(axis + 2u, 3u)] = along.y;
    metal::uint3 _e58 = bits;
    metal::float4 _e67 = impostor.extent;
    metal::float3 position_2 = ((static_cast<metal::float3>(_e58) * 2.0) - metal::float3(1.0)) * _e67.xyz;
    Instance instance_3 = instances[number];
    metal::float4 _e77 = impostor.centre;
    metal::float3 _e81 = turned(position_2 + _e77.xyz, instance_3.rotation);
    metal::float3 world = instance_3.place.xyz + (_e81 * instance_3.place.w);
    metal::float4x4 _e88 = frame.clip;
    clip = _e88 * metal::float4(world, 1.0);
    float _e95 = clip.w;
    clip.z = 0.5 * _e95;
    metal::float4 _e98 = clip;
    const auto _tmp = Proxy {_e98, position_2, number};
    return box_vertexOutput { _tmp.clip, _tmp.position, _tmp.instance };
}


struct ori_fragmentInput {
    metal::float3 position_2 [[user(loc0), center_perspective]];
    uint instance_3 [[user(loc1), flat]];
};
struct ori_fragmentOutput {
    metal::float4 color [[color(0)]];
    float depth [[depth(any)]];
};
fragment ori_fragmentOutput ori_fragment(
  ori_fragmentInput varyings_1 [[stage_in]]
, metal::float4 clip_1 [[position]]
, constant Frame& frame [[user(fake0)]]
, constant Impostor& impostor [[user(fake0)]]
, device type_6 const& maps [[user(fake0)]]
, device type_7 const& instances [[user(fake0)]]
, device type_9 const& ranges [[user(fake0)]]
, metal::texture2d_array<float, metal::access::sample> depth_codes [[user(fake0)]]
, metal::texture2d_array<float, metal::access::sample> color [[user(fake0)]]
, metal::texture2d_array<float, metal::access::sample> normals [[user(fake0)]]
, metal::texture2d_array<float, metal::access::sample> emissive [[user(fake0)]]
, metal::sampler smooth_sampler [[user(fake0)]]
, constant _mslBufferSizes& _buffer_sizes [[user(fake0)]]
) {
    const Proxy in = { clip_1, varyings_1.position_2, varyings_1.instance_3 };
    metal::float3 direction = {};
    Instance instance_4 = instances[in.instance];
    float scale = instance_4.place.w;
    metal::float4 _e9 = frame.depth;
    metal::float3 _e12 = turned_back(_e9.xyz, instance_4.rotation);
    metal::float4 _e15 = frame.eye;
    float _e22 = frame.eye.w;
    metal::float3 _e26 = turned_back(_e15.xyz - (instance_4.place.xyz * _e22), instance_4.rotation);
    metal::float4 _e32 = impostor.centre;
    metal::float3 from_eye = in.position - ((_e26 / metal::float3(scale)) - _e32.xyz);
    float _e40 = frame.eye.w;
    direction = (_e40 > 0.0) ? from_eye : -(_e26);
    metal::float3 _e45 = direction;
    metal::float3 _e46 = direction;
    direction = _e45 / metal::float3(metal::dot(_e12, _e46));
    metal::float3 _e51 = direction;
    metal::float3 _e56 = direction;
    Ray ray_7 = Ray {in.position - (_e51 * metal::dot(_e12, in.position)), _e56};
    metal::float4 _e62 = impostor.centre;
    metal::float3 _e65 = turned(_e62.xyz, instance_4.rotation);
    metal::float3 centre = instance_4.place.xyz + (_e65 * scale);
    metal::float4 _e70 = frame.depth;
    float middle_1 = metal::dot(_e70, metal::float4(centre, 1.0)) / scale;
    float _e78 = frame.near;
    float _e83 = frame.far;
    Seen _e86 = see(in.instance, ray_7, (_e78 / scale) - middle_1, (_e83 / scale) - middle_1, impostor, maps, instances, ranges, depth_codes, _buffer_sizes);
    if (_e86.map == NO_MAP) {
        metal::discard_fragment();
    }
    metal::float4 _e97 = impostor.centre;
    metal::float3 local_20 = (ray_7.origin + (ray_7.direction * _e86.t)) + _e97.xyz;
    metal::float3 _e103 = turned(local_20, instance_4.rotation);
    metal::float3 position_3 = instance_4.place.xyz + (_e103 * scale);
    metal::float4x4 _e108 = frame.clip;
    metal::float4 clip_2 = _e108 * metal::float4(position_3, 1.0);
    float depth_2 = (middle_1 + _e86.t) * scale;
    metal::float4 _e117 = impostor.centre;
    metal::float3 _e120 = shade(_e86, instance_4, local_20 - _e117.xyz, position_3, depth_2, frame, impostor, maps, color, normals, emissive, smooth_sampler, _buffer_sizes);
    const auto _tmp_1 = Fragment {metal::float4(_e120, 1.0), clip_2.z / clip_2.w};
    return ori_fragmentOutput { _tmp_1.color, _tmp_1.depth };
}
