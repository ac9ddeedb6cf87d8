//! Textures of whole numbers as DDS with a DX10 header.

use super::FormatError;
use ddsfile::{AlphaMode, D3D10ResourceDimension, Dds, DxgiFormat, NewDxgiParams};

/// A square texture of two 32-bit channels (`R32G32_UINT`), `side`² texels row by row.
///
/// # Errors
/// Where the number of texels is not `side`².
pub fn write_rg32_uint(side: u32, texels: &[[u32; 2]]) -> Result<Vec<u8>, FormatError> {
    let refuse = |what: String| FormatError::Unwritable { object: "texture".into(), what };
    if texels.len() as u64 != u64::from(side) * u64::from(side) {
        return Err(refuse(format!("{} texels for a side of {side}", texels.len())));
    }
    let params = NewDxgiParams {
        height: side,
        width: side,
        depth: None,
        format: DxgiFormat::R32G32_UInt,
        mipmap_levels: Some(1),
        array_layers: None,
        caps2: None,
        is_cubemap: false,
        resource_dimension: D3D10ResourceDimension::Texture2D,
        alpha_mode: AlphaMode::Straight,
    };
    let mut dds = Dds::new_dxgi(params).map_err(|e| refuse(e.to_string()))?;
    dds.data = texels.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let mut bytes = Vec::new();
    dds.write(&mut bytes).map_err(|e| refuse(e.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_reads_back() {
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
