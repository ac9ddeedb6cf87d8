struct Sprite {
    float4 world_to_texture[3];
    uint4 region;
    uint4 sections;
    uint2 size;
    uint packing;
    uint depth_complexity;
    uint depth_base;
    float depth_step;
    int _end_pad_0;
    int _end_pad_1;
};

static const uint SPRITE_OUTSIDE = 0u;
static const uint SPRITE_BORDER = 1u;
static const uint SPRITE_INSIDE = 2u;

ByteAddressBuffer sprites : register(t0);
ByteAddressBuffer sprite_data : register(t1);
ByteAddressBuffer points : register(t2);
RWByteAddressBuffer inside : register(u3);

float3 sprite_texture(uint i, float3 world)
{
    float4 p_2 = float4(world, 1.0);
    float4 _e8 = asfloat(sprites.Load4(0+0+i*112));
    float4 _e14 = asfloat(sprites.Load4(16+0+i*112));
    float4 _e20 = asfloat(sprites.Load4(32+0+i*112));
    return float3(dot(_e8, p_2), dot(_e14, p_2), dot(_e20, p_2));
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / (rhs == 0u ? 1u : rhs);
}

uint naga_mod(uint lhs, uint rhs) {
    return lhs % (rhs == 0u ? 1u : rhs);
}

uint prefix(uint section, uint texel)
{
    uint _e7 = asuint(sprite_data.Load((section + naga_div(texel, 2u))*4));
    return ((_e7 >> (16u * naga_mod(texel, 2u))) & 65535u);
}

uint words_of_range(uint i_1)
{
    float _e6 = asfloat(sprites.Load(100+i_1*112));
    return ((_e6 == 0.0) ? 2u : 1u);
}

