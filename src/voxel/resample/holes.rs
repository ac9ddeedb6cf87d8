//! A last look at a mesh whose outlines alpha cuts: holes inside surfaces are closed.
//!
//! Alpha says where a surface ends for the cell's centre. Another place of the cell may see the same surface go on there, and would look
//! through it. So opaque voxels and textured faces are drawn under shears, as in [`crate::voxel::gaps`]; where a face lies at the inside of a surface and
//! is transparent there, its texels become more opaque, by no more than closes the hole: beside it the surface may end.

use super::{Texture, charts::Chart, frame, place::Space};
use crate::{
    math::{Stop, Stopped},
    voxel::{
        gaps::{Picture, VoxelBounds},
        outline::Outline,
        shear::{CONTINUOUS, WIDE, under_all},
        touch::Point,
    },
};
use glam::DVec2;

/// Where pixels are looked at, beside their centres: gaps narrower than a pixel show between them.
const OFFSETS: [[f64; 2]; 4] = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
/// The least opacity that an alpha test passes.
const CUTOFF: f64 = 127.5;
/// The opacity to which holes are closed: enough for the test at the places between those that are looked at, too.
const CLOSED: f64 = 200.0;

/// A place of a chart, in texels of its rectangle.
#[derive(Clone, Copy)]
struct Spot {
    chart: u32,
    at: DVec2,
}

/// A face as it is looked at.
struct Textured {
    corners: [Point; 3],
    chart: u32,
    /// Texels of the chart's rectangle.
    uv: [DVec2; 3],
    /// Planar depths.
    depth: [f64; 3],
}

impl Textured {
    /// Where a renderer that corrects perspective shows the face at a pixel of a picture, in which its corners are `seen`.
    fn spot(&self, seen: &[Point; 3], at: [f64; 2]) -> Spot {
        let [a, b, c] = seen.map(|p| DVec2::new(p[0], p[1]));
        let p = DVec2::from(at);
        let area = (b - a).perp_dot(c - a);
        let (l1, l2) = ((p - a).perp_dot(c - a) / area, (b - a).perp_dot(p - a) / area);
        let weight = [(1.0 - l1 - l2) / self.depth[0], l1 / self.depth[1], l2 / self.depth[2]];
        let total: f64 = weight.iter().sum();
        let at = (0..3).fold(DVec2::ZERO, |sum, i| sum + self.uv[i] * (weight[i] / total));
        Spot { chart: self.chart, at }
    }
}

/// Makes texels more opaque through which the inside of a surface would be seen as a hole.
pub(super) fn close(
    space: &Space,
    charts: &[Chart],
    outline: &Outline,
    textures: &mut [Texture],
    margin: u32,
    stop: &Stop,
) -> Result<(), Stopped> {
    let voxels = &space.mesh.voxels;
    let Some(bounds) = VoxelBounds::around(voxels) else { return Ok(()) };
    let faces: Vec<Textured> = (0..)
        .zip(charts)
        .flat_map(|(chart, c)| c.faces.iter().map(move |f| (chart, c, *f)))
        .map(|(chart, c, f)| {
            let origin = frame(c, margin).0;
            let corner = DVec2::new(f64::from(origin[0]), f64::from(origin[1]));
            Textured {
                corners: space.mesh.triangle(f as usize),
                chart,
                uv: c.triangle(space, f).map(|uv| uv - corner),
                depth: space.mesh.faces[f as usize].map(|v| space.depth(v)),
            }
        })
        .collect();
    let cut: Vec<bool> = textures.iter().map(|t| t.color.iter().any(|c| c[3] < 255)).collect();
    let looked = &*textures;
    let found = under_all(&WIDE, stop, |shear| {
        let picture = Picture::new(voxels, &bounds, shear, |n| f64::from(outline.runs[n].opacity) >= CUTOFF);
        let mut open = Vec::new();
        for offset in OFFSETS {
            let mut shown = vec![false; picture.pixels()];
            // The transparent place that lies nearest to the surface, and how far from it.
            let mut holes: Vec<Option<(f32, Spot)>> = vec![None; picture.pixels()];
            for face in &faces {
                let seen = picture.seen(face.corners, offset);
                picture.draw(seen, |i, z| {
                    let inside = picture.is_inside(i) && picture.layers(i) <= CONTINUOUS;
                    if shown[i] || !inside || !picture.shows(i, z, false) {
                        return;
                    }
                    if !cut[face.chart as usize] {
                        shown[i] = true;
                        return;
                    }
                    let spot = face.spot(&seen, picture.at(i));
                    if looked[face.chart as usize].opacity(spot.at) >= CUTOFF {
                        shown[i] = true;
                    } else if picture.shows(i, z, true) {
                        let away = picture.away(i, z);
                        if holes[i].is_none_or(|(other, _)| away < other) {
                            holes[i] = Some((away, spot));
                        }
                    }
                });
            }
            open.extend((0..shown.len()).filter(|i| !shown[*i]).filter_map(|i| holes[i]).map(|(_, spot)| spot));
        }
        open
    })?;
    for spot in found.into_iter().flatten() {
        textures[spot.chart as usize].close(spot.at);
    }
    Ok(())
}

