struct Frame {
    row_major float4x4 clip_;
    float4 depth;
    float4 eye;
    float4 to_sun;
    float4 sun;
    float4 sky;
    float4 ground;
    float4 background;
    uint shading;
    float period;
    uint samples;
    uint layers;
};

struct Reference {
    float4 texel;
    float spread;
    float slack;
    float weight;
    float quality;
    float mapped;
    int _end_pad_0;
    int _end_pad_1;
    int _end_pad_2;
};

struct Depth {
    float4 clip_ : SV_Position;
    float depth : LOC0;
};

struct Fragment {
    float4 clip_ : SV_Position;
    float3 position : LOC0;
    float3 normal : LOC1;
    float3 ratios : LOC2;
    float quality : LOC3;
    float depth : LOC4;
};

cbuffer frame : register(b0) { Frame frame; }
cbuffer reference : register(b0, space1) { Reference reference; }
Texture2D<float4> front : register(t1, space1);
Texture2D<float4> picture : register(t2, space1);
Texture2D<float4> normal_map : register(t3, space1);
SamplerState nagaSamplerHeap[2048]: register(s0, space0);
SamplerComparisonState nagaComparisonSamplerHeap[2048]: register(s0, space1);
StructuredBuffer<uint> nagaGroup1SamplerIndexArray : register(t1, space255);
static const SamplerState smooth_sampler = nagaSamplerHeap[nagaGroup1SamplerIndexArray[4]];
Texture2DArray<float4> images : register(t5, space1);

struct VertexOutput_depth_vertex {
    float depth : LOC0;
    float4 clip_ : SV_Position;
};

struct FragmentInput_depth_fragment {
    float depth_1 : LOC0;
    float4 clip_1 : SV_Position;
};

struct VertexOutput_color_vertex {
    float3 position_5 : LOC0;
    float3 normal_3 : LOC1;
    float3 ratios : LOC2;
    float quality_1 : LOC3;
    float depth_2 : LOC4;
    float4 clip_2 : SV_Position;
};

struct FragmentInput_color_fragment {
    float3 position_6 : LOC0;
    float3 normal_4 : LOC1;
    float3 ratios_1 : LOC2;
    float quality_2 : LOC3;
    float depth_3 : LOC4;
    float4 clip_3 : SV_Position;
    bool facing_1 : SV_IsFrontFace;
};

struct FragmentInput_combine_fragment {
    float4 at_1 : SV_Position;
};

float3 lit_(float3 base, float3 normal_1, float3 position_2)
{
    float3 color_1 = (float3)0;
    bool local_1 = (bool)0;

    float4 _e5 = frame.to_sun;
    float sun = max(dot(normal_1, _e5.xyz), 0.0);
    float4 _e12 = frame.ground;
    float4 _e16 = frame.sky;
    float3 ambient = lerp(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal_1.y)));
    float4 _e26 = frame.sun;
    color_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = frame.sun.w;
    if ((_e35 > 0.0)) {
        local_1 = (sun > 0.0);
    } else {
        local_1 = false;
    }
    bool _e43 = local_1;
    if (_e43) {
        float4 _e46 = frame.eye;
        float _e51 = frame.eye.w;
        float3 to_eye = normalize((_e46.xyz - (position_2 * _e51)));
        float4 _e57 = frame.to_sun;
        float3 h_1 = normalize((_e57.xyz + to_eye));
        float3 _e61 = color_1;
        float4 _e64 = frame.sun;
        float _e69 = frame.sun.w;
        float _e76 = frame.to_sun.w;
        color_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal_1, h_1), 0.0), _e76)) * sun)));
    }
    float3 _e82 = color_1;
    return _e82;
}

