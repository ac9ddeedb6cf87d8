//! PNG, JPEG and WebP, decoded to 8-bit RGBA.
//!
//! What decoding takes is known before anything is allocated: an image's claimed size comes first, and chunks that hold no texels
//! (colour profiles, texts) are passed over without being expanded. JPEG goes through `zune-jpeg` without its vector code,
//! because that rounds differently from machine to machine.

use crate::scene::Image;
use image::{DynamicImage, ImageDecoder, ImageFormat, codecs::webp::WebPDecoder};
use std::io::Cursor;
use zune_jpeg::{JpegDecoder, zune_core};

use zune_core::colorspace::ColorSpace;
type Jpeg<'a> = JpegDecoder<zune_core::bytestream::ZCursor<&'a [u8]>>;

/// What an image claims of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Claim {
    /// Texels.
    pub width: u32,
    pub height: u32,
    /// Bytes that decoding may take at once, the result included.
    pub bytes: u64,
}

impl Claim {
    fn new(width: u32, height: u32, bytes_per_texel: u64) -> Result<Self, String> {
        if width == 0 || height == 0 {
            return Err("an image without texels".into());
        }
        let texels = u64::from(width) * u64::from(height);
        Ok(Self { width, height, bytes: texels.saturating_mul(bytes_per_texel) })
    }

    pub fn texels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

fn format(bytes: &[u8]) -> Result<ImageFormat, String> {
    if bytes.starts_with(b"\xabKTX 20\xbb") {
        return Err("a KTX2 image; only PNG, JPEG and WebP can be read; export the file with one of these".into());
    }
    match image::guess_format(bytes) {
        Ok(f @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => Ok(f),
        Ok(other) => Err(format!("an image of kind {other:?}; only PNG, JPEG and WebP can be read")),
        Err(_) => Err("neither PNG, JPEG nor WebP".into()),
    }
}

/// What the image's header claims.
pub(super) fn claim(bytes: &[u8]) -> Result<Claim, String> {
    match format(bytes)? {
        ImageFormat::Jpeg => {
            let (width, height, components, _) = frame(bytes)?;
            // The result; coefficients of 16 bits where the image is progressive; four components are converted from a copy.
            Claim::new(width, height, 4 + 2 * components + if components == 4 { 4 } else { 0 })
        }
        ImageFormat::WebP => {
            let (width, height) = webp(bytes)?.dimensions();
            // The result, the planes or RGB that it is made from, and what a predictor needs.
            Claim::new(width, height, 12)
        }
        _ => {
            let reader = png(bytes, u64::MAX)?;
            let (width, height) = reader.info().size();
            let (color, depth) = reader.output_color_type();
            // The samples and the result.
            Claim::new(width, height, 4 + color.samples() as u64 * if depth == png::BitDepth::Sixteen { 2 } else { 1 })
        }
    }
}

/// The image; `limit` bounds the bytes that decoding takes.
pub(super) fn decode(bytes: &[u8], name: &str, limit: u64) -> Result<Image, String> {
    let Claim { width, height, bytes: need } = claim(bytes)?;
    if need > limit {
        return Err(format!("decoding {width} × {height} texels takes {need} bytes; the limit is {limit}"));
    }
    let texels: Vec<u8> = match format(bytes)? {
        ImageFormat::Jpeg => decode_jpeg(bytes)?,
        ImageFormat::WebP => {
            let picture = DynamicImage::from_decoder(webp(bytes)?).map_err(|e| e.to_string())?;
            picture.into_rgba8().into_raw()
        }
        _ => decode_png(bytes, limit)?,
    };
    if texels.len() as u64 != u64::from(width) * u64::from(height) * 4 {
        return Err(format!("{} bytes for {width} × {height} texels", texels.len()));
    }
    let texels = bytemuck::allocation::try_cast_vec::<u8, [u8; 4]>(texels);
    let texels = texels.unwrap_or_else(|(_, bytes)| bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect());
    Ok(Image { name: name.to_owned(), width, height, texels: texels.into() })
}

fn webp(bytes: &[u8]) -> Result<WebPDecoder<Cursor<&[u8]>>, String> {
    WebPDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())
}

/// A reader that has seen all before the texels. `limit` bounds what it allocates beside the result.
fn png(bytes: &[u8], limit: u64) -> Result<png::Reader<Cursor<&[u8]>>, String> {
    let limits = png::Limits { bytes: usize::try_from(limit).unwrap_or(usize::MAX).max(1 << 20) };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.read_info().map_err(|e| e.to_string())
}

fn decode_png(bytes: &[u8], limit: u64) -> Result<Vec<u8>, String> {
    let mut reader = png(bytes, limit)?;
    let size = reader.output_buffer_size().ok_or("more bytes than this machine can address")?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(|e| e.to_string())?;
    samples.truncate(frame.buffer_size());
    if frame.bit_depth == png::BitDepth::Sixteen {
        // To the nearest of 256 levels.
        let byte = |c: &[u8]| ((u32::from(u16::from_be_bytes([c[0], c[1]])) + 128) / 257) as u8;
        samples = samples.chunks_exact(2).map(byte).collect();
    }
    Ok(match frame.color_type {
        png::ColorType::Rgba => samples,
        png::ColorType::Rgb => samples.chunks_exact(3).flat_map(|c| [c[0], c[1], c[2], 255]).collect(),
        png::ColorType::GrayscaleAlpha => samples.chunks_exact(2).flat_map(|c| [c[0], c[0], c[0], c[1]]).collect(),
        png::ColorType::Grayscale => samples.iter().flat_map(|c| [*c, *c, *c, 255]).collect(),
        png::ColorType::Indexed => return Err("a palette that was not resolved".into()),
    })
}

fn jpeg(bytes: &[u8], to: ColorSpace) -> Jpeg<'_> {
    let options = zune_core::options::DecoderOptions::default()
        .set_use_unsafe(false)
        .set_strict_mode(false)
        .set_max_width(1 << 16)
        .set_max_height(1 << 16)
        .jpeg_set_out_colorspace(to);
    JpegDecoder::new_with_options(zune_core::bytestream::ZCursor::new(bytes), options)
}

