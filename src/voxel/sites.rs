//! The voxels that take part in meshing one frustum, and the quads over them.

use super::{Across, Field, Side, Slices};
use crate::math::Stopped;

/// Why fields cannot be meshed.
#[derive(Debug, thiserror::Error)]
pub enum CoverError {
    #[error("a field names frustum {frustum}, but there are only {count}")]
    Frustum { frustum: u32, count: usize },
    #[error("two fields of frustum {0}")]
    Twice(u32),
    #[error("voxel ({x}, {y}) of frustum {frustum} lies outside its {width} x {height} image")]
    Outside { frustum: u32, x: u16, y: u16, width: u32, height: u32 },
    #[error("the voxels of frustum {0} are not sorted by layer, y and x, or two are equal")]
    Unsorted(u32),
    #[error("frustum {frustum} shares an edge of {here} pixels with frustum {other}, where it has {there}")]
    Seam { frustum: u32, here: u32, other: u32, there: u32 },
    #[error("frustum {0} has too many voxels to number their vertices")]
    Size(u32),
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// A voxel as the operator sees it: one of the field's own, or one that a neighbouring frustum lends beyond the image.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Site {
    pub layer: u16,
    pub y: i32,
    pub x: i32,
}

/// All voxels that take part: first the field's own (site numbers are voxel numbers), then those lent.
pub(super) struct Sites {
    pub size: [i32; 2],
    pub sites: Vec<Site>,
    pub own: usize,
    /// Per own site: sides that nothing seen faces ([`Voxel::inside`]).
    inside: Vec<u8>,
}

impl Sites {
    pub(super) fn new(slices: &Slices, fields: &[Option<&Field>], field: &Field) -> Result<Self, CoverError> {
        let frustum = &slices.frusta[field.frustum as usize];
        let size = frustum.size.map(|s| s as i32);
        let mut sites: Vec<Site> =
            field.voxels.iter().map(|v| Site { layer: v.layer, y: v.y.into(), x: v.x.into() }).collect();
        let own = sites.len();
        for (side, across) in [Side::Left, Side::Right, Side::Top, Side::Bottom].into_iter().zip(frustum.across) {
            let Some(across) = across else { continue };
            lend(slices, fields, field.frustum, side, across, &mut sites)?;
        }
        // Where three frusta meet there are three voxels instead of four: the missing one counts as filled where both
        // its neighbours are, so that all three frusta fill the gap up to the common corner.
        let mut corners = Vec::new();
        let mut lent = sites[own..].to_vec();
        lent.sort_unstable();
        for s in &lent {
            for x in [-1, size[0]] {
                let beside = Site { layer: s.layer, x, y: s.y.clamp(0, size[1] - 1) };
                let at_corner = s.x == x.clamp(0, size[0] - 1) && (s.y == -1 || s.y == size[1]);
                if at_corner && lent.binary_search(&beside).is_ok() {
                    corners.push(Site { layer: s.layer, y: s.y, x });
                }
            }
        }
        sites.extend(corners);
        sites[own..].sort_unstable();
        if sites.len() > (u32::MAX / 8) as usize {
            return Err(CoverError::Size(field.frustum));
        }
        Ok(Self { size, sites, own, inside: field.voxels.iter().map(|v| v.inside).collect() })
    }

    /// Whether the site is a voxel of this field.
    pub(super) fn is_own(&self, site: u32) -> bool {
        (site as usize) < self.own
    }

    /// Whether the place on that side of the site, if it is empty, faces something that is seen.
    pub(super) fn faces(&self, site: u32, side: Side) -> bool {
        self.inside.get(site as usize).is_none_or(|inside| inside >> side as u8 & 1 == 0)
    }

    pub(super) fn own_count(&self) -> usize {
        self.own
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.sites.len() * 4
    }

    /// Position of vertex `4 * site + corner` and whether it is locked onto a seam.
    pub(super) fn vertex(&self, vertex: u32) -> ([i32; 3], bool) {
        let (site, corner) = (vertex / 4, vertex as i32 % 4);
        let s = self.sites[site as usize];
        let at = |p: i32, far: i32, size: i32| (4 * p + 1 + 2 * far).clamp(0, 4 * size);
        let x = at(s.x, corner & 1, self.size[0]);
        let y = at(s.y, corner >> 1, self.size[1]);
        ([x, y, s.layer.into()], !self.is_own(site))
    }
}

/// Adds what the frustum beyond `side` shows along the shared edge, in this frustum's coordinates.
fn lend(
    slices: &Slices,
    fields: &[Option<&Field>],
    here: u32,
    side: Side,
    across: Across,
    sites: &mut Vec<Site>,
) -> Result<(), CoverError> {
    let count = slices.frusta.len();
    let other =
        slices.frusta.get(across.frustum as usize).ok_or(CoverError::Frustum { frustum: across.frustum, count })?;
    let size = slices.frusta[here as usize].size;
    let length = |side: Side, size: [u32; 2]| if matches!(side, Side::Left | Side::Right) { size[1] } else { size[0] };
    let (n, there) = (length(side, size), length(across.side, other.size));
    if n != there {
        return Err(CoverError::Seam { frustum: here, here: n, other: across.frustum, there });
    }
    let Some(field) = fields[across.frustum as usize] else { return Ok(()) };
    for v in field.voxels.iter() {
        let (x, y) = (u32::from(v.x), u32::from(v.y));
        let (on_edge, along) = match across.side {
            Side::Left => (x == 0, y),
            Side::Right => (x + 1 == other.size[0], y),
            Side::Top => (y == 0, x),
            Side::Bottom => (y + 1 == other.size[1], x),
        };
        if !on_edge {
            continue;
        }
        let along = if across.reversed { n - 1 - along } else { along } as i32;
        let (x, y) = match side {
            Side::Left => (-1, along),
            Side::Right => (size[0] as i32, along),
            Side::Top => (along, -1),
            Side::Bottom => (along, size[1] as i32),
        };
        sites.push(Site { layer: v.layer, y, x });
    }
    Ok(())
}

/// A quad: its vertices (`4 * site + corner`) in order, and the sites that it covers (the last repeated up to four).
pub(super) struct Quad {
    pub vertices: [u32; 4],
    pub covers: [u32; 4],
}

/// What the operator finds.
pub(super) struct Emitted {
    pub quads: Vec<Quad>,
    /// Own voxels that touch, if only at a corner.
    pub touching: Vec<[u32; 2]>,
}
