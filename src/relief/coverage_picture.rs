//! Pictures of how many maps sample each triangle (Andújar et al. 2007, figure 2).

use crate::{
    image::Picture,
    math::{Stop, Stopped},
    raster::{Backend, Geometry, NOTHING, Options, nearest},
    view::{Projection, View},
};

/// Maps from which on one more makes no difference.
const PLENTY: u32 = 10;

/// Behind the object.
const BACKGROUND: [u8; 4] = [200, 200, 200, 255];

/// For each of `triangles` triangles the number of captures that see it; a capture is what its pixels see, triangle numbers or [`NOTHING`].
pub fn count_samples<'a>(captures: impl IntoIterator<Item = &'a [u32]>, triangles: u32) -> Vec<u32> {
    let mut counts = vec![0; triangles as usize];
    // The last capture, from 1, that a triangle was counted for.
    let mut last = vec![0_u32; counts.len()];
    for (capture, shown) in (1..).zip(captures) {
        for t in shown.iter().filter(|t| **t < triangles).map(|t| *t as usize) {
            if last[t] != capture {
                last[t] = capture;
                counts[t] += 1;
            }
        }
    }
    counts
}

/// The colour of a triangle that so many maps sample, sRGB: black for none, red for one or two, then by way of yellow to green for ten or more.
pub fn coverage_color(count: u32) -> [u8; 3] {
    match count {
        0 => [0; 3],
        1 | 2 => [255, 0, 0],
        n => {
            let t = (n.min(PLENTY) - 2) * 510 / (PLENTY - 2);
            [(510 - t).min(255) as u8, t.min(255) as u8, 0]
        }
    }
}

/// The colours of all triangles.
pub fn coverage_colors(counts: &[u32]) -> Vec<[u8; 3]> {
    counts.iter().map(|n| coverage_color(*n)).collect()
}

/// The scene in the colours of its triangles as `view` sees it, darker where a face is turned aside. `colors` has one colour for each triangle.
pub fn coverage_picture(
    backend: &dyn Backend,
    geometry: &Geometry,
    view: &View,
    colors: &[[u8; 3]],
    stop: &Stop,
) -> Result<Picture, Stopped> {
    let shown = nearest(backend, geometry, view, &Options::default(), stop)?;
    let texel = |triangle: u32| {
        let Some(color) = colors.get(triangle as usize).filter(|_| triangle != NOTHING) else { return BACKGROUND };
        let [a, b, c] = geometry.positions(triangle);
        let towards = match view.projection {
            Projection::Orthographic { .. } => -view.forward,
            Projection::Perspective { .. } => (view.eye - a).normalize_or(-view.forward),
        };
        let cos = (b - a).cross(c - a).normalize_or_zero().dot(towards).abs();
        let [r, g, b] = color.map(|v| (f64::from(v) * (0.45 + 0.55 * cos)).round() as u8);
        [r, g, b, 255]
    };
    let texels = shown.triangle.iter().map(|t| texel(*t)).collect();
    Ok(Picture { width: view.width, height: view.height, texels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        raster::{
            Cpu,
            tests::{scene, square},
        },
        relief::entropy_tests::cube,
        view::directions,
    };
    use glam::DVec3;
    use std::collections::BTreeSet;

    #[test]
    fn colours_go_from_black_by_red_to_green() {
        let all = coverage_colors(&(0..14).collect::<Vec<_>>());
        assert_eq!(all[..3], [[0; 3], [255, 0, 0], [255, 0, 0]]);
        assert_eq!((all[6], all[10], all[13]), ([255, 255, 0], [0, 255, 0], [0, 255, 0]));
        let green = |c: &[u8; 3]| i32::from(c[1]) - i32::from(c[0]);
        assert!(all[2..=10].windows(2).all(|w| green(&w[0]) < green(&w[1])));
    }

    #[test]
    fn a_triangle_counts_once_in_a_capture() {
        let captures: [&[u32]; 3] = [&[0, 0, 2, NOTHING], &[2, 0, 2], &[7, NOTHING]];
        assert_eq!(count_samples(captures, 4), [2, 0, 2, 0]);
        assert_eq!(count_samples([], 2), [0, 0]);
    }

    #[test]
    fn pictures_show_the_colours_of_what_is_in_front() {
        let draw = |mesh, colors: &[[u8; 3]]| {
            let geometry = Geometry::new(&scene(mesh));
            let view = directions::look_along_sphere(DVec3::ZERO, 2.0, DVec3::Z, 32, 0.0);
            let picture = coverage_picture(&Cpu, &geometry, &view, colors, &Stop::default()).unwrap();
            picture.texels.into_iter().collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>()
        };
        let flat = draw(square(), &[[255, 0, 0], [0, 255, 0]]);
        assert_eq!(flat, [[0, 255, 0, 255], BACKGROUND, [255, 0, 0, 255]]);
        let colors: Vec<[u8; 3]> = (0..12).map(|i| [i * 20, 0, 255]).collect();
        // Triangles 2 and 3 face +Z; the others are hidden or edge-on.
        assert_eq!(draw(cube(), &colors), [[40, 0, 255, 255], [60, 0, 255, 255], BACKGROUND]);
    }
}
