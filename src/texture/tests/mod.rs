use super::mip::{Level, Rule, chain, chain16};
use super::*;

mod files;
mod mips;

/// An image of smooth colours, alpha included.
fn image(width: u32, height: u32, seed: u32) -> Level {
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        [40 + 5 * x + 2 * y + seed, 800 - 3 * x - y, 90 + x + 4 * y, 767 - 9 * x].map(|v| v as u8)
    };
    Level { width, height, texels: (0..width * height).map(texel).collect() }
}

/// Two layers of 6 × 5 texels with all three mip levels.
fn array(format: Format, srgb: bool) -> TextureArray {
    if format == Format::R16 {
        let layer = |n: u16| {
            let base = Level { width: 6, height: 5, texels: (0..30).map(|i| i * 2000 + n).collect() };
            chain16(&base, u16::min, 9)
        };
        return TextureArray::encode16(&[layer(0), layer(7)]).unwrap();
    }
    let layer = |seed| chain(&image(6, 5, seed), &[255; 30], Rule::Data, 9);
    TextureArray::encode(format, srgb, &[layer(0), layer(60)]).unwrap()
}
