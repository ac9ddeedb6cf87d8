//! The same field by its definition: one pass per layer, pixel by pixel, sample by sample.

use super::{
    Face, Fineness, Soup,
    cuts::{Cut, meets},
    facing, slice,
};
use crate::{
    image::srgb,
    math::Stop,
    raster::{Cpu, Fragments, Geometry, Holes, Shader, fragments},
    scene::{Alpha, Image, Material, Mesh, Object, Part, Scene, Texture, Wrap},
    voxel::{
        Cell, Field, Slices,
        frusta::{Lens, frame},
    },
};
use glam::{DVec3, Mat4};
use proptest::prelude::*;
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// What the literal field holds of a voxel, by (layer, y, x): colour, object, ring, inside.
type Literal = BTreeMap<(u16, u16, u16), ([u8; 3], String, u8, u8)>;

struct Slow<'a> {
    slices: &'a Slices,
    face: Face<'a>,
    fragments: Fragments,
}

impl Slow<'_> {
    /// The layer of a depth: the last border in front of it.
    fn layer(&self, depth: f32) -> u16 {
        let inner = self.slices.borders[1..self.slices.layers.len()].iter();
        inner.filter(|b| **b <= f64::from(depth)).count() as u16
    }

    /// All (depth, triangle) at a sample in a layer.
    fn hits(&self, layer: u16, [sx, sy]: [u32; 2]) -> Vec<(f32, u32)> {
        let all = self.fragments.of(sx, sy).iter().filter(|f| self.layer(f.depth) == layer);
        all.map(|f| (f.depth, f.triangle)).collect()
    }

    /// All cuts along the layer's two borders that touch a pixel: squared distance, source, weights.
    fn cuts(&self, layer: u16, x: u32, y: u32) -> Vec<(f64, u32, [f64; 3])> {
        let mut holes = Holes::new(&self.face.prepared);
        let mut all = vec![];
        for (source, corners) in self.face.soup.corners.iter().enumerate() {
            for border in [layer, layer + 1].into_iter().filter(|b| usize::from(*b) < self.slices.layers.len()) {
                let distance = self.slices.borders[usize::from(border)];
                let Some(cut) = Cut::new(corners, distance, &self.face.screen) else { continue };
                let (d, w) = cut.nearest(x, y);
                let number = self.face.soup.numbers[source];
                if meets(cut.ends, i64::from(x), i64::from(y)) && holes.solid_at(number, w) {
                    all.push((d, source as u32, w));
                }
            }
        }
        all
    }

    fn filled(&self, layer: u16, x: u32, y: u32) -> bool {
        !self.cuts(layer, x, y).is_empty() || self.face.samples_of(x, y).any(|s| !self.hits(layer, s).is_empty())
    }

    fn color(&self, shader: &Shader, layer: u16, x: u32, y: u32) -> ([u8; 3], u32) {
        let (view, geometry) = (&self.face.prepared.view, self.face.prepared.geometry);
        let mut seen = vec![];
        for sample in self.face.samples_of(x, y) {
            let nearest = self.hits(layer, sample).into_iter().reduce(|a, b| if b < a { b } else { a });
            if let Some((depth, number)) = nearest {
                let [px, py] = sample.map(|s| f64::from(s) + 0.5);
                seen.push((shader.shade(view, px, py, number).color, geometry.object_of(number), depth));
            }
        }
        if seen.is_empty() {
            let cuts = self.cuts(layer, x, y);
            let (_, source, w) = cuts.into_iter().reduce(|a, b| if (b.0, b.1) < (a.0, a.1) { b } else { a }).unwrap();
            let number = self.face.soup.numbers[source as usize];
            let point = shader.facet(&self.face.prepared.camera, number).point(w);
            seen.push((point.color, geometry.object_of(number), 0.0));
        }
        let mean = |k: usize| srgb::from_linear(seen.iter().fold(0.0, |s, c| s + c.0[k]) / seen.len() as f32);
        let votes = |o: u32| seen.iter().filter(|s| s.1 == o).count();
        let depth = |o: u32| seen.iter().filter(|s| s.1 == o).map(|s| s.2).fold(f32::INFINITY, f32::min);
        let best = |a: u32, b: u32| {
            let better =
                (votes(b), depth(a)) > (votes(a), depth(b)) || ((votes(b), depth(b)) == (votes(a), depth(a)) && b < a);
            if better { b } else { a }
        };
        ([mean(0), mean(1), mean(2)], seen.iter().map(|s| s.1).reduce(best).unwrap())
    }
}

