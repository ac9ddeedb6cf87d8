struct Frame {
    row_major float4x4 clip_;
    float4 depth;
    float4 eye;
    float4 to_sun;
    float4 sun;
    float4 sky;
    float4 ground;
    uint shading;
    float sample_size;
    int _end_pad_0;
    int _end_pad_1;
};

struct Impostor {
    float4 window;
    float4 card[4];
    uint corners;
    uint frames;
    uint tile;
    uint levels;
    uint hemi;
    uint steps;
    uint emits;
    int _end_pad_0;
};

struct Card {
    float4 clip_ : SV_Position;
    float3 position : LOC0;
};

struct Blend {
    float3 color;
    int _pad1_0;
    float3 normal;
    int _pad2_0;
    float3 emissive;
    float t;
    float coverage;
    float weight;
    int _end_pad_0;
    int _end_pad_1;
};

struct Fragment {
    float4 color : SV_Target0;
    float depth : SV_Depth;
};

cbuffer frame : register(b0) { Frame frame; }
cbuffer impostor : register(b1) { Impostor impostor; }
Texture2D<float4> color_atlas : register(t2);
Texture2D<float4> normal_atlas : register(t3);
Texture2D<float4> emissive_atlas : register(t4);
SamplerState nagaSamplerHeap[2048]: register(s0, space0);
SamplerComparisonState nagaComparisonSamplerHeap[2048]: register(s0, space1);
StructuredBuffer<uint> nagaGroup0SamplerIndexArray : register(t0, space255);
static const SamplerState smooth_sampler = nagaSamplerHeap[nagaGroup0SamplerIndexArray[5]];

struct VertexOutput_card_vertex {
    float3 position_1 : LOC0;
    float4 clip_ : SV_Position;
};

struct FragmentInput_card_fragment {
    float3 position_2 : LOC0;
    float4 clip_1 : SV_Position;
};

float3 towards_eye()
{
    float _e3 = frame.eye.w;
    if ((_e3 > 0.0)) {
        float4 _e8 = frame.eye;
        float4 _e12 = impostor.window;
        return normalize((_e8.xyz - _e12.xyz));
    }
    float4 _e18 = frame.eye;
    return _e18.xyz;
}

float3 right_of(float3 d)
{
    if ((dot(d.xz, d.xz) < 1e-12)) {
        return normalize(cross(float3(0.0, 0.0, 1.0), d));
    }
    return normalize(cross(float3(0.0, 1.0, 0.0), d));
}

float2 sign_of(float2 v)
{
    return ((v < (0.0).xx) ? (-1.0).xx : (1.0).xx);
}

float2 grid_of(float3 direction)
{
    float3 d_1 = (float3)0;
    float2 e = (float2)0;

    uint _e3 = impostor.frames;
    float last = float((_e3 - 1u));
    d_1 = direction;
    uint _e10 = impostor.hemi;
    if ((_e10 > 0u)) {
        float _e15 = d_1.y;
        d_1.y = max(_e15, 0.001);
    }
    float3 _e18 = d_1;
    float _e20 = d_1.x;
    float _e23 = d_1.y;
    float _e27 = d_1.z;
    float3 p = (_e18 / (((abs(_e20) + abs(_e23)) + abs(_e27))).xxx);
    e = p.xz;
    uint _e36 = impostor.hemi;
    if ((_e36 > 0u)) {
        e = float2((p.x + p.z), (p.x - p.z));
    } else {
        if ((p.y < 0.0)) {
            const float2 _e55 = sign_of(p.xz);
            e = (((1.0).xx - abs(p.zx)) * _e55);
        }
    }
    float2 _e57 = e;
    return clamp((((_e57 * 0.5) + (0.5).xx) * last), (0.0).xx, (last).xx);
}

float3 direction_of(float2 point_)
{
    uint _e3 = impostor.frames;
    float2 e_1 = (((point_ / (float((_e3 - 1u))).xx) * 2.0) - (1.0).xx);
    uint _e16 = impostor.hemi;
    if ((_e16 > 0u)) {
        float2 p_1 = (float2((e_1.x + e_1.y), (e_1.x - e_1.y)) * 0.5);
        return normalize(float3(p_1.x, max(((1.0 - abs(p_1.x)) - abs(p_1.y)), 0.0), p_1.y));
    }
    float y = ((1.0 - abs(e_1.x)) - abs(e_1.y));
    const float2 _e53 = sign_of(e_1);
    float2 p_2 = ((y < 0.0) ? (((1.0).xx - abs(e_1.yx)) * _e53) : e_1);
    return normalize(float3(p_2.x, y, p_2.y));
}

uint naga_f2u32(float value) {
    return uint(clamp(value, 0.0, 4294967000.0));
}