uint2 in_runs(uint i_2, uint2 p)
{
    uint low = (uint)0;
    uint high = (uint)0;

    uint4 sections = asuint(sprites.Load4(64+i_2*112));
    uint _e11 = asuint(sprite_data.Load((sections.x + p.y)*4));
    low = _e11;
    uint begin = low;
    uint _e21 = asuint(sprite_data.Load(((sections.x + p.y) + 1u)*4));
    high = _e21;
    uint2 loop_bound = uint2(4294967295u, 4294967295u);
    while(true) {
        if (all(loop_bound == uint2(0u, 0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        uint _e23 = low;
        uint _e24 = high;
        if ((_e23 < _e24)) {
        } else {
            break;
        }
        {
            uint _e26 = low;
            uint _e27 = high;
            uint middle = naga_div((_e26 + _e27), 2u);
            uint _e37 = asuint(sprite_data.Load((sections.y + (3u * middle))*4));
            if (((_e37 & 65535u) <= p.x)) {
                low = (middle + 1u);
            } else {
                high = middle;
            }
        }
    }
    uint _e44 = low;
    if ((_e44 == begin)) {
        return (0u).xx;
    }
    uint _e50 = low;
    uint run = (sections.y + (3u * (_e50 - 1u)));
    uint place = asuint(sprite_data.Load(run*4));
    uint along = (p.x - (place & 65535u));
    if ((along >= (place >> 16u))) {
        return (0u).xx;
    }
    uint count_1 = asuint(sprite_data.Load((run + 1u)*4));
    const uint _e73 = words_of_range(i_2);
    uint _e78 = asuint(sprite_data.Load((run + 2u)*4));
    return uint2((sections.z + (_e73 * (_e78 + (along * count_1)))), count_1);
}

uint2 sprite_ranges(uint i_3, uint2 p_1)
{
    uint end = (uint)0;

    uint4 sections_1 = asuint(sprites.Load4(64+i_3*112));
    uint width = asuint(sprites.Load(8+48+i_3*112));
    uint texel_2 = ((p_1.y * width) + p_1.x);
    uint _e18 = asuint(sprites.Load(88+i_3*112));
    switch(_e18) {
        case 0u: {
            uint _e24 = asuint(sprites.Load(92+i_3*112));
            return uint2((sections_1.x + texel_2), naga_div(_e24, 2u));
        }
        case 1u: {
            uint at = (sections_1.x + (2u * texel_2));
            uint _e36 = asuint(sprite_data.Load(at*4));
            uint _e43 = asuint(sprite_data.Load((at + 1u)*4));
            return uint2((sections_1.x + (2u * _e36)), _e43);
        }
        case 2u: {
            uint before = asuint(sprite_data.Load((sections_1.x + p_1.y)*4));
            const uint _e52 = prefix(sections_1.y, texel_2);
            uint first_1 = (before + _e52);
            uint _e61 = asuint(sprite_data.Load(((sections_1.x + p_1.y) + 1u)*4));
            end = _e61;
            if (((p_1.x + 1u) < width)) {
                const uint _e70 = prefix(sections_1.y, (texel_2 + 1u));
                end = (before + _e70);
            }
            const uint _e73 = words_of_range(i_3);
            uint _e76 = end;
            return uint2((sections_1.z + (_e73 * first_1)), (_e76 - first_1));
        }
        default: {
            const uint2 _e79 = in_runs(i_3, p_1);
            return _e79;
        }
    }
}

float2 sprite_range(uint i_4, uint first, uint k)
{
    bool local_1 = (bool)0;

    uint _e6 = asuint(sprites.Load(88+i_4*112));
    if ((_e6 == 0u)) {
        uint _e13 = asuint(sprites.Load(8+48+i_4*112));
        uint _e18 = asuint(sprites.Load(12+48+i_4*112));
        uint n_1 = (_e13 * _e18);
        uint at_1 = (first + ((2u * k) * n_1));
        uint _e26 = asuint(sprite_data.Load(at_1*4));
        uint _e31 = asuint(sprite_data.Load((at_1 + n_1)*4));
        return float2(asfloat(_e26), asfloat(_e31));
    }
    uint _e37 = asuint(sprites.Load(88+i_4*112));
    if ((_e37 > 1u)) {
        float _e45 = asfloat(sprites.Load(100+i_4*112));
        local_1 = (_e45 > 0.0);
    } else {
        local_1 = false;
    }
    bool _e49 = local_1;
    if (_e49) {
        uint word = asuint(sprite_data.Load((first + k)*4));
        uint _e62 = asuint(sprites.Load(96+i_4*112));
        uint2 steps = (uint2((word & 65535u), (word >> 16u)) + (_e62).xx);
        float _e69 = asfloat(sprites.Load(100+i_4*112));
        return (float2(steps) * _e69);
    }
    uint at_2 = (first + (2u * k));
    uint _e76 = asuint(sprite_data.Load(at_2*4));
    uint _e82 = asuint(sprite_data.Load((at_2 + 1u)*4));
    return float2(asfloat(_e76), asfloat(_e82));
}

uint2 naga_f2u32(float2 value) {
    return uint2(clamp(value, 0.0, 4294967000.0));
}

bool sprite_contains(uint i_5, float3 point_)
{
    bool local_2 = (bool)0;
    bool local_3 = (bool)0;
    bool local_4 = (bool)0;
    uint k_1 = 0u;
    bool local_5 = (bool)0;

    if ((point_.x >= 0.0)) {
        local_2 = (point_.x < 1.0);
    } else {
        local_2 = false;
    }
    bool _e11 = local_2;
    if (_e11) {
        local_3 = (point_.y >= 0.0);
    } else {
        local_3 = false;
    }
    bool _e18 = local_3;
    if (_e18) {
        local_4 = (point_.y < 1.0);
    } else {
        local_4 = false;
    }
    bool _e25 = local_4;
    if (!(_e25)) {
        return false;
    }
    uint2 _e32 = asuint(sprites.Load2(80+i_5*112));
    uint2 texel_3 = naga_f2u32((point_.xy * float2(_e32)));
    uint4 _e39 = asuint(sprites.Load4(48+i_5*112));
    if (any((texel_3 < _e39.xy))) {
        return false;
    }
    uint4 _e47 = asuint(sprites.Load4(48+i_5*112));
    uint2 p_3 = (texel_3 - _e47.xy);
    uint4 _e53 = asuint(sprites.Load4(48+i_5*112));
    if (any((p_3 >= _e53.zw))) {
        return false;
    }
    const uint2 _e58 = sprite_ranges(i_5, p_3);
    uint2 loop_bound_1 = uint2(4294967295u, 4294967295u);
    bool loop_init = true;
    while(true) {
        if (all(loop_bound_1 == uint2(0u, 0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init) {
            uint _e84 = k_1;
            k_1 = (_e84 + 1u);
        }
        loop_init = false;
        uint _e61 = k_1;
        if ((_e61 < _e58.y)) {
        } else {
            break;
        }
        {
            uint _e65 = k_1;
            const float2 _e66 = sprite_range(i_5, _e58.x, _e65);
            if (!((_e66.x > point_.z))) {
                local_5 = (_e66.x == 1.0);
            } else {
                local_5 = true;
            }
            bool _e77 = local_5;
            if (_e77) {
                return false;
            }
            if ((point_.z <= _e66.y)) {
                return true;
            }
        }
    }
    return false;
}

uint sprite_zone(uint i_6, float3 world_1, float half_)
{
    uint count = 0u;
    uint k_2 = 0u;

    uint2 loop_bound_2 = uint2(4294967295u, 4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (all(loop_bound_2 == uint2(0u, 0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e38 = k_2;
            k_2 = (_e38 + 1u);
        }
        loop_init_1 = false;
        uint _e7 = k_2;
        if ((_e7 < 8u)) {
        } else {
            break;
        }
        {
            uint _e10 = k_2;
            uint _e14 = k_2;
            uint _e20 = k_2;
            float3 corner = ((float3(float((_e10 & 1u)), float(((_e14 >> 1u) & 1u)), float((_e20 >> 2u))) * 2.0) - (1.0).xxx);
            uint _e30 = count;
            const float3 _e33 = sprite_texture(i_6, (world_1 + (corner * half_)));
            const bool _e34 = sprite_contains(i_6, _e33);
            count = (_e30 + uint(_e34));
        }
    }
    uint _e40 = count;
    if ((_e40 == 0u)) {
        return SPRITE_OUTSIDE;
    }
    uint _e46 = count;
    return ((_e46 == 8u) ? SPRITE_INSIDE : SPRITE_BORDER);
}

int2 naga_f2i32(float2 value) {
    return int2(clamp(value, -2147483600.0, 2147483500.0));
}

float2 sprite_enter(uint i_7, float3 origin, float3 direction)
{
    float t = 0.0;
    float last = 3.4e38;
    uint k_3 = 0u;
    bool local_6 = (bool)0;
    int2 texel_1 = (int2)0;
    float2 found = (float2)0;
    bool touched = (bool)0;
    uint n = (uint)0;
    float2 part = (float2)0;
    bool local_7 = (bool)0;
    bool local_8 = (bool)0;
    bool local_9 = (bool)0;
    bool local_10 = (bool)0;
    bool local_11 = (bool)0;

    float2 none = float2(1.0, 0.0);
    uint2 _e9 = asuint(sprites.Load2(80+i_7*112));
    float3 size = float3(float2(_e9), 1.0);
    uint4 _e16 = asuint(sprites.Load4(48+i_7*112));
    float3 end_1 = float3(float2(_e16.zw), 1.0);
    const float3 _e21 = sprite_texture(i_7, origin);
    uint4 _e26 = asuint(sprites.Load4(48+i_7*112));
    float3 o = ((_e21 * size) - float3(float2(_e26.xy), 0.0));
    const float3 _e33 = sprite_texture(i_7, (origin + direction));
    const float3 _e34 = sprite_texture(i_7, origin);
    float3 d = ((_e33 - _e34) * size);
    uint2 loop_bound_3 = uint2(4294967295u, 4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (all(loop_bound_3 == uint2(0u, 0u))) { break; }
        loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
        if (!loop_init_2) {
            uint _e85 = k_3;
            k_3 = (_e85 + 1u);
        }
        loop_init_2 = false;
        uint _e43 = k_3;
        if ((_e43 < 3u)) {
        } else {
            break;
        }
        {
            uint _e46 = k_3;
            if ((d[min(uint(_e46), 2u)] == 0.0)) {
                uint _e50 = k_3;
                if ((o[min(uint(_e50), 2u)] >= 0.0)) {
                    uint _e56 = k_3;
                    uint _e58 = k_3;
                    local_6 = (o[min(uint(_e56), 2u)] < end_1[min(uint(_e58), 2u)]);
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
                float a = (-(o[min(uint(_e64), 2u)]) / d[min(uint(_e67), 2u)]);
                uint _e70 = k_3;
                uint _e72 = k_3;
                uint _e75 = k_3;
                float b = ((end_1[min(uint(_e70), 2u)] - o[min(uint(_e72), 2u)]) / d[min(uint(_e75), 2u)]);
                float _e78 = t;
                t = max(_e78, min(a, b));
                float _e81 = last;
                last = min(_e81, max(a, b));
            }
        }
    }
    uint4 _e90 = asuint(sprites.Load4(48+i_7*112));
    int2 limit = int2(_e90.zw);
    float _e95 = t;
    texel_1 = clamp(naga_f2i32(floor((o.xy + (d.xy * _e95)))), (int(0)).xx, asint(asuint(limit) - asuint((int(1)).xx)));
    int2 step_ = naga_f2i32(sign(d.xy));
    found = none;
    uint2 loop_bound_4 = uint2(4294967295u, 4294967295u);
    while(true) {
        if (all(loop_bound_4 == uint2(0u, 0u))) { break; }
        loop_bound_4 -= uint2(loop_bound_4.y == 0u, 1u);
        float _e111 = t;
        float _e112 = last;
        if ((_e111 < _e112)) {
        } else {
            break;
        }
        {
            int2 _e114 = texel_1;
            float2 border = float2(asint(asuint(_e114) + asuint(max(step_, (int(0)).xx))));
            float2 next = ((step_ == (int(0)).xx) ? (3.4e38).xx : ((border - o.xy) / d.xy));
            float _e133 = last;
            float until = min(min(next.x, next.y), _e133);
            float _e135 = t;
            if ((_e135 < until)) {
                int2 _e137 = texel_1;
                const uint2 _e139 = sprite_ranges(i_7, uint2(_e137));
                touched = false;
                n = 0u;
                uint2 loop_bound_5 = uint2(4294967295u, 4294967295u);
                bool loop_init_3 = true;
                while(true) {
                    if (all(loop_bound_5 == uint2(0u, 0u))) { break; }
                    loop_bound_5 -= uint2(loop_bound_5.y == 0u, 1u);
                    if (!loop_init_3) {
                        uint _e228 = n;
                        n = (_e228 + 1u);
                    }
                    loop_init_3 = false;
                    uint _e144 = n;
                    if ((_e144 < _e139.y)) {
                    } else {
                        break;
                    }
                    {
                        uint _e147 = n;
                        uint _e151 = n;
                        uint k_4 = ((d.z < 0.0) ? ((_e139.y - 1u) - _e151) : _e147);
                        const float2 _e158 = sprite_range(i_7, _e139.x, k_4);
                        float _e159 = t;
                        part = float2(_e159, until);
                        if ((d.z == 0.0)) {
                            float2 _e165 = part;
                            if ((_e158.x <= o.z)) {
                                local_7 = (o.z <= _e158.y);
                            } else {
                                local_7 = false;
                            }
                            bool _e175 = local_7;
                            part = (_e175 ? _e165 : none);
                        } else {
                            float2 at_3 = ((_e158 - (o.z).xx) / (d.z).xx);
                            float _e183 = t;
                            part = float2(max(_e183, min(at_3.x, at_3.y)), min(until, max(at_3.x, at_3.y)));
                        }
                        if (!((_e158.x == 1.0))) {
                            float _e200 = part.x;
                            float _e202 = part.y;
                            local_8 = (_e200 >= _e202);
                        } else {
                            local_8 = true;
                        }
                        bool _e205 = local_8;
                        if (_e205) {
                            continue;
                        }
                        float _e207 = found.x;
                        float _e209 = found.y;
                        if ((_e207 > _e209)) {
                            float2 _e211 = part;
                            found = _e211;
                        } else {
                            float _e213 = part.x;
                            float _e215 = found.y;
                            if ((_e213 <= _e215)) {
                                float _e219 = found.y;
                                float _e221 = part.y;
                                found.y = max(_e219, _e221);
                            } else {
                                float2 _e223 = found;
                                return _e223;
                            }
                        }
                        float _e225 = found.y;
                        touched = (_e225 >= until);
                    }
                }
                float _e231 = found.x;
                float _e233 = found.y;
                if ((_e231 <= _e233)) {
                    bool _e237 = touched;
                    local_9 = !(_e237);
                } else {
                    local_9 = false;
                }
                bool _e240 = local_9;
                if (_e240) {
                    float2 _e241 = found;
                    return _e241;
                }
                t = until;
            }
            uint along_1 = uint((next.y < next.x));
            int _e247 = texel_1[min(uint(along_1), 1u)];
            texel_1[min(uint(along_1), 1u)] = asint(asuint(_e247) + asuint(step_[min(uint(along_1), 1u)]));
            if (!((step_[min(uint(along_1), 1u)] == int(0)))) {
                int _e257 = texel_1[min(uint(along_1), 1u)];
                local_10 = (_e257 < int(0));
            } else {
                local_10 = true;
            }
            bool _e261 = local_10;
            if (!(_e261)) {
                int _e266 = texel_1[min(uint(along_1), 1u)];
                local_11 = (_e266 >= limit[min(uint(along_1), 1u)]);
            } else {
                local_11 = true;
            }
            bool _e270 = local_11;
            if (_e270) {
                break;
            }
        }
    }
    float2 _e271 = found;
    return _e271;
}

uint NagaBufferLength(ByteAddressBuffer buffer)
{
    uint ret;
    buffer.GetDimensions(ret);
    return ret;
}

[numthreads(64, 1, 1)]
void classify(uint3 id : SV_DispatchThreadID, uint3 groups : SV_GroupID)
{
    bool local = (bool)0;

    uint i_8 = (((id.y * groups.x) * 64u) + id.x);
    if ((i_8 < ((NagaBufferLength(points) - 0) / 16))) {
        float4 _e17 = asfloat(points.Load4(i_8*16));
        const bool _e19 = sprite_contains(0u, _e17.xyz);
        local = _e19;
    } else {
        local = false;
    }
    bool _e21 = local;
    if (_e21) {
        uint _e30; inside.InterlockedOr(naga_div(i_8, 32u)*4, (1u << naga_mod(i_8, 32u)), _e30);
        return;
    } else {
        return;
    }
}
