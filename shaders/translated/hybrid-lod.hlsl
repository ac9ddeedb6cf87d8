struct Frame {
    row_major float4x4 clip_;
};

struct Page {
    float2 scale;
    uint layer;
    int _end_pad_0;
};

struct Fragment {
    float4 clip_ : SV_Position;
    float3 ratios : LOC0;
};

cbuffer frame : register(b0) { Frame frame; }
Texture2DArray<float4> pages : register(t1);
SamplerState nagaSamplerHeap[2048]: register(s0, space0);
SamplerComparisonState nagaComparisonSamplerHeap[2048]: register(s0, space1);
StructuredBuffer<uint> nagaGroup0SamplerIndexArray : register(t0, space255);
static const SamplerState smooth_sampler = nagaSamplerHeap[nagaGroup0SamplerIndexArray[2]];
cbuffer page : register(b0, space1) { Page page; }

struct VertexOutput_cell_vertex {
    float3 ratios : LOC0;
    float4 clip_ : SV_Position;
};

struct FragmentInput_cell_fragment {
    float3 ratios_1 : LOC0;
    float4 clip_1 : SV_Position;
};

Fragment ConstructFragment(float4 arg0, float3 arg1) {
    Fragment ret = (Fragment)0;
    ret.clip_ = arg0;
    ret.ratios = arg1;
    return ret;
}

VertexOutput_cell_vertex cell_vertex(float3 position : LOC0, float2 uv : LOC1, float depth : LOC2)
{
    float2 _e5 = page.scale;
    float3 ratios_2 = (float3((uv * _e5), 1.0) * depth);
    float4x4 _e12 = frame.clip_;
    const Fragment fragment = ConstructFragment(mul(float4(position, 1.0), _e12), ratios_2);
    const VertexOutput_cell_vertex fragment_1 = { fragment.ratios, fragment.clip_ };
    return fragment_1;
}

float4 cell_fragment(FragmentInput_cell_fragment fragmentinput_cell_fragment) : SV_Target0
{
    Fragment in_ = { fragmentinput_cell_fragment.clip_1, fragmentinput_cell_fragment.ratios_1 };
    float2 at = (in_.ratios.xy / (in_.ratios.z).xx);
    uint _e11 = page.layer;
    float4 _e12 = pages.Sample(smooth_sampler, float3(at, _e11));
    return float4(_e12.xyz, 1.0);
}
