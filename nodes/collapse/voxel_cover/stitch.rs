//! Closing gaps by single triangles.
//!
//! Where two boundaries face each other across a slit, each within the tolerance, the eye may pass between them. A gap is a group of lines of
//! sight whose voxels touch each other. Triangles are tried between all vertices of the faces around it, and points outside
//! of it: often one side is an edge of the one boundary, and the third corner lies on the other. Of those that lie within the tolerance and meet a line of the
//! gap, the one that meets most lines is added, those of other gaps included, until none of the gap is open. Larger gaps come first.

use super::{
    Goal, Silhouette,
    cover::{Boxes, Cover, Demand, Naming},
    drop::neighbours,
    lines::{Lines, Place, gaps},
    remove::agrees,
};
use crate::{
    math::{Stop, Stopped},
    voxel::{
        VoxelMesh,
        gaps::{Look, Sight, bare, cross},
        shear::{CONTINUOUS, WIDE},
        touch::{Point, centre, normal, point, squared},
    },
};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// How gaps are looked for, whatever the surface.
const COARSE: Look =
    Look { shears: &[-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75], offsets: &[[0.0; 2]], most_layers: f32::INFINITY };
/// And where alpha cuts outlines: from all over the cell, and between the centres of pixels; where surfaces are continuous, since there the
/// eye finds what is missing.
const FINE: Look = Look { shears: &WIDE, offsets: &[[-0.25, -0.25], [0.25, 0.25]], most_layers: CONTINUOUS };
/// Most vertices around a gap that triangles are tried between.
const MOST_VERTICES: usize = 16;
/// Most triangles for one gap.
const MOST_TRIANGLES: usize = 8;
/// Most lines of sight of a gap by which triangles are compared.
const SAMPLES: usize = 256;
/// Most triangles of a gap that are tested against the boxes: where those that meet most lie outside, others hardly do better.
const MOST_TESTS: usize = 64;
/// A triangle that stays inside the boxes is preferred to one that runs out to the sides, if it meets no less than this share of its lines.
const INSIDE: f64 = 0.5;

/// Adds triangles to `mesh` where surfaces show through its gaps. `bounds`: the box that vertices stay in.
pub fn stitch(mesh: &mut VoxelMesh, goal: Goal, bounds: [Point; 2], stop: &Stop) -> Result<(), Stopped> {
    let faces: Vec<_> = (0..mesh.faces.len()).map(|f| mesh.triangle(f)).collect();
    let alpha = goal.silhouette == Silhouette::Alpha;
    let look = |look| bare(&mesh.voxels, &faces, look, alpha, stop);
    let mut sights = look(COARSE)?;
    // Boundaries that end with the surface leave so many narrow gaps that closing them all takes an eighth more triangles.
    if alpha {
        sights.extend(look(FINE)?);
    }
    if sights.is_empty() {
        return Ok(());
    }
    let boxes = Boxes { half: 2.0 * goal.factor, skirt: goal.skirt() };
    let demands = vec![Demand::Nothing; mesh.voxels.len()];
    let mut cover = Cover::new(&mesh.voxels, demands, boxes, &mesh.cover_start, mesh.cover.to_vec());
    let naming = cover.faces_by_voxel();
    let gaps = gaps(&mesh.voxels, sights);
    let mut lines = Lines::new(&mesh.voxels, &gaps);
    let mut added: Vec<[Place; 3]> = Vec::new();
    for number in 0..gaps.len() {
        for _ in 0..MOST_TRIANGLES {
            stop.check()?;
            if lines.open(number).next().is_none() {
                break;
            }
            let gap: Vec<Sight> = lines.open(number).copied().collect();
            let found = [Reach::Near, Reach::Far].into_iter().find_map(|reach| {
                Surroundings::of(&gap, mesh, &naming, reach, bounds, &mut cover).best(number, &lines, &mut cover)
            });
            let Some(corners) = found else { break };
            lines.close(number, corners);
            cover.push_face();
            cover.add((mesh.faces.len() + added.len()) as u32, corners.map(point));
            added.push(corners);
        }
    }
    append(mesh, &added, &cover);
    Ok(())
}

/// Where places outside of a gap are tried.
#[derive(Clone, Copy)]
enum Reach {
    /// A pixel away, in the layers of the voxels around it.
    Near,
    /// Two pixels away, in the layers of the gap's own voxels: where the voxels around lie in other layers, lines of sight that come in
    /// at an angle pass by.
    Far,
}

