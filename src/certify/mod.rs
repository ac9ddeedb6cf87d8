//! The certificate: how much a stand-in differs from its original, measured over many views of the view cell.

pub mod views;
