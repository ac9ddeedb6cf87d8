//! Layered depth images of solids, and along which direction they are peeled.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    sprite::{CubeFrame, DepthQuantizer, Direction, LayeredDepthImage, Layout, OddRay, Packed, Peeled, Region, Repair},
};
use glam::DVec3;

/// A direction that was chosen, and among what.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenDirection {
    pub direction: Direction,
    /// Least and greatest depth complexity of the directions that were judged; the least is that of the chosen one.
    pub depth_complexity: [u32; 2],
}

/// A packed image with its place in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Sprite {
    pub packed: Packed,
    pub frame: CubeFrame,
}

impl Artifact for ChosenDirection {
    const TYPE: &'static str = "Direction";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let [_, up, forward] = self.direction.axes();
        out.array("axes", &[forward.to_array(), up.to_array()]);
        out.array("depth_complexity", &self.depth_complexity);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (axes, complexity) = (data.array::<[f64; 3]>("axes")?, data.array::<u32>("depth_complexity")?);
        let ([forward, up], [least, most]) = (&axes[..], &complexity[..]) else {
            return Err(DecodeError::section("axes", "expected two axes and two depth complexities"));
        };
        let direction = Direction::from_parts(DVec3::from(*forward), DVec3::from(*up));
        let direction = direction.ok_or_else(|| DecodeError::section("axes", "they are not orthonormal"))?;
        Ok(Self { direction, depth_complexity: [*least, *most] })
    }
}

fn put(out: &mut Encoder, image: &LayeredDepthImage, frame: &CubeFrame) {
    let ([right, up, forward], centre, side) = frame.parts();
    let axes = [right, up, forward, centre].map(|v| v.to_array());
    out.array("frame", &axes);
    out.array("side", &[side]);
    let (Region { x, y, width, height }, size) = (image.region(), image.size());
    out.array("region", &[size[0], size[1], x, y, width, height]);
    out.array("starts", image.starts());
    out.array("depths", image.depths());
}

fn get(data: &Decoder) -> Result<(LayeredDepthImage, CubeFrame), DecodeError> {
    let (axes, side) = (data.array::<[f64; 3]>("frame")?, data.array::<f64>("side")?);
    let ([right, up, forward, centre], [side]) = (&axes[..], &side[..]) else {
        return Err(DecodeError::section("frame", "expected four vectors and a length"));
    };
    let frame = CubeFrame::from_parts([*right, *up, *forward].map(DVec3::from), DVec3::from(*centre), *side);
    let frame = frame.ok_or_else(|| DecodeError::section("frame", "no orthonormal axes and a side above 0"))?;
    let region = data.array::<u32>("region")?;
    let [w, h, x, y, width, height] = region[..] else {
        return Err(DecodeError::section("region", format!("expected six numbers, found {}", region.len())));
    };
    let region = Region { x, y, width, height };
    let (starts, depths) = (data.array("starts")?.into_vec(), data.array("depths")?.into_vec());
    let image = LayeredDepthImage::from_parts([w, h], region, starts, depths);
    Ok((image.map_err(|what| DecodeError::section("depths", what))?, frame))
}

/// By their numbers in files.
const REPAIRS: [Repair; 4] = [Repair::None, Repair::Drop, Repair::Pair, Repair::Winding];

impl Artifact for Peeled {
    const TYPE: &'static str = "LayeredDepthImage";
    const FORMAT: u32 = 2;

    fn encode(&self, out: &mut Encoder) {
        put(out, &self.image, &self.frame);
        let odd: Vec<[u32; 3]> = self.odd.iter().map(|o| [o.texel[0], o.texel[1], o.crossings]).collect();
        out.array("odd", &odd);
        let repair = REPAIRS.iter().position(|r| *r == self.repair).unwrap_or(0);
        out.array("repair", &[repair as u32]);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (image, frame) = get(data)?;
        let odd = data.array::<[u32; 3]>("odd")?;
        let odd = odd.iter().map(|[x, y, crossings]| OddRay { texel: [*x, *y], crossings: *crossings }).collect();
        let repair = match data.array::<u32>("repair")?[..] {
            [r] => REPAIRS.get(r as usize).copied(),
            _ => None,
        };
        let repair = repair.ok_or_else(|| DecodeError::section("repair", "expected the number of a repair"))?;
        Ok(Self { image, frame, odd, repair })
    }
}

impl Artifact for Sprite {
    const TYPE: &'static str = "DepthSprite";
    const FORMAT: u32 = 2;

