//! What the kinds that ask depth sprites at run time have in common: where the sprites are put.

use super::values::Sprite;
use crate::{
    engine::node::{List, NodeError},
    sprite::{Placement, Volume},
};
use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A sprite in the world. Several may show the same one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// How effects call it; the sprite's name where there is none.
    #[serde(default)]
    pub name: Option<String>,
    /// Name of the sprite: the element of the list.
    pub sprite: String,
    /// Where the centre of its cube goes, metres; where the solid was if there is none.
    #[serde(default)]
    pub at: Option<[f64; 3]>,
    /// Factor on its size, above 0.
    #[serde(default = "one")]
    pub scale: f64,
    /// Degrees about the x, then the y, then the z axis, counter-clockwise seen from the axis' tip.
    #[serde(default)]
    pub turn: [f64; 3],
}

fn one() -> f64 {
    1.0
}

impl Place {
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.sprite)
    }
}

/// What is wrong with places, if anything.
pub fn check(places: &[Place]) -> Result<(), (&'static str, String)> {
    for (i, place) in places.iter().enumerate() {
        let name = place.name();
        if !(place.scale > 0.0 && place.scale.is_finite()) {
            return Err(("places", format!("`{name}`: expected a scale above 0, found {}", place.scale)));
        }
        let numbers = place.at.iter().flatten().chain(&place.turn);
        if let Some(wrong) = numbers.into_iter().find(|v| !v.is_finite()) {
            return Err(("places", format!("`{name}`: expected finite coordinates and angles, found {wrong}")));
        }
        if places[..i].iter().any(|p| p.name() == name) {
            return Err(("places", format!("two places are called `{name}`; give one of them another `name`")));
        }
    }
    Ok(())
}

/// The volumes of `places`, or without any all sprites where they are, by name.
pub fn volumes(places: &[Place], sprites: &List<Sprite>) -> Result<Vec<(String, Volume)>, NodeError> {
    let new = |sprite: &Sprite, placement: &Placement| Volume::new(sprite.packed.unpack(), &sprite.frame, placement);
    if places.is_empty() {
        let all = sprites.0.iter().map(|(name, s)| (name.clone(), new(s, &Placement::default())));
        return Ok(all.collect());
    }
    let place = |p: &Place| {
        let found = sprites.0.iter().find(|(name, _)| *name == p.sprite);
        let (_, sprite) = found.ok_or_else(|| unknown("places", &p.sprite, sprites.0.iter().map(|s| &*s.0)))?;
        let [x, y, z] = p.turn.map(f64::to_radians).map(turn);
        let turn = z(DVec3::Z) * y(DVec3::Y) * x(DVec3::X);
        let placement = Placement { centre: p.at.map(DVec3::from), scale: p.scale, turn };
        Ok((p.name().to_owned(), new(sprite, &placement)))
    };
    places.iter().map(place).collect()
}

/// The rotation by an angle (Rodrigues), with sine and cosine that are the same everywhere.
fn turn(angle: f64) -> impl Fn(DVec3) -> DMat3 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    move |a| {
        let cross =
            DMat3::from_cols(DVec3::new(0.0, a.z, -a.y), DVec3::new(-a.z, 0.0, a.x), DVec3::new(a.y, -a.x, 0.0));
        let outer = DMat3::from_cols(a * a.x, a * a.y, a * a.z);
        DMat3::IDENTITY * cos + cross * sin + outer * (1.0 - cos)
    }
}

/// An error for a name that is none of `known`.
pub fn unknown<'a>(param: &str, name: &str, known: impl Iterator<Item = &'a str>) -> NodeError {
    let known: Vec<_> = known.map(|n| format!("`{n}`")).collect();
    NodeError::Failed(format!("{param}: there is no `{name}`; there are {}", known.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_the_axes() {
        let quarter = turn(std::f64::consts::FRAC_PI_2);
        for (axis, from, to) in
            [(DVec3::X, DVec3::Y, DVec3::Z), (DVec3::Y, DVec3::Z, DVec3::X), (DVec3::Z, DVec3::X, DVec3::Y)]
        {
            assert!((quarter(axis) * from - to).length() < 1e-12);
            assert!((quarter(axis) * axis - axis).length() < 1e-12);
        }
    }
}
