//! The shaders that ship with a bundle.

use crate::runtime::ShaderFile;

/// The card and its fragments for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/octahedral.wgsl");

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 6] = [
    ShaderFile::wgsl("octahedral.wgsl", SHADER),
    ShaderFile::glsl("octahedral.vert", include_bytes!("../../../shaders/translated/octahedral.vert")),
    ShaderFile::glsl("octahedral.frag", include_bytes!("../../../shaders/translated/octahedral.frag")),
    ShaderFile::hlsl("octahedral.hlsl", include_bytes!("../../../shaders/translated/octahedral.hlsl")),
    ShaderFile::metal("octahedral.metal", include_bytes!("../../../shaders/translated/octahedral.metal")),
    ShaderFile::spirv("octahedral.spv", include_bytes!("../../../shaders/translated/octahedral.spv")),
];