    /// The image is stored as it is and packed again when it is read.
    fn encode(&self, out: &mut Encoder) {
        put(out, &self.packed.unpack(), &self.frame);
        out.array("layout", &[self.packed.layout() as u32]);
        let grid: Vec<u32> = self.packed.grid().iter().flat_map(DepthQuantizer::parts).collect();
        out.array("grid", &grid);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (image, frame) = get(data)?;
        let layout = data.array::<u32>("layout")?;
        let named = Layout::ALL.into_iter().find(|l| layout[..] == [*l as u32]);
        let packed = match data.array::<u32>("grid")?[..] {
            [] => named.and_then(|layout| Packed::new(&image, layout)),
            [exponent, base] => DepthQuantizer::from_parts([exponent, base])
                .and_then(|grid| Packed::short(&image, named?, grid))
                // What is stored must be what it says.
                .filter(|packed| packed.unpack() == image),
            _ => None,
        };
        let packed =
            packed.ok_or_else(|| DecodeError::section("layout", format!("{:?} cannot hold it", &layout[..])))?;
        Ok(Self { packed, frame })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::artifact::{from_bytes, to_bytes},
        sprite::{Placement, Ray, Volume},
    };
    use proptest::prelude::*;
    use std::sync::Arc;

    fn peeled() -> Peeled {
        let image = LayeredDepthImage::new([2, 2], [vec![], vec![0.25, 0.5], vec![0.0, 0.125, 0.5, 0.75], vec![]]);
        let frame = CubeFrame::from_parts([DVec3::X, DVec3::Y, -DVec3::Z], DVec3::new(1.0, 2.0, 3.0), 4.0).unwrap();
        Peeled { image, frame, odd: vec![OddRay { texel: [1, 1], crossings: 3 }], repair: Repair::Pair }
    }

    #[test]
    fn decodes_what_was_encoded() {
        let peeled = peeled();
        assert_eq!(from_bytes::<Peeled>(Arc::new(to_bytes(&peeled))), Ok(peeled.clone()));
        for layout in Layout::ALL {
            let packed = Packed::new(&peeled.image.crop().unwrap(), layout).unwrap();
            let sprite = Sprite { packed, frame: peeled.frame };
            assert_eq!(from_bytes::<Sprite>(Arc::new(to_bytes(&sprite))), Ok(sprite));
        }
        let grid = DepthQuantizer::around(&peeled.image);
        let packed = Packed::smallest(&peeled.image, Some(grid)).unwrap();
        assert_eq!(packed.grid(), Some(grid));
        let sprite = Sprite { packed, frame: peeled.frame };
        assert_eq!(from_bytes::<Sprite>(Arc::new(to_bytes(&sprite))), Ok(sprite));
        let choice = ChosenDirection { direction: Direction::new(DVec3::ONE).unwrap(), depth_complexity: [4, 10] };
        assert_eq!(from_bytes::<ChosenDirection>(Arc::new(to_bytes(&choice))), Ok(choice));
    }

    #[test]
    fn refuses_depths_in_disorder() {
        let bytes = to_bytes(&peeled());
        // The first depth is 0.25; anything at or above 1 stands for no depth, and ranges ascend.
        let at = bytes.windows(4).position(|w| w == 0.25f32.to_le_bytes()).unwrap();
        for wrong in [1.0f32, -0.5, f32::NAN, 0.75] {
            let mut damaged = bytes.clone();
            damaged[at..at + 4].copy_from_slice(&wrong.to_le_bytes());
            assert!(from_bytes::<Peeled>(Arc::new(damaged)).is_err(), "{wrong}");
        }
    }

    fn sprites() -> Vec<Sprite> {
        let Peeled { image, frame, .. } = peeled();
        let grid = DepthQuantizer::around(&image);
        let packed = Layout::ALL.map(|l| [Packed::new(&image, l), Packed::short(&image, l, grid)]);
        packed.into_iter().flatten().flatten().map(|packed| Sprite { packed, frame }).collect()
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_sprite_that_can_be_asked_or_an_error(
            which in 0..6usize, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), keep in 0.2..1.2f64,
        ) {
            let mut bytes = to_bytes(&sprites()[which]);
            for (at, byte) in changes {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            bytes.truncate((bytes.len() as f64 * keep) as usize);
            let bytes = Arc::new(bytes);
            let _ = from_bytes::<Peeled>(bytes.clone());
            if let Ok(Sprite { packed, frame }) = from_bytes::<Sprite>(bytes) {
                let volume = Volume::new(packed.unpack(), &frame, &Placement::default());
                let ray = Ray { origin: volume.bounds().min, direction: DVec3::new(0.3, 0.5, 0.7) };
                for span in volume.spans(&ray) {
                    volume.normal(&ray, &span.enter);
                }
                packed.contains([0.5, 0.5, 0.5]);
                prop_assert!(packed.file().0.len() >= packed.values() * 4 - 2);
            }
        }
    }
}
