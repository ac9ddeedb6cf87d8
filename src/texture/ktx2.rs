//! KTX 2.0 files of texture arrays, without supercompression.
//!
//! Source: The Khronos Group, "KTX File Format Specification" 2.0, and "Khronos Data Format Specification" 1.3 for the data format descriptor. A file holds: identifier,
//! header and index; where each level lies; the descriptor; keys and values; the levels, the smallest first.

use super::{Format, TextureArray, TextureError, array::Head};

const IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";
/// Bytes of identifier, header and index.
const HEAD: usize = 80;
/// Bytes of a level's entry.
const ENTRY: usize = 24;

/// Keys in their order, and values.
const KEYS: [(&str, &str); 2] = [("KTXorientation", "rd"), ("KTXwriter", "farfield")];

/// The file of a texture array; one with a single layer is written as a texture that is no array.
///
/// # Errors
/// Where `array` is not as its fields say.
pub fn write(array: &TextureArray) -> Result<Vec<u8>, TextureError> {
    array.check()?;
    let descriptor = descriptor(array.format, array.srgb);
    let keys = keys();
    let keys_at = HEAD + ENTRY * array.levels.len() + descriptor.len();
    let mut out = Vec::with_capacity(keys_at + keys.len() + array.bytes() as usize + 16 * array.levels.len());
    out.extend(IDENTIFIER);
    let words = [
        array.format.vk(array.srgb),
        if array.format == Format::R16 { 2 } else { 1 },
        array.width,
        array.height,
        0,
        if array.layers == 1 { 0 } else { array.layers },
        1,
        array.levels.len() as u32,
        0,
        (keys_at - descriptor.len()) as u32,
        descriptor.len() as u32,
        keys_at as u32,
        keys.len() as u32,
    ];
    out.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    // Neither place nor size of data that belong to a supercompression.
    out.extend([0; 16]);
    let mut at = keys_at + keys.len();
    let mut places = vec![0; array.levels.len()];
    for (place, level) in places.iter_mut().zip(&array.levels).rev() {
        at = at.next_multiple_of(alignment(array.format));
        *place = at;
        at += level.len();
    }
    for (place, level) in places.iter().zip(&array.levels) {
        out.extend([*place, level.len(), level.len()].iter().flat_map(|v| (*v as u64).to_le_bytes()));
    }
    out.extend(descriptor);
    out.extend(keys);
    for (place, level) in places.iter().zip(&array.levels).rev() {
        out.resize(*place, 0);
        out.extend(level);
    }
    Ok(out)
}

/// Where levels begin: at multiples of this.
fn alignment(format: Format) -> usize {
    // The least common multiple of a block's bytes, all powers of two, and 4.
    (format.block_bytes() as usize).max(4)
}

fn keys() -> Vec<u8> {
    let mut out = Vec::new();
    for (key, value) in KEYS {
        let length = key.len() + value.len() + 2;
        out.extend((length as u32).to_le_bytes());
        for text in [key, value] {
            out.extend(text.as_bytes());
            out.push(0);
        }
        out.resize(out.len().next_multiple_of(4), 0);
    }
    out
}

/// One of the descriptor's samples: first bit, bits, channel, and the highest code.
struct Sample(u16, u8, u8, u32);

/// The data format descriptor with its size before it.
fn descriptor(format: Format, srgb: bool) -> Vec<u8> {
    const ALPHA: u8 = 15;
    /// Alpha beside sRGB colours is linear.
    const LINEAR: u8 = 1 << 4;
    let alpha = if srgb { ALPHA | LINEAR } else { ALPHA };
    let whole = |first: u16, channel: u8| Sample(first, 64, channel, u32::MAX);
    let byte = |first: u16, channel: u8| Sample(first, 8, channel, 255);
    // KHR_DF_MODEL_*: 1 for RGBSDA, 128 and on for BC1A, BC2, BC3, BC4, BC5.
    let (model, samples) = match format {
        Format::R8 => (1, vec![byte(0, 0)]),
        Format::Rg8 => (1, vec![byte(0, 0), byte(8, 1)]),
        Format::Rgba8 => (1, vec![byte(0, 0), byte(8, 1), byte(16, 2), byte(24, alpha)]),
        Format::R16 => (1, vec![Sample(0, 16, 0, 65535)]),
        Format::Bc1 => (128, vec![whole(0, 0)]),
        Format::Bc3 => (130, vec![whole(0, alpha), whole(64, 0)]),
        Format::Bc4 => (131, vec![whole(0, 0)]),
        Format::Bc5 => (132, vec![whole(0, 0), whole(64, 1)]),
    };
    let size = 24 + 16 * samples.len();
    let mut out = Vec::with_capacity(4 + size);
    out.extend((size as u32 + 4).to_le_bytes());
    // Khronos's basic descriptor, version 2.
    out.extend([0; 4]);
    out.extend(2_u16.to_le_bytes());
    out.extend((size as u16).to_le_bytes());
    // Primaries of BT.709; straight alpha.
    out.extend([model, 1, if srgb { 2 } else { 1 }, 0]);
    let side = format.block_side() as u8 - 1;
    out.extend([side, side, 0, 0]);
    out.extend([format.block_bytes() as u8, 0, 0, 0, 0, 0, 0, 0]);
    for Sample(first, bits, channel, highest) in samples {
        out.extend(first.to_le_bytes());
        out.extend([bits - 1, channel, 0, 0, 0, 0]);
        out.extend(0_u32.to_le_bytes());
        out.extend(highest.to_le_bytes());
    }
    out
}

