//! `view-region`: the places from which a stand-in is looked at, where they are no view cell; a file per method.

mod path;
mod sphere;

pub use path::Path;
pub use sphere::Sphere;
