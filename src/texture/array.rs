//! Texture arrays: layers of one size and format, with mip levels.

use super::{Format, block, format::MOST_SIDE, mip::Level};

/// Layers that every current graphics API takes.
pub const MOST_LAYERS: u32 = 1 << 11;

/// Layers of one size and format, with mip levels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextureArray {
    pub format: Format,
    /// Colours are sRGB-encoded (alpha never is); only for formats that can be, see [`Format::has_srgb`].
    pub srgb: bool,
    /// Of the first level, 1 to [`MOST_SIDE`].
    pub width: u32,
    pub height: u32,
    /// 1 to [`MOST_LAYERS`].
    pub layers: u32,
    /// From the largest, 1 to [`TextureArray::most_levels`]; each side of a level is half of that before, rounded down, at least 1. A level holds its
    /// layers one after the other.
    pub levels: Vec<Vec<u8>>,
}

/// What is wrong with a texture or the file of one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {what}")]
pub struct TextureError {
    pub place: &'static str,
    pub what: String,
}

impl TextureError {
    pub(super) fn new(place: &'static str, what: impl Into<String>) -> Self {
        Self { place, what: what.into() }
    }
}

impl TextureArray {
    /// Encodes layers, each given as its mip levels from the largest.
    ///
    /// # Errors
    /// Where there is no layer, or layers or levels differ in number or size from what an array has.
    pub fn encode(format: Format, srgb: bool, layers: &[Vec<Level>]) -> Result<Self, TextureError> {
        assemble(format, srgb, layers, |l| block::encode(format, srgb, l.width, l.height, &l.texels))
    }

    /// [`Self::encode`] as R16.
    ///
    /// # Errors
    /// As [`Self::encode`].
    pub fn encode16(layers: &[Vec<Level<u16>>]) -> Result<Self, TextureError> {
        assemble(Format::R16, false, layers, |l| block::encode16(&l.texels))
    }

    /// Width and height of a level.
    pub fn size(&self, level: u32) -> (u32, u32) {
        let half = |n: u32| n.checked_shr(level).unwrap_or(0).max(1);
        (half(self.width), half(self.height))
    }

    /// Bytes of one layer of a level.
    pub fn layer_bytes(&self, level: u32) -> u64 {
        let (width, height) = self.size(level);
        self.format.bytes(width, height)
    }

    /// Bytes of all levels and layers.
    pub fn bytes(&self) -> u64 {
        self.levels.iter().map(|l| l.len() as u64).sum()
    }

    /// Levels down to one texel.
    pub fn most_levels(width: u32, height: u32) -> u32 {
        32 - width.max(height).max(1).leading_zeros()
    }

    /// The texels of one layer of a level; `None` where there is none.
    pub fn texels(&self, level: u32, layer: u32) -> Option<&[u8]> {
        let n = usize::try_from(self.layer_bytes(level)).ok()?;
        let start = n.checked_mul(layer as usize)?;
        let whole = self.levels.get(level as usize)?;
        (layer < self.layers).then(|| whole.get(start..start.checked_add(n)?)).flatten()
    }

    /// The image that one layer of a level shows, see [`super::decode`]; `None` where there is none.
    pub fn decode(&self, level: u32, layer: u32) -> Option<Level> {
        let (width, height) = self.size(level);
        let texels = block::decode(self.format, width, height, self.texels(level, layer)?)?;
        Some(Level { width, height, texels })
    }

    /// Itself, where everything is as the fields say.
    ///
    /// # Errors
    /// What is wrong.
    pub fn checked(self) -> Result<Self, TextureError> {
        self.check().map(|()| self)
    }

    /// What is wrong with it, if anything is.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self) -> Result<(), TextureError> {
        Head {
            format: self.format,
            srgb: self.srgb,
            width: self.width,
            height: self.height,
            layers: self.layers,
            levels: u32::try_from(self.levels.len()).unwrap_or(u32::MAX),
        }
        .check()?;
        for (i, level) in self.levels.iter().enumerate() {
            let expected = self.layer_bytes(i as u32) * u64::from(self.layers);
            if level.len() as u64 != expected {
                let what = format!("level {i} has {} bytes; expected {expected}", level.len());
                return Err(TextureError::new("levels", what));
            }
        }
        Ok(())
    }
}

fn assemble<T>(
    format: Format,
    srgb: bool,
    layers: &[Vec<Level<T>>],
    encode: impl Fn(&Level<T>) -> Vec<u8>,
) -> Result<TextureArray, TextureError> {
    let Some(first) = layers.first().and_then(|l| l.first()) else {
        return Err(TextureError::new("layers", "none; expected 1 or more with 1 or more levels"));
    };
    let count = layers[0].len();
    let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let head = Head {
        format,
        srgb,
        width: first.width,
        height: first.height,
        layers: number(layers.len()),
        levels: number(count),
    };
    head.check()?;
    let mut array = head.array();
    for (i, layer) in layers.iter().enumerate() {
        let right = |(at, level): (usize, &Level<T>)| {
            let texels = u64::from(level.width) * u64::from(level.height);
            (level.width, level.height) == array.size(at as u32) && level.texels.len() as u64 == texels
        };
        if layer.len() != count || !layer.iter().enumerate().all(right) {
            let (width, height) = (head.width, head.height);
            let what = format!("layer {i}: expected {count} levels from {width}×{height} on, each half of the last");
            return Err(TextureError::new("layers", what));
        }
    }
    array.levels = (0..count).map(|at| layers.iter().flat_map(|layer| encode(&layer[at])).collect()).collect();
    array.checked()
}

/// What the head of a file claims of a texture array.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head {
    pub format: Format,
    pub srgb: bool,
    pub width: u32,
    pub height: u32,
    pub layers: u32,
    pub levels: u32,
}

impl Head {
    pub fn check(&self) -> Result<(), TextureError> {
        let Self { width, height, layers, levels, .. } = *self;
        if self.srgb && !self.format.has_srgb() {
            return Err(TextureError::new("format", format!("{:?} has no sRGB variant", self.format)));
        }
        if width.min(height) < 1 || width.max(height) > MOST_SIDE {
            return Err(TextureError::new(
                "size",
                format!("{width}×{height}; expected 1 to {MOST_SIDE} texels a side"),
            ));
        }
        if !(1..=MOST_LAYERS).contains(&layers) {
            return Err(TextureError::new("layers", format!("{layers}; expected 1 to {MOST_LAYERS}")));
        }
        let most = TextureArray::most_levels(width, height);
        if !(1..=most).contains(&levels) {
            return Err(TextureError::new("levels", format!("{levels}; expected 1 to {most} for {width}×{height}")));
        }
        Ok(())
    }

    /// An array without texels yet.
    pub fn array(&self) -> TextureArray {
        let Self { format, srgb, width, height, layers, .. } = *self;
        TextureArray { format, srgb, width, height, layers, levels: Vec::new() }
    }
}
