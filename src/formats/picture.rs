//! PNG and JPEG, decoded to 8-bit RGBA.
//!
//! An image's size is known before its texels are allocated. JPEG goes through `zune-jpeg` without its vector code,
//! because that rounds differently from machine to machine.

use crate::scene::Image;
use image::{ImageDecoder, ImageFormat};
use std::io::Cursor;
use zune_jpeg::{JpegDecoder, zune_core};

type Jpeg<'a> = JpegDecoder<zune_core::bytestream::ZCursor<&'a [u8]>>;

fn format(bytes: &[u8]) -> Result<ImageFormat, String> {
    match image::guess_format(bytes) {
        Ok(f @ (ImageFormat::Png | ImageFormat::Jpeg)) => Ok(f),
        Ok(other) => Err(format!("an image of kind {other:?}; only PNG and JPEG can be read")),
        Err(_) => Err("neither PNG nor JPEG".into()),
    }
}

fn jpeg(bytes: &[u8]) -> Jpeg<'_> {
    let options = zune_core::options::DecoderOptions::default()
        .set_use_unsafe(false)
        .set_strict_mode(false)
        .jpeg_set_out_colorspace(zune_core::colorspace::ColorSpace::RGBA);
    JpegDecoder::new_with_options(zune_core::bytestream::ZCursor::new(bytes), options)
}

/// Width and height in texels, as the image's header claims.
pub(super) fn size(bytes: &[u8]) -> Result<(u32, u32), String> {
    let (width, height) = match format(bytes)? {
        ImageFormat::Jpeg => {
            let mut decoder = jpeg(bytes);
            decoder.decode_headers().map_err(|e| e.to_string())?;
            let info = decoder.info().ok_or("a JPEG without a frame")?;
            (info.width as u32, info.height as u32)
        }
        _ => image::codecs::png::PngDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?.dimensions(),
    };
    if width == 0 || height == 0 { Err("an image without texels".into()) } else { Ok((width, height)) }
}

/// The image; `limit` bounds its texels.
pub(super) fn decode(bytes: &[u8], name: &str, limit: u64) -> Result<Image, String> {
    let (width, height) = size(bytes)?;
    if width as u64 * height as u64 > limit {
        return Err(format!("{width} × {height} texels; the limit is {limit}"));
    }
    let texels: Vec<u8> = match format(bytes)? {
        ImageFormat::Jpeg => jpeg(bytes).decode().map_err(|e| e.to_string())?,
        _ => {
            let mut limits = image::Limits::no_limits();
            // The largest sample layout is 16-bit RGBA; the rest is room for the decoder's own buffers.
            limits.max_alloc = Some(limit.saturating_mul(12).saturating_add(1 << 24));
            let decoder = image::codecs::png::PngDecoder::with_limits(Cursor::new(bytes), limits);
            let picture = decoder.and_then(image::DynamicImage::from_decoder).map_err(|e| e.to_string())?;
            picture.into_rgba8().into_raw()
        }
    };
    if texels.len() as u64 != width as u64 * height as u64 * 4 {
        return Err(format!("{} bytes for {width} × {height} texels", texels.len()));
    }
    let texels = bytemuck::allocation::try_cast_vec::<u8, [u8; 4]>(texels);
    let texels = texels.unwrap_or_else(|(_, bytes)| bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect());
    Ok(Image { name: name.to_owned(), width, height, texels: texels.into() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, ImageBuffer, Luma, LumaA, Rgb, RgbImage};

    fn encode(picture: DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        picture.write_to(&mut out, format).unwrap();
        out.into_inner()
    }

    fn texel(bytes: &[u8]) -> [u8; 4] {
        let image = decode(bytes, "x", 16).unwrap();
        assert_eq!((image.width, image.height, image.texels.len()), (2, 3, 6));
        image.texels[0]
    }

    #[test]
    fn every_layout_becomes_rgba() {
        let png = |p: DynamicImage| texel(&encode(p, ImageFormat::Png));
        assert_eq!(png(GrayImage::from_pixel(2, 3, Luma([7])).into()), [7, 7, 7, 255]);
        let grey16 = ImageBuffer::<Luma<u16>, _>::from_pixel(2, 3, Luma([0x8000]));
        assert_eq!(png(DynamicImage::ImageLuma16(grey16)), [128, 128, 128, 255]);
        let rgb16 = ImageBuffer::<Rgb<u16>, _>::from_pixel(2, 3, Rgb([0, 0xffff, 0x4040]));
        assert_eq!(png(DynamicImage::ImageRgb16(rgb16)), [0, 255, 64, 255]);
        let grey_alpha = ImageBuffer::<LumaA<u8>, _>::from_pixel(2, 3, LumaA([9, 3]));
        assert_eq!(png(DynamicImage::ImageLumaA8(grey_alpha)), [9, 9, 9, 3]);
    }

    #[test]
    fn jpeg_in_colour_and_grey() {
        let near = |found: [u8; 4], expect: [u8; 4]| found.iter().zip(expect).all(|(a, b)| a.abs_diff(b) <= 3);
        let colour = encode(RgbImage::from_pixel(2, 3, Rgb([200, 100, 50])).into(), ImageFormat::Jpeg);
        assert!(near(texel(&colour), [200, 100, 50, 255]));
        let grey = encode(GrayImage::from_pixel(2, 3, Luma([77])).into(), ImageFormat::Jpeg);
        assert!(near(texel(&grey), [77, 77, 77, 255]));
        assert!(decode(&colour, "x", 5).unwrap_err().contains("the limit is 5"));
        for end in 0..colour.len() {
            // A JPEG that is cut off may still show something; it must not panic, nor have another size.
            if let Ok(image) = decode(&colour[..end], "x", 16) {
                assert_eq!(image.texels.len(), 6);
            }
        }
    }
}
