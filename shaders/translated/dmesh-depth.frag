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
layout(location = 0) smooth in float _vs2fs_location0;
layout(location = 0) out vec4 _fs2p_location0;

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

void main() {
    Depth in_ = Depth(gl_FragCoord, _vs2fs_location0);
    _fs2p_location0 = vec4(in_.depth, 0.0, 0.0, 0.0);
    return;
}