/// What lies around a gap.
struct Surroundings {
    /// Between which triangles are tried.
    places: Vec<Place>,
    /// Sum of the normals of the faces.
    normal: Point,
}

impl Surroundings {
    /// Collects the voxels around the gap as those that triangles must stay near.
    fn of(
        gap: &[Sight],
        mesh: &VoxelMesh,
        naming: &Naming,
        reach: Reach,
        bounds: [Point; 2],
        cover: &mut Cover,
    ) -> Self {
        let near: BTreeSet<u32> = gap.iter().flat_map(|s| s.voxels).collect();
        let near: BTreeSet<u32> = near.iter().flat_map(|v| neighbours(&mesh.voxels, *v)).collect();
        let faces: BTreeSet<u32> = near.iter().flat_map(|v| naming.of(*v)).copied().collect();
        // Those that were added meanwhile are no faces of the mesh yet.
        cover.collect(faces.iter().copied());
        let normal = faces.iter().fold([0.0; 3], |sum, f| {
            let [a, b, c] = mesh.triangle(*f as usize);
            let n = normal(a, b, c);
            std::array::from_fn(|i| sum[i] + n[i])
        });
        let centres: Vec<Point> = near.iter().map(|v| centre(&mesh.voxels[*v as usize])).collect();
        let middle: Point = std::array::from_fn(|i| centres.iter().map(|c| c[i]).sum::<f64>() / centres.len() as f64);
        let vertices: BTreeSet<Place> =
            faces.iter().flat_map(|f| mesh.faces[*f as usize]).map(|v| mesh.vertices[v as usize]).collect();
        let mut places: Vec<Place> = vertices.into_iter().collect();
        places.sort_by(|a, b| squared(point(*a), middle).total_cmp(&squared(point(*b), middle)));
        places.truncate(MOST_VERTICES);
        let fronts: BTreeSet<u32> = gap.iter().map(Sight::voxel).collect();
        let fronts: Vec<Point> = fronts.iter().map(|v| centre(&mesh.voxels[*v as usize])).collect();
        places.extend(match reach {
            Reach::Near => outside(&fronts, 4.0, &centres, bounds),
            Reach::Far => outside(&fronts, 8.0, &fronts, bounds),
        });
        Self { places, normal }
    }

    /// The triangle that meets most of the open lines of a gap and of later ones, the smallest of those; `None` where none that is allowed meets
    /// any of the gap.
    fn best(&self, gap: usize, lines: &Lines, cover: &mut Cover) -> Option<[Place; 3]> {
        let points: Vec<Point> = self.places.iter().map(|p| point(*p)).collect();
        let own = seen(lines.open(gap).collect(), &points);
        let beside = seen(lines.beside(gap, &self.places).collect(), &points);
        let all: Vec<[usize; 3]> =
            (2..points.len()).flat_map(|k| (1..k).flat_map(move |j| (0..j).map(move |i| [i, j, k]))).collect();
        let count = |t: &[usize; 3]| {
            let met = |lines: &[Seen]| lines.iter().filter(|s| s.meets(*t)).count();
            let count = Some(met(&own)).filter(|n| *n > 0)? + met(&beside);
            let [i, j, k] = *t;
            let sides = [[i, j], [j, k], [k, i]].map(|[p, q]| squared(points[p], points[q]).sqrt());
            Some((count, sides.iter().sum::<f64>(), *t))
        };
        let mut found: Vec<_> = all.par_iter().with_min_len(256).filter_map(count).collect();
        found.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)));
        let mut outer: Option<(usize, [usize; 3])> = None;
        for (count, _, [i, j, k]) in found.into_iter().take(MOST_TESTS) {
            if outer.is_some_and(|(most, _)| (count as f64) < INSIDE * most as f64) {
                break;
            }
            // It shows the side that the faces around it show.
            let sides = [[i, j, k], [i, k, j]];
            let Some(corners) = sides.into_iter().find(|t| agrees(t.map(|i| points[i]), self.normal)) else { continue };
            let triangle = corners.map(|i| points[i]);
            let mut holds = |outer| cover.holds(triangle[1], triangle[2], outer) && cover.holds_face(triangle, outer);
            if holds(false) {
                return Some(corners.map(|i| self.places[i]));
            }
            if outer.is_none() && holds(true) {
                outer = Some((count, corners));
            }
        }
        outer.map(|(_, corners)| corners.map(|i| self.places[i]))
    }
}

