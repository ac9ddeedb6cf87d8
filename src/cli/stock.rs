//! The pipelines that the program carries, by name.

use crate::engine::pipeline::Stock;

/// Everything in `pipelines/`, sorted by name.
pub const STOCK: &[Stock] = &[
    ("auto", include_str!("../../pipelines/auto.toml")),
    ("district", include_str!("../../pipelines/district.toml")),
    ("dmesh", include_str!("../../pipelines/dmesh.toml")),
    ("dmesh-relit", include_str!("../../pipelines/dmesh-relit.toml")),
    ("hybrid-lod", include_str!("../../pipelines/hybrid-lod.toml")),
    ("hybrid-lod-culled", include_str!("../../pipelines/hybrid-lod-culled.toml")),
    ("ori", include_str!("../../pipelines/ori.toml")),
    ("ori-tree", include_str!("../../pipelines/ori-tree.toml")),
    ("octahedral", include_str!("../../pipelines/octahedral.toml")),
    ("octahedral-objects", include_str!("../../pipelines/octahedral-objects.toml")),
    ("park-8m", include_str!("../../pipelines/park-8m.toml")),
    ("tdm", include_str!("../../pipelines/tdm.toml")),
    ("tdm-car", include_str!("../../pipelines/tdm-car.toml")),
    ("tdm-city", include_str!("../../pipelines/tdm-city.toml")),
    ("vds", include_str!("../../pipelines/vds.toml")),
    ("vds-borders", include_str!("../../pipelines/vds-borders.toml")),
    ("vds-clip", include_str!("../../pipelines/vds-clip.toml")),
    ("vds-collide", include_str!("../../pipelines/vds-collide.toml")),
    ("vds-draw", include_str!("../../pipelines/vds-draw.toml")),
    ("vds-lenses", include_str!("../../pipelines/vds-lenses.toml")),
    ("vds-points", include_str!("../../pipelines/vds-points.toml")),
    ("vds-styles", include_str!("../../pipelines/vds-styles.toml")),
];
