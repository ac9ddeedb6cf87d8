//! Triangulations have no T-junctions, and agree with the literal recursion.

use super::{literal::Tri, *};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Every directed edge occurs once; its reverse once too, except along the border of the grid; the whole grid is covered.
fn check_closed(side: usize, faces: &[[u32; 3]], edges: &mut Vec<u64>) {
    edges.clear();
    let at = |i: u32| ((i as usize % side) as i64, (i as usize / side) as i64);
    let mut area = 0;
    for t in faces {
        let [a, b, c] = t.map(at);
        // Rows run downwards, so that counter-clockwise is negative.
        let twice = (b.1 - a.1) * (c.0 - a.0) - (b.0 - a.0) * (c.1 - a.1);
        assert!(twice > 0, "{t:?} is not counter-clockwise");
        area += twice;
        edges.extend((0..3).map(|i| u64::from(t[i]) << 32 | u64::from(t[(i + 1) % 3])));
    }
    assert_eq!(area, 2 * (side as i64 - 1) * (side as i64 - 1));
    edges.sort_unstable();
    let last = side as i64 - 1;
    for (i, &e) in edges.iter().enumerate() {
        assert!(i == 0 || edges[i - 1] != e, "an edge has two faces on one side");
        let (a, b) = ((e >> 32) as u32, e as u32);
        let ((ax, ay), (bx, by)) = (at(a), at(b));
        let border = ax == bx && (ax == 0 || ax == last) || ay == by && (ay == 0 || ay == last);
        let twin = edges.binary_search(&(u64::from(b) << 32 | u64::from(a))).is_ok();
        assert_eq!(twin, !border, "edge {:?} to {:?}", at(a), at(b));
    }
}

#[test]
fn ten_thousand_random_fields_have_no_t_junctions() {
    let mut random = Random(7);
    let (mut workspace, mut edges, mut split) = (Workspace::default(), Vec::new(), 0);
    for round in 0..10_000 {
        let side = [3, 5, 5, 9, 9, 17, 17, 33][random.below(8)];
        let map = random_map(&mut random, side, false);
        let error = if round % 2 == 0 { ErrorMeasure::Edge } else { ErrorMeasure::Exact };
        let hierarchy = Hierarchy::new(map, &Options { error, ..options() }).unwrap();
        let triangulation = if round % 3 == 0 {
            let mut points = Selection::new(side);
            for _ in 0..random.below(side) {
                points.insert(random.below(side), random.below(side));
            }
            hierarchy.triangulate_selection(&points, &mut workspace)
        } else {
            hierarchy.triangulate((random.unit() * random.unit() * 0.2) as f32, &mut workspace)
        };
        assert_eq!(triangulation.cut, 0);
        split += usize::from(triangulation.triangles.len() > 2);
        check_closed(side, &faces(triangulation), &mut edges);
    }
    assert!(split > 8_000, "only {split} fields were split");
}

#[test]
fn the_full_resolution_has_every_triangle() {
    let hierarchy = Hierarchy::new(random_map(&mut Random(1), 129, false), &options()).unwrap();
    let mut workspace = Workspace::default();
    let full = hierarchy.triangulate(-1.0, &mut workspace);
    assert_eq!((full.triangles.len(), full.vertices.len()), (2 * 128 * 128, 129 * 129));
    assert_eq!(full.strips.len(), 1);
    check_closed(129, &faces(full), &mut Vec::new());
}

