//! What a collapsed mesh must keep, on slopes, houses, ragged and random fields, and along seams.

use super::{
    Goal, Silhouette,
    contract::{Facing, look},
    demands, reduce, simplify,
    surface::Surface,
};
use crate::{
    math::Stop,
    sample_fields as fields,
    voxel::{
        Across, Field, Side, Slices, VoxelMesh,
        columns::Columns,
        cover_mesh::cover_meshes,
        outline::{Outline, counts},
        touch::{Toucher, centre, cover_unit, interval, interval_oblong, normal, point},
    },
};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

fn boundary(m: &VoxelMesh) -> Vec<(u32, u32)> {
    let directed: BTreeSet<_> = m.faces.iter().flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]).collect();
    directed.iter().filter(|(a, b)| !directed.contains(&(*b, *a))).copied().collect()
}

/// Edges that both frusta share, by position.
fn seam(m: &VoxelMesh) -> BTreeSet<([i32; 3], [i32; 3])> {
    let locked = |v: u32| m.flags[v as usize] & 1 == 1;
    let at = |v: u32| m.vertices[v as usize];
    boundary(m).into_iter().filter(|(a, b)| locked(*a) && locked(*b)).map(|(a, b)| (at(a), at(b))).collect()
}

fn check_cover(m: &VoxelMesh, half: f64, what: &str) {
    let mut named = vec![false; m.voxels.len()];
    for f in 0..m.faces.len() {
        let toucher = Toucher::new(m.triangle(f), half);
        for v in m.covered_by(f) {
            assert!(toucher.touches(&centre(&m.voxels[*v as usize])), "{what}: face {f} names voxel {v}, but is apart");
            named[*v as usize] = true;
        }
    }
    let visible = m.voxels.iter().zip(&named).filter(|(v, _)| v.ring == 0);
    assert!(visible.into_iter().all(|(_, n)| *n), "{what}: a visible voxel is uncovered");
    // The walls of receding surfaces run outside of boxes that are enlarged by less than this.
    for (a, b) in boundary(m).into_iter().filter(|_| half >= 3.0) {
        let (a, b) = (point(m.vertices[a as usize]), point(m.vertices[b as usize]));
        let mut parts: Vec<_> = m.voxels.iter().filter_map(|v| interval(a, b, &centre(v), half)).collect();
        assert!(cover_unit(&mut parts), "{what}: boundary edge {a:?}-{b:?} leaves the boxes");
    }
}

fn goal(factor: f64) -> Goal {
    Goal { factor, silhouette: Silhouette::Geometry }
}

/// Everything that the policy promises.
fn check(before: &VoxelMesh, factor: f64) -> VoxelMesh {
    let after = simplify(before, goal(factor), &Stop::default()).unwrap();
    after.validate().unwrap();
    assert_eq!(after.voxels, before.voxels);
    assert!(after.faces.len() <= before.faces.len());
    check_cover(&after, 2.0 * factor, "collapsed");
    let mut directed = BTreeSet::new();
    let mut fans: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for (f, face) in after.faces.iter().enumerate() {
        let [a, b, c] = after.triangle(f);
        assert_ne!(normal(a, b, c), [0.0; 3], "face {f} is degenerate");
        assert_ne!(look(normal(a, b, c)), Facing::Back, "face {f} folds over");
        for i in 0..3 {
            let (a, b, c) = (face[i], face[(i + 1) % 3], face[(i + 2) % 3]);
            assert!(directed.insert((a, b)), "edge {a}-{b} has more than two faces");
            fans.entry(a).or_default().push((b, c));
        }
    }
    for (v, faces) in &fans {
        // Walking from face to face reaches the whole fan.
        let entered: BTreeSet<u32> = faces.iter().map(|f| f.1).collect();
        let start = faces.iter().find(|f| !entered.contains(&f.0)).unwrap_or(&faces[0]);
        let (mut at, mut reached) = (start.1, 1);
        while let Some(next) = faces.iter().find(|f| f.0 == at).filter(|_| at != start.0) {
            at = next.1;
            reached += 1;
        }
        assert_eq!(reached, faces.len(), "vertex {v} has two fans");
    }
    assert_eq!(fans.len(), after.vertices.len(), "a vertex without a face");
    assert_eq!(seam(&after), seam(before), "the seam changed");
    for axis in 0..3 {
        let range = |m: &VoxelMesh| {
            let of = m.vertices.iter().map(|v| v[axis]);
            (of.clone().min(), of.max())
        };
        assert!(range(&after).0 >= range(before).0 && range(&after).1 <= range(before).1);
    }
    after
}