/// Width, height, components and colours of a JPEG.
fn frame(bytes: &[u8]) -> Result<(u32, u32, u64, ColorSpace), String> {
    let mut decoder = jpeg(bytes, ColorSpace::RGBA);
    decoder.decode_headers().map_err(|e| e.to_string())?;
    let info = decoder.info().ok_or("a JPEG without a frame")?;
    let colors = decoder.input_colorspace().ok_or("a JPEG without a frame")?;
    Ok((info.width.into(), info.height.into(), info.components.into(), colors))
}

fn decode_jpeg(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let read = |to: ColorSpace| jpeg(bytes, to).decode().map_err(|e| e.to_string());
    let (_, _, components, colors) = frame(bytes)?;
    match (components, colors) {
        (4, ColorSpace::YCCK) => {
            let (mut raw, inverted) = (read(ColorSpace::YCCK)?, adobe(bytes));
            for c in raw.chunks_exact_mut(4) {
                let [r, g, b] = rgb_of_ycc([c[0], c[1], c[2]]);
                // libjpeg's YCCK holds the complement of the first three inks.
                let ink = [255 - r, 255 - g, 255 - b, c[3]];
                c.copy_from_slice(&rgba_of_cmyk(ink, inverted));
            }
            Ok(raw)
        }
        (4, _) => {
            let (mut raw, inverted) = (read(ColorSpace::CMYK)?, adobe(bytes));
            for c in raw.chunks_exact_mut(4) {
                let ink = [c[0], c[1], c[2], c[3]];
                c.copy_from_slice(&rgba_of_cmyk(ink, inverted));
            }
            Ok(raw)
        }
        // Adobe's marker says that three components are RGB; so the decoder learns it while it decodes.
        (3, ColorSpace::RGB | ColorSpace::CMYK) => {
            Ok(read(ColorSpace::RGB)?.chunks_exact(3).flat_map(|c| [c[0], c[1], c[2], 255]).collect())
        }
        _ => read(ColorSpace::RGBA),
    }
}

/// Whether a JPEG has Adobe's marker. Files that have it store inks inverted: 255 is no ink.
fn adobe(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some([0xff, marker, high, low]) = bytes.get(at..at + 4) {
        if *marker == 0xee && bytes.get(at + 4..at + 9) == Some(b"Adobe") {
            return true;
        }
        // The scan begins.
        if *marker == 0xda {
            return false;
        }
        at += 2 + usize::from(u16::from_be_bytes([*high, *low]));
    }
    false
}

/// Colour of inks on white paper, without a profile.
fn rgba_of_cmyk(ink: [u8; 4], inverted: bool) -> [u8; 4] {
    let [c, m, y, k] = ink.map(|v| if inverted { u32::from(v) } else { 255 - u32::from(v) });
    let mixed = |v: u32| ((v * k + 127) / 255) as u8;
    [mixed(c), mixed(m), mixed(y), 255]
}

