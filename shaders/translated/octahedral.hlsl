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

struct Camera {
    float2 point_;
    int _pad1_0;
    int _pad1_1;
    float3 right;
    int _pad2_0;
    float3 up;
    int _pad3_0;
    float3 start;
    int _pad4_0;
    float3 ray;
    float middle;
    float slope;
    float level;
    float edge;
    int _end_pad_0;
};

struct Met {
    float2 atlas;
    bool covered;
    float gap;
    bool below;
    int _end_pad_0;
};

struct Fragment {
    float4 color : SV_Target0;
    float depth : SV_Depth;
};

static const uint BISECTIONS = 5u;

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

Met ConstructMet(float2 arg0, bool arg1, float arg2, bool arg3) {
    Met ret = (Met)0;
    ret.atlas = arg0;
    ret.covered = arg1;
    ret.gap = arg2;
    ret.below = arg3;
    return ret;
}

Met look(Camera camera, float height)
{
    bool local_1 = (bool)0;

    float3 p_3 = (camera.start + (camera.ray * (camera.middle + (height / camera.slope))));
    float2 uv = (float2((dot(p_3, camera.right) + 1.0), (1.0 - dot(p_3, camera.up))) * 0.5);
    uint _e32 = impostor.frames;
    float2 atlas = ((camera.point_ + clamp(uv, (camera.edge).xx, ((1.0 - camera.edge)).xx)) / (float(_e32)).xx);
    if (!(any((uv < (0.0).xx)))) {
        local_1 = any((uv > (1.0).xx));
    } else {
        local_1 = true;
    }
    bool _e48 = local_1;
    if (_e48) {
        const Met met_1 = ConstructMet(atlas, false, 0.0, false);
        return met_1;
    }
    float4 _e56 = color_atlas.SampleLevel(smooth_sampler, atlas, camera.level);
    if ((_e56.w < 0.5)) {
        const Met met_2 = ConstructMet(atlas, false, 0.0, false);
        return met_2;
    }
    float4 _e67 = normal_atlas.SampleLevel(smooth_sampler, atlas, camera.level);
    float gap = (height - ((_e67.w * 2.0) - 1.0));
    const Met met_3 = ConstructMet(atlas, true, gap, (gap < 0.0));
    return met_3;
}

Camera ConstructCamera(float2 arg0, float3 arg1, float3 arg2, float3 arg3, float3 arg4, float arg5, float arg6, float arg7, float arg8) {
    Camera ret = (Camera)0;
    ret.point_ = arg0;
    ret.right = arg1;
    ret.up = arg2;
    ret.start = arg3;
    ret.ray = arg4;
    ret.middle = arg5;
    ret.slope = arg6;
    ret.level = arg7;
    ret.edge = arg8;
    return ret;
}

uint naga_f2u32(float value) {
    return uint(clamp(value, 0.0, 4294967000.0));
}

