//! The shaders that ship with a bundle.

use crate::runtime::ShaderFile;

/// The draw call for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/hybrid_lod.wgsl");

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 6] = [
    ShaderFile::wgsl("hybrid_lod.wgsl", SHADER),
    ShaderFile::glsl("hybrid_lod.vert", include_bytes!("../../../shaders/translated/hybrid_lod.vert")),
    ShaderFile::glsl("hybrid_lod.frag", include_bytes!("../../../shaders/translated/hybrid_lod.frag")),
    ShaderFile::hlsl("hybrid_lod.hlsl", include_bytes!("../../../shaders/translated/hybrid_lod.hlsl")),
    ShaderFile::metal("hybrid_lod.metal", include_bytes!("../../../shaders/translated/hybrid_lod.metal")),
    ShaderFile::spirv("hybrid_lod.spv", include_bytes!("../../../shaders/translated/hybrid_lod.spv")),
];
