//! What must hold for meshes over voxel fields, on random and on structured ones.

use super::{
    Across, Field, Frustum, Side, Slices, VoxelMesh,
    cover_mesh::{CoverError, cover_meshes},
    touch::{Toucher, centre, front_area, normal, point},
};
use crate::{math::Stop, sample_fields as fields, voxel};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

fn mesh(slices: &Slices, fields: &[&Field]) -> Vec<(String, VoxelMesh)> {
    cover_meshes(slices, fields, &Stop::default()).unwrap()
}

/// Everything that the meshing operator promises for one mesh.
fn check_mesh(name: &str, m: &VoxelMesh) {
    m.validate().unwrap_or_else(|e| panic!("{name}: {e:?}"));
    let mut named = vec![false; m.voxels.len()];
    let mut directed = BTreeSet::new();
    let mut undirected: BTreeMap<_, u32> = BTreeMap::new();
    let mut seen = BTreeSet::new();
    for (f, face) in m.faces.iter().enumerate() {
        let corners = face.map(|v| point(m.vertices[v as usize]));
        assert_ne!(normal(corners[0], corners[1], corners[2]), [0.0; 3], "{name}: face {f} is degenerate");
        // Only walls of receding surfaces do, and none of them by more than a pixel a layer.
        let n = normal(corners[0], corners[1], corners[2]);
        let recedes = corners.iter().any(|c| c[2] != corners[0][2]) && n[2] <= n[0].abs() + n[1].abs();
        let front = front_area(corners[0], corners[1], corners[2]) >= 0.0;
        assert!(front || recedes, "{name}: face {f} shows its back");
        let toucher = Toucher::new(corners, 2.0);
        for v in m.covered_by(f) {
            named[*v as usize] = true;
            assert!(toucher.touches(&centre(&m.voxels[*v as usize])), "{name}: face {f} names {v} but is apart");
        }
        let mut key = face.map(|v| m.vertices[v as usize]);
        key.sort_unstable();
        assert!(seen.insert(key), "{name}: face {f} is there twice");
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            assert!(directed.insert((a, b)), "{name}: edge {a}-{b} runs twice in one direction");
            *undirected.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    assert!(undirected.values().all(|n| *n <= 2));
    assert!(named.iter().all(|n| *n), "{name}: a voxel without a face");
    // One fan per vertex: as many boundary edges as leave it must enter it, at most one.
    let mut fans = vec![(0, 0); m.vertices.len()];
    for (a, b) in &directed {
        fans[*a as usize].0 += 1;
        fans[*b as usize].1 += 1;
    }
    let mut open = vec![0; m.vertices.len()];
    directed.iter().filter(|(a, b)| !directed.contains(&(*b, *a))).for_each(|(a, _)| open[*a as usize] += 1);
    assert!(open.iter().all(|n| *n <= 1), "{name}: bow tie");
}

/// Pixels that faces in the layers cover as seen from the centre, by the centres of quarter squares grown to their pixels.
fn seen_pixels(meshes: &[(String, VoxelMesh)]) -> BTreeSet<(i32, i32)> {
    let mut pixels = BTreeSet::new();
    for (_, m) in meshes {
        for face in m.faces.iter() {
            let t = face.map(|v| point(m.vertices[v as usize]));
            let low = [0, 1].map(|k| t.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min) as i32);
            let high = [0, 1].map(|k| t.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) as i32);
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let p = [f64::from(x) + 0.4, f64::from(y) + 0.3, 0.0];
                    if (0..3).all(|i| front_area(t[i], t[(i + 1) % 3], p) >= 0.0) {
                        pixels.insert((x.div_euclid(4), y.div_euclid(4)));
                    }
                }
            }
        }
    }
    pixels
}

fn check(slices: &Slices, field: &Field) -> Vec<(String, VoxelMesh)> {
    let meshes = mesh(slices, &[field]);
    for (name, m) in &meshes {
        check_mesh(name, m);
        let first = m.voxels[0];
        assert_eq!(*name, format!("f{}-l{:05}-y{:05}-x{:05}", m.frustum, first.layer, first.y, first.x));
    }
    let mut all: Vec<_> = meshes.iter().flat_map(|(_, m)| m.voxels.iter().copied()).collect();
    all.sort_by_key(|v| (v.layer, v.y, v.x));
    assert_eq!(all, field.voxels.to_vec(), "every voxel belongs to one mesh");
    let expected: BTreeSet<_> = field.voxels.iter().map(|v| (i32::from(v.x), i32::from(v.y))).collect();
    assert_eq!(seen_pixels(&meshes), expected, "the centre sees the field's pixels");
    meshes
}

