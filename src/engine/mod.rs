//! The engine: graph, plan, schedule, keys and cache. It knows no node kind and no geometry.

pub mod artifact;
pub mod node;
pub mod pipeline;
pub mod plan;
