//! The meshing operator: triangles that cover a layered voxel field (Jeschke and Wimmer 2002, section 5).
//!
//! Every voxel has four vertices at the quarter points of its pixel. A *previous* layer is the nearer one. Three phases
//! (figures 9 to 11), and two of our own, make quads:
//! (a) in the current layer, over one, two or four neighbouring voxels, where the previous layer leaves one of them open;
//! (b) walls between a voxel and the one before it, towards each side that is open in the previous layer, unless what
//!     is open there is hidden: the paper builds these walls too, the far side of every steep surface;
//! (c) walls that join those of two neighbours;
//! (d) over a voxel that no other face names;
//! (e) slanted walls from a voxel whose surface draws back behind it to the next one inwards and a layer farther.
//!
//! What always holds: every voxel is named by a face that touches it; an edge has at most two faces, of opposite direction;
//! around a vertex there is one fan of faces; faces in a layer are counter-clockwise seen from the cell's centre and walls
//! agree with them (slanted walls so show the centre their back). A voxel belongs to one mesh only: voxels that touch, if only
//! at a corner, are in one mesh. A mesh may so have parts that share no vertex; simplification needs to see them together, for
//! often one is within the tolerance of the other.
//!
//! Where an image continues in another frustum, its border voxels act as one more row or column whose vertices are moved
//! onto the seam; both frusta so end in the same seam vertices, which are locked.

pub use super::sites::CoverError;

use super::{
    Field, Side, Slices, Voxel, VoxelMesh,
    sites::{Emitted, Quad, Site, Sites},
};
use crate::math::{Stop, Stopped};
use std::ops::Range;

/// The connected meshes over all `fields`, with their names, sorted by name.
///
/// A name `f{frustum}-l{layer}-y{y}-x{x}` is that of the mesh's smallest voxel.
pub fn cover_meshes(slices: &Slices, fields: &[&Field], stop: &Stop) -> Result<Vec<(String, VoxelMesh)>, CoverError> {
    let mut of: Vec<Option<&Field>> = vec![None; slices.frusta.len()];
    for field in fields {
        let slot = of
            .get_mut(field.frustum as usize)
            .ok_or(CoverError::Frustum { frustum: field.frustum, count: slices.frusta.len() })?;
        if slot.replace(field).is_some() {
            return Err(CoverError::Twice(field.frustum));
        }
        check(slices, field)?;
    }
    let mut meshes = Vec::new();
    for field in of.iter().flatten() {
        let sites = Sites::new(slices, &of, field)?;
        let emitted = emit(&sites, stop)?;
        meshes.extend(super::assemble::assemble(field, &sites, &emitted, stop)?);
    }
    meshes.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(meshes)
}

fn check(slices: &Slices, field: &Field) -> Result<(), CoverError> {
    let frustum = field.frustum;
    let [width, height] = slices.frusta[frustum as usize].size;
    for v in field.voxels.iter() {
        if u32::from(v.x) >= width || u32::from(v.y) >= height {
            return Err(CoverError::Outside { frustum, x: v.x, y: v.y, width, height });
        }
    }
    let key = |v: &Voxel| (v.layer, v.y, v.x);
    if !field.voxels.windows(2).all(|w| key(&w[0]) < key(&w[1])) {
        return Err(CoverError::Unsorted(frustum));
    }
    Ok(())
}

/// Corners of a voxel; bit 0: right, bit 1: bottom.
const TL: u32 = 0;
const TR: u32 = 1;
const BL: u32 = 2;
const BR: u32 = 3;

/// Site numbers of one layer by pixel, with two pixels of margin, 0 where there is none.
struct SiteGrid {
    width: i32,
    cells: Vec<u32>,
    used: Vec<usize>,
}

impl SiteGrid {
    fn new(size: [i32; 2]) -> Self {
        let (w, h) = (size[0] + 4, size[1] + 4);
        Self { width: w, cells: vec![0; w as usize * h as usize], used: Vec::new() }
    }

