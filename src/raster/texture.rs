//! Textures: coordinates, mip chains in linear light, filtering.

use crate::{
    array::Array,
    image::srgb,
    scene::{Image, Mesh, Texture, Wrap},
};
use glam::Vec4;

/// The texture coordinates of a triangle's corners, the texture's transform applied.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinates {
    pub corners: [[f64; 2]; 3],
}

impl Coordinates {
    /// A mesh without that set of coordinates has (0, 0) everywhere.
    pub fn new(texture: &Texture, mesh: &Mesh, indices: [u32; 3]) -> Self {
        let set = &mesh.uv[usize::from(texture.uv_set != 0)];
        let (sin, cos) = libm::sincos(texture.rotation as f64);
        // KHR_texture_transform: scale, then rotate counter-clockwise as seen with v pointing down, then offset.
        let corners = indices.map(|i| {
            let [u, v] = set.get(i as usize).copied().unwrap_or([0.0; 2]);
            let (u, v) = (u as f64 * texture.scale[0] as f64, v as f64 * texture.scale[1] as f64);
            [texture.offset[0] as f64 + cos * u + sin * v, texture.offset[1] as f64 - sin * u + cos * v]
        });
        Self { corners }
    }

    /// At barycentric coordinates `w`.
    #[inline]
    pub fn at(&self, w: [f64; 3]) -> [f64; 2] {
        let c = &self.corners;
        [0, 1].map(|k| c[0][k] * w[0] + c[1][k] * w[1] + c[2][k] * w[2])
    }
}

/// What an image's numbers mean, which decides how they are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    /// sRGB colour; alpha is kept but takes no part.
    Color,
    /// sRGB colour of a material with holes: weighted by alpha, so that what lies under holes does not bleed.
    CutoutColor,
    /// Plain numbers, such as normals.
    Data,
}

/// An image's mip levels in 8 bits, encoded as the image is; averages are made in linear light.
#[derive(Debug)]
pub(crate) struct Mips {
    levels: Vec<Level>,
    role: Role,
    /// Linear value of a byte of colour, 0 to 1.
    linear: [f32; 256],
}

#[derive(Debug)]
pub(crate) struct Level {
    pub width: u32,
    pub height: u32,
    pub texels: Array<[u8; 4]>,
}

impl Mips {
    pub fn new(image: &Image, role: Role) -> Self {
        let linear = std::array::from_fn(|i| match role {
            Role::Data => i as f32 / 255.0,
            _ => srgb::to_linear(i as u8),
        });
        let base = Level { width: image.width, height: image.height, texels: image.texels.clone() };
        let mut mips = Self { levels: vec![base], role, linear };
        while let Some(last) = mips.levels.last().filter(|l| l.width > 1 || l.height > 1) {
            let next = mips.halved(last);
            mips.levels.push(next);
        }
        mips
    }

    /// Half the size, rounded down, at least 1; every texel the mean over the area that it covers.
    fn halved(&self, level: &Level) -> Level {
        let (width, height) = ((level.width / 2).max(1), (level.height / 2).max(1));
        let columns: Vec<_> = (0..width).map(|x| spread(x, width, level.width)).collect();
        let source = &level.texels[..];
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            let rows = spread(y, height, level.height);
            for columns in &columns {
                let mut sum = Vec4::ZERO;
                for (sy, wy) in rows.into_iter().filter(|r| r.1 > 0.0) {
                    let row = &source[sy as usize * level.width as usize..];
                    for (sx, wx) in columns.iter().filter(|c| c.1 > 0.0) {
                        sum += self.decoded(row[*sx as usize]) * (wx * wy);
                    }
                }
                let c = self.finished(sum);
                let code = |v: f32| match self.role {
                    Role::Data => (v * 255.0 + 0.5) as u8,
                    _ => srgb::from_linear(v),
                };
                texels.push([code(c[0]), code(c[1]), code(c[2]), (c[3] * 255.0 + 0.5) as u8]);
            }
        }
        Level { width, height, texels: texels.into() }
    }

    /// A texel as it is averaged: linear, and where holes are cut, weighted by its alpha.
    #[inline]
    fn decoded(&self, t: [u8; 4]) -> Vec4 {
        let l = &self.linear;
        let alpha = t[3] as f32 * (1.0 / 255.0);
        let c = Vec4::new(l[t[0] as usize], l[t[1] as usize], l[t[2] as usize], alpha);
        if self.role == Role::CutoutColor { c * Vec4::new(alpha, alpha, alpha, 1.0) } else { c }
    }

    /// The average without its weight.
    #[inline]
    fn finished(&self, c: Vec4) -> [f32; 4] {
        if self.role == Role::CutoutColor && c.w > 0.0 {
            let scale = 1.0 / c.w;
            return [c.x * scale, c.y * scale, c.z * scale, c.w];
        }
        c.to_array()
    }

    /// Linear RGBA at `uv`; `footprint` is the squared length of a pixel's longer side on the base level, texels².
    /// Trilinear; where `smooth` is false, the nearest texel as long as texels are larger than pixels.
    #[inline]
    pub fn sample(&self, uv: [f64; 2], footprint: f32, wrap: [Wrap; 2], smooth: bool) -> [f32; 4] {
        let uv = [wrapped(uv[0], wrap[0]), wrapped(uv[1], wrap[1])];
        if !smooth && !(footprint > 1.0) {
            let base = &self.levels[0];
            let at = texel_of(uv[1], base.height) as usize * base.width as usize + texel_of(uv[0], base.width) as usize;
            return self.finished(self.decoded(base.texels[at]));
        }
        let lod = if footprint > 1.0 { (0.5 * log2(footprint)).min((self.levels.len() - 1) as f32) } else { 0.0 };
        let level = lod as usize;
        let part = lod - level as f32;
        let mut c = self.bilinear(&self.levels[level], uv, wrap);
        if part > 0.0
            && let Some(next) = self.levels.get(level + 1)
        {
            c += (self.bilinear(next, uv, wrap) - c) * part;
        }
        self.finished(c)
    }

    #[inline]
    fn bilinear(&self, level: &Level, uv: [f64; 2], wrap: [Wrap; 2]) -> Vec4 {
        let (x, fx) = neighbours(uv[0], level.width, wrap[0]);
        let (y, fy) = neighbours(uv[1], level.height, wrap[1]);
        let (texels, w) = (&level.texels[..], level.width as usize);
        let texel = |x: u32, y: u32| self.decoded(texels[y as usize * w + x as usize]);
        let (a, b, c, d) = (texel(x[0], y[0]), texel(x[1], y[0]), texel(x[0], y[1]), texel(x[1], y[1]));
        let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
        top + (bottom - top) * fy
    }

    /// The image, then each half as large as the one before, down to one texel.
    #[cfg(feature = "gpu")]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Texels of the base level.
    pub fn size(&self) -> [f64; 2] {
        [self.levels[0].width as f64, self.levels[0].height as f64]
    }
}

