//! DDS files with a DX10 header.

use super::{Format, TextureArray, TextureError, array::Head};
use ddsfile::{AlphaMode, Caps2, D3D10ResourceDimension, Dds, DxgiFormat, Header, Header10, MiscFlag};

/// The file of a texture array. Each layer is stored with its levels, the largest first.
///
/// # Errors
/// Where `array` is not as its fields say.
pub fn write(array: &TextureArray) -> Result<Vec<u8>, TextureError> {
    array.check()?;
    let levels = array.levels.len() as u32;
    let mut data = Vec::with_capacity(array.bytes() as usize);
    for layer in 0..array.layers {
        for level in 0..levels {
            data.extend(array.texels(level, layer).unwrap_or_default());
        }
    }
    // The other formats have no alpha.
    let alpha = if array.format.channels() == 4 { AlphaMode::Straight } else { AlphaMode::Opaque };
    file(array.width, array.height, dxgi(array.format, array.srgb), levels, array.layers, alpha, data)
}

/// A square texture of two 32-bit channels (`R32G32_UINT`), `side`² texels row by row.
///
/// # Errors
/// Where the number of texels is not `side`².
pub fn write_rg32_uint(side: u32, texels: &[[u32; 2]]) -> Result<Vec<u8>, TextureError> {
    if texels.len() as u64 != u64::from(side) * u64::from(side) {
        return Err(TextureError::new("texture", format!("{} texels for a side of {side}", texels.len())));
    }
    let data = texels.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    file(side, side, DxgiFormat::R32G32_UInt, 1, 1, AlphaMode::Straight, data)
}

fn file(
    width: u32,
    height: u32,
    format: DxgiFormat,
    levels: u32,
    layers: u32,
    alpha: AlphaMode,
    data: Vec<u8>,
) -> Result<Vec<u8>, TextureError> {
    let refuse = |e: ddsfile::Error| TextureError::new("DDS", e.to_string());
    let header = Header::new_dxgi(height, width, None, format, Some(levels), Some(layers), None).map_err(refuse)?;
    let header10 = Header10::new(format, false, D3D10ResourceDimension::Texture2D, layers, alpha);
    let mut bytes = Vec::with_capacity(148 + data.len());
    Dds { header, header10: Some(header10), data }.write(&mut bytes).map_err(refuse)?;
    Ok(bytes)
}

fn dxgi(format: Format, srgb: bool) -> DxgiFormat {
    match (format, srgb) {
        (Format::R8, _) => DxgiFormat::R8_UNorm,
        (Format::Rg8, _) => DxgiFormat::R8G8_UNorm,
        (Format::Rgba8, false) => DxgiFormat::R8G8B8A8_UNorm,
        (Format::Rgba8, true) => DxgiFormat::R8G8B8A8_UNorm_sRGB,
        (Format::Bc1, false) => DxgiFormat::BC1_UNorm,
        (Format::Bc1, true) => DxgiFormat::BC1_UNorm_sRGB,
        (Format::Bc3, false) => DxgiFormat::BC3_UNorm,
        (Format::Bc3, true) => DxgiFormat::BC3_UNorm_sRGB,
        (Format::Bc4, _) => DxgiFormat::BC4_UNorm,
        (Format::Bc5, _) => DxgiFormat::BC5_UNorm,
        (Format::R16, _) => DxgiFormat::R16_UNorm,
    }
}

/// The texture array of a file with a DX10 header.
///
/// # Errors
/// Where `bytes` are no such file, or it holds a cube, a volume or another format. What a header only claims is not allocated.
pub fn read(bytes: &[u8]) -> Result<TextureArray, TextureError> {
    let fault = |what: String| TextureError::new("DDS", what);
    let dds = Dds::read(bytes).map_err(|e| fault(e.to_string()))?;
    let Some(header10) = &dds.header10 else {
        return Err(fault("it has no DX10 header".into()));
    };
    let number = header10.dxgi_format as u32;
    let (format, srgb) =
        Format::from_dxgi(number).ok_or_else(|| fault(format!("DXGI format {number} is not among those read here")))?;
    let flat = header10.resource_dimension == D3D10ResourceDimension::Texture2D
        && dds.get_depth() <= 1
        && !header10.misc_flag.contains(MiscFlag::TEXTURECUBE)
        && !dds.header.caps2.intersects(Caps2::CUBEMAP | Caps2::VOLUME);
    if !flat {
        return Err(fault("expected a texture of two dimensions, no cube and no volume".into()));
    }
    let head = Head {
        format,
        srgb,
        width: dds.header.width,
        height: dds.header.height,
        layers: header10.array_size,
        // Some writers say 0 where there is one.
        levels: dds.get_num_mipmap_levels().max(1),
    };
    head.check()?;
    let mut array = head.array();
    let stride: u64 = (0..head.levels).map(|l| array.layer_bytes(l)).sum();
    let expected = stride * u64::from(head.layers);
    if dds.data.len() as u64 != expected {
        return Err(fault(format!("{} bytes of texels; expected {expected}", dds.data.len())));
    }
    let mut start = 0;
    for level in 0..head.levels {
        let n = array.layer_bytes(level) as usize;
        let layers = dds.data.chunks_exact(stride as usize);
        array.levels.push(layers.flat_map(|layer| &layer[start..start + n]).copied().collect());
        start += n;
    }
    array.checked()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_dxgi() {
        for format in Format::ALL {
            for srgb in [false, true] {
                assert_eq!(dxgi(format, srgb) as u32, format.dxgi(srgb), "{format:?}");
            }
        }
    }

    #[test]
    fn a_texture_of_whole_numbers_reads_back() {
        let texels: Vec<[u32; 2]> = (0..9).map(|i| [i * 1_000_003, u32::MAX - i]).collect();
        let bytes = write_rg32_uint(3, &texels).unwrap();
        // Magic, header of 124 bytes, and DXGI_FORMAT_R32G32_UINT in the DX10 header.
        assert_eq!((&bytes[..4], bytes[4], &bytes[84..88], bytes[128]), (&b"DDS "[..], 124, &b"DX10"[..], 17));
        let dds = Dds::read(&bytes[..]).unwrap();
        assert_eq!((dds.get_width(), dds.get_height(), dds.get_dxgi_format()), (3, 3, Some(DxgiFormat::R32G32_UInt)));
        let read: Vec<u32> = dds.data.chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(read, texels.as_flattened());
        assert!(write_rg32_uint(2, &texels).is_err());
    }
}
