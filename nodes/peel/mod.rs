//! `peel`: more than the nearest surface, a file per method.

mod solid;

pub use solid::Solid;
