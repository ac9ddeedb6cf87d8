//! `separate-placement`: an object's shape, and where it stands.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    lod::{outline::Outline, subject::Placement},
    ports,
    scene::{Object, Scene},
};
use glam::{DAffine3, Mat4};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Separates what an object is from where it stands. Instances of one mesh have equal shapes, so what is made of a shape is made once for all of them, and moving
/// an object changes its placement only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {}

ports! {
    pub struct In {
        /// A scene of one object.
        object: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The object about its own origin, without its name.
        shape: Arc<Scene>,
        /// Where it stands, and the outline on the ground that holds it.
        placement: Arc<Placement>,
    }
}

pub struct SeparatePlacement;

impl Node for SeparatePlacement {
    const KIND: &'static str = "separate-placement";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // The corners of its outline; the shape shares what the object has.
        (1 << 20) + sizes[0]
    }

    fn run(_: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let [object] = &inputs.object.objects[..] else {
            let n = inputs.object.objects.len();
            return Err(NodeError::Failed(format!(
                "expected a scene of one object, found {n}; `split-objects` gives such scenes"
            )));
        };
        let placement = Placement {
            transform: DAffine3::from_mat4(object.transform.as_dmat4()),
            outline: Outline::of(object),
            triangles: object.triangle_count() as u64,
        };
        let shape = Object { name: "shape".into(), transform: Mat4::IDENTITY, parts: object.parts.clone() };
        Ok(Out { shape: Arc::new(Scene { objects: vec![shape] }), placement: Arc::new(placement) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::run;

    #[test]
    fn instances_have_one_shape() {
        let scene = crate::scene::builtin::make("car", 1).unwrap();
        let mut moved = scene.objects[0].clone();
        moved.name = "another".into();
        moved.transform = Mat4::from_rotation_y(1.0) * moved.transform;
        let separate = |o: &Object| {
            run::<SeparatePlacement>(&Params {}, In { object: Arc::new(Scene { objects: vec![o.clone()] }) }).0.unwrap()
        };
        let (a, b) = (separate(&scene.objects[0]), separate(&moved));
        assert_eq!(a.shape, b.shape);
        assert_ne!(a.placement, b.placement);
        assert!(run::<SeparatePlacement>(&Params {}, In { object: Arc::new(scene) }).0.is_err());
    }
}
