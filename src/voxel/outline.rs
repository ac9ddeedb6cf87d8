//! Where surfaces end, as the cell's centre sees it: how much of each voxel's pixel its surface covers.
//!
//! Voxels of one pixel in successive layers are a *run*: one surface, steep where the run is long. A run goes on in a neighbouring
//! pixel where a run there touches it. A surface is whole inside: a run that goes on in all eight neighbours is opaque,
//! whatever sampling found. Beside an end it is as opaque as the samples say. What is thinner than a pixel ends on both sides; filtered
//! texels would lose it below a coverage of one half, so it is at least as opaque as it takes to be seen from texel to texel. Steep
//! runs are opaque: the centre may see a sliver where another place of the cell sees much.

use super::{
    Voxel,
    columns::{Columns, around},
};
use glam::{DVec2, DVec3};

/// Layers between the runs of neighbouring pixels up to which they touch: seen from the cell such a step is within the error that
/// simplification makes, so that what lies behind it may be taken for the same surface, and must not show through it.
const STEP: u16 = 3;

/// From so many layers between its first and last on a run is steep.
const STEEP: u16 = 2;
/// The least opacity of what is thinner than a pixel, if anything of it is covered.
const THIN: u8 = 224;

/// Where one voxel's surface ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Run {
    /// First and last layer of its run.
    pub first: u16,
    pub last: u16,
    /// 255: opaque.
    pub opacity: u8,
    /// Whether the surface ends in a neighbouring pixel.
    pub open: bool,
}

impl Run {
    fn touches(&self, other: &Run) -> bool {
        self.first <= other.last.saturating_add(STEP) && other.first <= self.last.saturating_add(STEP)
    }

    /// Whether other places of the cell may see more of it than the centre does.
    fn is_steep(&self) -> bool {
        self.last - self.first >= STEEP
    }

    /// Layers from the run to a place.
    fn distance(&self, layer: f64) -> f64 {
        (f64::from(self.first) - layer).max(layer - f64::from(self.last)).max(0.0)
    }
}

/// The runs of a mesh's voxels.
pub struct Outline {
    /// Per voxel.
    pub runs: Vec<Run>,
}

/// An image as far as it matters at its sides.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    pub size: [u32; 2],
    /// Whether the surface may go on in another image beyond the left, right, top and bottom side.
    pub goes_on: [bool; 4],
}

/// The eight neighbours, opposite ones four apart.
const AROUND: [[i32; 2]; 8] = [[-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0], [1, 1], [0, 1], [-1, 1]];

impl Outline {
    pub fn new(columns: &Columns, image: Option<Image>) -> Self {
        let voxels = columns.voxels;
        let mut runs = vec![Run::default(); voxels.len()];
        for (_, _, column) in columns.all() {
            for run in column.chunk_by(|a, b| voxels[*b as usize].layer - voxels[*a as usize].layer <= 1) {
                let layer = |i: Option<&u32>| i.map_or(0, |i| voxels[*i as usize].layer);
                let found = Run { first: layer(run.first()), last: layer(run.last()), ..Run::default() };
                run.iter().for_each(|i| runs[*i as usize] = found);
            }
        }
        let beyond = |x: i32, y: i32| {
            image.is_some_and(|i| {
                let [w, h] = i.size.map(|s| s as i32);
                let out = [x < 0, x >= w, y < 0, y >= h];
                out.iter().zip(i.goes_on).any(|(out, goes_on)| *out && goes_on)
            })
        };
        for (x, y, column) in columns.all() {
            for run in column.chunk_by(|a, b| voxels[*b as usize].layer - voxels[*a as usize].layer <= 1) {
                let here = runs[run[0] as usize];
                let ends = AROUND.map(|[i, j]| {
                    let (x, y) = (i32::from(x) + i, i32::from(y) + j);
                    let there = columns.column(f64::from(x), f64::from(y));
                    !beyond(x, y) && !there.iter().any(|n| runs[*n as usize].touches(&here))
                });
                let open = ends.contains(&true) && run.iter().any(|i| voxels[*i as usize].ring == 0);
                let coverage = run.iter().map(|i| voxels[*i as usize].color[3]).max().unwrap_or(0);
                let thin = (0..4).any(|k| ends[k] && ends[k + 4]);
                let opacity = match (open && !here.is_steep(), thin) {
                    (false, _) => 255,
                    (true, false) => coverage,
                    (true, true) => thin_opacity(coverage),
                };
                run.iter().for_each(|i| runs[*i as usize] = Run { opacity, open, ..here });
            }
        }
        Self { runs }
    }

