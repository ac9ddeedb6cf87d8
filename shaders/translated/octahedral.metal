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
    uint shading;
    float sample_size;
    char _pad9[8];
};
struct type_4 {
    metal::float4 inner[4];
};
struct Impostor {
    metal::float4 window;
    type_4 card;
    uint corners;
    uint frames;
    uint tile;
    uint levels;
    uint hemi;
    uint steps;
    uint emits;
    char _pad9[4];
};
struct Card {
    metal::float4 clip;
    metal::float3 position;
};
struct Blend {
    metal::float3 color;
    metal::float3 normal;
    metal::packed_float3 emissive;
    float t;
    float coverage;
    float weight;
    char _pad6[8];
};
struct Camera {
    metal::float2 point;
    char _pad1[8];
    metal::float3 right;
    metal::float3 up;
    metal::float3 start;
    metal::packed_float3 ray;
    float middle;
    float slope;
    float level;
    float edge;
    char _pad9[4];
};
struct Met {
    metal::float2 atlas;
    bool covered;
    char _pad2[3];
    float gap;
    bool below;
    char _pad4[7];
};
struct Fragment {
    metal::float4 color;
    float depth;
    char _pad2[12];
};
constant uint BISECTIONS = 5u;

metal::float3 towards_eye(
    constant Frame& frame,
    constant Impostor& impostor
) {
    float _e3 = frame.eye.w;
    if (_e3 > 0.0) {
        metal::float4 _e8 = frame.eye;
        metal::float4 _e12 = impostor.window;
        return metal::normalize(_e8.xyz - _e12.xyz);
    }
    metal::float4 _e18 = frame.eye;
    return _e18.xyz;
}

metal::float3 right_of(
    metal::float3 d
) {
    if (metal::dot(d.xz, d.xz) < 0.000000000001) {
        return metal::normalize(metal::cross(metal::float3(0.0, 0.0, 1.0), d));
    }
    return metal::normalize(metal::cross(metal::float3(0.0, 1.0, 0.0), d));
}

metal::float2 sign_of(
    metal::float2 v
) {
    return metal::select(metal::float2(1.0), metal::float2(-1.0), v < metal::float2(0.0));
}

metal::float2 grid_of(
    metal::float3 direction,
    constant Impostor& impostor
) {
    metal::float3 d_1 = {};
    metal::float2 e = {};
    uint _e3 = impostor.frames;
    float last = static_cast<float>(_e3 - 1u);
    d_1 = direction;
    uint _e10 = impostor.hemi;
    if (_e10 > 0u) {
        float _e15 = d_1.y;
        d_1.y = metal::max(_e15, 0.001);
    }
    metal::float3 _e18 = d_1;
    float _e20 = d_1.x;
    float _e23 = d_1.y;
    float _e27 = d_1.z;
    metal::float3 p = _e18 / metal::float3((metal::abs(_e20) + metal::abs(_e23)) + metal::abs(_e27));
    e = p.xz;
    uint _e36 = impostor.hemi;
    if (_e36 > 0u) {
        e = metal::float2(p.x + p.z, p.x - p.z);
    } else {
        if (p.y < 0.0) {
            metal::float2 _e55 = sign_of(p.xz);
            e = (metal::float2(1.0) - metal::abs(p.zx)) * _e55;
        }
    }
    metal::float2 _e57 = e;
    return metal::clamp(((_e57 * 0.5) + metal::float2(0.5)) * last, metal::float2(0.0), metal::float2(last));
}

metal::float3 direction_of(
    metal::float2 point,
    constant Impostor& impostor
) {
    uint _e3 = impostor.frames;
    metal::float2 e_1 = ((point / metal::float2(static_cast<float>(_e3 - 1u))) * 2.0) - metal::float2(1.0);
    uint _e16 = impostor.hemi;
    if (_e16 > 0u) {
        metal::float2 p_1 = metal::float2(e_1.x + e_1.y, e_1.x - e_1.y) * 0.5;
        return metal::normalize(metal::float3(p_1.x, metal::max((1.0 - metal::abs(p_1.x)) - metal::abs(p_1.y), 0.0), p_1.y));
    }
    float y = (1.0 - metal::abs(e_1.x)) - metal::abs(e_1.y);
    metal::float2 _e53 = sign_of(e_1);
    metal::float2 p_2 = (y < 0.0) ? ((metal::float2(1.0) - metal::abs(e_1.yx)) * _e53) : e_1;
    return metal::normalize(metal::float3(p_2.x, y, p_2.y));
}