    fn at(&self, x: i32, y: i32) -> Option<u32> {
        self.cells[((y + 2) * self.width + x + 2) as usize].checked_sub(1)
    }

    fn fill(&mut self, sites: &[Site], numbers: impl Iterator<Item = u32>) {
        for i in self.used.drain(..) {
            self.cells[i] = 0;
        }
        for n in numbers {
            let s = sites[n as usize];
            let i = ((s.y + 2) * self.width + s.x + 2) as usize;
            self.cells[i] = n + 1;
            self.used.push(i);
        }
    }
}

/// The quads of all phases, layer by layer.
fn emit(sites: &Sites, stop: &Stop) -> Result<Emitted, Stopped> {
    let mut quads = Vec::with_capacity(sites.own * 4);
    let mut touching = Vec::new();
    let (mut cur, mut prev) = (SiteGrid::new(sites.size), SiteGrid::new(sites.size));
    let layer_range = |range: Range<usize>, layer: u16| {
        let slice = &sites.sites[range.clone()];
        let first = range.start + slice.partition_point(|s| s.layer < layer);
        let last = range.start + slice.partition_point(|s| s.layer <= layer);
        first as u32..last as u32
    };
    let all = |layer: u16| layer_range(0..sites.own, layer).chain(layer_range(sites.own..sites.sites.len(), layer));
    let mut layers: Vec<u16> = sites.sites.iter().map(|s| s.layer).collect();
    layers.sort_unstable();
    layers.dedup();
    let mut before = None;
    for layer in layers {
        std::mem::swap(&mut cur, &mut prev);
        if before != layer.checked_sub(1) || layer == 0 {
            prev.fill(&sites.sites, std::iter::empty());
        }
        cur.fill(&sites.sites, all(layer));
        before = Some(layer);
        for (i, site) in all(layer).enumerate() {
            if i % 65536 == 0 {
                stop.check()?;
            }
            faces_of(sites, &cur, &prev, site, &mut quads);
            if sites.is_own(site) {
                let Site { x, y, .. } = sites.sites[site as usize];
                // Every pair once: from the later voxel to the earlier.
                let earlier = [(-1, 0), (-1, -1), (0, -1), (1, -1)].into_iter().map(|(i, j)| cur.at(x + i, y + j));
                let nearer = (0..9).map(|k| prev.at(x + k % 3 - 1, y + k / 3 - 1));
                let own = |other: &u32| sites.is_own(*other);
                touching.extend(earlier.chain(nearer).flatten().filter(own).map(|other| [other, site]));
            }
        }
    }
    let mut named = vec![false; sites.own];
    for q in &quads {
        for s in q.covers {
            if sites.is_own(s) {
                named[s as usize] = true;
            }
        }
    }
    for site in (0..sites.own as u32).filter(|s| !named[*s as usize]) {
        quads.push(self_face(site));
    }
    Ok(Emitted { quads, touching })
}

fn self_face(site: u32) -> Quad {
    Quad { vertices: [TL, BL, BR, TR].map(|c| 4 * site + c), covers: [site; 4] }
}

