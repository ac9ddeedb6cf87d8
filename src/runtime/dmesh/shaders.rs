//! The shaders that ship with a bundle.

use crate::runtime::ShaderFile;

/// The passes for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/dmesh.wgsl");

/// [`SHADER`] and its translations by naga; `tests/shaders.rs` keeps them current. GLSL has one file for each entry point.
pub const SHADERS: [ShaderFile; 10] = [
    ShaderFile::wgsl("dmesh.wgsl", SHADER),
    ShaderFile::glsl("dmesh-depth.vert", include_bytes!("../../../shaders/translated/dmesh-depth.vert")),
    ShaderFile::glsl("dmesh-depth.frag", include_bytes!("../../../shaders/translated/dmesh-depth.frag")),
    ShaderFile::glsl("dmesh-color.vert", include_bytes!("../../../shaders/translated/dmesh-color.vert")),
    ShaderFile::glsl("dmesh-color.frag", include_bytes!("../../../shaders/translated/dmesh-color.frag")),
    ShaderFile::glsl("dmesh-combine.vert", include_bytes!("../../../shaders/translated/dmesh-combine.vert")),
    ShaderFile::glsl("dmesh-combine.frag", include_bytes!("../../../shaders/translated/dmesh-combine.frag")),
    ShaderFile::hlsl("dmesh.hlsl", include_bytes!("../../../shaders/translated/dmesh.hlsl")),
    ShaderFile::metal("dmesh.metal", include_bytes!("../../../shaders/translated/dmesh.metal")),
    ShaderFile::spirv("dmesh.spv", include_bytes!("../../../shaders/translated/dmesh.spv")),
];
