//! 8-bit pictures, and PNG files of them.

use std::path::{Path, PathBuf};

/// RGBA, sRGB-encoded, alpha linear; row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// `width * height` texels.
    pub texels: Vec<[u8; 4]>,
}

/// Why a picture could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error("{}: {source}", path.display())]
    Png { path: PathBuf, source: image::ImageError },
    #[error("{}: a picture of {width}×{height} pixels has {found} texels", path.display())]
    Size { path: PathBuf, width: u32, height: u32, found: usize },
}

/// Writes a PNG file; the same bytes for the same picture.
pub fn save_png(path: &Path, picture: &Picture) -> Result<(), PictureError> {
    let Picture { width, height, texels } = picture;
    if *width as usize * *height as usize != texels.len() {
        let found = texels.len();
        return Err(PictureError::Size { path: path.into(), width: *width, height: *height, found });
    }
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    image::save_buffer_with_format(path, bytes, *width, *height, image::ColorType::Rgba8, image::ImageFormat::Png)
        .map_err(|source| PictureError::Png { path: path.into(), source })
}

/// The bytes of a PNG file; the same for the same picture.
pub fn encode_png(picture: &Picture) -> Result<Vec<u8>, PictureError> {
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let name = || PathBuf::from("picture");
    let Picture { width, height, texels } = picture;
    if *width as usize * *height as usize != texels.len() {
        return Err(PictureError::Size { path: name(), width: *width, height: *height, found: texels.len() });
    }
    let mut out = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Adaptive);
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    image::ImageEncoder::write_image(encoder, bytes, *width, *height, image::ExtendedColorType::Rgba8)
        .map_err(|source| PictureError::Png { path: name(), source })?;
    Ok(out)
}

/// Reads a PNG file of any colour type as 8-bit RGBA. The `image` crate's default limits on size apply.
pub fn load_png(path: &Path) -> Result<Picture, PictureError> {
    let wrap = |source| PictureError::Png { path: path.into(), source };
    let mut reader = image::ImageReader::open(path).map_err(|e| wrap(e.into()))?;
    reader.set_format(image::ImageFormat::Png);
    let picture = reader.decode().map_err(wrap)?.into_rgba8();
    let (width, height) = picture.dimensions();
    Ok(Picture { width, height, texels: picture.pixels().map(|p| p.0).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let texels = (0..12u8).map(|i| [i, i * 2, 255 - i, i * 20]).collect();
        let picture = Picture { width: 4, height: 3, texels };
        save_png(&path, &picture).unwrap();
        assert_eq!(load_png(&path).unwrap(), picture);
        std::fs::write(&path, encode_png(&picture).unwrap()).unwrap();
        assert_eq!(load_png(&path).unwrap(), picture);
    }

    #[test]
    fn errors_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b.png");
        assert!(load_png(&path).unwrap_err().to_string().contains("b.png"));
        let short = Picture { width: 4, height: 3, texels: vec![[0; 4]; 11] };
        assert!(matches!(save_png(&path, &short), Err(PictureError::Size { found: 11, .. })));
    }
}
