use super::{cube, map, scene, sphere};
use crate::{
    math::{Sequence, Stop},
    raster::{Cpu, Geometry, NOTHING, Options, nearest},
    relief::{
        Candidate, DepthBits, Field, Hit, Ray, Search, Strategy, Trace, coverage, coverage::Mask, resolve, trace,
    },
    scene::Scene,
    view::{Region, directions::look_along},
};
use glam::{DVec3, Vec3};

/// Small steps and halvings, through walls: the literal version of the search by a pyramid.
fn march(field: &Field, ray: &Ray, wall: f32) -> Option<Hit> {
    let (t0, t1) = field.clip(ray, f32::NEG_INFINITY, f32::INFINITY)?;
    let lateral = ray.direction.truncate().length();
    let steps = (((t1 - t0) * lateral * 16.0) as u32).max(64);
    let at = |t: f32| {
        let p = ray.origin + ray.direction * t;
        let height = field.height(p.x, p.y, wall);
        (p.z - height, height)
    };
    let step = (t1 - t0) / steps as f32;
    let mut before = at(t0);
    for i in 1..=steps {
        let t = t0 + step * i as f32;
        let now = at(t);
        if before.0 < 0.0 && now.0 >= 0.0 {
            let (mut above, mut under) = (t - step, t);
            for _ in 0..24 {
                let middle = (above + under) * 0.5;
                if at(middle).0 >= 0.0 { under = middle } else { above = middle }
            }
            if (at(above).1 - at(under).1).abs() <= wall {
                return Some(Hit { t: under, point: ray.origin + ray.direction * under });
            }
        }
        before = now;
    }
    None
}

fn bumps() -> Scene {
    // A heap of boxes of different heights, so that there are walls, overhangs and slopes.
    let mut out = cube();
    for (i, (x, z)) in [(-0.6, 0.4), (0.5, 0.5), (0.2, -0.7), (-0.4, -0.5)].into_iter().enumerate() {
        let mut object = if i % 2 == 0 { sphere(3) } else { cube() }.objects.remove(0);
        object.name = format!("bump {i}");
        object.transform = glam::Mat4::from_scale_rotation_translation(
            Vec3::splat(0.25 + 0.1 * i as f32),
            glam::Quat::from_rotation_y(0.3 * i as f32),
            Vec3::new(x, 1.1, z),
        );
        out.objects.push(object);
    }
    out
}

#[test]
fn the_pyramid_finds_what_small_steps_find() {
    let scene = bumps();
    let sphere = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
    let sequence = Sequence::<3>::new(11);
    let (mut hits, mut differ, mut far) = (0, 0, 0);
    for m in 0..3 {
        let map = map(&scene, sphere.eye(sequence.point(m)), 48, 2, DepthBits::Sixteen);
        let field = Field::new(&map, 4.0);
        for v in 0..4 {
            let view =
                look_along(scene.points().into_iter(), sphere.eye(sequence.point(50 + 7 * m + v)), 40, 0.0).unwrap();
            if view.forward.dot(map.view.forward) < 0.2 {
                continue;
            }
            for i in 0..40 * 40 {
                let origin = view.unproject(f64::from(i % 40) + 0.5, f64::from(i / 40) + 0.5, 0.0);
                let ray = field.ray(origin, view.forward);
                let quick = trace(&field, &ray, f32::NEG_INFINITY, f32::INFINITY, &Trace::default());
                match (quick, march(&field, &ray, 4.0)) {
                    (Some(a), Some(b)) => {
                        hits += 1;
                        // At the rims of sheets the two end differently, within a texel.
                        far += usize::from(a.point.distance(b.point) > 0.5);
                    }
                    (None, None) => {}
                    _ => differ += 1,
                }
            }
        }
    }
    assert!(hits > 2000, "{hits}");
    // Rims: the literal search ends sheets by another rule, at the nearest texel's depth.
    assert!(differ * 25 < hits && far * 25 < hits, "{differ} and {far} of {hits} differ");
}

#[test]
fn cells_cover_what_rays_cover() {
    let scene = bumps();
    for (a, b) in [
        (DVec3::Y, DVec3::new(0.5, 0.8, 0.3)),
        (DVec3::new(1.0, 1.0, 0.2), DVec3::new(0.2, 1.0, -0.4)),
        (DVec3::Y, DVec3::Y),
    ] {
        let map = map(&scene, a.normalize(), 64, 2, DepthBits::Eight);
        let field = Field::new(&map, 4.0);
        let view = look_along(scene.points().into_iter(), b.normalize(), 96, 0.0).unwrap();
        let stop = Stop::default();
        let cells = coverage::of_map(&field, &view, &Trace::default(), &stop).unwrap();
        let rays = Mask::new(96 * 96, |i| {
            let origin = view.unproject((i % 96) as f64 + 0.5, (i / 96) as f64 + 0.5, 0.0);
            trace(&field, &field.ray(origin, view.forward), f32::NEG_INFINITY, f32::INFINITY, &Trace::default())
                .is_some()
        });
        let (more, less) = (cells.beyond(&rays), rays.beyond(&cells));
        // Rays that graze a surface may fall on either side of it.
        assert!(rays.count() > 2000 && more <= 6 && less <= 6, "{more} more and {less} fewer than {}", rays.count());
    }
}

