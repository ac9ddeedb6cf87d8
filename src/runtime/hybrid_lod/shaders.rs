//! The shaders that ship with a bundle.

use crate::runtime::ShaderFile;

/// The draw call for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/hybrid_lod.wgsl");

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 6] = [
    ShaderFile::wgsl("hybrid-lod.wgsl", SHADER),
    ShaderFile::glsl("hybrid-lod.vert", include_bytes!("../../../shaders/translated/hybrid-lod.vert")),
    ShaderFile::glsl("hybrid-lod.frag", include_bytes!("../../../shaders/translated/hybrid-lod.frag")),
    ShaderFile::hlsl("hybrid-lod.hlsl", include_bytes!("../../../shaders/translated/hybrid-lod.hlsl")),
    ShaderFile::metal("hybrid-lod.metal", include_bytes!("../../../shaders/translated/hybrid-lod.metal")),
    ShaderFile::spirv("hybrid-lod.spv", include_bytes!("../../../shaders/translated/hybrid-lod.spv")),
];
