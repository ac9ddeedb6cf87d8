//! Materials as common viewers show them, and what the user should know of one that does not come out as expected.

use crate::scene::{Alpha, Material, Texture};

/// Linear; a few of sRGB's 256 levels.
const BLACK: f32 = 1.0 / 1024.0;

/// What is said of a material that mixes.
pub(super) const BLEND: &str =
    "is BLEND and drawn as a mask at 0.5: what has less alpha vanishes, the rest hides what is behind it";

/// `material` as viewers show it where its base colour alone would not: a picture that is emissive on a black base, the way before
/// KHR_materials_unlit, becomes an unlit base colour. The text says why it did not where it could not.
pub(super) fn as_viewers_show(material: Material) -> (Material, Option<&'static str>) {
    let shines = material.emissive.iter().any(|c| *c > 0.0);
    if material.unlit || !shines || !black(&material) {
        return (material, None);
    }
    // The holes are those of the base colour.
    let holes = material.alpha != Alpha::Opaque && material.base_color_texture.as_ref().is_some_and(transparent);
    if holes {
        return (
            material,
            Some("is black: it is emissive on a black base whose texture has holes; give it its colour as base colour"),
        );
    }
    let [r, g, b] = material.emissive.map(|c| c.min(1.0));
    let base_color = [r, g, b, material.base_color[3]];
    let base_color_texture = material.emissive_texture.clone();
    let shown = Material {
        base_color,
        base_color_texture,
        emissive: [0.0; 3],
        emissive_texture: None,
        unlit: true,
        ..material
    };
    (shown, None)
}

/// Why a material is invisible, black, or hides what it should not; the worst of these.
pub(super) fn trouble(material: &Material) -> Option<&'static str> {
    let alpha = material.base_color[3];
    let opaque = || !material.base_color_texture.as_ref().is_some_and(transparent);
    match material.alpha {
        Alpha::Mask { cutoff } if alpha < cutoff => {
            return Some("is invisible: its alpha lies below its cutoff everywhere");
        }
        Alpha::Blend if alpha < 0.5 => {
            return Some("is invisible: BLEND is drawn as a mask at 0.5, and its alpha lies below that everywhere");
        }
        Alpha::Blend if alpha < 1.0 || !opaque() => {
            return Some(BLEND);
        }
        _ => {}
    }
    if !black(material) {
        return None;
    }
    Some(match material.base_color[..3].iter().any(|c| *c > BLACK) {
        false => "is black: its base colour factor is 0",
        true => "is black: its base colour texture is",
    })
}

/// Also as lossy images and editors round black.
fn black(material: &Material) -> bool {
    let factor = material.base_color[..3].iter().all(|c| *c <= BLACK);
    let dark = |t: &Texture| t.image.texels.iter().all(|c| c[..3].iter().all(|c| *c <= 4));
    factor || material.base_color_texture.as_ref().is_some_and(dark)
}

fn transparent(texture: &Texture) -> bool {
    texture.image.texels.iter().any(|t| t[3] < 255)
}
