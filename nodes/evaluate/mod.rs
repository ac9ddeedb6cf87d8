//! `evaluate`: certificates, a file per method.

mod points;
mod views;

pub use points::Points;
pub use views::Views;