void add(inout Blend blend_1, float2 point_1, float weight, float3 origin, float3 ray_1, float depth)
{
    bool local_1 = (bool)0;
    float t = (float)0;
    float2 uv = (0.0).xx;
    float2 atlas = (0.0).xx;
    uint i = 0u;
    bool local_2 = (bool)0;

    const float3 _e6 = direction_of(point_1);
    float slope = dot(ray_1, _e6);
    if (!((weight <= 0.0))) {
        local_1 = (slope > (-0.05 * length(ray_1)));
    } else {
        local_1 = true;
    }
    bool _e18 = local_1;
    if (_e18) {
        return;
    }
    float _e20 = blend_1.weight;
    blend_1.weight = (_e20 + weight);
    const float3 _e22 = right_of(_e6);
    float3 up = cross(_e6, _e22);
    float radius = impostor.window.w;
    float4 _e30 = impostor.window;
    float3 start = (origin - _e30.xyz);
    float middle = (-(dot(start, _e6)) / slope);
    float _e40 = frame.eye.w;
    float far = ((_e40 > 0.0) ? (depth + middle) : 1.0);
    float _e47 = frame.sample_size;
    uint _e51 = impostor.tile;
    float texels = (((_e47 * far) * float(_e51)) / (2.0 * radius));
    uint _e62 = impostor.levels;
    float level = clamp(log2(max(texels, 1.0)), 0.0, float((_e62 - 1u)));
    uint _e70 = impostor.tile;
    float edge = (0.5 / float((_e70 >> naga_f2u32(ceil(level)))));
    t = middle;
    uint2 loop_bound = uint2(4294967295u, 4294967295u);
    bool loop_init = true;
    while(true) {
        if (all(loop_bound == uint2(0u, 0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        if (!loop_init) {
            uint _e131 = i;
            i = (_e131 + 1u);
        }
        loop_init = false;
        uint _e86 = i;
        uint _e89 = impostor.steps;
        if ((_e86 <= _e89)) {
        } else {
            break;
        }
        {
            float _e91 = t;
            float3 p_3 = ((start + (ray_1 * _e91)) / (radius).xxx);
            uv = (float2((dot(p_3, _e22) + 1.0), (1.0 - dot(p_3, up))) * 0.5);
            float2 _e105 = uv;
            uint _e114 = impostor.frames;
            atlas = ((point_1 + clamp(_e105, (edge).xx, ((1.0 - edge)).xx)) / (float(_e114)).xx);
            float2 _e120 = atlas;
            float4 _e121 = normal_atlas.SampleLevel(smooth_sampler, _e120, level);
            float height = ((_e121.w * 2.0) - 1.0);
            t = (middle + ((height * radius) / slope));
        }
    }
    float2 _e133 = uv;
    if (!(any((_e133 < (0.0).xx)))) {
        float2 _e141 = uv;
        local_2 = any((_e141 > (1.0).xx));
    } else {
        local_2 = true;
    }
    bool _e147 = local_2;
    if (_e147) {
        return;
    }
    float2 _e150 = atlas;
    float4 color_2 = color_atlas.SampleLevel(smooth_sampler, _e150, level);
    float w = (color_2.w * weight);
    float _e155 = blend_1.coverage;
    blend_1.coverage = (_e155 + w);
    float _e158 = blend_1.t;
    float _e159 = t;
    blend_1.t = (_e158 + (_e159 * w));
    float3 _e163 = blend_1.color;
    blend_1.color = (_e163 + (color_2.xyz * w));
    float3 _e168 = blend_1.normal;
    float2 _e171 = atlas;
    float4 _e172 = normal_atlas.SampleLevel(smooth_sampler, _e171, level);
    blend_1.normal = (_e168 + (((_e172.xyz * 2.0) - (1.0).xxx) * w));
    float3 _e182 = blend_1.emissive;
    float2 _e185 = atlas;
    float4 _e186 = emissive_atlas.SampleLevel(smooth_sampler, _e185, level);
    uint _e190 = impostor.emits;
    blend_1.emissive = (_e182 + (_e186.xyz * (w * float(_e190))));
    return;
}

float3 lit_(float3 base, float3 normal, float3 position)
{
    float3 color_1 = (float3)0;
    bool local_3 = (bool)0;

    float4 _e5 = frame.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    float4 _e12 = frame.ground;
    float4 _e16 = frame.sky;
    float3 ambient = lerp(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    float4 _e26 = frame.sun;
    color_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = frame.sun.w;
    if ((_e35 > 0.0)) {
        local_3 = (sun > 0.0);
    } else {
        local_3 = false;
    }
    bool _e43 = local_3;
    if (_e43) {
        float4 _e46 = frame.eye;
        float _e51 = frame.eye.w;
        float3 to_eye = normalize((_e46.xyz - (position * _e51)));
        float4 _e57 = frame.to_sun;
        float3 h = normalize((_e57.xyz + to_eye));
        float3 _e61 = color_1;
        float4 _e64 = frame.sun;
        float _e69 = frame.sun.w;
        float _e76 = frame.to_sun.w;
        color_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal, h), 0.0), _e76)) * sun)));
    }
    float3 _e82 = color_1;
    return _e82;
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / (rhs == 0u ? 1u : rhs);
}

