//! From a solid to its layered depth image (section 3.1).
//!
//! The paper peels layer after layer with a second depth test. Here one pass gathers all surfaces of every ray: equal depths are
//! kept, of which strict peeling would drop one and turn inside and outside round behind it.

use super::{Direction, LayeredDepthImage, layered::INVALID, membrane::Solid};
use crate::{
    math::{Stop, Stopped},
    raster::{Backend, Geometry, MAX_SIDE, Options, Prepared, Tile, TileFragments, fragments_in_tiles},
    view::{Projection, View},
};
use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The unit cube around a solid, turned so that rays run along its third axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeFrame {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// P: the cube's centre in the world.
    centre: DVec3,
    /// Its side, metres.
    side: f64,
}

impl CubeFrame {
    /// The smallest cube so turned around all triangles; `None` where there are none, or where they have no finite extent above 0.
    pub fn around(geometry: &Geometry, direction: &Direction) -> Option<Self> {
        let [right, up, forward] = direction.axes();
        let turned = |t: u32| geometry.positions(t).map(|p| DVec3::new(p.dot(right), p.dot(up), p.dot(forward)));
        let (low, high) = (0..geometry.triangle_count())
            .into_par_iter()
            .map(turned)
            .map(|[a, b, c]| (a.min(b).min(c), a.max(b).max(c)))
            // Least and greatest are the same in any order.
            .reduce(|| (DVec3::INFINITY, DVec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let side = (high - low).max_element();
        let middle = (low + high) * 0.5;
        let centre = right * middle.x + up * middle.y + forward * middle.z;
        (side > 0.0 && side.is_finite() && centre.is_finite()).then_some(Self { right, up, forward, centre, side })
    }

    /// M of equation (2), from the world to texture space: (s, t, r) in [0, 1]³, t downwards, r along the rays.
    pub fn to_texture(&self) -> DAffine3 {
        let base = DMat3::from_cols(self.right, -self.up, self.forward).transpose() * (1.0 / self.side);
        DAffine3 { matrix3: base, translation: DVec3::splat(0.5) - base * self.centre }
    }

    /// Side of the cube, metres.
    pub fn side(&self) -> f64 {
        self.side
    }

    /// Its axes right, up and forward, its centre and its side.
    pub fn parts(&self) -> ([DVec3; 3], DVec3, f64) {
        ([self.right, self.up, self.forward], self.centre, self.side)
    }

    /// See [`CubeFrame::parts`]; `None` where the axes are not orthonormal or the side is not above 0.
    pub fn from_parts([right, up, forward]: [DVec3; 3], centre: DVec3, side: f64) -> Option<Self> {
        let unit = |v: DVec3| (v.length_squared() - 1.0).abs() < 1e-9;
        let upright = right.cross(up).distance(-forward) < 1e-9 && unit(right) && unit(up);
        (upright && centre.is_finite() && side > 0.0 && side.is_finite()).then_some(Self {
            right,
            up,
            forward,
            centre,
            side,
        })
    }

    pub(super) fn view(&self, resolution: u32) -> View {
        let half = self.side * 0.5;
        View {
            eye: self.centre - self.forward * half,
            right: self.right,
            up: self.up,
            forward: self.forward,
            projection: Projection::Orthographic { left: -half, right: half, bottom: -half, top: half },
            width: resolution,
            height: resolution,
            // What lies on the cube's sides is not clipped.
            near: -0.01 * self.side,
            far: 1.01 * self.side,
        }
    }
}

/// What happens to rays that cross the surface an odd number of times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Repair {
    /// They are an error.
    #[default]
    None,
    /// They count as empty.
    Drop,
    /// Crossings are kept where they enter and leave in turn.
    Pair,
    /// The winding number decides every ray: holes are closed, and where shapes overlap all that any of them holds is inside. For scans and
    /// other open or self-overlapping models whose triangles turn one side outwards (Jacobson et al. 2013).
    Winding,
}

/// How a solid is peeled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peeling {
    /// Texels along a side of the image.
    pub resolution: u32,
    /// Rays along a texel's side, 1 to 64. With more than one a texel holds what at least half of its rays hold, so that steep faces and
    /// thin parts, which rays through texel centres undersample (the paper's limitation), are not decided by one ray.
    pub samples: u32,
    pub repair: Repair,
}

/// A ray that crosses the surface an odd number of times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OddRay {
    pub texel: [u32; 2],
    pub crossings: u32,
}

/// A peeled solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Peeled {
    pub image: LayeredDepthImage,
    pub frame: CubeFrame,
    /// Those that were repaired, row by row.
    pub odd: Vec<OddRay>,
    /// How they were; [`Repair::None`] where there was nothing to repair. [`Repair::Winding`] decides every ray.
    pub repair: Repair,
}

#[derive(Debug, thiserror::Error)]
pub enum PeelError {
    #[error("there is nothing to peel: no triangle has an extent above 0")]
    Empty,
    #[error("no ray meets the surface at {0} × {0} texels")]
    Missed(u32),
    #[error("{0} rays along a texel's side; expected 1 to {side}", side = Tile::SIDE)]
    Samples(u32),
    #[error("{0} rays along a side of the image, texels times samples; expected 1 to {MAX_SIDE}")]
    Resolution(u64),
    #[error(
        "{} rays cross the surface an odd number of times, the first at texel ({}, {}): it is not closed; `--set peel.repair=winding` \
         closes its holes by the winding number (`pair` and `drop` mend single rays); or close the surface in its source",
        odd.len(), odd[0].texel[0], odd[0].texel[1]
    )]
    Open { odd: Vec<OddRay> },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Peels the triangles of `geometry` along `direction`. Where shapes overlap, inside is what an odd number of them holds.