Met look(
    Camera camera,
    float height,
    constant Impostor& impostor,
    metal::texture2d<float, metal::access::sample> color_atlas,
    metal::texture2d<float, metal::access::sample> normal_atlas,
    metal::sampler smooth_sampler
) {
    bool local_1 = {};
    metal::float3 p_3 = camera.start + (camera.ray * (camera.middle + (height / camera.slope)));
    metal::float2 uv = metal::float2(metal::dot(p_3, camera.right) + 1.0, 1.0 - metal::dot(p_3, camera.up)) * 0.5;
    uint _e32 = impostor.frames;
    metal::float2 atlas = (camera.point + metal::clamp(uv, metal::float2(camera.edge), metal::float2(1.0 - camera.edge))) / metal::float2(static_cast<float>(_e32));
    if (!(metal::any(uv < metal::float2(0.0)))) {
        local_1 = metal::any(uv > metal::float2(1.0));
    } else {
        local_1 = true;
    }
    bool _e48 = local_1;
    if (_e48) {
        return Met {atlas, false, {}, 0.0, false};
    }
    metal::float4 _e56 = color_atlas.sample(smooth_sampler, atlas, metal::level(camera.level));
    if (_e56.w < 0.5) {
        return Met {atlas, false, {}, 0.0, false};
    }
    metal::float4 _e67 = normal_atlas.sample(smooth_sampler, atlas, metal::level(camera.level));
    float gap = height - ((_e67.w * 2.0) - 1.0);
    return Met {atlas, true, {}, gap, gap < 0.0};
}

uint naga_f2u32(float value) {
    return static_cast<uint>(metal::clamp(value, 0.0, 4294967000.0));
}

