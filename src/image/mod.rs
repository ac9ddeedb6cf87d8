//! Pictures: linear and sRGB colour, filters, drawing, and the measures that compare two of them.

pub mod canvas;
pub mod measure;
pub mod picture;
pub mod srgb;

pub use picture::{Picture, PictureError, encode_png, load_png, save_png};
