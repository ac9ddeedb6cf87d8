//! `compress`: the same in fewer bytes, a file per method.

mod ranges;

pub use ranges::Ranges;
