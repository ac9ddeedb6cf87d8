//! `view-cell`: the box from which a stand-in will be seen.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    math::Aabb,
    ports,
    scene::Scene,
    view::Cell,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A view cell: an axis-aligned box; the stand-in must look right from every point in it. Without a size it is a cube whose
/// side is 0.1 of the scene's diagonal; without a centre it lies 1.5 diagonals from the scene's centre along +Z. For that the
/// scene's bounds are rounded outward to a 32nd of a power of two, so that small changes of the scene do not change the cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Centre of the cell, metres.
    pub centre: Option<[f64; 3]>,
    /// Side lengths of the cell, metres, each > 0.
    #[schemars(extend("x-unit" = "m"))]
    pub size: Option<[f64; 3]>,
}

ports! {
    pub struct In {
        /// The scene from which a missing centre or size is derived; only its bounding box matters.
        scene: Option<Arc<Scene>>,
    }
}

ports! {
    pub struct Out {
        /// The cell.
        cell: Arc<Cell>,
    }
}

pub struct ViewCell;

impl Node for ViewCell {
    const KIND: &'static str = "view-cell";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        1 << 20
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        match params.size.filter(|size| size.iter().any(|v| *v <= 0.0)) {
            Some(size) => Err(("size", format!("expected side lengths above 0 m, found {size:?}"))),
            None => Ok(()),
        }
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let cell = match (params.centre, params.size) {
            (Some(centre), Some(size)) => Cell { centre: centre.into(), half: DVec3::from(size) * 0.5 },
            (centre, size) => {
                let bounds = inputs.scene.as_ref().map_or(Aabb::EMPTY, |s| s.bounds());
                let from_scene = default_cell(&bounds).ok_or_else(|| {
                    NodeError::Failed(
                        "a cell without centre or size needs a `scene` with an extent: connect one, or give both"
                            .into(),
                    )
                })?;
                Cell {
                    centre: centre.map_or(from_scene.centre, DVec3::from),
                    half: size.map_or(from_scene.half, |s| DVec3::from(s) * 0.5),
                }
            }
        };
        if let Some(text) = inputs.scene.and_then(|scene| doubt(&cell, &scene.bounds())) {
            (ctx.warn)(text);
        }
        Ok(Out { cell: Arc::new(cell) })
    }
}

/// A cell larger than this many diagonals of the scene can hardly be meant.
const LARGE: f64 = 100.0;

/// What to say of a cell that can hardly be meant for a scene with these bounds.
fn doubt(cell: &Cell, bounds: &Aabb) -> Option<String> {
    let (side, diagonal) = (cell.half.max_element() * 2.0, bounds.diagonal());
    let large = !bounds.is_empty() && diagonal > 0.0 && side > LARGE * diagonal;
    large.then(|| format!("the cell is {side:.4} m wide and the scene {diagonal:.4} m: lengths are metres"))
}

/// The cell of a scene with these bounds; `None` where they have no extent.
pub fn default_cell(bounds: &Aabb) -> Option<Cell> {
    if bounds.is_empty() || !(bounds.diagonal() > 0.0 && bounds.diagonal().is_finite()) {
        return None;
    }
    // The power of two below the diagonal: its exponent alone.
    let step = f64::from_bits(bounds.diagonal().to_bits() & 0x7ff0_0000_0000_0000) / 32.0;
    let rounded = Aabb { min: (bounds.min / step).floor() * step, max: (bounds.max / step).ceil() * step };
    let diagonal = rounded.diagonal();
    Some(Cell { centre: rounded.centre() + DVec3::Z * (1.5 * diagonal), half: DVec3::splat(0.05 * diagonal) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::refused;

    const BOUNDS: Aabb = Aabb { min: DVec3::new(-3.13, 0.02, -8.1), max: DVec3::new(9.2, 4.9, 7.77) };

    #[test]
    fn the_default_cell_stands_in_front_of_the_scene() {
        let cell = default_cell(&BOUNDS).unwrap();
        let d = BOUNDS.diagonal();
        assert!((cell.half * 2.0 / d - 0.1).abs().max_element() < 0.01);
        let off = cell.centre - BOUNDS.centre();
        assert!((off.z / d - 1.5).abs() < 0.15 && off.truncate().length() < 0.05 * d);
    }

    #[test]
    fn small_changes_leave_it_alone() {
        let moved = Aabb { min: BOUNDS.min + 0.01, max: BOUNDS.max - 0.01 };
        assert_eq!(default_cell(&BOUNDS), default_cell(&moved));
    }

    #[test]
    fn a_cell_that_dwarfs_the_scene_is_doubted() {
        let cell = |side: f64| Cell { centre: DVec3::ZERO, half: DVec3::new(1.0, side * 0.5, 1.0) };
        let d = BOUNDS.diagonal();
        assert!(doubt(&cell(20_000.0), &BOUNDS).unwrap().contains("20000.0000 m wide"));
        assert_eq!(doubt(&cell(99.0 * d), &BOUNDS), None);
        assert_eq!(doubt(&cell(1e9), &Aabb::EMPTY), None);
    }

    #[test]
    fn no_extent_no_cell() {
        assert_eq!(default_cell(&Aabb::EMPTY), None);
        assert_eq!(default_cell(&Aabb { min: DVec3::ONE, max: DVec3::ONE }), None);
    }

    #[test]
    fn bad_sizes_are_refused_before_anything_runs() {
        for (size, name) in [([0.0, 1.0, 1.0], "size"), ([1.0, f64::NAN, 1.0], ""), ([1.0, 1.0, -2.0], "size")] {
            assert_eq!(refused::<ViewCell>(&Params { centre: None, size: Some(size) }).as_deref(), Some(name));
        }
        let centre = Some([0.0, f64::INFINITY, 0.0]);
        assert!(refused::<ViewCell>(&Params { centre, size: None }).is_some());
        assert_eq!(refused::<ViewCell>(&Params::default()), None);
    }
}
