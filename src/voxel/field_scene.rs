//! The uncollapsed field as a scene: what no simplification of it can surpass.
//!
//! Every vertex of an initial mesh lies in one voxel (each has four per layer) and has that voxel's colour.

use super::{
    Slices, Voxel, VoxelMesh,
    lattice::Lattice,
    reproject::{MisfitError, Reprojection},
};
use crate::{
    image::srgb,
    math::{Stop, Stopped},
    scene::{Material, Mesh, Object, Part, Scene},
};
use glam::{DVec3, Mat4};
use rayon::prelude::*;
use std::sync::Arc;

#[derive(Debug, thiserror::Error)]
pub enum FieldSceneError {
    #[error("mesh `{mesh}`")]
    Misfit { mesh: String, source: MisfitError },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// One unlit object per mesh, with the mesh's name and its voxels' colours at its vertices.
pub fn field_scene(meshes: &[(&str, &VoxelMesh)], slices: &Slices, stop: &Stop) -> Result<Scene, FieldSceneError> {
    let material = Arc::new(Material {
        name: "voxels".into(),
        metallic: 0.0,
        roughness: 1.0,
        unlit: true,
        double_sided: true,
        ..Material::default()
    });
    let object = |(name, mesh): &(&str, &VoxelMesh)| {
        stop.check()?;
        let map = Reprojection::of(slices, mesh)
            .map_err(|source| FieldSceneError::Misfit { mesh: (*name).to_owned(), source })?;
        let origin = map.origin();
        let lattice = Lattice::new(&mesh.voxels);
        let colors = mesh.vertices.iter().map(|v| {
            let voxel = voxel_of(mesh, &lattice, *v, map.frustum().size);
            let c = voxel.map_or([0; 4], |v| v.color);
            [srgb::to_linear(c[0]), srgb::to_linear(c[1]), srgb::to_linear(c[2]), 1.0]
        });
        let part = Mesh {
            positions: mesh.vertices.iter().map(|v| (map.world(*v) - origin).as_vec3().to_array()).collect(),
            colors: colors.collect(),
            triangles: mesh.faces.clone(),
            ..Mesh::default()
        };
        let parts = vec![Part { mesh: Arc::new(part), material: material.clone() }];
        Ok(Object { name: (*name).to_owned(), transform: Mat4::from_translation(origin.as_vec3()), parts })
    };
    let mut objects: Vec<Object> = meshes.par_iter().map(object).collect::<Result<_, FieldSceneError>>()?;
    objects.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(Scene { objects })
}

/// The voxel in which a vertex lies; the nearest one where the mesh has none there (at seams).
fn voxel_of<'a>(mesh: &'a VoxelMesh, lattice: &Lattice, v: [i32; 3], size: [u32; 2]) -> Option<&'a Voxel> {
    let pixel = |at: i32, n: u32| at.div_euclid(4).clamp(0, n as i32 - 1);
    let (x, y) = (pixel(v[0], size[0]), pixel(v[1], size[1]));
    let key = |w: &Voxel| (i32::from(w.layer), i32::from(w.y), i32::from(w.x));
    if let Ok(i) = mesh.voxels.binary_search_by_key(&(v[2], y, x), key) {
        return Some(&mesh.voxels[i]);
    }
    let p = DVec3::new(f64::from(v[0]) / 4.0, f64::from(v[1]) / 4.0, f64::from(v[2]));
    lattice.nearest(p, DVec3::ONE, 1).found().first().map(|f| &mesh.voxels[f.1 as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::testing;

    /// Two voxels side by side: four vertices each, with the colour of their own.
    #[test]
    fn vertices_have_their_voxels_colours() {
        let vertices = vec![[41, 81, 2], [41, 83, 2], [43, 83, 2], [43, 81, 2], [45, 81, 2], [45, 83, 2], [47, 83, 2]];
        let mesh = testing::mesh(vertices, vec![[0, 1, 2], [4, 5, 6]], [[10, 20, 2], [11, 20, 2]]);
        let scene = field_scene(&[("b", &mesh), ("a", &mesh)], &testing::slices(), &Stop::default()).unwrap();
        assert_eq!(scene.objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        let part = &scene.objects[0].parts[0];
        for (i, c) in part.mesh.colors.iter().enumerate() {
            let voxel = testing::speckle(if i < 4 { 10 } else { 11 }, 20, 2);
            assert_eq!([c[0], c[1], c[2]].map(srgb::from_linear), voxel);
        }
        assert_eq!(part.mesh.triangles, mesh.faces);
    }

    #[test]
    fn a_mesh_of_other_slices_is_an_error() {
        let mesh = VoxelMesh { frustum: 3, ..testing::ground() };
        assert!(field_scene(&[("a", &mesh)], &testing::slices(), &Stop::default()).is_err());
    }
}
