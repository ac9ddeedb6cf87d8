//! The cache of results.

use super::error::EngineError;
use crate::math::Stop;
use std::{path::Path, time::Duration};

/// What a cache holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Results of single runs, and of whole maps.
    pub runs: u64,
    pub maps: u64,
    /// Distinct values, and their bytes.
    pub values: u64,
    pub bytes: u64,
    /// Values and bytes that lie in the index itself.
    pub inline_values: u64,
    pub inline_bytes: u64,
    /// Size of the index file in bytes.
    pub index_bytes: u64,
    /// Bake records kept.
    pub bakes: u64,
}

/// What `verify` found. Clean if both lists are empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verified {
    pub values: u64,
    pub bytes: u64,
    /// Values whose bytes are not what their hash says, or are missing: what and where. They were set aside.
    pub bad: Vec<String>,
    /// Records that were damaged or led to a bad value; they were removed.
    pub dropped_records: u64,
}

/// What `gc` may keep.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    /// Remove the results not used for longest until the cache is at most this large.
    pub max_bytes: Option<u64>,
    /// Remove results not used for so long.
    pub max_age: Option<Duration>,
}

/// What `gc` removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Collected {
    pub runs: u64,
    pub values: u64,
    pub bytes: u64,
    /// Bytes that remain.
    pub left_bytes: u64,
}

pub fn stats(cache: &Path) -> Result<Stats, EngineError> {
    Err(EngineError::cache(cache, "not built yet"))
}

pub fn verify(cache: &Path, _stop: &Stop) -> Result<Verified, EngineError> {
    Err(EngineError::cache(cache, "not built yet"))
}

pub fn gc(cache: &Path, _limits: &Limits) -> Result<Collected, EngineError> {
    Err(EngineError::cache(cache, "not built yet"))
}
