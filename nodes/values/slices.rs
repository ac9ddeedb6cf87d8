//! How a cell's surroundings are cut into frusta and layers, and the voxels seen in them.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    view::Cell,
    voxel::{Across, Field, Frustum, Side, Slices},
};
use glam::DVec3;

/// A frustum as numbers: right, up, forward, then the window's left, right, bottom and top.
type FrustumNumbers = [f64; 13];
/// Width, height, then for each side (frustum, side, reversed); a frustum of `u32::MAX` means "none".
type ImageNumbers = [u32; 14];

fn frame(f: &Frustum) -> FrustumNumbers {
    let mut out = [0.0; 13];
    for (i, v) in [f.right, f.up, f.forward].into_iter().enumerate() {
        out[3 * i..3 * i + 3].copy_from_slice(&v.to_array());
    }
    out[9..].copy_from_slice(&[f.left, f.right_tan, f.bottom, f.top]);
    out
}

fn image(f: &Frustum) -> ImageNumbers {
    let mut out = [0; 14];
    out[..2].copy_from_slice(&f.size);
    for (i, across) in f.across.iter().enumerate() {
        let link = across.map_or([u32::MAX, 0, 0], |a| [a.frustum, a.side as u32, u32::from(a.reversed)]);
        out[2 + 3 * i..5 + 3 * i].copy_from_slice(&link);
    }
    out
}

fn frustum(frame: &FrustumNumbers, image: &ImageNumbers) -> Result<Frustum, DecodeError> {
    let vector = |i: usize| DVec3::new(frame[i], frame[i + 1], frame[i + 2]);
    let mut across = [None; 4];
    for (i, link) in across.iter_mut().enumerate() {
        *link = match image[2 + 3 * i..5 + 3 * i] {
            [u32::MAX, 0, 0] => None,
            [frustum, side, reversed @ (0 | 1)] if side < 4 => Some(Across {
                frustum,
                side: [Side::Left, Side::Right, Side::Top, Side::Bottom][side as usize],
                reversed: reversed == 1,
            }),
            ref other => return Err(DecodeError::section("images", format!("{other:?} names no side"))),
        };
    }
    Ok(Frustum {
        right: vector(0),
        up: vector(3),
        forward: vector(6),
        left: frame[9],
        right_tan: frame[10],
        bottom: frame[11],
        top: frame[12],
        size: [image[0], image[1]],
        across,
    })
}

impl Artifact for Slices {
    const TYPE: &'static str = "Slices";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.array("cell", &[self.cell.centre.to_array(), self.cell.half.to_array()]);
        out.array("frames", &self.frusta.iter().map(frame).collect::<Vec<_>>());
        out.array("images", &self.frusta.iter().map(image).collect::<Vec<_>>());
        out.array("layers", &self.layers);
        out.array("borders", &self.borders);
        out.array("alpha", &[self.alpha]);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (cell, alpha) = (data.array::<[f64; 3]>("cell")?, data.array::<f64>("alpha")?);
        let ([centre, half], [alpha]) = (&cell[..], &alpha[..]) else {
            return Err(DecodeError::section("cell", "expected two vectors and one angle"));
        };
        let (frames, images) = (data.array::<FrustumNumbers>("frames")?, data.array::<ImageNumbers>("images")?);
        if frames.len() != images.len() {
            return Err(DecodeError::section("frames", format!("{} with {} images", frames.len(), images.len())));
        }
        let slices = Self {
            cell: Cell { centre: DVec3::from(*centre), half: DVec3::from(*half) },
            frusta: frames.iter().zip(images.iter()).map(|(f, i)| frustum(f, i)).collect::<Result<_, _>>()?,
            layers: data.array::<f64>("layers")?.into_vec(),
            borders: data.array::<f64>("borders")?.into_vec(),
            alpha: *alpha,
        };
        slices.validate().map_err(|(section, what)| DecodeError::section(section, what))?;
        Ok(slices)
    }
}

impl Artifact for Field {
    const TYPE: &'static str = "VoxelField";
    const FORMAT: u32 = 2;

