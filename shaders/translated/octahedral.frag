#version 450 core
struct Frame {
    mat4x4 clip;
    vec4 depth;
    vec4 eye;
    vec4 to_sun;
    vec4 sun;
    vec4 sky;
    vec4 ground;
    uint shading;
    float sample_size;
};
struct Impostor {
    vec4 window;
    vec4 card[4];
    uint corners;
    uint frames;
    uint tile;
    uint levels;
    uint hemi;
    uint steps;
    uint emits;
};
struct Card {
    vec4 clip;
    vec3 position;
};
struct Blend {
    vec3 color;
    vec3 normal;
    vec3 emissive;
    float t;
    float coverage;
    float weight;
};
struct Camera {
    vec2 point;
    vec3 right;
    vec3 up;
    vec3 start;
    vec3 ray;
    float middle;
    float slope;
    float level;
    float edge;
};
struct Met {
    vec2 atlas;
    bool covered;
    float gap;
    bool below;
};
struct Fragment {
    vec4 color;
    float depth;
};
const uint BISECTIONS = 5u;

layout(std140) uniform Frame_block_0Fragment { Frame _group_0_binding_0_fs; };

layout(std140) uniform Impostor_block_1Fragment { Impostor _group_0_binding_1_fs; };

uniform sampler2D _group_0_binding_2_fs;

uniform sampler2D _group_0_binding_3_fs;

uniform sampler2D _group_0_binding_4_fs;

layout(location = 0) smooth in vec3 _vs2fs_location0;
layout(location = 0) out vec4 _fs2p_location0;

vec3 towards_eye() {
    float _e3 = _group_0_binding_0_fs.eye.w;
    if ((_e3 > 0.0)) {
        vec4 _e8 = _group_0_binding_0_fs.eye;
        vec4 _e12 = _group_0_binding_1_fs.window;
        return normalize((_e8.xyz - _e12.xyz));
    }
    vec4 _e18 = _group_0_binding_0_fs.eye;
    return _e18.xyz;
}

vec3 right_of(vec3 d) {
    if ((dot(d.xz, d.xz) < 1e-12)) {
        return normalize(cross(vec3(0.0, 0.0, 1.0), d));
    }
    return normalize(cross(vec3(0.0, 1.0, 0.0), d));
}

vec2 sign_of(vec2 v) {
    return mix(vec2(1.0), vec2(-1.0), lessThan(v, vec2(0.0)));
}

vec2 grid_of(vec3 direction) {
    vec3 d_1 = vec3(0.0);
    vec2 e = vec2(0.0);
    uint _e3 = _group_0_binding_1_fs.frames;
    float last = float((_e3 - 1u));
    d_1 = direction;
    uint _e10 = _group_0_binding_1_fs.hemi;
    if ((_e10 > 0u)) {
        float _e15 = d_1.y;
        d_1.y = max(_e15, 0.001);
    }
    vec3 _e18 = d_1;
    float _e20 = d_1.x;
    float _e23 = d_1.y;
    float _e27 = d_1.z;
    vec3 p = (_e18 / vec3(((abs(_e20) + abs(_e23)) + abs(_e27))));
    e = p.xz;
    uint _e36 = _group_0_binding_1_fs.hemi;
    if ((_e36 > 0u)) {
        e = vec2((p.x + p.z), (p.x - p.z));
    } else {
        if ((p.y < 0.0)) {
            vec2 _e55 = sign_of(p.xz);
            e = ((vec2(1.0) - abs(p.zx)) * _e55);
        }
    }
    vec2 _e57 = e;
    return clamp((((_e57 * 0.5) + vec2(0.5)) * last), vec2(0.0), vec2(last));
}

vec3 direction_of(vec2 point) {
    uint _e3 = _group_0_binding_1_fs.frames;
    vec2 e_1 = (((point / vec2(float((_e3 - 1u)))) * 2.0) - vec2(1.0));
    uint _e16 = _group_0_binding_1_fs.hemi;
    if ((_e16 > 0u)) {
        vec2 p_1 = (vec2((e_1.x + e_1.y), (e_1.x - e_1.y)) * 0.5);
        return normalize(vec3(p_1.x, max(((1.0 - abs(p_1.x)) - abs(p_1.y)), 0.0), p_1.y));
    }
    float y = ((1.0 - abs(e_1.x)) - abs(e_1.y));
    vec2 _e53 = sign_of(e_1);
    vec2 p_2 = ((y < 0.0) ? ((vec2(1.0) - abs(e_1.yx)) * _e53) : e_1);
    return normalize(vec3(p_2.x, y, p_2.y));
}

