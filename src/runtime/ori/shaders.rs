//! The shaders that ship with a bundle.

pub use crate::runtime::dmesh::ShaderFile;

/// The draw call for renderers, WGSL; its head says what is bound where.
pub const SHADER: &str = include_str!("../../../shaders/ori.wgsl");
pub const SHADERS: [ShaderFile; 0] = [];
