//! Relief maps as textures for graphics cards.

use super::{DepthBits, ReliefMap};
use crate::{
    array::Array,
    math::{Stop, Stopped},
    texture::{
        Format, TextureArray, TextureError,
        mip::{Level, Rule, chain},
    },
};
use rayon::prelude::*;

/// The images of all maps of an impostor, one texture array each; layer i is map i.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Textures {
    /// sRGB; with mip levels.
    pub color: TextureArray,
    /// [`ReliefMap::normal`] in the first two channels; with mip levels.
    pub normal: TextureArray,
    /// [`ReliefMap::depth`]; one level, to be read texel by texel.
    pub depth: TextureArray,
    /// [`ReliefMap::orm`]; with mip levels.
    pub orm: Option<TextureArray>,
    /// [`ReliefMap::emissive`], sRGB; with mip levels.
    pub emissive: Option<TextureArray>,
}

/// How maps become textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compression {
    /// BC1 for colours and materials and BC5 for normals, 1.5 bytes a texel with them; else RGBA8 and RG8.
    pub blocks: bool,
    /// Mip levels of each image, at most.
    pub levels: u32,
}

impl Default for Compression {
    fn default() -> Self {
        Self { blocks: true, levels: 16 }
    }
}

/// Why maps did not become textures.
#[derive(Debug, thiserror::Error)]
pub enum CompressError {
    #[error(transparent)]
    Texture(#[from] TextureError),
    #[error("{0}")]
    Maps(String),
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Makes the textures of maps of one size (section 4: 1 byte of depth, 1 of normal and ½ of colour for a texel). Texels without surface count for nothing
/// in mip levels, and have the value of the nearest surface.
///
/// # Errors
/// Where there is no map, or maps differ in size or in what they hold.
pub fn compress(maps: &[&ReliefMap], how: Compression, stop: &Stop) -> Result<Textures, CompressError> {
    let Some(first) = maps.first() else { return Err(CompressError::Maps("expected a relief map".into())) };
    let alike = |m: &&&ReliefMap| {
        (m.side(), m.bits, m.orm.len(), m.emissive.len())
            == (first.side(), first.bits, first.orm.len(), first.emissive.len())
    };
    if let Some(at) = maps.iter().position(|m| !alike(&m)) {
        return Err(CompressError::Maps(format!("map {at} has another size or other images than the first")));
    }
    let color = if how.blocks { Format::Bc1 } else { Format::Rgba8 };
    let normal = if how.blocks { Format::Bc5 } else { Format::Rg8 };
    let images = |texels: &(dyn Fn(&ReliefMap) -> Vec<[u8; 4]> + Sync), rule, format, srgb| {
        let layers = maps.par_iter().map(|map| {
            stop.check()?;
            let weight: Vec<u8> = map.color.iter().map(|c| c[3]).collect();
            let base = Level { width: map.side(), height: map.side(), texels: texels(map) };
            Ok(chain(&base, &weight, rule, how.levels))
        });
        let layers = layers.collect::<Result<Vec<_>, Stopped>>()?;
        Ok::<_, CompressError>(TextureArray::encode(format, srgb, &layers)?)
    };
    let opaque = |c: &[u8; 4]| [c[0], c[1], c[2], 255];
    Ok(Textures {
        color: images(&|m| m.color.iter().map(opaque).collect(), Rule::Color, color, true)?,
        normal: images(&|m| m.normal.iter().map(|n| [n[0], n[1], 0, 255]).collect(), Rule::Normal, normal, false)?,
        depth: depths(maps)?,
        orm: match first.orm.is_empty() {
            true => None,
            false => Some(images(&|m| m.orm.iter().map(opaque).collect(), Rule::Data, color, false)?),
        },
        emissive: match first.emissive.is_empty() {
            true => None,
            false => Some(images(&|m| m.emissive.iter().map(opaque).collect(), Rule::Color, color, true)?),
        },
    })
}

fn depths(maps: &[&ReliefMap]) -> Result<TextureArray, TextureError> {
    let side = maps[0].side();
    match maps[0].bits {
        DepthBits::Eight => {
            let layer = |m: &&ReliefMap| {
                let texels = m.depth.iter().map(|c| [*c as u8, 0, 0, 255]).collect();
                vec![Level { width: side, height: side, texels }]
            };
            TextureArray::encode(Format::R8, false, &maps.iter().map(layer).collect::<Vec<_>>())
        }
        DepthBits::Sixteen => {
            let layer = |m: &&ReliefMap| vec![Level { width: side, height: side, texels: m.depth.to_vec() }];
            TextureArray::encode16(&maps.iter().map(layer).collect::<Vec<_>>())
        }
    }
}

impl Textures {
    /// All arrays by the name of what they hold, in a fixed order.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &TextureArray)> {
        let optional = [("orm", self.orm.as_ref()), ("emissive", self.emissive.as_ref())];
        let optional = optional.into_iter().filter_map(|(name, array)| Some((name, array?)));
        [("color", &self.color), ("normal", &self.normal), ("depth", &self.depth)].into_iter().chain(optional)
    }

    /// Bytes of all texels.
    pub fn bytes(&self) -> u64 {
        self.named().map(|(_, array)| array.bytes()).sum()
    }

    /// Bits of a depth, which follow from its format; `None` where it is of neither.
    pub fn depth_bits(&self) -> Option<DepthBits> {
        match self.depth.format {
            Format::R8 => Some(DepthBits::Eight),
            Format::R16 => Some(DepthBits::Sixteen),
            _ => None,
        }
    }

    /// The images of map `layer` as they are read: [`ReliefMap`] with another camera's view put in by the caller. Colour has alpha 255 where there is a
    /// surface. `None` where arrays have no such layer, or other sizes or formats than an impostor's.
    pub fn map(&self, layer: u32, view: crate::view::View) -> Option<ReliefMap> {
        let bits = self.depth_bits()?;
        let side = self.depth.width;
        let texels = side as usize * side as usize;
        let image = |array: &TextureArray| {
            let level = array.decode(0, layer)?;
            (level.width == side && level.texels.len() == texels).then_some(level.texels)
        };
        let bytes = self.depth.texels(0, layer)?;
        let depth: Array<u16> = match bits {
            DepthBits::Eight => bytes.iter().map(|c| u16::from(*c)).collect(),
            DepthBits::Sixteen => bytes.as_chunks::<2>().0.iter().map(|c| u16::from_le_bytes(*c)).collect(),
        };
        let mut color = image(&self.color)?;
        for (c, code) in color.iter_mut().zip(depth.iter()) {
            c[3] = if u32::from(*code) < bits.levels() { 255 } else { 0 };
        }
        let optional = |array: &Option<TextureArray>| match array {
            None => Some(Array::default()),
            Some(array) => Some(image(array)?.into()),
        };
        let map = ReliefMap {
            view,
            bits,
            depth,
            color: color.into(),
            normal: image(&self.normal)?.iter().map(|n| [n[0], n[1]]).collect(),
            orm: optional(&self.orm)?,
            emissive: optional(&self.emissive)?,
        };
        map.check().ok().map(|()| map)
    }
}
