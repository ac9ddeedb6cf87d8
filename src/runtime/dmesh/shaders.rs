//! The shaders that ship with a bundle.

/// The passes for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/dmesh.wgsl");

/// A shader file of a bundle.
#[derive(Clone, Copy, Debug)]
pub struct ShaderFile {
    pub name: &'static str,
    /// Its language, as the manifest names it.
    pub language: &'static str,
    pub media: &'static str,
    pub bytes: &'static [u8],
}

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 10] = [
    ShaderFile { name: "dmesh.wgsl", language: "wgsl", media: "text/wgsl", bytes: SHADER.as_bytes() },
    glsl("dmesh-depth.vert", include_bytes!("../../../shaders/translated/dmesh-depth.vert")),
    glsl("dmesh-depth.frag", include_bytes!("../../../shaders/translated/dmesh-depth.frag")),
    glsl("dmesh-color.vert", include_bytes!("../../../shaders/translated/dmesh-color.vert")),
    glsl("dmesh-color.frag", include_bytes!("../../../shaders/translated/dmesh-color.frag")),
    glsl("dmesh-combine.vert", include_bytes!("../../../shaders/translated/dmesh-combine.vert")),
    glsl("dmesh-combine.frag", include_bytes!("../../../shaders/translated/dmesh-combine.frag")),
    ShaderFile {
        name: "dmesh.hlsl",
        language: "hlsl",
        media: "text/x-hlsl",
        bytes: include_bytes!("../../../shaders/translated/dmesh.hlsl"),
    },
    ShaderFile {
        name: "dmesh.metal",
        language: "metal",
        media: "text/x-metal",
        bytes: include_bytes!("../../../shaders/translated/dmesh.metal"),
    },
    ShaderFile {
        name: "dmesh.spv",
        language: "spirv",
        media: "application/octet-stream",
        bytes: include_bytes!("../../../shaders/translated/dmesh.spv"),
    },
];

const fn glsl(name: &'static str, bytes: &'static [u8]) -> ShaderFile {
    ShaderFile { name, language: "glsl", media: "text/x-glsl", bytes }
}
