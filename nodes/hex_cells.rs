//! `hex-cells`: the ground in hexagonal view cells.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::Relation,
    },
    ports,
    scene::Scene,
    view::{HexCell, HexGrid},
};
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeSet, sync::Arc};

/// Divides the ground below a scene into hexagonal view cells: prisms over the plane of x and z that hold the eyes of whoever walks there. Columns are named by
/// x, rows by z: `3,4`. Source: Chen et al., Rendering complex scenes using spatial subdivision and textured LOD meshes, 2003, section 3.1.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Of a cell, centre to corner: c. 0 for a thirtieth of the ground's longer side.
    #[schemars(range(min = 0.0, max = 1e9), extend("x-unit" = "m"))]
    pub size: f64,
    /// Heights above the scene's lowest point between which eyes are: `[1.5, 2]`. Empty for 2 % to 3 % of the cell's size.
    #[schemars(extend("x-unit" = "m"))]
    pub heights: Vec<f64>,
    /// The rectangle of the ground: `[x, z, x, z]`. Empty for that of the scene.
    #[schemars(extend("x-unit" = "m"))]
    pub area: Vec<f64>,
    /// Only these cells, such as `["3,4"]`; empty for all.
    pub cells: Vec<String>,
    /// Only cells that this line of points meets, `[[x, z], …]`; empty for all.
    #[schemars(extend("x-unit" = "m"))]
    pub path: Vec<[f64; 2]>,
    /// More cells than this are an error.
    #[schemars(range(min = 1, max = 10_000_000))]
    pub most: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { size: 0.0, heights: Vec::new(), area: Vec::new(), cells: Vec::new(), path: Vec::new(), most: 10_000 }
    }
}

ports! {
    pub struct In {
        /// What stands on the ground.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The cells, by `column,row`.
        cells: List<HexCell>,
        /// The grid that they are part of.
        grid: Arc<HexGrid>,
        /// Which of the cells share a side.
        neighbours: Arc<Relation>,
    }
}

pub struct HexCells;

/// Points along a line, in cells' sizes, at which it is looked where it is.
const STEP: f64 = 0.05;

impl Node for HexCells {
    const KIND: &'static str = "hex-cells";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, _: &[u64]) -> u64 {
        (16 << 20) + u64::from(params.most) * 2048
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        match params.heights[..] {
            [] => {}
            [low, high] if low.is_finite() && high.is_finite() && low <= high => {}
            _ => return Err(("heights", format!("expected two heights, the lower first, found {:?}", params.heights))),
        }
        match params.area[..] {
            [] => {}
            [a, b, c, d] if params.area.iter().all(|v| v.is_finite()) && a < c && b < d => {}
            _ => return Err(("area", format!("expected `[x, z, x, z]`, the smaller first, found {:?}", params.area))),
        }
        match params.path.iter().find(|p| !p.iter().all(|v| v.is_finite())) {
            Some(p) => Err(("path", format!("expected finite coordinates, found {p:?}"))),
            None => Ok(()),
        }
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let bounds = inputs.scene.bounds();
        let (min, max) = match params.area[..] {
            [a, b, c, d] => (DVec2::new(a, b), DVec2::new(c, d)),
            _ if bounds.is_empty() => {
                return Err(NodeError::Failed("the scene has no triangles, and `area` gives no ground".into()));
            }
            _ => (DVec2::new(bounds.min.x, bounds.min.z), DVec2::new(bounds.max.x, bounds.max.z)),
        };
        let size = if params.size > 0.0 { params.size } else { (max - min).max_element() / 30.0 };
        if size <= 0.0 {
            return Err(NodeError::Failed("the ground has no extent: expected `size` above 0".into()));
        }
        let floor = if bounds.is_empty() { 0.0 } else { bounds.min.y };
        let [low, high] = match params.heights[..] {
            [low, high] => [low, high],
            _ => [0.02 * size, 0.03 * size],
        };
        let grid = HexGrid::over(min, max, size, floor + low, floor + high);
        if params.cells.is_empty() && params.path.is_empty() && grid.count() > u64::from(params.most) {
            return Err(NodeError::Failed(format!(
                "{} × {} cells of size {size} m are more than the {} that `most` allows; expected a larger `size`",
                grid.columns, grid.rows, params.most
            )));
        }
        let mut chosen: BTreeSet<(u32, u32)> = BTreeSet::new();
        for name in &params.cells {
            let parsed = name.split_once(',').and_then(|(c, r)| Some((c.parse().ok()?, r.parse().ok()?)));
            match parsed.filter(|(c, r)| *c < grid.columns && *r < grid.rows) {
                Some(cell) => _ = chosen.insert(cell),
                None => {
                    return Err(NodeError::Failed(format!(
                        "`cells`: `{name}` is none; expected names from `0,0` to `{}`",
                        HexGrid::name(grid.columns - 1, grid.rows - 1)
                    )));
                }
            }
        }
        chosen.extend(along(&grid, &params.path, params.most)?);
        if chosen.is_empty() {
            if !params.path.is_empty() {
                return Err(NodeError::Failed(format!(
                    "`path` meets no cell: expected points of the ground, x from {} to {} and z from {} to {} m",
                    min.x, max.x, min.y, max.y
                )));
            }
            chosen.extend(grid.cells());
        }
        let cells: Vec<HexCell> = chosen.iter().map(|(c, r)| grid.hex_cell(*c, *r)).collect();
        let has: BTreeSet<&str> = cells.iter().map(|c| c.name.as_str()).collect();
        let kept =
            |c: &HexCell| c.neighbours.iter().map(|n| n.0.clone()).filter(|n| has.contains(n.as_str())).collect();
        let neighbours = Relation(cells.iter().map(|c| (c.name.clone(), kept(c))).collect());
        let mut cells: Vec<_> = cells.into_iter().map(|c| (c.name.clone(), Arc::new(c))).collect();
        cells.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(Out { cells: List(cells), grid: Arc::new(grid), neighbours: Arc::new(neighbours) })
    }
}

