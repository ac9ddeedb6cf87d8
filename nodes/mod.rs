//! The node kinds: thin adapters between the engine and the algorithms, one file or folder each.

pub mod collapse;
mod field_scene;
mod pack_atlas;
mod resample;
mod load_scene;
mod make_scene;
pub mod values;

use crate::engine::node::Registry;

/// Every kind that the program knows.
pub fn registry() -> Registry {
    let mut r = Registry::default();
    r.add::<collapse::Collapse>();
    r.add::<field_scene::FieldScene>();
    r.add::<pack_atlas::PackAtlas>();
    r.add::<resample::Resample>();
    r.add::<load_scene::LoadScene>();
    r.add::<make_scene::MakeScene>();
    r
}
