//! Textures of a simplified mesh, taken from the windows (Chen et al. 2003, sections 3.1.4 and 3.2).
//!
//! A face's views are those that see its three corners, and most of its points. Each face takes one of them: the centre's where it can, else one of few views
//! that together show the others. The paper blends two at run time; colours here are without light and the same from everywhere, so that blending would
//! only blur. Faces that no view sees take colours of the original's vertices: the paper's resampled maps.

use super::{
    simplified::Simplified,
    weights::{SLACK, Windows},
};
use crate::capture::dilate;
use glam::{DVec2, DVec3};

/// A part of a window, or resampled colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Number of the window; `None` for resampled colours.
    pub window: Option<u32>,
    /// Pixel of the window that is the first of the patch.
    pub origin: [u32; 2],
    pub width: u32,
    pub height: u32,
    /// sRGB, row by row from the top.
    pub texels: Vec<[u8; 4]>,
}

/// A stand-in's mesh with its textures, about the cell's centre.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textured {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Texels from the upper left corner of the vertex's patch.
    pub uv: Vec<[f32; 2]>,
    /// Depth in the patch's window, metres, 1 for resampled colours. Texture coordinates are exact where u·depth, v·depth and depth are interpolated along the
    /// face and divided: projective texture mapping.
    pub depth: Vec<f32>,
    /// Number of the vertex's patch.
    pub patch: Vec<u32>,
    /// Counter-clockwise seen from the front; corners of one triangle have one patch.
    pub triangles: Vec<[u32; 3]>,
    pub patches: Vec<Patch>,
}

/// How textures are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texturing {
    /// By how much the collapse may have moved the surface, in pixels of parallax.
    pub moved: f64,
    /// c: the cell's radius, metres.
    pub radius: f64,
}

/// Texels around what a patch must show.
const GUTTER: u32 = 2;
/// A face takes the centre's picture unless another shows it this many times larger.
const LARGER: f64 = 4.0;
/// Texels of a patch for each that its faces show, at most.
const SPARSE: f64 = 20.0;
/// Side of a face's block of resampled colours, texels.
const BLOCK: u32 = 4;
/// Blocks in a row.
const ROW: u32 = 64;
/// The share of a face that may be hidden in a view that shows it.
const HIDDEN: f64 = 0.1;
/// Points along a face's side at which it is looked for, at most.
const POINTS: u32 = 12;

/// The textured mesh of what a collapse left. There is at least one window. `single`: all faces take the first window, but for those
/// that face it and are hidden.
pub fn texture(mesh: &Simplified, windows: &Windows, single: bool, how: &Texturing) -> Textured {
    let triangles = &mesh.triangles;
    let views: Vec<u32> = triangles.iter().map(|t| views_of(mesh, *t, windows, how)).collect();
    let chosen = choose(mesh, triangles, &views, windows, single);
    let mut out = Textured::default();
    // The patch of each window that a face uses.
    let mut patch_of = vec![None; windows.0.len()];
    for (k, window) in windows.0.iter().enumerate() {
        let users = triangles.iter().zip(&chosen).filter(|(_, chosen)| **chosen == Some(k as u32));
        let users: Vec<[u32; 3]> = users.map(|(t, _)| *t).collect();
        let Some((min, max)) = extent(mesh, windows, k as u32, &users) else { continue };
        let (w, h) = (window.view.width, window.view.height);
        let low = |v: f64, n: u32| (v.max(0.0) as u32).min(n - 1).saturating_sub(GUTTER);
        let high = |v: f64, n: u32| ((v.max(0.0) as u32).min(n - 1) + GUTTER + 1).min(n);
        let origin = [low(min.x, w), low(min.y, h)];
        let (width, height) = (high(max.x, w) - origin[0], high(max.y, h) - origin[1]);
        let mut texels: Vec<[u8; 4]> = window.color.to_vec();
        let known: Vec<bool> = texels.iter().map(|c| c[3] != 0).collect();
        dilate(&mut texels, &known, w as usize);
        let cut = (0..height).flat_map(|y| {
            let at = ((origin[1] + y) * w + origin[0]) as usize;
            texels[at..at + width as usize].iter().map(|[r, g, b, _]| [*r, *g, *b, 255])
        });
        let texels = cut.collect();
        patch_of[k] = Some(out.patches.len() as u32);
        out.patches.push(Patch { window: Some(k as u32), origin, width, height, texels });
    }
    let mut placer = Placer::new(mesh, windows, &patch_of);
    let mut unseen = Vec::new();
    for (t, view) in triangles.iter().zip(&chosen) {
        match view.and_then(|k| patch_of[k as usize].map(|patch| (k, patch))) {
            Some((k, patch)) => {
                let corners = t.map(|v| placer.vertex(&mut out, v, k, patch));
                out.triangles.push(corners);
            }
            None => {
                unseen.push(out.triangles.len());
                out.triangles.push(*t);
            }
        }
    }
    resample(mesh, &unseen, &mut out);
    out
}