/// The pixel of a face at (x, y), which may lie one pixel outside: found by direction, not by links.
fn locate(slices: &Slices, i: usize, x: i64, y: i64) -> Option<(usize, usize)> {
    let f = &slices.frusta[i];
    let [w, h] = f.size.map(i64::from);
    if (0..w).contains(&x) && (0..h).contains(&y) {
        return Some((i, (y * w + x) as usize));
    }
    let u = f.left + (x as f64 + 0.5) / w as f64 * (f.right_tan - f.left);
    let v = f.top - (y as f64 + 0.5) / h as f64 * (f.top - f.bottom);
    let d = f.forward + f.right * u + f.up * v;
    if slices.frusta.len() == 1 {
        return None;
    }
    let (k, g) = slices.frusta.iter().enumerate().find(|(_, g)| d.dot(g.forward) >= d.abs().max_element() - 1e-12)?;
    let z = d.dot(g.forward);
    let px = (d.dot(g.right) / z - g.left) / (g.right_tan - g.left) * w as f64;
    let py = (g.top - d.dot(g.up) / z) / (g.top - g.bottom) * h as f64;
    Some((k, (py.floor() as i64 * w + px.floor() as i64) as usize))
}

fn literal(scene: &Scene, geometry: &Geometry, slices: &Slices, n: u32, skirt: u8) -> Vec<Literal> {
    let soup = Soup::new(geometry, &slices.cell);
    let shader = Shader::new(geometry);
    let face = |f| {
        let face = Face::new(geometry, &soup, slices, f, n, &Stop::default()).unwrap();
        let fragments = fragments(&Cpu, geometry, &face.prepared.view, &facing(slices), &Stop::default()).unwrap();
        Slow { slices, face, fragments }
    };
    let faces: Vec<_> = slices.frusta.iter().map(face).collect();
    let pixels = |f: &Slow| f.face.screen.width * f.face.screen.height;
    let look = |f: &Slow, layer: u16, x: u32, y: u32, ring: u8, inside: u8| {
        let (color, object) = f.color(&shader, layer, x, y);
        (color, scene.objects[object as usize].name.clone(), ring, inside)
    };
    let mut hidden: Vec<Vec<bool>> = faces.iter().map(|f| vec![false; pixels(f) as usize]).collect();
    let mut out = vec![Literal::new(); faces.len()];
    // Filled voxels that are hidden, but not far from what is not.
    let mut candidates = vec![BTreeMap::new(); faces.len()];
    for layer in 0..slices.layers.len() as u16 {
        let filled: Vec<Vec<bool>> = faces
            .iter()
            .map(|f| {
                (0..pixels(f)).map(|i| f.filled(layer, i % f.face.screen.width, i / f.face.screen.width)).collect()
            })
            .collect();
        for (k, f) in faces.iter().enumerate() {
            let (w, h, reach) = (f.face.screen.width as i64, f.face.screen.height as i64, i64::from(skirt));
            let shown = |x: i64, y: i64| x < 0 || y < 0 || x >= w || y >= h || !hidden[k][(y * w + x) as usize];
            // Whether all pixels less than d away are hidden.
            let deep = |x: i64, y: i64, d: i64| (1 - d..d).all(|j| (1 - d..d).all(|i| !shown(x + i, y + j)));
            let inside = |x: i64, y: i64| {
                let d = (1..).find(|d| !deep(x, y, *d)).unwrap_or(0);
                let sides = [(-1, 0), (1, 0), (0, -1), (0, 1)];
                (0..4).filter(|s| deep(x + sides[*s].0, y + sides[*s].1, d)).map(|s| 1 << s).sum::<u8>()
            };
            for i in (0..pixels(f)).filter(|i| filled[k][*i as usize]) {
                let (x, y) = (i64::from(i) % w, i64::from(i) / w);
                if !hidden[k][i as usize] {
                    out[k].insert((layer, y as u16, x as u16), look(f, layer, x as u32, y as u32, 0, inside(x, y)));
                } else if (-reach..=reach).any(|dy| (-reach..=reach).any(|dx| shown(x + dx, y + dy))) {
                    candidates[k].insert((layer, y as u16, x as u16), inside(x, y));
                }
            }
        }
        let opaque =
            |k: usize, x: i64, y: i64| locate(slices, k, x, y).is_some_and(|(f, i)| filled[f][i] || hidden[f][i]);
        let next = faces.iter().enumerate().map(|(k, f)| {
            let (w, h) = (i64::from(f.face.screen.width), i64::from(f.face.screen.height));
            let inside = |v: i64, n: i64| (0..n).contains(&v);
            let neighbour = |x: i64, y: i64| {
                if inside(x, w) || inside(y, h) {
                    opaque(k, x, y)
                } else {
                    opaque(k, x, y.clamp(0, h - 1)) && opaque(k, x.clamp(0, w - 1), y)
                }
            };
            let eroded = |x: i64, y: i64| (-1..=1).all(|dy| (-1..=1).all(|dx| neighbour(x + dx, y + dy)));
            (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| eroded(x, y)).collect()
        });
        hidden = next.collect();
    }
    for ring in 1..=skirt {
        for (k, f) in faces.iter().enumerate() {
            let touches = |a: &(u16, u16, u16), b: &(u16, u16, u16)| {
                a.0.abs_diff(b.0) <= 1 && a.1.abs_diff(b.1) <= 1 && a.2.abs_diff(b.2) <= 1
            };
            let last: Vec<_> = out[k].iter().filter(|(_, v)| v.2 == ring - 1).map(|(at, _)| *at).collect();
            let reached: Vec<_> =
                candidates[k].keys().filter(|c| last.iter().any(|l| touches(c, l))).copied().collect();
            for at in reached {
                let inside = candidates[k].remove(&at).unwrap();
                out[k].insert(at, look(f, at.0, at.2.into(), at.1.into(), ring, inside));
            }
        }
    }
    out
}

