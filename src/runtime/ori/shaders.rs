//! The shaders that ship with a bundle.

pub use crate::runtime::dmesh::ShaderFile;

/// The draw call for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/ori.wgsl");

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 6] = [
    ShaderFile { name: "ori.wgsl", language: "wgsl", media: "text/wgsl", bytes: SHADER.as_bytes() },
    glsl("ori.vert", include_bytes!("../../../shaders/translated/ori.vert")),
    glsl("ori.frag", include_bytes!("../../../shaders/translated/ori.frag")),
    ShaderFile {
        name: "ori.hlsl",
        language: "hlsl",
        media: "text/x-hlsl",
        bytes: include_bytes!("../../../shaders/translated/ori.hlsl"),
    },
    ShaderFile {
        name: "ori.metal",
        language: "metal",
        media: "text/x-metal",
        bytes: include_bytes!("../../../shaders/translated/ori.metal"),
    },
    ShaderFile {
        name: "ori.spv",
        language: "spirv",
        media: "application/octet-stream",
        bytes: include_bytes!("../../../shaders/translated/ori.spv"),
    },
];

const fn glsl(name: &'static str, bytes: &'static [u8]) -> ShaderFile {
    ShaderFile { name, language: "glsl", media: "text/x-glsl", bytes }
}
