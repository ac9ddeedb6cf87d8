//! Relief impostors as they are drawn (Andújar et al. 2007, section 3.3): the CPU twin of `shaders/ori.wgsl`, and the bundle on disk.

mod draw;
mod error;
mod instances;
mod manifest;
mod model;
mod picture;
mod preview;
mod read;
#[cfg(test)]
pub(crate) mod sample;
mod shaders;
mod stand_in;
#[cfg(test)]
mod tests;
mod tree;
mod write;

pub use draw::{Drawn, MAPS, draw};
pub use error::OriError;
pub use instances::{DrawnInstances, Instance, draw_instances};
pub use manifest::{FORMAT, NAME};
pub use model::{Drawing, Model, Ori};
pub use read::{Bundle, read};
pub use shaders::{SHADER, SHADERS};
pub use stand_in::OriStandIn;
pub use tree::{
    Front, RegionRow, TREE_FORMAT, TREE_NAME, TREE_VERSION, TreeManifest, TreeStandIn, projected_size, stated_threshold,
};
pub use write::{Extras, write};