fn as_literal(fields: &[Field]) -> Vec<Literal> {
    let voxel = |f: &Field, v: &crate::voxel::Voxel| {
        (
            (v.layer, v.y, v.x),
            ([v.color[0], v.color[1], v.color[2]], f.objects[v.object as usize].clone(), v.ring, v.inside),
        )
    };
    fields.iter().map(|f| f.voxels.iter().map(|v| voxel(f, v)).collect()).collect()
}

/// Objects of a triangle each, of which some have holes; every other one without has one side.
fn scene(triangles: &[([[f32; 3]; 3], [f32; 3], bool)]) -> Scene {
    let checker = Image {
        name: "checker".into(),
        width: 4,
        height: 4,
        texels: (0..16).map(|i| [200, 100, 50, if (i + i / 4) % 2 == 0 { 255 } else { 0 }]).collect(),
    };
    let texture = Texture {
        image: Arc::new(checker),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Repeat; 2],
        smooth: false,
    };
    let solid = [true, false].map(|double_sided| Arc::new(Material { double_sided, ..Material::default() }));
    let holes = Arc::new(Material {
        base_color_texture: Some(texture),
        alpha: Alpha::Mask { cutoff: 0.5 },
        ..Material::default()
    });
    let object = |(i, (corners, color, masked)): (usize, &([[f32; 3]; 3], [f32; 3], bool))| {
        let mesh = Mesh {
            positions: corners.to_vec().into(),
            uv: [vec![[0.0, 0.0], [1.5, 0.0], [0.0, 1.5]].into(), Default::default()],
            colors: vec![[color[0], color[1], color[2], 1.0]; 3].into(),
            triangles: vec![[0, 1, 2]].into(),
            ..Mesh::default()
        };
        let material = if *masked { holes.clone() } else { solid[i % 2].clone() };
        Object {
            name: format!("object {i:03}"),
            transform: Mat4::IDENTITY,
            parts: vec![Part { mesh: Arc::new(mesh), material }],
        }
    };
    Scene { objects: triangles.iter().enumerate().map(object).collect() }
}

