struct Frame {
    row_major float4x4 clip_;
    float4 depth;
    float4 eye;
    float4 to_sun;
    float4 sun;
    float4 sky;
    float4 ground;
    float near;
    float far;
    float sample_size;
    uint shading;
};

struct Impostor {
    float4 centre;
    float4 extent;
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
    int _end_pad_0;
    int _end_pad_1;
};

struct Map {
    float4 rows[3];
    float4 window;
    float deep;
    float step_;
    float texel;
    uint first;
};

struct Instance {
    float4 place;
    float4 rotation;
    uint4 maps;
};

struct Ray {
    float3 origin;
    int _pad1_0;
    float3 direction;
    int _end_pad_0;
};

struct Proxy {
    float4 clip_ : SV_Position;
    float3 position : LOC0;
    nointerpolation uint instance : LOC1;
};

struct Seen {
    uint map;
    float t;
};

struct Fragment {
    float4 color : SV_Target0;
    float depth : SV_Depth;
};

static const uint MAPS = 8u;
static const uint NO_MAP = 65535u;

cbuffer frame : register(b0) { Frame frame; }
cbuffer impostor : register(b1) { Impostor impostor; }
ByteAddressBuffer maps : register(t2);
ByteAddressBuffer instances : register(t3);
ByteAddressBuffer ranges : register(t4);
Texture2DArray<float4> depth_codes : register(t5);
Texture2DArray<float4> color : register(t6);
Texture2DArray<float4> normals : register(t7);
Texture2DArray<float4> emissive : register(t8);
SamplerState nagaSamplerHeap[2048]: register(s0, space0);
SamplerComparisonState nagaComparisonSamplerHeap[2048]: register(s0, space1);
StructuredBuffer<uint> nagaGroup0SamplerIndexArray : register(t0, space255);
static const SamplerState smooth_sampler = nagaSamplerHeap[nagaGroup0SamplerIndexArray[9]];

struct VertexOutput_box_vertex {
    float3 position_2 : LOC0;
    nointerpolation uint instance_3 : LOC1;
    float4 clip_1 : SV_Position;
};

struct FragmentInput_ori_fragment {
    float3 position_3 : LOC0;
    nointerpolation uint instance_4 : LOC1;
    float4 clip_2 : SV_Position;
};

float3 turned(float3 v, float4 q)
{
    return (v + (2.0 * cross(q.xyz, (cross(q.xyz, v) + (q.w * v)))));
}

float3 turned_back(float3 v_1, float4 q_1)
{
    return (v_1 + (2.0 * cross(q_1.xyz, (cross(q_1.xyz, v_1) - (q_1.w * v_1)))));
}

float2 texel(uint map, int2 at)
{
    bool local_3 = (bool)0;

    if (!(any((at < (int(0)).xx)))) {
        uint _e11 = impostor.side;
        local_3 = any((at >= (int(_e11)).xx));
    } else {
        local_3 = true;
    }
    bool _e17 = local_3;
    if (_e17) {
        return float2(3e38, -0.5);
    }
    uint _e23 = impostor.codes;
    float last = float((_e23 - 1u));
    float4 _e29 = depth_codes.Load(int4(at, map, int(0)));
    float code = floor(((_e29.x * last) + 0.5));
    uint _e37 = impostor.depths;
    if ((code < float(_e37))) {
        float _e43 = asfloat(maps.Load(68+map*80));
        return float2((code * _e43), 0.5);
    }
    float reach = (((last - code) + 0.5) / 16.0);
    return float2(3e38, ((-0.5 * (1.0 - reach)) / reach));
}

float straight_on(uint map_1, int2 a, float depth, int2 k)
{
    const float2 _e7 = texel(map_1, asint(asuint(asint(asuint(int(2)) * asuint(a))) - asuint(k)));
    float before_1 = _e7.x;
    float _e16 = impostor.wall;
    return ((abs((before_1 - depth)) <= _e16) ? ((2.0 * depth) - before_1) : depth);
}

int2 corner_of(int2 first, uint k_1)
{
    return asint(asuint(first) + asuint(int2(uint2((k_1 & 1u), (k_1 >> 1u)))));
}

