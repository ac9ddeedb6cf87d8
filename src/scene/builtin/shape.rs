//! Building blocks of procedural meshes: quads, boxes, prisms and surfaces of revolution with normals and
//! texture coordinates in metres.

use crate::scene::{Alpha, Image, Material, Mesh, Object, Part, Texture, Wrap};
use glam::{Mat4, Vec2, Vec3};
use std::sync::Arc;

/// A mesh under construction.
#[derive(Default)]
pub struct Shape {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Shape {
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    fn vertex(&mut self, p: Vec3, n: Vec3, uv: Vec2) -> u32 {
        self.positions.push(p.into());
        self.normals.push(n.into());
        self.uv.push(uv.into());
        self.positions.len() as u32 - 1
    }

    /// A flat quad a, b, c, d (counter-clockwise from the front) cut into `nu` × `nv` cells along a→b and a→d.
    /// Texture coordinates are lengths in metres from a.
    pub fn quad(&mut self, [a, b, c, d]: [Vec3; 4], nu: u32, nv: u32) {
        let n = (b - a).cross(d - a).normalize();
        let (lu, lv) = ((b - a).length(), (d - a).length());
        let first = self.positions.len() as u32;
        for j in 0..=nv {
            for i in 0..=nu {
                let (s, t) = (i as f32 / nu as f32, j as f32 / nv as f32);
                let p = a.lerp(b, s).lerp(d.lerp(c, s), t);
                self.vertex(p, n, Vec2::new(s * lu, -t * lv));
            }
        }
        for j in 0..nv {
            for i in 0..nu {
                let v = first + j * (nu + 1) + i;
                self.triangles.push([v, v + 1, v + nu + 2]);
                self.triangles.push([v, v + nu + 2, v + nu + 1]);
            }
        }
    }

    /// A box with a cap `cut` cells wide and four sides; no floor.
    pub fn block(&mut self, min: Vec3, max: Vec3, cut: u32) {
        self.frustum(min, max, min, max, cut);
    }

    /// A truncated pyramid: base rectangle at `min.y`, cap rectangle at `max.y`; no floor.
    /// `base_*` give the base in x and z, `cap_*` the cap.
    pub fn frustum(&mut self, base_min: Vec3, base_max: Vec3, cap_min: Vec3, cap_max: Vec3, cut: u32) {
        let ring = |min: Vec3, max: Vec3, y: f32| {
            [
                Vec3::new(min.x, y, max.z),
                Vec3::new(max.x, y, max.z),
                Vec3::new(max.x, y, min.z),
                Vec3::new(min.x, y, min.z),
            ]
        };
        let (lo, hi) = (ring(base_min, base_max, base_min.y), ring(cap_min, cap_max, cap_max.y));
        for i in 0..4 {
            let j = (i + 1) % 4;
            self.quad([lo[i], lo[j], hi[j], hi[i]], 1, 1);
        }
        self.quad(hi, cut, cut);
    }

    /// The same box with a floor: closed.
    pub fn closed_block(&mut self, min: Vec3, max: Vec3) {
        self.block(min, max, 1);
        let y = min.y;
        self.quad(
            [
                Vec3::new(min.x, y, min.z),
                Vec3::new(max.x, y, min.z),
                Vec3::new(max.x, y, max.z),
                Vec3::new(min.x, y, max.z),
            ],
            1,
            1,
        );
    }

    /// A surface over a grid of points, `points[j][i]`, smooth normals given per point.
    pub fn grid(&mut self, points: &[Vec<(Vec3, Vec3)>]) {
        let first = self.positions.len() as u32;
        let nu = points[0].len() as u32;
        for row in points {
            for (p, n) in row {
                self.vertex(*p, *n, Vec2::new(p.x + p.z, -p.y - p.z));
            }
        }
        for j in 0..points.len() as u32 - 1 {
            for i in 0..nu - 1 {
                let v = first + j * nu + i;
                self.triangles.push([v, v + 1, v + nu + 1]);
                self.triangles.push([v, v + nu + 1, v + nu]);
            }
        }
    }

    /// A cylinder around z through `centre`, closed at both ends, with `sides` sides.
    pub fn wheel(&mut self, centre: Vec3, radius: f32, width: f32, sides: u32) {
        let at = |i: u32, z: f32| {
            let a = (i % sides) as f32 / sides as f32 * std::f32::consts::TAU;
            let n = Vec3::new(libm::cosf(a), libm::sinf(a), 0.0);
            (centre + n * radius + Vec3::Z * z, n)
        };
        let h = width * 0.5;
        for i in 0..sides {
            let ring = [at(i, h), at(i, -h), at(i + 1, -h), at(i + 1, h)];
            let v = ring.map(|(p, n)| self.vertex(p, n, Vec2::new(p.x, p.y)));
            self.triangles.push([v[0], v[1], v[2]]);
            self.triangles.push([v[0], v[2], v[3]]);
            for z in [h, -h] {
                let n = Vec3::Z * z.signum();
                let v =
                    [centre + Vec3::Z * z, at(i, z).0, at(i + 1, z).0].map(|p| self.vertex(p, n, Vec2::new(p.x, p.y)));
                self.triangles.push(if z > 0.0 { v } else { [v[0], v[2], v[1]] });
            }
        }
    }

    /// The finished mesh, texture coordinates scaled so that the image repeats every `tile` metres.
    pub fn mesh(self, tile: f32) -> Arc<Mesh> {
        Arc::new(Mesh {
            positions: self.positions.into(),
            normals: self.normals.into(),
            uv: [self.uv.into_iter().map(|[u, v]| [u / tile, v / tile]).collect(), Default::default()],
            triangles: self.triangles.into(),
            ..Default::default()
        })
    }
}

/// A material with a repeating image times a linear tint.
pub fn textured(name: &str, image: &Arc<Image>, tint: [f32; 3]) -> Arc<Material> {
    let texture = Texture {
        image: image.clone(),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Repeat; 2],
        smooth: true,
    };
    Arc::new(Material { base_color_texture: Some(texture), ..plain(name, tint) })
}

/// A material of one linear colour.
pub fn plain(name: &str, [r, g, b]: [f32; 3]) -> Material {
    Material {
        name: name.into(),
        base_color: [r, g, b, 1.0],
        metallic: 0.0,
        roughness: 0.9,
        alpha: Alpha::Opaque,
        ..Default::default()
    }
}

/// An object with one part.
pub fn object(name: impl Into<String>, transform: Mat4, mesh: &Arc<Mesh>, material: &Arc<Material>) -> Object {
    Object { name: name.into(), transform, parts: vec![Part { mesh: mesh.clone(), material: material.clone() }] }
}