/// The alpha channel of a texture's base level.
pub(crate) struct AlphaMap<'a> {
    texture: &'a Texture,
    texels: &'a [[u8; 4]],
}

impl<'a> AlphaMap<'a> {
    pub fn new(texture: &'a Texture) -> Self {
        Self { texture, texels: &texture.image.texels }
    }

    /// 0 to 1: bilinear, or of the nearest texel where the texture is not smooth.
    pub fn at(&self, uv: [f64; 2]) -> f32 {
        let (image, wrap) = (&self.texture.image, self.texture.wrap);
        let uv = [wrapped(uv[0], wrap[0]), wrapped(uv[1], wrap[1])];
        let alpha = |x: u32, y: u32| self.texels[y as usize * image.width as usize + x as usize][3] as f32 / 255.0;
        if !self.texture.smooth {
            return alpha(texel_of(uv[0], image.width), texel_of(uv[1], image.height));
        }
        let (x, fx) = neighbours(uv[0], image.width, wrap[0]);
        let (y, fy) = neighbours(uv[1], image.height, wrap[1]);
        let row = |y: u32| {
            let (a, b) = (alpha(x[0], y), alpha(x[1], y));
            a + (b - a) * fx
        };
        let (top, bottom) = (row(y[0]), row(y[1]));
        top + (bottom - top) * fy
    }
}

/// The texel of the base level at a vertex; `None` where the mesh lacks that set of coordinates.
pub(crate) fn texel_at(texture: &Texture, mesh: &Mesh, vertex: u32) -> Option<[u8; 4]> {
    mesh.uv[usize::from(texture.uv_set != 0)].get(vertex as usize)?;
    let [u, v] = Coordinates::new(texture, mesh, [vertex; 3]).corners[0];
    let (image, wrap) = (&texture.image, texture.wrap);
    let (x, y) = (texel_of(wrapped(u, wrap[0]), image.width), texel_of(wrapped(v, wrap[1]), image.height));
    image.texels.get(y as usize * image.width as usize + x as usize).copied()
}

/// The source texels under texel `i` of `n`, and their shares: two or three of them, the rest with share 0.
fn spread(i: u32, n: u32, source: u32) -> [(u32, f32); 3] {
    let scale = source as f64 / n as f64;
    let (from, to) = (i as f64 * scale, (i + 1) as f64 * scale);
    let first = from as u32;
    std::array::from_fn(|k| {
        let at = first + k as u32;
        let covered = ((at + 1) as f64).min(to) - (at as f64).max(from);
        (at.min(source - 1), (covered.max(0.0) / scale) as f32)
    })
}

/// A texture coordinate brought to 0..=1; 0 where it is no number.
fn wrapped(u: f64, wrap: Wrap) -> f64 {
    let u = match wrap {
        Wrap::Repeat => u - floor(u),
        Wrap::Mirror => {
            let u = u - 2.0 * floor(u * 0.5);
            if u > 1.0 { 2.0 - u } else { u }
        }
        Wrap::Clamp => u,
    };
    if u >= 0.0 { u.min(1.0) } else { 0.0 }
}