    /// [`Outline::opacity`] at `p` (x, y in pixels, z the layer), bilinear over the four nearest pixels.
    pub fn filtered(&self, columns: &Columns, p: DVec3, reach: f64) -> u8 {
        let opacity = |(at, weight): (DVec2, f64)| weight * f64::from(self.opacity(columns, at.x, at.y, p.z, reach));
        around(p.truncate(), 1.0).map(opacity).sum::<f64>().round() as u8
    }

    /// How opaque the surface is that passes a pixel near `layer`: the most of the runs within `reach` layers, or else of one that touches such a
    /// run of a neighbouring pixel, as steep surfaces do. Where none does it is transparent; opaque only if all that lies around is
    /// hidden, because surfaces go on behind what hides them.
    pub fn opacity(&self, columns: &Columns, x: f64, y: f64, layer: f64, reach: f64) -> u8 {
        let run = |i: &u32| self.runs[*i as usize];
        let near = |r: &Run| r.distance(layer) <= reach;
        let column = columns.column(x, y);
        if let Some(most) = column.iter().map(run).filter(near).map(|r| r.opacity).max() {
            return most;
        }
        let (mut seen, mut hidden) = (false, false);
        for [i, j] in AROUND {
            for n in columns.column(x + f64::from(i), y + f64::from(j)) {
                let beside = run(n);
                if !near(&beside) {
                    continue;
                }
                if let Some(r) = column.iter().map(run).find(|r| r.touches(&beside)) {
                    return r.opacity;
                }
                let visible = columns.voxels[*n as usize].ring == 0;
                seen |= visible;
                hidden |= !visible;
            }
        }
        if hidden && !seen { 255 } else { 0 }
    }
}

/// The opacity of what is thinner than a pixel.
fn thin_opacity(coverage: u8) -> u8 {
    if coverage == 0 { 0 } else { coverage.max(THIN) }
}

/// Less than this is a trace of a surface.
const TRACE: u8 = 96;

