//! A scene as the rasteriser sees it: draws that share meshes, and one numbering over all triangles.

use crate::{
    math::Aabb,
    scene::{Alpha, Image, Material, Mesh, Scene},
};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::{collections::BTreeMap, sync::Arc};

/// The prepared scene. Instances share their mesh: only a transform is kept for each.
#[derive(Clone, Debug)]
pub struct Geometry {
    draws: Vec<Draw>,
    triangles: u32,
}

/// One part of one object.
#[derive(Clone, Debug)]
pub(crate) struct Draw {
    pub object: u32,
    pub part: u32,
    pub mesh: Arc<Mesh>,
    pub material: Arc<Material>,
    pub to_world: DAffine3,
    /// Inverse transpose, for normals; the identity where the transform has no inverse.
    pub normals: DMat3,
    /// The transform mirrors: front faces become back faces.
    pub mirrored: bool,
    /// Number of its first triangle.
    pub first: u32,
    /// Object-space bounds of all positions.
    pub bounds: Aabb,
    pub cutout: Cutout,
}

/// Which points of a draw's triangles are there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cutout {
    Solid,
    /// Those whose alpha reaches the cutoff.
    Masked(f32),
    /// None.
    Hidden,
}

/// Where a triangle number lies in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleOrigin {
    /// Index into [`Scene::objects`].
    pub object: u32,
    /// Index into the object's parts.
    pub part: u32,
    /// Index into the mesh's triangles.
    pub triangle: u32,
}

impl Geometry {
    /// # Panics
    /// Where the scene has 2³² − 1 triangles or more, instances counted; readers allow fewer.
    pub fn new(scene: &Scene) -> Self {
        let mut bounds = BTreeMap::new();
        let mut transparent = BTreeMap::new();
        let mut draws = Vec::new();
        let mut first = 0u64;
        for (o, object) in scene.objects.iter().enumerate() {
            let to_world = DAffine3::from_mat4(object.transform.as_dmat4());
            let determinant = to_world.matrix3.determinant();
            let inverse = if determinant != 0.0 { to_world.matrix3.inverse().transpose() } else { DMat3::IDENTITY };
            for (p, part) in object.parts.iter().enumerate() {
                let bounds = *bounds
                    .entry(Arc::as_ptr(&part.mesh))
                    .or_insert_with(|| Aabb::of(part.mesh.positions.iter().map(|p| Vec3::from(*p))));
                draws.push(Draw {
                    object: o as u32,
                    part: p as u32,
                    mesh: part.mesh.clone(),
                    material: part.material.clone(),
                    to_world,
                    normals: if inverse.is_finite() { inverse } else { DMat3::IDENTITY },
                    mirrored: determinant < 0.0,
                    first: first as u32,
                    bounds,
                    cutout: cutout(&part.mesh, &part.material, &mut transparent),
                });
                first += part.mesh.triangles.len() as u64;
                assert!(first < u32::MAX as u64, "a scene has less than 2^32 - 1 triangles");
            }
        }
        Self { draws, triangles: first as u32 }
    }

    /// The same before the alpha test: masked parts are whole.
    pub fn uncut(&self) -> Self {
        let whole = |d: &Draw| Draw {
            cutout: if matches!(d.cutout, Cutout::Masked(_)) { Cutout::Solid } else { d.cutout },
            ..d.clone()
        };
        Self { draws: self.draws.iter().map(whole).collect(), triangles: self.triangles }
    }

    /// Triangles in all, instances counted. Triangle numbers lie below.
    pub fn triangle_count(&self) -> u32 {
        self.triangles
    }

    pub(crate) fn draws(&self) -> &[Draw] {
        &self.draws
    }

    pub(crate) fn draw_index(&self, triangle: u32) -> usize {
        self.draws.partition_point(|d| d.first <= triangle) - 1
    }

    pub(crate) fn draw_of(&self, triangle: u32) -> &Draw {
        &self.draws[self.draw_index(triangle)]
    }

    pub fn locate(&self, triangle: u32) -> TriangleOrigin {
        let d = self.draw_of(triangle);
        TriangleOrigin { object: d.object, part: d.part, triangle: triangle - d.first }
    }

    /// Index into [`Scene::objects`].
    pub fn object_of(&self, triangle: u32) -> u32 {
        self.draw_of(triangle).object
    }

    /// Index into the object's parts.
    pub fn part_of(&self, triangle: u32) -> u32 {
        self.draw_of(triangle).part
    }

    pub fn material_of(&self, triangle: u32) -> &Arc<Material> {
        &self.draw_of(triangle).material
    }

    /// Corners in world space, metres; counter-clockwise seen from the front.
    pub fn positions(&self, triangle: u32) -> [DVec3; 3] {
        let d = self.draw_of(triangle);
        let [a, b, c] = d.corners(triangle - d.first);
        if d.mirrored { [a, c, b] } else { [a, b, c] }
    }
}

impl Draw {
    /// World-space corners in the order of the mesh's indices.
    pub fn corners(&self, local: u32) -> [DVec3; 3] {
        self.mesh.triangles[local as usize].map(|i| self.to_world.transform_point3(self.position(i)))
    }

    fn position(&self, vertex: u32) -> DVec3 {
        Vec3::from(self.mesh.positions[vertex as usize]).as_dvec3()
    }
}

/// Whether the part has holes. `transparent` remembers which images have a texel with alpha below 255.
fn cutout(mesh: &Mesh, material: &Material, transparent: &mut BTreeMap<*const Image, bool>) -> Cutout {
    let cutoff = match material.alpha {
        Alpha::Opaque => return Cutout::Solid,
        Alpha::Mask { cutoff } => cutoff,
        Alpha::Blend => 0.5,
    };
    let factor = material.base_color[3];
    let least_vertex = mesh.colors.iter().fold(1.0f32, |least, c| least.min(c[3]));
    let texels = material.base_color_texture.as_ref().is_some_and(|t| {
        *transparent.entry(Arc::as_ptr(&t.image)).or_insert_with(|| t.image.texels.iter().any(|texel| texel[3] < 255))
    });
    if factor < cutoff {
        // Texels and vertices only take away.
        Cutout::Hidden
    } else if !texels && factor * least_vertex >= cutoff {
        Cutout::Solid
    } else {
        Cutout::Masked(cutoff)
    }
}
