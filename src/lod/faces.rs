//! The surface that a stand-in starts from: the members' meshes without what the cell never sees (Chen et al. 2003, section 3.1.5).

use super::{
    levels::{Level, Levels},
    subject::Subject,
};
use crate::mesh::simplify::compact;
use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which faces are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Facing {
    /// Those that show their front to the cell's centre: the paper's SVMesh.
    Centre,
    /// Those that show their front to a corner of the cell, and so all that any eye in it can see from the front: the paper's MVMesh.
    #[default]
    Cell,
}

/// A triangle mesh about the cell's centre.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    pub positions: Vec<DVec3>,
    /// Unit, from all faces around the vertex, back faces too.
    pub normals: Vec<DVec3>,
    /// Base colours of the original, sRGB.
    pub colors: Vec<[u8; 4]>,
    /// Per vertex one bit for each of `eyes`: some face around the vertex shows it its front.
    pub front: Vec<u32>,
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// The largest error of the members' levels, metres.
    pub error: f64,
}

/// Whether the front of the face with corner `p` and normal `n` (any length) can be seen from a point of the convex hull of `eyes`.
pub fn front(n: DVec3, p: DVec3, eyes: &[DVec3]) -> bool {
    eyes.iter().any(|e| n.dot(*e - p) > 0.0)
}

/// Joins the members of `subject`. `levels` are their meshes, in the order of the members; each differs from the original by at most `tolerance` metres where
/// it has such a level. `eyes`: at most 32 places for [`Surface::front`]. A face of a double-sided object that shows its back is kept, turned round, where
/// `seen` says that its middle is visible.
///
/// # Panics
/// Where there are more than 32 eyes.
pub fn surface(
    subject: &Subject,
    levels: &[&Levels],
    facing: Facing,
    tolerance: f64,
    eyes: &[DVec3],
    seen: &dyn Fn(DVec3) -> bool,
) -> Surface {
    assert!(eyes.len() <= 32, "one bit an eye");
    let corners = subject.cell.corners();
    let towards: &[DVec3] = match facing {
        Facing::Centre => &[DVec3::ZERO],
        Facing::Cell => &corners,
    };
    let mut out = Surface::default();
    for ((_, transform), levels) in subject.members.iter().zip(levels) {
        let axes = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis];
        let scale = axes.iter().map(|a| a.length()).fold(0.0, f64::max);
        let level: &Level = levels.within(tolerance / scale.max(f64::MIN_POSITIVE));
        out.error = out.error.max(level.error * scale);
        let positions: Vec<DVec3> =
            level.positions.iter().map(|p| transform.transform_point3(Vec3::from(*p).as_dvec3())).collect();
        let mirrored = transform.matrix3.determinant() < 0.0;
        let middle = |t: &[u32; 3]| t.iter().map(|v| positions[*v as usize]).sum::<DVec3>() / 3.0;
        let visible: Vec<bool> = match levels.double_sided {
            true => level.triangles.iter().map(|t| seen(middle(t))).collect(),
            false => vec![false; level.triangles.len()],
        };
        let turned = mirrored != is_inside_out(level, &positions, mirrored, &visible);
        let mut normals = vec![DVec3::ZERO; positions.len()];
        let mut fronts = vec![0_u32; positions.len()];
        let mut kept: Vec<[u32; 3]> = Vec::new();
        for (t, visible) in level.triangles.iter().zip(&visible) {
            let t = if turned { [t[0], t[2], t[1]] } else { *t };
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let n = (b - a).cross(c - a);
            let bits = eyes.iter().enumerate().fold(0, |bits, (k, e)| bits | u32::from(n.dot(*e - a) > 0.0) << k);
            for v in t {
                normals[v as usize] += n;
                fronts[v as usize] |= bits;
            }
            if front(n, a, towards) {
                kept.push(t);
            } else if *visible && n != DVec3::ZERO {
                kept.push([t[0], t[2], t[1]]);
            }
        }
        let first = out.positions.len() as u32;
        let (used, triangles) = compact(positions.len(), &kept);
        for v in used.into_iter().map(|v| v as usize) {
            out.positions.push(positions[v]);
            out.normals.push(normals[v].normalize_or_zero());
            out.colors.push(level.colors[v]);
            out.front.push(fronts[v]);
        }
        out.triangles.extend(triangles.into_iter().map(|t| t.map(|v| first + v)));
    }
    out
}

/// Whether more of what is visible from the cell's centre shows its back: double-sided objects may be wound inwards.
fn is_inside_out(level: &Level, positions: &[DVec3], mirrored: bool, visible: &[bool]) -> bool {
    let mut front = 0.0;
    for (t, _) in level.triangles.iter().zip(visible).filter(|(_, visible)| **visible) {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let middle = (a + b + c) / 3.0;
        // As large as it looks from the centre, up to a constant.
        front -= (b - a).cross(c - a).dot(middle) / (middle.length_squared() * middle.length()).max(f64::MIN_POSITIVE);
    }
    if mirrored { front > 0.0 } else { front < 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{math::Sequence, view::Prism};
    use proptest::prelude::*;

    proptest! {
        /// Section 3.1.5: what is back-facing to the twelve corners is back-facing to every point of the cell.
        #[test]
        fn culling_removes_nothing_that_an_eye_sees(
            n in prop::array::uniform3(-1.0..1.0_f64), p in prop::array::uniform3(-9.0..9.0_f64), size in 0.1..3.0_f64, half in 0.0..2.0_f64,
        ) {
            let (n, p) = (DVec3::from(n), DVec3::from(p));
            let cell = Prism { centre: DVec3::ZERO, size, half_height: half };
            let sequence = Sequence::<3>::new(7);
            if !front(n, p, &cell.corners()) {
                for i in 0..200 {
                    prop_assert!(n.dot(cell.point(sequence.point(i)) - p) <= 1e-9);
                }
            }
        }
    }
}
