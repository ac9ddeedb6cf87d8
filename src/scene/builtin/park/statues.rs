//! Six kinds of procedural statue, from an obelisk of few triangles to a knot of many: closed, outward wound, 9 to 46 m tall, as large
//! as the objects in table 2 of Chen et al. 2003. Each stands on y = 0 around the y axis and is painted.

use super::{
    super::{shape, texture},
    sculpt::{Ends, Sculpt},
};
use crate::scene::{Material, Mesh};
use glam::{Vec2, Vec3};
use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

/// A kind of statue: its name, its shape and its look.
pub struct Kind {
    pub name: &'static str,
    pub mesh: Arc<Mesh>,
    pub material: Arc<Material>,
}

/// A number of cells: `usual` at a detail of 1.
fn cells(usual: u32, detail: f64) -> u32 {
    ((f64::from(usual) * detail).round() as u32).max(3)
}

/// The point of a surface of revolution, at `turn` of a full turn.
fn around(radius: f32, y: f32, turn: f32) -> Vec3 {
    Vec3::new(radius * libm::sinf(turn * TAU), y, radius * libm::cosf(turn * TAU))
}

/// A smooth step from 0 at `a` to 1 at `b`.
fn step(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Where `t` of the way along a polyline is, each of its pieces as long in `t` as in space.
struct Polyline {
    points: Vec<Vec2>,
    lengths: Vec<f32>,
}

impl Polyline {
    fn new(points: &[[f32; 2]]) -> Self {
        let points: Vec<Vec2> = points.iter().map(|p| Vec2::from(*p)).collect();
        let mut lengths = vec![0.0];
        for w in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + (w[1] - w[0]).length());
        }
        Self { points, lengths }
    }

    /// Rows at about `n` equal steps and at every corner; rows at corners, the ends excepted, twice, so that they are creases.
    fn rows(&self, n: u32) -> Vec<Vec2> {
        let total = self.lengths[self.lengths.len() - 1];
        let mut rows = Vec::new();
        for (w, l) in self.points.windows(2).zip(self.lengths.windows(2)) {
            let pieces = (((l[1] - l[0]) / total * n as f32).round() as u32).max(1);
            rows.extend((0..=pieces).map(|i| w[0].lerp(w[1], i as f32 / pieces as f32)));
        }
        rows
    }
}

/// A closed surface of revolution around the y axis; `rows` are (radius, y) from the top to the bottom pole.
fn lathe(sculpt: &mut Sculpt, nu: u32, rows: &[Vec2], repeat: [f32; 2], bend: impl Fn(f32, Vec2) -> f32) {
    sculpt.surface([nu, rows.len() as u32 - 1], Ends::Poles, repeat, [1.0; 3], |i, j| {
        let (turn, row) = (i as f32 / nu as f32, rows[j as usize]);
        around(row.x * bend(turn, row), row.y, turn)
    });
}

/// A tube of `radius(t)` along a closed curve, or along an open one whose ends shrink to points.
fn tube(sculpt: &mut Sculpt, [nu, nv]: [u32; 2], ends: Ends, radius: impl Fn(f32) -> f32, curve: impl Fn(f32) -> Vec3) {
    let frame = |t: f32| {
        let h = 1e-3;
        // A ring's curve goes on beyond its ends, and so does any curve that is given by a formula.
        let along = (curve(t + h) - curve(t - h)).normalize_or(Vec3::Y);
        // No curve here runs along z.
        let aside = along.cross(Vec3::Z).normalize_or(Vec3::X);
        (aside, along.cross(aside))
    };
    sculpt.surface([nu, nv], ends, [2.0, 12.0], [1.0; 3], |i, j| {
        let (s, t) = (i as f32 / nu as f32, j as f32 / nv as f32);
        let (aside, other) = frame(t);
        let r = if ends == Ends::Poles && (j == 0 || j == nv) { 0.0 } else { radius(t) };
        curve(t) + (aside * libm::cosf(s * TAU) - other * libm::sinf(s * TAU)) * r
    });
}

fn plinth(sculpt: &mut Sculpt, half: f32, height: f32, cut: u32) {
    sculpt.block(Vec3::new(-half, 0.0, -half), Vec3::new(half, height, half), [cut, 1, cut], 6.0, [1.0; 3], |p| p);
}

