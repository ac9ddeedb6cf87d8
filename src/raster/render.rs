//! Pictures: supersampled colour over a background.

use super::{NOTHING, Nearest, Options, Prepared, Shader, Shading, Tile, shade::Facet, tile::Grid};
use crate::{
    image::{Picture, srgb},
    math::{Stop, Stopped, View},
};
use rayon::prelude::*;

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rendering {
    /// Samples of a pixel in x and in y, 1 to 64, at the centres of as many equal squares.
    pub samples_per_axis: u32,
    pub shading: Shading,
    /// Linear RGB where nothing is seen.
    pub background: [f32; 3],
    pub options: Options,
}

impl Default for Rendering {
    /// 4×4 samples, unlit, on a mid-grey (sRGB 128) background.
    fn default() -> Self {
        let grey = srgb::to_linear(128);
        Self { samples_per_axis: 4, shading: Shading::Unlit, background: [grey; 3], options: Options::default() }
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

/// Renders a view. Every sample is shaded with its own share of the pixel as footprint.
///
/// # Panics
/// Where a side of the view times the samples exceeds [`super::MAX_SIDE`].
pub fn render(shader: &Shader, view: &View, how: &Rendering, stop: &Stop) -> Result<Rendered, Stopped> {
    let nearest = super::nearest(shader.geometry, view, &how.options, stop)?;
    Ok(Rendered { picture: picture(shader, view, how, stop)?, nearest })
}

/// The picture of [`render`] alone.
pub fn picture(shader: &Shader, view: &View, how: &Rendering, stop: &Stop) -> Result<Picture, Stopped> {
    let s = how.samples_per_axis;
    assert!((1..=Tile::SIDE).contains(&s), "1 to {} samples an axis", Tile::SIDE);
    let fine = View { width: view.width * s, height: view.height * s, ..*view };
    let pixels = Tile::SIDE / s;
    let prepared = Prepared::with_tiles(shader.geometry, &fine, &how.options, pixels * s, stop)?;
    let grid = Grid::new(view.width, view.height, pixels);
    let mut texels = vec![[0u8; 4]; view.width as usize * view.height as usize];
    grid.split(&mut texels).into_par_iter().enumerate().try_for_each_init(
        Samples::default,
        |work, (i, mut rows)| {
            stop.check()?;
            work.fill(&prepared, i as u32);
            work.resolve(shader, &prepared, how, i as u32, &mut rows);
            Ok(())
        },
    )?;
    Ok(Picture { width: view.width, height: view.height, texels })
}

/// The samples of one tile.
#[derive(Default)]
struct Samples {
    depth: Vec<f32>,
    triangle: Vec<u32>,
}

impl Samples {
    fn fill(&mut self, prepared: &Prepared, index: u32) {
        let tile = prepared.tile(index);
        self.depth.clear();
        self.depth.resize(tile.pixels(), f32::INFINITY);
        self.triangle.clear();
        self.triangle.resize(tile.pixels(), NOTHING);
        prepared.nearest_in_tile(index, &mut rows(&mut self.depth, &tile), &mut rows(&mut self.triangle, &tile));
    }

    fn resolve(&self, shader: &Shader, prepared: &Prepared, how: &Rendering, index: u32, out: &mut [&mut [[u8; 4]]]) {
        let tile = prepared.tile(index);
        let s = how.samples_per_axis as usize;
        let width = tile.width as usize;
        let mut facets = Facets::default();
        let share = 1.0 / (s * s) as f32;
        for (y, row) in out.iter_mut().enumerate() {
            for (x, texel) in row.iter_mut().enumerate() {
                let mut sum = [0.0f32; 3];
                for i in 0..s * s {
                    let (sx, sy) = (x * s + i % s, y * s + i / s);
                    let triangle = self.triangle[sy * width + sx];
                    let color = if triangle == NOTHING {
                        how.background
                    } else {
                        let (px, py) = (tile.x as f64 + sx as f64 + 0.5, tile.y as f64 + sy as f64 + 0.5);
                        facets.get(shader, prepared, triangle).seen(px, py, &how.shading)
                    };
                    for k in 0..3 {
                        sum[k] += color[k];
                    }
                }
                let [r, g, b] = sum.map(|c| srgb::from_linear(c * share));
                *texel = [r, g, b, 255];
            }
        }
    }
}

fn rows<'a, T>(values: &'a mut [T], tile: &Tile) -> Vec<&'a mut [T]> {
    values.chunks_mut(tile.width as usize).collect()
}

/// The facets of a tile, made when first seen.
struct Facets<'a> {
    facets: Vec<(u32, Facet<'a>)>,
    /// Position in `facets` by the low bits of the triangle number.
    at: [u32; 256],
}

impl Default for Facets<'_> {
    fn default() -> Self {
        Self { facets: Vec::new(), at: [u32::MAX; 256] }
    }
}

impl<'a> Facets<'a> {
    fn get(&mut self, shader: &'a Shader<'a>, prepared: &Prepared, triangle: u32) -> &Facet<'a> {
        let slot = triangle as usize % self.at.len();
        let mut i = self.at[slot] as usize;
        if self.facets.get(i).is_none_or(|f| f.0 != triangle) {
            i = self.facets.len();
            self.facets.push((triangle, shader.facet(&prepared.camera, triangle)));
            self.at[slot] = i as u32;
        }
        &self.facets[i].1
    }
}
