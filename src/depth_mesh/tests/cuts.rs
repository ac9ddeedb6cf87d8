//! Rubber sheets are cut, surfaces are not.

use super::*;
use std::collections::BTreeSet;

const KINDS: [Segmentation; 3] = [Segmentation::Connectedness, Segmentation::Disparity, Segmentation::Orthogonality];

fn full(map: &DepthMap, options: &Options) -> DepthMesh {
    Hierarchy::new(map.clone(), options).unwrap().static_mesh(-1.0)
}

/// Every triangle across a step is cut, and no other one.
#[test]
fn steps_are_cut() {
    for perspective in [true, false] {
        let step = map(33, perspective, |(x, _)| if x < 14 { 2.0 } else { 4.0 });
        for segmentation in KINDS {
            let mesh = full(&step, &Options { segmentation, ..Options::for_extent(2.0) });
            assert_eq!(mesh.cut, 2 * 32, "{segmentation:?}, perspective: {perspective}");
            for t in &mesh.triangles {
                let left = t.iter().filter(|i| mesh.grid[**i as usize] % 33 < 14).count();
                assert!(left == 0 || left == 3);
            }
        }
        let mesh = full(&step, &options());
        assert_eq!(mesh.cut, 0);
    }
}

/// A steep but continuous slope stays, whatever depth its triangles span.
#[test]
fn slopes_stay() {
    for perspective in [true, false] {
        let slope = map(33, perspective, |(x, _)| 2.0 + 0.06 * x as f32);
        for segmentation in KINDS {
            let mesh = full(&slope, &Options { segmentation, lambda: 0.01, ..Options::for_extent(2.0) });
            assert_eq!(mesh.cut, 0, "{segmentation:?}, perspective: {perspective}");
        }
    }
}

/// A sphere before a wall: the outline is cut all around, nothing else is.
#[test]
fn spheres_keep_their_inside() {
    let side = 129usize;
    let middle = (side / 2) as f32;
    let from_centre = |x: usize, y: usize| {
        let (dx, dy) = ((x as f32 - middle) / middle, (y as f32 - middle) / middle);
        dx * dx + dy * dy
    };
    for perspective in [true, false] {
        let sphere = map(side, perspective, |(x, y)| {
            let r = from_centre(x, y) / (0.6 * 0.6);
            if r < 1.0 { 3.0 - 0.6 * (1.0 - r).sqrt() } else { 4.0 }
        });
        for segmentation in KINDS {
            let mesh = full(&sphere, &Options { segmentation, ..Options::for_extent(2.0) });
            let inside = |t: &[u32; 3]| {
                let at = |i: &u32| mesh.grid[*i as usize] as usize;
                t.iter().filter(|i| from_centre(at(i) % side, at(i) / side) < 0.36).count()
            };
            let sheets = mesh.triangles.iter().filter(|t| !matches!(inside(t), 0 | 3)).count();
            // Where the slope of the sphere happens to lead to the wall, connectedness takes both for one surface.
            let most = if segmentation == Segmentation::Connectedness { mesh.cut / 10 } else { 0 };
            assert!(sheets <= most, "{segmentation:?}: {sheets} sheets are left, {} are cut", mesh.cut);
            // The outline of 2π · 0.6 · 64 pixels crosses two to four triangles in each.
            let outline = std::f64::consts::TAU * 0.6 * f64::from(middle);
            let cut = mesh.cut as f64 / outline;
            assert!((2.0..4.5).contains(&cut), "{segmentation:?}: {} cut", mesh.cut);
        }
    }
}

#[test]
fn small_ranges_are_not_cut() {
    let rough = map(257, true, |(x, y)| 2.0 + if (x * 7 + y * 13) % 5 == 0 { 0.09 } else { 0.0 });
    for segmentation in KINDS {
        let absolute = Options { segmentation, ..Options::for_extent(2.0) };
        assert_eq!(full(&rough, &absolute).cut, 0);
        assert!(full(&rough, &Options { lambda: 0.08, ..absolute.clone() }).cut > 0, "{segmentation:?}");
        // 0.09 of 2 to 2.09 m is a little more than 4.3 %.
        let relative = Options { depth_range: DepthRange::Relative, ..absolute };
        assert!(full(&rough, &Options { lambda: 0.04, ..relative.clone() }).cut > 0);
        assert_eq!(full(&rough, &Options { lambda: 0.046, ..relative }).cut, 0);
    }
}

#[test]
fn background_is_in_no_face() {
    let mut random = Random(71);
    for round in 0..200 {
        let side = [3, 5, 9, 17, 33][round % 5];
        let map = random_map(&mut random, side, true);
        for options in all_options() {
            let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
            assert!(hierarchy.error().iter().all(|e| e.is_finite()));
            for epsilon in [-1.0, 0.0, 0.01, 10.0] {
                let mesh = hierarchy.static_mesh(epsilon);
                for &at in &mesh.grid {
                    assert!(map.depth()[at as usize].is_finite());
                }
                // No triangle spans a hole either.
                let triangles = mesh.triangles.iter().map(|t| t.map(|i| mesh.grid[i as usize]));
                let covered: usize = literal_cover(&map, triangles);
                assert_eq!(covered, 0, "{options:?} at {epsilon}");
            }
        }
    }
}

