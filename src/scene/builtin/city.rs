//! A city on a lake: terraced pyramids on a walled precinct, rows of flat-roofed houses on rising ground, canals,
//! causeways and plazas. 450 × 450 × 50 m, about 158,944 triangles: the size of the model in table 1 of
//! Jeschke and Wimmer 2002, which is not to be had any more. The ground is in y = 0, the centre in the origin.

use super::{
    random::Random,
    shape::{Shape, object, textured},
    texture,
};
use crate::scene::{Material, Mesh, Object, Scene};
use glam::{Mat4, Vec3};
use std::{f32::consts::FRAC_PI_2, sync::Arc};

/// Half of the city's side, metres.
const HALF: f32 = 225.0;
/// Half of the precinct's side, metres.
const PRECINCT: f32 = 75.0;
/// Height of the precinct's platform.
const PLATFORM: f32 = 9.0;
/// Width of a canal or street between two blocks of houses.
const GAP: f32 = 9.0;
/// Side of a block of houses.
const BLOCK: f32 = 42.0;
/// Side of a house; its walls touch its neighbours', as in a row of courtyard houses.
const PLOT: f32 = 13.6;

/// Height of the ground: it rises in terraces from the shore to the precinct.
fn ground(x: f32, z: f32) -> f32 {
    let d = x.abs().max(z.abs());
    let rise = ((HALF - d) / (HALF - PRECINCT)).clamp(0.0, 1.0);
    1.0 + ((rise * 7.0).floor() / 7.0) * (PLATFORM - 2.0)
}

struct Palette {
    plaster: Vec<Arc<Material>>,
    stone: Arc<Material>,
    temple: Arc<Material>,
    paving: Arc<Material>,
    water: Arc<Material>,
    earth: Arc<Material>,
    green: Arc<Material>,
}

impl Palette {
    fn new(seed: u64) -> Self {
        let plaster = texture::stained("plaster", seed ^ 1, [0.72, 0.66, 0.56], [0.96, 0.92, 0.84]);
        let stone = texture::blocks("stone", seed ^ 2, 8, [0.30, 0.28, 0.26], [0.48, 0.45, 0.41], [0.70, 0.66, 0.60]);
        let paving = texture::blocks("paving", seed ^ 3, 4, [0.45, 0.42, 0.36], [0.66, 0.62, 0.54], [0.82, 0.78, 0.70]);
        let water = texture::stained("water", seed ^ 4, [0.12, 0.26, 0.34], [0.26, 0.46, 0.52]);
        let earth = texture::stained("earth", seed ^ 5, [0.46, 0.38, 0.26], [0.66, 0.58, 0.42]);
        let green = texture::stained("garden", seed ^ 6, [0.16, 0.30, 0.10], [0.40, 0.52, 0.22]);
        let tints = [[1.0, 1.0, 1.0], [0.95, 0.72, 0.52], [0.86, 0.80, 0.62], [0.90, 0.62, 0.56], [0.70, 0.76, 0.80]];
        Self {
            plaster: (tints.iter().enumerate()).map(|(i, t)| textured(&format!("plaster {i}"), &plaster, *t)).collect(),
            stone: textured("stone", &stone, [1.0; 3]),
            temple: textured("temple", &stone, [1.0, 0.55, 0.40]),
            paving: textured("paving", &paving, [1.0; 3]),
            water: textured("water", &water, [1.0; 3]),
            earth: textured("earth", &earth, [1.0; 3]),
            green: textured("garden", &green, [1.0; 3]),
        }
    }
}

/// A house around its origin on a square plot: walls, a laid roof, a low parapet of single stones, a hatch.
fn house(height: f32, hatch: f32) -> Shape {
    let mut s = Shape::default();
    let h = PLOT * 0.5;
    s.block(Vec3::new(-h, -0.9, -h), Vec3::new(h, height, h), 5);
    let stone = |s: &mut Shape, x: f32, z: f32, along_x: bool| {
        let (hx, hz) = if along_x { (0.5, 0.2) } else { (0.2, 0.5) };
        s.block(Vec3::new(x - hx, height, z - hz), Vec3::new(x + hx, height + 0.35, z + hz), 1);
    };
    let side = |i: i32, n: i32| (2.0 * i as f32 / (n - 1) as f32 - 1.0) * (h - 0.6);
    for i in 0..4 {
        stone(&mut s, side(i, 4), h - 0.2, true);
        stone(&mut s, side(i, 4), 0.2 - h, true);
    }
    for i in 1..3 {
        stone(&mut s, h - 0.2, side(i, 4), false);
        stone(&mut s, 0.2 - h, side(i, 4), false);
    }
    s.block(Vec3::new(0.2 * h, height, -0.5 * h), Vec3::new(0.6 * h, height + hatch, -0.1 * h), 2);
    s
}

