// language: metal2.0
#include <metal_stdlib>
#include <simd/simd.h>

using metal::uint;

struct Frame {
    metal::float4x4 clip;
    metal::float4 depth;
    metal::float4 eye;
    metal::float4 to_sun;
    metal::float4 sun;
    metal::float4 sky;
    metal::float4 ground;
    metal::float4 background;
    uint shading;
    float period;
    uint samples;
    uint layers;
};
struct Reference {
    metal::float4 texel;
    float spread;
    float slack;
    float weight;
    float quality;
    float mapped;
    char _pad6[12];
};
struct Depth {
    metal::float4 clip;
    float depth;
    char _pad2[12];
};
struct Fragment {
    metal::float4 clip;
    metal::float3 position;
    metal::float3 normal;
    metal::packed_float3 ratios;
    float quality;
    float depth;
    char _pad6[12];
};

metal::float3 lit(
    metal::float3 base,
    metal::float3 normal_1,
    metal::float3 position_2,
    constant Frame& frame
) {
    metal::float3 color_1 = {};
    bool local_1 = {};
    metal::float4 _e5 = frame.to_sun;
    float sun = metal::max(metal::dot(normal_1, _e5.xyz), 0.0);
    metal::float4 _e12 = frame.ground;
    metal::float4 _e16 = frame.sky;
    metal::float3 ambient = metal::mix(_e12.xyz, _e16.xyz, 0.5 + (0.5 * normal_1.y));
    metal::float4 _e26 = frame.sun;
    color_1 = base * ((_e26.xyz * sun) + ambient);
    float _e35 = frame.sun.w;
    if (_e35 > 0.0) {
        local_1 = sun > 0.0;
    } else {
        local_1 = false;
    }
    bool _e43 = local_1;
    if (_e43) {
        metal::float4 _e46 = frame.eye;
        float _e51 = frame.eye.w;
        metal::float3 to_eye = metal::normalize(_e46.xyz - (position_2 * _e51));
        metal::float4 _e57 = frame.to_sun;
        metal::float3 h_1 = metal::normalize(_e57.xyz + to_eye);
        metal::float3 _e61 = color_1;
        metal::float4 _e64 = frame.sun;
        float _e69 = frame.sun.w;
        float _e76 = frame.to_sun.w;
        color_1 = _e61 + (_e64.xyz * ((_e69 * metal::pow(metal::max(metal::dot(normal_1, h_1), 0.0), _e76)) * sun));
    }
    metal::float3 _e82 = color_1;
    return _e82;
}

