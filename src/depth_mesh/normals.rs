//! Normals estimated from the depth grid (section 4.2).

use super::{
    map::DepthMap,
    options::{DepthRange, Options},
    rays::Rays,
};
use glam::Vec3;

/// A neighbour that much farther off in depth than the other one belongs to another surface.
const FARTHER: f32 = 3.0;

/// The unit normal of a grid point in the camera's frame, towards the camera: from central differences along row and column,
/// from one side only at borders, beside background, and where the other neighbour lies across a step. Without a
/// neighbour in a row or column the surface faces the camera there. For background it is the direction to the camera.
pub(super) fn normal(map: &DepthMap, rays: &Rays, options: &Options, x: usize, y: usize) -> Vec3 {
    let side = map.side();
    let z = map.depth()[y * side + x];
    let away = rays.direction(x, y);
    let facing = -away.normalize_or(Vec3::Z);
    if z == f32::INFINITY {
        return facing;
    }
    let own = rays.position(x, y, z);
    let at = |x: usize, y: usize| {
        let z = map.depth()[y * side + x];
        (z < f32::INFINITY).then(|| rays.position(x, y, z))
    };
    let before = |i: usize| i.checked_sub(1);
    let after = |i: usize| (i + 1 < side).then_some(i + 1);
    let row = tangent(options, own, before(x).and_then(|x| at(x, y)), after(x).and_then(|x| at(x, y)));
    let column = tangent(options, own, before(y).and_then(|y| at(x, y)), after(y).and_then(|y| at(x, y)));
    let n = row.unwrap_or(facing.cross(Vec3::Y)).cross(column.unwrap_or(facing.cross(Vec3::X)));
    let Some(n) = n.try_normalize() else { return facing };
    if n.dot(away) > 0.0 { -n } else { n }
}

fn tangent(options: &Options, own: Vec3, before: Option<Vec3>, after: Option<Vec3>) -> Option<Vec3> {
    let (Some(a), Some(b)) = (before, after) else {
        return before.map(|a| own - a).or(after.map(|b| b - own));
    };
    let (da, db) = ((own.z - a.z).abs(), (b.z - own.z).abs());
    let step = match options.depth_range {
        DepthRange::Absolute => options.lambda,
        DepthRange::Relative => options.lambda * own.z,
    };
    Some(match da.max(db) > step && da.max(db) > FARTHER * da.min(db) {
        true if da < db => own - a,
        true => b - own,
        false => b - a,
    })
}

/// How squarely the camera samples a surface: ρ = |n·v|, 0 to 1 (section 4.2).
pub(super) fn quality(rays: &Rays, x: usize, y: usize, normal: Vec3) -> f32 {
    normal.dot(rays.direction(x, y).normalize_or(Vec3::Z)).abs().min(1.0)
}