/// Background points under triangles.
fn literal_cover(map: &DepthMap, triangles: impl Iterator<Item = [u32; 3]>) -> usize {
    let side = map.side();
    let mut count = 0;
    for t in triangles {
        let [a, b, c] = t.map(|i| (i as usize % side, i as usize / side));
        let long = |p: (usize, usize), q: (usize, usize)| p.0.abs_diff(q.0).pow(2) + p.1.abs_diff(q.1).pow(2);
        let [l, apex, r] = [[b, a, c], [c, b, a], [a, c, b]].into_iter().max_by_key(|t| long(t[0], t[2])).unwrap();
        let t = literal::Tri { l, apex, r };
        let xs = [a.0, b.0, c.0];
        let ys = [a.1, b.1, c.1];
        for y in *ys.iter().min().unwrap()..=*ys.iter().max().unwrap() {
            for x in *xs.iter().min().unwrap()..=*xs.iter().max().unwrap() {
                count += usize::from(t.covers((x, y)) && map.depth()[y * side + x] == f32::INFINITY);
            }
        }
    }
    count
}

/// An outline recedes by the tolerance at most, so a small one keeps all of it.
#[test]
fn small_tolerances_keep_the_outline() {
    let mut random = Random(81);
    for _ in 0..30 {
        let map = random_map(&mut random, 33, true);
        for options in all_options() {
            let hierarchy =
                Hierarchy::new(map.clone(), &Options { segmentation: Segmentation::None, ..options }).unwrap();
            let area = |mesh: &DepthMesh| {
                let doubled = |t: &[u32; 3]| {
                    let [a, b, c] = t.map(|i| mesh.grid[i as usize] as i64).map(|i| (i % 33, i / 33));
                    ((b.1 - a.1) * (c.0 - a.0) - (b.0 - a.0) * (c.1 - a.1)).unsigned_abs()
                };
                mesh.triangles.iter().map(doubled).sum::<u64>()
            };
            // A pixel is at least 0.04 m wide there.
            let (some, all) = (hierarchy.static_mesh(0.02), hierarchy.static_mesh(-1.0));
            assert_eq!(area(&some), area(&all));
        }
    }
}

/// With `refine` whatever is not cut at the full resolution is drawn, at any tolerance.
#[test]
fn refined_meshes_lose_only_leaves() {
    let mut random = Random(91);
    let mut lost = 0;
    for _ in 0..60 {
        let map = random_map(&mut random, 33, true);
        for error in [ErrorMeasure::Edge, ErrorMeasure::Exact] {
            let options = Options {
                error,
                lambda: 0.1,
                omega: 30.0,
                propagation: Propagation::Refine,
                ..Options::for_extent(2.0)
            };
            let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
            for epsilon in [0.001, 0.02, 1.0, 100.0] {
                let area = |hierarchy: &Hierarchy, epsilon: f32| {
                    let mesh = hierarchy.static_mesh(epsilon);
                    let doubled = |t: &[u32; 3]| {
                        let [a, b, c] = t.map(|i| mesh.grid[i as usize] as i64).map(|i| (i % 33, i / 33));
                        ((b.1 - a.1) * (c.0 - a.0) - (b.0 - a.0) * (c.1 - a.1)).unsigned_abs()
                    };
                    mesh.triangles.iter().map(doubled).sum::<u64>()
                };
                let full = area(&hierarchy, -1.0);
                assert_eq!(area(&hierarchy, epsilon), full);
                let paper = Options { propagation: Propagation::Paper, ..options.clone() };
                let paper = Hierarchy::new(map.clone(), &paper).unwrap();
                lost += usize::from(area(&paper, epsilon) < full);
            }
        }
    }
    assert!(lost > 50, "the paper's propagation lost something in only {lost} meshes");
}

/// A cut triangle cuts all that stand for it.
#[test]
fn coarse_triangles_over_a_cut_are_left_out() {
    let step = map(17, false, |(x, y)| if x >= 9 && y < 8 { 2.0 } else { 6.0 });
    let hierarchy = Hierarchy::new(step, &Options::for_extent(2.0)).unwrap();
    let (coarse, full) = (hierarchy.static_mesh(10.0), hierarchy.static_mesh(-1.0));
    assert_eq!((coarse.triangles.len(), coarse.cut), (1, 1));
    let corners: BTreeSet<_> = coarse.grid.into_iter().collect();
    assert_eq!(corners, BTreeSet::from([0, 16 * 17, 16 * 17 + 16]));
    assert!(full.cut > 0 && full.triangles.len() + full.cut == 2 * 16 * 16);
}

#[test]
fn normals_and_quality_do_not_reach_across_steps() {
    let step = map(33, false, |(x, _)| if x < 14 { 2.0 } else { 2.6 });
    let hierarchy = Hierarchy::new(step, &Options::for_extent(2.0)).unwrap();
    for x in 0..33 {
        assert!((hierarchy.camera_normal(x, 20) - glam::Vec3::NEG_Z).length() < 1e-5, "column {x}");
        assert!((hierarchy.quality(x, 20) - 1.0).abs() < 1e-5);
    }
    let hole = map(33, false, |(x, y)| if y == 5 || x > 20 { f32::INFINITY } else { 2.0 + 0.02 * x as f32 });
    let hierarchy = Hierarchy::new(hole, &Options::for_extent(2.0)).unwrap();
    let pixel = 2.2 / 33.0;
    let expected = glam::Vec3::new(0.02, 0.0, -pixel).normalize();
    for (x, y) in [(0, 0), (10, 4), (10, 6), (20, 20), (20, 4), (0, 32)] {
        assert!((hierarchy.camera_normal(x, y) - expected).length() < 1e-3, "({x}, {y})");
        assert!((hierarchy.quality(x, y) + expected.z).abs() < 1e-3);
    }
    assert!(hierarchy.camera_position(25, 0).is_none());
}
