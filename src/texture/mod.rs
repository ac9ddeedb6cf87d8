//! Textures as graphics cards read them: formats and block compression, mip levels, arrays of layers, and their files.
//!
//! Plain data in and out. Results are the same bytes on every machine and for any number of threads: blocks and texels do not depend on each other,
//! and no platform function decides about them. Readers return errors for any bytes and allocate nothing that a header only claims.

mod array;
mod bc1;
mod bc4;
mod block;
pub mod dds;
mod format;
pub mod ktx2;
pub mod mip;

pub use array::{MOST_LAYERS, TextureArray, TextureError};
pub use block::{decode, decode16, encode, encode16};
pub use format::{Format, MOST_SIDE};

#[cfg(test)]
mod tests;
