//! The node kinds: thin adapters between the engine and the algorithms, one file or folder each.

mod load_scene;
mod make_scene;
pub mod render_slices;
pub mod values;
pub mod view_cell;

use crate::engine::node::Registry;

/// Every kind that the program knows.
pub fn registry() -> Registry {
    let mut r = Registry::default();
    r.add::<load_scene::LoadScene>();
    r.add::<make_scene::MakeScene>();
    r.add::<view_cell::ViewCell>();
    r.add::<render_slices::RenderSlices>();
    r
}
