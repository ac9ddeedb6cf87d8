//! The engine: graph, plan, schedule, keys and cache. It knows no node kind and no geometry.

pub mod artifact;
mod attempt;
pub mod bake;
pub mod cache;
mod deliver;
pub mod elements;
pub mod error;
pub mod events;
pub mod file;
pub mod hash;
pub mod key;
mod lookup;
mod memory;
pub mod node;
pub mod pipeline;
pub mod plan;
pub mod profile;
pub mod publish;
pub mod record;
pub mod require;
pub mod schedule;
pub mod source;
pub mod temporary;
pub mod value;
pub mod why;
mod wire;