/// Whether a voxel must stay covered where alpha cuts outlines: whether more than a trace of it is seen.
pub fn counts(run: &Run, voxel: &Voxel) -> bool {
    voxel.ring == 0 && run.opacity >= TRACE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::testing::voxel;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn outline(voxels: &[Voxel]) -> Vec<Run> {
        Outline::new(&Columns::new(voxels, 0..voxels.len() as u32), None).runs
    }

    fn field(places: impl IntoIterator<Item = (u16, u16, u16, u8)>) -> Vec<Voxel> {
        let sorted: BTreeMap<_, _> = places.into_iter().map(|(x, y, l, c)| ((l, y, x), c)).collect();
        let one = |((l, y, x), c): ((u16, u16, u16), u8)| Voxel { color: [9, 9, 9, c], ..voxel(x, y, l, [0; 3]) };
        sorted.into_iter().map(one).collect()
    }

    /// A slope of two layers a pixel with samples missing everywhere: whole inside, as covered as the samples say at its ends.
    #[test]
    fn a_continuous_surface_is_opaque_inside() {
        let slope = |x: u16| [2 * x, 2 * x + 1];
        let voxels = field((0..9u16).flat_map(|x| (0..7u16).flat_map(move |y| slope(x).map(move |l| (x, y, l, 70)))));
        for (v, run) in voxels.iter().zip(outline(&voxels)) {
            let (ends_x, ends_y) = ([0, 8].contains(&v.x), [0, 6].contains(&v.y));
            // Corners count as thin.
            let expect = [255, 70, THIN][usize::from(ends_x) + usize::from(ends_y)];
            assert_eq!((run.open, run.opacity), (ends_x || ends_y, expect), "{v:?}");
            assert_eq!([run.first, run.last], slope(v.x));
        }
    }

    /// What ends on both sides stays above the cutoff from a coverage of a quarter on.
    #[test]
    fn thin_lines_do_not_vanish() {
        for coverage in [64, 128, 192, 255] {
            let voxels = field((0..9u16).map(|x| (x, 3, 5, coverage)));
            assert!(outline(&voxels).iter().all(|r| r.opacity >= coverage.max(128)), "{coverage}");
        }
    }

    /// A roof that the centre sees edge-on, in one row of pixels and barely a sample.
    #[test]
    fn what_is_seen_edge_on_counts() {
        let voxels = field((0..9u16).flat_map(|x| (2..8u16).map(move |l| (x, 3, l, 0))));
        assert!(voxels.iter().zip(outline(&voxels)).all(|(v, r)| r.opacity == 255 && counts(&r, v)));
        let row = field((0..9u16).map(|x| (x, 3, 2, 0)));
        assert!(row.iter().zip(outline(&row)).all(|(v, r)| !counts(&r, v)));
    }

    #[test]
    fn what_is_hidden_goes_on() {
        let mut voxels = field((0..6u16).flat_map(|x| (0..6u16).map(move |y| (x, y, 2, 30))));
        voxels.iter_mut().for_each(|v| v.ring = 1);
        let columns = Columns::new(&voxels, 0..36);
        let outline = Outline::new(&columns, None);
        assert!(outline.runs.iter().all(|r| r.opacity == 255));
        assert_eq!(outline.opacity(&columns, 6.5, 3.5, 2.0, 2.0), 255);
        assert_eq!(outline.opacity(&columns, 8.5, 3.5, 2.0, 2.0), 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Against all pairs of voxels.
        #[test]
        fn agrees_with_looking_at_all(
            places in prop::collection::btree_map((0..6u16, 0..6u16, 0..7u16), 0..=255u8, 1..120),
            hidden in prop::collection::vec(prop::bool::weighted(0.3), 120),
        ) {
            let mut voxels = field(places.into_iter().map(|((x, y, l), c)| (x, y, l, c)));
            voxels.iter_mut().zip(&hidden).for_each(|(v, h)| v.ring = u8::from(*h));
            let at = |x: i32, y: i32, l: u16| voxels.iter().find(|v| (i32::from(v.x), i32::from(v.y), v.layer) == (x, y, l));
            for (v, run) in voxels.iter().zip(outline(&voxels)) {
                let (x, y) = (i32::from(v.x), i32::from(v.y));
                let first = (0..=v.layer).rev().take_while(|l| at(x, y, *l).is_some()).last().unwrap();
                let last = (v.layer..9).take_while(|l| at(x, y, *l).is_some()).last().unwrap();
                prop_assert_eq!((run.first, run.last), (first, last));
                let goes_on = |i: i32, j: i32| (first.saturating_sub(STEP)..=last + STEP).any(|l| at(x + i, y + j, l).is_some());
                let seen = (first..=last).any(|l| at(x, y, l).unwrap().ring == 0);
                let whole = (-1..=1).all(|j| (-1..=1).all(|i| goes_on(i, j)));
                prop_assert_eq!(run.open, seen && !whole);
                let thin = [(1, 0), (0, 1), (1, 1), (1, -1)].iter().any(|(i, j)| !goes_on(*i, *j) && !goes_on(-i, -j));
                let most = (first..=last).map(|l| at(x, y, l).unwrap().color[3]).max().unwrap();
                let expect = if !run.open || last - first >= STEEP { 255 } else if thin { thin_opacity(most) } else { most };
                prop_assert_eq!(run.opacity, expect);
            }
        }
    }
}
