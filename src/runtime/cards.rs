//! Pictures of an object on cards, as a GLB that any viewer opens. An approximation: each card is right only from its own side.

use crate::{
    array::Array,
    formats::{FormatError, GlbOptions, write_glb},
    scene::{Alpha, Image, Material, Mesh, Object, Part, Scene, Texture},
};
use glam::{DVec3, Mat4};
use std::sync::Arc;

/// A square picture in space.
pub(super) struct Card {
    /// Unit vector towards those who see its front.
    pub normal: DVec3,
    /// sRGB, row by row from the top; alpha cuts at one half. All cards have as many texels.
    pub texels: Vec<[u8; 4]>,
    /// Its corners from the object's origin, metres, in the order of [`CORNERS`].
    pub corners: [DVec3; 4],
}

/// The corners of a card: to the right and up from its middle, counter-clockwise from the lower left.
pub(super) const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];

/// The bytes of a GLB file with one object `name`: all cards, `side` texels wide, with one texture. `origin` is the object's
/// translation.
///
/// # Errors
/// Where the file cannot be written.
pub(super) fn glb(
    name: &str,
    side: u32,
    origin: DVec3,
    both_sides: bool,
    cards: &[Card],
) -> Result<Vec<u8>, FormatError> {
    let (mut positions, mut normals, mut uv, mut triangles) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut texels = Vec::with_capacity(cards.len() * side as usize * side as usize);
    for (i, card) in cards.iter().enumerate() {
        // One picture below another.
        texels.extend_from_slice(&card.texels);
        let normal = card.normal.as_vec3().to_array();
        let first = positions.len() as u32;
        for (corner, (x, y)) in card.corners.iter().zip(CORNERS) {
            positions.push(corner.as_vec3().to_array());
            normals.push(normal);
            uv.push([0.5 + 0.5 * x as f32, (i as f32 + 0.5 - 0.5 * y as f32) / cards.len() as f32]);
        }
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let image = Image { name: "color".into(), width: side, height: side * cards.len() as u32, texels: texels.into() };
    let texture = Texture::clamped(Arc::new(image));
    let material = Material {
        name: name.into(),
        base_color_texture: Some(texture),
        alpha: Alpha::Mask { cutoff: 0.5 },
        double_sided: both_sides,
        unlit: true,
        ..Material::default()
    };
    let mesh = Mesh {
        positions: positions.into(),
        normals: normals.into(),
        uv: [uv.into(), Array::default()],
        triangles: triangles.into(),
        ..Mesh::default()
    };
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    let object = Object { name: name.into(), transform: Mat4::from_translation(origin.as_vec3()), parts: vec![part] };
    write_glb(&Scene { objects: vec![object] }, &GlbOptions::default())
}