pub fn peel(
    backend: &dyn Backend,
    geometry: &Geometry,
    direction: &Direction,
    how: &Peeling,
    stop: &Stop,
) -> Result<Peeled, PeelError> {
    let Peeling { resolution, samples, repair } = *how;
    let rays = u64::from(resolution) * u64::from(samples);
    if !(1..=u64::from(MAX_SIDE)).contains(&rays) {
        return Err(PeelError::Resolution(rays));
    }
    let frame = CubeFrame::around(geometry, direction).ok_or(PeelError::Empty)?;
    // A texel's rays lie in one tile.
    if samples > Tile::SIDE {
        return Err(PeelError::Samples(samples));
    }
    let side = Tile::SIDE / samples * samples;
    let view = frame.view(resolution * samples);
    let solid = if repair == Repair::Winding { Some(Solid::new(geometry, &frame, stop)?) } else { None };
    let texel = 1.0 / f64::from(resolution);
    let prepared = Prepared::with_tiles(geometry, &view, &Options::BOTH, side, stop)?;
    let tiles = fragments_in_tiles(backend, &prepared, stop, |tile, fragments| {
        let mut odd = Vec::new();
        let mut ray = |i: usize| -> Vec<f32> {
            let crossings = fragments.of(i).len() as u32;
            let (x, y) = tile.pixel(i);
            let is_odd = !crossings.is_multiple_of(2);
            if is_odd {
                odd.push(OddRay { texel: [x / samples, y / samples], crossings });
            }
            let depths = || fragments.of(i).iter().map(|f| frame.depth(f.depth)).collect();
            match &solid {
                // What was left undone is given up below.
                Some(_) if stop.is_set() => Vec::new(),
                Some(solid) => {
                    let [s, t] = [x, y].map(|p| (f64::from(p) + 0.5) / rays as f64);
                    let depths: Vec<f32> = depths();
                    solid.ranges(s, t, &depths, texel)
                }
                None if is_odd => frame.repaired(geometry, fragments, i, repair),
                None => depths(),
            }
        };
        let mut texels: Vec<Vec<f32>> = Vec::with_capacity(tile.pixels() / (samples * samples) as usize);
        for y in (0..tile.height).step_by(samples as usize) {
            for x in (0..tile.width).step_by(samples as usize) {
                let at = |k: u32| ((y + k / samples) * tile.width + x + k % samples) as usize;
                texels.push(if samples == 1 { ray(at(0)) } else { half((0..samples * samples).map(|k| ray(at(k)))) });
            }
        }
        let tile = Tile { y: tile.y / samples, width: tile.width / samples, ..tile };
        (tile, texels, odd)
    })?;
    stop.check()?;
    let mut odd: Vec<OddRay> = tiles.iter().flat_map(|t| &t.2).copied().collect();
    odd.sort_by_key(|o| (o.texel[1], o.texel[0]));
    if repair == Repair::None && !odd.is_empty() {
        return Err(PeelError::Open { odd });
    }
    let mut rows: Vec<Vec<&[f32]>> = vec![Vec::with_capacity(resolution as usize); resolution as usize];
    // Tiles come row by row, so that those of one row fill it from the left.
    for (tile, rays, _) in &tiles {
        for (y, row) in rays.chunks(tile.width as usize).enumerate() {
            rows[tile.y as usize + y].extend(row.iter().map(Vec::as_slice));
        }
    }
    let image = LayeredDepthImage::new([resolution; 2], rows.into_iter().flatten());
    if image.depths().is_empty() {
        return Err(PeelError::Missed(resolution));
    }
    let repair = if odd.is_empty() && repair != Repair::Winding { Repair::None } else { repair };
    Ok(Peeled { image, frame, odd, repair })
}

/// The ranges that at least half of some rays hold; where they touch they are one.
fn half(rays: impl ExactSizeIterator<Item = Vec<f32>>) -> Vec<f32> {
    let enough = rays.len().div_ceil(2);
    // What begins comes before what ends at the same depth.
    let mut ends: Vec<(f32, bool)> =
        rays.flat_map(|ray| ray.into_iter().enumerate().map(|(i, d)| (d, i % 2 == 1))).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (mut kept, mut count) = (Vec::new(), 0);
    for (depth, ends) in ends {
        if ends {
            count -= 1;
        } else {
            count += 1;
        }
        // It has just come to half, or is about to fall below it.
        if (!ends && count == enough) || (ends && count + 1 == enough) {
            kept.push(depth);
        }
    }
    kept
}

impl CubeFrame {
    /// From metres along the ray to [0, 1).
    fn depth(&self, metres: f32) -> f32 {
        /// The greatest below 1, which stands for no depth.
        const MOST: f32 = INVALID - f32::EPSILON / 2.0;
        ((f64::from(metres) / self.side) as f32).clamp(0.0, MOST)
    }

    fn repaired(&self, geometry: &Geometry, fragments: &TileFragments, i: usize, repair: Repair) -> Vec<f32> {
        if repair != Repair::Pair {
            return Vec::new();
        }
        let (mut kept, mut inside) = (Vec::new(), false);
        for f in fragments.of(i) {
            let [a, b, c] = geometry.positions(f.triangle);
            let enters = (b - a).cross(c - a).dot(self.forward) < 0.0;
            if enters != inside {
                kept.push(self.depth(f.depth));
                inside = enters;
            }
        }
        if inside {
            kept.pop();
        }
        kept
    }
}
