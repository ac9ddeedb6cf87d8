//! Where an object stands: as translation, rotation and scale, or baked into its vertices.

use crate::scene::Mesh;
use glam::{Mat4, Vec3};

pub(super) enum NodePlacement {
    Node(Trs),
    Baked(Transform),
}

/// A node's transform; `None` stands for its default.
#[derive(Default)]
pub(super) struct Trs {
    pub translation: Option<[f32; 3]>,
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
}

/// A transform that glTF's nodes cannot hold: sheared, or without volume.
pub(super) struct Transform(Mat4);

impl NodePlacement {
    /// A node's matrix must be a translation, rotation and scale: validators refuse others.
    pub fn of(m: &Mat4) -> Self {
        if *m == Mat4::IDENTITY {
            return Self::Node(Trs::default());
        }
        let baked = Self::Baked(Transform(*m));
        if m.determinant() == 0.0 || !m.is_finite() {
            return baked;
        }
        let (scale, rotation, translation) = m.to_scale_rotation_translation();
        let rotation = rotation.normalize();
        let back = Mat4::from_scale_rotation_translation(scale, rotation, translation);
        let largest = scale.abs().max_element();
        let close = (0..3).all(|c| (back.col(c) - m.col(c)).abs().max_element() <= 1e-6 * largest);
        if !close || !rotation.is_finite() || m.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return baked;
        }
        let some = |v: Vec3, default: Vec3| (v != default).then(|| v.to_array());
        let turned = rotation.to_array() != [0.0, 0.0, 0.0, 1.0];
        Self::Node(Trs {
            translation: some(translation, Vec3::ZERO),
            rotation: turned.then(|| rotation.to_array()),
            scale: some(scale, Vec3::ONE),
        })
    }
}

impl Transform {
    /// The mesh in world space; a mirroring turns its triangles round.
    pub fn apply(&self, mesh: &Mesh) -> Mesh {
        let m = &self.0;
        let linear = glam::Mat3::from_mat4(*m);
        // The cofactor matrix carries normals even where the transform has no inverse.
        let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
        let cofactor = glam::Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let mirrored = linear.determinant() < 0.0;
        let side = if mirrored { -1.0 } else { 1.0 };
        let normal = |n: &[f32; 3]| (cofactor * Vec3::from(*n) * side).try_normalize().unwrap_or(Vec3::Y).to_array();
        let tangent = |t: &[f32; 4]| {
            let v = (linear * Vec3::new(t[0], t[1], t[2])).try_normalize().unwrap_or(Vec3::X);
            [v.x, v.y, v.z, t[3] * side]
        };
        Mesh {
            positions: mesh.positions.iter().map(|p| m.transform_point3(Vec3::from(*p)).to_array()).collect(),
            normals: mesh.normals.iter().map(normal).collect(),
            tangents: mesh.tangents.iter().map(tangent).collect(),
            triangles: mesh
                .triangles
                .iter()
                .map(|[a, b, c]| if mirrored { [*a, *c, *b] } else { [*a, *b, *c] })
                .collect(),
            ..mesh.clone()
        }
    }
}