/// Cells that a line meets.
fn along(grid: &HexGrid, path: &[[f64; 2]], most: u32) -> Result<BTreeSet<(u32, u32)>, NodeError> {
    let mut out = BTreeSet::new();
    let at = |p: DVec2| grid.locate(DVec3::new(p.x, grid.origin.y, p.y));
    out.extend(path.first().and_then(|p| at(DVec2::from(*p))));
    for pair in path.windows(2) {
        let (a, b) = (DVec2::from(pair[0]), DVec2::from(pair[1]));
        let steps = (a.distance(b) / (grid.size * STEP)).ceil().max(1.0);
        if steps > f64::from(most) * 1000.0 {
            return Err(NodeError::Failed(format!(
                "`path`: a line of {} m is too long for cells of {} m",
                a.distance(b),
                grid.size
            )));
        }
        out.extend((0..=steps as u64).filter_map(|i| at(a.lerp(b, i as f64 / steps))));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::{refused, run};

    fn solids() -> Arc<Scene> {
        Arc::new(crate::scene::builtin::make("solids", 1).unwrap())
    }

    #[test]
    fn cells_cover_the_ground() {
        let out = run::<HexCells>(&Params { size: 1.0, ..Params::default() }, In { scene: solids() }).0.unwrap();
        let b = solids().bounds();
        assert!(out.grid.locate(b.min).is_some() && out.grid.locate(b.max).is_some());
        assert_eq!(out.cells.0.len() as u64, out.grid.count());
        for (name, related) in &out.neighbours.0 {
            assert!(related.iter().all(|r| out.neighbours.0[r].contains(name)), "{name}");
        }
    }

    #[test]
    fn some_cells_and_those_of_a_path() {
        let params = Params { size: 1.0, area: vec![0.0, 0.0, 30.0, 30.0], ..Params::default() };
        let some = Params { cells: vec!["3,4".into(), "0,0".into()], ..params.clone() };
        let names = |p: &Params| -> Vec<String> {
            run::<HexCells>(p, In { scene: solids() }).0.unwrap().cells.0.iter().map(|c| c.0.clone()).collect()
        };
        assert_eq!(names(&some), ["0,0", "3,4"]);
        let path = names(&Params { path: vec![[0.0, 0.0], [0.0, 5.0]], ..params });
        assert_eq!(path, ["0,0", "0,1", "0,2", "0,3"]);
    }

    #[test]
    fn what_cannot_be_is_an_error() {
        let fails = |p: &Params| run::<HexCells>(p, In { scene: solids() }).0.err().unwrap().to_string();
        assert!(fails(&Params { size: 1e-4, ..Params::default() }).contains("`most` allows"));
        assert!(fails(&Params { cells: vec!["9,x".into()], ..Params::default() }).contains("`9,x` is none"));
        assert!(fails(&Params { path: vec![[1e6, 0.0]], ..Params::default() }).contains("meets no cell"));
        let empty = In { scene: Arc::default() };
        assert!(run::<HexCells>(&Params::default(), empty).0.err().unwrap().to_string().contains("no triangles"));
        assert_eq!(refused::<HexCells>(&Params { size: -1.0, ..Params::default() }).as_deref(), Some("size"));
        assert_eq!(
            refused::<HexCells>(&Params { heights: vec![2.0], ..Params::default() }).as_deref(),
            Some("heights")
        );
    }
}
