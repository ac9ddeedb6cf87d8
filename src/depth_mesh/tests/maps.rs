//! What is a depth map, and how other images become one.

use super::*;

#[test]
fn images_that_are_no_maps_are_named() {
    let message = |width: u32, height: u32, depth: Vec<f32>| {
        let view = View { height, ..camera(width, true) };
        DepthMap::new(view, depth).unwrap_err().to_string()
    };
    assert!(message(4, 4, vec![1.0; 16]).contains("found 4 × 4"));
    assert!(message(5, 3, vec![1.0; 15]).contains("found 5 × 3"));
    assert!(message(2, 2, vec![1.0; 4]).contains("found 2 × 2"));
    assert!(message(0, 0, Vec::new()).contains("found 0 × 0"));
    assert!(message(u32::MAX, u32::MAX, Vec::new()).contains("2^k+1"));
    assert!(message(16385, 16385, Vec::new()).contains("k from 1 to 13"));
    assert!(message(3, 3, vec![1.0; 8]).contains("need 9 depths, found 8"));
    for bad in [f32::NAN, -1.0, f32::NEG_INFINITY, 1e13] {
        let mut depth = vec![1.0; 9];
        depth[5] = bad;
        let text = message(3, 3, depth);
        assert!(text.contains("pixel (2, 1)"), "{text}");
    }
    let view = View {
        projection: Projection::Perspective { left: 0.0, right: 0.0, bottom: -1.0, top: 1.0 },
        ..camera(3, true)
    };
    assert_eq!(DepthMap::new(view, vec![1.0; 9]), Err(MapError::View));
}

#[test]
fn thresholds_out_of_range_are_named() {
    for (options, name) in [
        (Options { omega: 91.0, ..options() }, "omega"),
        (Options { lambda: -1.0, ..options() }, "lambda"),
        (Options { kappa: f32::NAN, ..options() }, "kappa"),
        (Options { sigma: f32::INFINITY, ..options() }, "sigma"),
    ] {
        let error = Hierarchy::new(random_map(&mut Random(1), 3, false), &options).unwrap_err();
        assert_eq!(error.name, name);
    }
}

#[test]
fn background_alone_gives_an_empty_mesh() {
    for options in all_options() {
        for side in [3, 5, 65] {
            let hierarchy = Hierarchy::new(map(side, true, |_| f32::INFINITY), &options).unwrap();
            for epsilon in [-1.0, 0.0, 1.0, f32::NAN, f32::INFINITY] {
                let mesh = hierarchy.static_mesh(epsilon);
                assert_eq!(mesh, DepthMesh::default());
            }
            let mut workspace = Workspace::default();
            assert!(hierarchy.view_dependent(&camera(64, true), 1.0, &mut workspace).triangles.is_empty());
        }
    }
}

#[test]
fn surfaces_at_the_eye_and_far_away_are_finite() {
    for depths in [[0.0; 3], [0.0, 1e12, 0.0], [1e12, 0.0, 1e-30], [1e12; 3]] {
        for perspective in [true, false] {
            let map = map(9, perspective, |(x, y)| depths[(x * 7 + y * 3) % 3]);
            for options in all_options() {
                for segmentation in [Segmentation::Connectedness, Segmentation::Disparity, Segmentation::Orthogonality]
                {
                    let hierarchy = Hierarchy::new(map.clone(), &Options { segmentation, ..options.clone() }).unwrap();
                    assert!(hierarchy.error().iter().all(|e| e.is_finite()), "{depths:?} {:?}", hierarchy.error());
                    let mesh = hierarchy.static_mesh(0.0);
                    assert!(mesh.normals.iter().flatten().all(|c| c.is_finite()));
                }
            }
        }
    }
}

#[test]
fn other_sizes_take_their_nearest_pixels() {
    let view = View { height: 4, ..camera(6, true) };
    let depth: Vec<f32> = (0..24).map(|i| if i % 5 == 0 { f32::INFINITY } else { 1.0 + i as f32 }).collect();
    let resampled = resample(&view, &depth).unwrap();
    assert_eq!(resampled.map.side(), 9);
    for (i, &source) in resampled.source.iter().enumerate() {
        assert_eq!(resampled.map.depth()[i], depth[source as usize]);
        let [x, y] = [i % 9, i / 9].map(|c| (c as f64 + 0.5) / 9.0);
        let nearest = (x * 6.0) as usize + (y * 4.0) as usize * 6;
        assert_eq!(source as usize, nearest);
    }
    // A pixel looks where its source looks, to within half a source pixel.
    let at = |view: &View, x: f64, y: f64| view.unproject(x, y, 1.0);
    let [new, old] = [at(resampled.map.view(), 4.5, 4.5), at(&view, 3.0, 2.0)];
    assert!((new - old).length() < 1e-12);

    let same = random_map(&mut Random(3), 17, true);
    let kept = resample(same.view(), same.depth()).unwrap();
    assert_eq!(kept.map, same);
    assert_eq!(kept.source, (0..17 * 17).collect::<Vec<u32>>());
    assert!(resample(&camera(0, true), &[]).is_err());
    assert!(resample(&camera(9000, true), &[]).is_err());
    assert_eq!(resample(&camera(1, true), &[1.0]).unwrap().map.side(), 3);
}

#[test]
fn vertices_carry_what_the_pixels_hold() {
    let map = random_map(&mut Random(5), 33, true);
    let hierarchy = Hierarchy::new(map.clone(), &options()).unwrap();
    let mesh = hierarchy.static_mesh(0.01);
    assert!(!mesh.grid.is_empty());
    for (i, &at) in mesh.grid.iter().enumerate() {
        let (x, y) = (at as usize % 33, at as usize / 33);
        let expected = literal::position(&map, (x, y)).unwrap();
        assert!((DVec3::from(mesh.positions[i].map(f64::from)) - expected).length() < 1e-5);
        assert_eq!(mesh.uv[i], [(x as f32 + 0.5) / 33.0, (y as f32 + 0.5) / 33.0]);
        assert!((0.0..=1.0).contains(&mesh.quality[i]));
        let normal = DVec3::from(mesh.normals[i].map(f64::from));
        assert!((normal.length() - 1.0).abs() < 1e-5);
    }
    // Front faces are counter-clockwise from the camera.
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
        let towards = match map.view().projection {
            Projection::Perspective { .. } => map.view().eye - a,
            Projection::Orthographic { .. } => -map.view().forward,
        };
        assert!((b - a).cross(c - a).dot(towards) > 0.0);
    }
}