fn random_field(size: u32, layers: u32, filled: &[bool]) -> Field {
    let mut voxels = Vec::new();
    for l in 0..layers {
        for y in 0..size {
            for x in 0..size {
                if filled[((l * size + y) * size + x) as usize] {
                    voxels.push(fields::voxel(x, y, l));
                }
            }
        }
    }
    Field { frustum: 0, voxels: voxels.into(), ..Field::default() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn random_fields_are_covered(
        filled in prop::collection::vec(prop::bool::weighted(0.5), 7 * 7 * 4),
        density in 0u32..4,
    ) {
        // Thinned to several densities, because dense and sparse fields fail differently.
        let mut random = fields::Random(u64::from(density) + 77);
        let filled: Vec<bool> = filled.iter().map(|f| if *f { random.below(4) >= density } else { density == 0 && random.below(2) == 0 }).collect();
        let field = random_field(7, 4, &filled);
        if !field.voxels.is_empty() {
            check(&fields::slices([7, 7], 4), &field);
        }
    }
}

#[test]
fn structured_fields_are_covered() {
    let mut slope = fields::Solid::new(40, 30, 12);
    slope.patch([2.0, 2.0, 0.0], [35.0, 0.0, 6.0], [0.0, 25.0, 5.0]);
    let mut house = fields::Solid::new(40, 40, 12);
    house.house([8.0, 25.0], [5.0, 30.0], 2.0, 7.0, 0.04);
    for solid in [slope, house, fields::skyline(150, 12, 8, 3)] {
        check(&fields::slices(solid.size, solid.layers), &solid.field());
    }
}

#[test]
fn a_continuous_surface_is_one_mesh() {
    let mut slope = fields::Solid::new(40, 30, 12);
    slope.patch([2.0, 2.0, 0.0], [35.0, 0.0, 11.0], [0.0, 25.0, 0.0]);
    assert_eq!(check(&fields::slices([40, 30], 12), &slope.field()).len(), 1);
}

#[test]
fn nothing_is_built_towards_what_is_hidden() {
    // A ridge of three voxels in depth: with its lower side hidden it keeps the other walls only.
    let mut voxels: Vec<_> = (0..3).flat_map(|l| (2..6).map(move |x| fields::voxel(x, 3, l))).collect();
    let slices = fields::slices([8, 8], 3);
    let count = |voxels: &[voxel::Voxel]| {
        let field = Field { frustum: 0, voxels: voxels.iter().copied().collect(), ..Field::default() };
        let meshes = mesh(&slices, &[&field]);
        meshes.iter().for_each(|(name, m)| check_mesh(name, m));
        meshes.iter().map(|(_, m)| m.faces.len()).sum::<usize>()
    };
    let all = count(&voxels);
    voxels.iter_mut().for_each(|v| v.inside = 1 << Side::Bottom as u8);
    // Two layers of 4 walls and 3 between them, two triangles each.
    assert_eq!(all - count(&voxels), 2 * 2 * (4 + 3));
}

#[test]
fn strips_of_a_receding_surface_hang_together() {
    // Two rows, the farther one a row lower: from above, a roof that draws back.
    let rows = [(3, 0..3), (4, 2..5)];
    let voxels = |x: u32| rows.clone().into_iter().flat_map(move |(y, l)| l.map(move |l| fields::voxel(x, y, l)));
    let mut all: Vec<_> = (2..6).flat_map(voxels).collect();
    all.sort_by_key(|v| (v.layer, v.y, v.x));
    let field = Field { frustum: 0, voxels: all.into(), ..Field::default() };
    let meshes = check(&fields::slices([8, 8], 5), &field);
    let m = &meshes[0].1;
    let top = |y: i32, z: i32| m.vertices.iter().position(|v| *v == [9, y, z]).unwrap() as u32;
    let (near, far) = (top(13, 2), top(17, 3));
    assert!(m.faces.iter().any(|f| f.contains(&near) && f.contains(&far)), "no face joins the strips");
}

#[test]
fn an_unchanged_mesh_keeps_name_and_bytes() {
    let build = |other: u32| {
        let mut solid = fields::Solid::new(60, 30, 12);
        solid.house([30.0, 50.0], [5.0, 25.0], 6.0, 3.0, 0.01);
        solid.patch([2.0, 2.0, f64::from(other)], [15.0, 0.0, 0.0], [0.0, 20.0, 0.0]);
        mesh(&fields::slices([60, 30], 12), &[&solid.field()])
    };
    let (a, b) = (build(1), build(3));
    let kept: Vec<_> = a.iter().filter(|m| b.contains(m)).collect();
    assert_eq!((a.len(), b.len(), kept.len()), (2, 2, 1));
}

/// Two frusta side by side; the right one's image may be turned so that another of its sides lies on the seam.
fn pair(size: u32, layers: u32, side: Side, reversed: bool) -> Slices {
    let mut slices = fields::slices([size; 2], layers);
    let mut other: Frustum = slices.frusta[0].clone();
    slices.frusta[0].across[Side::Right as usize] = Some(Across { frustum: 1, side, reversed });
    other.across[side as usize] = Some(Across { frustum: 0, side: Side::Right, reversed });
    slices.frusta.push(other);
    slices
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]
    #[test]
    fn seams_have_the_same_vertices_on_both_sides(
        filled in prop::collection::vec(prop::bool::weighted(0.6), 2 * 5 * 5 * 3),
        side in prop::sample::select(vec![Side::Left, Side::Right, Side::Top, Side::Bottom]),
        reversed in any::<bool>(),
    ) {
        let slices = pair(5, 3, side, reversed);
        let a = random_field(5, 3, &filled[..75]);
        let mut b = random_field(5, 3, &filled[75..]);
        b.frustum = 1;
        let meshes = mesh(&slices, &[&b, &a]);
        let mut edges = [BTreeSet::new(), BTreeSet::new()];
        for (name, m) in &meshes {
            check_mesh(name, m);
            let on_seam = |v: [i32; 3]| -> Option<(i32, i32)> {
                let side = if m.frustum == 0 { Side::Right } else { side };
                let along = match side {
                    Side::Left => (v[0] == 0).then_some(v[1]),
                    Side::Right => (v[0] == 20).then_some(v[1]),
                    Side::Top => (v[1] == 0).then_some(v[0]),
                    Side::Bottom => (v[1] == 20).then_some(v[0]),
                }?;
                Some((if m.frustum == 1 && reversed { 20 - along } else { along }, v[2]))
            };
            for (v, flags) in m.vertices.iter().zip(m.flags.iter()) {
                prop_assert_eq!(on_seam(*v).is_some(), flags & 1 == 1);
            }
            for f in m.faces.iter() {
                for i in 0..3 {
                    let ends = (f[i], f[(i + 1) % 3]);
                    if let Some((p, q)) = on_seam(m.vertices[ends.0 as usize]).zip(on_seam(m.vertices[ends.1 as usize])) {
                        edges[m.frustum as usize].insert((p.min(q), p.max(q)));
                    }
                }
            }
        }
        prop_assert_eq!(&edges[0], &edges[1]);
    }
}

#[test]
fn wrong_fields_are_refused() {
    let slices = fields::slices([4, 4], 2);
    let field = |frustum: u32, voxels: Vec<voxel::Voxel>| Field { frustum, voxels: voxels.into(), ..Field::default() };
    let at = fields::voxel;
    let run = |fields: &[&Field]| cover_meshes(&slices, fields, &Stop::default()).unwrap_err();
    assert!(matches!(run(&[&field(1, vec![])]), CoverError::Frustum { frustum: 1, count: 1 }));
    assert!(matches!(run(&[&field(0, vec![]), &field(0, vec![])]), CoverError::Twice(0)));
    assert!(matches!(run(&[&field(0, vec![at(4, 0, 0)])]), CoverError::Outside { x: 4, .. }));
    assert!(matches!(run(&[&field(0, vec![at(1, 0, 0), at(0, 0, 0)])]), CoverError::Unsorted(0)));
    let stop = Stop::default();
    stop.set();
    let some = field(0, vec![at(0, 0, 0)]);
    assert!(matches!(cover_meshes(&slices, &[&some], &stop), Err(CoverError::Stopped(_))));
}