float hash(uint3 p, uint seed)
{
    uint h = (uint)0;
    uint k_1 = 0u;

    h = seed;
    uint2 loop_bound = uint2(4294967295u, 4294967295u);
    bool loop_init = true;
    while(true) {
        if (all(loop_bound == uint2(0u, 0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        if (!loop_init) {
            uint _e27 = k_1;
            k_1 = (_e27 + 1u);
        }
        loop_init = false;
        uint _e5 = k_1;
        if ((_e5 < 3u)) {
        } else {
            break;
        }
        {
            uint _e8 = h;
            uint _e9 = k_1;
            h = ((_e8 ^ p[min(uint(_e9), 2u)]) * 2246822507u);
            uint _e14 = h;
            uint _e15 = h;
            h = ((_e14 ^ (_e15 >> 13u)) * 3266489909u);
            uint _e21 = h;
            uint _e22 = h;
            h = (_e21 ^ (_e22 >> 16u));
        }
    }
    uint _e29 = h;
    return (float((_e29 >> 8u)) / 16777216.0);
}

int3 naga_f2i32(float3 value) {
    return int3(clamp(value, -2147483600.0, 2147483500.0));
}

float octave(float3 p_1, uint seed_1)
{
    float3 t = (float3)0;
    float sum_1 = 0.0;
    uint corner = 0u;

    float3 cell = floor(p_1);
    t = (p_1 - cell);
    float3 _e5 = t;
    float3 _e6 = t;
    float3 _e8 = t;
    t = ((_e5 * _e6) * ((3.0).xxx - (2.0 * _e8)));
    uint3 first = asuint(naga_f2i32(cell));
    uint2 loop_bound_1 = uint2(4294967295u, 4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (all(loop_bound_1 == uint2(0u, 0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e54 = corner;
            corner = (_e54 + 1u);
        }
        loop_init_1 = false;
        uint _e21 = corner;
        if ((_e21 < 8u)) {
        } else {
            break;
        }
        {
            uint _e24 = corner;
            uint _e27 = corner;
            uint _e32 = corner;
            uint3 bits = uint3((_e24 & 1u), ((_e27 >> 1u) & 1u), (_e32 >> 2u));
            float3 _e36 = t;
            float3 _e40 = t;
            float3 side = lerp(((1.0).xxx - _e36), _e40, float3(bits));
            float _e43 = sum_1;
            const float _e50 = hash((first + bits), seed_1);
            sum_1 = (_e43 + (((side.x * side.y) * side.z) * _e50));
        }
    }
    float _e56 = sum_1;
    return _e56;
}

float noise_(float3 position_3)
{
    float _e3 = frame.period;
    float3 q = (position_3 / (_e3).xxx);
    const float _e7 = octave(q, 0u);
    const float _e15 = octave((q * 4.0), 1u);
    return ((0.05 + (0.6 * _e7)) + (0.3 * _e15));
}

float3 shade(float3 base_1, float3 normal_2, float3 position_4)
{
    uint _e5 = frame.shading;
    switch(_e5) {
        case 1u: {
            const float3 _e6 = lit_(base_1, normal_2, position_4);
            return _e6;
        }
        case 2u: {
            const float _e7 = noise_(position_4);
            return (base_1 * _e7);
        }
        default: {
            return base_1;
        }
    }
}

Depth ConstructDepth(float4 arg0, float arg1) {
    Depth ret = (Depth)0;
    ret.clip_ = arg0;
    ret.depth = arg1;
    return ret;
}

VertexOutput_depth_vertex depth_vertex(float3 position : LOC0)
{
    float4 p_2 = float4(position, 1.0);
    float4x4 _e5 = frame.clip_;
    float4 _e9 = frame.depth;
    const Depth depth_4 = ConstructDepth(mul(p_2, _e5), dot(_e9, p_2));
    const VertexOutput_depth_vertex depth_4_ = { depth_4.depth, depth_4.clip_ };
    return depth_4_;
}

float4 depth_fragment(FragmentInput_depth_fragment fragmentinput_depth_fragment) : SV_Target0
{
    Depth in_ = { fragmentinput_depth_fragment.clip_1, fragmentinput_depth_fragment.depth_1 };
    return float4(in_.depth, 0.0, 0.0, 0.0);
}

Fragment ConstructFragment(float4 arg0, float3 arg1, float3 arg2, float3 arg3, float arg4, float arg5) {
    Fragment ret = (Fragment)0;
    ret.clip_ = arg0;
    ret.position = arg1;
    ret.normal = arg2;
    ret.ratios = arg3;
    ret.quality = arg4;
    ret.depth = arg5;
    return ret;
}

VertexOutput_color_vertex color_vertex(float3 position_1 : LOC0, float3 normal : LOC1, float2 uv : LOC2, float quality : LOC3)
{
    float4 p_3 = float4(position_1, 1.0);
    float4 _e10 = reference.texel;
    float3 ratios_2 = (float3(uv, 1.0) * dot(_e10, p_3));
    float4x4 _e15 = frame.clip_;
    float4 _e19 = frame.depth;
    const Fragment fragment = ConstructFragment(mul(p_3, _e15), position_1, normal, ratios_2, quality, dot(_e19, p_3));
    const VertexOutput_color_vertex fragment_1 = { fragment.position, fragment.normal, fragment.ratios, fragment.quality, fragment.depth, fragment.clip_ };
    return fragment_1;
}

int2 naga_f2i32(float2 value) {
    return int2(clamp(value, -2147483600.0, 2147483500.0));
}

uint2 NagaDimensions2D(Texture2D<float4> tex)
{
    uint4 ret;
    tex.GetDimensions(0, ret.x, ret.y, ret.z);
    return ret.xy;
}

float4 color_fragment(FragmentInput_color_fragment fragmentinput_color_fragment) : SV_Target0
{
    Fragment in_1 = { fragmentinput_color_fragment.clip_3, fragmentinput_color_fragment.position_6, fragmentinput_color_fragment.normal_4, fragmentinput_color_fragment.ratios_1, fragmentinput_color_fragment.quality_2, fragmentinput_color_fragment.depth_3 };
    bool facing = fragmentinput_color_fragment.facing_1;
    bool local = (bool)0;

    float2 size = float2(NagaDimensions2D(picture));
    float2 uv_1 = (in_1.ratios.xy / (in_1.ratios.z).xx);
    float2 _e11 = ddx(uv_1);
    float2 dx = (_e11 * size);
    float2 _e13 = ddy(uv_1);
    float2 dy = (_e13 * size);
    float level = (0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1.0)));
    float4 _e25 = picture.SampleLevel(smooth_sampler, uv_1, level);
    float3 base_2 = _e25.xyz;
    float4 _e29 = normal_map.SampleLevel(smooth_sampler, uv_1, level);
    float3 mapped = ((_e29.xyz * 2.0) - (1.0).xxx);
    float _e39 = reference.mapped;
    if ((_e39 > 0.0)) {
        local = (dot(mapped, mapped) > 0.0);
    } else {
        local = false;
    }
    bool _e48 = local;
    float3 bent = (_e48 ? mapped : in_1.normal);
    float3 normal_5 = normalize((facing ? bent : -(bent)));
    float _e56 = reference.quality;
    float quality_3 = lerp(1.0, in_1.quality, _e56);
    float _e61 = reference.slack;
    float _e64 = reference.spread;
    float offset = (_e61 + (_e64 * in_1.ratios.z));
    float4 _e75 = front.Load(int3(naga_f2i32(in_1.clip_.xy), int(0)));
    if ((in_1.depth > (_e75.x + offset))) {
        discard;
    }
    const float3 _e80 = shade(base_2, normal_5, in_1.position);
    float _e83 = reference.weight;
    return float4(_e80, max((_e83 * quality_3), 6.1035156e-5));
}

float4 screen_vertex(uint index : SV_VertexID) : SV_Position
{
    float2 corner_1 = float2(uint2((index & 1u), (index >> 1u)));
    return float4(((corner_1 * 4.0) - (1.0).xx), 0.0, 1.0);
}

int naga_mod(int lhs, int rhs) {
    int divisor = ((lhs == int(-2147483647 - 1) & rhs == -1) | (rhs == 0)) ? 1 : rhs;
    return lhs - (lhs / divisor) * divisor;
}

int naga_div(int lhs, int rhs) {
    return lhs / (((lhs == int(-2147483647 - 1) & rhs == -1) | (rhs == 0)) ? 1 : rhs);
}

float4 combine_fragment(FragmentInput_combine_fragment fragmentinput_combine_fragment) : SV_Target0
{
    float4 at = fragmentinput_combine_fragment.at_1;
    float3 sum = (0.0).xxx;
    int i = int(0);
    float3 color = (float3)0;
    float alpha = (float)0;
    uint k = (uint)0;

    uint _e3 = frame.samples;
    int n = int(_e3);
    int2 first_1 = asint(asuint(naga_f2i32(at.xy)) * asuint(n));
    uint2 loop_bound_2 = uint2(4294967295u, 4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (all(loop_bound_2 == uint2(0u, 0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
        if (!loop_init_2) {
            int _e65 = i;
            i = asint(asuint(_e65) + asuint(int(1)));
        }
        loop_init_2 = false;
        int _e13 = i;
        if ((_e13 < asint(asuint(n) * asuint(n)))) {
        } else {
            break;
        }
        {
            int _e16 = i;
            int _e18 = i;
            int2 sample_ = asint(asuint(first_1) + asuint(int2(naga_mod(_e16, n), naga_div(_e18, n))));
            color = (0.0).xxx;
            alpha = 0.0;
            k = 0u;
            uint2 loop_bound_3 = uint2(4294967295u, 4294967295u);
            bool loop_init_3 = true;
            while(true) {
                if (all(loop_bound_3 == uint2(0u, 0u))) { break; }
                loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
                if (!loop_init_3) {
                    uint _e47 = k;
                    k = (_e47 + 1u);
                }
                loop_init_3 = false;
                uint _e29 = k;
                uint _e32 = frame.layers;
                if ((_e29 < _e32)) {
                } else {
                    break;
                }
                {
                    uint _e35 = k;
                    float4 c = images.Load(int4(sample_, _e35, int(0)));
                    float3 _e38 = color;
                    color = (_e38 + (c.xyz * c.w));
                    float _e43 = alpha;
                    alpha = (_e43 + c.w);
                }
            }
            float _e49 = alpha;
            if ((_e49 > 0.0)) {
                float3 _e52 = sum;
                float3 _e53 = color;
                float _e54 = alpha;
                sum = (_e52 + (_e53 / (_e54).xxx));
            } else {
                float3 _e58 = sum;
                float4 _e61 = frame.background;
                sum = (_e58 + _e61.xyz);
            }
        }
    }
    float3 _e67 = sum;
    return float4((_e67 / (float(asint(asuint(n) * asuint(n)))).xxx), 1.0);
}