/// A stepped pyramid of `terraces` on a square base, with a stairway of `steps` towards +z and a shrine on top.
/// `top` counts the shrine in.
fn pyramid(side: f32, top: f32, terraces: u32, steps: u32, shrines: u32) -> [Shape; 2] {
    let mut body = Shape::default();
    let cap = side * 0.36;
    let deck = top * if shrines > 0 { 0.72 } else { 1.0 };
    let at = |t: f32| side * 0.5 + (cap * 0.5 - side * 0.5) * t;
    for i in 0..terraces {
        let (lo, hi) = (i as f32 / terraces as f32, (i + 1) as f32 / terraces as f32);
        let (a, y0, y1) = (at(lo), deck * lo, deck * hi);
        let b = a + (at(hi) - a) * 0.4;
        let min = |h: f32, y: f32| Vec3::new(-h, y, -h);
        let max = |h: f32, y: f32| Vec3::new(h, y, h);
        body.frustum(min(a, y0), max(a, y0), min(b, y1), max(b, y1), 6);
    }
    let (front, back) = (side * 0.5 + side * 0.1, cap * 0.5);
    let wide = side * 0.11;
    for i in 0..steps {
        let (lo, hi) = (i as f32 / steps as f32, (i + 1) as f32 / steps as f32);
        let z0 = front + (back - front) * lo;
        body.block(Vec3::new(-wide, deck * lo - 0.5, back * 0.9), Vec3::new(wide, deck * hi, z0), 1);
    }
    let mut shrine = Shape::default();
    for i in 0..shrines {
        let x = if shrines == 1 { 0.0 } else { cap * (i as f32 - 0.5) * 0.5 };
        let (h, d) = (cap * if shrines == 1 { 0.28 } else { 0.2 }, cap * 0.22);
        let walls = deck + (top - deck) * 0.55;
        shrine.block(Vec3::new(x - h, deck, -d - cap * 0.1), Vec3::new(x + h, walls, d - cap * 0.1), 2);
        let (lo, hi) = (Vec3::new(x - h, walls, -d - cap * 0.1), Vec3::new(x + h, walls, d - cap * 0.1));
        let inset = Vec3::new(h * 0.35, 0.0, d * 0.35);
        shrine.frustum(lo, hi, lo + inset, (hi - inset).with_y(top), 4);
    }
    [body, shrine]
}

/// A wall from a to b (along x or z) with a crest of single stones.
fn wall(a: Vec3, b: Vec3, height: f32, thick: f32) -> Shape {
    let mut s = Shape::default();
    let t = Vec3::new(thick * 0.5, 0.0, thick * 0.5);
    let (lo, hi) = (a.min(b) - t, a.max(b) + t);
    s.block(lo, hi + Vec3::Y * height, 12);
    let n = ((b - a).length() / 1.6) as u32;
    for i in 0..n {
        let p = a.lerp(b, (i as f32 + 0.5) / n as f32) + Vec3::Y * height;
        s.block(p - Vec3::new(0.4, 0.0, 0.4), p + Vec3::new(0.4, 0.7, 0.4), 1);
    }
    s
}

fn slab(min: Vec3, max: Vec3, cut: u32) -> Shape {
    let mut s = Shape::default();
    s.block(min, max, cut);
    s
}

pub fn city(seed: u64) -> Scene {
    let look = Palette::new(seed);
    let mut random = Random::new(seed);
    let mut objects = Vec::new();
    let still = Mat4::IDENTITY;

    // The lake bed and shore: one plate of water, in which the terraces stand.
    let lake = slab(Vec3::new(-HALF, 0.0, -HALF), Vec3::new(HALF, 0.4, HALF), 8).mesh(24.0);
    objects.push(object("lake", still, &lake, &look.water));

    houses(&mut objects, &mut random, &look);
    precinct(&mut objects, &mut random, &look);

    // Causeways from the precinct to the four shores, over the canals.
    for (i, (dx, dz)) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].into_iter().enumerate() {
        let dir = Vec3::new(dx, 0.0, dz);
        let across = Vec3::new(dz.abs(), 0.0, dx.abs()) * (GAP * 0.5);
        for k in 0..7 {
            let (d0, d1) = (PRECINCT + 150.0 * k as f32 / 7.0, PRECINCT + 150.0 * (k + 1) as f32 / 7.0);
            let (a, b) = (dir * d0, dir * d1);
            let y = ground((dir * (d0 + 1.0)).x, (dir * (d0 + 1.0)).z) + 0.4;
            let (lo, hi) = (a.min(b) - across, a.max(b) + across);
            let road = slab(lo.with_y(0.0), hi.with_y(y), 8).mesh(8.0);
            objects.push(object(format!("causeway {i}.{k}"), still, &road, &look.paving));
        }
    }
    Scene { objects }
}