/// The rectangle of a window in which triangles lie, pixels; `None` where there are none.
fn extent(mesh: &Simplified, windows: &Windows, k: u32, triangles: &[[u32; 3]]) -> Option<(DVec2, DVec2)> {
    let on = |v: &u32| {
        let (x, y, _) = windows.0[k as usize].view.project(mesh.positions[*v as usize]);
        DVec2::new(x, y)
    };
    let all = triangles.as_flattened().iter().map(on);
    all.map(|p| (p, p)).reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
}

/// The windows that see a face: all of its corners, and most of its points.
fn views_of(mesh: &Simplified, t: [u32; 3], windows: &Windows, how: &Texturing) -> u32 {
    let all = t.iter().fold(u32::MAX, |bits, v| bits & mesh.views[*v as usize]);
    let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
    let sees = |k: &u32| {
        let window = &windows.0[*k as usize];
        let pixel = window.pixel();
        let on = |p: DVec3| {
            let (x, y, _) = window.view.project(p);
            DVec2::new(x, y)
        };
        let (p, q, r) = (on(a), on(b), on(c));
        if (q - p).perp_dot(r - p) >= 0.0 {
            // Rows count downwards: a front turns clockwise in the picture.
            return false;
        }
        let longest = p.distance(q).max(q.distance(r)).max(r.distance(p));
        let n = (longest.ceil() as u32).clamp(1, POINTS);
        let (mut hidden, mut count) = (0, 0);
        for i in 0..n {
            for j in 0..n - i {
                let (s, u) = ((f64::from(i) + 1.0 / 3.0) / f64::from(n), (f64::from(j) + 1.0 / 3.0) / f64::from(n));
                let point = a + (b - a) * s + (c - a) * u;
                let z = (point - window.view.eye).dot(window.view.forward);
                // The collapse moved the surface in depth by so many pixels of parallax.
                let slack = mesh.error + SLACK * pixel * z + how.moved * pixel * z * z / how.radius;
                hidden += u32::from(window.sees(point, slack).is_none());
                count += 1;
            }
        }
        f64::from(hidden) <= HIDDEN * f64::from(count)
    };
    (0..windows.0.len() as u32).filter(|k| all >> k & 1 == 1).filter(sees).fold(0, |bits, k| bits | 1 << k)
}

/// The window of each face. The centre's where it sees the face or, for meshes of one view, where the face turns its back to it and continues the
/// picture's outline. The other faces take as few windows as a greedy cover finds: again and again the one that shows the most of what is left.
fn choose(
    mesh: &Simplified,
    triangles: &[[u32; 3]],
    views: &[u32],
    windows: &Windows,
    single: bool,
) -> Vec<Option<u32>> {
    let area = |t: &[u32; 3], k: u32| {
        let [p, q, r] = t.map(|v| {
            let (x, y, _) = windows.0[k as usize].view.project(mesh.positions[v as usize]);
            DVec2::new(x, y)
        });
        -(q - p).perp_dot(r - p)
    };
    let mut out = vec![None; triangles.len()];
    let mut left: Vec<usize> = Vec::new();
    for (i, t) in triangles.iter().enumerate() {
        let seen = views[i] & 1 == 1;
        if single && (seen || area(t, 0) <= 0.0)
            || seen && (1..windows.0.len() as u32).all(|k| views[i] >> k & 1 == 0 || area(t, 0) * LARGER >= area(t, k))
        {
            out[i] = Some(0);
        } else if !single && views[i] != 0 {
            left.push(i);
        }
    }
    while !left.is_empty() {
        let shown =
            |k: u32| left.iter().filter(|i| views[**i] >> k & 1 == 1).map(|i| area(&triangles[*i], k)).sum::<f64>();
        let best =
            (0..windows.0.len() as u32).map(|k| (shown(k), k)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((shows, best)) = best.filter(|b| b.0 > 0.0) else { break };
        let gained: Vec<[u32; 3]> =
            left.iter().filter(|i| views[**i] >> best & 1 == 1).map(|i| triangles[*i]).collect();
        let Some((min, max)) = extent(mesh, windows, best, &gained) else { break };
        let texels = (max - min + f64::from(2 * GUTTER)).element_product();
        // A few faces far apart: blocks of their own are smaller than the picture around them all.
        if texels > SPARSE * shows && texels > f64::from(BLOCK * BLOCK) * gained.len() as f64 {
            break;
        }
        left.retain(|i| {
            let sees = views[*i] >> best & 1 == 1;
            if sees {
                out[*i] = Some(best);
            }
            !sees
        });
    }
    out
}

/// Vertices of the result: one for each pair of an original's and a patch.
struct Placer<'a> {
    mesh: &'a Simplified,
    windows: &'a Windows,
    /// By patch, then vertex.
    known: Vec<Vec<u32>>,
}

