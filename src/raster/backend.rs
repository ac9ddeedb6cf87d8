//! The interface that the CPU and the GPU back end share.

use super::{Prepared, TileFragments, samples::Samples};
use crate::math::{Stop, Stopped};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Receives what the pixels of a tile see: the tile's number, depths, triangles (as in [`super::Nearest`]).
pub type OnNearest<'a> = dyn Fn(u32, &[f32], &[u32]) + Sync + 'a;
/// Receives the fragments of a tile.
pub type OnFragments<'a> = dyn Fn(u32, &TileFragments) + Sync + 'a;

/// Carries out the rasteriser's operations on a prepared view. Every back end gives the same, bit for bit: which one it was
/// changes how long a bake takes and nothing else.
pub trait Backend: Send + Sync {
    /// Operation 1. Calls `tile(index, depth, triangle)` for every tile with what its pixels see (as in [`super::Nearest`]), several at a time;
    /// for one tile perhaps twice, with the same values.
    fn nearest(&self, prepared: &Prepared, stop: &Stop, tile: &OnNearest) -> Result<(), Stopped>;

    /// Operation 2. Calls `tile(index, fragments)` likewise.
    fn fragments(&self, prepared: &Prepared, stop: &Stop, tile: &OnFragments) -> Result<(), Stopped>;
}

/// The threads of the machine; the embedded default.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cpu;

impl Backend for Cpu {
    fn nearest(&self, prepared: &Prepared, stop: &Stop, tile: &OnNearest) -> Result<(), Stopped> {
        let tiles = (0..prepared.tile_count() as u32).into_par_iter();
        tiles.try_for_each_init(Samples::default, |samples, index| {
            stop.check()?;
            samples.fill(prepared, index);
            tile(index, &samples.depth, &samples.triangle);
            Ok(())
        })
    }

    fn fragments(&self, prepared: &Prepared, stop: &Stop, tile: &OnFragments) -> Result<(), Stopped> {
        let tiles = (0..prepared.tile_count() as u32).into_par_iter();
        tiles.try_for_each_init(TileFragments::default, |buffer, index| {
            stop.check()?;
            prepared.collect(index, buffer);
            tile(index, buffer);
            Ok(())
        })
    }
}

/// What `work` gave for every tile, in the order of the tiles.
pub(super) fn in_tiles<R: Send>(
    prepared: &Prepared,
    run: impl FnOnce(&(dyn Fn(u32, R) + Sync)) -> Result<(), Stopped>,
) -> Result<Vec<R>, Stopped> {
    let results: Vec<Mutex<Option<R>>> = (0..prepared.tile_count()).map(|_| Mutex::new(None)).collect();
    run(&|i, r| *results[i as usize].lock().unwrap_or_else(PoisonError::into_inner) = Some(r))?;
    let taken = results.into_iter().map(|r| r.into_inner().unwrap_or_else(PoisonError::into_inner));
    Ok(taken.map(|r| r.expect("a back end calls back for every tile")).collect())
}
