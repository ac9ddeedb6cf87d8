//! `pack-atlas`: charts onto atlas pages.

use super::values::Bound;
use crate::{
    atlas::{self, AtlasError, Settings},
    engine::node::{Ctx, List, Node, NodeError},
    mesh::ChartedMesh,
    ports,
    scene::Scene,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Packs the charts of all meshes into texture pages. Everything on one page becomes one object with one unlit material, and so one
/// draw call; with normal maps the material is lit. A page with a transparent texel is masked at an alpha of one half, others are opaque.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Texels between charts, 1 to 64, filled from the charts' borders. Mip levels whose texels are at most this
    /// wide mix no two charts.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "texels"))]
    pub gutter: u32,
    /// Largest side of a page in texels, a power of two, 64 to 16384.
    #[schemars(range(min = 64, max = 16384), extend("x-unit" = "texels"))]
    pub max_page: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { gutter: Settings::default().gutter, max_page: Settings::default().max_page }
    }
}

ports! {
    pub struct In {
        /// Meshes with charts of texels.
        meshes: List<ChartedMesh>,
    }
}

ports! {
    pub struct Out {
        /// One object per page.
        scene: Arc<Scene>,
        /// The largest displacement on the screen that the method allows for any of the meshes.
        bound: Arc<Bound>,
    }
}

pub struct PackAtlas;

impl Node for PackAtlas {
    const KIND: &'static str = "pack-atlas";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        sizes.first().copied().unwrap_or(0).saturating_mul(4)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if !params.max_page.is_power_of_two() {
            return Err(("max_page", format!("expected a power of two from 64 to 16384, found {}", params.max_page)));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let meshes: Vec<_> = inputs.meshes.0.iter().map(|(name, m)| (name.as_str(), m.as_ref())).collect();
        let settings = Settings { gutter: params.gutter, max_page: params.max_page };
        let packed = atlas::atlas(&meshes, &settings, ctx.stop).map_err(|e| match e {
            AtlasError::Stopped(s) => NodeError::Stopped(s),
            other => NodeError::from_error(&other),
        })?;
        let value = meshes.iter().map(|(_, m)| m.bound_px).fold(0.0, f64::max);
        let bound = Bound { kind: "tdm: displacement on the screen".into(), value, unit: "px".into() };
        Ok(Out { scene: Arc::new(packed.scene), bound: Arc::new(bound) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::refused;

    #[test]
    fn ranges_are_checked() {
        assert_eq!(refused::<PackAtlas>(&Params::default()), None);
        assert_eq!(refused::<PackAtlas>(&Params { gutter: 0, ..Params::default() }).as_deref(), Some("gutter"));
        assert_eq!(refused::<PackAtlas>(&Params { max_page: 1000, ..Params::default() }).as_deref(), Some("max_page"));
    }
}
