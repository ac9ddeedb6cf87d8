//! `make-scene`: a procedural scene.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    ports,
    scene::{
        Scene,
        builtin::{
            self,
            park::{self, Park},
        },
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Generates a procedural scene from a seed: the same on every machine, without any file. The city and the car have
/// the size and the triangle count of the two models in table 1 of Jeschke and Wimmer 2002; the park is as large as those of Chen et al.
/// 2003 and takes its statues from `models` where they are connected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Which scene to generate.
    pub what: What,
    /// Seed of the random generator.
    pub seed: u64,
    /// Of the park: statues. The park of a smaller count is a subset of that of a larger one, names and places included.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: u32,
    /// Of the park: its extent along x, metres. The origin is its centre.
    #[schemars(range(max = 65_536.0), extend("exclusiveMinimum" = 0.0, "x-unit" = "m"))]
    pub width: f64,
    /// Of the park: its extent along z, metres.
    #[schemars(range(max = 65_536.0), extend("exclusiveMinimum" = 0.0, "x-unit" = "m"))]
    pub depth: f64,
    /// Of the park: multiplies the cells of procedural statues in each direction, and their triangles about by its square. Without
    /// meaning for `models`.
    #[schemars(range(min = 0.25, max = 8.0))]
    pub detail: f64,
    /// Of the park: how many of the statues are of each kind, in proportion, in the order of the kinds' names. Empty: equally many.
    pub shares: Vec<u32>,
}

impl Default for Params {
    fn default() -> Self {
        let Park { count, seed, width, depth } = Park::default();
        Self { what: What::City, seed, count, width, depth, detail: 1.0, shares: Vec::new() }
    }
}

/// The procedural scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// 450 × 450 × 50 m, about 700 objects, 158,944 triangles.
    City,
    /// 4.7 × 1.8 × 1.5 m, about 1,188 triangles.
    Car,
    /// `count` statues on `width` × `depth` metres, standing on y = 0 without touching, each mesh in memory once.
    Park,
    /// A box, a sphere and a torus, all closed.
    Solids,
}

ports! {
    pub struct In {
        /// Of the park: each object of this scene is a kind of statue, in its size and attitude there; its place counts for nothing. What
        /// has neither texture nor colours is coloured like stone. Without it the kinds are procedural: bench, column, figure, knot, obelisk, vase.
        models: Option<Arc<Scene>>,
    }
}

ports! {
    pub struct Out {
        /// The scene.
        scene: Arc<Scene>,
    }
}

pub struct MakeScene;

impl Node for MakeScene {
    const KIND: &'static str = "make-scene";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Models are copied to be coloured, with 16 bytes more for each vertex.
        (64u64 << 20).saturating_add(sizes.iter().fold(0u64, |a, b| a.saturating_add(*b)).saturating_mul(2))
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if !params.shares.is_empty() && params.shares.iter().all(|s| *s == 0) {
            return Err(("shares", park::ParkError::NoShares.to_string()));
        }
        if params.what == What::Park {
            return Ok(());
        }
        let usual = Self::Params::default();
        let given = [
            ("count", params.count != usual.count),
            ("width", params.width != usual.width),
            ("depth", params.depth != usual.depth),
            ("detail", params.detail != usual.detail),
            ("shares", params.shares != usual.shares),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((name, _)) => Err((name, "is a parameter of `what = \"park\"` only".into())),
            None => Ok(()),
        }
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let name = match params.what {
            What::City => "city",
            What::Car => "car",
            What::Park => return grow_park(params, inputs.models.as_deref()),
            What::Solids => "solids",
        };
        if inputs.models.is_some() {
            return Err(NodeError::Failed(format!("`models` is connected, and `{name}` takes none; `park` does")));
        }
        let scene = builtin::make(name, params.seed)
            .ok_or_else(|| NodeError::Failed(format!("no procedural scene `{name}`")))?;
        Ok(Out { scene: Arc::new(scene) })
    }
}