uint naga_mod(uint lhs, uint rhs) {
    return lhs % (rhs == 0u ? 1u : rhs);
}

Card ConstructCard(float4 arg0, float3 arg1) {
    Card ret = (Card)0;
    ret.clip_ = arg0;
    ret.position = arg1;
    return ret;
}

VertexOutput_card_vertex card_vertex(uint index : SV_VertexID)
{
    uint triangle_ = naga_div(index, 3u);
    uint k = naga_mod(index, 3u);
    uint corner = ((k == 0u) ? 0u : (triangle_ + k));
    float4 pair = impostor.card[naga_div(corner, 2u)];
    float2 at = (((corner & 1u) == 1u) ? pair.zw : pair.xy);
    const float3 _e23 = towards_eye();
    const float3 _e24 = right_of(_e23);
    float3 offset = ((_e23 + (_e24 * at.x)) + (cross(_e23, _e24) * at.y));
    float4 _e34 = impostor.window;
    float _e39 = impostor.window.w;
    float3 position_3 = (_e34.xyz + (offset * _e39));
    float4x4 _e44 = frame.clip_;
    const Card card = ConstructCard(mul(float4(position_3, 1.0), _e44), position_3);
    const VertexOutput_card_vertex card_1 = { card.position, card.clip_ };
    return card_1;
}

Blend ConstructBlend(float3 arg0, float3 arg1, float3 arg2, float arg3, float arg4, float arg5) {
    Blend ret = (Blend)0;
    ret.color = arg0;
    ret.normal = arg1;
    ret.emissive = arg2;
    ret.t = arg3;
    ret.coverage = arg4;
    ret.weight = arg5;
    return ret;
}

Fragment ConstructFragment(float4 arg0, float arg1) {
    Fragment ret = (Fragment)0;
    ret.color = arg0;
    ret.depth = arg1;
    return ret;
}

Fragment card_fragment(FragmentInput_card_fragment fragmentinput_card_fragment)
{
    Card in_ = { fragmentinput_card_fragment.clip_1, fragmentinput_card_fragment.position_2 };
    float3 ray = (float3)0;
    Blend blend = ConstructBlend((0.0).xxx, (0.0).xxx, (0.0).xxx, 0.0, 0.0, 0.0);
    bool local = (bool)0;
    float3 color = (float3)0;

    const float3 _e1 = towards_eye();
    float4 _e5 = frame.eye;
    ray = (in_.position - _e5.xyz);
    float _e12 = frame.eye.w;
    if ((_e12 == 0.0)) {
        ray = -(_e1);
    }
    float3 _e16 = ray;
    float4 _e19 = frame.depth;
    float3 _e21 = ray;
    ray = (_e16 / (dot(_e19.xyz, _e21)).xxx);
    float4 _e27 = frame.depth;
    float depth_1 = dot(_e27, float4(in_.position, 1.0));
    const float2 _e32 = grid_of(_e1);
    uint _e36 = impostor.frames;
    float2 cell = min(floor(_e32), (float((_e36 - 2u))).xx);
    float2 f = (_e32 - cell);
    bool across = (f.x >= f.y);
    float2 side = (across ? float2(1.0, 0.0) : float2(0.0, 1.0));
    float3 _e70 = ray;
    add(blend, cell, (1.0 - max(f.x, f.y)), in_.position, _e70, depth_1);
    float3 _e77 = ray;
    add(blend, (cell + side), abs((f.x - f.y)), in_.position, _e77, depth_1);
    float3 _e85 = ray;
    add(blend, (cell + (1.0).xx), min(f.x, f.y), in_.position, _e85, depth_1);
    float _e87 = blend.coverage;
    if (!((_e87 <= 0.0))) {
        float _e94 = blend.coverage;
        float _e96 = blend.weight;
        local = (_e94 < (0.5 * _e96));
    } else {
        local = true;
    }
    bool _e101 = local;
    if (_e101) {
        discard;
    }
    float _e103 = blend.coverage;
    float share = (1.0 / _e103);
    float3 _e107 = ray;
    float _e109 = blend.t;
    float3 position_4 = (in_.position + (_e107 * (_e109 * share)));
    float4x4 _e115 = frame.clip_;
    float4 clip_2 = mul(float4(position_4, 1.0), _e115);
    float3 _e120 = blend.color;
    color = (_e120 * share);
    uint _e125 = frame.shading;
    if ((_e125 == 1u)) {
        float3 _e128 = color;
        float3 _e130 = blend.normal;
        const float3 _e132 = lit_(_e128, normalize(_e130), position_4);
        float3 _e134 = blend.emissive;
        color = (_e132 + (_e134 * share));
    }
    float3 _e137 = color;
    const Fragment fragment = ConstructFragment(float4(_e137, 1.0), (clip_2.z / clip_2.w));
    return fragment;
}
