//! The engine: graph, plan, schedule, keys and cache. It knows no node kind and no geometry.

pub mod artifact;
pub mod bake;
pub mod cache;
pub mod error;
pub mod events;
pub mod hash;
pub mod node;
pub mod pipeline;
pub mod plan;
pub mod why;
