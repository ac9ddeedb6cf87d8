#version 450 core
struct Frame {
    mat4x4 clip;
    vec4 depth;
    vec4 eye;
    vec4 to_sun;
    vec4 sun;
    vec4 sky;
    vec4 ground;
    vec4 background;
    uint shading;
    float period;
    uint samples;
    uint layers;
};
struct Reference {
    vec4 texel;
    float spread;
    float slack;
    float weight;
    float quality;
    float mapped;
};
struct Depth {
    vec4 clip;
    float depth;
};
struct Fragment {
    vec4 clip;
    vec3 position;
    vec3 normal;
    vec3 ratios;
    float quality;
    float depth;
};
layout(std140) uniform Frame_block_0Fragment { Frame _group_0_binding_0_fs; };

uniform sampler2DArray _group_1_binding_5_fs;

layout(location = 0) out vec4 _fs2p_location0;

vec3 lit(vec3 base, vec3 normal_1, vec3 position_2) {
    vec3 color_1 = vec3(0.0);
    bool local_1 = false;
    vec4 _e5 = _group_0_binding_0_fs.to_sun;
    float sun = max(dot(normal_1, _e5.xyz), 0.0);
    vec4 _e12 = _group_0_binding_0_fs.ground;
    vec4 _e16 = _group_0_binding_0_fs.sky;
    vec3 ambient = mix(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal_1.y)));
    vec4 _e26 = _group_0_binding_0_fs.sun;
    color_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = _group_0_binding_0_fs.sun.w;
    if ((_e35 > 0.0)) {
        local_1 = (sun > 0.0);
    } else {
        local_1 = false;
    }
    bool _e43 = local_1;
    if (_e43) {
        vec4 _e46 = _group_0_binding_0_fs.eye;
        float _e51 = _group_0_binding_0_fs.eye.w;
        vec3 to_eye = normalize((_e46.xyz - (position_2 * _e51)));
        vec4 _e57 = _group_0_binding_0_fs.to_sun;
        vec3 h_1 = normalize((_e57.xyz + to_eye));
        vec3 _e61 = color_1;
        vec4 _e64 = _group_0_binding_0_fs.sun;
        float _e69 = _group_0_binding_0_fs.sun.w;
        float _e76 = _group_0_binding_0_fs.to_sun.w;
        color_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal_1, h_1), 0.0), _e76)) * sun)));
    }
    vec3 _e82 = color_1;
    return _e82;
}

float hash(uvec3 p, uint seed) {
    uint h = 0u;
    uint k_1 = 0u;
    h = seed;
    bool loop_init = true;
    while(true) {
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
            h = ((_e8 ^ p[_e9]) * 2246822507u);
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

float octave(vec3 p_1, uint seed_1) {
    vec3 t = vec3(0.0);
    float sum_1 = 0.0;
    uint corner = 0u;
    vec3 cell = floor(p_1);
    t = (p_1 - cell);
    vec3 _e5 = t;
    vec3 _e6 = t;
    vec3 _e8 = t;
    t = ((_e5 * _e6) * (vec3(3.0) - (2.0 * _e8)));
    uvec3 first = uvec3(ivec3(cell));
    bool loop_init_1 = true;
    while(true) {
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
            uvec3 bits = uvec3((_e24 & 1u), ((_e27 >> 1u) & 1u), (_e32 >> 2u));
            vec3 _e36 = t;
            vec3 _e40 = t;
            vec3 side = mix((vec3(1.0) - _e36), _e40, vec3(bits));
            float _e43 = sum_1;
            float _e50 = hash((first + bits), seed_1);
            sum_1 = (_e43 + (((side.x * side.y) * side.z) * _e50));
        }
    }
    float _e56 = sum_1;
    return _e56;
}

float noise(vec3 position_3) {
    float _e3 = _group_0_binding_0_fs.period;
    vec3 q = (position_3 / vec3(_e3));
    float _e7 = octave(q, 0u);
    float _e15 = octave((q * 4.0), 1u);
    return ((0.05 + (0.6 * _e7)) + (0.3 * _e15));
}

vec3 shade(vec3 base_1, vec3 normal_2, vec3 position_4) {
    uint _e5 = _group_0_binding_0_fs.shading;
    switch(_e5) {
        case 1u: {
            vec3 _e6 = lit(base_1, normal_2, position_4);
            return _e6;
        }
        case 2u: {
            float _e7 = noise(position_4);
            return (base_1 * _e7);
        }
        default: {
            return base_1;
        }
    }
}

void main() {
    vec4 at = gl_FragCoord;
    vec3 sum = vec3(0.0);
    int i = 0;
    vec3 color = vec3(0.0);
    float alpha = 0.0;
    uint k = 0u;
    uint _e3 = _group_0_binding_0_fs.samples;
    int n = int(_e3);
    ivec2 first_1 = (ivec2(at.xy) * n);
    bool loop_init_2 = true;
    while(true) {
        if (!loop_init_2) {
            int _e65 = i;
            i = (_e65 + 1);
        }
        loop_init_2 = false;
        int _e13 = i;
        if ((_e13 < (n * n))) {
        } else {
            break;
        }
        {
            int _e16 = i;
            int _e18 = i;
            ivec2 sample_ = (first_1 + ivec2((_e16 % n), (_e18 / n)));
            color = vec3(0.0);
            alpha = 0.0;
            k = 0u;
            bool loop_init_3 = true;
            while(true) {
                if (!loop_init_3) {
                    uint _e47 = k;
                    k = (_e47 + 1u);
                }
                loop_init_3 = false;
                uint _e29 = k;
                uint _e32 = _group_0_binding_0_fs.layers;
                if ((_e29 < _e32)) {
                } else {
                    break;
                }
                {
                    uint _e35 = k;
                    vec4 c = texelFetch(_group_1_binding_5_fs, ivec3(sample_, _e35), 0);
                    vec3 _e38 = color;
                    color = (_e38 + (c.xyz * c.w));
                    float _e43 = alpha;
                    alpha = (_e43 + c.w);
                }
            }
            float _e49 = alpha;
            if ((_e49 > 0.0)) {
                vec3 _e52 = sum;
                vec3 _e53 = color;
                float _e54 = alpha;
                sum = (_e52 + (_e53 / vec3(_e54)));
            } else {
                vec3 _e58 = sum;
                vec4 _e61 = _group_0_binding_0_fs.background;
                sum = (_e58 + _e61.xyz);
            }
        }
    }
    vec3 _e67 = sum;
    _fs2p_location0 = vec4((_e67 / vec3(float((n * n)))), 1.0);
    return;
}