impl Texture {
    /// The four texels that are filtered at a place, and their weights.
    fn around(&self, at: DVec2) -> [(usize, f64); 4] {
        let height = self.color.len() / self.width;
        let limit = DVec2::new(self.width as f64 - 1.0, height as f64 - 1.0);
        let at = (at - 0.5).clamp(DVec2::ZERO, limit);
        let low = at.floor();
        let part = at - low;
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
            let (x, y) = ((low.x as usize + i).min(self.width - 1), (low.y as usize + j).min(height - 1));
            let along = |part: f64, k: usize| if k == 0 { 1.0 - part } else { part };
            (y * self.width + x, along(part.x, i) * along(part.y, j))
        })
    }

    /// Brings the four texels around a place as much nearer to opaque, all by one share, as makes it [`CLOSED`].
    fn close(&mut self, at: DVec2) {
        let opacity = self.opacity(at);
        if opacity >= CLOSED {
            return;
        }
        let share = (CLOSED - opacity) / (255.0 - opacity);
        for (i, _) in self.around(at) {
            let alpha = f64::from(self.color[i][3]);
            self.color[i][3] = (alpha + share * (255.0 - alpha)).ceil() as u8;
        }
    }

    fn opacity(&self, at: DVec2) -> f64 {
        self.around(at).iter().map(|(i, weight)| weight * f64::from(self.color[*i][3])).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::Stop,
        voxel::{VoxelMesh, columns::Columns, reproject::Reprojection, resample::charts, testing},
    };

    /// A wall with some of its texels transparent: which of them stay so.
    fn closed(cut: impl Fn(usize, usize, usize) -> bool) -> Vec<(bool, bool)> {
        let slices = testing::slices();
        let mesh = VoxelMesh { alpha: true, ..testing::wall(&slices) };
        let space = Space::new(&mesh, Reprojection::of(&slices, &mesh).unwrap());
        let charts = charts::cut(&space, 1.0, 2, 256, &Stop::default()).unwrap();
        let columns = Columns::new(&mesh.voxels, 0..mesh.voxels.len() as u32);
        let outline = Outline::new(&columns, None);
        let mut before = Vec::new();
        let mut textures: Vec<Texture> = charts
            .iter()
            .map(|c| {
                let [width, height] = frame(c, 2).1.map(|s| s as usize);
                let alpha = |i: usize| if cut(i % width, i / width, width) { 0 } else { 255 };
                let color: Vec<[u8; 4]> = (0..width * height).map(|i| [9, 9, 9, alpha(i)]).collect();
                before.extend(color.iter().map(|c| f64::from(c[3]) < CUTOFF));
                Texture { width, color, normal: Vec::new() }
            })
            .collect();
        close(&space, &charts, &outline, &mut textures, 2, &Stop::default()).unwrap();
        let after = textures.iter().flat_map(|t| t.color.iter().map(|c| f64::from(c[3]) < CUTOFF));
        before.into_iter().zip(after).collect()
    }

    #[test]
    fn a_hole_inside_is_closed_and_an_edge_stays_cut() {
        let hole = closed(|x, y, width| x.abs_diff(width / 2) <= 1 && (6..=8).contains(&y));
        assert!(hole.iter().any(|h| h.0));
        assert!(hole.iter().all(|h| !h.1), "the hole stays open");
        // The margin, and the outermost pixels of the surface.
        let edge = closed(|x, _, _| x < 3);
        assert!(edge.iter().any(|h| h.0));
        assert!(edge.iter().all(|h| h.0 == h.1), "the edge was filled");
    }

    #[test]
    fn a_place_is_closed_by_no_more_than_it_takes() {
        let texture =
            |alpha: [u8; 4]| Texture { width: 2, color: alpha.map(|a| [9, 9, 9, a]).to_vec(), normal: Vec::new() };
        for (alpha, at) in [([0; 4], [0.9, 1.2]), ([0, 255, 40, 90], [0.7, 1.4]), ([0, 0, 0, 255], [1.0, 1.0])] {
            let (mut closed, at) = (texture(alpha), DVec2::from(at));
            let before = closed.opacity(at);
            assert!(before < CUTOFF);
            closed.close(at);
            assert!((CLOSED..CLOSED + 1.0).contains(&closed.opacity(at)), "{}", closed.opacity(at));
            assert!(closed.color.iter().zip(alpha).all(|(c, a)| c[3] >= a));
            let again = closed.color.clone();
            closed.close(at);
            assert_eq!(closed.color, again);
        }
    }
}
