//! Pictures of a DMesh, and what its pixel centres see.

use super::{
    Model, Selected, Weights,
    blend::{Layers, resolve},
    select,
};
use crate::{
    image::Picture,
    math::{Stop, Stopped},
    raster::{Camera, NOTHING, Rendering, Samples, Tile, TileGrid},
    view::View,
};
use rayon::prelude::*;

/// What decides how references blend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blending {
    pub weights: Weights,
    /// Fragments count by their quality; without, all of a reference alike.
    pub quality: bool,
    /// How far behind the nearest fragment others still blend, metres; `None`: 2ε plus what a texel of their reference measures
    /// there. Two meshes of one surface differ by at most 2ε, and their vertices lie between texels.
    pub offset: Option<f64>,
}

impl Default for Blending {
    fn default() -> Self {
        Self { weights: Weights::default(), quality: true, offset: None }
    }
}

/// One view of a DMesh. The arrays are those of the pixel centres, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// The mean over all samples of a pixel in linear light, sRGB-encoded; alpha 255.
    pub picture: Picture,
    /// Planar depth of the nearest fragment, metres; infinite where there is nothing.
    pub depth: Vec<f32>,
    /// Its triangle, counted through all references ([`Model::positions`]); [`NOTHING`] where there is nothing.
    pub surface: Vec<u32>,
    /// The references that blend: bit i for reference i.
    pub mask: Vec<u64>,
    pub selected: Vec<Selected>,
}

impl Drawn {
    /// How many references blend at a pixel.
    pub fn count(&self, pixel: usize) -> u32 {
        self.mask[pixel].count_ones()
    }
}

impl Model {
    /// Draws a view. `how.options` says which faces of single-sided meshes are drawn.
    ///
    /// # Panics
    /// Where a side of the view times the samples exceeds [`crate::raster::MAX_SIDE`], or the numbers of samples and squares are
    /// not as [`Rendering`] demands.
    pub fn draw(&self, view: &View, how: &Rendering, blending: &Blending, stop: &Stop) -> Result<Drawn, Stopped> {
        let selected = select(self.dmesh(), view, blending.weights);
        self.draw_selected(view, how, blending, selected, stop)
    }

    /// [`Model::draw`] with references and weights chosen by the caller; those of weight 0 are left out.
    ///
    /// # Panics
    /// As [`Model::draw`], and where there is no such reference.
    pub fn draw_selected(
        &self,
        view: &View,
        how: &Rendering,
        blending: &Blending,
        mut selected: Vec<Selected>,
        stop: &Stop,
    ) -> Result<Drawn, Stopped> {
        selected.retain(|s| s.weight > 0.0);
        let picture = self.picture(view, how, blending, &selected, stop)?;
        let layers = Layers::new(self, &selected, view, Tile::SIDE, how, blending, stop)?;
        let grid = TileGrid::new(view.width, view.height, Tile::SIDE);
        let tiles = in_tiles(&grid, stop, |tile, samples| layers.centres(tile, samples))?;
        let (mut depth, mut surface, mut mask) = (Vec::new(), Vec::new(), Vec::new());
        for (z, s, m) in tiles {
            depth.push(z);
            surface.push(s);
            mask.push(m);
        }
        Ok(Drawn {
            picture,
            depth: grid.join(&depth, f32::INFINITY),
            surface: grid.join(&surface, NOTHING),
            mask: grid.join(&mask, 0),
            selected,
        })
    }

    fn picture(
        &self,
        view: &View,
        how: &Rendering,
        blending: &Blending,
        selected: &[Selected],
        stop: &Stop,
    ) -> Result<Picture, Stopped> {
        let (s, shades) = (how.samples_per_axis, how.shades_per_axis);
        assert!((1..=Tile::SIDE).contains(&s), "1 to {} samples an axis", Tile::SIDE);
        assert!(shades > 0 && s.is_multiple_of(shades), "the squares' number divides the samples'");
        let times = |n: u32| View { width: view.width * n, height: view.height * n, ..*view };
        let pixels = Tile::SIDE / s;
        let layers = Layers::new(self, selected, &times(s), pixels * s, how, blending, stop)?;
        let camera = Camera::new(&times(shades));
        let samples = TileGrid::new(view.width * s, view.height * s, pixels * s);
        let tiles = in_tiles(&samples, stop, |tile, samples| resolve(&layers, &camera, &tile, samples, how))?;
        let texels = TileGrid::new(view.width, view.height, pixels).join(&tiles, [0; 4]);
        Ok(Picture { width: view.width, height: view.height, texels })
    }
}

/// What `work` gives for every tile, in the order of the tiles. It gets room for the samples of each reference.
fn in_tiles<R: Send>(
    grid: &TileGrid,
    stop: &Stop,
    work: impl Fn(Tile, &mut Vec<Samples>) -> R + Sync,
) -> Result<Vec<R>, Stopped> {
    let tiles = (0..grid.len() as u32).into_par_iter();
    tiles
        .map_init(Vec::new, |samples, index| {
            stop.check()?;
            Ok(work(grid.tile(index), samples))
        })
        .collect()
}
