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
pub struct SpritePlace {
    /// How effects call it; the sprite's name where there is none.
    #[serde(default)]
    pub name: Option<String>,
    /// Name of the sprite: the element of the list. Without one the place takes the sprite of its own number, in the order of the sprites'
    /// names, from the beginning again where there are fewer; then it needs a `name`.
    #[serde(default)]
    pub sprite: Option<String>,
    /// Where the centre of its cube goes, metres; where the solid was if there is none.
    #[serde(default)]
    pub at: Option<[f64; 3]>,
    /// Factor on its size, above 0.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub scale: f64,
    /// Side of its cube, metres, above 0; in place of `scale`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m"))]
    pub size: Option<f64>,
    /// Degrees about the x, then the y, then the z axis, counter-clockwise seen from the axis' tip.
    #[serde(default)]
    pub turn: [f64; 3],
}

fn one() -> f64 {
    1.0
}

impl SpritePlace {
    pub fn name(&self) -> &str {
        self.name.as_deref().or(self.sprite.as_deref()).unwrap_or_default()
    }
}

/// What is wrong with places, if anything.
pub fn check(places: &[SpritePlace]) -> Result<(), (&'static str, String)> {
    for (i, place) in places.iter().enumerate() {
        let name = place.name();
        if name.is_empty() {
            return Err(("places", format!("place {}: expected a `name` or a `sprite`", i + 1)));
        }
        if place.size.is_some() && place.scale != 1.0 {
            return Err(("places", format!("`{name}`: expected either `size` or `scale`, found both")));
        }
        if places[..i].iter().any(|p| p.name() == name) {
            return Err(("places", format!("two places are called `{name}`; give one of them another `name`")));
        }
    }
    Ok(())
}

/// The volumes of `places`, or without any all sprites where they are, by name.
pub fn volumes(places: &[SpritePlace], sprites: &List<Sprite>) -> Result<Vec<(String, Volume)>, NodeError> {
    let new = |sprite: &Sprite, placement: &Placement| Volume::new(sprite.packed.unpack(), &sprite.frame, placement);
    if places.is_empty() {
        let all = sprites.0.iter().map(|(name, s)| (name.clone(), new(s, &Placement::default())));
        return Ok(all.collect());
    }
    let place = |(i, p): (usize, &SpritePlace)| {
        let found = match &p.sprite {
            Some(wanted) => sprites.0.iter().find(|(name, _)| name == wanted),
            None => sprites.0.iter().cycle().nth(i),
        };
        let wanted = p.sprite.as_deref().unwrap_or_default();
        let (_, sprite) = found.ok_or_else(|| unknown("places", wanted, sprites.0.iter().map(|s| &*s.0)))?;
        let scale = p.size.map_or(p.scale, |size| size / sprite.frame.side());
        let [x, y, z] = p.turn.map(f64::to_radians).map(turn);
        let turn = z(DVec3::Z) * y(DVec3::Y) * x(DVec3::X);
        let placement = Placement { centre: p.at.map(DVec3::from), scale, turn };
        Ok((p.name().to_owned(), new(sprite, &placement)))
    };
    places.iter().enumerate().map(place).collect()
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
    use crate::sprite::{CubeFrame, LayeredDepthImage, Layout, Packed};
    use std::sync::Arc;

    fn sprite(depth: f32, side: f64) -> Arc<Sprite> {
        let image = LayeredDepthImage::new([1, 1], [vec![0.0, depth]]);
        let frame = CubeFrame::from_parts([DVec3::X, DVec3::Y, -DVec3::Z], DVec3::ZERO, side).unwrap();
        Arc::new(Sprite { packed: Packed::new(&image, Layout::Raw).unwrap(), frame })
    }

    #[test]
    fn places_without_a_sprite_take_them_in_turn() {
        let sprites = List(vec![("a".to_owned(), sprite(0.5, 2.0)), ("b".to_owned(), sprite(0.25, 8.0))]);
        let place = |name: &str, sprite: Option<&str>, size| SpritePlace {
            name: Some(name.into()),
            sprite: sprite.map(str::to_owned),
            at: None,
            scale: 1.0,
            size,
            turn: [0.0; 3],
        };
        let places = [
            place("one", None, Some(3.0)),
            place("two", None, None),
            place("three", None, Some(1.0)),
            place("four", Some("b"), None),
        ];
        assert_eq!(check(&places), Ok(()));
        let found = volumes(&places, &sprites).unwrap();
        let of = |i: usize| (&*found[i].0, found[i].1.bounds().size().x, found[i].1.image().depths()[1]);
        assert_eq!(
            [0, 1, 2, 3].map(of),
            [("one", 3.0, 0.5), ("two", 8.0, 0.25), ("three", 1.0, 0.5), ("four", 8.0, 0.25)]
        );
        let message = volumes(&[place("one", Some("c"), None)], &sprites).unwrap_err().to_string();
        assert!(message.contains("there is no `c`; there are `a`, `b`"), "{message}");
        let nameless = SpritePlace { name: None, ..place("", None, None) };
        let twice = SpritePlace { scale: 2.0, ..place("one", None, Some(1.0)) };
        for wrong in [nameless, twice] {
            assert!(check(&[wrong]).is_err());
        }
    }

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
