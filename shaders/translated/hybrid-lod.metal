// language: metal2.0
#include <metal_stdlib>
#include <simd/simd.h>

using metal::uint;

struct Frame {
    metal::float4x4 clip;
};
struct Page {
    metal::float2 scale;
    uint layer;
    char _pad2[4];
};
struct Fragment {
    metal::float4 clip;
    metal::float3 ratios;
};

struct cell_vertexInput {
    metal::float3 position [[attribute(0)]];
    metal::float2 uv [[attribute(1)]];
    float depth [[attribute(2)]];
};
struct cell_vertexOutput {
    metal::float4 clip [[position]];
    metal::float3 ratios [[user(loc0), center_perspective]];
};
vertex cell_vertexOutput cell_vertex(
  cell_vertexInput varyings [[stage_in]]
, constant Frame& frame [[user(fake0)]]
, constant Page& page [[user(fake0)]]
) {
    const auto position = varyings.position;
    const auto uv = varyings.uv;
    const auto depth = varyings.depth;
    metal::float2 _e5 = page.scale;
    metal::float3 ratios = metal::float3(uv * _e5, 1.0) * depth;
    metal::float4x4 _e12 = frame.clip;
    const auto _tmp = Fragment {_e12 * metal::float4(position, 1.0), ratios};
    return cell_vertexOutput { _tmp.clip, _tmp.ratios };
}


struct cell_fragmentInput {
    metal::float3 ratios [[user(loc0), center_perspective]];
};
struct cell_fragmentOutput {
    metal::float4 member_1 [[color(0)]];
};
fragment cell_fragmentOutput cell_fragment(
  cell_fragmentInput varyings_1 [[stage_in]]
, metal::float4 clip [[position]]
, metal::texture2d_array<float, metal::access::sample> pages [[user(fake0)]]
, metal::sampler smooth_sampler [[user(fake0)]]
, constant Page& page [[user(fake0)]]
) {
    const Fragment in = { clip, varyings_1.ratios };
    metal::float2 at = in.ratios.xy / metal::float2(in.ratios.z);
    uint _e11 = page.layer;
    metal::float4 _e12 = pages.sample(smooth_sampler, at, _e11);
    return cell_fragmentOutput { metal::float4(_e12.xyz, 1.0) };
}