/// JFIF's colours, in 16-bit fixed point.
fn rgb_of_ycc([y, cb, cr]: [u8; 3]) -> [u8; 3] {
    let (y, cb, cr) = (i32::from(y) << 16, i32::from(cb) - 128, i32::from(cr) - 128);
    let round = |v: i32| ((v + (1 << 15)) >> 16).clamp(0, 255) as u8;
    [round(y + 91881 * cr), round(y - 22554 * cb - 46802 * cr), round(y + 116130 * cb)]
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
        let image = decode(bytes, "x", 256).unwrap();
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
        assert_eq!(decode(&colour, "x", 5).unwrap_err(), "decoding 2 × 3 texels takes 60 bytes; the limit is 5");
        for end in 0..colour.len() {
            // A JPEG that is cut off may still show something; it must not panic, nor have another size.
            if let Ok(image) = decode(&colour[..end], "x", 256) {
                assert_eq!(image.texels.len(), 6);
            }
        }
    }

    #[test]
    fn palettes_and_small_depths_are_resolved() {
        let encode = |color, depth, palette: Option<&[u8]>, trns: Option<&[u8]>, data: &[u8]| {
            let mut out = Vec::new();
            let mut encoder = png::Encoder::new(&mut out, 2, 3);
            encoder.set_color(color);
            encoder.set_depth(depth);
            palette.into_iter().for_each(|p| encoder.set_palette(p.to_vec()));
            trns.into_iter().for_each(|t| encoder.set_trns(t.to_vec()));
            encoder.write_header().unwrap().write_image_data(data).unwrap();
            out
        };
        use png::{BitDepth, ColorType};
        let colors = [9, 8, 7, 200, 100, 50];
        let four = encode(ColorType::Indexed, BitDepth::Four, Some(&colors), None, &[0x10; 3]);
        assert_eq!(texel(&four), [200, 100, 50, 255]);
        let holes = encode(ColorType::Indexed, BitDepth::Eight, Some(&colors), Some(&[77]), &[0; 6]);
        assert_eq!(texel(&holes), [9, 8, 7, 77]);
        let bits = encode(ColorType::Grayscale, BitDepth::One, None, None, &[0x80; 3]);
        assert_eq!(texel(&bits), [255, 255, 255, 255]);
        let wide = encode(ColorType::GrayscaleAlpha, BitDepth::Sixteen, None, None, &[0x40, 0x40, 0x80, 0].repeat(6));
        assert_eq!(texel(&wide), [64, 64, 64, 128]);
        let clear = encode(ColorType::Rgb, BitDepth::Eight, None, Some(&[0, 1, 0, 2, 0, 3]), &[1, 2, 3].repeat(6));
        assert_eq!(texel(&clear), [1, 2, 3, 0]);
    }

    #[test]
    fn webp_with_and_without_alpha() {
        let file =
            encode(image::RgbaImage::from_pixel(2, 3, image::Rgba([200, 100, 50, 60])).into(), ImageFormat::WebP);
        assert_eq!(texel(&file), [200, 100, 50, 60]);
        let file = encode(RgbImage::from_pixel(2, 3, Rgb([1, 2, 3])).into(), ImageFormat::WebP);
        assert_eq!(texel(&file), [1, 2, 3, 255]);
    }

    #[test]
    fn other_kinds_are_refused_by_name() {
        let what = |bytes: &[u8]| claim(bytes).unwrap_err();
        assert!(what(b"\xabKTX 20\xbb\r\n\x1a\n").starts_with("a KTX2 image"));
        assert!(what(b"GIF89a").starts_with("an image of kind Gif"));
        assert!(what(b"no image at all").starts_with("neither PNG, JPEG nor WebP"));
    }

    /// A JPEG of one block of 8 × 8 equal texels: each component's level, and Adobe's marker with a transform.
    fn flat_jpeg(components: &[u8], adobe: Option<u8>) -> Vec<u8> {
        let mut out = vec![0xff, 0xd8];
        let mut segment = |marker: u8, body: &[u8]| {
            out.extend([0xff, marker]);
            out.extend((body.len() as u16 + 2).to_be_bytes());
            out.extend(body);
        };
        if let Some(transform) = adobe {
            segment(0xee, &[b"Adobe".as_slice(), &[0, 100, 0, 0, 0, 0, transform]].concat());
        }
        segment(0xdb, &[&[0u8][..], &[8; 64]].concat());
        let n = components.len() as u8;
        let of = (1..=n).flat_map(|c| [c, 0x11, 0]);
        segment(0xc0, &[vec![8, 0, 8, 0, 8, n], of.collect()].concat());
        // Twelve categories of difference, each a code of four bits; "end of block", a code of one bit.
        segment(0xc4, &[vec![0, 0, 0, 0, 12], vec![0; 12], (0..12).collect()].concat());
        segment(0xc4, &[vec![0x10, 1], vec![0; 15], vec![0]].concat());
        segment(0xda, &[vec![n], (1..=n).flat_map(|c| [c, 0]).collect(), vec![0, 63, 0]].concat());
        let mut bits = String::new();
        for level in components {
            // With steps of 8 the first coefficient is the level itself.
            let value = i32::from(*level) - 128;
            let category = (32 - value.unsigned_abs().leading_zeros()) as usize;
            let code = if value < 0 { value + (1 << category) - 1 } else { value };
            bits += &format!("{category:04b}");
            bits += &format!("{code:012b}")[12 - category..];
            bits.push('0');
        }
        while !bits.len().is_multiple_of(8) {
            bits.push('1');
        }
        for byte in bits.as_bytes().chunks(8) {
            let byte = byte.iter().fold(0u8, |b, c| b << 1 | (c - b'0'));
            out.push(byte);
            if byte == 0xff {
                out.push(0);
            }
        }
        out.extend([0xff, 0xd9]);
        out
    }

    #[test]
    fn jpegs_of_three_and_four_components() {
        let colour = |components: &[u8], adobe| {
            let image = decode(&flat_jpeg(components, adobe), "x", 1 << 12).unwrap();
            assert_eq!(image.texels.len(), 64);
            image.texels[9]
        };
        let near = |found: [u8; 4], expect: [u8; 4]| {
            assert!(found.iter().zip(expect).all(|(a, b)| a.abs_diff(b) <= 2), "{found:?} {expect:?}");
        };
        // Plain inks: cyan 255, a fifth of black.
        near(colour(&[255, 0, 0, 51], None), [0, 204, 204, 255]);
        // Adobe's, inverted: the same colour.
        near(colour(&[0, 255, 255, 204], Some(0)), [0, 204, 204, 255]);
        // The same as YCCK: Y, Cb, Cr of the complement (255, 0, 0).
        near(colour(&[76, 85, 255, 204], Some(2)), [0, 204, 204, 255]);
        // Three components: YCbCr with and without a marker, RGB.
        near(colour(&[76, 85, 255], Some(1)), [254, 0, 0, 255]);
        near(colour(&[76, 85, 255], None), [254, 0, 0, 255]);
        near(colour(&[200, 100, 50], Some(0)), [200, 100, 50, 255]);
        near(colour(&[77], None), [77, 77, 77, 255]);
    }

    #[test]
    fn chunks_without_texels_are_not_expanded() {
        // 64 MiB of zeros in a colour profile and in a text, a few hundred bytes packed once more would be gigabytes.
        let packed = {
            let mut out = Vec::new();
            let mut encoder = png::Encoder::new(&mut out, 1 << 12, 1 << 12);
            encoder.set_color(png::ColorType::Rgba);
            encoder.write_header().unwrap().write_image_data(&vec![0; 1 << 26]).unwrap();
            let at = out.windows(4).position(|w| w == b"IDAT").unwrap();
            let length = u32::from_be_bytes(out[at - 4..at].try_into().unwrap()) as usize;
            out[at + 4..at + 4 + length].to_vec()
        };
        let plain = encode(RgbImage::from_pixel(2, 3, Rgb([1, 2, 3])).into(), ImageFormat::Png);
        let chunk = |kind: &[u8; 4], head: &[u8]| {
            let body = [kind.as_slice(), head, &packed].concat();
            let crc = crate::formats::tests::crc(&body).to_be_bytes();
            [&(body.len() as u32 - 4).to_be_bytes()[..], &body, &crc].concat()
        };
        let chunks = [chunk(b"iCCP", b"p\0\0"), chunk(b"zTXt", b"t\0\0"), chunk(b"iTXt", b"t\0\x01\0\0\0")].concat();
        let bomb = [&plain[..33], &chunks, &plain[33..]].concat();
        // A limit far below what the chunks expand to.
        assert_eq!(decode(&bomb, "x", 1 << 10).unwrap().texels[0], [1, 2, 3, 255]);
    }
}