void add(
    thread Blend& blend_1,
    metal::float2 point_1,
    float weight,
    metal::float3 origin,
    metal::float3 ray_1,
    float depth,
    constant Frame& frame,
    constant Impostor& impostor,
    metal::texture2d<float, metal::access::sample> color_atlas,
    metal::texture2d<float, metal::access::sample> normal_atlas,
    metal::texture2d<float, metal::access::sample> emissive_atlas,
    metal::sampler smooth_sampler
) {
    bool local_2 = {};
    Met met = {};
    bool hidden = false;
    bool found = false;
    Met before = {};
    uint i = 1u;
    bool local_3 = {};
    float high = {};
    float low = {};
    bool local_4 = {};
    bool above = {};
    uint k = {};
    bool local_5 = {};
    bool local_6 = {};
    metal::float3 _e6 = direction_of(point_1, impostor);
    float slope = metal::dot(ray_1, _e6);
    if (!((weight <= 0.0))) {
        local_2 = slope > (-0.05 * metal::length(ray_1));
    } else {
        local_2 = true;
    }
    bool _e18 = local_2;
    if (_e18) {
        return;
    }
    float _e20 = blend_1.weight;
    blend_1.weight = _e20 + weight;
    metal::float3 _e22 = right_of(_e6);
    metal::float3 up = metal::cross(_e6, _e22);
    float radius = impostor.window.w;
    metal::float4 _e30 = impostor.window;
    metal::float3 start = origin - _e30.xyz;
    float middle = -(metal::dot(start, _e6)) / slope;
    float _e40 = frame.eye.w;
    float far = (_e40 > 0.0) ? (depth + middle) : 1.0;
    float _e47 = frame.sample_size;
    uint _e51 = impostor.tile;
    float texels = ((_e47 * far) * static_cast<float>(_e51)) / (2.0 * radius);
    uint _e62 = impostor.levels;
    float level = metal::clamp(metal::log2(metal::max(texels, 1.0)), 0.0, static_cast<float>(_e62 - 1u));
    uint _e70 = impostor.tile;
    float edge = 0.5 / static_cast<float>(_e70 >> naga_f2u32(metal::ceil(level)));
    Camera camera_1 = Camera {point_1, {}, _e22, up, start / metal::float3(radius), ray_1 / metal::float3(radius), middle, slope / radius, level, edge};
    Met _e84 = look(camera_1, 0.0, impostor, color_atlas, normal_atlas, smooth_sampler);
    met = _e84;
    uint _e88 = impostor.steps;
    if (_e88 > 0u) {
        uint _e96 = impostor.tile;
        float wall = (6.0 * metal::exp2(level)) / static_cast<float>(_e96);
        Met _e104 = look(camera_1, 1.0, impostor, color_atlas, normal_atlas, smooth_sampler);
        before = _e104;
        uint2 loop_bound = uint2(4294967295u);
        bool loop_init = true;
        while(true) {
            if (metal::all(loop_bound == uint2(0u))) { break; }
            loop_bound -= uint2(loop_bound.y == 0u, 1u);
            if (!loop_init) {
                uint _e193 = i;
                i = _e193 + 1u;
            }
            loop_init = false;
            uint _e108 = i;
            uint _e111 = impostor.steps;
            if (_e108 <= _e111) {
                bool _e115 = found;
                local_3 = !(_e115);
            } else {
                local_3 = false;
            }
            bool _e118 = local_3;
            if (_e118) {
            } else {
                break;
            }
            {
                uint _e119 = i;
                uint _e127 = impostor.steps;
                high = 1.0 - ((2.0 * static_cast<float>(_e119 - 1u)) / static_cast<float>(_e127));
                uint _e133 = i;
                uint _e139 = impostor.steps;
                low = 1.0 - ((2.0 * static_cast<float>(_e133)) / static_cast<float>(_e139));
                float _e145 = low;
                Met _e146 = look(camera_1, _e145, impostor, color_atlas, normal_atlas, smooth_sampler);
                if (_e146.below) {
                    bool _e151 = before.below;
                    local_4 = !(_e151);
                } else {
                    local_4 = false;
                }
                bool _e154 = local_4;
                if (_e154) {
                    bool _e156 = before.covered;
                    above = _e156;
                    met = _e146;
                    k = 0u;
                    uint2 loop_bound_1 = uint2(4294967295u);
                    bool loop_init_1 = true;
                    while(true) {
                        if (metal::all(loop_bound_1 == uint2(0u))) { break; }
                        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
                        if (!loop_init_1) {
                            uint _e172 = k;
                            k = _e172 + 1u;
                        }
                        loop_init_1 = false;
                        uint _e160 = k;
                        if (_e160 < BISECTIONS) {
                        } else {
                            break;
                        }
                        {
                            float _e163 = high;
                            float _e164 = low;
                            float half_ = (_e163 + _e164) * 0.5;
                            Met _e168 = look(camera_1, half_, impostor, color_atlas, normal_atlas, smooth_sampler);
                            if (_e168.below) {
                                low = half_;
                                met = _e168;
                            } else {
                                high = half_;
                                above = _e168.covered;
                            }
                        }
                    }
                    bool _e174 = above;
                    if (!(_e174)) {
                        float _e179 = met.gap;
                        local_5 = -(_e179) <= wall;
                    } else {
                        local_5 = true;
                    }
                    bool _e183 = local_5;
                    found = _e183;
                    bool _e184 = hidden;
                    if (!(_e184)) {
                        bool _e188 = found;
                        local_6 = !(_e188);
                    } else {
                        local_6 = true;
                    }
                    bool _e191 = local_6;
                    hidden = _e191;
                }
                before = _e146;
            }
        }
        bool _e195 = found;
        if (!(_e195)) {
            float _e198 = blend_1.weight;
            bool _e199 = hidden;
            blend_1.weight = _e198 - (_e199 ? weight : 0.0);
            return;
        }
    } else {
        bool _e204 = met.covered;
        if (!(_e204)) {
            return;
        }
    }
    metal::float2 _e209 = met.atlas;
    metal::float4 data = normal_atlas.sample(smooth_sampler, _e209, metal::level(level));
    float t = middle + ((((data.w * 2.0) - 1.0) * radius) / slope);
    float _e220 = blend_1.coverage;
    blend_1.coverage = _e220 + weight;
    float _e223 = blend_1.t;
    blend_1.t = _e223 + (t * weight);
    metal::float3 _e227 = blend_1.color;
    metal::float2 _e231 = met.atlas;
    metal::float4 _e232 = color_atlas.sample(smooth_sampler, _e231, metal::level(level));
    blend_1.color = _e227 + (_e232.xyz * weight);
    metal::float3 _e237 = blend_1.normal;
    blend_1.normal = _e237 + (((data.xyz * 2.0) - metal::float3(1.0)) * weight);
    metal::float3 _e247 = blend_1.emissive;
    metal::float2 _e251 = met.atlas;
    metal::float4 _e252 = emissive_atlas.sample(smooth_sampler, _e251, metal::level(level));
    uint _e256 = impostor.emits;
    blend_1.emissive = _e247 + (_e252.xyz * (weight * static_cast<float>(_e256)));
    return;
}

