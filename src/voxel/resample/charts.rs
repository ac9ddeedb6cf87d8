//! Cutting a mesh into charts: faces that share one piece of texture.
//!
//! A chart's texel coordinates are its vertices' voxel-space coordinates with one axis left out: the layer for faces
//! that look at the cell (their texels are the field's own pixels), x or y for walls. So neighbouring faces continue
//! each other's texels although they are not coplanar, and a texel is about a voxel's side wherever it lies. A
//! renderer interpolates linearly in world space over each triangle; [`super::place`] accounts for that.
//!
//! Always: each face is in exactly one chart; no two faces of a chart own the same texel; faces whose texels touch
//! either share a vertex or are neighbours in space too, so that filtering mixes only colours that belong together.

use super::grid::{REACH, TexelOwners, signed_distance};
use super::place::Space;
use crate::math::{Stop, Stopped};
use glam::{DVec2, DVec3};
use std::collections::VecDeque;

/// A face joins a chart whose left out axis makes at least this cosine with its normal.
const JOIN: f64 = 0.4;
/// A face begins a chart that looks at the cell where the layer axis makes this cosine with its normal.
const FRONT: f64 = 0.5;
/// Texels at the border of two faces without a common vertex may lie this many voxel sides apart, not more.
const APART: f64 = 4.0;
/// Depth ratio within a face from which on its texels are made smaller: the near end is drawn larger by that ratio.
const RATIO: f64 = 1.12;

/// Which voxel-space axis a chart leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    X,
    Y,
    Layer,
}

impl Axis {
    fn component(self, n: DVec3) -> f64 {
        match self {
            Self::X => n.x,
            Self::Y => n.y,
            Self::Layer => n.z,
        }
    }

    /// How much each axis counts in distances between a texel of the chart and voxels. Simplification moves a face
    /// along its normal, by more than a voxel where it is large; the voxel that a texel should show is the one at the
    /// same place of the chart, so the axis that the chart leaves out counts a quarter. (The paper counts all alike;
    /// measured on the built-in city at factor 2 this is 0.7 dB better.) It still tells surfaces apart.
    pub fn weight(self) -> DVec3 {
        const ACROSS: f64 = 1.0 / 16.0;
        match self {
            Self::X => DVec3::new(ACROSS, 1.0, 1.0),
            Self::Y => DVec3::new(1.0, ACROSS, 1.0),
            Self::Layer => DVec3::new(1.0, 1.0, ACROSS),
        }
    }

    /// The two axes that are kept.
    pub fn flatten(self, q: DVec3) -> DVec2 {
        match self {
            Self::X => DVec2::new(q.z, q.y),
            Self::Y => DVec2::new(q.x, q.z),
            Self::Layer => DVec2::new(q.x, q.y),
        }
    }
}

/// Faces with a common piece of texture.
pub struct Chart {
    pub axis: Axis,
    /// Texels per unit of the metric.
    pub scale: f64,
    pub faces: Vec<u32>,
    /// Which face each texel belongs to.
    pub grid: TexelOwners,
}

impl Chart {
    /// Texel coordinates of a vertex in the grid's frame.
    pub fn uv(&self, space: &Space, vertex: u32) -> DVec2 {
        self.axis.flatten(space.metric(vertex)) * self.scale
    }

    pub fn triangle(&self, space: &Space, face: u32) -> [DVec2; 3] {
        space.mesh.faces[face as usize].map(|v| self.uv(space, v))
    }
}

/// What decides in which chart a face may lie.
struct Shape {
    /// Unit normal in the metric; zero for a degenerate face.
    normal: DVec3,
    area: f64,
    /// Texels per unit of the metric are `density · √2^class`.
    class: u32,
}

fn shape(space: &Space, face: u32) -> Shape {
    let v = space.mesh.faces[face as usize];
    let q = v.map(|v| space.metric(v));
    let n = (q[1] - q[0]).cross(q[2] - q[0]);
    let area = n.length();
    let z = v.map(|v| space.depth(v));
    let ratio = z[0].max(z[1]).max(z[2]) / z[0].min(z[1]).min(z[2]);
    let (mut class, mut reached) = (0, RATIO);
    while reached < ratio && class < 6 {
        class += 1;
        reached *= std::f64::consts::SQRT_2;
    }
    Shape { normal: if area > 1e-9 { n / area } else { DVec3::ZERO }, area, class }
}

fn axis_of(normal: DVec3) -> Axis {
    let a = normal.abs();
    if a.z >= FRONT || normal == DVec3::ZERO {
        Axis::Layer
    } else if a.x >= a.y {
        Axis::X
    } else {
        Axis::Y
    }
}

