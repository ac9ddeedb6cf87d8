//! Cameras and the places from which a stand-in is seen.

mod camera;
mod cell;
pub mod directions;
mod prism;
mod region;
mod sphere;

pub use camera::{Pose, Projection, View};
pub use cell::Cell;
pub use prism::{HexCell, HexGrid, Prism};
pub use region::Region;
pub use sphere::enclosing_sphere;
