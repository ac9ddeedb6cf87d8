//! Pictures: supersampled colour over a background.

use super::{
    Backend, Memo, NOTHING, Nearest, Options, Prepared, Shader, Shading, Tile, camera::Camera,
    nearest::nearest_in_tiles, shade::Facet, tile::TileGrid,
};
use crate::{
    image::{Picture, srgb},
    math::{Stop, Stopped},
    view::View,
};
use glam::Vec3;

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rendering {
    /// Samples of a pixel in x and in y, 1 to 64, at the centres of as many equal squares.
    pub samples_per_axis: u32,
    /// Squares of a pixel in x and in y that are shaded each by itself; divides `samples_per_axis`. The samples of a
    /// square that see the same triangle share one colour, taken at their mean position and filtered over the square.
    pub shades_per_axis: u32,
    pub shading: Shading,
    /// Linear RGB where nothing is seen.
    pub background: [f32; 3],
    pub options: Options,
}

impl Default for Rendering {
    /// 4×4 samples shaded in 2×2 squares, unlit, on a mid-grey (sRGB 128) background.
    fn default() -> Self {
        Self {
            samples_per_axis: 4,
            shades_per_axis: 2,
            shading: Shading::Unlit,
            background: [srgb::to_linear(128); 3],
            options: Options::default(),
        }
    }
}

impl Rendering {
    /// `n`×`n` samples, each shaded by itself.
    pub fn with_samples(self, n: u32) -> Self {
        Self { samples_per_axis: n, shades_per_axis: n, ..self }
    }
}

/// A picture and what its pixel centres see.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// The mean over all samples of a pixel in linear light, sRGB-encoded; alpha 255.
    pub picture: Picture,
    /// Of the pixel centres, one sample each.
    pub nearest: Nearest,
}

/// Renders a view.
///
/// # Panics
/// As [`picture`].
pub fn render(
    backend: &dyn Backend,
    shader: &Shader,
    view: &View,
    how: &Rendering,
    stop: &Stop,
) -> Result<Rendered, Stopped> {
    let nearest = super::nearest(backend, shader.geometry, view, &how.options, stop)?;
    Ok(Rendered { picture: picture(backend, shader, view, how, stop)?, nearest })
}

/// The picture of [`render`] alone.
///
/// # Panics
/// Where a side of the view times the samples exceeds [`super::MAX_SIDE`], or the numbers of samples and squares are
/// not as [`Rendering`] demands.
pub fn picture(
    backend: &dyn Backend,
    shader: &Shader,
    view: &View,
    how: &Rendering,
    stop: &Stop,
) -> Result<Picture, Stopped> {
    let (s, shades) = (how.samples_per_axis, how.shades_per_axis);
    assert!((1..=Tile::SIDE).contains(&s), "1 to {} samples an axis", Tile::SIDE);
    assert!(shades > 0 && s.is_multiple_of(shades), "the squares' number divides the samples'");
    let times = |n: u32| View { width: view.width * n, height: view.height * n, ..*view };
    let pixels = Tile::SIDE / s;
    let prepared = Prepared::with_tiles(shader.geometry, &times(s), &how.options, pixels * s, stop)?;
    let camera = Camera::new(&times(shades));
    let grid = TileGrid::new(view.width, view.height, pixels);
    let tiles = nearest_in_tiles(backend, &prepared, stop, |tile, _, triangles| {
        resolve(&tile, triangles, how, &mut Facets::new(shader, &camera))
    })?;
    let texels = grid.join(&tiles, [0; 4]);
    Ok(Picture { width: view.width, height: view.height, texels })
}

/// The pixels of a tile of samples, row by row.
fn resolve(tile: &Tile, triangles: &[u32], how: &Rendering, facets: &mut Facets) -> Vec<[u8; 4]> {
    let s = how.samples_per_axis as usize;
    let side = s / how.shades_per_axis as usize;
    let share = 1.0 / (s * s) as f32;
    let [r, g, b] = how.background.map(srgb::from_linear);
    let background = [r, g, b, 255];
    let (width, height) = (tile.width as usize / s, tile.height as usize / s);
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut missing) = (Vec3::ZERO, 0);
            for sy in (y * s..(y + 1) * s).step_by(side) {
                for sx in (x * s..(x + 1) * s).step_by(side) {
                    let square = Square { tile, x: sx, y: sy, side };
                    missing += square.shade(triangles, &how.shading, facets, &mut sum);
                }
            }
            if missing == s * s {
                texels.push(background);
                continue;
            }
            let sum = (sum + Vec3::from(how.background) * missing as f32).to_array();
            let [r, g, b] = sum.map(|c| srgb::from_linear(c * share));
            texels.push([r, g, b, 255]);
        }
    }
    texels
}

/// The samples that are shaded together; x and y count samples within the tile.
struct Square<'a> {
    tile: &'a Tile,
    x: usize,
    y: usize,
    side: usize,
}

impl Square<'_> {
    /// Adds the samples' colours to `sum`; the number of those that see nothing.
    #[inline]
    fn shade(&self, triangles: &[u32], shading: &Shading, facets: &mut Facets, sum: &mut Vec3) -> usize {
        let n = self.side;
        let first = self.y * self.tile.width as usize + self.x;
        let at = |i: usize| triangles[first + i / n * self.tile.width as usize + i % n];
        let mut missing = 0;
        for i in 0..n * n {
            let triangle = at(i);
            if triangle == NOTHING {
                missing += 1;
                continue;
            }
            if (0..i).any(|k| at(k) == triangle) {
                continue;
            }
            let (mut count, mut dx, mut dy) = (0, 0, 0);
            for k in (i..n * n).filter(|k| at(*k) == triangle) {
                (count, dx, dy) = (count + 1, dx + 2 * (k % n) + 1, dy + 2 * (k / n) + 1);
            }
            // The samples' mean position, in squares from the view's corner.
            let place = |tile: u32, at: usize, twice: usize| {
                ((tile as usize + at) as f64 + twice as f64 / (2 * count) as f64) / n as f64
            };
            let (px, py) = (place(self.tile.x, self.x, dx), place(self.tile.y, self.y, dy));
            *sum += Vec3::from(facets.get(triangle).seen(px, py, shading)) * count as f32;
        }
        missing
    }
}

/// The facets of a tile, made when first seen.
struct Facets<'a> {
    shader: &'a Shader<'a>,
    camera: &'a Camera,
    facets: Memo<Facet<'a>>,
}

impl<'a> Facets<'a> {
    fn new(shader: &'a Shader<'a>, camera: &'a Camera) -> Self {
        Self { shader, camera, facets: Memo::default() }
    }

    fn get(&mut self, triangle: u32) -> &Facet<'a> {
        self.facets.get(triangle, || self.shader.facet(self.camera, triangle))
    }
}