/// The faces across the three edges of each face (`u32::MAX`: none), the nearest by number where there are several.
fn neighbours(faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(faces.len() * 3);
    for (f, v) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (v[k], v[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), f as u32, k as u8));
        }
    }
    edges.sort_unstable();
    let mut across = vec![[u32::MAX; 3]; faces.len()];
    for w in edges.windows(2) {
        if (w[0].0, w[0].1) == (w[1].0, w[1].1) {
            across[w[0].2 as usize][w[0].3 as usize] = w[1].2;
            across[w[1].2 as usize][w[1].3 as usize] = w[0].2;
        }
    }
    across
}

/// Cuts the mesh into charts of at most `max_size` texels a side, margins of `margin` texels included.
/// `density` is in texels per voxel side.
pub fn cut(space: &Space, density: f64, margin: u32, max_size: u32, stop: &Stop) -> Result<Vec<Chart>, Stopped> {
    let faces = &space.mesh.faces;
    let shapes: Vec<_> = (0..faces.len() as u32).map(|f| shape(space, f)).collect();
    let across = neighbours(faces);
    // The largest faces first: they decide the axis of their surroundings.
    let mut seeds: Vec<u32> = (0..faces.len() as u32).collect();
    seeds.sort_by(|a, b| shapes[*b as usize].area.total_cmp(&shapes[*a as usize].area).then(a.cmp(b)));
    let room = f64::from(max_size - 2 * margin - 2);
    let mut charts: Vec<Chart> = Vec::new();
    let mut taken = vec![false; faces.len()];
    // Number of the last chart that refused this face.
    let mut refused = vec![u32::MAX; faces.len()];
    let mut queue = VecDeque::new();
    for seed in seeds {
        if taken[seed as usize] {
            continue;
        }
        stop.check()?;
        let number = charts.len() as u32;
        let like = &shapes[seed as usize];
        let axis = axis_of(like.normal);
        let mut chart = Chart { axis, scale: density, faces: Vec::new(), grid: TexelOwners::default() };
        for _ in 0..like.class {
            chart.scale *= std::f64::consts::SQRT_2;
        }
        let size = extent(&chart.triangle(space, seed));
        chart.scale *= (room / size.max(1e-9)).min(1.0);
        let sign = axis.component(like.normal) >= 0.0;
        queue.push_back(seed);
        let mut polled = 0;
        while let Some(face) = queue.pop_front() {
            let f = face as usize;
            if taken[f] || refused[f] == number {
                continue;
            }
            let s = &shapes[f];
            let c = axis.component(s.normal);
            let fits = s.normal == DVec3::ZERO || (c.abs() >= JOIN && (c >= 0.0) == sign && s.class == like.class);
            if !(face == seed || fits && extends(&chart, space, face, room)) {
                refused[f] = number;
                continue;
            }
            claim(&mut chart, space, face);
            chart.faces.push(face);
            taken[f] = true;
            queue.extend(across[f].iter().filter(|n| **n != u32::MAX));
            polled += 1;
            if polled % 4096 == 0 {
                stop.check()?;
            }
        }
        charts.push(chart);
    }
    Ok(charts)
}

/// The longer side of a triangle's bounding box.
fn extent(t: &[DVec2; 3]) -> f64 {
    (t[0].max(t[1]).max(t[2]) - t[0].min(t[1]).min(t[2])).max_element()
}

/// Whether `face` can lie in `chart`: within its largest size, over no other face, and beside only what is near it.
fn extends(chart: &Chart, space: &Space, face: u32, room: f64) -> bool {
    let t = chart.triangle(space, face);
    let corners = space.mesh.faces[face as usize];
    if !chart.grid.stays_within(&t, room) {
        return false;
    }
    chart.grid.each(&t, REACH, |at, owner| {
        let Some((other, theirs)) = owner else { return true };
        let ours = signed_distance(&t, at);
        if ours < -0.25 && theirs < -0.25 {
            return false;
        }
        let joined = space.mesh.faces[other as usize].iter().any(|v| corners.contains(v));
        if joined || ours > REACH {
            return true;
        }
        let place = |face, t: &[DVec2; 3]| space.place(face, t, at) * space.unit();
        place(face, &t).distance(place(other, &chart.triangle(space, other))) <= APART
    })
}

/// Gives `face` the texels that lie deeper in it, or nearer to it, than in or to the faces before.
fn claim(chart: &mut Chart, space: &Space, face: u32) {
    let t = chart.triangle(space, face);
    chart.grid.make_room(&t);
    chart.grid.claim(&t, REACH, face);
}
