//! Pictures of the worst views: original, stand-in and difference side by side.
//!
//! The difference shows |ΔY| in grey, four times enlarged, and over it the classes of pixels that are not right:
//! missing red, extra blue, wrong surface magenta, in front cyan, cracks yellow; darker inside the band.

use super::{
    classes::{Class, Classes},
    measure::{Reference, Shot},
};
use crate::image::{Picture, measure::luminance};

/// How much the difference is enlarged.
const GAIN: f32 = 4.0;

/// The three panels, `3 · width` pixels wide.
pub fn panels(original: &Reference, stand_in: &Shot) -> Picture {
    let (a, b) = (&original.shot.picture, &stand_in.picture);
    let difference = difference(a, b, &original.classes(stand_in));
    let width = a.width as usize;
    let rows = a.texels.chunks(width).zip(b.texels.chunks(width)).zip(difference.chunks(width));
    let texels = rows.flat_map(|((a, b), d)| [a, b, d]).flatten().copied().collect();
    Picture { width: 3 * a.width, height: a.height, texels }
}

fn difference(a: &Picture, b: &Picture, classes: &Classes) -> Vec<[u8; 4]> {
    let y = |t: &[u8; 4]| luminance([t[0].into(), t[1].into(), t[2].into()]);
    a.texels
        .iter()
        .zip(&b.texels)
        .enumerate()
        .map(|(i, (a, b))| {
            let grey = ((y(a) - y(b)).abs() * GAIN).min(255.0) as u8;
            let [r, g, b] = match classes.class[i] {
                _ if classes.crack[i] => return [255, 255, 0, 255],
                Class::Right => return [grey, grey, grey, 255],
                Class::Missing => [255, 0, 0],
                Class::Extra => [64, 64, 255],
                Class::WrongSurface => [255, 0, 255],
                Class::InFront => [0, 255, 255],
            };
            let shade = |c: u8| if classes.band[i] { c / 2 } else { c };
            [shade(r), shade(g), shade(b), 255]
        })
        .collect()
}
