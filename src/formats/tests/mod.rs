//! Tests of all readers and the writer, on files made in memory.

mod appearance;
mod document;
mod gltf;
mod mutate;
mod obj;
mod packed;
mod ply;
mod pose;
mod round_trip;
mod scene_toml;

use super::{Files, FormatError, Limits, load_with};
use crate::{
    array::Bytes,
    math::Stop,
    scene::{Alpha, Image, Material, Mesh, Object, Part, Scene, Texture, Wrap},
};
use glam::Mat4;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Files in memory.
#[derive(Default)]
pub(super) struct Memory(pub BTreeMap<String, Vec<u8>>);

impl Files for Memory {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        Ok(self.0.get(path.to_str().unwrap()).map(|b| Arc::new(b.clone()) as Bytes))
    }

    fn real(&self, _: &Path) -> Option<PathBuf> {
        None
    }
}

impl Memory {
    fn of<const N: usize>(files: [(&str, &[u8]); N]) -> Self {
        Self(files.iter().map(|(n, b)| (n.to_string(), b.to_vec())).collect())
    }

    /// The scene at `path`, and the warnings.
    fn load(&self, path: &str) -> (Result<Scene, FormatError>, Vec<String>) {
        let mut warnings = Vec::new();
        let scene = load_with(Path::new(path), self, &small(), &Stop::default(), &mut |w| warnings.push(w));
        if let Ok(scene) = &scene {
            keeps_its_promises(scene);
        }
        (scene, warnings)
    }

    /// The scene at `path`, which must load without a warning.
    fn scene(&self, path: &str) -> Scene {
        let (scene, warnings) = self.load(path);
        assert_eq!(warnings, [""; 0]);
        scene.unwrap()
    }

    fn error(&self, path: &str) -> String {
        self.load(path).0.unwrap_err().to_string()
    }
}

/// Limits under which nothing large is ever allocated.
pub(super) fn small() -> Limits {
    Limits {
        texels: 1 << 16,
        vertices: 1 << 16,
        triangles: 1 << 16,
        objects: 1 << 10,
        implied: 1 << 8,
        ..Limits::default()
    }
}

/// What `crate::scene` promises of every scene.
pub(super) fn keeps_its_promises(scene: &Scene) {
    assert!(scene.objects.is_sorted_by(|a, b| a.name < b.name), "names unique and sorted");
    for object in &scene.objects {
        assert!(object.transform.is_finite());
        for part in &object.parts {
            let m = &part.mesh;
            let n = m.positions.len();
            for len in [m.normals.len(), m.tangents.len(), m.uv[0].len(), m.uv[1].len(), m.colors.len()] {
                assert!(len == 0 || len == n);
            }
            assert!(m.triangles.iter().flatten().all(|v| (*v as usize) < n));
            assert!(
                m.positions.iter().flatten().chain(m.uv.iter().flat_map(|u| u.iter().flatten())).all(|v| v.is_finite())
            );
            assert!(m.normals.iter().all(|v| (glam::Vec3::from(*v).length() - 1.0).abs() < 1e-4));
            assert!(m.colors.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
        }
    }
}

/// One triangle in the plane z = 0.
pub(super) fn triangle() -> Mesh {
    Mesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]].into(),
        triangles: vec![[0, 1, 2]].into(),
        ..Mesh::default()
    }
}

pub(super) fn image(name: &str, alpha: u8) -> Arc<Image> {
    let texels = (0..12u8).map(|i| [i * 20, 255 - i, i, if i == 5 { alpha } else { 255 }]).collect();
    Arc::new(Image { name: name.into(), width: 4, height: 3, texels })
}

/// Everything that a scene can hold, in little.
pub(super) fn everything() -> Scene {
    let texture = |image, uv_set| Texture {
        image,
        uv_set,
        offset: [0.25, 0.5],
        rotation: 0.5,
        scale: [2.0, 3.0],
        wrap: [Wrap::Clamp, Wrap::Mirror],
        smooth: false,
    };
    let plain = Texture {
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Repeat; 2],
        smooth: true,
        ..texture(image("plain", 255), 0)
    };
    let rich = Arc::new(Material {
        name: "rich".into(),
        base_color: [0.5, 0.25, 1.0, 0.75],
        base_color_texture: Some(texture(image("colour", 10), 1)),
        metallic: 0.5,
        roughness: 0.25,
        metallic_roughness_texture: Some(plain.clone()),
        normal_scale: 0.5,
        normal_texture: Some(plain.clone()),
        emissive: [2.0, 1.0, 0.5],
        emissive_texture: Some(plain.clone()),
        occlusion_strength: 0.75,
        occlusion_texture: Some(plain),
        alpha: Alpha::Mask { cutoff: 0.25 },
        double_sided: true,
        unlit: false,
    });
    let blend = Arc::new(Material { name: "glass".into(), alpha: Alpha::Blend, unlit: true, ..Material::default() });
    let full = Arc::new(Mesh {
        normals: vec![[0.0, 0.0, 1.0]; 3].into(),
        tangents: vec![[1.0, 0.0, 0.0, -1.0]; 3].into(),
        uv: [vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into(), vec![[0.5, 0.5]; 3].into()],
        colors: vec![[1.0, 0.2, 0.4, 1.0], [0.3, 0.6, 0.9, 0.5], [0.0; 4]].into(),
        ..triangle()
    });
    let odd = Arc::new(Mesh { colors: vec![[0.1234567, 0.5, 0.7, 1.0]; 3].into(), ..triangle() });
    let object = |name: &str, transform, parts: Vec<(&Arc<Mesh>, &Arc<Material>)>| Object {
        name: name.into(),
        transform,
        parts: parts.into_iter().map(|(m, t)| Part { mesh: m.clone(), material: t.clone() }).collect(),
    };
    Scene {
        objects: vec![
            object("Root/House.003", Mat4::IDENTITY, vec![(&full, &rich), (&odd, &blend)]),
            object("a", Mat4::from_translation(glam::vec3(1.0, 2.0, 3.0)), vec![(&full, &rich), (&odd, &blend)]),
            object("b", Mat4::from_scale(glam::vec3(2.0, 1.0, -4.0)), vec![(&odd, &blend)]),
        ],
    }
}

/// CRC-32 as PNG defines it.
pub(in crate::formats) fn crc(bytes: &[u8]) -> u32 {
    !bytes
        .iter()
        .fold(!0, |c, b| (0..8).fold(c ^ *b as u32, |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 }))
}
