//! Directions spread evenly.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    nodes::cameras::{self, Pictures},
    ports,
    scene::Scene,
    view::{View, directions},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Places orthographic cameras in the directions of the faces of an icosahedron: strategy (a) of omni-directional relief impostors
/// (Andújar et al. 2007, section 3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How often the faces are split in four: 20, 80 or 320 directions. Those of a level are among those of the next, under the same names.
    #[schemars(range(max = 2))]
    pub levels: u32,
    /// Width and height of a relief map, texels.
    #[schemars(range(min = 4, max = 8192), extend("x-unit" = "texels"))]
    pub resolution: u32,
    /// Pixels of the picture along a side of a texel: 1, 2 or 4; those of `resample` `relief`. `resolution` times this is at most 16384.
    pub samples: u32,
    /// Kept free around the object.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "texels"))]
    pub margin: f64,
}

impl Default for Params {
    fn default() -> Self {
        let Pictures { resolution, samples, margin } = Pictures::DEFAULT;
        Self { levels: 0, resolution, samples, margin }
    }
}

impl Params {
    fn pictures(&self) -> Pictures {
        Pictures { resolution: self.resolution, samples: self.samples, margin: self.margin }
    }
}

ports! {
    pub struct In {
        /// What is looked at.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The cameras, by the number of the icosahedron's face that they look at and, for parts of faces, letters, such as `v07` and `v07b`.
        views: List<View>,
    }
}

pub struct Icosahedron;

impl Node for Icosahedron {
    const KIND: &'static str = "select-views";
    const METHOD: &'static str = "icosahedron";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // The vertices in 64 bits.
        (8 << 20) + sizes[0].saturating_mul(3)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        params.pictures().check()
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let directions = directions::named_geodesic(params.levels);
        Ok(Out { views: cameras::around(&inputs.scene, directions, params.pictures())? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::{refused, run};

    fn views(levels: u32) -> Vec<(String, Arc<View>)> {
        let scene = Arc::new(crate::scene::builtin::make("car", 1).unwrap());
        let params = Params { levels, ..Params::default() };
        run::<Icosahedron>(&params, In { scene }).0.unwrap().views.0
    }

    #[test]
    fn more_directions_keep_names_and_cameras() {
        let (few, more) = (views(0), views(1));
        assert_eq!((few.len(), more.len()), (20, 80));
        assert!(few.iter().all(|named| more.contains(named)));
        assert!(more.is_sorted_by(|a, b| a.0 < b.0));
        assert!(few.iter().all(|(_, v)| (v.width, v.height) == (512, 512)));
    }

    #[test]
    fn impossible_pictures_are_refused() {
        for (params, name) in [
            (Params { samples: 3, ..Params::default() }, "samples"),
            (Params { samples: 4, resolution: 8192, ..Params::default() }, "resolution"),
            (Params { resolution: 3, ..Params::default() }, "resolution"),
            (Params { levels: 3, ..Params::default() }, "levels"),
            (Params { margin: -1.0, ..Params::default() }, "margin"),
        ] {
            assert_eq!(refused::<Icosahedron>(&params).as_deref(), Some(name));
        }
        assert_eq!(refused::<Icosahedron>(&Params::default()), None);
    }

    #[test]
    fn an_empty_scene_is_an_error() {
        let error = run::<Icosahedron>(&Params::default(), In { scene: Arc::default() }).0.err().unwrap();
        assert!(error.to_string().contains("no triangles"), "{error}");
    }
}
