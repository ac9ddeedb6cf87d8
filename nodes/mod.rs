//! The node kinds: thin adapters between the engine and the algorithms, one file or folder each.

pub mod collapse;
pub mod values;

use crate::engine::node::Registry;

/// Every kind that the program knows.
pub fn registry() -> Registry {
    let mut r = Registry::default();
    r.add::<collapse::Collapse>();
    r
}
