//! What a cell's files hold: the row of a cell in the manifest.

use serde::{Deserialize, Serialize};

/// A cell of the manifest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// `column,row`.
    pub name: String,
    /// Metres: where the GLB's coordinates begin.
    pub centre: [f64; 3],
    /// Cells that share a side.
    pub neighbours: Vec<String>,
    /// Objects that are drawn as they are, not in the cell's files.
    pub inside: Vec<String>,
    pub stand_ins: Vec<StandInRow>,
    /// Triangles of the objects inside.
    pub inside_triangles: u64,
    /// Triangles of all stand-ins, and of the objects that they stand for.
    pub triangles: u64,
    pub original_triangles: u64,
    /// Of the atlases.
    pub texels: u64,
    /// Of the GLB file, and of each texture file.
    pub glb_bytes: u64,
    pub texture_bytes: u64,
}

/// A stand-in of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandInRow {
    /// The node of the GLB: that of its object, or of the first of a cluster with how many more there are.
    pub name: String,
    /// Objects that it stands for.
    pub objects: Vec<String>,
    /// `sv` or `mv`: made from the centre's view, or from neighbours' too.
    pub kind: String,
    pub triangles: u64,
    pub texels: u64,
}
