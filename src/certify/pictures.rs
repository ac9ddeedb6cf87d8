//! Pictures of the worst views: original, stand-in and difference side by side.
//!
//! The difference shows |ΔY| in grey, four times enlarged, and over it the classes of pixels that are not right:
//! missing red, extra blue, wrong surface magenta, in front cyan, cracks yellow; darker inside the band.

use super::{
    classes::{Class, Classes},
    frame::Frame,
    measure::{Reference, Shot},
};
use crate::image::{Picture, measure::luminance};

/// Mid-grey, as `Rendering::default()` has it.
const BACKGROUND: [u8; 4] = [128, 128, 128, 255];
/// How much the difference is enlarged.
const GAIN: f32 = 4.0;

/// The three panels, three frames wide.
pub fn panels(original: &Reference, stand_in: &Shot, frame: &Frame) -> Picture {
    let (a, b) = (&original.shot.picture, &stand_in.picture);
    let difference = difference(a, b, &original.classes(stand_in));
    let (width, height) = (frame.size[0] as usize, frame.size[1] as usize);
    let mut texels = Vec::with_capacity(3 * width * height);
    for _ in 0..height {
        texels.extend(std::iter::repeat_n(BACKGROUND, 2 * width));
        texels.extend(std::iter::repeat_n([0, 0, 0, 255], width));
    }
    for (panel, pixels) in [&a.texels, &b.texels, &difference].into_iter().enumerate() {
        for (y, row) in pixels.chunks(a.width as usize).enumerate() {
            let at = (frame.origin[1] as usize + y) * 3 * width + panel * width + frame.origin[0] as usize;
            texels[at..at + row.len()].copy_from_slice(row);
        }
    }
    Picture { width: 3 * frame.size[0], height: frame.size[1], texels }
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
