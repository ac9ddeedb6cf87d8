//! Relief impostors as they are drawn (Andújar et al. 2007, section 3.3): the CPU twin of `shaders/ori.wgsl`, and the bundle on disk.

mod draw;
mod error;
mod manifest;
mod model;
mod preview;
mod read;
mod shaders;
mod stand_in;
mod write;

pub use draw::{Drawn, draw};
pub use error::OriError;
pub use manifest::{FORMAT, NAME};
pub use model::{Drawing, Model, Ori};
pub use read::{Bundle, read};
pub use shaders::{SHADERS, ShaderFile};
pub use stand_in::OriStandIn;
pub use write::write;
