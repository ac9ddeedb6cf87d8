//! The files of one cell, and the scene that a program draws in it.

use crate::{
    atlas::pack::pack,
    lod::{
        entry::{Entry, StandInRow},
        subject::{Subject, Views},
        texture::Textured,
    },
    raster::Geometry,
    runtime::SceneStandIn,
    scene::{Image, Material, Mesh, Object, Part, Scene, Texture},
    texture::{Format, TextureArray, ktx2, mip::Level},
};
use glam::{DVec3, Mat4};
use std::sync::Arc;

/// Sides of patches on atlases are multiples of this: a block of BC1, and two mip levels.
const ALIGN: u32 = 4;

/// What a cell's files are made of.
pub struct CellFiles {
    /// An object for each stand-in that shows something, at the cell's centre; their materials share the atlases.
    pub scene: Scene,
    /// The cell's row of the manifest, without the files' sizes.
    pub row: Entry,
    atlases: Vec<Arc<Image>>,
}

/// The files of a cell: `entry` is its row without stand-ins, `stand_ins` are sorted by name. Atlases are at most `page` texels wide.
///
/// # Errors
/// Where a texture is larger than a page: a message.
pub fn cell_files(entry: &Entry, stand_ins: &[(&str, &Subject, &Textured)], page: u32) -> Result<CellFiles, String> {
    let patches: Vec<_> = stand_ins.iter().flat_map(|(name, _, t)| t.patches.iter().map(move |p| (*name, p))).collect();
    let blocks = |n: u32| n.div_ceil(ALIGN);
    let sizes: Vec<[u32; 2]> = patches.iter().map(|(_, p)| [blocks(p.width), blocks(p.height)]).collect();
    let mut packing = match pack(&sizes, page / ALIGN) {
        Some(packing) => packing,
        None => {
            let largest = patches.iter().max_by_key(|(_, p)| p.width.max(p.height));
            let (name, w, h) = largest.map_or(("", 0, 0), |(n, p)| (*n, p.width, p.height));
            return Err(format!(
                "a texture of `{name}` has {w} × {h} texels, an atlas page at most {page} × {page}; expected a larger `page` or a smaller `resolution`"
            ));
        }
    };
    // Pages end with the last row that is in use.
    for (i, [_, height]) in packing.pages.iter_mut().enumerate() {
        let tops = packing.places.iter().zip(&sizes).filter(|(slot, _)| slot.page as usize == i);
        *height = tops.map(|(slot, size)| slot.y + size[1]).max().unwrap_or(*height);
    }
    let mut pages: Vec<Vec<[u8; 4]>> =
        packing.pages.iter().map(|s| vec![[0, 0, 0, 255]; (s[0] * s[1] * ALIGN * ALIGN) as usize]).collect();
    for ((_, patch), slot) in patches.iter().zip(&packing.places) {
        let width = packing.pages[slot.page as usize][0] * ALIGN;
        let texels = &mut pages[slot.page as usize];
        // Beyond the patch its last row and column go on, up to whole blocks.
        for y in 0..blocks(patch.height) * ALIGN {
            for x in 0..blocks(patch.width) * ALIGN {
                let from = y.min(patch.height - 1) * patch.width + x.min(patch.width - 1);
                texels[((slot.y * ALIGN + y) * width + slot.x * ALIGN + x) as usize] = patch.texels[from as usize];
            }
        }
    }
    let atlases: Vec<Arc<Image>> = pages
        .into_iter()
        .zip(&packing.pages)
        .enumerate()
        .map(|(i, (texels, size))| {
            let [width, height] = size.map(|n| n * ALIGN);
            Arc::new(Image { name: format!("atlas {i}"), width, height, texels: texels.into() })
        })
        .collect();
    let materials: Vec<Arc<Material>> = atlases.iter().map(|image| Arc::new(material(image.clone()))).collect();
    let mut scene = Scene::default();
    let mut row =
        Entry { texels: atlases.iter().map(|a| u64::from(a.width) * u64::from(a.height)).sum(), ..entry.clone() };
    let mut first = 0;
    let centre = Mat4::from_translation(DVec3::from(entry.centre).as_vec3());
    for (name, subject, t) in stand_ins {
        let slots = &packing.places[first..first + t.patches.len()];
        first += t.patches.len();
        row.triangles += t.triangles.len() as u64;
        row.stand_ins.push(StandInRow {
            name: (*name).to_owned(),
            objects: subject.members.iter().map(|m| m.0.clone()).collect(),
            kind: if subject.views == Views::Multi { "mv" } else { "sv" }.into(),
            triangles: t.triangles.len() as u64,
            texels: t.patches.iter().map(|p| u64::from(p.width) * u64::from(p.height)).sum(),
        });
        let mut parts = Vec::new();
        for (i, atlas) in atlases.iter().enumerate() {
            let on_page = |c: &&[u32; 3]| slots[t.patch[c[0] as usize] as usize].page as usize == i;
            let triangles: Vec<[u32; 3]> = t.triangles.iter().filter(on_page).copied().collect();
            if !triangles.is_empty() {
                let size = [atlas.width, atlas.height];
                parts.push(Part { mesh: Arc::new(mesh(t, triangles, size, slots)), material: materials[i].clone() });
            }
        }
        if !parts.is_empty() {
            scene.objects.push(Object { name: (*name).to_owned(), transform: centre, parts });
        }
    }
    Ok(CellFiles { scene, row, atlases })
}