fn obelisk(detail: f64) -> Sculpt {
    let mut sculpt = Sculpt::default();
    let n = cells(3, detail);
    plinth(&mut sculpt, 4.5, 2.0, n);
    // Four fifths of the rows are the shaft, the rest its pointed cap.
    let (shaft, tip) = (31.0, 36.0);
    let wide = 3.2;
    let (min, max) = (Vec3::new(-wide, 0.0, -wide), Vec3::new(wide, 1.0, wide));
    sculpt.block(min, max, [n, 5 * n, n], 6.0, [1.0, 0.86, 0.74], |p| {
        let t = p.y / 0.8;
        let (y, scale) = if p.y <= 0.8 {
            (2.0 + (shaft - 2.0) * t, 1.0 - 0.38 * t)
        } else {
            let u = ((p.y - 0.8) / 0.2).min(1.0);
            (shaft + (tip - shaft) * u, 0.62 * (1.0 - u))
        };
        Vec3::new(p.x * scale, y, p.z * scale)
    });
    sculpt
}

fn bench(detail: f64) -> Sculpt {
    let mut sculpt = Sculpt::default();
    let (n, wood, stone) = (cells(3, detail), [0.72, 0.45, 0.25], [0.9, 0.9, 0.86]);
    let curve = |p: Vec3| p + Vec3::Z * (0.012 * p.x * p.x);
    let mut board = |min: [f32; 3], max: [f32; 3], cells: [u32; 3], tint| {
        sculpt.block(min.into(), max.into(), cells, 4.0, tint, curve);
    };
    for k in 0..3 {
        let z = -2.6 + 1.9 * k as f32;
        board([-10.0, 3.6, z], [10.0, 4.3, z + 1.6], [4 * n, 1, 1], wood);
        let y = 5.2 + 1.5 * k as f32;
        board([-10.0, y, -3.6], [10.0, y + 1.1, -3.1], [4 * n, 1, 1], wood);
    }
    for x in [-8.5, 7.3] {
        board([x, 0.0, -3.2], [x + 1.2, 3.6, 3.0], [1, n, n], stone);
        board([x, 0.0, -4.2], [x + 1.2, 9.4, -3.6], [1, 2 * n, 1], stone);
    }
    sculpt
}

fn vase(detail: f64) -> Sculpt {
    let mut sculpt = Sculpt::default();
    let nv = cells(44, detail);
    // From the bottom of the inside over the lip down to the foot.
    let wall = |y: f32| {
        let belly = 3.2 + 5.4 * step(3.0, 14.0, y) - 5.2 * step(14.0, 24.0, y) + 2.6 * step(24.0, 28.0, y);
        belly + 1.2 * (1.0 - step(0.0, 3.0, y))
    };
    let row = |j: u32| {
        let t = j as f32 / nv as f32;
        if j == 0 {
            Vec2::new(0.0, 6.0)
        } else if j == nv {
            Vec2::new(wall(0.0), 0.0)
        } else if t < 0.4 {
            let y = 6.0 + 22.0 * (t / 0.4);
            Vec2::new((wall(y) - 0.7) * step(0.0, 0.06, t), y)
        } else {
            let y = 28.0 * (1.0 - (t - 0.4) / 0.6);
            Vec2::new(wall(y), y)
        }
    };
    // The foot is a crease.
    let rows: Vec<Vec2> = (0..=nv).map(row).chain([row(nv), Vec2::ZERO]).collect();
    lathe(&mut sculpt, cells(22, detail), &rows, [3.0, 2.0], |_, _| 1.0);
    for side in [1.0, -1.0] {
        let handle = |t: f32| {
            let a = PI * (t - 0.5);
            Vec3::new(side * (4.0 + 6.6 * libm::cosf(a)), 18.5 - 6.5 * libm::sinf(a), 0.0)
        };
        tube(&mut sculpt, [cells(6, detail), cells(14, detail)], Ends::Poles, |_| 0.8, handle);
    }
    sculpt
}

fn column(detail: f64) -> Sculpt {
    let mut sculpt = Sculpt::default();
    plinth(&mut sculpt, 7.0, 1.5, cells(3, detail));
    let outline = [
        [0.0, 45.0],
        [6.4, 45.0],
        [6.4, 43.2],
        [4.6, 40.0],
        [3.9, 39.2],
        [4.0, 30.0],
        [4.4, 15.0],
        [4.6, 5.0],
        [5.8, 4.2],
        [5.8, 3.0],
        [6.5, 2.4],
        [6.5, 1.2],
        [0.0, 1.2],
    ];
    let flutes = 12.0;
    lathe(&mut sculpt, cells(48, detail), &Polyline::new(&outline).rows(cells(26, detail)), [3.0, 4.0], |turn, row| {
        let shaft = step(4.9, 6.5, row.y) * (1.0 - step(37.5, 39.1, row.y));
        1.0 - 0.13 * shaft * libm::fabsf(libm::sinf(turn * flutes * PI))
    });
    sculpt
}