metal::float3 lit(
    metal::float3 base,
    metal::float3 normal,
    metal::float3 position,
    constant Frame& frame
) {
    metal::float3 color_1 = {};
    bool local_7 = {};
    metal::float4 _e5 = frame.to_sun;
    float sun = metal::max(metal::dot(normal, _e5.xyz), 0.0);
    metal::float4 _e12 = frame.ground;
    metal::float4 _e16 = frame.sky;
    metal::float3 ambient = metal::mix(_e12.xyz, _e16.xyz, 0.5 + (0.5 * normal.y));
    metal::float4 _e26 = frame.sun;
    color_1 = base * ((_e26.xyz * sun) + ambient);
    float _e35 = frame.sun.w;
    if (_e35 > 0.0) {
        local_7 = sun > 0.0;
    } else {
        local_7 = false;
    }
    bool _e43 = local_7;
    if (_e43) {
        metal::float4 _e46 = frame.eye;
        float _e51 = frame.eye.w;
        metal::float3 to_eye = metal::normalize(_e46.xyz - (position * _e51));
        metal::float4 _e57 = frame.to_sun;
        metal::float3 h = metal::normalize(_e57.xyz + to_eye);
        metal::float3 _e61 = color_1;
        metal::float4 _e64 = frame.sun;
        float _e69 = frame.sun.w;
        float _e76 = frame.to_sun.w;
        color_1 = _e61 + (_e64.xyz * ((_e69 * metal::pow(metal::max(metal::dot(normal, h), 0.0), _e76)) * sun));
    }
    metal::float3 _e82 = color_1;
    return _e82;
}
uint naga_div(uint lhs, uint rhs) {
    return lhs / metal::select(rhs, 1u, rhs == 0u);
}

uint naga_mod(uint lhs, uint rhs) {
    return lhs % metal::select(rhs, 1u, rhs == 0u);
}


struct card_vertexInput {
};
struct card_vertexOutput {
    metal::float4 clip [[position]];
    metal::float3 position [[user(loc0), center_perspective]];
};
vertex card_vertexOutput card_vertex(
  uint index [[vertex_id]]
, constant Frame& frame [[user(fake0)]]
, constant Impostor& impostor [[user(fake0)]]
) {
    uint triangle = naga_div(index, 3u);
    uint k_1 = naga_mod(index, 3u);
    uint corner = (k_1 == 0u) ? 0u : (triangle + k_1);
    metal::float4 pair = impostor.card.inner[naga_div(corner, 2u)];
    metal::float2 at = ((corner & 1u) == 1u) ? pair.zw : pair.xy;
    metal::float3 _e23 = towards_eye(frame, impostor);
    metal::float3 _e24 = right_of(_e23);
    metal::float3 offset = (_e23 + (_e24 * at.x)) + (metal::cross(_e23, _e24) * at.y);
    metal::float4 _e34 = impostor.window;
    float _e39 = impostor.window.w;
    metal::float3 position_1 = _e34.xyz + (offset * _e39);
    metal::float4x4 _e44 = frame.clip;
    const auto _tmp = Card {_e44 * metal::float4(position_1, 1.0), position_1};
    return card_vertexOutput { _tmp.clip, _tmp.position };
}


