//! `peel`: more than the nearest surface, a file per method.

mod layers;
mod solid;

pub use layers::Layers;
pub use solid::Solid;