impl<'a> Placer<'a> {
    fn new(mesh: &'a Simplified, windows: &'a Windows, patches: &[Option<u32>]) -> Self {
        let used = patches.iter().flatten().count();
        Self { mesh, windows, known: vec![vec![u32::MAX; mesh.positions.len()]; used] }
    }

    fn vertex(&mut self, out: &mut Textured, v: u32, window: u32, patch: u32) -> u32 {
        let slot = &mut self.known[patch as usize][v as usize];
        if *slot == u32::MAX {
            let p = self.mesh.positions[v as usize];
            let (x, y, z) = self.windows.0[window as usize].view.project(p);
            let origin = out.patches[patch as usize].origin;
            *slot = out.positions.len() as u32;
            out.positions.push(p.as_vec3().to_array());
            out.uv.push([(x - f64::from(origin[0])) as f32, (y - f64::from(origin[1])) as f32]);
            out.depth.push(z as f32);
            out.patch.push(patch);
        }
        *slot
    }
}

/// Blocks of interpolated vertex colours for the triangles `unseen` of `out`, whose corners are still the mesh's vertices.
fn resample(mesh: &Simplified, unseen: &[usize], out: &mut Textured) {
    if unseen.is_empty() {
        return;
    }
    let n = unseen.len() as u32;
    let (width, height) = (n.min(ROW) * BLOCK, n.div_ceil(ROW) * BLOCK);
    let mut texels = vec![[0, 0, 0, 255]; (width * height) as usize];
    let patch = out.patches.len() as u32;
    for (i, t) in unseen.iter().enumerate() {
        let (x0, y0) = (i as u32 % ROW * BLOCK, i as u32 / ROW * BLOCK);
        let colors = out.triangles[*t].map(|v| mesh.colors[v as usize]);
        let side = (BLOCK - 1) as f32;
        for y in 0..BLOCK {
            for x in 0..BLOCK {
                let (s, u) = (x as f32 / side, y as f32 / side);
                // Beyond the slanted side the nearest point on it.
                let over = ((s + u - 1.0) * 0.5).max(0.0);
                let (s, u) = ((s - over).clamp(0.0, 1.0), (u - over).clamp(0.0, 1.0));
                let w = [1.0 - s - u, s, u];
                let mix = |k: usize| (0..3).map(|c| f32::from(colors[c][k]) * w[c]).sum::<f32>().round() as u8;
                texels[((y0 + y) * width + x0 + x) as usize] = [mix(0), mix(1), mix(2), 255];
            }
        }
        let (x, y) = (x0 as f32 + 0.5, y0 as f32 + 0.5);
        let first = out.positions.len() as u32;
        for (v, uv) in out.triangles[*t].into_iter().zip([[x, y], [x + side, y], [x, y + side]]) {
            out.positions.push(mesh.positions[v as usize].as_vec3().to_array());
            out.uv.push(uv);
            out.depth.push(1.0);
            out.patch.push(patch);
        }
        out.triangles[*t] = [first, first + 1, first + 2];
    }
    out.patches.push(Patch { window: None, origin: [0, 0], width, height, texels });
}