struct card_fragmentInput {
    metal::float3 position_1 [[user(loc0), center_perspective]];
};
struct card_fragmentOutput {
    metal::float4 color [[color(0)]];
    float depth [[depth(any)]];
};
fragment card_fragmentOutput card_fragment(
  card_fragmentInput varyings_1 [[stage_in]]
, metal::float4 clip [[position]]
, constant Frame& frame [[user(fake0)]]
, constant Impostor& impostor [[user(fake0)]]
, metal::texture2d<float, metal::access::sample> color_atlas [[user(fake0)]]
, metal::texture2d<float, metal::access::sample> normal_atlas [[user(fake0)]]
, metal::texture2d<float, metal::access::sample> emissive_atlas [[user(fake0)]]
, metal::sampler smooth_sampler [[user(fake0)]]
) {
    const Card in = { clip, varyings_1.position_1 };
    metal::float3 ray = {};
    Blend blend = Blend {metal::float3(0.0), metal::float3(0.0), metal::float3(0.0), 0.0, 0.0, 0.0};
    bool local = {};
    metal::float3 color = {};
    metal::float3 _e1 = towards_eye(frame, impostor);
    metal::float4 _e5 = frame.eye;
    ray = in.position - _e5.xyz;
    float _e12 = frame.eye.w;
    if (_e12 == 0.0) {
        ray = -(_e1);
    }
    metal::float3 _e16 = ray;
    metal::float4 _e19 = frame.depth;
    metal::float3 _e21 = ray;
    ray = _e16 / metal::float3(metal::dot(_e19.xyz, _e21));
    metal::float4 _e27 = frame.depth;
    float depth_1 = metal::dot(_e27, metal::float4(in.position, 1.0));
    metal::float2 _e32 = grid_of(_e1, impostor);
    uint _e36 = impostor.frames;
    metal::float2 cell = metal::min(metal::floor(_e32), metal::float2(static_cast<float>(_e36 - 2u)));
    metal::float2 f = _e32 - cell;
    bool across = f.x >= f.y;
    metal::float2 side = across ? metal::float2(1.0, 0.0) : metal::float2(0.0, 1.0);
    metal::float3 _e70 = ray;
    add(blend, cell, 1.0 - metal::max(f.x, f.y), in.position, _e70, depth_1, frame, impostor, color_atlas, normal_atlas, emissive_atlas, smooth_sampler);
    metal::float3 _e77 = ray;
    add(blend, cell + side, metal::abs(f.x - f.y), in.position, _e77, depth_1, frame, impostor, color_atlas, normal_atlas, emissive_atlas, smooth_sampler);
    metal::float3 _e85 = ray;
    add(blend, cell + metal::float2(1.0), metal::min(f.x, f.y), in.position, _e85, depth_1, frame, impostor, color_atlas, normal_atlas, emissive_atlas, smooth_sampler);
    float _e87 = blend.coverage;
    if (!((_e87 <= 0.0))) {
        float _e94 = blend.coverage;
        float _e96 = blend.weight;
        local = _e94 < (0.5 * _e96);
    } else {
        local = true;
    }
    bool _e101 = local;
    if (_e101) {
        metal::discard_fragment();
    }
    float _e103 = blend.coverage;
    float share = 1.0 / _e103;
    metal::float3 _e107 = ray;
    float _e109 = blend.t;
    metal::float3 position_2 = in.position + (_e107 * (_e109 * share));
    metal::float4x4 _e115 = frame.clip;
    metal::float4 clip_1 = _e115 * metal::float4(position_2, 1.0);
    metal::float3 _e120 = blend.color;
    color = _e120 * share;
    uint _e125 = frame.shading;
    if (_e125 == 1u) {
        metal::float3 _e128 = color;
        metal::float3 _e130 = blend.normal;
        metal::float3 _e132 = lit(_e128, metal::normalize(_e130), position_2, frame);
        metal::float3 _e134 = blend.emissive;
        color = _e132 + (_e134 * share);
    }
    metal::float3 _e137 = color;
    const auto _tmp_1 = Fragment {metal::float4(_e137, 1.0), clip_1.z / clip_1.w};
    return card_fragmentOutput { _tmp_1.color, _tmp_1.depth };
}
