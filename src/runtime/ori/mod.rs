//! Relief impostors as they are drawn (Andújar et al. 2007, section 3.3): the CPU twin of `shaders/ori.wgsl`, and the bundle on disk.

mod draw;
mod model;

pub use draw::{Drawn, draw};
pub use model::{Channel, Drawing, Model, Ori, OriError};