fn meshes(slices: &Slices, fields: &[&Field]) -> Vec<VoxelMesh> {
    cover_meshes(slices, fields, &Stop::default()).unwrap().into_iter().map(|m| m.1).collect()
}

fn solid_meshes(solid: &fields::Solid) -> Vec<VoxelMesh> {
    meshes(&fields::slices(solid.size, solid.layers), &[&solid.field()])
}

fn random_field(size: u32, layers: u32, frustum: u32, filled: &[bool]) -> Field {
    let at = |i: u32| (i % size, i / size % size, i / size / size);
    let voxels = (0..size * size * layers).filter(|i| filled[*i as usize]).map(|i| {
        let (x, y, l) = at(i);
        fields::voxel(x, y, l)
    });
    Field { frustum, voxels: voxels.collect(), ..Field::default() }
}

/// What holds where alpha cuts outlines: every voxel of which more than a trace is seen is touched, and boundaries stay within two voxels of the
/// boxes to the sides, and within the boxes in depth.
fn check_alpha(before: &VoxelMesh, factor: f64) -> VoxelMesh {
    let after = simplify(before, Goal { factor, silhouette: Silhouette::Alpha }, &Stop::default()).unwrap();
    after.validate().unwrap();
    assert!(after.alpha && after.voxels == before.voxels && after.faces.len() <= before.faces.len());
    let outline = Outline::new(&Columns::new(&after.voxels, 0..after.voxels.len() as u32), None);
    let half = 2.0 * factor;
    let mut named = vec![false; after.voxels.len()];
    for f in 0..after.faces.len() {
        let [a, b, c] = after.triangle(f);
        assert_ne!(look(normal(a, b, c)), Facing::Back, "face {f} folds over");
        let toucher = Toucher::new(after.triangle(f), half);
        for v in after.covered_by(f) {
            assert!(toucher.touches(&centre(&after.voxels[*v as usize])), "face {f} names voxel {v}, but is apart");
            named[*v as usize] = true;
        }
    }
    for ((v, run), named) in after.voxels.iter().zip(&outline.runs).zip(&named) {
        assert!(*named || !counts(run, v), "{v:?} is uncovered");
    }
    assert_eq!(seam(&after), seam(before), "the seam changed");
    for (a, b) in boundary(&after).into_iter().filter(|_| half >= 3.0) {
        let (a, b) = (point(after.vertices[a as usize]), point(after.vertices[b as usize]));
        let tube = [half + 8.0, half + 8.0, half];
        let mut parts: Vec<_> = after.voxels.iter().filter_map(|v| interval_oblong(a, b, &centre(v), tube)).collect();
        assert!(cover_unit(&mut parts), "boundary edge {a:?}-{b:?} leaves the tube");
    }
    after
}

