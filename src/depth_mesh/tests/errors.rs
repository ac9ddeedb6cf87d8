//! Errors are those of the equations; with `exact` the mesh deviates by the tolerance at most.

use super::*;

#[test]
fn errors_are_those_of_the_equations() {
    let mut random = Random(11);
    for round in 0..60 {
        let side = [3, 5, 9][round % 3];
        let map = random_map(&mut random, side, round % 4 == 0);
        for error in [ErrorMeasure::Edge, ErrorMeasure::Exact] {
            for distance in [Distance::Planar, Distance::Full] {
                let options = Options { error, distance, ..options() };
                let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
                assert!(error == ErrorMeasure::Exact || hierarchy.distance() == distance);
                for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
                    if hierarchy.grid.is_corner(x, y) {
                        assert_eq!(hierarchy.error()[y * side + x], 0.0);
                    } else if let (ErrorMeasure::Exact, Some(expected)) =
                        (error, literal::error(&map, &options, (x, y)))
                    {
                        let tolerance = |d: f64| if d > 0.0 { (d * d) as f32 } else { -1.0 };
                        assert!(hierarchy.exceeds(x, y, tolerance(expected - 2e-5)), "({x}, {y}): {expected}");
                        assert!(!hierarchy.exceeds(x, y, tolerance(expected + 2e-5)), "({x}, {y}): {expected}");
                    } else if let Some(expected) = literal::error(&map, &options, (x, y)) {
                        let found = f64::from(hierarchy.error()[y * side + x]).sqrt();
                        assert!((found - expected).abs() < 2e-5, "({x}, {y}): {found}, {expected}");
                    }
                }
            }
        }
    }
}

#[test]
fn wide_views_use_the_full_distance() {
    let distance = |tangent: f64| {
        let projection = Projection::Perspective { left: -tangent, right: tangent, bottom: -0.1, top: 0.1 };
        let map = DepthMap::new(View { projection, ..camera(3, true) }, vec![1.0; 9]).unwrap();
        Hierarchy::new(map, &options()).unwrap().distance()
    };
    assert_eq!(distance(libm::tan(24.9f64.to_radians())), Distance::Planar);
    assert_eq!(distance(libm::tan(25.1f64.to_radians())), Distance::Full);
}

#[test]
fn the_planar_distance_errs_by_a_tenth_at_most() {
    let map = random_map(&mut Random(21), 33, false);
    let errors = |distance| {
        let hierarchy = Hierarchy::new(map.clone(), &Options { distance, ..options() }).unwrap();
        hierarchy.error().to_vec()
    };
    for (planar, full) in errors(Distance::Planar).into_iter().zip(errors(Distance::Full)) {
        let (planar, full) = (planar.sqrt(), full.sqrt());
        assert!((planar - full).abs() <= 0.094 * full.max(planar) + 1e-5, "{planar} {full}");
    }
}

/// Every grid point under a triangle that is drawn lies within ε of it, with and without background, in both projections.
#[test]
fn exact_errors_bound_the_deviation() {
    let mut random = Random(31);
    let (mut simplified, mut near_bound) = (0, 0);
    for round in 0..300 {
        let side = [5, 9, 17, 33, 65][round % 5];
        let map = random_map(&mut random, side, round % 3 == 0);
        let epsilon = (0.001 + 0.1 * random.unit() * random.unit()) as f32;
        for (distance, propagation) in [
            (Distance::Full, Propagation::Paper),
            (Distance::Full, Propagation::Refine),
            (Distance::Depth, Propagation::Paper),
        ] {
            let options = Options { error: ErrorMeasure::Exact, distance, propagation, ..options() };
            let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
            let mesh = hierarchy.static_mesh(epsilon);
            let found = measure(&map, mesh.triangles.iter().map(|t| t.map(|i| mesh.grid[i as usize])));
            let deviation = if distance == Distance::Depth { found.depth } else { found.distance };
            let epsilon = f64::from(epsilon);
            assert!(deviation <= epsilon * 1.0001 + 1e-6, "{deviation} > {epsilon} ({distance:?}, side {side})");
            simplified += usize::from(mesh.triangles.len() < (side - 1) * (side - 1));
            near_bound += usize::from(deviation > 0.7 * epsilon);
        }
    }
    assert!(simplified > 300, "only {simplified} meshes were simplified");
    assert!(near_bound > 200, "only {near_bound} meshes use their tolerance");
}

/// With Edge errors the deviation may be larger than ε; it stays within the 2k·ε of a chain of displaced edges.
#[test]
fn edge_errors_bound_the_deviation_loosely() {
    let mut random = Random(41);
    for _ in 0..50 {
        let map = random_map(&mut random, 33, false);
        let hierarchy = Hierarchy::new(map.clone(), &Options { distance: Distance::Depth, ..options() }).unwrap();
        let mesh = hierarchy.static_mesh(0.02);
        let found = measure(&map, mesh.triangles.iter().map(|t| t.map(|i| mesh.grid[i as usize])));
        assert!(found.depth <= 10.0 * 0.02, "{found:?}");
    }
}

#[test]
fn exact_errors_need_no_more_than_a_maximum_up_the_hierarchy() {
    let mut random = Random(51);
    for _ in 0..50 {
        let map = random_map(&mut random, 33, false);
        let hierarchy = Hierarchy::new(map, &Options { error: ErrorMeasure::Exact, ..options() }).unwrap();
        let epsilon = 0.02;
        let mut all = Selection::new(33);
        for (x, y) in (0..33).flat_map(|y| (0..33).map(move |x| (x, y))) {
            if !hierarchy.grid.is_corner(x, y) && hierarchy.exceeds(x, y, epsilon * epsilon) {
                all.insert(x, y);
            }
        }
        all.close();
        let mut workspace = Workspace::default();
        hierarchy.triangulate(epsilon, &mut workspace);
        let found = workspace.selection().unwrap();
        assert!(found.points().all(|(x, y)| all.contains(x, y)));
        let mut closed = found.clone();
        closed.close();
        assert_eq!(&closed, found);
    }
}

#[test]
fn measured_planes_deviate_by_nothing_and_bumps_by_their_height() {
    let flat = map(17, false, |(x, y)| if (x, y) == (5, 7) { 2.5 } else { 2.0 });
    let corners = [0, 16 * 17, 16 * 17 + 16];
    let found = measure(&flat, [corners]);
    assert_eq!(found.covered, 17 * 18 / 2);
    assert!((found.depth - 0.5).abs() < 1e-6 && (found.distance - 0.5).abs() < 1e-6, "{found:?}");
    assert_eq!(measure(&flat, [[0, 16 * 17 + 16, 16]]).depth, 0.0);
}

#[test]
fn results_do_not_depend_on_threads() {
    let map = random_map(&mut Random(61), 257, true);
    let run = |threads: usize, options: &Options| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let hierarchy = Hierarchy::new(map.clone(), options).unwrap();
            let mesh = hierarchy.static_mesh(0.003);
            (hierarchy, mesh)
        })
    };
    for options in all_options() {
        let (one, four) = (run(1, &options), run(4, &options));
        assert!(one == four, "{options:?}");
    }
}
