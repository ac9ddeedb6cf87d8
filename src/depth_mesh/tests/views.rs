//! Triangulations for a novel view.

use super::*;
use std::collections::BTreeSet;

fn bumps(side: usize) -> DepthMap {
    map(side, true, |(x, y)| {
        let (u, v) = (x as f32 / side as f32, y as f32 / side as f32);
        2.0 + 0.1 * libm::sinf(20.0 * u) * libm::cosf(17.0 * v) + 0.005 * libm::sinf(200.0 * u + 150.0 * v)
    })
}

/// A view from `distance` metres before the middle of the map's surface.
fn view(distance: f64, width: u32) -> View {
    let target = DVec3::new(0.5, -0.25, -1.0);
    View::look_at(target + DVec3::Z * distance, target, DVec3::Y, 0.8, width, width, 1e-3, 1e4)
}

#[test]
fn far_views_need_far_fewer_triangles() {
    for options in all_options() {
        let hierarchy = Hierarchy::new(bumps(257), &options).unwrap();
        let mut workspace = Workspace::default();
        let mut count = |distance| hierarchy.view_dependent(&view(distance, 512), 1.0, &mut workspace).triangles.len();
        let counts = [2.0, 8.0, 32.0, 128.0].map(&mut count);
        assert!(counts.windows(2).all(|c| c[1] < c[0]), "{counts:?}");
        assert!(counts[2] * 10 < counts[0] && counts[3] <= 200, "{counts:?}");
    }
}

/// Whatever a test of each point selects inside the frustum is selected; what is selected beyond it, something depends on.
#[test]
fn no_point_is_missed() {
    let mut random = Random(101);
    for round in 0..40 {
        let side = [17, 33, 65, 129][round % 4];
        let map = random_map(&mut random, side, round % 2 == 0);
        let hierarchy = Hierarchy::new(map.clone(), &options()).unwrap();
        let place = DVec3::new(random.unit(), random.unit() - 0.75, -random.unit() * 2.0);
        let target = DVec3::new(random.unit(), random.unit() - 0.75, -1.2);
        let novel = View::look_at(place, target, DVec3::Y, 0.4 + random.unit(), 640, 480, 0.05, 3.0);
        let tau = (0.5 + 4.0 * random.unit()) as f32;
        let mut workspace = Workspace::default();
        hierarchy.view_dependent(&novel, tau, &mut workspace);
        let selected: BTreeSet<_> = workspace.selection().unwrap().points().collect();
        let f = 480.0 / (2.0 * libm::tan(0.5 * fov(&novel)));
        let mut literal = BTreeSet::new();
        let mut inside = BTreeSet::new();
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let Some(p) = literal::position(&map, (x, y)) else { continue };
            let d = f64::from(hierarchy.error()[y * side + x]).sqrt();
            let pixels = d * f / (p - novel.eye).length();
            // Points at the threshold may fall either way.
            if pixels > f64::from(tau) * 0.9999 {
                literal.insert((x, y));
            }
            let (px, py, z) =
                if (p - novel.eye).dot(novel.forward) > 0.0 { novel.project(p) } else { (-1.0, -1.0, 0.0) };
            let seen = (0.0..640.0).contains(&px) && (0.0..480.0).contains(&py) && (0.05..3.0).contains(&z);
            if seen && pixels > f64::from(tau) * 1.0001 {
                inside.insert((x, y));
            }
        }
        literal::close(side - 1, &mut inside);
        assert!(inside.is_subset(&selected), "a point in view is missed");
        // Background beside surfaces is judged by the sphere around its node, so look at maps without any.
        if round % 2 == 1 {
            literal::close(side - 1, &mut literal);
            assert!(selected.is_subset(&literal), "a point is selected that nothing needs");
        }
    }
}

fn fov(view: &View) -> f64 {
    match view.projection {
        Projection::Perspective { top, .. } => 2.0 * libm::atan(top),
        Projection::Orthographic { .. } => 0.0,
    }
}

