//! What projective texture coordinates mean: a cell seen from its centre looks as it was captured.

use super::{cell_files, cell_stand_in};
use crate::{
    formats::{GlbOptions, Limits, from_glb, write_glb},
    image::Picture,
    lod::{
        entry::Entry,
        outline::Outline,
        simplified::Simplified,
        subject::{Subject, Views},
        texture::{Textured, Texturing, texture},
        weights::{Window, Windows},
    },
    math::Stop,
    raster::{Cpu, Geometry, Rendering},
    runtime::{Context, SceneStandIn, StandIn},
    scene::Scene,
    view::{Prism, View},
};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use proptest::prelude::*;
use std::{path::Path, sync::Arc};

/// Pixels along a side of the capture.
const SIDE: u32 = 160;
const CENTRE: DVec3 = DVec3::new(130.0, 2.0, -75.0);

/// A square that a cell's centre captured in colours that differ from pixel to pixel, as the stand-in that is made of it.
pub(crate) struct Flat {
    pub view: View,
    pub colors: Vec<[u8; 4]>,
    pub textured: Textured,
}

/// `turn` radians about the vertical axis, metres from the middle and from there to a side.
pub(crate) fn flat(turn: f64, distance: f64, half: f64) -> Flat {
    let fov = 120.0_f64.to_radians();
    let view = View::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov, SIDE, SIDE, 0.1, 1e3);
    let (sin, cos) = libm::sincos(turn);
    let (right, normal) = (DVec3::new(cos, 0.0, -sin), DVec3::new(sin, 0.0, cos));
    let middle = DVec3::new(0.3, -0.2, -distance);
    let corner = |x: f64, y: f64| middle + right * (x * half) + DVec3::Y * (y * half);
    let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let depth = |i: u32| {
        let ray = view.unproject(f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5, 1.0);
        let z = middle.dot(normal) / ray.dot(normal);
        let at = ray * z - middle;
        if z > 0.0 && at.dot(right).abs() <= half && at.y.abs() <= half { z as f32 } else { f32::INFINITY }
    };
    // Neighbours differ much, so that half a texel is seen.
    let color = |i: u32| {
        let n = i.wrapping_mul(0x9e37_79b9);
        [(n >> 24) as u8, (n >> 16) as u8, (n >> 8) as u8, 255]
    };
    let colors: Vec<[u8; 4]> = (0..SIDE * SIDE).map(color).collect();
    let window = Window { view, depth: (0..SIDE * SIDE).map(depth).collect(), color: colors.iter().copied().collect() };
    let mesh = Simplified {
        positions,
        colors: vec![[0, 0, 0, 255]; 4],
        views: vec![1; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        error: 0.0,
        before: 2,
    };
    let textured = texture(&mesh, &Windows(vec![window]), true, &Texturing { moved: 0.1, radius: 3.0 });
    assert!(textured.triangles.len() == 2 && textured.patches.len() == 1 && textured.patches[0].window == Some(0));
    Flat { view, colors, textured }
}

impl Flat {
    /// The cell's scene as its GLB gives it.
    pub(crate) fn scene(&self) -> Scene {
        let subject = Subject {
            members: vec![("square".into(), DAffine3::IDENTITY)],
            views: Views::Single,
            cell: Prism { centre: DVec3::ZERO, size: 3.0, half_height: 0.1 },
            outline: Outline { plan: vec![DVec2::new(0.0, -10.0)], low: -1.0, high: 1.0 },
            focal: 100.0,
            cameras: Vec::new(),
        };
        let entry = Entry { centre: CENTRE.to_array(), ..Entry::default() };
        let files = cell_files(&entry, &[("square", &subject, &self.textured)], 1024).unwrap();
        let glb = write_glb(&files.scene, &GlbOptions::default()).unwrap();
        from_glb(Path::new("cell.glb"), Arc::new(glb), &Limits::default()).unwrap()
    }

    /// The camera of the capture, in the world.
    pub(crate) fn view(&self) -> View {
        View { eye: CENTRE, ..self.view }
    }

    /// How many pixels of the square, not counting its border, differ by more than `tolerance` from the capture, and how many there are.
    pub(crate) fn differing(&self, picture: &Picture, depth: &[f32], tolerance: u8) -> (usize, usize) {
        let inner = |i: &usize| {
            let around = [0, 1, SIDE as usize, SIDE as usize + 1];
            let seen = |i: usize| depth.get(i).is_some_and(|z| z.is_finite());
            around.iter().all(|k| seen(i + k) && seen(i.wrapping_sub(*k)))
        };
        let pixels: Vec<usize> = (0..depth.len()).filter(inner).collect();
        let differs = |i: &&usize| (0..3).any(|k| picture.texels[**i][k].abs_diff(self.colors[**i][k]) > tolerance);
        (pixels.iter().filter(differs).count(), pixels.len())
    }
}

