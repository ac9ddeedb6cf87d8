//! Published pictures, made ready to be embedded: the three pictures of a sheet apart, each pixel of the view once, without its caption.

use super::{Shown, View};
use image::{DynamicImage, GenericImageView as _, ImageReader, RgbImage, codecs::png, imageops};
use serde::Deserialize;
use std::io::Cursor;

/// Views that a page shows at most; the rest are links.
pub const MOST_VIEWS: usize = 8;
/// Bytes of all embedded PNG files together.
pub const MOST_BYTES: usize = 16 << 20;
/// Pixels along a side of an embedded picture; larger ones are reduced.
const MOST_SIDE: u32 = 1024;

/// Where three pictures lie in a sheet, as a certificate says: left, top, width, height. Each pixel is a square of `scale` pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub struct Panels {
    pub scale: u32,
    pub original: [u32; 4],
    pub stand_in: [u32; 4],
    pub difference: [u32; 4],
}

/// A published PNG file as it is to be shown. `None` where it is none, or where `panels` does not lie in it.
pub fn shown(file: &[u8], panels: Option<&Panels>) -> Option<Shown> {
    let mut reader = ImageReader::new(Cursor::new(file));
    reader.set_format(image::ImageFormat::Png);
    let sheet = reader.decode().ok()?;
    let Some(panels) = panels else {
        let (size, picture) = encoded(sheet)?;
        return Some(Shown::Alone { size, picture });
    };
    let part = |[x, y, width, height]: [u32; 4]| {
        let inside =
            |from: u32, length: u32, all: u32| length > 0 && from.checked_add(length).is_some_and(|e| e <= all);
        let scale = panels.scale;
        let fits = inside(x, width, sheet.width()) && inside(y, height, sheet.height());
        if !fits || scale == 0 || width < scale || height < scale {
            return None;
        }
        let at = |u: u32, v: u32| {
            let [r, g, b, _] = sheet.get_pixel(x + u * scale + scale / 2, y + v * scale + scale / 2).0;
            image::Rgb([r, g, b])
        };
        encoded(DynamicImage::ImageRgb8(RgbImage::from_fn(width / scale, height / scale, at)))
    };
    let (original, stand_in, difference) = (part(panels.original)?, part(panels.stand_in)?, part(panels.difference)?);
    let size = original.0;
    let same = stand_in.0 == size && difference.0 == size;
    same.then_some(Shown::Compared { size, original: original.1, stand_in: stand_in.1, difference: difference.1 })
}

/// As a PNG file without alpha, and its size.
fn encoded(picture: DynamicImage) -> Option<([u32; 2], Vec<u8>)> {
    let longest = picture.width().max(picture.height());
    let picture = if longest > MOST_SIDE {
        let side = |s: u32| (u64::from(s) * u64::from(MOST_SIDE) / u64::from(longest)).max(1) as u32;
        picture.resize_exact(side(picture.width()), side(picture.height()), imageops::FilterType::Triangle)
    } else {
        picture
    };
    let picture = picture.into_rgb8();
    let mut out = Vec::new();
    let encoder = png::PngEncoder::new_with_quality(&mut out, png::CompressionType::Default, png::FilterType::Adaptive);
    picture.write_with_encoder(encoder).ok()?;
    Some(([picture.width(), picture.height()], out))
}

impl Shown {
    /// Of its PNG files.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Compared { original, stand_in, difference, .. } => original.len() + stand_in.len() + difference.len(),
            Self::Alone { picture, .. } => picture.len(),
        }
    }
}

impl View {
    /// Whether both are pictures of the same view; what is marked in the difference does not matter.
    pub fn is_of(&self, other: &Shown) -> bool {
        match (&self.shown, other) {
            (Shown::Compared { original: a, stand_in: b, .. }, Shown::Compared { original: c, stand_in: d, .. }) => {
                a == c && b == d
            }
            (a, b) => a == b,
        }
    }
}

/// A PNG file as an address.
pub fn data_uri(png: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(png.len() / 3 * 4 + 32);
    out.push_str("data:image/png;base64,");
    for chunk in png.chunks(3) {
        let byte = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let digit = char::from(DIGITS[(bits >> (18 - 6 * k) & 63) as usize]);
            out.push(if k <= chunk.len() { digit } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
        let picture = RgbImage::from_fn(width, height, |x, y| image::Rgb(texel(x, y)));
        let mut out = Cursor::new(Vec::new());
        picture.write_to(&mut out, image::ImageFormat::Png).unwrap();
        out.into_inner()
    }

    fn texels(png: &[u8]) -> RgbImage {
        image::load_from_memory(png).unwrap().into_rgb8()
    }

    #[test]
    fn base64_is_that_of_rfc_4648() {
        for (bytes, expect) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(data_uri(bytes.as_bytes()), format!("data:image/png;base64,{expect}"));
        }
    }

    #[test]
    fn a_sheet_is_taken_apart() {
        // A caption of 5 rows, panels of 6 × 4 pixels in which each pixel of the view is a square of 2.
        let sheet = png(22, 10, |x, y| [(x / 2) as u8, (y / 2) as u8, u8::from(y < 5)]);
        let at = |x: u32| [x, 6, 6, 4];
        let panels = Panels { scale: 2, original: at(0), stand_in: at(8), difference: at(16) };
        let Some(Shown::Compared { size, original, stand_in, difference }) = shown(&sheet, Some(&panels)) else {
            panic!("three pictures");
        };
        assert_eq!(size, [3, 2]);
        for (picture, left) in [(original, 0), (stand_in, 4), (difference, 8)] {
            assert_eq!(texels(&picture), texels(&png(3, 2, |x, y| [(left + x) as u8, 3 + y as u8, 0])));
        }
        // What a certificate says need not be so.
        for wrong in [
            Panels { scale: 0, ..panels },
            Panels { scale: 9, ..panels },
            Panels { original: at(17), ..panels },
            Panels { original: [u32::MAX, 0, 2, 2], ..panels },
            Panels { original: [0, 0, 2, 2], ..panels },
        ] {
            assert_eq!(shown(&sheet, Some(&wrong)), None, "{wrong:?}");
        }
        assert_eq!(shown(b"no picture", None), None);
    }

    #[test]
    fn large_pictures_are_reduced() {
        let Some(Shown::Alone { size, picture }) = shown(&png(2048, 512, |_, _| [9, 8, 7]), None) else {
            panic!("a picture");
        };
        assert_eq!((size, texels(&picture).dimensions()), ([1024, 256], (1024, 256)));
        assert_eq!(texels(&picture).get_pixel(700, 100).0, [9, 8, 7]);
    }
}