/// What is not drawn is outside the frustum: every triangle of the whole triangulation that the view could see is there.
#[test]
fn culled_triangles_are_outside() {
    let mut random = Random(111);
    let mut culled = 0;
    for round in 0..40 {
        let map = random_map(&mut random, 65, round % 2 == 0);
        for options in all_options() {
            let hierarchy = Hierarchy::new(map.clone(), &options).unwrap();
            let place = DVec3::new(random.unit(), random.unit() - 0.75, 1.0 - random.unit() * 1.5);
            let target = DVec3::new(random.unit(), random.unit() - 0.75, -1.2);
            let mut novel = View::look_at(place, target, DVec3::Y, 0.3, 200, 200, 0.05, 5.0);
            if round % 4 < 2 {
                novel.projection = Projection::Orthographic { left: -0.2, right: 0.3, bottom: -0.2, top: 0.2 };
            }
            let mut workspace = Workspace::default();
            let drawn: BTreeSet<_> =
                faces(hierarchy.view_dependent(&novel, 1.0, &mut workspace)).into_iter().map(turned).collect();
            let selection = workspace.selection().unwrap().clone();
            let whole = hierarchy.triangulate_selection(&selection, &mut workspace);
            let whole: BTreeSet<_> = faces(whole).into_iter().map(turned).collect();
            assert!(drawn.is_subset(&whole));
            for t in whole.difference(&drawn) {
                culled += 1;
                for i in t {
                    let (x, y) = (*i as usize % 65, *i as usize / 65);
                    let p = literal::position(&map, (x, y)).unwrap();
                    let z = (p - novel.eye).dot(novel.forward);
                    let perspective = matches!(novel.projection, Projection::Perspective { .. });
                    let (px, py, _) = if z > 0.0 || !perspective { novel.project(p) } else { (-1.0, -1.0, z) };
                    let seen = (0.0..=200.0).contains(&px) && (0.0..=200.0).contains(&py) && (0.05..=5.0).contains(&z);
                    assert!(!seen, "a culled triangle has a corner in view");
                }
            }
        }
    }
    assert!(culled > 1_000, "only {culled} triangles were culled");
}

/// The projected deviation of what is drawn stays within the tolerance with exact errors.
#[test]
fn exact_errors_bound_the_projected_deviation() {
    let map = bumps(129);
    let hierarchy = Hierarchy::new(map.clone(), &Options { error: ErrorMeasure::Exact, ..options() }).unwrap();
    let mut workspace = Workspace::default();
    for distance in [0.5, 1.0, 4.0, 16.0] {
        let novel = view(distance, 512);
        let drawn = faces(hierarchy.view_dependent(&novel, 2.0, &mut workspace));
        let f = 512.0 / (2.0 * libm::tan(0.4));
        for t in drawn {
            let found = measure(&map, [t]);
            let nearest = t.map(|i| literal::position(&map, (i as usize % 129, i as usize / 129)).unwrap());
            let nearest = nearest.map(|p| (p - novel.eye).length()).into_iter().fold(f64::MAX, f64::min);
            assert!(found.distance * f / nearest <= 2.0 * 1.01, "{distance}");
        }
    }
}

#[test]
fn a_workspace_serves_maps_of_any_size() {
    let mut workspace = Workspace::default();
    for side in [129, 5, 65, 129] {
        let hierarchy = Hierarchy::new(bumps(side), &options()).unwrap();
        let again = hierarchy.view_dependent(&view(3.0, 256), 0.5, &mut workspace).clone();
        let fresh = hierarchy.view_dependent(&view(3.0, 256), 0.5, &mut Workspace::default()).clone();
        assert_eq!(again, fresh);
        let again = hierarchy.triangulate(0.01, &mut workspace).clone();
        assert_eq!(&again, hierarchy.triangulate(0.01, &mut Workspace::default()));
    }
}

#[test]
fn without_a_tolerance_all_errors_show() {
    let hierarchy = Hierarchy::new(bumps(65), &options()).unwrap();
    let mut workspace = Workspace::default();
    let wide = view(3.0, 256);
    let all = hierarchy.view_dependent(&wide, 0.0, &mut workspace).triangles.len();
    assert_eq!(all, hierarchy.triangulate(0.0, &mut workspace).triangles.len());
}
