//! The colour of a place in voxel space: the nearest voxels, weighted by distance (section 7).

use crate::image::srgb;
use crate::voxel::{
    Voxel,
    lattice::{self, Lattice, Nearest},
};
use glam::{DVec3, Vec3};

/// Below this many voxels, looking at all is faster than an index.
const FEW: usize = 24;
/// Softens the weight 1/(d² + ε²) so that a voxel at distance 0 does not rule alone; voxel sides.
pub const EPS: f64 = 0.25;

/// Voxels to take colours from.
pub enum Source<'a> {
    Few(&'a [Voxel]),
    Many(&'a [Voxel], Lattice<'a>),
}

impl<'a> Source<'a> {
    /// `voxels` sorted by (layer, y, x), not empty.
    pub fn new(voxels: &'a [Voxel]) -> Self {
        if voxels.len() < FEW { Self::Few(voxels) } else { Self::Many(voxels, Lattice::new(voxels)) }
    }

    fn nearest(&self, p: DVec3, weight: DVec3, n: usize) -> (&'a [Voxel], Nearest) {
        match self {
            Self::Few(v) => (v, lattice::nearest_of_few(v, p, weight, n)),
            Self::Many(v, lattice) => (v, lattice.nearest(p, weight, n)),
        }
    }

    /// sRGB colour and world normal at a place: the `n` nearest voxels weighted by 1/(d² + ε²), averaged in linear
    /// light; one voxel's own bytes where all agree. Distances by `weight`, see [`Lattice::nearest`].
    pub fn sample(&self, p: DVec3, weight: DVec3, n: usize) -> ([u8; 4], Vec3) {
        let (voxels, nearest) = self.nearest(p, weight, n);
        mix(nearest.found().iter().map(|&(d2, i)| (1.0 / (d2 + EPS * EPS), voxels[i as usize])))
    }
}

/// sRGB colour and world normal of voxels by weight, averaged in linear light; one voxel's own bytes where all agree.
pub fn mix(of: impl IntoIterator<Item = (f64, Voxel)>) -> ([u8; 4], Vec3) {
    let (mut colour, mut normal, mut sum) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    let mut first = None;
    let mut alike = true;
    for (w, v) in of {
        let rgb = [v.color[0], v.color[1], v.color[2]];
        alike &= rgb == *first.get_or_insert(rgb);
        let w = w as f32;
        colour += Vec3::from_array([0, 1, 2].map(|k| srgb::to_linear(v.color[k]))) * w;
        normal += octahedral(v.normal) * w;
        sum += w;
    }
    let color = match first {
        Some([r, g, b]) if alike => [r, g, b, 255],
        _ => {
            let [r, g, b] = (colour / sum.max(f32::MIN_POSITIVE)).to_array().map(srgb::from_linear);
            [r, g, b, 255]
        }
    };
    (color, normal.try_normalize().unwrap_or(Vec3::Z))
}

/// The unit vector of an octahedral normal scaled to ±32767.
pub fn octahedral(n: [i16; 2]) -> Vec3 {
    let [x, y] = n.map(|c| f32::from(c) / 32767.0);
    let z = 1.0 - x.abs() - y.abs();
    let t = (-z).max(0.0);
    Vec3::new(x - t.copysign(x), y - t.copysign(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::testing::voxel;

    #[test]
    fn one_voxel_keeps_its_bytes() {
        let voxels = [voxel(3, 4, 1, [10, 200, 30]), voxel(5, 4, 1, [90, 0, 60])];
        let source = Source::new(&voxels);
        assert_eq!(source.sample(DVec3::new(3.6, 4.4, 1.2), DVec3::ONE, 1).0, [10, 200, 30, 255]);
        let between = source.sample(DVec3::new(4.5, 4.5, 1.0), DVec3::ONE, 2).0;
        assert!(between[0] > 50 && between[0] < 90 && between[1] > 100, "{between:?}: half the light of both");
    }

    #[test]
    fn octahedral_normals() {
        assert_eq!(octahedral([0, 0]), Vec3::Z);
        assert_eq!(octahedral([32767, 0]), Vec3::X);
        assert_eq!(octahedral([0, -32767]), Vec3::NEG_Y);
        assert!((octahedral([32767, 32767]) - Vec3::NEG_Z).length() < 1e-6);
    }
}
