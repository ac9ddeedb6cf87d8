//! Pictures: linear and sRGB colour, filters, and the measures that compare two of them.

pub mod measure;
pub mod picture;
pub mod srgb;

pub use picture::{Picture, PictureError, encode_png, load_png, save_png};
