//! Small slices and voxel meshes for tests.

use super::{Frustum, Slices, Voxel, VoxelMesh};
use crate::{array::Array, view::Cell};
use glam::{DVec3, dvec3};
use std::collections::BTreeMap;

/// One frustum of 100 × 60 pixels along −Z with an asymmetric window and six layers at 20 m to 45 m; cell of side 4 m.
pub fn slices() -> Slices {
    let layers: Vec<f64> = vec![20.0, 22.5, 26.0, 31.0, 37.0, 45.0];
    let mut borders = vec![19.0];
    borders.extend(layers.windows(2).map(|w| 0.5 * (w[0] + w[1])));
    borders.push(f64::INFINITY);
    Slices {
        cell: Cell { centre: dvec3(3.0, 1.5, -2.0), half: DVec3::splat(2.0) },
        frusta: vec![Frustum {
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::NEG_Z,
            left: -0.4,
            right_tan: 0.6,
            bottom: -0.25,
            top: 0.35,
            size: [100, 60],
            across: [None; 4],
        }],
        layers,
        borders,
        alpha: 0.005,
    }
}

pub fn voxel(x: u16, y: u16, layer: u16, rgb: [u8; 3]) -> Voxel {
    Voxel { x, y, layer, ring: 0, inside: 0, color: [rgb[0], rgb[1], rgb[2], 255], normal: [0, 0], object: 0 }
}

/// A colour that differs from voxel to voxel.
pub fn speckle(x: u16, y: u16, layer: u16) -> [u8; 3] {
    let h = (u32::from(x) * 7919 + u32::from(y) * 104_729 + u32::from(layer) * 1_299_709).wrapping_mul(2_654_435_761);
    [(h >> 24) as u8, (h >> 16) as u8, (h >> 8) as u8]
}

/// A mesh of given faces over given voxels; every face covers the voxels whose centre lies within two voxel sides of
/// its bounding box. Factor 2.
pub fn mesh(vertices: Vec<[i32; 3]>, faces: Vec<[u32; 3]>, places: impl IntoIterator<Item = [u16; 3]>) -> VoxelMesh {
    let sorted: BTreeMap<_, _> =
        places.into_iter().map(|[x, y, l]| ((l, y, x), voxel(x, y, l, speckle(x, y, l)))).collect();
    let voxels: Vec<_> = sorted.into_values().collect();
    let (mut cover_start, mut cover) = (vec![0], Vec::new());
    for f in &faces {
        let near = |v: &Voxel| {
            let c = [i32::from(v.x) * 4 + 2, i32::from(v.y) * 4 + 2, i32::from(v.layer)];
            (0..3).all(|k| {
                let of = f.map(|i| vertices[i as usize][k]);
                let reach = if k == 2 { 2 } else { 8 };
                c[k] >= of.into_iter().min().unwrap() - reach && c[k] <= of.into_iter().max().unwrap() + reach
            })
        };
        cover.extend((0..voxels.len()).filter(|i| near(&voxels[*i])).map(|i| i as u32));
        cover_start.push(cover.len() as u32);
    }
    VoxelMesh {
        frustum: 0,
        flags: vec![0; vertices.len()].into(),
        vertices: vertices.into(),
        faces: faces.into(),
        cover_start: cover_start.into(),
        cover: cover.into(),
        voxels: voxels.into(),
        quarters: Array::default(),
        factor: 2.0,
        alpha: false,
    }
}

/// Pixels 10..50 × 20..40 of layer 2 as two faces.
pub fn wall(_: &Slices) -> VoxelMesh {
    let vertices = vec![[41, 81, 2], [41, 159, 2], [199, 159, 2], [199, 81, 2]];
    mesh(vertices, vec![[0, 1, 2], [0, 2, 3]], (20..40).flat_map(|y| (10..50).map(move |x| [x, y, 2])))
}

/// Ground that rises from layer 0 at the bottom to layer 5, twelve pixels a layer across the whole window's width.
pub fn ground() -> VoxelMesh {
    let vertices = vec![[1, 21, 5], [1, 237, 0], [397, 237, 0], [397, 21, 5]];
    let places = (5..60u16).flat_map(|y| (0..100).map(move |x| [x, y, 5 - (y - 5) * 6 / 55]));
    mesh(vertices, vec![[0, 1, 2], [0, 2, 3]], places)
}

/// A wall along one column of pixels through all layers: seen edge-on from the centre.
pub fn edge_on() -> VoxelMesh {
    let vertices = vec![[301, 41, 0], [301, 199, 0], [301, 199, 5], [301, 41, 5]];
    let places = (0..6u16).flat_map(|l| (10..50).map(move |y| [75, y, l]));
    mesh(vertices, vec![[0, 1, 2], [0, 2, 3]], places)
}

/// Front, right side and top of a box.
pub fn open_box() -> VoxelMesh {
    let v = |x: i32, y: i32, l: i32| [x, y, l];
    let vertices = vec![
        v(81, 81, 1),
        v(81, 159, 1),
        v(159, 159, 1),
        v(159, 81, 1), // front
        v(159, 159, 4),
        v(159, 81, 4),
        v(81, 81, 4),
    ];
    let faces = vec![[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5], [0, 3, 5], [0, 5, 6]];
    let front = (20..40u16).flat_map(|y| (20..40u16).map(move |x| [x, y, 1]));
    let side = (1..5u16).flat_map(|l| (20..40u16).map(move |y| [39, y, l]));
    let top = (1..5u16).flat_map(|l| (20..40u16).map(move |x| [x, 20, l]));
    mesh(vertices, faces, front.chain(side).chain(top).collect::<Vec<_>>())
}

/// The meshes above.
pub fn all() -> Vec<VoxelMesh> {
    vec![wall(&slices()), ground(), edge_on(), open_box()]
}
