//! `split-region`: a scene as a tree of boxes with what lies in them.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    ports,
    scene::{
        Scene,
        split::{Division, RegionTree, SplitError, Splitting, split},
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Divides the bounding box of a scene into smaller boxes again and again and gives what lies in each, root included, so that large or near objects get stand-ins by part
/// (Andújar et al. 2007, section 5). Triangles are cut at the sides of their box, which is inflated by 1 % of its parent's longest side, so that
/// stand-ins of neighbours overlap and leave no gap. A region of the list is stored with its own copy of its textures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How a box is divided.
    pub division: Division,
    /// How often boxes are divided; 0 gives the scene as it is. There are at most 4096 regions.
    #[schemars(range(max = 6))]
    pub levels: u32,
    /// Regions with fewer triangles are not divided.
    #[schemars(range(max = 1_000_000_000), extend("x-unit" = "triangles"))]
    pub min_triangles: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { division: Division::Octree, levels: 1, min_triangles: 64 }
    }
}

ports! {
    pub struct In {
        /// The scene to divide.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// What lies in each region that is not empty, by its path from the `root`, such as `root.3.1`.
        regions: List<Scene>,
        /// Boxes and children of the regions.
        tree: Arc<RegionTree>,
    }
}

pub struct SplitRegion;

impl Node for SplitRegion {
    const KIND: &'static str = "split-region";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // A level has each triangle once, those at sides twice, with vertices of its own; textures are shared.
        (16 << 20) + sizes[0].saturating_mul(2 + 2 * u64::from(params.levels))
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let Params { division, levels, min_triangles } = *params;
        let how = Splitting { division, levels, min_triangles: min_triangles as usize };
        let (tree, scenes) = split(&inputs.scene, how, ctx.stop).map_err(|error| match error {
            SplitError::Stopped(stopped) => NodeError::Stopped(stopped),
            other => NodeError::Failed(other.to_string()),
        })?;
        let names = tree.regions.iter().map(|r| r.name.clone());
        Ok(Out { regions: List(names.zip(scenes.into_iter().map(Arc::new)).collect()), tree: Arc::new(tree) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::{refused, run};

    fn solids() -> Arc<Scene> {
        Arc::new(crate::scene::builtin::make("solids", 1).unwrap())
    }

    #[test]
    fn regions_have_the_names_of_the_tree() {
        let out = run::<SplitRegion>(&Params::default(), In { scene: solids() }).0.unwrap();
        let names: Vec<&String> = out.regions.0.iter().map(|r| &r.0).collect();
        assert_eq!(names, out.tree.regions.iter().map(|r| &r.name).collect::<Vec<_>>());
        assert_eq!((names[0].as_str(), names[1].as_str(), &*out.regions.0[0].1), ("root", "root.0", &*solids()));
    }

    #[test]
    fn what_cannot_be_split_is_an_error() {
        let fails = |params: &Params, scene| run::<SplitRegion>(params, In { scene }).0.err().unwrap().to_string();
        assert!(fails(&Params::default(), Arc::default()).contains("no triangles"));
        let deep = Params { levels: 6, min_triangles: 0, ..Params::default() };
        assert!(fails(&deep, solids()).contains("expected fewer `levels`"));
        assert_eq!(refused::<SplitRegion>(&Params { levels: 7, ..Params::default() }).as_deref(), Some("levels"));
    }
}
