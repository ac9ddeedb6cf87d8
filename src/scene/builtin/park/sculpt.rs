//! Builds closed meshes from closed pieces: surfaces over a periodic parameter and boxes, both bent by any function of the place.
//!
//! What always holds: each piece is closed where corners of equal coordinates are one, its triangles are seen counter-clockwise from
//! outside, and none has two equal corners. Points that coincide are computed once, so that their bits are equal.

use super::stone::Stone;
use crate::{math::Aabb, scene::Mesh};
use glam::Vec3;
use std::sync::Arc;

/// How a surface ends where its second parameter does.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// In a point on either side.
    Poles,
    /// Where it began.
    Ring,
}

/// A mesh under construction.
#[derive(Default)]
pub struct Sculpt {
    positions: Vec<[f32; 3]>,
    normals: Vec<Vec3>,
    uv: Vec<[f32; 2]>,
    tints: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Sculpt {
    /// A closed surface over s, t in [0, 1] of `nu` × `nv` cells, `at(i, j)` its grid points with i below `nu`; counter-clockwise seen
    /// from outside where s runs to the right and t down. Equal rows on end make a crease. `repeat`: how often the image goes round
    /// and along.
    pub fn surface(
        &mut self,
        [nu, nv]: [u32; 2],
        ends: Ends,
        repeat: [f32; 2],
        tint: [f32; 3],
        at: impl Fn(u32, u32) -> Vec3,
    ) {
        let weld = |i: u32, j: u32| match ends {
            Ends::Poles if j == 0 || j == nv => (0, j),
            Ends::Poles => (i % nu, j),
            Ends::Ring => (i % nu, j % nv),
        };
        let uv = |i: u32, j: u32| [i as f32 / nu as f32 * repeat[0], j as f32 / nv as f32 * repeat[1]];
        self.patch([nu, nv], weld, uv, tint, at);
    }

    /// A box of `cells` along each axis, its points moved by `bend`; the image repeats every `tile` metres.
    pub fn block(
        &mut self,
        min: Vec3,
        max: Vec3,
        cells: [u32; 3],
        tile: f32,
        tint: [f32; 3],
        bend: impl Fn(Vec3) -> Vec3,
    ) {
        // The same number gives the same bits on every face that shares an edge.
        let along = |axis: usize, i: u32| min[axis] + (max[axis] - min[axis]) * (i as f32 / cells[axis] as f32);
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for top in [false, true] {
                // A patch shows its front where its second axis times its first points outwards.
                let (u, v) = if top { (v, u) } else { (u, v) };
                let straight = |i: u32, j: u32| {
                    let mut p = Vec3::ZERO;
                    p[axis] = along(axis, if top { cells[axis] } else { 0 });
                    p[u] = along(u, i);
                    p[v] = along(v, j);
                    p
                };
                let uv = |i: u32, j: u32| {
                    let p = straight(i, j);
                    if axis == 1 { [p.x / tile, p.z / tile] } else { [(p.x + p.z) / tile, -p.y / tile] }
                };
                self.patch([cells[u], cells[v]], |i, j| (i, j), uv, tint, |i, j| bend(straight(i, j)));
            }
        }
    }

    /// A grid of quads; corners that `weld` gives the same numbers are one point with one normal.
    fn patch(
        &mut self,
        [nu, nv]: [u32; 2],
        weld: impl Fn(u32, u32) -> (u32, u32),
        uv: impl Fn(u32, u32) -> [f32; 2],
        tint: [f32; 3],
        at: impl Fn(u32, u32) -> Vec3,
    ) {
        let first = self.positions.len() as u32;
        let corner = |i: u32, j: u32| first + j * (nu + 1) + i;
        let all = (0..=nv).flat_map(|j| (0..=nu).map(move |i| (i, j)));
        for (i, j) in all.clone() {
            let (wi, wj) = weld(i, j);
            // Adding zero turns −0 into 0: equal places have equal bits.
            self.positions.push((at(wi, wj) + Vec3::ZERO).into());
            self.uv.push(uv(i, j));
            self.tints.push(tint);
        }
        let mut normals = vec![Vec3::ZERO; self.positions.len() - first as usize];
        for (i, j) in (0..nv).flat_map(|j| (0..nu).map(move |i| (i, j))) {
            let quad = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)];
            for t in [[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| t.map(|k| quad[k])) {
                let [a, b, c] = t.map(|(i, j)| Vec3::from(self.positions[corner(i, j) as usize]));
                if a == b || b == c || c == a {
                    continue;
                }
                self.triangles.push(t.map(|(i, j)| corner(i, j)));
                for (i, j) in t {
                    let (wi, wj) = weld(i, j);
                    normals[(corner(wi, wj) - first) as usize] += (b - a).cross(c - a);
                }
            }
        }
        self.normals.extend(all.map(|(i, j)| {
            let (wi, wj) = weld(i, j);
            normals[(corner(wi, wj) - first) as usize].normalize_or(Vec3::Y)
        }));
    }

    /// The finished mesh, its vertices' colours the tints times a weathered grey that `seed` decides.
    pub fn mesh(self, seed: u64) -> Arc<Mesh> {
        let size = Aabb::of(self.positions.iter().map(|p| Vec3::from(*p))).diagonal() as f32;
        let weather = Stone { seed, dark: [0.45; 3], light: [1.0; 3] }.colors(&self.positions, size);
        let color = |(w, t): ([f32; 4], &[f32; 3])| [w[0] * t[0], w[1] * t[1], w[2] * t[2], 1.0];
        Arc::new(Mesh {
            colors: weather.into_iter().zip(&self.tints).map(color).collect(),
            positions: self.positions.into(),
            normals: self.normals.into_iter().map(|n| n.to_array()).collect(),
            uv: [self.uv.into(), Default::default()],
            triangles: self.triangles.into(),
            ..Default::default()
        })
    }
}