impl CellFiles {
    /// The atlases as BC1 in KTX2, a file of layers of one size; no bytes where there are none.
    ///
    /// # Errors
    /// A message, where they cannot be stored.
    pub fn ktx2(&self) -> Result<Vec<u8>, String> {
        if self.atlases.is_empty() {
            return Ok(Vec::new());
        }
        // Layers of an array have one size.
        let width = self.atlases.iter().map(|a| a.width).max().unwrap_or(1);
        let height = self.atlases.iter().map(|a| a.height).max().unwrap_or(1);
        let layer = |a: &Arc<Image>| {
            let texel = |i: u32| {
                let (x, y) = (i % width, i / width);
                if x < a.width && y < a.height { a.texels[(y * a.width + x) as usize] } else { [0, 0, 0, 255] }
            };
            vec![Level { width, height, texels: (0..width * height).map(texel).collect() }]
        };
        let layers: Vec<Vec<Level>> = self.atlases.iter().map(layer).collect();
        let array = TextureArray::encode(Format::Bc1, true, &layers).map_err(|e| e.to_string())?;
        ktx2::write(&array).map_err(|e| e.to_string())
    }
}

/// Colours without light, clamped at the atlas' edge.
fn material(image: Arc<Image>) -> Material {
    let texture = Texture::clamped(image);
    Material {
        name: "captured".into(),
        unlit: true,
        double_sided: false,
        base_color_texture: Some(texture),
        ..Material::default()
    }
}

/// The `triangles` of a stand-in that lie on one page of `size` texels.
fn mesh(t: &Textured, triangles: Vec<[u32; 3]>, size: [u32; 2], slots: &[crate::atlas::pack::AtlasSlot]) -> Mesh {
    let (used, triangles) = crate::mesh::simplify::compact(t.positions.len(), &triangles);
    let used = || used.iter().map(|v| *v as usize);
    let uv = |v: usize| {
        let slot = slots[t.patch[v] as usize];
        let at = [(slot.x * ALIGN) as f32 + t.uv[v][0], (slot.y * ALIGN) as f32 + t.uv[v][1]];
        [at[0] / size[0] as f32, at[1] / size[1] as f32]
    };
    Mesh {
        positions: used().map(|v| t.positions[v]).collect(),
        uv: [used().map(uv).collect(), used().map(|v| [t.depth[v], 0.0]).collect()],
        triangles: triangles.into(),
        ..Mesh::default()
    }
}

/// What [`cell_scene`] gives, drawn with projective texture coordinates: the twin of shaders/hybrid_lod.wgsl. `geometry` is that of `scene`.
pub fn cell_stand_in<'a>(scene: &Scene, geometry: &'a Geometry, entry: &Entry) -> SceneStandIn<'a> {
    SceneStandIn::projective(scene, geometry, |name| {
        entry.inside.binary_search_by(|inside| inside.as_str().cmp(name)).is_err()
    })
}

/// What a program draws in a cell: its stand-ins, and the objects of `original` that are drawn as they are.
pub fn cell_scene(stand_ins: Scene, entry: &Entry, original: &Scene) -> Scene {
    let mut scene = stand_ins;
    // Names of stand-ins are those of objects that are not inside.
    let inside = original.objects.iter().filter(|o| entry.inside.binary_search(&o.name).is_ok());
    scene.objects.extend(inside.cloned());
    scene.objects.sort_by(|a, b| a.name.cmp(&b.name));
    scene
}