fn figure(detail: f64) -> Sculpt {
    let mut sculpt = Sculpt::default();
    plinth(&mut sculpt, 5.5, 3.0, cells(4, detail));
    // A robe in folds that turn with height, shoulders, neck.
    let outline = [
        [0.0, 27.2],
        [1.0, 27.0],
        [1.3, 25.6],
        [3.6, 24.4],
        [4.0, 22.8],
        [3.2, 19.0],
        [2.7, 16.0],
        [3.4, 11.0],
        [4.3, 6.0],
        [4.9, 3.0],
        [4.9, 2.6],
        [0.0, 2.6],
    ];
    lathe(&mut sculpt, cells(56, detail), &Polyline::new(&outline).rows(cells(34, detail)), [4.0, 3.0], |turn, row| {
        let folds = 1.0 - step(15.0, 23.0, row.y);
        let flat = 0.75 + 0.25 * libm::fabsf(libm::sinf(turn * TAU));
        let wave = libm::sinf(TAU * (9.0 * turn + 0.04 * row.y));
        flat * (1.0 + folds * (0.11 * wave + 0.05 * libm::sinf(TAU * (4.0 * turn - 0.07 * row.y))))
    });
    let (hu, hv) = (cells(18, detail), cells(14, detail));
    sculpt.surface([hu, hv], Ends::Poles, [2.0, 1.0], [1.0, 0.88, 0.78], |i, j| {
        let a = PI * j as f32 / hv as f32;
        let r = if j == 0 || j == hv { 0.0 } else { libm::sinf(a) };
        let p = around(r, libm::cosf(a), i as f32 / hu as f32);
        Vec3::new(0.0, 29.0, 0.25) + p * Vec3::new(1.65, 2.1, 1.9)
    });
    for side in [1.0f32, -1.0] {
        // One arm hangs, the other is raised.
        let up = side;
        let arm = |t: f32| {
            let elbow = libm::sinf(PI * t.clamp(0.0, 1.0));
            Vec3::new(side * (3.0 + 3.2 * elbow + 1.2 * t), 23.4 + up * 8.5 * t * t - 2.2 * elbow, 0.4 + 1.8 * t)
        };
        let thick = |t: f32| (1.25 - 0.5 * t) * step(0.0, 0.04, t).max(0.2) * (1.0 - 0.6 * step(0.93, 1.0, t));
        tube(&mut sculpt, [cells(12, detail), cells(26, detail)], Ends::Poles, thick, arm);
    }
    sculpt
}

fn knot(detail: f64) -> Sculpt {
    let mut sculpt = Sculpt::default();
    plinth(&mut sculpt, 8.0, 4.0, cells(5, detail));
    // The (2, 3) torus knot, upright.
    let curve = |t: f32| {
        let a = t * TAU;
        let r = 1.0 + 0.45 * libm::cosf(3.0 * a);
        let p = Vec3::new(r * libm::cosf(2.0 * a), r * libm::sinf(2.0 * a), 0.5 * libm::sinf(3.0 * a));
        Vec3::new(0.0, 21.0, 0.0) + p * 10.0
    };
    let ribs = |t: f32| 2.4 * (1.0 + 0.08 * libm::sinf(t * TAU * 45.0));
    tube(&mut sculpt, [cells(20, detail), cells(180, detail)], Ends::Ring, ribs, curve);
    sculpt
}

/// The kinds, in the order of their names, with about `detail`² as many triangles as at a detail of 1: 456 to 7,340.
pub fn kinds(detail: f64) -> Vec<Kind> {
    let kind = |name: &'static str, seed: u64, sculpt: Sculpt, ground: [f32; 3], ink: [f32; 3], accent: [f32; 3]| {
        let image = texture::bands(name, seed, ground, ink, accent);
        let material = Arc::unwrap_or_clone(shape::textured(name, &image, [1.0; 3]));
        Kind { name, mesh: sculpt.mesh(seed), material: Arc::new(Material { double_sided: false, ..material }) }
    };
    vec![
        kind("bench", 21, bench(detail), [0.86, 0.78, 0.66], [0.50, 0.38, 0.26], [0.70, 0.58, 0.42]),
        kind("column", 22, column(detail), [0.90, 0.88, 0.80], [0.24, 0.38, 0.56], [0.76, 0.52, 0.24]),
        kind("figure", 23, figure(detail), [0.74, 0.80, 0.76], [0.20, 0.36, 0.30], [0.58, 0.20, 0.22]),
        kind("knot", 24, knot(detail), [0.92, 0.74, 0.36], [0.50, 0.22, 0.10], [0.98, 0.94, 0.78]),
        kind("obelisk", 25, obelisk(detail), [0.84, 0.62, 0.50], [0.36, 0.16, 0.14], [0.96, 0.88, 0.62]),
        kind("vase", 26, vase(detail), [0.86, 0.46, 0.26], [0.10, 0.08, 0.08], [0.96, 0.90, 0.78]),
    ]
}
