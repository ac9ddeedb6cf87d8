//! Cameras, and the regions that eyes lie in.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    view::{Cell, Projection, Region, View},
};
use glam::DVec3;

/// A view as numbers: 12 of the frame, 4 of the window, 2 of the depths.
pub(super) fn put_view(out: &mut Encoder, view: &View) {
    let (perspective, [l, r, b, t]) = match view.projection {
        Projection::Perspective { left, right, bottom, top } => (1, [left, right, bottom, top]),
        Projection::Orthographic { left, right, bottom, top } => (0, [left, right, bottom, top]),
    };
    let mut numbers: Vec<f64> =
        [view.eye, view.right, view.up, view.forward].iter().flat_map(DVec3::to_array).collect();
    numbers.extend([l, r, b, t, view.near, view.far]);
    out.array("view", &numbers);
    out.array("pixels", &[perspective, view.width, view.height]);
}

pub(super) fn get_view(data: &Decoder) -> Result<View, DecodeError> {
    view_of(&data.array::<f64>("view")?, &data.array::<u32>("pixels")?)
}

/// The view of 12 numbers of its frame, 4 of its window and 2 depths, and of its projection (1: perspective), width and height.
pub(super) fn view_of(numbers: &[f64], pixels: &[u32]) -> Result<View, DecodeError> {
    let wrong = |what: &str| DecodeError::section("view", what);
    let (Some((frame, rest)), [perspective, width, height]) = (numbers.split_at_checked(12), pixels) else {
        return Err(wrong("expected 18 numbers and 3 whole ones"));
    };
    let [left, right, bottom, top, near, far] = rest[..] else { return Err(wrong("expected 18 numbers")) };
    let [eye, r, up, forward] = [0, 3, 6, 9].map(|i| DVec3::from_slice(&frame[i..i + 3]));
    let unit = |v: DVec3| (v.length_squared() - 1.0).abs() < 1e-9;
    let square = unit(r) && unit(up) && unit(forward) && r.cross(up).distance(-forward) < 1e-9;
    if !(numbers.iter().all(|v| v.is_finite()) && square && left < right && bottom < top && near < far) {
        return Err(wrong("expected an orthonormal frame, and a window and a depth range that are not empty"));
    }
    let projection = match perspective {
        1 if near > 0.0 => Projection::Perspective { left, right, bottom, top },
        0 => Projection::Orthographic { left, right, bottom, top },
        _ => return Err(wrong("expected a projection")),
    };
    if *width == 0 || *height == 0 {
        return Err(wrong("expected pixels"));
    }
    Ok(View { eye, right: r, up, forward, projection, width: *width, height: *height, near, far })
}

impl Artifact for View {
    const TYPE: &'static str = "View";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        put_view(out, self);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        get_view(data)
    }
}

impl Artifact for Region {
    const TYPE: &'static str = "Region";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let (kind, points) = match self {
            Self::Box(cell) => (0, vec![cell.centre.to_array(), cell.half.to_array()]),
            Self::Sphere { centre, radius } => (1, vec![centre.to_array(), [*radius; 3]]),
            Self::Path(points) => (2, points.iter().map(DVec3::to_array).collect()),
        };
        out.array("kind", &[kind]);
        out.array("points", &points);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let wrong = |what: &str| DecodeError::section("points", what);
        let kind = data.array::<u32>("kind")?;
        let points = data.array::<[f64; 3]>("points")?;
        if !points.iter().flatten().all(|v| v.is_finite()) {
            return Err(wrong("expected finite coordinates"));
        }
        match (&kind[..], &points[..]) {
            ([0], [centre, half]) if half.iter().all(|h| *h > 0.0) => {
                Ok(Self::Box(Cell { centre: DVec3::from(*centre), half: DVec3::from(*half) }))
            }
            ([1], [centre, [radius, ..]]) if *radius > 0.0 => {
                Ok(Self::Sphere { centre: DVec3::from(*centre), radius: *radius })
            }
            ([2], [_, ..]) => Ok(Self::Path(points.iter().copied().map(DVec3::from).collect())),
            _ => Err(wrong("expected a box, a sphere or a path with an extent")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::artifact::{from_bytes, to_bytes};
    use std::sync::Arc;

    #[test]
    fn decodes_what_was_encoded() {
        let view = View::look_at(DVec3::ONE, DVec3::ZERO, DVec3::Y, 0.7, 33, 17, 0.1, 9.0);
        assert_eq!(from_bytes::<View>(Arc::new(to_bytes(&view))), Ok(view));
        let flat =
            View { projection: Projection::Orthographic { left: -1.0, right: 2.0, bottom: 0.0, top: 1.0 }, ..view };
        assert_eq!(from_bytes::<View>(Arc::new(to_bytes(&flat))), Ok(flat));
        for region in [
            Region::Box(Cell { centre: DVec3::X, half: DVec3::ONE }),
            Region::Sphere { centre: DVec3::Y, radius: 2.0 },
            Region::Path(vec![DVec3::X, DVec3::Z, DVec3::Y]),
        ] {
            assert_eq!(from_bytes::<Region>(Arc::new(to_bytes(&region))), Ok(region));
        }
    }

    #[test]
    fn refuses_what_cannot_be() {
        let view = View::look_at(DVec3::ONE, DVec3::ZERO, DVec3::Y, 0.7, 33, 17, 0.1, 9.0);
        for wrong in [
            View { near: 0.0, ..view },
            View { up: view.right, ..view },
            View { width: 0, ..view },
            View { eye: DVec3::NAN, ..view },
        ] {
            assert!(from_bytes::<View>(Arc::new(to_bytes(&wrong))).is_err());
        }
        for wrong in [Region::Path(vec![]), Region::Sphere { centre: DVec3::ZERO, radius: 0.0 }] {
            assert!(from_bytes::<Region>(Arc::new(to_bytes(&wrong))).is_err());
        }
    }
}
