//! How scenes are stored: every distinct mesh, material and image once, their arrays end to end.

use crate::{
    array::Array,
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    scene::{
        Image, Mesh, Object, Part, Scene,
        tables::{MaterialRow, Tables},
    },
};
use bytemuck::Pod;
use glam::Mat4;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What the image table holds of an image.
#[derive(Serialize, Deserialize)]
struct ImageRow {
    name: String,
    width: u32,
    height: u32,
}

/// Lengths of a mesh's arrays: positions, normals, tangents, both texture coordinates, colours, triangles.
type Sizes = [u64; 7];

impl Artifact for Scene {
    const TYPE: &'static str = "Scene";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let t = Tables::of(self);
        out.json("names", &self.objects.iter().map(|o| &o.name).collect::<Vec<_>>());
        let transforms: Vec<_> = self.objects.iter().map(|o| o.transform.to_cols_array()).collect();
        out.array("transforms", &transforms);
        let ends = t.parts.iter().scan(0, |end, p| {
            *end += p.len() as u64;
            Some(*end)
        });
        out.array("part_ends", &ends.collect::<Vec<_>>());
        out.array("parts", &t.parts.concat());

        let sizes = |m: &Mesh| -> Sizes {
            let attributes = [m.positions.len(), m.normals.len(), m.tangents.len(), m.uv[0].len(), m.uv[1].len()];
            let [p, n, t, u, v] = attributes.map(|n| n as u64);
            [p, n, t, u, v, m.colors.len() as u64, m.triangles.len() as u64]
        };
        out.array("mesh_sizes", &t.meshes.iter().map(|m| sizes(m)).collect::<Vec<_>>());
        joined(out, "positions", &t.meshes, |m| &m.positions);
        joined(out, "normals", &t.meshes, |m| &m.normals);
        joined(out, "tangents", &t.meshes, |m| &m.tangents);
        joined(out, "uv0", &t.meshes, |m| &m.uv[0]);
        joined(out, "uv1", &t.meshes, |m| &m.uv[1]);
        joined(out, "colors", &t.meshes, |m| &m.colors);
        joined(out, "triangles", &t.meshes, |m| &m.triangles);

        out.json("materials", &t.materials.iter().map(|(_, row)| row).collect::<Vec<_>>());
        let row = |i: &&Arc<Image>| ImageRow { name: i.name.clone(), width: i.width, height: i.height };
        out.json("images", &t.images.iter().map(row).collect::<Vec<_>>());
        joined(out, "texels", &t.images, |i| &i.texels);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let images = images(data)?;
        let materials = data.json::<Vec<MaterialRow>>("materials")?;
        let materials = materials.iter().enumerate().map(|(i, row)| match row.material(&images) {
            Some(m) => Ok(Arc::new(m)),
            None => Err(DecodeError::section("materials", format!("material {i} names an image that is not stored"))),
        });
        let materials = materials.collect::<Result<Vec<_>, _>>()?;
        let meshes = meshes(data)?;

        let names: Vec<String> = data.json("names")?;
        let transforms = data.array::<[f32; 16]>("transforms")?;
        let ends = data.array::<u64>("part_ends")?;
        let parts = data.array::<[u32; 2]>("parts")?;
        if transforms.len() != names.len() || ends.len() != names.len() {
            return Err(DecodeError::section("names", format!("{} names, {} objects", names.len(), ends.len())));
        }
        if !names.is_sorted_by(|a, b| a < b) {
            return Err(DecodeError::section("names", "not sorted or not unique"));
        }
        if ends.last().copied().unwrap_or(0) != parts.len() as u64 {
            return Err(DecodeError::section("part_ends", "the last one is not the number of parts"));
        }
        let mut objects = Vec::with_capacity(names.len());
        let mut start = 0;
        for ((name, transform), end) in names.into_iter().zip(transforms.iter()).zip(ends.iter()) {
            let own = parts.get(start..*end as usize);
            let own = own.ok_or_else(|| DecodeError::section("part_ends", "not ascending"))?;
            start = *end as usize;
            let part = |[mesh, material]: &[u32; 2]| {
                let mesh = meshes.get(*mesh as usize)?.clone();
                Some(Part { mesh, material: materials.get(*material as usize)?.clone() })
            };
            let own = own.iter().map(part).collect::<Option<Vec<_>>>();
            let own = own.ok_or_else(|| DecodeError::section("parts", "a mesh or material that is not stored"))?;
            if !transform.iter().all(|v| v.is_finite()) {
                return Err(DecodeError::section("transforms", format!("{name}: not finite")));
            }
            objects.push(Object { name, transform: Mat4::from_cols_array(transform), parts: own });
        }
        Ok(Self { objects })
    }
}