/// The quads whose top left voxel in the current layer is `c`, and the walls at `c`.
fn faces_of(sites: &Sites, cur: &SiteGrid, prev: &SiteGrid, c: u32, quads: &mut Vec<Quad>) {
    let Site { x, y, .. } = sites.sites[c as usize];
    let own = |s: u32| sites.is_own(s);
    let mut push = |vertices: [(u32, u32); 4], covers: [u32; 4]| {
        // A face that no voxel of this field takes part in belongs to the neighbour.
        if covers.into_iter().any(own) {
            quads.push(Quad { vertices: vertices.map(|(s, corner)| 4 * s + corner), covers });
        }
    };
    let p = prev.at(x, y);
    let (right, down, diagonal) = (cur.at(x + 1, y), cur.at(x, y + 1), cur.at(x + 1, y + 1));
    let (p_right, p_down) = (prev.at(x + 1, y), prev.at(x, y + 1));
    let p_diagonal = prev.at(x + 1, y + 1);
    // (a) within the layer.
    if p.is_none() && own(c) {
        push([(c, TL), (c, BL), (c, BR), (c, TR)], [c; 4]);
    }
    if let Some(r) = right
        && (p.is_none() || p_right.is_none())
    {
        push([(c, TR), (c, BR), (r, BL), (r, TL)], [c, r, r, r]);
    }
    if let Some(d) = down
        && (p.is_none() || p_down.is_none())
    {
        push([(c, BL), (d, TL), (d, TR), (c, BR)], [c, d, d, d]);
    }
    if let (Some(r), Some(d), Some(e)) = (right, down, diagonal)
        && [p, p_right, p_down, p_diagonal].contains(&None)
    {
        push([(c, BR), (d, TR), (e, TL), (r, BL)], [c, r, d, e]);
    }
    let Some(p) = p else { return };
    // From the nearer layer to this one, from `first` to `second`, seen from the open side from left to right.
    let mut wall = |first: (u32, u32, u32), second: (u32, u32, u32)| {
        let ((c1, p1, k1), (c2, p2, k2)) = (first, second);
        // A slanted face touches no voxels but those of its corners: of two halves, both name what both touch.
        let far = |p: u32, c: u32| {
            (sites.sites[p as usize].x, sites.sites[p as usize].y)
                != (sites.sites[c as usize].x, sites.sites[c as usize].y)
        };
        let covers = if far(p1, c1) { [p1, c2, c2, c2] } else { [p1, c1, p2, c2] };
        push([(p1, k1), (p2, k2), (c2, k2), (c1, k1)], covers);
    };
    // The previous layer's sites that a wall of `site` towards `side` may begin at: the one before it, (b), or the one
    // beside that, (e).
    let before = |site: u32, side: Side| {
        let Site { x, y, .. } = sites.sites[site as usize];
        let [i, j] = side.step();
        let (p, beside) = (prev.at(x, y)?, prev.at(x + i, y + j));
        match beside {
            None => sites.faces(p, side).then_some(Wall::Straight(p)),
            Some(b) => {
                let ends = cur.at(x + i, y + j).is_none() && prev.at(x + 2 * i, y + 2 * j).is_none();
                // On a seam the other frustum could not tell.
                let here = [site, p, b].into_iter().all(own);
                (ends && here && sites.faces(site, side)).then_some(Wall::Receding(b))
            }
        }
    };
    for (side, k1, k2) in WALLS {
        let here = before(c, side);
        match here {
            Some(Wall::Straight(p) | Wall::Receding(p)) if own(c) => wall((c, p, k1), (c, p, k2)),
            _ => {}
        }
        // (c) Between the walls of two neighbours.
        let (next, ahead) = if matches!(side, Side::Top | Side::Bottom) { (right, p_right) } else { (down, p_down) };
        let (Some(n), Some(pn)) = (next, ahead) else { continue };
        let ends = match (here, before(n, side)) {
            (Some(Wall::Receding(a)), Some(Wall::Receding(b))) => [a, b],
            (Some(Wall::Straight(_)), _) | (_, Some(Wall::Straight(_))) => [p, pn],
            _ => continue,
        };
        if matches!(side, Side::Top | Side::Right) {
            wall((c, ends[0], k2), (n, ends[1], k1));
        } else {
            wall((n, ends[1], k2), (c, ends[0], k1));
        }
    }
}

/// Walls by the side that they face: their corners from left to right.
const WALLS: [(Side, u32, u32); 4] =
    [(Side::Right, TR, BR), (Side::Left, BL, TL), (Side::Top, TL, TR), (Side::Bottom, BR, BL)];

/// Where a wall begins in the previous layer.
#[derive(Clone, Copy)]
enum Wall {
    /// At the same pixel.
    Straight(u32),
    /// A pixel further out: the surface draws back from layer to layer.
    Receding(u32),
}