/// A voxel's coverage: the share of its pixel's samples that meet a surface from which layers lead to it in steps of at most three, over the
/// layers of samples and of the pixel's voxels up to three behind the last of these.
fn check_coverage(geometry: &Geometry, soup: &Soup, slices: &Slices, n: u32, fields: &[Field]) {
    for (frustum, field) in slices.frusta.iter().zip(fields) {
        let face = Face::new(geometry, soup, slices, frustum, n, &Stop::default()).unwrap();
        let fragments = fragments(&Cpu, geometry, &face.prepared.view, &facing(slices), &Stop::default()).unwrap();
        let slow = Slow { slices, face, fragments };
        for v in field.voxels.iter() {
            let here = field.voxels.iter().filter(|u| (u.x, u.y) == (v.x, v.y));
            let mut layers: BTreeSet<u16> = here.map(|u| u.layer).collect();
            let last = *layers.last().unwrap();
            let of = |sample: [u32; 2]| -> Vec<u16> {
                let met = slow.fragments.of(sample[0], sample[1]).iter().map(|f| slow.layer(f.depth));
                met.filter(|l| *l <= last + 3).collect()
            };
            layers.extend(slow.face.samples_of(v.x.into(), v.y.into()).flat_map(of));
            let mut run = BTreeSet::from([v.layer]);
            while let Some(l) = layers.iter().find(|l| !run.contains(l) && run.iter().any(|r| r.abs_diff(**l) <= 3)) {
                run.insert(*l);
            }
            let samples = slow.face.samples_of(v.x.into(), v.y.into());
            let covered = samples.filter(|s| of(*s).iter().any(|l| run.contains(l))).count();
            assert_eq!(usize::from(v.color[3]), covered * 255 / (n * n) as usize, "voxel {v:?}");
        }
    }
}

fn fineness(samples: u32, skirt: u8) -> Fineness {
    Fineness { samples, skirt: skirt.into(), quarters: samples > 1 }
}

/// Quarters average to what the voxel shows, and where their samples differ they do.
fn check_quarters(fields: &[Field], n: u32) {
    for f in fields {
        assert_eq!(f.quarters.len(), if n > 1 { f.voxels.len() } else { 0 });
        for (quarters, v) in f.quarters.iter().zip(f.voxels.iter()) {
            for k in 0..3 {
                let all = quarters.map(|q| q[k]);
                let (low, high) = (all.iter().min().unwrap(), all.iter().max().unwrap());
                assert!(
                    low.saturating_sub(1) <= v.color[k] && v.color[k] <= high.saturating_add(1),
                    "{quarters:?} {v:?}"
                );
            }
            assert!(quarters.iter().all(|q| q[3] == 255));
        }
    }
}

fn check(scene: &Scene, cell: &Cell, lens: &Lens, n: u32, skirt: u8) -> Option<Slices> {
    let geometry = Geometry::new(scene);
    let stop = Stop::default();
    let soup = Soup::new(&geometry, cell);
    let slices = frame(cell, &soup.corners, lens, &stop).ok()?;
    let fields = slice(&Cpu, scene, &geometry, &soup, &slices, fineness(n, skirt), &stop).unwrap();
    for f in &fields {
        assert_eq!(f.validate(), Ok(()));
    }
    check_quarters(&fields, n);
    check_coverage(&geometry, &soup, &slices, n, &fields);
    let (ours, expect) = (as_literal(&fields), literal(scene, &geometry, &slices, n, skirt));
    for (k, (ours, expect)) in ours.iter().zip(&expect).enumerate() {
        for (key, value) in expect {
            assert_eq!(ours.get(key), Some(value), "frustum {k}, voxel {key:?}");
        }
        assert_eq!(ours.len(), expect.len(), "frustum {k}");
    }
    Some(slices)
}

fn corner(low: [f32; 3], high: [f32; 3]) -> impl Strategy<Value = [f32; 3]> {
    [low[0]..high[0], low[1]..high[1], low[2]..high[2]]
}

fn triangles(low: [f32; 3], high: [f32; 3], count: usize) -> impl Strategy<Value = Scene> {
    let one = (prop::array::uniform3(corner(low, high)), prop::array::uniform3(0.0..1.0f32), prop::bool::weighted(0.3));
    prop::collection::vec(one, 1..count).prop_map(|t| scene(&t))
}

