//! The node kinds: thin adapters between the engine and the algorithms, one file or folder each.

pub mod values;