Met look(Camera camera, float height) {
    bool local_1 = false;
    vec3 p_3 = (camera.start + (camera.ray * (camera.middle + (height / camera.slope))));
    vec2 uv = (vec2((dot(p_3, camera.right) + 1.0), (1.0 - dot(p_3, camera.up))) * 0.5);
    uint _e32 = _group_0_binding_1_fs.frames;
    vec2 atlas = ((camera.point + clamp(uv, vec2(camera.edge), vec2((1.0 - camera.edge)))) / vec2(float(_e32)));
    if (!(any(lessThan(uv, vec2(0.0))))) {
        local_1 = any(greaterThan(uv, vec2(1.0)));
    } else {
        local_1 = true;
    }
    bool _e48 = local_1;
    if (_e48) {
        return Met(atlas, false, 0.0, false);
    }
    vec4 _e56 = textureLod(_group_0_binding_2_fs, vec2(atlas), camera.level);
    if ((_e56.w < 0.5)) {
        return Met(atlas, false, 0.0, false);
    }
    vec4 _e67 = textureLod(_group_0_binding_3_fs, vec2(atlas), camera.level);
    float gap = (height - ((_e67.w * 2.0) - 1.0));
    return Met(atlas, true, gap, (gap < 0.0));
}

void add(inout Blend blend_1, vec2 point_1, float weight, vec3 origin, vec3 ray_1, float depth) {
    bool local_2 = false;
    Met met = Met(vec2(0.0), false, 0.0, false);
    bool hidden = false;
    bool found = false;
    Met before = Met(vec2(0.0), false, 0.0, false);
    uint i = 1u;
    bool local_3 = false;
    float high = 0.0;
    float low = 0.0;
    bool local_4 = false;
    bool above = false;
    uint k = 0u;
    bool local_5 = false;
    bool local_6 = false;
    vec3 _e6 = direction_of(point_1);
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
    vec3 _e22 = right_of(_e6);
    vec3 up = cross(_e6, _e22);
    float radius = _group_0_binding_1_fs.window.w;
    vec4 _e30 = _group_0_binding_1_fs.window;
    vec3 start = (origin - _e30.xyz);
    float middle = (-(dot(start, _e6)) / slope);
    float _e40 = _group_0_binding_0_fs.eye.w;
    float far = ((_e40 > 0.0) ? (depth + middle) : 1.0);
    float _e47 = _group_0_binding_0_fs.sample_size;
    uint _e51 = _group_0_binding_1_fs.tile;
    float texels = (((_e47 * far) * float(_e51)) / (2.0 * radius));
    uint _e62 = _group_0_binding_1_fs.levels;
    float level = clamp(log2(max(texels, 1.0)), 0.0, float((_e62 - 1u)));
    uint _e70 = _group_0_binding_1_fs.tile;
    float edge = (0.5 / float((_e70 >> uint(ceil(level)))));
    Camera camera_1 = Camera(point_1, _e22, up, (start / vec3(radius)), (ray_1 / vec3(radius)), middle, (slope / radius), level, edge);
    Met _e84 = look(camera_1, 0.0);
    met = _e84;
    uint _e88 = _group_0_binding_1_fs.steps;
    if ((_e88 > 0u)) {
        uint _e96 = _group_0_binding_1_fs.tile;
        float wall = ((6.0 * exp2(level)) / float(_e96));
        Met _e104 = look(camera_1, 1.0);
        before = _e104;
        bool loop_init = true;
        while(true) {
            if (!loop_init) {
                uint _e193 = i;
                i = (_e193 + 1u);
            }
            loop_init = false;
            uint _e108 = i;
            uint _e111 = _group_0_binding_1_fs.steps;
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
                uint _e127 = _group_0_binding_1_fs.steps;
                high = (1.0 - ((2.0 * float((_e119 - 1u))) / float(_e127)));
                uint _e133 = i;
                uint _e139 = _group_0_binding_1_fs.steps;
                low = (1.0 - ((2.0 * float(_e133)) / float(_e139)));
                float _e145 = low;
                Met _e146 = look(camera_1, _e145);
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
                    bool loop_init_1 = true;
                    while(true) {
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
                            Met _e168 = look(camera_1, half_);
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
    vec2 _e209 = met.atlas;
    vec4 data = textureLod(_group_0_binding_3_fs, vec2(_e209), level);
    float t = (middle + ((((data.w * 2.0) - 1.0) * radius) / slope));
    float _e220 = blend_1.coverage;
    blend_1.coverage = (_e220 + weight);
    float _e223 = blend_1.t;
    blend_1.t = (_e223 + (t * weight));
    vec3 _e227 = blend_1.color;
    vec2 _e231 = met.atlas;
    vec4 _e232 = textureLod(_group_0_binding_2_fs, vec2(_e231), level);
    blend_1.color = (_e227 + (_e232.xyz * weight));
    vec3 _e237 = blend_1.normal;
    blend_1.normal = (_e237 + (((data.xyz * 2.0) - vec3(1.0)) * weight));
    vec3 _e247 = blend_1.emissive;
    vec2 _e251 = met.atlas;
    vec4 _e252 = textureLod(_group_0_binding_4_fs, vec2(_e251), level);
    uint _e256 = _group_0_binding_1_fs.emits;
    blend_1.emissive = (_e247 + (_e252.xyz * (weight * float(_e256))));
    return;
}

vec3 lit(vec3 base, vec3 normal, vec3 position) {
    vec3 color_1 = vec3(0.0);
    bool local_7 = false;
    vec4 _e5 = _group_0_binding_0_fs.to_sun;
    float sun = max(dot(normal, _e5.xyz), 0.0);
    vec4 _e12 = _group_0_binding_0_fs.ground;
    vec4 _e16 = _group_0_binding_0_fs.sky;
    vec3 ambient = mix(_e12.xyz, _e16.xyz, (0.5 + (0.5 * normal.y)));
    vec4 _e26 = _group_0_binding_0_fs.sun;
    color_1 = (base * ((_e26.xyz * sun) + ambient));
    float _e35 = _group_0_binding_0_fs.sun.w;
    if ((_e35 > 0.0)) {
        local_7 = (sun > 0.0);
    } else {
        local_7 = false;
    }
    bool _e43 = local_7;
    if (_e43) {
        vec4 _e46 = _group_0_binding_0_fs.eye;
        float _e51 = _group_0_binding_0_fs.eye.w;
        vec3 to_eye = normalize((_e46.xyz - (position * _e51)));
        vec4 _e57 = _group_0_binding_0_fs.to_sun;
        vec3 h = normalize((_e57.xyz + to_eye));
        vec3 _e61 = color_1;
        vec4 _e64 = _group_0_binding_0_fs.sun;
        float _e69 = _group_0_binding_0_fs.sun.w;
        float _e76 = _group_0_binding_0_fs.to_sun.w;
        color_1 = (_e61 + (_e64.xyz * ((_e69 * pow(max(dot(normal, h), 0.0), _e76)) * sun)));
    }
    vec3 _e82 = color_1;
    return _e82;
}

void main() {
    Card in_ = Card(gl_FragCoord, _vs2fs_location0);
    vec3 ray = vec3(0.0);
    Blend blend = Blend(vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);
    bool local = false;
    vec3 color = vec3(0.0);
    vec3 _e1 = towards_eye();
    vec4 _e5 = _group_0_binding_0_fs.eye;
    ray = (in_.position - _e5.xyz);
    float _e12 = _group_0_binding_0_fs.eye.w;
    if ((_e12 == 0.0)) {
        ray = -(_e1);
    }
    vec3 _e16 = ray;
    vec4 _e19 = _group_0_binding_0_fs.depth;
    vec3 _e21 = ray;
    ray = (_e16 / vec3(dot(_e19.xyz, _e21)));
    vec4 _e27 = _group_0_binding_0_fs.depth;
    float depth_1 = dot(_e27, vec4(in_.position, 1.0));
    vec2 _e32 = grid_of(_e1);
    uint _e36 = _group_0_binding_1_fs.frames;
    vec2 cell = min(floor(_e32), vec2(float((_e36 - 2u))));
    vec2 f = (_e32 - cell);
    bool across = (f.x >= f.y);
    vec2 side = (across ? vec2(1.0, 0.0) : vec2(0.0, 1.0));
    vec3 _e70 = ray;
    add(blend, cell, (1.0 - max(f.x, f.y)), in_.position, _e70, depth_1);
    vec3 _e77 = ray;
    add(blend, (cell + side), abs((f.x - f.y)), in_.position, _e77, depth_1);
    vec3 _e85 = ray;
    add(blend, (cell + vec2(1.0)), min(f.x, f.y), in_.position, _e85, depth_1);
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
    vec3 _e107 = ray;
    float _e109 = blend.t;
    vec3 position_1 = (in_.position + (_e107 * (_e109 * share)));
    mat4x4 _e115 = _group_0_binding_0_fs.clip;
    vec4 clip = (_e115 * vec4(position_1, 1.0));
    vec3 _e120 = blend.color;
    color = (_e120 * share);
    uint _e125 = _group_0_binding_0_fs.shading;
    if ((_e125 == 1u)) {
        vec3 _e128 = color;
        vec3 _e130 = blend.normal;
        vec3 _e132 = lit(_e128, normalize(_e130), position_1);
        vec3 _e134 = blend.emissive;
        color = (_e132 + (_e134 * share));
    }
    vec3 _e137 = color;
    Fragment _tmp_return = Fragment(vec4(_e137, 1.0), (clip.z / clip.w));
    _fs2p_location0 = _tmp_return.color;
    gl_FragDepth = _tmp_return.depth;
    return;
}