/// A line of sight, and points as they are seen along it.
struct Seen<'a> {
    sight: &'a Sight,
    points: Vec<Point>,
    /// The cross product of every two points, row by row.
    crossed: Vec<f64>,
}

impl Seen<'_> {
    /// Whether the triangle between three of the points meets the line.
    fn meets(&self, [i, j, k]: [usize; 3]) -> bool {
        let crossed = |p: usize, q: usize| self.crossed[p * self.points.len() + q];
        self.sight.meets_between([i, j, k].map(|p| self.points[p][2]), [crossed(j, k), crossed(k, i), crossed(i, j)])
    }
}

/// A sample of lines of sight.
fn seen<'a>(lines: Vec<&'a Sight>, points: &[Point]) -> Vec<Seen<'a>> {
    let every = lines.len().div_ceil(SAMPLES).max(1);
    let seen = |sight: &'a Sight| {
        let points: Vec<Point> = points.iter().map(|p| sight.seen(*p)).collect();
        let crossed = points.iter().flat_map(|p| points.iter().map(|q| cross(*p, *q))).collect();
        Seen { sight, points, crossed }
    };
    lines.into_iter().step_by(every).map(seen).collect()
}

/// Eight places outside of the box around `fronts`, `margin` quarter pixels away, in the layers of those of `centres` that lie nearest to the sides.
fn outside(fronts: &[Point], margin: f64, centres: &[Point], bounds: [Point; 2]) -> Vec<Place> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for c in fronts {
        low = std::array::from_fn(|i| low[i].min(c[i] - margin));
        high = std::array::from_fn(|i| high[i].max(c[i] + margin));
    }
    let at = |i: usize, step: usize| match step {
        0 => low[i],
        1 => ((low[i] + high[i]) / 2.0).round(),
        _ => high[i],
    };
    let steps = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]];
    let places = steps.iter().filter_map(|step| {
        let to: [f64; 2] = std::array::from_fn(|i| at(i, step[i]).clamp(bounds[0][i], bounds[1][i]));
        let away = |c: &Point| (c[0] - to[0]) * (c[0] - to[0]) + (c[1] - to[1]) * (c[1] - to[1]);
        let nearest = centres.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
        Some([to[0] as i32, to[1] as i32, (nearest[2] / 4.0) as i32])
    });
    places.collect()
}