/// The texture array of a file. Files by other writers are read where they have two dimensions, one face, a [`Format`] and no supercompression.
///
/// # Errors
/// Where `bytes` are no such file. What a header only claims is not allocated.
pub fn read(bytes: &[u8]) -> Result<TextureArray, TextureError> {
    fn fault(place: &'static str, what: impl Into<String>) -> TextureError {
        TextureError::new(place, what)
    }
    if !bytes.starts_with(&IDENTIFIER) {
        return Err(fault("identifier", "this is no KTX 2.0 file"));
    }
    let number = |at: usize| {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(four.try_into().ok()?))
    };
    let word = |i: usize| number(12 + 4 * i).ok_or_else(|| fault("header", "cut short"));
    let long = |at: usize| Some(u64::from(number(at)?) | u64::from(number(at + 4)?) << 32);
    let vk = word(0)?;
    let (format, srgb) = Format::from_vk(vk).ok_or_else(|| {
        fault("vkFormat", format!("{vk}; expected that of 8 or 16 bits or BC1 without alpha, BC3, BC4, BC5"))
    })?;
    let expected_size = if format == Format::R16 { 2 } else { 1 };
    for (name, at, expected) in [
        ("typeSize", 1, expected_size),
        ("pixelDepth", 4, 0),
        ("faceCount", 6, 1),
        ("supercompressionScheme", 8, 0),
        ("sgdByteOffset", 13, 0),
        ("sgdByteOffset", 14, 0),
        ("sgdByteLength", 15, 0),
        ("sgdByteLength", 16, 0),
    ] {
        let found = word(at)?;
        if found != expected {
            return Err(fault(name, format!("{found}; expected {expected}")));
        }
    }
    let head = Head { format, srgb, width: word(2)?, height: word(3)?, layers: word(5)?.max(1), levels: word(7)? };
    head.check()?;
    let index_end = HEAD + ENTRY * head.levels as usize;
    let range = |at: u64, length: u64| {
        let (start, end) = (usize::try_from(at).ok()?, usize::try_from(at.checked_add(length)?).ok()?);
        (start >= index_end).then(|| bytes.get(start..end)).flatten()
    };
    let descriptor_bytes = range(word(9)?.into(), word(10)?.into()).filter(|d| d.len() >= 28);
    let found = descriptor_bytes.ok_or_else(|| fault("data format descriptor", "cut short"))?;
    check_descriptor(found, format, srgb)?;
    let (keys_at, keys_length) = (word(11)?, word(12)?);
    if keys_length > 0 && range(keys_at.into(), keys_length.into()).is_none() {
        return Err(fault("keys and values", "they leave the file"));
    }
    let mut array = head.array();
    for level in 0..head.levels {
        let entry = HEAD + ENTRY * level as usize;
        let (Some(at), Some(length), Some(plain)) = (long(entry), long(entry + 8), long(entry + 16)) else {
            return Err(fault("level index", "cut short"));
        };
        let expected = array.layer_bytes(level) * u64::from(head.layers);
        if (length, plain) != (expected, expected) {
            return Err(fault("level index", format!("level {level} has {length} bytes; expected {expected}")));
        }
        let aligned = at.is_multiple_of(alignment(format) as u64);
        let texels = range(at, length).filter(|_| aligned);
        let what = || format!("level {level}: {length} bytes at {at} leave the file or are not aligned");
        array.levels.push(texels.ok_or_else(|| fault("level index", what()))?.to_vec());
    }
    array.checked()
}

/// Whether a descriptor tells of the same texels as the header; the colours' primaries, and keys beside them, do not matter.
fn check_descriptor(found: &[u8], format: Format, srgb: bool) -> Result<(), TextureError> {
    let expected = descriptor(format, srgb);
    let differs = |range: std::ops::Range<usize>| found.get(range.clone()) != expected.get(range);
    // Sizes, kind of descriptor and model; the transfer curve; blocks and samples.
    let size = expected.len();
    for (what, range) in [("kind", 0..13), ("transfer function", 14..15), ("blocks or samples", 16..size)] {
        if differs(range) {
            let what = format!("its {what} are not those of {format:?}, sRGB {srgb}");
            return Err(TextureError::new("data format descriptor", what));
        }
    }
    Ok(())
}
