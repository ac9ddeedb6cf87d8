//! The certificate: how much a stand-in differs from its original, measured over many views of a region such as the view cell.
//!
//! Original and stand-in are always drawn alike: same views, same filter, same background, same shading. Which surface a
//! pixel sees is decided by depth at its centre and never by colour. The same input gives the same bytes on any number of
//! threads (FLIP comes from C++ code and is rounded).

mod about;
mod certificate;
pub mod classes;
mod compare;
mod cracks;
mod deviation;
pub mod directions;
pub mod edges;
mod figures;
mod frame;
mod lost;
mod measure;
mod modes;
mod nearby;
pub mod parallax;
mod per_view;
mod pictures;
mod requirements;
mod shading;
mod summary;
mod viewing;
pub mod views;
pub mod walk;
mod worst;

pub use about::{Better, Helps, Measure, measure, measures};
pub use certificate::{About, Bound, Camera, Ceiling, Certificate, Flip, Sampling as Sampled, Subject, WorstView};
pub use compare::{CompareError, Comparison, Context, Mode, Options, VIEWS_AT_ONCE, ceiling, compare};
pub use figures::{Band, Count, Figures, LostDetail, MeanMax, MeanMin, Total, rounded};
pub use modes::{Everywhere, ModeFigures};
pub use per_view::PerView;
pub use pictures::{Panels, legend};
pub use requirements::{Limits, Requirement, Verdict};
pub use shading::{Choice, colorless};
pub use summary::grouped;
pub use viewing::Viewing;
pub use views::Sampling;

#[cfg(test)]
mod tests;