void add(inout Blend blend_1, float2 point_1, float weight, float3 origin, float3 ray_1, float depth)
{
    bool local_2 = (bool)0;
    Met met = (Met)0;
    bool hidden = false;
    bool found = false;
    Met before = (Met)0;
    uint i = 1u;
    bool local_3 = (bool)0;
    float high = (float)0;
    float low = (float)0;
    bool local_4 = (bool)0;
    bool above = (bool)0;
    uint k = (uint)0;
    bool local_5 = (bool)0;
    bool local_6 = (bool)0;

    const float3 _e6 = direction_of(point_1);
    float slope = dot(ray_1, _e6);
    if (!((weight <= 0.0))) {
        local_2 = (slope > (-0.05 * length(ray_1)));
    } else {
        local_2 = true;
    }
    bool _e18 = local_2;
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
    Camera camera_1 = ConstructCamera(point_1, _e22, up, (start / (radius).xxx), (ray_1 / (radius).xxx), middle, (slope / radius), level, edge);
    const Met _e84 = look(camera_1, 0.0);
    met = _e84;
    uint _e88 = impostor.steps;
    if ((_e88 > 0u)) {
        uint _e96 = impostor.tile;
        float wall = ((6.0 * exp2(level)) / float(_e96));
        const Met _e104 = look(camera_1, 1.0);
        before = _e104;
        uint2 loop_bound = uint2(4294967295u, 4294967295u);
        bool loop_init = true;
        while(true) {
            if (all(loop_bound == uint2(0u, 0u))) { break; }
            loop_bound -= uint2(loop_bound.y == 0u, 1u);
            if (!loop_init) {
                uint _e193 = i;
                i = (_e193 + 1u);
            }
            loop_init = false;
            uint _e108 = i;
            uint _e111 = impostor.steps;
            if ((_e108 <= _e111)) {
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
                high = (1.0 - ((2.0 * float((_e119 - 1u))) / float(_e127)));
                uint _e133 = i;
                uint _e139 = impostor.steps;
                low = (1.0 - ((2.0 * float(_e133)) / float(_e139)));
                float _e145 = low;
                const Met _e146 = look(camera_1, _e145);
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
                    uint2 loop_bound_1 = uint2(4294967295u, 4294967295u);
                    bool loop_init_1 = true;
                    while(true) {
                        if (all(loop_bound_1 == uint2(0u, 0u))) { break; }
                        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
                        if (!loop_init_1) {
                            uint _e172 = k;
                            k = (_e172 + 1u);
                        }
                        loop_init_1 = false;
                        uint _e160 = k;
                        if ((_e160 < BISECTIONS)) {
                        } else {
                            break;
                        }
                        {
                            float _e163 = high;
                            float _e164 = low;
                            float half_ = ((_e163 + _e164) * 0.5);
                            const Met _e168 = look(camera_1, half_);
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
                        local_5 = (-(_e179) <= wall);
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
            blend_1.weight = (_e198 - (_e199 ? weight : 0.0));
            return;
        }
    } else {
        bool _e204 = met.covered;
        if (!(_e204)) {
            return;
        }
    }
    float2 _e209 = met.atlas;
    float4 data = normal_atlas.SampleLevel(smooth_sampler, _e209, level);
    float t = (middle + ((((data.w * 2.0) - 1.0) * radius) / slope));
    float _e220 = blend_1.coverage;
    blend_1.coverage = (_e220 + weight);
    float _e223 = blend_1.t;
    blend_1.t = (_e223 + (t * weight));
    float3 _e227 = blend_1.color;
    float2 _e231 = met.atlas;
    float4 _e232 = color_atlas.SampleLevel(smooth_sampler, _e231, level);
    blend_1.color = (_e227 + (_e232.xyz * weight));
    float3 _e237 = blend_1.normal;
    blend_1.normal = (_e237 + (((data.xyz * 2.0) - (1.0).xxx) * weight));
    float3 _e247 = blend_1.emissive;
    float2 _e251 = met.atlas;
    float4 _e252 = emissive_atlas.SampleLevel(smooth_sampler, _e251, level);
    uint _e256 = impostor.emits;
    blend_1.emissive = (_e247 + (_e252.xyz * (weight * float(_e256))));
    return;
}

float3 lit_(float3 base, float3 normal, float3 position)
{
    float3 color_1 = (float3)0;
    bool local_7 = (bool)0;

    float4 _e5 = frame.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    float4 _e12 = frame.ground;
    float4 _e16 = frame.sky;
    float3 ambient = lerp(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    float4 _e26 = frame.sun;
    color_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = frame.sun.w;
    if ((_e35 > 0.0)) {
        local_7 = (sun > 0.0);
    } else {
        local_7 = false;
    }
    bool _e43 = local_7;
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
    uint k_1 = naga_mod(index, 3u);
    uint corner = ((k_1 == 0u) ? 0u : (triangle_ + k_1));
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
