//! The shaders that ship with a bundle.

use crate::runtime::ShaderFile;

/// The draw call for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/ori.wgsl");

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 6] = [
    ShaderFile::wgsl("ori.wgsl", SHADER),
    ShaderFile::glsl("ori.vert", include_bytes!("../../../shaders/translated/ori.vert")),
    ShaderFile::glsl("ori.frag", include_bytes!("../../../shaders/translated/ori.frag")),
    ShaderFile::hlsl("ori.hlsl", include_bytes!("../../../shaders/translated/ori.hlsl")),
    ShaderFile::metal("ori.metal", include_bytes!("../../../shaders/translated/ori.metal")),
    ShaderFile::spirv("ori.spv", include_bytes!("../../../shaders/translated/ori.spv")),
];
