//! `cull-occluded`: the objects that a view cell can see.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    lod::{occluder::Opaque, subject::Placement, umbra},
    nodes::backend,
    ports,
    scene::Scene,
    view::HexCell,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, sync::Arc};

/// Leaves out objects that others hide from every point of a view cell. What is left out is hidden for certain; what stays may still be hidden. Objects narrower
/// than the cell hide little and are not drawn: their shadows end where those of the cell's sides meet. Materials with holes hide nothing. Insert it between
/// `separate-placement` and `classify-occlusion`. Source: Chen et al. 2003, section 3.1.7; the test is farfield's own (docs/hybrid-lod.md).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Pixels along a side of the pictures that show 60° from the cell's centre, in which hidden places are looked for. Fewer find fewer.
    #[schemars(range(min = 16, max = 2048), extend("x-unit" = "px"))]
    pub resolution: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { resolution: 512 }
    }
}

ports! {
    pub struct In {
        /// The cell.
        cell: Arc<HexCell>,
        /// Where the scene's objects stand.
        placements: List<Placement, true>,
        /// Their shapes.
        shapes: List<Scene, true>,
    }
}

ports! {
    pub struct Out {
        /// Placements of the objects that may be seen.
        visible: List<Placement, true>,
    }
}

pub struct CullOccluded;

impl Node for CullOccluded {
    const KIND: &'static str = "cull-occluded";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // Joined vertices, edges, and occluders as they are drawn; a picture of 2.5 by 1.6 tangents with depths and borders.
        let focal = f64::from(params.resolution) * 0.8661;
        let pixels = (4.0 * focal * focal) as u64 + 4096;
        (1 << 20) + sizes.iter().sum::<u64>().saturating_mul(4) + pixels.saturating_mul(56)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        // Instances share a shape.
        let mut opaque: BTreeMap<*const Scene, Opaque> = BTreeMap::new();
        for (_, shape) in &inputs.shapes.0 {
            opaque.entry(Arc::as_ptr(shape)).or_insert_with(|| Opaque::of(shape));
        }
        let shapes: BTreeMap<&str, &Opaque> =
            inputs.shapes.0.iter().map(|(n, s)| (n.as_str(), &opaque[&Arc::as_ptr(s)])).collect();
        let of = |(name, placement): &(String, Arc<Placement>)| {
            let shape = shapes.get(name.as_str());
            let shape = shape.ok_or_else(|| NodeError::Failed(format!("the object `{name}` has no shape")))?;
            Ok((placement.clone(), *shape))
        };
        let objects: Vec<(Arc<Placement>, &Opaque)> =
            inputs.placements.0.iter().map(of).collect::<Result<_, NodeError>>()?;
        let lent: Vec<(&Placement, &Opaque)> = objects.iter().map(|(p, s)| (&**p, *s)).collect();
        let seen = umbra::visible(backend(ctx), &inputs.cell.prism, &lent, f64::from(params.resolution), ctx.stop)?;
        let kept = inputs.placements.0.into_iter().zip(seen).filter(|(_, seen)| *seen).map(|(p, _)| p);
        Ok(Out { visible: List(kept.collect()) })
    }
}
