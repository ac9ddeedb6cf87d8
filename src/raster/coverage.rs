//! Operation 3: how much of each triangle views show.

use super::{Backend, Camera, Geometry, NOTHING, Options, Prepared, clip::clip_to_view, nearest_in_tiles};
use crate::{
    math::{Stop, Stopped},
    view::View,
};
use glam::DVec3;
use rayon::prelude::*;

/// What one view shows of every triangle, by its number in the [`Geometry`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Pixel centres whose nearest surface it is.
    pub pixels: Vec<u32>,
    /// Area on the picture in square pixels, of the part within the view's borders and depths, whatever hides it; negative
    /// where its back is seen. Alpha does not count.
    pub area: Vec<f32>,
}

/// Calls `work(i, coverage)` for each of `views`, in their order; memory is that of one view.
pub fn coverage<R>(
    backend: &dyn Backend,
    geometry: &Geometry,
    views: &[View],
    options: &Options,
    stop: &Stop,
    mut work: impl FnMut(usize, &Coverage) -> R,
) -> Result<Vec<R>, Stopped> {
    let triangles = geometry.triangle_count() as usize;
    let mut coverage = Coverage::default();
    let mut results = Vec::with_capacity(views.len());
    for (i, view) in views.iter().enumerate() {
        let prepared = Prepared::new(geometry, view, options, stop)?;
        let tiles = nearest_in_tiles(backend, &prepared, stop, |_, _, seen| runs(seen))?;
        coverage.pixels.clear();
        coverage.pixels.resize(triangles, 0);
        for (triangle, count) in tiles.into_iter().flatten() {
            coverage.pixels[triangle as usize] += count;
        }
        let mut camera = Camera::new(view);
        camera.band = [0.0, f64::from(view.width), 0.0, f64::from(view.height)];
        stop.check()?;
        let area = |t: u32| area(&camera, geometry.positions(t)) as f32;
        (0..geometry.triangle_count()).into_par_iter().map(area).collect_into_vec(&mut coverage.area);
        results.push(work(i, &coverage));
    }
    Ok(results)
}

/// The triangles seen, with the lengths of their runs.
fn runs(seen: &[u32]) -> Vec<(u32, u32)> {
    let runs = seen.chunk_by(|a, b| a == b).filter(|run| run[0] != NOTHING);
    runs.map(|run| (run[0], run.len() as u32)).collect()
}

/// Of a triangle of the world, counter-clockwise from its front.
fn area(camera: &Camera, corners: [DVec3; 3]) -> f64 {
    let polygon = clip_to_view(corners.map(|p| camera.world_to_camera(p)), camera);
    let Some((first, rest)) = polygon.corners().split_first() else { return 0.0 };
    let from_first = |p: &DVec3| {
        let ((x, y), (x0, y0)) = (camera.pixel(*p), camera.pixel(*first));
        (x - x0, y - y0)
    };
    let doubled = rest.windows(2).map(|pair| {
        let ((ax, ay), (bx, by)) = (from_first(&pair[0]), from_first(&pair[1]));
        // y points down.
        ay * bx - ax * by
    });
    doubled.sum::<f64>() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        raster::{
            Cpu,
            tests::{ahead, literal, octahedron, scene, square},
        },
        scene::Scene,
    };
    use proptest::prelude::*;

    fn cover(scene: &Scene, views: &[View]) -> Vec<Coverage> {
        let geometry = Geometry::new(scene);
        coverage(&Cpu, &geometry, views, &Options::default(), &Stop::default(), |_, c| c.clone()).unwrap()
    }

    #[test]
    fn a_square_fills_what_it_should() {
        // It spans the view's height at distance 1.
        let views = [1.0, 2.0, 0.5].map(|d| ahead(d, 100, 80));
        let found = cover(&scene(square()), &views);
        for (c, side) in found.iter().zip([80.0, 40.0, 160.0]) {
            let (w, h) = (f64::min(side, 100.0), f64::min(side, 80.0));
            assert_eq!(c.pixels.iter().sum::<u32>() as f64, w * h);
            assert!((c.area.iter().map(|a| f64::from(*a)).sum::<f64>() - w * h).abs() < 1e-2, "{:?}", c.area);
        }
        let behind = View { eye: DVec3::new(0.0, 0.0, -1.0), forward: DVec3::Z, right: -DVec3::X, ..views[0] };
        let c = &cover(&scene(square()), &[behind])[0];
        assert!(c.pixels.iter().sum::<u32>() == 6400 && c.area.iter().all(|a| *a < 0.0), "{c:?}");
    }

    #[test]
    fn fronts_and_backs_of_a_closed_mesh_have_equal_areas() {
        let c = &cover(&scene(octahedron(3)), &[ahead(2.5, 200, 160)])[0];
        let sum = |sign: f32| c.area.iter().filter(|a| **a * sign > 0.0).map(|a| f64::from(a.abs())).sum::<f64>();
        let (front, back) = (sum(1.0), sum(-1.0));
        assert!((front - back).abs() < 1e-3 * front, "{front} {back}");
        // What is in front is seen, each pixel once.
        let seen: u32 = c.pixels.iter().sum();
        assert!((f64::from(seen) - front).abs() < 0.02 * front, "{seen} {front}");
        assert!(c.pixels.iter().zip(&c.area).all(|(n, a)| *n == 0 || *a > 0.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn counts_are_those_of_the_nearest_surfaces(scene in literal::soup(), view in literal::any_view()) {
            let c = &cover(&scene, &[view])[0];
            let geometry = Geometry::new(&scene);
            let near = crate::raster::nearest(&Cpu, &geometry, &view, &Options::default(), &Stop::default()).unwrap();
            for (t, n) in c.pixels.iter().enumerate() {
                prop_assert_eq!(*n as usize, near.triangle.iter().filter(|s| **s == t as u32).count());
            }
        }
    }
}
