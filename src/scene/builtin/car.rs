//! A car, 4.7 × 1.8 × 1.5 m, about 1,188 triangles: the size of the second model in table 1 of Jeschke and Wimmer
//! 2002. Its length lies along x, its wheels stand on y = 0, the centre is over the origin.

use super::{
    shape::{Shape, object, plain, textured},
    texture,
};
use crate::scene::Scene;
use glam::{Mat4, Vec3};
use std::sync::Arc;

const LENGTH: f32 = 4.7;
const HALF_WIDTH: f32 = 0.9;

/// Height of a profile given as (x, y) stations, sorted by x, by smooth interpolation.
fn height(profile: &[(f32, f32)], x: f32) -> f32 {
    let k = profile.partition_point(|(px, _)| *px <= x).clamp(1, profile.len() - 1);
    let ((x0, y0), (x1, y1)) = (profile[k - 1], profile[k]);
    let t = ((x - x0) / (x1 - x0)).clamp(0.0, 1.0);
    y0 + (y1 - y0) * t * t * (3.0 - 2.0 * t)
}

/// A shell that is lofted over rounded cross-sections between `x0` and `x1`. `half(x)` and `top(x)`, `bottom(x)` in metres.
fn loft(
    nu: u32,
    nv: u32,
    x: [f32; 2],
    half: impl Fn(f32) -> f32,
    top: impl Fn(f32) -> f32,
    bottom: impl Fn(f32) -> f32,
) -> Shape {
    let point = |i: u32, j: u32| {
        let x = x[0] + (x[1] - x[0]) * i as f32 / nu as f32;
        // From the sill of the near side over the roof to the far one, a superellipse.
        let a = std::f32::consts::PI * j as f32 / nv as f32;
        let round = |v: f32| v.signum() * libm::powf(v.abs(), 0.45);
        let (c, s) = (round(libm::cosf(a)), round(libm::sinf(a)));
        Vec3::new(x, bottom(x) + (top(x) - bottom(x)) * s, half(x) * c)
    };
    let rows: Vec<Vec<(Vec3, Vec3)>> = (0..=nu)
        .map(|i| {
            (0..=nv)
                .map(|j| {
                    let along = point((i + 1).min(nu), j) - point(i.max(1) - 1, j);
                    let around = point(i, (j + 1).min(nv)) - point(i, j.max(1) - 1);
                    (point(i, j), around.cross(along).normalize_or(Vec3::Y))
                })
                .collect()
        })
        .collect();
    let mut shape = Shape::default();
    shape.grid(&rows);
    shape
}

pub fn car() -> Scene {
    let paint = textured("paint", &texture::stained("paint", 11, [0.55, 0.05, 0.04], [0.78, 0.12, 0.08]), [1.0; 3]);
    let [glass, rubber, metal, lamp, tail] = [
        plain("glass", [0.03, 0.05, 0.07]),
        plain("rubber", [0.015, 0.015, 0.015]),
        plain("metal", [0.55, 0.56, 0.58]),
        plain("lamp", [0.95, 0.92, 0.75]),
        plain("tail lamp", [0.6, 0.02, 0.02]),
    ]
    .map(Arc::new);
    let l = LENGTH * 0.5;
    let deck = [(-l, 0.62), (-2.2, 0.86), (-1.3, 0.98), (0.9, 0.96), (2.0, 0.80), (l, 0.55)];
    let sill = [(-l, 0.42), (-2.0, 0.26), (2.0, 0.24), (l, 0.36)];
    let body =
        loft(27, 8, [-l, l], |x| HALF_WIDTH - 0.16 * (x / l) * (x / l), |x| height(&deck, x), |x| height(&sill, x));
    let roof = [(-1.75, 0.93), (-0.9, 1.46), (-0.1, 1.5), (0.35, 1.44), (1.25, 0.93)];
    let cabin = loft(18, 8, [-1.75, 1.25], |x| 0.78 - 0.06 * x * x, |x| height(&roof, x), |_| 0.9);
    let still = Mat4::IDENTITY;
    let mut objects =
        vec![object("body", still, &body.mesh(1.5), &paint), object("cabin", still, &cabin.mesh(1.5), &glass)];

    let slab = |lo: [f32; 3], hi: [f32; 3]| {
        let mut s = Shape::default();
        s.closed_block(lo.into(), hi.into());
        s.mesh(1.0)
    };
    objects.push(object("floor", still, &slab([-2.1, 0.22, -0.8], [2.1, 0.45, 0.8]), &rubber));
    objects.push(object("roof panel", still, &slab([-0.85, 1.44, -0.45], [0.25, 1.485, 0.45]), &paint));
    for (name, x) in [("bumper front", l - 0.08), ("bumper rear", -l)] {
        objects.push(object(name, still, &slab([x, 0.34, -0.72], [x + 0.08, 0.52, 0.72]), &metal));
    }
    for (side, z) in [("left", 0.62f32), ("right", -0.62)] {
        let lamps = [("lamp", l - 0.12, &lamp), ("tail", 0.02 - l, &tail)];
        for (name, x, material) in lamps {
            let mesh = slab([x, 0.58, z - 0.12], [x + 0.06, 0.70, z + 0.12]);
            objects.push(object(format!("{name} {side}"), still, &mesh, material));
        }
        let s = z.signum();
        let (z0, z1) = ((s * 0.74).min(s * 0.9), (s * 0.74).max(s * 0.9));
        objects.push(object(format!("mirror {side}"), still, &slab([0.75, 0.96, z0], [0.92, 1.08, z1]), &paint));
        for (k, x) in [("front", 1.45), ("rear", -1.4)] {
            let mut tyre = Shape::default();
            tyre.wheel(Vec3::new(x, 0.33, s * 0.76), 0.33, 0.24, 14);
            objects.push(object(format!("wheel {k} {side}/tyre"), still, &tyre.mesh(1.0), &rubber));
            let mut rim = Shape::default();
            rim.wheel(Vec3::new(x, 0.33, s * 0.78), 0.2, 0.22, 8);
            objects.push(object(format!("wheel {k} {side}/rim"), still, &rim.mesh(1.0), &metal));
        }
    }
    Scene { objects }
}