/// `shares` are the voxels' coverages.
fn with_coverage(mut field: Field, shares: &[u8]) -> Field {
    let share = |(v, c): (&crate::voxel::Voxel, &u8)| crate::voxel::Voxel {
        color: [v.color[0], v.color[1], v.color[2], *c],
        ..*v
    };
    field.voxels = field.voxels.iter().zip(shares).map(share).collect();
    field
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn outlines_cut_by_alpha_stay_in_their_tube(
        filled in prop::collection::vec(prop::bool::weighted(0.6), 8 * 8 * 4),
        shares in prop::collection::vec(prop::sample::select(vec![0u8, 63, 127, 191, 255]), 8 * 8 * 4),
        factor in prop::sample::select(vec![1.0, 2.0, 3.0]),
    ) {
        let field = with_coverage(random_field(8, 4, 0, &filled), &shares);
        for m in meshes(&fields::slices([8, 8], 4), &[&field]) {
            check_alpha(&m, factor);
        }
    }

    #[test]
    fn random_fields_keep_their_cover(
        filled in prop::collection::vec(prop::bool::weighted(0.6), 8 * 8 * 4),
        factor in prop::sample::select(vec![1.0, 1.3, 2.0, 3.0]),
    ) {
        for m in meshes(&fields::slices([8, 8], 4), &[&random_field(8, 4, 0, &filled)]) {
            check(&m, factor);
        }
    }

    #[test]
    fn skirts_may_go_but_nothing_visible(
        filled in prop::collection::vec(prop::bool::weighted(0.6), 8 * 8 * 4),
        hidden in prop::collection::vec(prop::bool::weighted(0.4), 8 * 8 * 4),
    ) {
        let mut field = random_field(8, 4, 0, &filled);
        let ring = |(v, hidden): (&crate::voxel::Voxel, &bool)| crate::voxel::Voxel { ring: u8::from(*hidden), ..*v };
        field.voxels = field.voxels.iter().zip(&hidden).map(ring).collect();
        for m in meshes(&fields::slices([8, 8], 4), &[&field]) {
            // A mesh of which nothing is visible keeps a face all the same.
            prop_assert!(!check(&m, 2.0).faces.is_empty());
        }
    }

    #[test]
    fn seams_stay(
        filled in prop::collection::vec(prop::bool::weighted(0.7), 2 * 6 * 6 * 3),
    ) {
        let mut slices = fields::slices([6, 6], 3);
        let mut other = slices.frusta[0].clone();
        slices.frusta[0].across[1] = Some(Across { frustum: 1, side: Side::Left, reversed: false });
        other.across[0] = Some(Across { frustum: 0, side: Side::Right, reversed: false });
        slices.frusta.push(other);
        let (a, b) = (random_field(6, 3, 0, &filled[..108]), random_field(6, 3, 1, &filled[108..]));
        for m in meshes(&slices, &[&a, &b]) {
            check(&m, 2.0);
        }
    }

    #[test]
    fn ragged_heightfields_keep_their_cover(
        heights in prop::collection::vec(0u32..6, 14 * 14),
    ) {
        // Columns from a random height backwards: steps, walls and pits.
        let filled: Vec<bool> = (0..14 * 14 * 6).map(|i| {
            let (h, l) = (heights[i % 196], i as u32 / 196);
            l == h || (l > h && l <= h + 1)
        }).collect();
        for m in meshes(&fields::slices([14, 14], 6), &[&random_field(14, 6, 0, &filled)]) {
            check(&m, 2.0);
        }
    }
}

#[test]
fn planes_become_two_triangles() {
    let mut flat = fields::Solid::new(60, 40, 12);
    flat.patch([5.0, 5.0, 3.0], [50.0, 0.0, 0.0], [0.0, 30.0, 0.0]);
    let mut slope = fields::Solid::new(60, 40, 12);
    slope.patch([5.0, 5.0, 0.0], [50.0, 0.0, 11.0], [0.0, 30.0, 0.0]);
    for solid in [flat, slope] {
        let all = solid_meshes(&solid);
        assert_eq!(all.len(), 1);
        assert_eq!(check(&all[0], 2.0).faces.len(), 2);
    }
}

#[test]
fn a_house_becomes_few_triangles() {
    let mut house = fields::Solid::new(80, 60, 16);
    house.house([8.0, 35.0], [5.0, 50.0], 2.0, 9.0, 0.03);
    let all = solid_meshes(&house);
    let count: usize = all.iter().map(|m| check(m, 2.0).faces.len()).sum();
    assert!(count <= 32, "{count} triangles for a front, a roof and a side");
}

#[test]
fn alpha_leaves_hardly_more_triangles_of_a_skyline() {
    let solid = fields::skyline(160, 14, 10, 5);
    let all = solid_meshes(&solid);
    let alpha: usize = all.iter().map(|m| check_alpha(m, 2.0).faces.len()).sum();
    let geometry: usize = all.iter().map(|m| check(m, 2.0).faces.len()).sum();
    // Gaps are looked for more closely.
    assert!(20 * alpha <= 21 * geometry, "{alpha} against {geometry}");
}