float hash(
    metal::uint3 p,
    uint seed
) {
    uint h = {};
    uint k_1 = 0u;
    h = seed;
    uint2 loop_bound = uint2(4294967295u);
    bool loop_init = true;
    while(true) {
        if (metal::all(loop_bound == uint2(0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        if (!loop_init) {
            uint _e27 = k_1;
            k_1 = _e27 + 1u;
        }
        loop_init = false;
        uint _e5 = k_1;
        if (_e5 < 3u) {
        } else {
            break;
        }
        {
            uint _e8 = h;
            uint _e9 = k_1;
            h = (_e8 ^ p[_e9]) * 2246822507u;
            uint _e14 = h;
            uint _e15 = h;
            h = (_e14 ^ (_e15 >> 13u)) * 3266489909u;
            uint _e21 = h;
            uint _e22 = h;
            h = _e21 ^ (_e22 >> 16u);
        }
    }
    uint _e29 = h;
    return static_cast<float>(_e29 >> 8u) / 16777216.0;
}

metal::int3 naga_f2i32(metal::float3 value) {
    return static_cast<metal::int3>(metal::clamp(value, -2147483600.0, 2147483500.0));
}

float octave(
    metal::float3 p_1,
    uint seed_1
) {
    metal::float3 t = {};
    float sum_1 = 0.0;
    uint corner = 0u;
    metal::float3 cell = metal::floor(p_1);
    t = p_1 - cell;
    metal::float3 _e5 = t;
    metal::float3 _e6 = t;
    metal::float3 _e8 = t;
    t = (_e5 * _e6) * (metal::float3(3.0) - (2.0 * _e8));
    metal::uint3 first = as_type<metal::uint3>(naga_f2i32(cell));
    uint2 loop_bound_1 = uint2(4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (metal::all(loop_bound_1 == uint2(0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e54 = corner;
            corner = _e54 + 1u;
        }
        loop_init_1 = false;
        uint _e21 = corner;
        if (_e21 < 8u) {
        } else {
            break;
        }
        {
            uint _e24 = corner;
            uint _e27 = corner;
            uint _e32 = corner;
            metal::uint3 bits = metal::uint3(_e24 & 1u, (_e27 >> 1u) & 1u, _e32 >> 2u);
            metal::float3 _e36 = t;
            metal::float3 _e40 = t;
            metal::float3 side = metal::mix(metal::float3(1.0) - _e36, _e40, static_cast<metal::float3>(bits));
            float _e43 = sum_1;
            float _e50 = hash(first + bits, seed_1);
            sum_1 = _e43 + (((side.x * side.y) * side.z) * _e50);
        }
    }
    float _e56 = sum_1;
    return _e56;
}

float noise(
    metal::float3 position_3,
    constant Frame& frame
) {
    float _e3 = frame.period;
    metal::float3 q = position_3 / metal::float3(_e3);
    float _e7 = octave(q, 0u);
    float _e15 = octave(q * 4.0, 1u);
    return (0.05 + (0.6 * _e7)) + (0.3 * _e15);
}

metal::float3 shade(
    metal::float3 base_1,
    metal::float3 normal_2,
    metal::float3 position_4,
    constant Frame& frame
) {
    uint _e5 = frame.shading;
    switch(_e5) {
        case 1u: {
            metal::float3 _e6 = lit(base_1, normal_2, position_4, frame);
            return _e6;
        }
        case 2u: {
            float _e7 = noise(position_4, frame);
            return base_1 * _e7;
        }
        default: {
            return base_1;
        }
    }
}

struct depth_vertexInput {
    metal::float3 position [[attribute(0)]];
};
struct depth_vertexOutput {
    metal::float4 clip [[position]];
    float depth [[user(loc0), center_perspective]];
};
vertex depth_vertexOutput depth_vertex(
  depth_vertexInput varyings [[stage_in]]
, constant Frame& frame [[user(fake0)]]
) {
    const auto position = varyings.position;
    metal::float4 p_2 = metal::float4(position, 1.0);
    metal::float4x4 _e5 = frame.clip;
    metal::float4 _e9 = frame.depth;
    const auto _tmp = Depth {_e5 * p_2, metal::dot(_e9, p_2)};
    return depth_vertexOutput { _tmp.clip, _tmp.depth };
}


struct depth_fragmentInput {
    float depth [[user(loc0), center_perspective]];
};
struct depth_fragmentOutput {
    metal::float4 member_1 [[color(0)]];
};
fragment depth_fragmentOutput depth_fragment(
  depth_fragmentInput varyings_1 [[stage_in]]
, metal::float4 clip [[position]]
) {
    const Depth in = { clip, varyings_1.depth };
    return depth_fragmentOutput { metal::float4(in.depth, 0.0, 0.0, 0.0) };
}


struct color_vertexInput {
    metal::float3 position_1 [[attribute(0)]];
    metal::float3 normal [[attribute(1)]];
    metal::float2 uv [[attribute(2)]];
    float quality [[attribute(3)]];
};
struct color_vertexOutput {
    metal::float4 clip [[position]];
    metal::float3 position [[user(loc0), center_perspective]];
    metal::float3 normal [[user(loc1), center_perspective]];
    metal::float3 ratios [[user(loc2), center_perspective]];
    float quality [[user(loc3), center_perspective]];
    float depth [[user(loc4), center_perspective]];
};
vertex color_vertexOutput color_vertex(
  color_vertexInput varyings_2 [[stage_in]]
, constant Frame& frame [[user(fake0)]]
, constant Reference& reference [[user(fake0)]]
) {
    const auto position_1 = varyings_2.position_1;
    const auto normal = varyings_2.normal;
    const auto uv = varyings_2.uv;
    const auto quality = varyings_2.quality;
    metal::float4 p_3 = metal::float4(position_1, 1.0);
    metal::float4 _e10 = reference.texel;
    metal::float3 ratios = metal::float3(uv, 1.0) * metal::dot(_e10, p_3);
    metal::float4x4 _e15 = frame.clip;
    metal::float4 _e19 = frame.depth;
    const auto _tmp_1 = Fragment {_e15 * p_3, position_1, normal, ratios, quality, metal::dot(_e19, p_3)};
    return color_vertexOutput { _tmp_1.clip, _tmp_1.position, _tmp_1.normal, _tmp_1.ratios, _tmp_1.quality, _tmp_1.depth };
}

metal::int2 naga_f2i32(metal::float2 value) {
    return static_cast<metal::int2>(metal::clamp(value, -2147483600.0, 2147483500.0));
}


struct color_fragmentInput {
    metal::float3 position_5 [[user(loc0), center_perspective]];
    metal::float3 normal_3 [[user(loc1), center_perspective]];
    metal::float3 ratios [[user(loc2), center_perspective]];
    float quality_1 [[user(loc3), center_perspective]];
    float depth [[user(loc4), center_perspective]];
};
struct color_fragmentOutput {
    metal::float4 member_3 [[color(0)]];
};
fragment color_fragmentOutput color_fragment(
  color_fragmentInput varyings_3 [[stage_in]]
, metal::float4 clip_1 [[position]]
, bool facing [[front_facing]]
, constant Frame& frame [[user(fake0)]]
, constant Reference& reference [[user(fake0)]]
, metal::texture2d<float, metal::access::sample> front [[user(fake0)]]
, metal::texture2d<float, metal::access::sample> picture [[user(fake0)]]
, metal::texture2d<float, metal::access::sample> normal_map [[user(fake0)]]
, metal::sampler smooth_sampler [[user(fake0)]]
) {
    const Fragment in_1 = { clip_1, varyings_3.position_5, varyings_3.normal_3, varyings_3.ratios, varyings_3.quality_1, varyings_3.depth };
    bool local = {};
    metal::float2 size = static_cast<metal::float2>(metal::uint2(picture.get_width(), picture.get_height()));
    metal::float2 uv_1 = metal::float3(in_1.ratios).xy / metal::float2(in_1.ratios[2]);
    metal::float2 _e11 = metal::dfdx(uv_1);
    metal::float2 dx = _e11 * size;
    metal::float2 _e13 = metal::dfdy(uv_1);
    metal::float2 dy = _e13 * size;
    float level = 0.5 * metal::log2(metal::max(metal::max(metal::dot(dx, dx), metal::dot(dy, dy)), 1.0));
    metal::float4 _e25 = picture.sample(smooth_sampler, uv_1, metal::level(level));
    metal::float3 base_2 = _e25.xyz;
    metal::float4 _e29 = normal_map.sample(smooth_sampler, uv_1, metal::level(level));
    metal::float3 mapped = (_e29.xyz * 2.0) - metal::float3(1.0);
    float _e39 = reference.mapped;
    if (_e39 > 0.0) {
        local = metal::dot(mapped, mapped) > 0.0;
    } else {
        local = false;
    }
    bool _e48 = local;
    metal::float3 bent = _e48 ? mapped : in_1.normal;
    metal::float3 normal_3 = metal::normalize(facing ? bent : -(bent));
    float _e56 = reference.quality;
    float quality_1 = metal::mix(1.0, in_1.quality, _e56);
    float _e61 = reference.slack;
    float _e64 = reference.spread;
    float offset = _e61 + (_e64 * in_1.ratios[2]);
    metal::float4 _e75 = front.read(metal::uint2(naga_f2i32(in_1.clip.xy)), 0);
    if (in_1.depth > (_e75.x + offset)) {
        metal::discard_fragment();
    }
    metal::float3 _e80 = shade(base_2, normal_3, in_1.position, frame);
    float _e83 = reference.weight;
    return color_fragmentOutput { metal::float4(_e80, metal::max(_e83 * quality_1, 0.000061035156)) };
}


struct screen_vertexInput {
};
struct screen_vertexOutput {
    metal::float4 member_4 [[position]];
};
vertex screen_vertexOutput screen_vertex(
  uint index [[vertex_id]]
) {
    metal::float2 corner_1 = static_cast<metal::float2>(metal::uint2(index & 1u, index >> 1u));
    return screen_vertexOutput { metal::float4((corner_1 * 4.0) - metal::float2(1.0), 0.0, 1.0) };
}

int naga_mod(int lhs, int rhs) {
    int divisor = metal::select(rhs, 1, (lhs == (-2147483647 - 1) & rhs == -1) | (rhs == 0));
    return lhs - (lhs / divisor) * divisor;
}

int naga_div(int lhs, int rhs) {
    return lhs / metal::select(rhs, 1, (lhs == (-2147483647 - 1) & rhs == -1) | (rhs == 0));
}


struct combine_fragmentInput {
};
struct combine_fragmentOutput {
    metal::float4 member_5 [[color(0)]];
};
fragment combine_fragmentOutput combine_fragment(
  metal::float4 at [[position]]
, constant Frame& frame [[user(fake0)]]
, metal::texture2d_array<float, metal::access::sample> images [[user(fake0)]]
) {
    metal::float3 sum = metal::float3(0.0);
    int i = 0;
    metal::float3 color = {};
    float alpha = {};
    uint k = {};
    uint _e3 = frame.samples;
    int n = static_cast<int>(_e3);
    metal::int2 first_1 = as_type<metal::int2>(as_type<metal::uint2>(naga_f2i32(at.xy)) * as_type<uint>(n));
    uint2 loop_bound_2 = uint2(4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (metal::all(loop_bound_2 == uint2(0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
        if (!loop_init_2) {
            int _e65 = i;
            i = as_type<int>(as_type<uint>(_e65) + as_type<uint>(1));
        }
        loop_init_2 = false;
        int _e13 = i;
        if (_e13 < as_type<int>(as_type<uint>(n) * as_type<uint>(n))) {
        } else {
            break;
        }
        {
            int _e16 = i;
            int _e18 = i;
            metal::int2 sample = as_type<metal::int2>(as_type<metal::uint2>(first_1) + as_type<metal::uint2>(metal::int2(naga_mod(_e16, n), naga_div(_e18, n))));
            color = metal::float3(0.0);
            alpha = 0.0;
            k = 0u;
            uint2 loop_bound_3 = uint2(4294967295u);
            bool loop_init_3 = true;
            while(true) {
                if (metal::all(loop_bound_3 == uint2(0u))) { break; }
                loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
                if (!loop_init_3) {
                    uint _e47 = k;
                    k = _e47 + 1u;
                }
                loop_init_3 = false;
                uint _e29 = k;
                uint _e32 = frame.layers;
                if (_e29 < _e32) {
                } else {
                    break;
                }
                {
                    uint _e35 = k;
                    metal::float4 c = images.read(metal::uint2(sample), _e35, 0);
                    metal::float3 _e38 = color;
                    color = _e38 + (c.xyz * c.w);
                    float _e43 = alpha;
                    alpha = _e43 + c.w;
                }
            }
            float _e49 = alpha;
            if (_e49 > 0.0) {
                metal::float3 _e52 = sum;
                metal::float3 _e53 = color;
                float _e54 = alpha;
                sum = _e52 + (_e53 / metal::float3(_e54));
            } else {
                metal::float3 _e58 = sum;
                metal::float4 _e61 = frame.background;
                sum = _e58 + _e61.xyz;
            }
        }
    }
    metal::float3 _e67 = sum;
    return combine_fragmentOutput { metal::float4(_e67 / metal::float3(static_cast<float>(as_type<int>(as_type<uint>(n) * as_type<uint>(n)))), 1.0) };
}
