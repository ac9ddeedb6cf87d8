//! The mesh while it is simplified.

use super::{
    Goal, Silhouette,
    contract::Link,
    cover::{Boxes, Cover, Demand},
    topology::{NONE, Topology, next, prev},
};
use crate::{
    array::Array,
    math::{Stop, Stopped},
    voxel::{
        VoxelMesh,
        assemble::split_bow_ties,
        touch::{self, Point},
    },
};

pub struct Surface {
    pub topology: Topology,
    pub cover: Cover,
    /// Vertices, quarter units.
    pub points: Vec<Point>,
    /// Vertices on seams stay.
    pub locked: Vec<bool>,
    /// Box that vertices stay in.
    pub bounds: [Point; 2],
    /// When a face around each vertex last changed.
    pub changed: Vec<u32>,
    /// Counts what was done.
    pub clock: u32,
    /// Whether alpha cuts outlines: boundaries may run out of the surface then.
    pub alpha: bool,
    pub scratch: Scratch,
}

/// Buffers of the contraction under test.
#[derive(Default)]
pub struct Scratch {
    pub star: Vec<u32>,
    pub other: Vec<u32>,
    pub new: Vec<[Point; 3]>,
    pub slots: Vec<u32>,
    /// Vertices next to `a`, marked by the number of the attempt.
    pub marks: Vec<u32>,
    pub attempt: u32,
    pub ring_a: Vec<u32>,
    pub ring_b: Vec<u32>,
    pub link: Link,
}

impl Surface {
    /// `demands`: those of the mesh's voxels.
    pub fn new(mesh: &VoxelMesh, demands: Vec<Demand>, goal: Goal) -> Self {
        let boxes = Boxes { half: 2.0 * goal.factor, skirt: goal.skirt() };
        Self {
            topology: Topology::new(mesh.vertices.len(), &mesh.faces),
            cover: Cover::new(&mesh.voxels, demands, boxes, &mesh.cover_start, mesh.cover.to_vec()),
            points: mesh.vertices.iter().map(|v| touch::point(*v)).collect(),
            locked: mesh.flags.iter().map(|f| f & 1 == 1).collect(),
            bounds: bounds(mesh, goal.skirt()),
            changed: vec![1; mesh.vertices.len()],
            clock: 1,
            alpha: goal.silhouette == Silhouette::Alpha,
            scratch: Scratch::default(),
        }
    }

    pub fn triangle(&self, face: u32) -> [Point; 3] {
        self.topology.corners(face).map(|v| self.points[v as usize])
    }

    /// The faces that are left.
    pub fn faces(&self) -> impl Iterator<Item = u32> {
        (0..self.topology.vertex.len() as u32 / 3).filter(|f| self.topology.is_live(*f))
    }

    /// Whether a vertex may lie at `p`.
    pub fn in_bounds(&self, p: Point) -> bool {
        let [low, high] = self.bounds;
        (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i])
    }

    pub fn is_live(&self, vertex: u32) -> bool {
        self.topology.corner[vertex as usize] != NONE
    }

    pub fn are_neighbours(&self, a: u32, b: u32) -> bool {
        let topology = &self.topology;
        let first = topology.corner[a as usize];
        let mut c = first;
        loop {
            if topology.at(next(c)) == b || topology.at(prev(c)) == b {
                return true;
            }
            c = topology.turn(c);
            if c == NONE || c == first {
                return false;
            }
        }
    }

    /// Squared length of the edge a–b; an integer.
    pub fn squared(&self, a: u32, b: u32) -> u64 {
        touch::squared(self.points[a as usize], self.points[b as usize]) as u64
    }

    /// Notes that faces around `v` changed: with it, all its neighbours are worth another try.
    pub fn note(&mut self, v: u32) {
        self.clock += 1;
        self.changed[v as usize] = self.clock;
        let topology = &self.topology;
        let first = topology.corner[v as usize];
        let mut c = first;
        while c != NONE {
            self.changed[topology.at(next(c)) as usize] = self.clock;
            self.changed[topology.at(prev(c)) as usize] = self.clock;
            c = topology.turn(c);
            if c == first {
                break;
            }
        }
    }

    /// Keeps only `faces`, whose lists stay as they are, and numbers what is left anew.
    pub fn select(&mut self, faces: &[u32], stop: &Stop) -> Result<(), Stopped> {
        let (mut corners, mut vertices) = self.numbered(faces);
        // Where faces are missing, two fans may be left around a vertex.
        for v in split_bow_ties(&mut corners, vertices.len(), stop)? {
            vertices.push(vertices[v as usize]);
        }
        self.topology = Topology::new(vertices.len(), &corners);
        self.cover.select(faces);
        let of = |v: &u32| *v as usize;
        self.points = vertices.iter().map(|v| self.points[of(v)]).collect();
        self.locked = vertices.iter().map(|v| self.locked[of(v)]).collect();
        self.changed = vertices.iter().map(|v| self.changed[of(v)]).collect();
        Ok(())
    }

    /// The corners of `faces` by new numbers, and the old number of each.
    fn numbered(&self, faces: &[u32]) -> (Vec<[u32; 3]>, Vec<u32>) {
        let (mut number, mut vertices) = (vec![u32::MAX; self.points.len()], Vec::new());
        let mut corner = |v: u32| {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = vertices.len() as u32;
                vertices.push(v);
            }
            *slot
        };
        let corners = faces.iter().map(|f| self.topology.corners(*f).map(&mut corner)).collect();
        (corners, vertices)
    }

    /// What is left, as a mesh over the voxels of the original `mesh`.
    pub fn to_mesh(&self, mesh: &VoxelMesh, goal: Goal) -> VoxelMesh {
        let kept: Vec<u32> = self.faces().collect();
        let (faces, vertices) = self.numbered(&kept);
        let place = |v: &u32| {
            let p = self.points[*v as usize];
            [p[0] as i32, p[1] as i32, (p[2] / 4.0) as i32]
        };
        let (mut cover_start, mut cover) = (vec![0], Vec::new());
        for face in kept {
            let from = cover.len();
            cover.extend_from_slice(self.cover.list(face));
            cover[from..].sort_unstable();
            cover_start.push(cover.len() as u32);
        }
        VoxelMesh {
            frustum: mesh.frustum,
            vertices: vertices.iter().map(place).collect(),
            flags: vertices.iter().map(|v| u8::from(self.locked[*v as usize])).collect(),
            faces: faces.into(),
            cover_start: cover_start.into(),
            cover: cover.into(),
            voxels: Array::clone(&mesh.voxels),
            quarters: Array::clone(&mesh.quarters),
            factor: goal.factor,
            alpha: goal.silhouette == Silhouette::Alpha,
        }
    }
}

/// Box around the mesh's vertices, and `skirt` beyond it to the sides, quarter units.
fn bounds(mesh: &VoxelMesh, skirt: f64) -> [Point; 2] {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for p in mesh.vertices.iter().map(|v| touch::point(*v)) {
        for i in 0..3 {
            bounds[0][i] = bounds[0][i].min(p[i]);
            bounds[1][i] = bounds[1][i].max(p[i]);
        }
    }
    for i in 0..2 {
        bounds[0][i] -= skirt;
        bounds[1][i] += skirt;
    }
    bounds
}
