#version 450 core
struct Frame {
    mat4x4 clip;
};
struct Page {
    vec2 scale;
    uint layer;
};
struct Fragment {
    vec4 clip;
    vec3 ratios;
};
layout(std140) uniform Frame_block_0Vertex { Frame _group_0_binding_0_vs; };

layout(std140) uniform Page_block_1Vertex { Page _group_1_binding_0_vs; };

layout(location = 0) in vec3 _p2vs_location0;
layout(location = 1) in vec2 _p2vs_location1;
layout(location = 2) in float _p2vs_location2;
layout(location = 0) smooth out vec3 _vs2fs_location0;

void main() {
    vec3 position = _p2vs_location0;
    vec2 uv = _p2vs_location1;
    float depth = _p2vs_location2;
    vec2 _e5 = _group_1_binding_0_vs.scale;
    vec3 ratios = (vec3((uv * _e5), 1.0) * depth);
    mat4x4 _e12 = _group_0_binding_0_vs.clip;
    Fragment _tmp_return = Fragment((_e12 * vec4(position, 1.0)), ratios);
    gl_Position = _tmp_return.clip;
    _vs2fs_location0 = _tmp_return.ratios;
    return;
}