float4 corners_of(uint map_2, int2 first_1, float2 texels[4], uint bits_1)
{
    float4 depths = (float4)0;
    float4 out_ = (float4)0;
    uint k_2 = 0u;
    float sum = (float)0;
    bool local_4 = (bool)0;

    depths = float4(texels[0].x, texels[1].x, texels[2].x, texels[3].x);
    if ((bits_1 == 15u)) {
        float4 _e16 = depths;
        return _e16;
    }
    float4 _e17 = depths;
    out_ = _e17;
    uint2 loop_bound = uint2(4294967295u, 4294967295u);
    bool loop_init = true;
    while(true) {
        if (all(loop_bound == uint2(0u, 0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        if (!loop_init) {
            uint _e100 = k_2;
            k_2 = (_e100 + 1u);
        }
        loop_init = false;
        uint _e21 = k_2;
        if ((_e21 < 4u)) {
        } else {
            break;
        }
        {
            uint _e24 = k_2;
            if ((((bits_1 >> _e24) & 1u) == 1u)) {
                continue;
            }
            uint _e30 = k_2;
            uint a_1 = (_e30 ^ 1u);
            uint _e33 = k_2;
            uint b = (_e33 ^ 2u);
            uint _e36 = k_2;
            uint c = (_e36 ^ 3u);
            bool3 has = bool3((((bits_1 >> a_1) & 1u) == 1u), (((bits_1 >> b) & 1u) == 1u), (((bits_1 >> c) & 1u) == 1u));
            if (all(has)) {
                uint _e56 = k_2;
                float _e59 = depths[min(uint(a_1), 3u)];
                float _e61 = depths[min(uint(b), 3u)];
                float _e64 = depths[min(uint(c), 3u)];
                out_[min(uint(_e56), 3u)] = ((_e59 + _e61) - _e64);
                continue;
            }
            uint _e66 = k_2;
            const int2 _e67 = corner_of(first_1, _e66);
            sum = 0.0;
            if (has.x) {
                const int2 _e71 = corner_of(first_1, a_1);
                float _e73 = depths[min(uint(a_1), 3u)];
                const float _e74 = straight_on(map_2, _e71, _e73, _e67);
                sum = _e74;
            }
            if (has.y) {
                const int2 _e76 = corner_of(first_1, b);
                float _e78 = depths[min(uint(b), 3u)];
                const float _e79 = straight_on(map_2, _e76, _e78, _e67);
                float _e80 = sum;
                sum = (has.x ? ((_e80 + _e79) * 0.5) : _e79);
            }
            uint _e86 = k_2;
            float _e89 = depths[min(uint(c), 3u)];
            float _e90 = sum;
            if (!(has.x)) {
                local_4 = has.y;
            } else {
                local_4 = true;
            }
            bool _e97 = local_4;
            out_[min(uint(_e86), 3u)] = (_e97 ? _e90 : _e89);
        }
    }
    float4 _e102 = out_;
    return _e102;
}

float rising_root(float e, float f, float g)
{
    float under_1 = ((f * f) - ((4.0 * e) * g));
    if (!((under_1 > 0.0))) {
        return 3e38;
    }
    float root = sqrt(under_1);
    if ((f >= 0.0)) {
        return ((-2.0 * e) / (f + root));
    }
    if ((g == 0.0)) {
        return 3e38;
    }
    return ((root - f) / (2.0 * g));
}

bool shows(float2 texels_1[4], uint bits_2, float2 at_1)
{
    float2 all_texels[4] = (float2[4])0;
    float4 weights = (float4)0;
    float edge = 0.0;
    uint own = 0u;
    float most = -1.0;
    uint k_3 = 0u;
    bool local_5 = (bool)0;
    bool local_6 = (bool)0;

    all_texels = texels_1;
    float2 p_1 = clamp(at_1, (0.0).xx, (1.0).xx);
    weights = float4(((1.0 - p_1.x) * (1.0 - p_1.y)), (p_1.x * (1.0 - p_1.y)), ((1.0 - p_1.x) * p_1.y), (p_1.x * p_1.y));
    uint2 loop_bound_1 = uint2(4294967295u, 4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (all(loop_bound_1 == uint2(0u, 0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e72 = k_3;
            k_3 = (_e72 + 1u);
        }
        loop_init_1 = false;
        uint _e39 = k_3;
        if ((_e39 < 4u)) {
        } else {
            break;
        }
        {
            float _e42 = edge;
            uint _e43 = k_3;
            float _e45 = weights[min(uint(_e43), 3u)];
            uint _e46 = k_3;
            float _e49 = all_texels[min(uint(_e46), 3u)].y;
            edge = (_e42 + (_e45 * _e49));
            uint _e52 = k_3;
            float _e55 = all_texels[min(uint(_e52), 3u)].x;
            if ((_e55 < 1e38)) {
                uint _e60 = k_3;
                float _e62 = weights[min(uint(_e60), 3u)];
                float _e63 = most;
                local_5 = (_e62 > _e63);
            } else {
                local_5 = false;
            }
            bool _e66 = local_5;
            if (_e66) {
                uint _e67 = k_3;
                own = _e67;
                uint _e68 = k_3;
                float _e70 = weights[min(uint(_e68), 3u)];
                most = _e70;
            }
        }
    }
    float _e74 = edge;
    if ((_e74 > 0.0)) {
        uint _e79 = own;
        local_6 = (((bits_2 >> _e79) & 1u) == 1u);
    } else {
        local_6 = false;
    }
    bool _e86 = local_6;
    return _e86;
}

typedef float2 ret_Constructarray4_float2_[4];
ret_Constructarray4_float2_ Constructarray4_float2_(float2 arg0, float2 arg1, float2 arg2, float2 arg3) {
    float2 ret[4] = { arg0, arg1, arg2, arg3 };
    return ret;
}

float meet(uint map_3, int2 first_2, Ray ray, float start, float end)
{
    float2 texels_2[4] = (float2[4])0;
    uint taken = 0u;
    float nearest = 3e38;
    uint k_4 = 0u;
    bool local_7 = (bool)0;
    uint bits_3 = (uint)0;
    uint l = (uint)0;
    bool local_8 = (bool)0;
    bool local_9 = (bool)0;
    bool local_10 = (bool)0;
    bool local_11 = (bool)0;

    const float2 _e5 = texel(map_3, first_2);
    const float2 _e10 = texel(map_3, asint(asuint(first_2) + asuint(int2(int(1), int(0)))));
    const float2 _e15 = texel(map_3, asint(asuint(first_2) + asuint(int2(int(0), int(1)))));
    const float2 _e20 = texel(map_3, asint(asuint(first_2) + asuint(int2(int(1), int(1)))));
    texels_2 = Constructarray4_float2_(_e5, _e10, _e15, _e20);
    float3 begin = (ray.origin + (ray.direction * start));
    float3 d = ray.direction;
    float2 corner = (begin.xy - (float2(first_2) + (0.5).xx));
    uint2 loop_bound_2 = uint2(4294967295u, 4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (all(loop_bound_2 == uint2(0u, 0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
        if (!loop_init_2) {
            uint _e183 = k_4;
            k_4 = (_e183 + 1u);
        }
        loop_init_2 = false;
        uint _e40 = k_4;
        if ((_e40 < 4u)) {
        } else {
            break;
        }
        {
            uint _e43 = taken;
            uint _e44 = k_4;
            if (!((((_e43 >> _e44) & 1u) == 1u))) {
                uint _e53 = k_4;
                float _e56 = texels_2[min(uint(_e53), 3u)].x;
                local_7 = (_e56 > 1e38);
            } else {
                local_7 = true;
            }
            bool _e60 = local_7;
            if (_e60) {
                continue;
            }
            bits_3 = 0u;
            l = 0u;
            uint2 loop_bound_3 = uint2(4294967295u, 4294967295u);
            bool loop_init_3 = true;
            while(true) {
                if (all(loop_bound_3 == uint2(0u, 0u))) { break; }
                loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
                if (!loop_init_3) {
                    uint _e99 = l;
                    l = (_e99 + 1u);
                }
                loop_init_3 = false;
                uint _e65 = l;
                if ((_e65 < 4u)) {
                } else {
                    break;
                }
                {
                    uint _e68 = taken;
                    uint _e69 = l;
                    if ((((_e68 >> _e69) & 1u) == 0u)) {
                        uint _e77 = l;
                        float _e80 = texels_2[min(uint(_e77), 3u)].x;
                        uint _e81 = k_4;
                        float _e84 = texels_2[min(uint(_e81), 3u)].x;
                        float _e89 = impostor.wall;
                        local_8 = (abs((_e80 - _e84)) <= _e89);
                    } else {
                        local_8 = false;
                    }
                    bool _e92 = local_8;
                    if (_e92) {
                        uint _e93 = bits_3;
                        uint _e95 = l;
                        bits_3 = (_e93 | (1u << _e95));
                    }
                }
            }
            uint _e101 = taken;
            uint _e102 = bits_3;
            taken = (_e101 | _e102);
            float2 _e104[4] = texels_2;
            uint _e105 = bits_3;
            const float4 _e106 = corners_of(map_3, first_2, _e104, _e105);
            float b_1 = (_e106.y - _e106.x);
            float c_1 = (_e106.z - _e106.x);
            float g_1 = (((_e106.x - _e106.y) - _e106.z) + _e106.w);
            float e_1 = (begin.z - (((_e106.x + (b_1 * corner.x)) + (c_1 * corner.y)) + ((g_1 * corner.x) * corner.y)));
            float f_1 = (d.z - (((b_1 * d.x) + (c_1 * d.y)) + (g_1 * ((corner.x * d.y) + (corner.y * d.x)))));
            const float _e155 = rising_root(e_1, f_1, ((-(g_1) * d.x) * d.y));
            if ((_e155 >= 0.0)) {
                local_9 = ((start + _e155) <= end);
            } else {
                local_9 = false;
            }
            bool _e163 = local_9;
            if (_e163) {
                float _e167 = nearest;
                local_10 = ((start + _e155) < _e167);
            } else {
                local_10 = false;
            }
            bool _e170 = local_10;
            if (_e170) {
                float2 _e173[4] = texels_2;
                uint _e174 = bits_3;
                const bool _e178 = shows(_e173, _e174, (corner + (d.xy * _e155)));
                local_11 = _e178;
            } else {
                local_11 = false;
            }
            bool _e180 = local_11;
            if (_e180) {
                nearest = (start + _e155);
            }
        }
    }
    float _e185 = nearest;
    return _e185;
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / (rhs == 0u ? 1u : rhs);
}

int2 naga_f2i32(float2 value) {
    return int2(clamp(value, -2147483600.0, 2147483500.0));
}

float search_pyramid(uint map_4, Ray ray_1, float t0_, float t1_)
{
    uint level = (uint)0;
    float t = (float)0;
    uint i = 0u;
    bool local_12 = (bool)0;
    bool local_13 = (bool)0;

    float3 o = ray_1.origin;
    float3 d_1 = ray_1.direction;
    float pace = max(max(abs(d_1.x), abs(d_1.y)), (0.05 * abs(d_1.z)));
    float nudge = (0.0005 / pace);
    float slack = (0.002 / pace);
    uint n = impostor.squares;
    uint top = firstbitlow(n);
    float2 begin_1 = (o.xy - (0.5).xx);
    bool2 still = (d_1.xy == (0.0).xx);
    float2 over = ((1.0).xx / (still ? (1.0).xx : d_1.xy));
    int2 ahead = int2((d_1.xy > (0.0).xx));
    level = min(2u, top);
    t = min((t0_ + nudge), ((t0_ + t1_) * 0.5));
    uint2 loop_bound_4 = uint2(4294967295u, 4294967295u);
    bool loop_init_4 = true;
    while(true) {
        if (all(loop_bound_4 == uint2(0u, 0u))) { break; }
        loop_bound_4 -= uint2(loop_bound_4.y == 0u, 1u);
        if (!loop_init_4) {
            uint _e165 = i;
            i = (_e165 + 1u);
        }
        loop_init_4 = false;
        uint _e55 = i;
        if ((_e55 < (8u * n))) {
            float _e61 = t;
            local_12 = (_e61 < t1_);
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
            int2 cell = clamp(naga_f2i32((begin_1 + (d_1.xy * _e66))), (int(0)).xx, (asint(asuint(int(n)) - asuint(int(1)))).xx);
            float _e77 = t;
            float before_2 = max((_e77 - nudge), t0_);
            float enter = (o.z + (d_1.z * before_2));
            uint2 loop_bound_5 = uint2(4294967295u, 4294967295u);
            while(true) {
                if (all(loop_bound_5 == uint2(0u, 0u))) { break; }
                loop_bound_5 -= uint2(loop_bound_5.y == 0u, 1u);
                uint _e84 = level;
                int2 square = (cell >> (_e84).xx);
                uint _e88 = level;
                float2 sides = ((float2((asint(asuint(square) + asuint(ahead)) << (_e88).xx)) - begin_1) * over);
                float2 ends = (still ? (t1_).xx : sides);
                float _e100 = t;
                float end_3 = max(min(min(ends.x, ends.y), t1_), _e100);
                uint _e102 = level;
                uint m = (n >> _e102);
                uint skipped = (naga_div(((n * n) - (m * m)), 3u) * 4u);
                uint _e115 = asuint(maps.Load(76+map_4*80));
                float2 range = asfloat(ranges.Load2((((_e115 + skipped) + (uint(square.y) * m)) + uint(square.x))*8));
                float leave = (o.z + (d_1.z * end_3));
                if (!(((max(enter, leave) + 0.002) < range.x))) {
                    local_13 = ((min(enter, leave) - 0.002) > range.y);
                } else {
                    local_13 = true;
                }
                bool _e144 = local_13;
                if (_e144) {
                    t = (end_3 + nudge);
                    uint _e146 = level;
                    level = min((_e146 + 1u), top);
                    break;
                }
                uint _e150 = level;
                if ((_e150 == 0u)) {
                    const float _e155 = meet(map_4, cell, ray_1, (before_2 - slack), (end_3 + slack));
                    if ((_e155 < 1e38)) {
                        return _e155;
                    }
                    t = (end_3 + nudge);
                    level = min(1u, top);
                    break;
                }
                uint _e161 = level;
                level = (_e161 - 1u);
            }
        }
    }
    return 3e38;
}

float height(uint map_5, float2 at_2)
{
    float2 texels_3[4] = (float2[4])0;
    float4 weights_1 = (float4)0;
    float edge_1 = 0.0;
    float own_1 = 3e38;
    float most_1 = -1.0;
    uint k_5 = 0u;
    bool local_14 = (bool)0;
    float sum_1 = 0.0;
    float weight = 0.0;
    uint k_6 = 0u;

    float2 p_2 = (at_2 - (0.5).xx);
    float2 low = floor(p_2);
    float2 f_2 = (p_2 - low);
    int2 first_3 = naga_f2i32(low);
    const float2 _e8 = texel(map_5, first_3);
    const float2 _e13 = texel(map_5, asint(asuint(first_3) + asuint(int2(int(1), int(0)))));
    const float2 _e18 = texel(map_5, asint(asuint(first_3) + asuint(int2(int(0), int(1)))));
    const float2 _e23 = texel(map_5, asint(asuint(first_3) + asuint(int2(int(1), int(1)))));
    texels_3 = Constructarray4_float2_(_e8, _e13, _e18, _e23);
    weights_1 = float4(((1.0 - f_2.x) * (1.0 - f_2.y)), (f_2.x * (1.0 - f_2.y)), ((1.0 - f_2.x) * f_2.y), (f_2.x * f_2.y));
    uint2 loop_bound_6 = uint2(4294967295u, 4294967295u);
    bool loop_init_5 = true;
    while(true) {
        if (all(loop_bound_6 == uint2(0u, 0u))) { break; }
        loop_bound_6 -= uint2(loop_bound_6.y == 0u, 1u);
        if (!loop_init_5) {
            uint _e92 = k_5;
            k_5 = (_e92 + 1u);
        }
        loop_init_5 = false;
        uint _e56 = k_5;
        if ((_e56 < 4u)) {
        } else {
            break;
        }
        {
            float _e59 = edge_1;
            uint _e60 = k_5;
            float _e62 = weights_1[min(uint(_e60), 3u)];
            uint _e63 = k_5;
            float _e66 = texels_3[min(uint(_e63), 3u)].y;
            edge_1 = (_e59 + (_e62 * _e66));
            uint _e69 = k_5;
            float _e72 = texels_3[min(uint(_e69), 3u)].x;
            if ((_e72 < 1e38)) {
                uint _e77 = k_5;
                float _e79 = weights_1[min(uint(_e77), 3u)];
                float _e80 = most_1;
                local_14 = (_e79 > _e80);
            } else {
                local_14 = false;
            }
            bool _e83 = local_14;
            if (_e83) {
                uint _e84 = k_5;
                float _e87 = texels_3[min(uint(_e84), 3u)].x;
                own_1 = _e87;
                uint _e88 = k_5;
                float _e90 = weights_1[min(uint(_e88), 3u)];
                most_1 = _e90;
            }
        }
    }
    float _e94 = edge_1;
    if (!((_e94 > 0.0))) {
        return 3e38;
    }
    uint2 loop_bound_7 = uint2(4294967295u, 4294967295u);
    bool loop_init_6 = true;
    while(true) {
        if (all(loop_bound_7 == uint2(0u, 0u))) { break; }
        loop_bound_7 -= uint2(loop_bound_7.y == 0u, 1u);
        if (!loop_init_6) {
            uint _e135 = k_6;
            k_6 = (_e135 + 1u);
        }
        loop_init_6 = false;
        uint _e105 = k_6;
        if ((_e105 < 4u)) {
        } else {
            break;
        }
        {
            uint _e108 = k_6;
            float _e111 = texels_3[min(uint(_e108), 3u)].x;
            float _e112 = own_1;
            float _e117 = impostor.wall;
            if ((abs((_e111 - _e112)) <= _e117)) {
                float _e119 = sum_1;
                uint _e120 = k_6;
                float _e122 = weights_1[min(uint(_e120), 3u)];
                uint _e123 = k_6;
                float _e126 = texels_3[min(uint(_e123), 3u)].x;
                sum_1 = (_e119 + (_e122 * _e126));
                float _e129 = weight;
                uint _e130 = k_6;
                float _e132 = weights_1[min(uint(_e130), 3u)];
                weight = (_e129 + _e132);
            }
        }
    }
    float _e137 = sum_1;
    float _e138 = weight;
    return (_e137 / _e138);
}

float below(uint map_6, Ray ray_2, float t_1)
{
    float3 p_3 = (ray_2.origin + (ray_2.direction * t_1));
    const float _e9 = height(map_6, p_3.xy);
    return (p_3.z - _e9);
}

float search_linear(uint map_7, Ray ray_3, float t0_1, float t1_1)
{
    float above = (float)0;
    float under = 3e38;
    uint i_1 = 0u;
    uint i_2 = 0u;

    uint _e7 = impostor.steps;
    float step_ = ((t1_1 - t0_1) / float(_e7));
    above = t0_1;
    uint2 loop_bound_8 = uint2(4294967295u, 4294967295u);
    bool loop_init_7 = true;
    while(true) {
        if (all(loop_bound_8 == uint2(0u, 0u))) { break; }
        loop_bound_8 -= uint2(loop_bound_8.y == 0u, 1u);
        if (!loop_init_7) {
            uint _e28 = i_1;
            i_1 = (_e28 + 1u);
        }
        loop_init_7 = false;
        uint _e15 = i_1;
        uint _e18 = impostor.steps;
        if ((_e15 <= _e18)) {
        } else {
            break;
        }
        {
            uint _e20 = i_1;
            float t_2 = (t0_1 + (step_ * float(_e20)));
            const float _e24 = below(map_7, ray_3, t_2);
            if ((_e24 >= 0.0)) {
                under = t_2;
                break;
            }
            above = t_2;
        }
    }
    float _e30 = under;
    if ((_e30 > 1e38)) {
        return 3e38;
    }
    uint2 loop_bound_9 = uint2(4294967295u, 4294967295u);
    bool loop_init_8 = true;
    while(true) {
        if (all(loop_bound_9 == uint2(0u, 0u))) { break; }
        loop_bound_9 -= uint2(loop_bound_9.y == 0u, 1u);
        if (!loop_init_8) {
            uint _e50 = i_2;
            i_2 = (_e50 + 1u);
        }
        loop_init_8 = false;
        uint _e36 = i_2;
        uint _e39 = impostor.halvings;
        if ((_e36 < _e39)) {
        } else {
            break;
        }
        {
            float _e41 = above;
            float _e42 = under;
            float middle = ((_e41 + _e42) * 0.5);
            const float _e46 = below(map_7, ray_3, middle);
            if ((_e46 >= 0.0)) {
                under = middle;
            } else {
                above = middle;
            }
        }
    }
    float _e54 = above;
    float3 a_2 = (ray_3.origin + (ray_3.direction * _e54));
    float _e59 = under;
    float3 b_2 = (ray_3.origin + (ray_3.direction * _e59));
    const float _e63 = height(map_7, a_2.xy);
    const float _e65 = height(map_7, b_2.xy);
    float _e70 = impostor.wall;
    if (!((abs((_e63 - _e65)) <= _e70))) {
        return 3e38;
    }
    float _e74 = under;
    return _e74;
}

float trace(uint map_8, Ray ray_4, float start_1, float end_1)
{
    float4 window = asfloat(maps.Load4(48+map_8*80));
    float3 low_1 = float3(window.xy, 0.0);
    float _e15 = asfloat(maps.Load(64+map_8*80));
    float3 high = float3(window.zw, _e15);
    bool3 still_1 = (ray_4.direction == (0.0).xxx);
    if (any((still_1 & ((ray_4.origin < low_1) | (ray_4.origin > high))))) {
        return 3e38;
    }
    float3 over_1 = ((1.0).xxx / (still_1 ? (1.0).xxx : ray_4.direction));
    float3 a_3 = (still_1 ? (start_1).xxx : ((low_1 - ray_4.origin) * over_1));
    float3 b_3 = (still_1 ? (end_1).xxx : ((high - ray_4.origin) * over_1));
    float3 first_4 = min(a_3, b_3);
    float3 last_1 = max(a_3, b_3);
    float t0_2 = max(max(first_4.x, first_4.y), max(first_4.z, start_1));
    float t1_2 = min(min(last_1.x, last_1.y), min(last_1.z, end_1));
    if (!((t0_2 <= t1_2))) {
        return 3e38;
    }
    uint _e65 = impostor.steps;
    if ((_e65 > 0u)) {
        const float _e68 = search_linear(map_8, ray_4, t0_2, t1_2);
        return _e68;
    }
    const float _e69 = search_pyramid(map_8, ray_4, t0_2, t1_2);
    return _e69;
}

float slope(float before, float at_3, float after)
{
    bool local_15 = (bool)0;

    float _e7 = impostor.wall;
    bool has_before = (abs((before - at_3)) <= _e7);
    float _e13 = impostor.wall;
    bool has_after = (abs((after - at_3)) <= _e13);
    if (has_before) {
        local_15 = has_after;
    } else {
        local_15 = false;
    }
    bool _e18 = local_15;
    if (_e18) {
        return (after - before);
    }
    if (has_before) {
        return (2.0 * (at_3 - before));
    }
    if (has_after) {
        return (2.0 * (after - at_3));
    }
    return 0.0;
}

float squareness(uint map_9, float3 p)
{
    float2 u = float2(0.5, 0.0);
    float2 v_2 = float2(0.0, 0.5);
    const float _e10 = height(map_9, (p.xy - u));
    const float _e14 = height(map_9, (p.xy + u));
    const float _e15 = slope(_e10, p.z, _e14);
    const float _e18 = height(map_9, (p.xy - v_2));
    const float _e22 = height(map_9, (p.xy + v_2));
    const float _e23 = slope(_e18, p.z, _e22);
    return (1.0 / sqrt((((_e15 * _e15) + (_e23 * _e23)) + 1.0)));
}

Ray ConstructRay(float3 arg0, float3 arg1) {
    Ray ret = (Ray)0;
    ret.origin = arg0;
    ret.direction = arg1;
    return ret;
}

typedef float4 ret_Constructarray3_float4_[3];
ret_Constructarray3_float4_ Constructarray3_float4_(float4 arg0, float4 arg1, float4 arg2) {
    float4 ret[3] = { arg0, arg1, arg2 };
    return ret;
}

Ray map_ray(uint map_10, Ray ray_5)
{
    float4 r[3] = Constructarray3_float4_(asfloat(maps.Load4(0+map_10*80+0)), asfloat(maps.Load4(0+map_10*80+16)), asfloat(maps.Load4(0+map_10*80+32)));
    float4 o_1 = float4(ray_5.origin, 1.0);
    const Ray ray_7 = ConstructRay(float3(dot(r[0], o_1), dot(r[1], o_1), dot(r[2], o_1)), float3(dot(r[0].xyz, ray_5.direction), dot(r[1].xyz, ray_5.direction), dot(r[2].xyz, ray_5.direction)));
    return ray_7;
}

uint map_of(uint instance, uint k_7)
{
    uint pair = asuint(instances.Load((k_7 >> 1u)*4+32+instance*48));
    return (((k_7 & 1u) == 1u) ? (pair >> 16u) : (pair & 65535u));
}

Seen ConstructSeen(uint arg0, float arg1) {
    Seen ret = (Seen)0;
    ret.map = arg0;
    ret.t = arg1;
    return ret;
}

Map ConstructMap(float4 arg0[3], float4 arg1, float arg2, float arg3, float arg4, uint arg5) {
    Map ret = (Map)0;
    ret.rows = arg0;
    ret.window = arg1;
    ret.deep = arg2;
    ret.step_ = arg3;
    ret.texel = arg4;
    ret.first = arg5;
    return ret;
}

Seen see(uint instance_1, Ray ray_6, float start_2, float end_2)
{
    float found[8] = (float[8])0;
    float nearest_1 = 3e38;
    Seen best = ConstructSeen(65535u, 3e38);
    float least = 3e38;
    uint k_8 = 0u;
    float rank = (float)0;
    bool local_16 = (bool)0;
    uint k_9 = 0u;
    bool local_17 = (bool)0;

    uint2 loop_bound_10 = uint2(4294967295u, 4294967295u);
    bool loop_init_9 = true;
    while(true) {
        if (all(loop_bound_10 == uint2(0u, 0u))) { break; }
        loop_bound_10 -= uint2(loop_bound_10.y == 0u, 1u);
        if (!loop_init_9) {
            uint _e76 = k_8;
            k_8 = (_e76 + 1u);
        }
        loop_init_9 = false;
        uint _e15 = k_8;
        if ((_e15 < MAPS)) {
        } else {
            break;
        }
        {
            uint _e18 = k_8;
            found[min(uint(_e18), 7u)] = 3e38;
            uint _e21 = k_8;
            const uint _e22 = map_of(instance_1, _e21);
            if ((_e22 == NO_MAP)) {
                continue;
            }
            const Ray _e25 = map_ray(_e22, ray_6);
            const float _e26 = trace(_e22, _e25, start_2, end_2);
            if ((_e26 > 1e38)) {
                continue;
            }
            uint _e29 = k_8;
            found[min(uint(_e29), 7u)] = _e26;
            float _e31 = nearest_1;
            nearest_1 = min(_e31, _e26);
            rank = _e26;
            uint _e36 = impostor.strategy;
            bool should_continue = false;
            switch(_e36) {
                case 1u: {
                    rank = ((_e25.direction.z == 0.0) ? 1e38 : (-(_e25.origin.z) / _e25.direction.z));
                    break;
                }
                case 4u: {
                    const float _e53 = squareness(_e22, (_e25.origin + (_e25.direction * _e26)));
                    rank = -(_e53);
                    break;
                }
                case 5u: {
                    Map m_1 = ConstructMap(Constructarray3_float4_(asfloat(maps.Load4(_e22*80+0+0)), asfloat(maps.Load4(_e22*80+0+16)), asfloat(maps.Load4(_e22*80+0+32))), asfloat(maps.Load4(_e22*80+48)), asfloat(maps.Load(_e22*80+64)), asfloat(maps.Load(_e22*80+68)), asfloat(maps.Load(_e22*80+72)), asuint(maps.Load(_e22*80+76)));
                    const float _e67 = squareness(_e22, (_e25.origin + (_e25.direction * _e26)));
                    rank = (_e26 - ((0.03125 * (m_1.deep * m_1.texel)) * _e67));
                    break;
                }
                default: {
                    break;
                }
            }
            float _e70 = rank;
            float _e71 = least;
            if ((_e70 < _e71)) {
                best = ConstructSeen(_e22, _e26);
                float _e74 = rank;
                least = _e74;
            }
        }
    }
    uint _e80 = impostor.strategy;
    if ((_e80 == 3u)) {
        uint _e86 = best.map;
        local_16 = (_e86 != NO_MAP);
    } else {
        local_16 = false;
    }
    bool _e90 = local_16;
    if (_e90) {
        uint2 loop_bound_11 = uint2(4294967295u, 4294967295u);
        bool loop_init_10 = true;
        while(true) {
            if (all(loop_bound_11 == uint2(0u, 0u))) { break; }
            loop_bound_11 -= uint2(loop_bound_11.y == 0u, 1u);
            if (!loop_init_10) {
                uint _e127 = k_9;
                k_9 = (_e127 + 1u);
            }
            loop_init_10 = false;
            uint _e93 = k_9;
            if ((_e93 < MAPS)) {
            } else {
                break;
            }
            {
                uint _e96 = k_9;
                const uint _e97 = map_of(instance_1, _e96);
                uint _e98 = k_9;
                float _e100 = found[min(uint(_e98), 7u)];
                if ((_e100 < 1e38)) {
                    uint _e105 = k_9;
                    float _e107 = found[min(uint(_e105), 7u)];
                    float _e108 = nearest_1;
                    float _e111 = impostor.wall;
                    float _e115 = asfloat(maps.Load(72+_e97*80));
                    local_17 = !((_e107 > (_e108 + (_e111 * _e115))));
                } else {
                    local_17 = false;
                }
                bool _e121 = local_17;
                if (_e121) {
                    uint _e122 = k_9;
                    float _e124 = found[min(uint(_e122), 7u)];
                    const Seen seen_1 = ConstructSeen(_e97, _e124);
                    return seen_1;
                }
            }
        }
    }
    Seen _e129 = best;
    const Seen seen_2 = _e129;
    return seen_2;
}

float3 lit_(float3 base, float3 normal, float3 position)
{
    float3 out_1 = (float3)0;
    bool local_18 = (bool)0;

    float4 _e5 = frame.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    float4 _e12 = frame.ground;
    float4 _e16 = frame.sky;
    float3 ambient = lerp(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    float4 _e26 = frame.sun;
    out_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = frame.sun.w;
    if ((_e35 > 0.0)) {
        local_18 = (sun > 0.0);
    } else {
        local_18 = false;
    }
    bool _e43 = local_18;
    if (_e43) {
        float4 _e46 = frame.eye;
        float _e51 = frame.eye.w;
        float3 to_eye = normalize((_e46.xyz - (position * _e51)));
        float4 _e57 = frame.to_sun;
        float3 h = normalize((_e57.xyz + to_eye));
        float3 _e61 = out_1;
        float4 _e64 = frame.sun;
        float _e69 = frame.sun.w;
        float _e76 = frame.to_sun.w;
        out_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal, h), 0.0), _e76)) * sun)));
    }
    float3 _e82 = out_1;
    return _e82;
}

float3 shade(Seen seen, Instance instance_2, float3 local_19, float3 position_1, float depth_1)
{
    Map map_11 = ConstructMap(Constructarray3_float4_(asfloat(maps.Load4(seen.map*80+0+0)), asfloat(maps.Load4(seen.map*80+0+16)), asfloat(maps.Load4(seen.map*80+0+32))), asfloat(maps.Load4(seen.map*80+48)), asfloat(maps.Load(seen.map*80+64)), asfloat(maps.Load(seen.map*80+68)), asfloat(maps.Load(seen.map*80+72)), asuint(maps.Load(seen.map*80+76)));
    float4 p_4 = float4(local_19, 1.0);
    uint _e20 = impostor.side;
    float2 uv = (float2(dot(map_11.rows[0], p_4), dot(map_11.rows[1], p_4)) / (float(_e20)).xx);
    float _e26 = frame.sample_size;
    float _e30 = frame.eye.w;
    float sample_ = ((_e26 * ((_e30 > 0.0) ? depth_1 : 1.0)) / (map_11.texel * instance_2.place.w));
    uint _e46 = impostor.levels;
    float level_1 = clamp(log2(max(sample_, 1.0)), 0.0, float((_e46 - 1u)));
    float4 _e55 = color.SampleLevel(smooth_sampler, float3(uv, seen.map), level_1);
    float3 base_1 = _e55.xyz;
    uint _e59 = frame.shading;
    if ((_e59 == 0u)) {
        return base_1;
    }
    float4 _e65 = normals.SampleLevel(smooth_sampler, float3(uv, seen.map), level_1);
    float2 bent = (((_e65.xy * 255.0) - (127.0).xx) / (127.0).xx);
    float out_2 = sqrt(max((1.0 - dot(bent, bent)), 0.0));
    float3 normal_1 = normalize((((map_11.rows[0].xyz * bent.x) - (map_11.rows[1].xyz * bent.y)) - (map_11.rows[2].xyz * out_2)));
    float4 _e101 = emissive.SampleLevel(smooth_sampler, float3(uv, seen.map), level_1);
    uint _e105 = impostor.emits;
    float3 glow = (_e101.xyz * float(_e105));
    const float3 _e109 = turned(normal_1, instance_2.rotation);
    const float3 _e110 = lit_(base_1, _e109, position_1);
    return (_e110 + glow);
}

uint naga_mod(uint lhs, uint rhs) {
    return lhs % (rhs == 0u ? 1u : rhs);
}

Proxy ConstructProxy(float4 arg0, float3 arg1, uint arg2) {
    Proxy ret = (Proxy)0;
    ret.clip_ = arg0;
    ret.position = arg1;
    ret.instance = arg2;
    return ret;
}

Instance ConstructInstance(float4 arg0, float4 arg1, uint4 arg2) {
    Instance ret = (Instance)0;
    ret.place = arg0;
    ret.rotation = arg1;
    ret.maps = arg2;
    return ret;
}

VertexOutput_box_vertex box_vertex(uint index : SV_VertexID, uint number : SV_InstanceID)
{
    bool local = (bool)0;
    bool local_1 = (bool)0;
    bool local_2 = (bool)0;
    uint3 bits = (0u).xxx;
    float4 clip_ = (float4)0;

    uint face = naga_div(index, 6u);
    uint corner_1 = naga_mod(index, 6u);
    if (!((corner_1 == 1u))) {
        local = (corner_1 == 2u);
    } else {
        local = true;
    }
    bool _e14 = local;
    if (!(_e14)) {
        local_1 = (corner_1 == 4u);
    } else {
        local_1 = true;
    }
    bool _e21 = local_1;
    if (!((corner_1 == 2u))) {
        local_2 = (corner_1 >= 4u);
    } else {
        local_2 = true;
    }
    bool _e31 = local_2;
    uint2 across = uint2(uint(_e21), uint(_e31));
    uint axis = (face >> 1u);
    uint side = (face & 1u);
    uint2 along = ((side == 1u) ? across : across.yx);
    bits[min(uint(axis), 2u)] = side;
    bits[min(uint(naga_mod((axis + 1u), 3u)), 2u)] = along.x;
    bits[min(uint(naga_mod((axis + 2u), 3u)), 2u)] = along.y;
    uint3 _e58 = bits;
    float4 _e67 = impostor.extent;
    float3 position_4 = (((float3(_e58) * 2.0) - (1.0).xxx) * _e67.xyz);
    Instance instance_5 = ConstructInstance(asfloat(instances.Load4(number*48+0)), asfloat(instances.Load4(number*48+16)), asuint(instances.Load4(number*48+32)));
    float4 _e77 = impostor.centre;
    const float3 _e81 = turned((position_4 + _e77.xyz), instance_5.rotation);
    float3 world = (instance_5.place.xyz + (_e81 * instance_5.place.w));
    float4x4 _e88 = frame.clip_;
    clip_ = mul(float4(world, 1.0), _e88);
    float _e95 = clip_.w;
    clip_.z = (0.5 * _e95);
    float4 _e98 = clip_;
    const Proxy proxy = ConstructProxy(_e98, position_4, number);
    const VertexOutput_box_vertex proxy_1 = { proxy.position, proxy.instance, proxy.clip_ };
    return proxy_1;
}

Fragment ConstructFragment(float4 arg0, float arg1) {
    Fragment ret = (Fragment)0;
    ret.color = arg0;
    ret.depth = arg1;
    return ret;
}

Fragment ori_fragment(FragmentInput_ori_fragment fragmentinput_ori_fragment)
{
    Proxy in_ = { fragmentinput_ori_fragment.clip_2, fragmentinput_ori_fragment.position_3, fragmentinput_ori_fragment.instance_4 };
    float3 direction = (float3)0;

    Instance instance_6 = ConstructInstance(asfloat(instances.Load4(in_.instance*48+0)), asfloat(instances.Load4(in_.instance*48+16)), asuint(instances.Load4(in_.instance*48+32)));
    float scale = instance_6.place.w;
    float4 _e9 = frame.depth;
    const float3 _e12 = turned_back(_e9.xyz, instance_6.rotation);
    float4 _e15 = frame.eye;
    float _e22 = frame.eye.w;
    const float3 _e26 = turned_back((_e15.xyz - (instance_6.place.xyz * _e22)), instance_6.rotation);
    float4 _e32 = impostor.centre;
    float3 from_eye = (in_.position - ((_e26 / (scale).xxx) - _e32.xyz));
    float _e40 = frame.eye.w;
    direction = ((_e40 > 0.0) ? from_eye : -(_e26));
    float3 _e45 = direction;
    float3 _e46 = direction;
    direction = (_e45 / (dot(_e12, _e46)).xxx);
    float3 _e51 = direction;
    float3 _e56 = direction;
    Ray ray_8 = ConstructRay((in_.position - (_e51 * dot(_e12, in_.position))), _e56);
    float4 _e62 = impostor.centre;
    const float3 _e65 = turned(_e62.xyz, instance_6.rotation);
    float3 centre = (instance_6.place.xyz + (_e65 * scale));
    float4 _e70 = frame.depth;
    float middle_1 = (dot(_e70, float4(centre, 1.0)) / scale);
    float _e78 = frame.near;
    float _e83 = frame.far;
    const Seen _e86 = see(in_.instance, ray_8, ((_e78 / scale) - middle_1), ((_e83 / scale) - middle_1));
    if ((_e86.map == NO_MAP)) {
        discard;
    }
    float4 _e97 = impostor.centre;
    float3 local_20 = ((ray_8.origin + (ray_8.direction * _e86.t)) + _e97.xyz);
    const float3 _e103 = turned(local_20, instance_6.rotation);
    float3 position_5 = (instance_6.place.xyz + (_e103 * scale));
    float4x4 _e108 = frame.clip_;
    float4 clip_3 = mul(float4(position_5, 1.0), _e108);
    float depth_2 = ((middle_1 + _e86.t) * scale);
    float4 _e117 = impostor.centre;
    const float3 _e120 = shade(_e86, instance_6, (local_20 - _e117.xyz), position_5, depth_2);
    const Fragment fragment = ConstructFragment(float4(_e120, 1.0), (clip_3.z / clip_3.w));
    return fragment;
}
