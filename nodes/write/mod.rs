//! `write`: stand-ins as bundles of files that other programs open, a file per format.

mod dmesh;
mod glb;
mod sprite;

pub use dmesh::Dmesh;
pub use glb::Glb;
pub use sprite::Sprite;

/// Whether `name` can be the stem of a file's name in a bundle.
fn check_name(name: &str) -> Result<(), (&'static str, String)> {
    match crate::engine::publish::names::bad_component(name) {
        None if !name.contains('.') => Ok(()),
        None => Err(("name", format!("`{name}`: expected a name without dots; endings are added"))),
        Some(what) => Err(("name", format!("`{name}` {what}"))),
    }
}