/// One section with the arrays of all `items` end to end.
fn joined<I, T: Pod>(out: &mut Encoder, name: &str, items: &[&Arc<I>], array: impl Fn(&I) -> &Array<T>) {
    let mut bytes = Vec::with_capacity(items.iter().map(|i| size_of_val(array(i).as_slice())).sum());
    items.iter().for_each(|i| bytes.extend_from_slice(bytemuck::cast_slice(array(i))));
    out.bytes(name, bytes);
}

/// A section that holds the arrays of several items, taken apart from its beginning.
struct Joined<T: Pod> {
    name: &'static str,
    all: Array<T>,
    at: usize,
}

impl<T: Pod> Joined<T> {
    fn open(data: &Decoder, name: &'static str) -> Result<Self, DecodeError> {
        Ok(Self { name, all: data.array(name)?, at: 0 })
    }

    fn take(&mut self, len: u64) -> Result<Array<T>, DecodeError> {
        let part = usize::try_from(len).ok().and_then(|len| self.all.slice(self.at, len));
        let part = part.ok_or_else(|| DecodeError::section(self.name, "shorter than its items"))?;
        self.at += part.len();
        Ok(part)
    }

    fn end(self) -> Result<(), DecodeError> {
        let rest = self.all.len() - self.at;
        if rest > 0 { Err(DecodeError::section(self.name, format!("{rest} elements of no item"))) } else { Ok(()) }
    }
}

fn images(data: &Decoder) -> Result<Vec<Arc<Image>>, DecodeError> {
    let mut texels = Joined::<[u8; 4]>::open(data, "texels")?;
    let rows = data.json::<Vec<ImageRow>>("images")?.into_iter();
    let images = rows.map(|ImageRow { name, width, height }| {
        let texels = texels.take(width as u64 * height as u64)?;
        if texels.is_empty() {
            return Err(DecodeError::section("images", format!("image `{name}` is empty")));
        }
        Ok(Arc::new(Image { name, width, height, texels }))
    });
    let images = images.collect::<Result<_, _>>()?;
    texels.end()?;
    Ok(images)
}