    fn encode(&self, out: &mut Encoder) {
        out.array("frustum", &[self.frustum]);
        out.array("voxels", &self.voxels);
        out.array("quarters", &self.quarters);
        out.json("objects", &self.objects);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let frustum = data.array::<u32>("frustum")?;
        let [frustum] = frustum[..] else {
            return Err(DecodeError::section("frustum", format!("expected one number, found {}", frustum.len())));
        };
        let field = Self {
            frustum,
            voxels: data.array("voxels")?,
            quarters: data.array("quarters")?,
            objects: data.json("objects")?,
        };
        field.validate().map_err(|(section, what)| DecodeError::section(section, what))?;
        Ok(field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::artifact::{from_bytes, to_bytes},
        voxel::Voxel,
    };
    use std::sync::Arc;

    fn slices() -> Slices {
        let face = |right: DVec3, forward: DVec3, across| Frustum {
            right,
            up: DVec3::Y,
            forward,
            left: -1.0,
            right_tan: 1.0,
            bottom: -1.0,
            top: 1.0,
            size: [8, 8],
            across,
        };
        let link = |frustum, side| Some(Across { frustum, side, reversed: false });
        Slices {
            cell: Cell { centre: DVec3::ZERO, half: DVec3::ONE },
            frusta: vec![
                face(DVec3::X, DVec3::NEG_Z, [None, link(1, Side::Left), None, None]),
                face(DVec3::Z, DVec3::X, [link(0, Side::Right), None, None, None]),
            ],
            layers: vec![3.0, 5.0],
            borders: vec![2.0, 4.0, f64::INFINITY],
            alpha: 0.01,
        }
    }

    fn field() -> Field {
        let voxel = |layer, y, x, object| Voxel {
            x,
            y,
            layer,
            ring: 0,
            inside: 0,
            color: [1, 2, 3, 255],
            normal: [0, 0],
            object,
        };
        Field {
            frustum: 1,
            voxels: vec![voxel(0, 1, 2, 1), voxel(0, 2, 1, 0), voxel(1, 0, 0, 1)].into(),
            quarters: vec![[[7, 8, 9, 255]; 4]; 3].into(),
            objects: vec!["a".into(), "b".into()],
        }
    }

    fn again<A: Artifact>(value: &A) -> Result<A, DecodeError> {
        from_bytes(Arc::new(to_bytes(value)))
    }

    #[test]
    fn decode_what_was_encoded() {
        assert_eq!(again(&slices()), Ok(slices()));
        assert_eq!(again(&field()), Ok(field()));
        assert_eq!(again(&Field::default()), Ok(Field::default()));
    }

    #[test]
    fn slices_that_lead_nowhere_are_refused() {
        let damages: [fn(&mut Slices); 12] = [
            |s| s.layers.clear(),
            |s| s.layers[0] = 4.5,
            |s| s.borders[0] = -1.0,
            |s| s.borders[1] = f64::NAN,
            |s| s.frusta.clear(),
            |s| s.frusta[0].size = [0, 8],
            |s| s.frusta[0].size = [8, 70000],
            |s| s.frusta[0].up = DVec3::X,
            |s| s.frusta[0].left = 1.0,
            |s| s.frusta[1].across[0] = Some(Across { frustum: 2, side: Side::Right, reversed: false }),
            |s| s.frusta[1].size[1] = 9,
            |s| s.cell.half.x = 0.0,
        ];
        for (i, damage) in damages.iter().enumerate() {
            let mut s = slices();
            damage(&mut s);
            assert!(again(&s).is_err(), "damage {i}");
        }
    }

    #[test]
    fn fields_out_of_order_are_refused() {
        let damages: [fn(&mut Field); 5] = [
            |f| f.objects = vec!["a".into()],
            |f| f.objects.swap(0, 1),
            |f| f.voxels = f.voxels.iter().rev().copied().collect(),
            |f| f.voxels = [f.voxels[0], f.voxels[0]].into_iter().collect(),
            |f| f.quarters = f.quarters.iter().take(2).copied().collect(),
        ];
        for (i, damage) in damages.iter().enumerate() {
            let mut f = field();
            damage(&mut f);
            assert!(again(&f).is_err(), "damage {i}");
        }
    }
}
