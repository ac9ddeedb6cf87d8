//! `select-views`: from where something is looked at, a file per method.

mod box_faces;
mod min_depth_complexity;

pub use box_faces::BoxFaces;
pub use min_depth_complexity::MinDepthComplexity;
