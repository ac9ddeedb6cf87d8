//! A few closed solids: a box, a sphere and a torus.

use super::{shape, texture};
use crate::{
    math::Aabb,
    scene::{Material, Mesh, Scene},
};
use glam::{Mat4, Vec3};
use std::{f32::consts::TAU, sync::Arc};

/// A closed surface over a periodic parameter square; rows may shrink to a point.
fn closed_grid(nu: u32, nv: u32, wrap_v: bool, at: impl Fn(f32, f32) -> (Vec3, Vec3)) -> Arc<Mesh> {
    let (mut positions, mut normals, mut uv, mut triangles) = (vec![], vec![], vec![], vec![]);
    for j in 0..=nv {
        for i in 0..=nu {
            let (s, t) = (i as f32 / nu as f32, j as f32 / nv as f32);
            let last_v = if wrap_v { (j % nv) as f32 / nv as f32 } else { t };
            let (p, n) = at((i % nu) as f32 / nu as f32, last_v);
            positions.push(p.to_array());
            normals.push(n.to_array());
            uv.push([s * 4.0, t * 2.0]);
        }
    }
    for j in 0..nv {
        for i in 0..nu {
            let v = j * (nu + 1) + i;
            for t in [[v, v + 1, v + nu + 2], [v, v + nu + 2, v + nu + 1]] {
                let [a, b, c] = t.map(|k: u32| positions[k as usize]);
                if a != b && b != c && c != a {
                    triangles.push(t);
                }
            }
        }
    }
    Arc::new(Mesh {
        positions: positions.into(),
        normals: normals.into(),
        uv: [uv.into(), Default::default()],
        triangles: triangles.into(),
        ..Default::default()
    })
}

fn circle(t: f32) -> (f32, f32) {
    (libm::cosf(t * TAU), libm::sinf(t * TAU))
}

pub fn solids() -> Scene {
    let checks = texture::blocks("blocks", 5, 8, [0.2, 0.2, 0.2], [0.7, 0.4, 0.2], [0.95, 0.8, 0.5]);
    let stains = texture::stained("stains", 6, [0.1, 0.25, 0.5], [0.6, 0.8, 0.95]);
    let mut block = shape::Shape::default();
    block.closed_block(Vec3::new(-0.7, -0.7, -0.7), Vec3::new(0.7, 0.7, 0.7));
    let sphere = closed_grid(48, 24, false, |s, t| {
        let ((cs, sn), (ct, st)) = (circle(s), circle(t * 0.5));
        // The poles are one point each, whatever s says.
        let r = if t == 0.0 || t == 1.0 { 0.0 } else { st };
        let n = Vec3::new(r * sn, ct, r * cs) + Vec3::ZERO; // no negative zeros
        (n, n)
    });
    let torus = closed_grid(64, 32, true, |s, t| {
        let ((cs, sn), (ct, st)) = (circle(s), circle(-t));
        let n = Vec3::new(ct * cs, ct * sn, st);
        (Vec3::new(cs, sn, 0.0) * 0.9 + n * 0.35, n)
    });
    let at = |x, y, z| Mat4::from_translation(Vec3::new(x, y, z));
    Scene {
        objects: vec![
            shape::object("box", at(-2.4, 0.7, 0.0), &block.mesh(1.0), &shape::textured("blocks", &checks, [1.0; 3])),
            shape::object("sphere", at(0.0, 1.0, -0.8), &sphere, &shape::textured("stains", &stains, [1.0; 3])),
            shape::object("torus", at(2.4, 1.25, 0.4), &torus, &shape::textured("gold", &checks, [1.0, 0.8, 0.3])),
        ],
    }
}

/// A box as a closed solid.
pub fn closed_box(bounds: &Aabb) -> Scene {
    let mut block = shape::Shape::default();
    block.closed_block(bounds.min.as_vec3(), bounds.max.as_vec3());
    Scene { objects: vec![shape::object("box", Mat4::IDENTITY, &block.mesh(1.0), &Arc::new(Material::default()))] }
}