fn floor(x: f64) -> f64 {
    let i = x as i64;
    if x < i as f64 { i as f64 - 1.0 } else { i as f64 }
}

/// The two texels between whose centres a wrapped coordinate lies, and how far it is from the first towards the second.
fn neighbours(u: f64, n: u32, wrap: Wrap) -> ([u32; 2], f32) {
    let x = u * n as f64 + 0.5;
    // x ≥ 0.5: truncation rounds down. Texel `i − 1` has its centre at i.
    let i = x as u32;
    let part = (x - i as f64) as f32;
    let (low, high) = match wrap {
        Wrap::Repeat => (n - 1, 0),
        _ => (0, n - 1),
    };
    ([if i == 0 { low } else { i - 1 }, if i >= n { high } else { i }], part)
}

/// The texel in which a wrapped coordinate lies.
fn texel_of(u: f64, n: u32) -> u32 {
    ((u * n as f64) as u32).min(n - 1)
}

/// Base-2 logarithm of a positive number, error below 1e-4: by exponent and a polynomial in the mantissa, so that it is
/// fast and has the same bits everywhere.
fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let m = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
    // log2(m) = (2/ln 2)·artanh(t), t = (m − 1)/(m + 1) ≤ 1/3.
    let t = (m - 1.0) / (m + 1.0);
    let t2 = t * t;
    exponent as f32 + t * (2.885_39 + t2 * (0.961_797 + t2 * (0.577_078 + t2 * 0.412_199)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, texel: impl Fn(u32) -> [u8; 4]) -> Image {
        Image { name: String::new(), width, height, texels: (0..width * height).map(texel).collect() }
    }

    #[test]
    fn logarithm() {
        let mut x = 1.0f32;
        while x < 1e6 {
            assert!((log2(x) - libm::log2(x as f64) as f32).abs() < 1e-4, "{x}");
            x *= 1.0137;
        }
        assert_eq!((log2(1.0), log2(2.0), log2(1024.0)), (0.0, 1.0, 10.0));
    }

    /// The smallest level is the mean of the whole image, whatever its size.
    #[test]
    fn levels_keep_the_mean() {
        for (w, h) in [(1, 1), (8, 8), (7, 5), (1, 9), (100, 3), (31, 64)] {
            let img = image(w, h, |i| [(i * 37 % 256) as u8, (i * 101 % 256) as u8, 7, (i * 11 % 256) as u8]);
            let mips = Mips::new(&img, Role::Data);
            let last = mips.levels.last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
            for k in 0..4 {
                let mean = img.texels.iter().map(|t| t[k] as f64 / 255.0).sum::<f64>() / (w * h) as f64;
                assert!((last.texels[0][k] as f64 / 255.0 - mean).abs() < 0.012, "{w}×{h}: {k}");
            }
        }
    }

    #[test]
    fn holes_do_not_bleed() {
        let img = image(2, 2, |i| if i == 0 { [255, 0, 0, 255] } else { [0, 255, 255, 0] });
        let mips = Mips::new(&img, Role::CutoutColor);
        let c = mips.sample([0.5, 0.5], 4.0, [Wrap::Repeat; 2], true);
        assert!((c[0] - 1.0).abs() < 1e-3 && c[1] == 0.0 && (c[3] - 0.25).abs() < 3e-3, "{c:?}");
        let c = mips.sample([0.45, 0.45], 0.5, [Wrap::Repeat; 2], true);
        assert!((c[0] - 1.0).abs() < 1e-3 && c[1] == 0.0, "{c:?}");
    }

    #[test]
    fn wrapping() {
        let img = image(4, 1, |i| [(i * 60) as u8, 0, 0, 255]);
        let mips = Mips::new(&img, Role::Data);
        let at = |u: f64, wrap| (mips.sample([u, 0.5], 0.1, [wrap; 2], true)[0] * 255.0).round() as u32;
        let centre = |i: i32| (i as f64 + 0.5) / 4.0;
        for (i, repeat, mirror, clamp) in [(-1, 180, 0, 0), (-2, 120, 60, 0), (4, 0, 180, 180), (5, 60, 120, 180)] {
            let found = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|w| at(centre(i), w));
            assert_eq!(found, [repeat, mirror, clamp], "{i}");
        }
        assert_eq!(at(0.0, Wrap::Repeat), 90);
        assert_eq!(at(0.0, Wrap::Clamp), 0);
        for u in [1e300, -1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e-30] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                assert!(at(u, wrap) <= 180);
                assert!(mips.sample([u; 2], 0.1, [wrap; 2], false)[0] <= 1.0);
                assert!(mips.sample([u; 2], 1e30, [wrap; 2], false)[0] <= 1.0);
            }
        }
        assert!(mips.sample([0.3; 2], f32::NAN, [Wrap::Clamp; 2], true)[0].is_finite());
        assert!(mips.sample([0.3; 2], f32::INFINITY, [Wrap::Clamp; 2], true)[0].is_finite());
    }
}
