//! The pipelines that the program carries, by name.

use crate::engine::pipeline::Stock;

/// Everything in `pipelines/`, sorted by name.
pub const STOCK: &[Stock] = &[
    ("tdm", include_str!("../../pipelines/tdm.toml")),
    ("tdm-car", include_str!("../../pipelines/tdm-car.toml")),
    ("tdm-city", include_str!("../../pipelines/tdm-city.toml")),
    ("vds", include_str!("../../pipelines/vds.toml")),
];