/// Adds faces with vertices of their own; `cover` has their lists.
fn append(mesh: &mut VoxelMesh, added: &[[Place; 3]], cover: &Cover) {
    let first = mesh.vertices.len() as u32;
    let faces = (0..added.len() as u32).map(|i| [0, 1, 2].map(|k| first + 3 * i + k));
    let (mut start, mut list) = (mesh.cover_start.to_vec(), mesh.cover.to_vec());
    for f in mesh.faces.len()..mesh.faces.len() + added.len() {
        let from = list.len();
        list.extend_from_slice(cover.list(f as u32));
        list[from..].sort_unstable();
        start.push(list.len() as u32);
    }
    mesh.faces = mesh.faces.iter().copied().chain(faces).collect();
    mesh.vertices = mesh.vertices.iter().copied().chain(added.iter().flatten().copied()).collect();
    mesh.flags = mesh.flags.iter().copied().chain(added.iter().flatten().map(|_| 0)).collect();
    mesh.cover_start = start.into();
    mesh.cover = list.into();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{sample_fields as fields, voxel::cover_mesh::cover_meshes};

    const TWO_VOXELS_OUT: [Point; 2] = [[-8.0, -8.0, 0.0], [200.0, 200.0, 40.0]];

    /// A wall whose faces in a part of it are missing.
    fn wall(missing: impl Fn([Point; 3]) -> bool) -> VoxelMesh {
        let mut solid = fields::Solid::new(40, 24, 3);
        solid.patch([2.0, 2.0, 0.0], [36.0, 0.0, 2.0], [0.0, 20.0, 0.0]);
        let slices = fields::slices(solid.size, solid.layers);
        let (_, mesh) = cover_meshes(&slices, &[&solid.field()], &Stop::default()).unwrap().remove(0);
        let kept: Vec<usize> = (0..mesh.faces.len()).filter(|f| !missing(mesh.triangle(*f))).collect();
        let lists = kept.iter().map(|f| mesh.covered_by(*f));
        let start = lists.clone().scan(0, |sum, l| {
            *sum += l.len() as u32;
            Some(*sum)
        });
        VoxelMesh {
            faces: kept.iter().map(|f| mesh.faces[*f]).collect(),
            cover_start: std::iter::once(0).chain(start).collect(),
            cover: lists.flatten().copied().collect(),
            ..mesh
        }
    }

    fn open(mesh: &VoxelMesh) -> usize {
        let faces: Vec<_> = (0..mesh.faces.len()).map(|f| mesh.triangle(f)).collect();
        bare(&mesh.voxels, &faces, COARSE, true, &Stop::default()).unwrap().len()
    }

    #[test]
    fn a_slit_closes_within_the_tolerance() {
        let within = |t: [Point; 3], low: f64, high: f64| t.iter().all(|p| (low..=high).contains(&p[0]));
        let mut mesh = wall(|t| within(t, 60.0, 66.0));
        let before = mesh.clone();
        assert!(open(&mesh) > 0);
        let goal = Goal { factor: 2.0, silhouette: Silhouette::Alpha };
        stitch(&mut mesh, goal, TWO_VOXELS_OUT, &Stop::default()).unwrap();
        mesh.validate().unwrap();
        let added = before.faces.len()..mesh.faces.len();
        assert_eq!(open(&mesh), 0);
        assert!((1..=4).contains(&added.len()), "{added:?}");
        assert_eq!(mesh.faces[..before.faces.len()], before.faces[..]);
        for f in added {
            assert!(within(mesh.triangle(f), 40.0, 86.0) && !mesh.covered_by(f).is_empty(), "{:?}", mesh.triangle(f));
        }
    }

    #[test]
    fn what_is_whole_stays_as_it_is() {
        let mut mesh = wall(|_| false);
        let before = mesh.clone();
        for silhouette in [Silhouette::Alpha, Silhouette::Geometry] {
            stitch(&mut mesh, Goal { factor: 2.0, silhouette }, TWO_VOXELS_OUT, &Stop::default()).unwrap();
            assert_eq!(mesh.faces, before.faces);
        }
    }

    #[test]
    fn gaps_are_apart_and_the_largest_comes_first() {
        let around = |t: [Point; 3], x: f64| t.iter().all(|p| (p[0] - x).abs() <= 3.0);
        let mesh = wall(|t| around(t, 30.0) && t.iter().all(|p| (40.0..60.0).contains(&p[1])) || around(t, 90.0));
        let faces: Vec<_> = (0..mesh.faces.len()).map(|f| mesh.triangle(f)).collect();
        let sights = bare(&mesh.voxels, &faces, COARSE, true, &Stop::default()).unwrap();
        let all = gaps(&mesh.voxels, sights.clone());
        assert_eq!(all.len(), 2);
        assert!(all[0].len() > all[1].len() && all[0].len() + all[1].len() == sights.len());
        let x = |s: &Sight| mesh.voxels[s.voxel() as usize].x;
        assert!(all[0].iter().all(|s| x(s) > 15) && all[1].iter().all(|s| x(s) < 15));
    }

    /// Against all lines, with the triangles that the wall lacks.
    #[test]
    fn a_triangle_closes_the_lines_that_it_meets() {
        let around = |t: [Point; 3], x: f64| t.iter().all(|p| (p[0] - x).abs() <= 3.0);
        let hole = |t: [Point; 3]| [30.0, 44.0, 90.0].iter().any(|x| around(t, *x));
        let (whole, mesh) = (wall(|_| false), wall(hole));
        let faces: Vec<_> = (0..mesh.faces.len()).map(|f| mesh.triangle(f)).collect();
        let all = gaps(&mesh.voxels, bare(&mesh.voxels, &faces, COARSE, true, &Stop::default()).unwrap());
        assert!(all.len() > 1);
        let mut lines = Lines::new(&mesh.voxels, &all);
        let (mut closed, mut beside) = (0, 0);
        for f in (0..whole.faces.len()).filter(|f| hole(whole.triangle(*f))) {
            let corners = whole.faces[f].map(|v| whole.vertices[v as usize]);
            let open = |lines: &Lines| -> Vec<Sight> { (0..all.len()).flat_map(|g| lines.open(g).copied()).collect() };
            let before = open(&lines);
            beside += lines.beside(0, &corners).count();
            lines.close(0, corners);
            let meets = |s: &Sight| s.meets(corners.map(|p| s.seen(point(p))));
            let expect: Vec<Sight> = before.iter().filter(|s| !meets(s)).copied().collect();
            closed += before.len() - expect.len();
            assert_eq!(open(&lines), expect);
        }
        assert!(closed > 0 && beside > 0);
        assert!((0..all.len()).all(|g| lines.open(g).next().is_none()));
    }
}
