//! The shaders that ship with a bundle.

pub use crate::runtime::dmesh::ShaderFile;

pub const SHADERS: [ShaderFile; 0] = [];