/// Blocks of houses between canals, on terraces that rise towards the precinct.
fn houses(objects: &mut Vec<Object>, random: &mut Random, look: &Palette) {
    let kinds: Vec<Arc<Mesh>> =
        (0..12).map(|i| house(3.8 + 0.06 * i as f32, 0.5 + 0.1 * (i % 3) as f32).mesh(6.0)).collect();
    let blocks = ((2.0 * HALF + GAP) / (BLOCK + GAP)).floor() as i32;
    let pitch = (2.0 * HALF - BLOCK) / (blocks - 1) as f32;
    for bz in 0..blocks {
        for bx in 0..blocks {
            let (cx, cz) = (-HALF + BLOCK * 0.5 + pitch * bx as f32, -HALF + BLOCK * 0.5 + pitch * bz as f32);
            if cx.abs().max(cz.abs()) < PRECINCT + BLOCK * 0.5 {
                continue;
            }
            let y = ground(cx, cz);
            let h = BLOCK * 0.5;
            let plate = slab(Vec3::new(cx - h, 0.0, cz - h), Vec3::new(cx + h, y, cz + h), 7).mesh(10.0);
            objects.push(object(format!("block {bx}.{bz}/ground"), Mat4::IDENTITY, &plate, &look.earth));
            let garden = random.below(4);
            for slot in 0..9 {
                let (sx, sz) = ((slot % 3) as f32 - 1.0, (slot / 3) as f32 - 1.0);
                let (x, z) = (cx + sx * PLOT, cz + sz * PLOT);
                let (kind, tint, turn) = (random.below(kinds.len()), random.below(5), random.below(4));
                if slot == 4 && garden == 0 {
                    let bed = slab(Vec3::new(x - 6.0, y, z - 6.0), Vec3::new(x + 6.0, y + 0.5, z + 6.0), 6).mesh(5.0);
                    objects.push(object(format!("block {bx}.{bz}/garden"), Mat4::IDENTITY, &bed, &look.green));
                    continue;
                }
                let place = Mat4::from_translation(Vec3::new(x, y, z)) * quarter_turns(turn);
                let name = format!("block {bx}.{bz}/house {slot}");
                objects.push(object(name, place, &kinds[kind], &look.plaster[tint]));
            }
        }
    }
}

/// Exact quarter turns about y (a rotation matrix from a sine would not be exact).
fn quarter_turns(n: usize) -> Mat4 {
    let (c, s) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][n % 4];
    debug_assert!((c - libm::cosf(n as f32 * FRAC_PI_2)).abs() < 1e-6);
    Mat4::from_cols_array(&[c, 0.0, -s, 0.0, 0.0, 1.0, 0.0, 0.0, s, 0.0, c, 0.0, 0.0, 0.0, 0.0, 1.0])
}

/// The walled platform with its pyramids and plazas.
fn precinct(objects: &mut Vec<Object>, random: &mut Random, look: &Palette) {
    let h = PRECINCT;
    for (i, (x, z)) in [(-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)].into_iter().enumerate() {
        let (lo, hi) = (Vec3::new(x * h, 0.0, z * h), Vec3::new((x + 1.0) * h, PLATFORM, (z + 1.0) * h));
        let plaza = slab(lo, hi, 12).mesh(12.0);
        objects.push(object(format!("precinct/plaza {i}"), Mat4::IDENTITY, &plaza, &look.paving));
    }
    let corner = |x: f32, z: f32| Vec3::new(x * (h - 1.0), PLATFORM, z * (h - 1.0));
    let ring = [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    for i in 0..4 {
        let (a, b) = (ring[i], ring[(i + 1) % 4]);
        for (k, (s, t)) in [(0.0, 0.46), (0.54, 1.0)].into_iter().enumerate() {
            let w = wall(a.lerp(b, s), a.lerp(b, t), 3.0, 1.6).mesh(6.0);
            objects.push(object(format!("precinct/wall {i}.{k}"), Mat4::IDENTITY, &w, &look.stone));
        }
    }
    let mut stand = |name: String, x: f32, z: f32, turn: usize, [body, shrine]: [Shape; 2]| {
        let place = Mat4::from_translation(Vec3::new(x, PLATFORM, z)) * quarter_turns(turn);
        objects.push(object(format!("{name}/body"), place, &body.mesh(8.0), &look.stone));
        if shrine.triangle_count() > 0 {
            objects.push(object(format!("{name}/shrine"), place, &shrine.mesh(6.0), &look.temple));
        }
    };
    stand("great pyramid".into(), 0.0, -28.0, 0, pyramid(62.0, 50.0 - PLATFORM, 12, 90, 2));
    for (i, (x, z)) in [(-50.0, -5.0), (50.0, -5.0), (-48.0, -48.0), (48.0, -48.0)].into_iter().enumerate() {
        let top = random.range(19.0, 25.0);
        stand(format!("pyramid {i}"), x, z, 0, pyramid(30.0, top, 8, 50, 1));
    }
    for (i, (x, z)) in [(-34.0, 44.0), (34.0, 44.0), (0.0, 34.0)].into_iter().enumerate() {
        let top = random.range(10.0, 14.0);
        stand(format!("altar {i}"), x, z, 0, pyramid(18.0, top, 6, 30, 1));
    }
    for i in 0..16 {
        let (side, k) = (if i % 2 == 0 { -1.0 } else { 1.0 }, (i / 2) as f32);
        let top = random.range(3.5, 6.0);
        stand(format!("platform {i:02}"), side * 67.0, -58.0 + k * 16.0, 0, pyramid(9.0, top, 4, 16, 0));
    }
}
