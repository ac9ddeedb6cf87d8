//! Small mathematics shared by the algorithm folders: boxes, deterministic functions.
//!
//! Transcendental functions come from `libm`, never from the platform, so that bytes agree between machines.

pub mod bounds;
pub mod sequence;
pub mod shift;
pub mod stop;
pub mod triangle;

pub use bounds::Aabb;
pub use sequence::Sequence;
pub use shift::shift;
pub use stop::{Stop, Stopped};
pub use triangle::squared_distance;
