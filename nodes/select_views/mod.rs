//! `select-views`: from where something is looked at, a file per method.

mod min_depth_complexity;

pub use min_depth_complexity::MinDepthComplexity;