/// An impostor that is seen from its own direction covers what the original covers.
#[test]
fn a_map_covers_what_its_own_view_shows() {
    for (scene, direction) in
        [(sphere(4), DVec3::new(0.3, 0.2, 0.9)), (cube(), DVec3::new(0.5, 0.6, 0.7)), (bumps(), DVec3::Y)]
    {
        let map = map(&scene, direction.normalize(), 64, 1, DepthBits::Eight);
        let field = Field::new(&map, 4.0);
        let geometry = Geometry::new(&scene);
        // The map's own view keeps only what lies in the range of its depths.
        let view = look_along(scene.points().into_iter(), direction.normalize(), 64, 1.0).unwrap();
        let stop = Stop::default();
        let seen = nearest(&Cpu, &geometry, &view, &Options::default(), &stop).unwrap();
        let original = Mask::new(64 * 64, |i| seen.triangle[i] != NOTHING);
        for search in [Search::Pyramid, Search::Linear { steps: 16, halvings: 7 }] {
            let how = Trace { search, ..Trace::default() };
            let shown = coverage::of_map(&field, &view, &how, &stop).unwrap();
            assert_eq!((shown.beyond(&original), original.beyond(&shown)), (0, 0), "{search:?}");
        }
    }
}

/// Section 3.3, figure 5: the paper's rays end at walls, those that search by a pyramid go on.
#[test]
fn rays_end_at_walls_or_go_on() {
    // A small square high above a large one; the map looks down on both.
    let square = |h: f32, y: f32| [[-h, y, -h], [-h, y, h], [h, y, h], [h, y, -h]];
    let positions = [square(4.0, 0.0), square(1.0, 3.0)].concat();
    let scene = scene(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
    let map = map(&scene, DVec3::Y, 64, 1, DepthBits::Eight);
    let field = Field::new(&map, 4.0);
    // Under the small square, and out of its column before the large one is met.
    let (origin, direction) = (DVec3::new(-4.0, 2.6, 0.0), DVec3::new(1.0, -0.38, 0.0));
    let ray = field.ray(origin, direction);
    let shoot = |search| trace(&field, &ray, 0.0, 100.0, &Trace { search, wall: 4.0 });
    assert_eq!(shoot(Search::Linear { steps: 256, halvings: 7 }), None);
    let hit = shoot(Search::Pyramid).unwrap();
    assert!(field.world(hit.point).y.abs() < 0.1, "{}", field.world(hit.point));
}

#[test]
fn points_go_to_texels_and_back() {
    let map = map(&bumps(), DVec3::new(0.3, 0.8, -0.4).normalize(), 32, 1, DepthBits::Eight);
    let field = Field::new(&map, 4.0);
    for p in [DVec3::ZERO, DVec3::new(0.3, -0.2, 0.9), DVec3::new(-3.0, 2.0, 1.0)] {
        let q = field.point(p);
        assert!(field.world(q).distance(p) < 1e-5);
        let (x, y, z) = map.view.project(p);
        assert!((f64::from(q.x) - x).abs() < 1e-4 && (f64::from(q.y) - y).abs() < 1e-4);
        assert!((f64::from(q.z) - (z - map.view.near) / map.texel()).abs() < 1e-3);
    }
}

#[test]
fn each_strategy_ranks_by_its_own_rule() {
    let candidate = |plane, depth, cos| Some(Candidate { plane, depth, range: 3.2, cos, tolerance: 0.5 });
    let all = [candidate(3.0, 5.0, 0.5), None, candidate(2.0, 4.8, 0.1), candidate(9.0, 4.9, 0.9)];
    for (strategy, expect) in [
        (Strategy::Plane, 2),
        (Strategy::Depth, 2),
        (Strategy::Direction, 0),
        (Strategy::Normal, 3),
        // 5.0 − 0.05, 4.8 − 0.01, 4.9 − 0.09.
        (Strategy::BiasedDepth, 2),
    ] {
        assert_eq!(resolve(strategy, &all), Some(expect), "{strategy:?}");
        assert_eq!(resolve(strategy, &[None, None]), None);
    }
    // What lies far in front is another surface.
    let hidden = [candidate(0.0, 5.0, 1.0), candidate(0.0, 4.0, 0.1)];
    assert_eq!(resolve(Strategy::Direction, &hidden), Some(1));
}
