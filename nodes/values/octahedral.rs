//! Octahedral impostors.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    math::Aabb,
    octahedral::{Atlas, Grid, Impostor},
};
use glam::DVec3;
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
struct Head {
    grid: Grid,
    tile: u32,
    /// Of the atlas.
    side: u32,
    orm: bool,
    emissive: bool,
}

impl Artifact for Impostor {
    const TYPE: &'static str = "OctahedralImpostor";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let Self { grid, tile, centre, radius, bounds, card, atlas } = self;
        let (orm, emissive) = (atlas.orm.is_some(), atlas.emissive.is_some());
        out.json("head", &Head { grid: *grid, tile: *tile, side: atlas.side, orm, emissive });
        out.array("window", &[centre.x, centre.y, centre.z, *radius]);
        out.array("bounds", &[bounds.min.to_array(), bounds.max.to_array()]);
        out.array("card", card);
        out.array("color", &atlas.color);
        out.array("normal", &atlas.normal);
        for (name, image) in [("orm", &atlas.orm), ("emissive", &atlas.emissive)] {
            if let Some(image) = image {
                out.array(name, image);
            }
        }
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let head: Head = data.json("head")?;
        let window = data.array::<f64>("window")?;
        let bounds = data.array::<[f64; 3]>("bounds")?;
        let (&[x, y, z, radius], &[min, max]) = (&window[..], &bounds[..]) else {
            return Err(DecodeError::section("window", "expected a centre with a radius, and a box"));
        };
        let impostor = Self {
            grid: head.grid,
            tile: head.tile,
            centre: DVec3::new(x, y, z),
            radius,
            bounds: Aabb { min: DVec3::from(min), max: DVec3::from(max) },
            card: data.array("card")?.into_vec(),
            atlas: Atlas {
                side: head.side,
                color: data.array("color")?,
                normal: data.array("normal")?,
                orm: head.orm.then(|| data.array("orm")).transpose()?,
                emissive: head.emissive.then(|| data.array("emissive")).transpose()?,
            },
        };
        match impostor.fault() {
            Some(what) => Err(DecodeError::section("head", what)),
            None => Ok(impostor),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::artifact::{from_bytes, to_bytes};
    use std::sync::Arc;

    fn impostor(orm: bool) -> Impostor {
        let image = |v: u8| -> crate::array::Array<[u8; 4]> { vec![[v; 4]; 48 * 48].into() };
        Impostor {
            grid: Grid { side: 3, hemi: false },
            tile: 16,
            centre: DVec3::ONE,
            radius: 2.0,
            bounds: Aabb { min: DVec3::ZERO, max: DVec3::ONE },
            card: vec![[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]],
            atlas: Atlas {
                side: 48,
                color: image(1),
                normal: image(2),
                orm: orm.then(|| image(3)),
                emissive: orm.then(|| image(4)),
            },
        }
    }

    #[test]
    fn decodes_what_was_encoded() {
        for orm in [false, true] {
            assert_eq!(from_bytes::<Impostor>(Arc::new(to_bytes(&impostor(orm)))), Ok(impostor(orm)));
        }
    }

    #[test]
    fn refuses_what_cannot_be_drawn() {
        let breaks: [fn(&mut Impostor); 6] = [
            |i| i.atlas.side = 32,
            |i| i.tile = 24,
            |i| i.grid.side = 2,
            |i| i.radius = 0.0,
            |i| i.card.truncate(2),
            |i| i.atlas.orm = Some(vec![[0; 4]; 7].into()),
        ];
        for change in breaks {
            let mut wrong = impostor(true);
            change(&mut wrong);
            assert!(from_bytes::<Impostor>(Arc::new(to_bytes(&wrong))).is_err());
        }
    }
}