#[test]
fn dependencies_are_those_of_the_recursion() {
    for k in 1..=5 {
        let (grid, n) = (grid::Grid { k }, 1usize << k);
        let expected = literal::dependencies(n);
        assert_eq!(expected.len(), (n + 1) * (n + 1) - 4);
        for (&(x, y), on) in &expected {
            let parents: BTreeSet<_> = grid.parents(x, y).into_iter().flatten().collect();
            assert_eq!(&parents, on, "({x}, {y}) of {n}");
            let dependants: BTreeSet<_> = grid.dependants(x, y).into_iter().flatten().collect();
            let inverse = expected.iter().filter(|(_, on)| on.contains(&(x, y))).map(|(p, _)| *p).collect();
            assert_eq!(dependants, inverse, "what depends on ({x}, {y}) of {n}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn closing_words_at_a_time_is_closing_point_by_point(k in 1u32..=8, seed: u64, points in 1usize..40) {
        let (n, mut random) = (1usize << k, Random(seed));
        let mut selection = Selection::new(n + 1);
        let mut expected = BTreeSet::new();
        for _ in 0..points {
            let p = (random.below(n + 1), random.below(n + 1));
            selection.insert(p.0, p.1);
            expected.insert(p);
        }
        prop_assert_eq!(selection.count(), expected.len());
        selection.close();
        literal::close(n, &mut expected);
        let found: BTreeSet<_> = selection.points().collect();
        prop_assert_eq!(found, expected);
    }

    /// Triangles, cuts and flags are those of the recursion, background and steps included.
    #[test]
    fn triangulations_are_those_of_the_recursion(k in 1u32..=5, seed: u64, epsilon in 0.0f32..0.05) {
        let (n, mut random) = (1usize << k, Random(seed));
        let map = random_map(&mut random, n + 1, true);
        let options = Options { lambda: 0.05, omega: 20.0, ..Options::for_extent(2.0) };
        let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
        let mut workspace = Workspace::default();
        let triangulation = hierarchy.triangulate(epsilon, &mut workspace).clone();
        let point = |i: usize| (i % (n + 1), i / (n + 1));
        let mut selected: BTreeSet<_> =
            (0..(n + 1) * (n + 1)).filter(|i| hierarchy.error()[*i] > epsilon * epsilon).map(point).collect();
        literal::close(n, &mut selected);
        let (mut expected, mut left_out) = (Vec::new(), 0);
        for t in literal::triangulation(n, &selected) {
            let index = |(x, y): (usize, usize)| (y * (n + 1) + x) as u32;
            if !t.leaves().into_iter().any(|leaf| literal::cut(&map, &options, leaf)) {
                expected.push(turned(t.corners().map(index)));
            } else if t.corners().into_iter().any(|p| literal::position(&map, p).is_some()) {
                left_out += 1;
            }
        }
        let found: Vec<_> = faces(&triangulation).into_iter().map(turned).collect();
        prop_assert_eq!(found, expected);
        prop_assert_eq!(triangulation.cut, left_out);
    }

    #[test]
    fn strips_and_indices_are_the_same_faces(k in 1u32..=6, seed: u64, epsilon in -0.01f32..0.05, holes: bool) {
        let map = random_map(&mut Random(seed), (1 << k) + 1, holes);
        for options in all_options() {
            let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
            let mesh = hierarchy.static_mesh(epsilon);
            let stripped: Vec<_> = mesh.strips.triangles().map(turned).collect();
            let indexed: Vec<_> = mesh.triangles.iter().copied().map(turned).collect();
            prop_assert_eq!(stripped, indexed);
            prop_assert!(mesh.strips.iter().all(|s| s.len() >= 3));
            prop_assert!(holes || mesh.cut > 0 || mesh.strips.len() == 1);
        }
    }

    /// Whatever is selected more is used more: vertices of a coarse mesh are vertices of any finer one.
    #[test]
    fn coarse_vertices_are_fine_vertices(k in 1u32..=6, seed: u64, fine in 0.0f32..0.02, times in 1.0f32..4.0) {
        let map = random_map(&mut Random(seed), (1 << k) + 1, true);
        for options in all_options() {
            let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
            let vertices = |epsilon: f32| hierarchy.static_mesh(epsilon).grid.into_iter().collect::<BTreeSet<_>>();
            let (coarse, fine, full) = (vertices(fine * times), vertices(fine), vertices(-1.0));
            prop_assert!(coarse.is_subset(&fine));
            prop_assert!(fine.is_subset(&full));
        }
    }
}

#[test]
fn the_recursion_itself_covers_the_grid_once() {
    let leaves: Vec<Tri> = literal::roots(8).into_iter().flat_map(Tri::leaves).collect();
    assert_eq!(leaves.len(), 128);
    let faces: Vec<_> = leaves.iter().map(|t| t.corners().map(|(x, y)| (y * 9 + x) as u32)).collect();
    check_closed(9, &faces, &mut Vec::new());
}