#[test]
fn a_skyline_keeps_its_cover() {
    let solid = fields::skyline(160, 14, 10, 5);
    for m in solid_meshes(&solid) {
        check(&m, 2.0);
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let solid = fields::skyline(120, 10, 6, 2);
    for m in solid_meshes(&solid) {
        assert_eq!(check(&m, 2.0), check(&m, 2.0));
    }
}

#[test]
fn a_stop_is_obeyed() {
    let stop = Stop::default();
    stop.set();
    for m in solid_meshes(&fields::skyline(120, 10, 6, 2)).iter().filter(|m| m.faces.len() > 1000) {
        assert!(simplify(m, goal(2.0), &stop).is_err());
    }
}

/// The paper's algorithm, literally: plain lists, the shortest edge found by looking at all, one end onto the other.
/// Only what would leave an edge with three faces is refused beyond its own rules, and folds.
fn literal(m: &VoxelMesh, factor: f64) -> Vec<[u32; 3]> {
    let at = |v: u32| point(m.vertices[v as usize]);
    let half = 2.0 * factor;
    let mut faces: Vec<([u32; 3], BTreeSet<u32>)> =
        m.faces.iter().enumerate().map(|(f, c)| (*c, m.covered_by(f).iter().copied().collect())).collect();
    let mut failed = BTreeSet::new();
    loop {
        let mut count: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for (f, _) in &faces {
            (0..3).for_each(|i| {
                let (a, b) = (f[i], f[(i + 1) % 3]);
                *count.entry((a.min(b), a.max(b))).or_default() += 1;
            });
        }
        let on_boundary: BTreeSet<u32> =
            count.iter().filter(|(_, n)| **n == 1).flat_map(|((a, b), _)| [*a, *b]).collect();
        let length = |(a, b): (u32, u32)| {
            let (a, b) = (at(a), at(b));
            (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>()
        };
        let mut edges: Vec<_> = count.keys().flat_map(|(a, b)| [(*a, *b), (*b, *a)]).collect();
        edges.retain(|e| !failed.contains(e));
        edges.sort_by(|a, b| length(*a).total_cmp(&length(*b)).then(a.cmp(b)));
        let Some(&(a, b)) = edges.first() else { return faces.into_iter().map(|f| f.0).collect() };
        let (old, rest): (Vec<_>, Vec<_>) = faces.iter().cloned().partition(|f| f.0.contains(&a));
        let voxels: BTreeSet<u32> = old.iter().flat_map(|f| f.1.iter().copied()).collect();
        let kept: Vec<([u32; 3], [u32; 3])> =
            old.iter().filter(|f| !f.0.contains(&b)).map(|f| (f.0, f.0.map(|v| if v == a { b } else { v }))).collect();
        let new: Vec<_> = kept
            .iter()
            .map(|(_, f)| {
                let toucher = Toucher::new(f.map(at), half);
                let touched = voxels.iter().filter(|v| toucher.touches(&centre(&m.voxels[**v as usize])));
                (*f, touched.copied().collect::<BTreeSet<u32>>())
            })
            .collect();
        let covered =
            voxels.iter().all(|v| new.iter().any(|f| f.1.contains(v)) || rest.iter().any(|f| f.1.contains(v)));
        let sides = kept.iter().all(|(o, n)| super::contract::keeps_side(o.map(at), n.map(at)));
        let mut edge_ok = true;
        if on_boundary.contains(&a) {
            edge_ok = count[&(a.min(b), a.max(b))] == 1;
            for ((p, q), _) in count.iter().filter(|((p, q), n)| **n == 1 && (*p == a || *q == a)) {
                let end = if *p == a { *q } else { *p };
                let mut parts: Vec<_> = voxels
                    .iter()
                    .filter_map(|v| interval(at(end), at(b), &centre(&m.voxels[*v as usize]), half))
                    .collect();
                edge_ok &= end == b || cover_unit(&mut parts);
            }
        }
        let candidate: Vec<_> = rest.iter().cloned().chain(new).collect();
        let mut directed = BTreeSet::new();
        let manifold = candidate.iter().all(|(f, _)| (0..3).all(|i| directed.insert((f[i], f[(i + 1) % 3]))))
            && !candidate.is_empty();
        if covered && sides && edge_ok && manifold {
            let near: BTreeSet<u32> = candidate.iter().filter(|f| f.0.contains(&b)).flat_map(|f| f.0).collect();
            failed.retain(|(p, q)| !near.contains(p) && !near.contains(q));
            faces = candidate;
        } else {
            failed.insert((a, b));
        }
    }
}

#[test]
fn no_more_faces_than_the_literal_algorithm_leaves() {
    let mut house = fields::Solid::new(24, 20, 10);
    house.house([2.0, 12.0], [3.0, 16.0], 1.0, 5.0, 0.04);
    let mut slope = fields::Solid::new(24, 16, 8);
    slope.patch([3.0, 2.0, 0.0], [18.0, 0.0, 3.0], [0.0, 12.0, 4.0]);
    for solid in [house, slope] {
        for m in solid_meshes(&solid) {
            check(&m, 2.0);
            let mut surface = Surface::new(&m, demands(&m, goal(2.0)), goal(2.0));
            reduce(&mut surface, &m.voxels, &Stop::default()).unwrap();
            let (ours, slow) = (surface.faces().count(), literal(&m, 2.0).len());
            assert!(ours <= slow, "{ours} against {slow}");
        }
    }
}
