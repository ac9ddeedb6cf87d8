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