#[test]
fn from_the_centre_a_cell_looks_as_it_was_captured() {
    for (turn, distance, half) in [(1.1, 12.0, 5.0), (-0.7, 10.0, 6.0), (0.4, 8.0, 2.0)] {
        let flat = flat(turn, distance, half);
        let scene = flat.scene();
        let geometry = Geometry::new(&scene);
        let how = Rendering::default().with_samples(1);
        let context = Context { backend: &Cpu, stop: &Stop::default() };
        let entry = Entry::default();
        let cast = cell_stand_in(&scene, &geometry, &entry);
        let cast = cast.draw(&flat.view(), &how, context).unwrap();
        let (differing, all) = flat.differing(&cast.picture, &cast.depth, 1);
        assert!(differing == 0 && all > 300, "{differing} of {all}");
        // What ordinary viewers show of the same file.
        let plain = SceneStandIn::new(&scene, &geometry);
        let plain = plain.draw(&flat.view(), &how, context).unwrap();
        let (differing, all) = flat.differing(&plain.picture, &plain.depth, 32);
        assert!(differing * 2 > all, "{differing} of {all}");
        // The cell draws objects inside it as they are.
        let entry = Entry { inside: vec!["square".into()], ..entry };
        let inside = cell_stand_in(&scene, &geometry, &entry);
        assert_eq!(inside.draw(&flat.view(), &how, context).unwrap().picture, plain.picture);
    }
}

#[test]
fn numbers_that_are_no_depths_leave_coordinates_as_they_are() {
    let flat = flat(0.8, 10.0, 4.0);
    let how = Rendering::default().with_samples(1);
    let context = Context { backend: &Cpu, stop: &Stop::default() };
    for wrong in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let mut scene = flat.scene();
        let mesh = Arc::make_mut(&mut scene.objects[0].parts[0].mesh);
        mesh.uv[1] = mesh.uv[1].iter().enumerate().map(|(i, d)| if i == 2 { [wrong, 0.0] } else { *d }).collect();
        let geometry = Geometry::new(&scene);
        let cast = cell_stand_in(&scene, &geometry, &Entry::default());
        let plain = SceneStandIn::new(&scene, &geometry);
        let (a, b) = (cast.draw(&flat.view(), &how, context), plain.draw(&flat.view(), &how, context));
        assert_eq!(a.unwrap().picture, b.unwrap().picture, "{wrong}");
    }
}

proptest! {
    /// Interpolating (u·d, v·d, d) and dividing gives for every point of a face where the capture saw it; interpolating (u, v) misses by texels.
    #[test]
    fn points_of_a_face_are_where_the_capture_saw_them(
        turn in 0.5..1.2_f64, left: bool, distance in 8.0..14.0, half in 4.0..6.0, face in 0_usize..2, s in 0.0..1.0_f64, t in 0.0..1.0_f64,
    ) {
        let flat = flat(if left { -turn } else { turn }, distance, half);
        let Textured { positions, uv, depth, triangles, patches, .. } = &flat.textured;
        let corners = triangles[face].map(|v| v as usize);
        let miss = |w: [f64; 3], cast: bool| {
            let mut p = DVec3::ZERO;
            let mut sum = DVec3::ZERO;
            for (w, v) in w.into_iter().zip(corners) {
                p += Vec3::from(positions[v]).as_dvec3() * w;
                let d = if cast { f64::from(depth[v]) } else { 1.0 };
                sum += DVec3::new(f64::from(uv[v][0]), f64::from(uv[v][1]), 1.0) * (w * d);
            }
            let [x0, y0] = patches[0].origin.map(f64::from);
            let (x, y, _) = flat.view.project(p);
            DVec2::new(x - x0, y - y0).distance(sum.truncate() / sum.z)
        };
        let (a, b) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
        let found = miss([1.0 - a - b, a, b], true);
        prop_assert!(found < 1e-3, "{found}");
        let middles = [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];
        prop_assert!(middles.iter().all(|w| miss(*w, true) < 1e-3));
        let plain = middles.iter().map(|w| miss(*w, false)).fold(0.0, f64::max);
        prop_assert!(plain > 1.0, "{plain}");
    }
}
