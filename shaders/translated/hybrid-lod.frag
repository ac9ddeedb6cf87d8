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
uniform sampler2DArray _group_0_binding_1_fs;

layout(std140) uniform Page_block_0Fragment { Page _group_1_binding_0_fs; };

layout(location = 0) smooth in vec3 _vs2fs_location0;
layout(location = 0) out vec4 _fs2p_location0;

void main() {
    Fragment in_ = Fragment(gl_FragCoord, _vs2fs_location0);
    vec2 at = (in_.ratios.xy / vec2(in_.ratios.z));
    uint _e11 = _group_1_binding_0_fs.layer;
    vec4 _e12 = texture(_group_0_binding_1_fs, vec3(at, _e11));
    _fs2p_location0 = vec4(_e12.xyz, 1.0);
    return;
}