fn grow_park(params: &Params, models: Option<&Scene>) -> Result<Out, NodeError> {
    let Params { count, seed, width, depth, detail, ref shares, .. } = *params;
    let kinds = match models {
        Some(models) => park::of_models(models, shares),
        None => park::procedural(detail, shares),
    };
    let scene = kinds.and_then(|kinds| park::scatter(&kinds, &Park { count, seed, width, depth }));
    scene.map(|scene| Out { scene: Arc::new(scene) }).map_err(|e| NodeError::from_error(&e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::{refused, run};

    fn park(params: Params, models: Option<Arc<Scene>>) -> Result<Arc<Scene>, String> {
        let (out, _) = run::<MakeScene>(&Params { what: What::Park, ..params }, In { models });
        out.map(|o| o.scene).map_err(|e| e.to_string())
    }

    #[test]
    fn the_default_park_is_the_built_in_one() {
        let scene = park(Params::default(), None).unwrap();
        assert_eq!(Some(&*scene), builtin::make("park", 1).as_ref());
        assert_eq!(scene.objects.len(), 64);
    }

    #[test]
    fn the_objects_of_a_scene_become_statues() {
        let models = Arc::new(builtin::make("solids", 1).unwrap());
        let params = Params { count: 40, shares: vec![2, 0, 3], width: 60.0, depth: 70.0, ..Params::default() };
        let scene = park(params, Some(models.clone())).unwrap();
        let of = |kind: &str| scene.objects.iter().filter(|o| o.name.starts_with(kind)).count();
        assert_eq!([of("box."), of("sphere."), of("torus.")], [16, 0, 24]);
        let mesh = &models.objects[0].parts[0].mesh;
        assert!(scene.objects.iter().any(|o| Arc::ptr_eq(&o.parts[0].mesh, mesh)), "meshes are shared, not copied");
    }

    #[test]
    fn what_gives_no_park_is_an_error() {
        let usual = Params::default();
        let text = park(Params { count: 5000, width: 90.0, ..usual.clone() }, None).unwrap_err();
        assert!(text.contains("is too small"), "{text}");
        let text = park(Params { shares: vec![1], ..usual.clone() }, None).unwrap_err();
        assert!(text.starts_with("1 shares for 6 kinds of statue: expected one for each (bench, column"), "{text}");
        let models = Some(Arc::new(builtin::make("solids", 1).unwrap()));
        let (out, _) = run::<MakeScene>(&usual, In { models });
        assert_eq!(
            out.err().map(|e| e.to_string()).as_deref(),
            Some("`models` is connected, and `city` takes none; `park` does")
        );
    }

    #[test]
    fn parameters_are_checked_before_anything_runs() {
        let bad = |change: &dyn Fn(&mut Params)| {
            let mut params = Params { what: What::Park, ..Params::default() };
            change(&mut params);
            refused::<MakeScene>(&params)
        };
        assert_eq!(bad(&|_| {}), None);
        assert_eq!(bad(&|p| p.count = 0).as_deref(), Some("count"));
        assert_eq!(bad(&|p| p.count = 100_001).as_deref(), Some("count"));
        assert_eq!(bad(&|p| p.width = 0.0).as_deref(), Some("width"));
        assert_eq!(bad(&|p| p.depth = -3.0).as_deref(), Some("depth"));
        assert_eq!(bad(&|p| p.depth = 1e6).as_deref(), Some("depth"));
        assert_eq!(bad(&|p| p.detail = 9.0).as_deref(), Some("detail"));
        assert_eq!(bad(&|p| p.shares = vec![0, 0]).as_deref(), Some("shares"));
        assert_eq!(bad(&|p| (p.what, p.count) = (What::Car, 3)).as_deref(), Some("count"));
        assert_eq!(bad(&|p| (p.what, p.detail) = (What::City, 2.0)).as_deref(), Some("detail"));
    }
}
