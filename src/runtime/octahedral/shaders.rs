//! The shaders that ship with a bundle.

use crate::runtime::dmesh::ShaderFile;

/// The card and its fragments for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/octahedral.wgsl");

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 6] = [
    ShaderFile { name: "octahedral.wgsl", language: "wgsl", media: "text/wgsl", bytes: SHADER.as_bytes() },
    glsl("octahedral.vert", include_bytes!("../../../shaders/translated/octahedral.vert")),
    glsl("octahedral.frag", include_bytes!("../../../shaders/translated/octahedral.frag")),
    ShaderFile {
        name: "octahedral.hlsl",
        language: "hlsl",
        media: "text/x-hlsl",
        bytes: include_bytes!("../../../shaders/translated/octahedral.hlsl"),
    },
    ShaderFile {
        name: "octahedral.metal",
        language: "metal",
        media: "text/x-metal",
        bytes: include_bytes!("../../../shaders/translated/octahedral.metal"),
    },
    ShaderFile {
        name: "octahedral.spv",
        language: "spirv",
        media: "application/octet-stream",
        bytes: include_bytes!("../../../shaders/translated/octahedral.spv"),
    },
];

const fn glsl(name: &'static str, bytes: &'static [u8]) -> ShaderFile {
    ShaderFile { name, language: "glsl", media: "text/x-glsl", bytes }
}
