//! Depth maps of the sizes that a restricted quadtree covers.

use crate::view::{Projection, View};

/// Smallest and largest k of a grid of 2^k+1 points a side.
const LEVELS: std::ops::RangeInclusive<u32> = 1..=13;
/// Largest depth, metres: squares of it are far from overflow in 32 bits.
const FARTHEST: f32 = 1e12;

/// A square depth image. The centre of pixel (i, j) is grid point (i, j).
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    view: View,
    depth: Vec<f32>,
}

/// Why an image is no [`DepthMap`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    #[error("a depth map must be square with 2^k+1 pixels a side, k from 1 to 13, found {width} × {height}")]
    Size { width: u32, height: u32 },
    #[error("{width} × {height} pixels need {expected} depths, found {found}")]
    Length { width: u32, height: u32, expected: usize, found: usize },
    #[error("the depth of pixel ({x}, {y}) is {depth}, expected 0 to 1e12 metres, or infinity for background")]
    Depth { x: usize, y: usize, depth: f32 },
    #[error("the view's frame and projection must be finite, with left < right and bottom < top")]
    View,
    #[error("nothing can be resampled to 2^k+1 pixels a side, k from 1 to 13, from {width} × {height}")]
    Resample { width: u32, height: u32 },
}

impl DepthMap {
    /// `depth`: planar depths in metres, row by row from the top, infinite where there is background. `view.width` and
    /// `view.height` are 2^k+1, k from 1 to 13.
    pub fn new(view: View, depth: Vec<f32>) -> Result<Self, MapError> {
        let View { width, height, .. } = view;
        let cells = width.saturating_sub(1);
        if width != height || !cells.is_power_of_two() || !LEVELS.contains(&cells.trailing_zeros()) {
            return Err(MapError::Size { width, height });
        }
        check(&view, &depth)?;
        Ok(Self { view, depth })
    }

    pub fn view(&self) -> &View {
        &self.view
    }

    /// Grid points a side, 2^k+1.
    pub fn side(&self) -> usize {
        self.view.width as usize
    }

    /// Planar depths, row by row from the top; infinite where there is background.
    pub fn depth(&self) -> &[f32] {
        &self.depth
    }

    pub fn into_parts(self) -> (View, Vec<f32>) {
        (self.view, self.depth)
    }
}

/// Length, depths and camera of an image of any size.
fn check(view: &View, depth: &[f32]) -> Result<(), MapError> {
    let View { width, height, .. } = *view;
    let expected = width as usize * height as usize;
    if depth.len() != expected {
        return Err(MapError::Length { width, height, expected, found: depth.len() });
    }
    let (Projection::Perspective { left, right, bottom, top } | Projection::Orthographic { left, right, bottom, top }) =
        view.projection;
    let frame = [view.eye, view.right, view.up, view.forward];
    let finite = frame.iter().all(|v| v.is_finite()) && [left, right, bottom, top].iter().all(|v| v.abs() <= 1e12);
    if !(finite && left < right && bottom < top) {
        return Err(MapError::View);
    }
    match depth.iter().position(|&z| !(0.0..=FARTHEST).contains(&z) && z != f32::INFINITY) {
        Some(at) => Err(MapError::Depth { x: at % width as usize, y: at / width as usize, depth: depth[at] }),
        None => Ok(()),
    }
}

/// A map of another size, and where its pixels come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled {
    pub map: DepthMap,
    /// For every pixel of the map the index of the source pixel, for anything else that the source holds per pixel.
    pub source: Vec<u32>,
}

/// The next larger map of 2^k+1 pixels a side with the same window. Every pixel takes its nearest source pixel: averages over the
/// edge of a surface would be depths at which there is none. `depth` is row by row as `view` says; a square source of
/// 2^k+1 comes back unchanged.
pub fn resample(view: &View, depth: &[f32]) -> Result<Resampled, MapError> {
    let View { width, height, .. } = *view;
    let cells = width.max(height).saturating_sub(1).max(2).checked_next_power_of_two().unwrap_or(u32::MAX);
    if width == 0 || height == 0 || !LEVELS.contains(&cells.trailing_zeros()) {
        return Err(MapError::Resample { width, height });
    }
    check(view, depth)?;
    let side = cells + 1;
    let nearest = |i: u32, length: u32| {
        let at = (2 * u64::from(i) + 1) * u64::from(length) / (2 * u64::from(side));
        at as u32
    };
    let columns: Vec<u32> = (0..side).map(|x| nearest(x, width)).collect();
    let source: Vec<u32> = (0..side)
        .map(|y| nearest(y, height) * width)
        .flat_map(|row| columns.iter().map(move |column| row + column))
        .collect();
    let depth = source.iter().map(|&at| depth[at as usize]).collect();
    let map = DepthMap::new(View { width: side, height: side, ..*view }, depth)?;
    Ok(Resampled { map, source })
}