const CELL: Cell = Cell { centre: DVec3::new(0.1, 0.2, 0.3), half: DVec3::new(0.5, 0.4, 0.45) };

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, max_shrink_iters: 40, ..ProptestConfig::default() })]

    #[test]
    fn one_frustum_agrees_with_the_definition(scene in triangles([-2.0, -1.5, -8.0], [2.0, 1.5, -0.2], 10), log in 0..3u32, skirt in 0..4u8) {
        let lens = Lens { resolution: 8, fov: 0.8, max_layers: 100, max_side: 4000 };
        check(&scene, &CELL, &lens, 1 << log, skirt);
    }

    #[test]
    fn faces_of_a_cube_agree_with_the_definition(scene in triangles([-6.0, -6.0, -6.0], [6.0, 6.0, 6.0], 10), skirt in 0..3u8) {
        let lens = Lens { resolution: 4, fov: 0.8, max_layers: 100, max_side: 4000 };
        check(&scene, &CELL, &lens, 2, skirt);
    }
}

#[test]
fn what_lies_edge_on_or_on_pixel_borders_agrees_too() {
    let quad = |a: [f32; 3], b: [f32; 3], c: [f32; 3], d: [f32; 3]| {
        [([a, b, c], [1.0, 0.0, 0.0], false), ([a, c, d], [0.0, 0.0, 1.0], false)]
    };
    // A wall through the cell's centre seen edge-on, a floor, and a wall right across.
    let t = [
        quad([0.0, -1.0, -3.0], [0.0, 1.0, -3.0], [0.0, 1.0, -9.0], [0.0, -1.0, -9.0]),
        quad([-1.0, -1.0, -3.0], [1.0, -1.0, -3.0], [1.0, -1.0, -9.0], [-1.0, -1.0, -9.0]),
        quad([-1.0, -1.0, -9.0], [1.0, -1.0, -9.0], [1.0, 1.0, -9.0], [-1.0, 1.0, -9.0]),
    ];
    let cell = Cell { centre: DVec3::ZERO, half: DVec3::splat(0.5) };
    let lens = Lens { resolution: 28, fov: 0.8, max_layers: 100, max_side: 4000 };
    let slices = check(&scene(&t.concat()), &cell, &lens, 2, 2).unwrap();
    assert_eq!(slices.frusta.len(), 1);
    assert!(slices.layers.len() > 3);
}

#[test]
fn threads_and_bytes() {
    let mut t = vec![];
    for i in 0..40u32 {
        let v = |k: u32| ((i * 37 + k * 101) % 97) as f32 / 97.0 * 8.0 - 4.0;
        let z = -3.0 - (i % 7) as f32;
        t.push(([[v(0), v(1), z], [v(2), v(3), z - 2.0], [v(4), v(5), z]], [v(6).abs() / 4.0, 0.5, 0.2], i % 5 == 0));
    }
    let (scene, stop) = (scene(&t), Stop::default());
    let geometry = Geometry::new(&scene);
    let soup = Soup::new(&geometry, &CELL);
    let lens = Lens { resolution: 200, fov: 0.8, max_layers: 100, max_side: 4000 };
    let slices = frame(&CELL, &soup.corners, &lens, &stop).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| slice(&Cpu, &scene, &geometry, &soup, &slices, fineness(2, 2), &stop).unwrap())
    };
    assert!(run(1) == run(3));
    let fields = run(2);
    let quarters = fields.iter().flat_map(|f| f.quarters.iter());
    assert!(quarters.clone().any(|q| q[0] != q[3]) && quarters.clone().any(|q| q[1] != q[2]));
    let plain = Fineness { quarters: false, ..fineness(2, 2) };
    let without = slice(&Cpu, &scene, &geometry, &soup, &slices, plain, &stop).unwrap();
    assert!(without.iter().zip(&fields).all(|(a, b)| a.quarters.is_empty() && a.voxels == b.voxels));
    stop.set();
    assert!(slice(&Cpu, &scene, &geometry, &soup, &slices, fineness(2, 2), &stop).is_err());
}
