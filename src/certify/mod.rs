//! The certificate: how much a stand-in differs from its original, measured over many views of the view cell.

pub mod classes;
pub mod cracks;
pub mod deviation;
pub mod edges;
pub mod parallax;
pub mod views;
