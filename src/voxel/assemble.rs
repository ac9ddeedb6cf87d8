//! From loose quads to connected meshes: split vertices, group by voxel, number anew.
//!
//! A mesh holds only what is its own, so that it keeps its bytes while other meshes change.

use super::{
    Field, VoxelMesh,
    sites::{Emitted, Quad, Sites},
};
use crate::math::{Stop, Stopped};

/// The connected meshes of one frustum with their names.
pub(super) fn assemble(
    field: &Field,
    sites: &Sites,
    emitted: &Emitted,
    stop: &Stop,
) -> Result<Vec<(String, VoxelMesh)>, Stopped> {
    let quads = &emitted.quads;
    let mut corners: Vec<[u32; 3]> = Vec::with_capacity(quads.len() * 2);
    for q in quads {
        let [a, b, c, d] = q.vertices;
        corners.extend([[a, b, c], [a, c, d]]);
    }
    let copies = split_bow_ties(&mut corners, sites.vertex_count(), stop)?;
    stop.check()?;

    // A mesh is named by its smallest voxel. Every face names voxels that touch, so faces need not be asked.
    let mut group: Vec<u32> = (0..sites.own_count() as u32).collect();
    for [a, b] in &emitted.touching {
        unite(&mut group, *a, *b);
    }
    // Roots are smallest members, so one ascending pass flattens the forest and numbers the meshes in order.
    let mut mesh_of = vec![0; group.len()];
    let mut roots = Vec::new();
    for v in 0..group.len() {
        let root = find(&mut group, v as u32) as usize;
        if root == v {
            mesh_of[v] = roots.len() as u32;
            roots.push(v);
        } else {
            mesh_of[v] = mesh_of[root];
        }
    }
    stop.check()?;
    let quad_lists = buckets(roots.len(), quads.iter().map(|q| mesh_of[first_own(sites, q) as usize]));
    let voxel_lists = buckets(roots.len(), mesh_of.iter().copied());

    let mut vertex_number = vec![u32::MAX; sites.vertex_count() + copies.len()];
    let mut voxel_number = vec![0u32; sites.own_count()];
    let mut meshes = Vec::with_capacity(roots.len());
    for (m, root) in roots.iter().enumerate() {
        if m % 1024 == 0 {
            stop.check()?;
        }
        let members = voxel_lists.of(m);
        for (i, v) in members.iter().enumerate() {
            voxel_number[*v as usize] = i as u32;
        }
        let (mut vertices, mut flags, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        let (mut cover_start, mut cover) = (vec![0], Vec::new());
        for q in quad_lists.of(m) {
            let quad = &quads[*q as usize];
            let mut named: Vec<u32> =
                quad.covers.iter().filter(|s| sites.is_own(**s)).map(|s| voxel_number[*s as usize]).collect();
            named.sort_unstable();
            named.dedup();
            for half in 0..2 {
                faces.push(corners[*q as usize * 2 + half].map(|v| {
                    let slot = &mut vertex_number[v as usize];
                    if *slot == u32::MAX {
                        *slot = vertices.len() as u32;
                        let original = copies.get((v as usize).wrapping_sub(sites.vertex_count())).copied();
                        let (position, locked) = sites.vertex(original.unwrap_or(v));
                        vertices.push(position);
                        flags.push(u8::from(locked));
                    }
                    *slot
                }));
                cover.extend(&named);
                cover_start.push(cover.len() as u32);
            }
        }
        let smallest = field.voxels[*root];
        let name = format!("f{}-l{:05}-y{:05}-x{:05}", field.frustum, smallest.layer, smallest.y, smallest.x);
        let mesh = VoxelMesh {
            frustum: field.frustum,
            vertices: vertices.into(),
            flags: flags.into(),
            faces: faces.into(),
            cover_start: cover_start.into(),
            cover: cover.into(),
            voxels: members.iter().map(|v| field.voxels[*v as usize]).collect(),
            quarters: members.iter().filter_map(|v| field.quarters.get(*v as usize)).copied().collect(),
            factor: 0.0,
            alpha: false,
        };
        meshes.push((name, mesh));
    }
    Ok(meshes)
}

fn first_own(sites: &Sites, quad: &Quad) -> u32 {
    quad.covers.into_iter().find(|s| sites.is_own(*s)).expect("a quad covers a voxel of its field")
}

fn find(group: &mut [u32], mut v: u32) -> u32 {
    while group[v as usize] != v {
        group[v as usize] = group[group[v as usize] as usize];
        v = group[v as usize];
    }
    v
}

fn unite(group: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(group, a), find(group, b));
    group[a.max(b) as usize] = a.min(b);
}

/// Item numbers grouped by a key, in order.
struct Buckets {
    start: Vec<u32>,
    items: Vec<u32>,
}

impl Buckets {
    fn of(&self, key: usize) -> &[u32] {
        &self.items[self.start[key] as usize..self.start[key + 1] as usize]
    }
}

fn buckets(count: usize, keys: impl Iterator<Item = u32> + Clone) -> Buckets {
    let mut start = vec![0u32; count + 2];
    let mut total = 0;
    for k in keys.clone() {
        start[k as usize + 2] += 1;
        total += 1;
    }
    for k in 2..start.len() {
        start[k] += start[k - 1];
    }
    let mut items = vec![0; total];
    for (i, k) in keys.enumerate() {
        let at = &mut start[k as usize + 1];
        items[*at as usize] = i as u32;
        *at += 1;
    }
    start.pop();
    Buckets { start, items }
}

/// Gives every fan but the first around a vertex a vertex of its own. Returns, for the vertices added
/// (numbered from `vertex_count`), the one that each is a copy of.
pub fn split_bow_ties(faces: &mut [[u32; 3]], vertex_count: usize, stop: &Stop) -> Result<Vec<u32>, Stopped> {
    let corners = buckets(vertex_count, faces.iter().flatten().copied());
    let mut copies = Vec::new();
    let mut fan = Vec::new();
    for v in 0..vertex_count as u32 {
        if v % 65536 == 0 {
            stop.check()?;
        }
        let around = corners.of(v as usize);
        if around.len() < 2 {
            continue;
        }
        // Two faces are in one fan if they share an edge at v; degrees are small, so pairs are compared.
        fan.clear();
        fan.extend(0..around.len());
        let ends = |c: u32, faces: &[[u32; 3]]| {
            let (f, i) = (faces[c as usize / 3], c as usize % 3);
            (f[(i + 1) % 3], f[(i + 2) % 3])
        };
        for i in 0..around.len() {
            let next = ends(around[i], faces).0;
            for j in 0..around.len() {
                if next == ends(around[j], faces).1 && fan[i] != fan[j] {
                    let (old, new) = (fan[i].max(fan[j]), fan[i].min(fan[j]));
                    fan.iter_mut().filter(|f| **f == old).for_each(|f| *f = new);
                }
            }
        }
        for first in 1..around.len() {
            if fan[first] != first {
                continue;
            }
            let copy = (vertex_count + copies.len()) as u32;
            copies.push(v);
            for i in first..around.len() {
                if fan[i] == first {
                    faces[around[i] as usize / 3][around[i] as usize % 3] = copy;
                }
            }
        }
    }
    Ok(copies)
}