fn meshes(data: &Decoder) -> Result<Vec<Arc<Mesh>>, DecodeError> {
    let sizes = data.array::<Sizes>("mesh_sizes")?;
    let mut positions = Joined::<[f32; 3]>::open(data, "positions")?;
    let mut normals = Joined::<[f32; 3]>::open(data, "normals")?;
    let mut tangents = Joined::<[f32; 4]>::open(data, "tangents")?;
    let mut uv0 = Joined::<[f32; 2]>::open(data, "uv0")?;
    let mut uv1 = Joined::<[f32; 2]>::open(data, "uv1")?;
    let mut colors = Joined::<[f32; 4]>::open(data, "colors")?;
    let mut triangles = Joined::<[u32; 3]>::open(data, "triangles")?;
    let mut meshes = Vec::with_capacity(sizes.len());
    for (i, &[p, n, t, u, v, c, f]) in sizes.iter().enumerate() {
        if [n, t, u, v, c].iter().any(|a| *a != 0 && *a != p) {
            return Err(DecodeError::section("mesh_sizes", format!("mesh {i}: attributes of unequal length")));
        }
        meshes.push(Arc::new(Mesh {
            positions: positions.take(p)?,
            normals: normals.take(n)?,
            tangents: tangents.take(t)?,
            uv: [uv0.take(u)?, uv1.take(v)?],
            colors: colors.take(c)?,
            triangles: triangles.take(f)?,
        }));
    }
    positions.end()?;
    normals.end()?;
    tangents.end()?;
    uv0.end()?;
    uv1.end()?;
    colors.end()?;
    triangles.end()?;
    meshes.par_iter().enumerate().try_for_each(|(i, mesh)| {
        let count = mesh.positions.len();
        if mesh.triangles.par_iter().any(|t| t.iter().any(|v| *v as usize >= count)) {
            return Err(DecodeError::section("triangles", format!("mesh {i}: an index beyond its {count} vertices")));
        }
        let finite = |values: &[f32]| values.par_iter().all(|v| v.is_finite());
        let arrays: [&[f32]; 6] = [
            bytemuck::cast_slice(&mesh.positions),
            bytemuck::cast_slice(&mesh.normals),
            bytemuck::cast_slice(&mesh.tangents),
            bytemuck::cast_slice(&mesh.uv[0]),
            bytemuck::cast_slice(&mesh.uv[1]),
            bytemuck::cast_slice(&mesh.colors),
        ];
        if !arrays.iter().all(|a| finite(a)) {
            return Err(DecodeError::section("positions", format!("mesh {i}: a number that is not finite")));
        }
        Ok(())
    })?;
    Ok(meshes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::artifact::{from_bytes, to_bytes};
    use crate::scene::{Material, Texture, Wrap};

    fn scene(separate: bool) -> Scene {
        let mesh = || {
            Arc::new(Mesh {
                positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].into(),
                uv: [vec![[0.5, 0.25]; 3].into(), Default::default()],
                triangles: vec![[0, 1, 2]].into(),
                ..Mesh::default()
            })
        };
        let material = || {
            let texels = vec![[1, 2, 3, 4]; 6].into();
            let image = Arc::new(Image { name: "i".into(), width: 3, height: 2, texels });
            let (offset, scale, wrap) = ([0.0; 2], [1.0; 2], [Wrap::Clamp; 2]);
            let texture = Texture { image, uv_set: 0, offset, rotation: 0.1, scale, wrap, smooth: true };
            Arc::new(Material { base_color_texture: Some(texture), ..Material::default() })
        };
        let (shared_mesh, shared_material) = (mesh(), material());
        let part = || match separate {
            true => Part { mesh: mesh(), material: material() },
            false => Part { mesh: shared_mesh.clone(), material: shared_material.clone() },
        };
        let object = |name: &str| Object { name: name.into(), transform: Mat4::IDENTITY, parts: vec![part(), part()] };
        Scene { objects: vec![object("a"), object("b")] }
    }

    #[test]
    fn equal_scenes_have_equal_bytes_and_share_when_decoded() {
        let bytes = to_bytes(&scene(false));
        assert_eq!(bytes, to_bytes(&scene(true)));
        let back: Scene = from_bytes(Arc::new(bytes.clone())).unwrap();
        assert_eq!(back, scene(false));
        assert!(Arc::ptr_eq(&back.objects[0].parts[0].mesh, &back.objects[1].parts[1].mesh));
        assert!(Arc::ptr_eq(&back.objects[0].parts[0].material, &back.objects[1].parts[1].material));
        assert_eq!(to_bytes(&back), bytes);
    }

    #[test]
    fn the_empty_scene() {
        assert_eq!(from_bytes::<Scene>(Arc::new(to_bytes(&Scene::default()))).unwrap(), Scene::default());
    }

    #[test]
    fn broken_promises_are_found() {
        let broken = |change: fn(&mut Scene)| {
            let mut s = scene(false);
            change(&mut s);
            from_bytes::<Scene>(Arc::new(to_bytes(&s))).unwrap_err().to_string()
        };
        fn mesh(s: &mut Scene) -> &mut Mesh {
            Arc::make_mut(&mut s.objects[0].parts[0].mesh)
        }
        let found = broken(|s| mesh(s).triangles = vec![[0, 1, 3]].into());
        assert_eq!(found, "section `triangles`: mesh 0: an index beyond its 3 vertices");
        let found = broken(|s| mesh(s).positions = vec![[f32::INFINITY; 3]; 3].into());
        assert_eq!(found, "section `positions`: mesh 0: a number that is not finite");
        let found = broken(|s| mesh(s).uv[1] = vec![[0.0; 2]; 2].into());
        assert_eq!(found, "section `mesh_sizes`: mesh 0: attributes of unequal length");
        let found = broken(|s| s.objects[1].name = "a".into());
        assert_eq!(found, "section `names`: not sorted or not unique");
        let found = broken(|s| s.objects[1].transform.x_axis.x = f32::NAN);
        assert_eq!(found, "section `transforms`: b: not finite");
        let found = broken(|s| {
            let material = Arc::make_mut(&mut s.objects[1].parts[0].material);
            let texture = material.base_color_texture.as_mut().unwrap();
            Arc::make_mut(&mut texture.image).width = 4;
        });
        assert_eq!(found, "section `texels`: shorter than its items");
    }

    proptest::proptest! {
        #[test]
        fn damaged_bytes_never_break_a_promise(changes in proptest::collection::vec((0usize..1 << 16, 0u8..=255), 1..6), cut in 0usize..1 << 16) {
            let mut bytes = to_bytes(&scene(false));
            let n = bytes.len();
            for (at, byte) in changes {
                bytes[at % n] = byte;
            }
            if cut % 5 == 0 {
                bytes.truncate(cut % n);
            }
            if let Ok(scene) = from_bytes::<Scene>(Arc::new(bytes)) {
                for part in scene.objects.iter().flat_map(|o| &o.parts) {
                    let n = part.mesh.positions.len();
                    assert!(part.mesh.positions.iter().flatten().all(|x| x.is_finite()));
                    assert!(part.mesh.triangles.iter().flatten().all(|i| (*i as usize) < n));
                }
                assert!(scene.objects.is_sorted_by(|a, b| a.name < b.name));
            }
        }
    }
}
