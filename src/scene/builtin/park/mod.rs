//! A statuary park: a few kinds of statue in many places, each mesh in memory once. 1650 × 2035 m by default, as the scenes of Chen et
//! al. 2003, section 4.1.1. The statues stand on y = 0; there is no ground.

mod place;
mod sculpt;
mod statues;
mod stone;
#[cfg(test)]
mod tests;

pub use place::{CLEARANCE, DETAIL, Footprint, LONGEST_SIDE, MOST_STATUES, Park, ParkError, Place, places};

use crate::{
    math::Aabb,
    scene::{Mesh, Object, Part, Scene},
};
use glam::{DMat4, DVec3};
use std::{collections::BTreeMap, sync::Arc};
use stone::Stone;

/// A kind of statue.
#[derive(Clone, Debug)]
pub struct Statue {
    pub name: String,
    /// Puts its parts on y = 0 around the y axis.
    pub stand: DMat4,
    pub parts: Vec<Part>,
    pub footprint: Footprint,
}

impl Statue {
    /// The object as a kind of statue: its base on the ground, the middle of its bounds over the origin, in the size and attitude that
    /// its transform gives it.
    ///
    /// # Errors
    /// Where the object has no triangle, or no finite or no positive extent.
    pub fn new(object: &Object, share: u32) -> Result<Self, ParkError> {
        let fault = |what: &str| Err(ParkError::Kind { name: object.name.clone(), what: what.into() });
        let bounds = object.bounds();
        if bounds.is_empty() {
            return fault("it has no triangles");
        }
        let middle = bounds.centre().with_y(bounds.min.y);
        let stand = DMat4::from_translation(-middle) * object.transform.as_dmat4();
        let alone = Scene { objects: vec![Object { transform: object.transform, ..object.clone() }] };
        let across = |p: DVec3| {
            let d = p - middle;
            d.x * d.x + d.z * d.z
        };
        let radius = alone.points().into_iter().map(across).fold(0.0, f64::max).sqrt();
        if !(radius > 0.0 && radius.is_finite() && stand.is_finite()) {
            return fault("it has no width");
        }
        Ok(Self {
            name: object.name.clone(),
            stand,
            parts: object.parts.clone(),
            footprint: Footprint { radius, share },
        })
    }

    /// The statue at a place; its name is that of its kind and its number, `bunny.007`.
    pub fn at(&self, place: &Place) -> Object {
        let transform = turned(place) * self.stand;
        Object { name: place_name(&self.name, place), transform: transform.as_mat4(), parts: self.parts.clone() }
    }
}

/// The name of a statue of the kind `kind`.
pub fn place_name(kind: &str, place: &Place) -> String {
    format!("{kind}.{:03}", place.number)
}

/// Turned about y, then moved.
fn turned(place: &Place) -> DMat4 {
    let (s, c) = (libm::sin(place.turn), libm::cos(place.turn));
    DMat4::from_cols_array(&[c, 0.0, -s, 0.0, 0.0, 1.0, 0.0, 0.0, s, 0.0, c, 0.0, place.x, 0.0, place.z, 1.0])
}

/// The procedural kinds. `detail` multiplies the cells along each direction of a surface; `shares` as in [`of_models`].
///
/// # Errors
/// A detail outside of [`DETAIL`], and where shares and kinds are not as many.
pub fn procedural(detail: f64, shares: &[u32]) -> Result<Vec<Statue>, ParkError> {
    if !(DETAIL[0]..=DETAIL[1]).contains(&detail) {
        return Err(ParkError::Detail(detail));
    }
    let object = |kind: statues::Kind| {
        let parts = vec![Part { mesh: kind.mesh, material: kind.material }];
        Object { name: kind.name.into(), transform: glam::Mat4::IDENTITY, parts }
    };
    of_models(&Scene { objects: statues::kinds(detail).into_iter().map(object).collect() }, shares)
}

/// The objects of `models` as kinds, in the order of their names. `shares` has one number for each, or none: all alike. What has neither
/// texture nor colours of vertices is coloured like stone, a kind of stone for each object, times its material's base colour.
///
/// # Errors
/// Without any object, and where shares and kinds are not as many.
pub fn of_models(models: &Scene, shares: &[u32]) -> Result<Vec<Statue>, ParkError> {
    let mut objects: Vec<&Object> = models.objects.iter().collect();
    objects.sort_by(|a, b| a.name.cmp(&b.name));
    if objects.is_empty() {
        return Err(ParkError::NoKinds);
    }
    if !shares.is_empty() && shares.len() != objects.len() {
        let names = objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(ParkError::Shares { found: shares.len(), kinds: objects.len(), names });
    }
    let mut painted = BTreeMap::new();
    let statue = |(i, object): (usize, &&Object)| {
        let mut object = (*object).clone();
        paint(&mut object, i, &mut painted);
        Statue::new(&object, shares.get(i).copied().unwrap_or(1))
    };
    objects.iter().enumerate().map(statue).collect()
}

/// Meshes that are painted, by stone and address; the unpainted one is kept, so that no other takes its address.
type Painted = BTreeMap<(usize, usize), (Arc<Mesh>, Arc<Mesh>)>;

fn paint(object: &mut Object, stone: usize, painted: &mut Painted) {
    for part in &mut object.parts {
        if part.material.base_color_texture.is_some() || !part.mesh.colors.is_empty() {
            continue;
        }
        let plain = part.mesh.clone();
        let entry = painted.entry((stone, Arc::as_ptr(&plain).addr()));
        let (_, mesh) = entry.or_insert_with(|| {
            let points = plain.positions.iter().map(|p| glam::Vec3::from(*p));
            let colors = Stone::nth(stone).colors(&plain.positions, Aabb::of(points).diagonal() as f32);
            let mesh = Mesh { colors: colors.into(), ..(*plain).clone() };
            (plain, Arc::new(mesh))
        });
        part.mesh = mesh.clone();
    }
}

/// The park: statues of these kinds, sorted by name. A smaller count gives a subset of it.
///
/// # Errors
/// What [`places`] refuses, and kinds of one name.
pub fn scatter(kinds: &[Statue], park: &Park) -> Result<Scene, ParkError> {
    let footprints: Vec<Footprint> = kinds.iter().map(|k| k.footprint).collect();
    let mut names: Vec<&str> = kinds.iter().map(|k| k.name.as_str()).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|w| w[0] == w[1]) {
        return Err(ParkError::Kind { name: twice[0].into(), what: "two kinds have this name".into() });
    }
    let places = places(&footprints, park)?;
    let mut objects: Vec<Object> = places.iter().map(|p| kinds[p.kind].at(p)).collect();
    objects.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(Scene { objects })
}

/// `builtin:park`: the default park of procedural statues.
pub fn park(seed: u64) -> Scene {
    // Sixty-four circles on a twelfth of the area find their places whatever the seed.
    procedural(1.0, &[]).and_then(|kinds| scatter(&kinds, &Park { seed, ..Park::default() })).unwrap_or_default()
}
