//! Pictures: linear and sRGB colour, filters, and the measures that compare two of them.

pub mod measure;
pub mod srgb;
