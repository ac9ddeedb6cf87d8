//! Which pixels original and impostors cover, as bits.

use super::{Field, Trace, trace};
use crate::{
    math::{Stop, Stopped},
    view::View,
};
use rayon::prelude::*;

/// A bit for each pixel of a picture, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask(pub Vec<u64>);

impl Mask {
    /// Of `pixels` pixels, those of which `covered` is true.
    pub fn new(pixels: usize, covered: impl Fn(usize) -> bool) -> Self {
        let word = |w: usize| {
            let bits = (w * 64..((w + 1) * 64).min(pixels)).filter(|i| covered(*i));
            bits.fold(0_u64, |word, i| word | 1 << (i % 64))
        };
        Self((0..pixels.div_ceil(64)).map(word).collect())
    }

    pub fn empty(pixels: usize) -> Self {
        Self(vec![0; pixels.div_ceil(64)])
    }

    /// Adds what another mask of as many pixels covers.
    pub fn join(&mut self, other: &Self) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a |= b;
        }
    }

    pub fn count(&self) -> u64 {
        self.0.iter().map(|w| u64::from(w.count_ones())).sum()
    }

    /// Pixels that this mask covers and `other` does not.
    pub fn beyond(&self, other: &Self) -> u64 {
        self.0.iter().zip(&other.0).map(|(a, b)| u64::from((a & !b).count_ones())).sum()
    }

    pub fn covers(&self, pixel: usize) -> bool {
        self.0.get(pixel / 64).is_some_and(|w| w >> (pixel % 64) & 1 == 1)
    }
}

/// What one map shows in an orthographic view: the pixels whose centre's ray meets its surface.
pub fn of_map(field: &Field, view: &View, how: &Trace, stop: &Stop) -> Result<Mask, Stopped> {
    let (width, height) = (view.width as usize, view.height as usize);
    let rows: Vec<Vec<bool>> = (0..height)
        .into_par_iter()
        .map(|y| {
            stop.check()?;
            Ok((0..width).map(|x| hits(field, view, x, y, how)).collect())
        })
        .collect::<Result<_, Stopped>>()?;
    Ok(Mask::new(width * height, |i| rows[i / width][i % width]))
}

fn hits(field: &Field, view: &View, x: usize, y: usize, how: &Trace) -> bool {
    let origin = view.unproject(x as f64 + 0.5, y as f64 + 0.5, 0.0);
    trace(field, &field.ray(origin, view.forward), f32::NEG_INFINITY, how).is_some()
}
