//! `hybrid-lod.json`.

use crate::{lod::entry::Entry, view::HexGrid};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What the manifest says that it is.
pub const FORMAT: &str = "farfield-hybrid-lod";
/// The manifest's name in the bundle.
pub const MANIFEST: &str = "hybrid-lod.json";
const VERSION: u32 = 1;

/// The cells of a scene and where their files lie.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    pub format: String,
    pub version: u32,
    /// Centre of the cell of column 0 and row 0, metres.
    pub origin: [f64; 3],
    /// Of a cell, centre to corner, metres.
    pub size: f64,
    /// Half of a cell's height, metres.
    pub half_height: f64,
    pub columns: u32,
    pub rows: u32,
    /// Sorted by name; cells without an entry were not baked.
    pub cells: Vec<Entry>,
}

/// Why a manifest is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{MANIFEST}: {0}")]
pub struct ManifestError(pub String);

impl Manifest {
    pub fn new(grid: &HexGrid, mut cells: Vec<Entry>) -> Self {
        cells.sort_by(|a, b| a.name.cmp(&b.name));
        Self {
            format: FORMAT.into(),
            version: VERSION,
            origin: grid.origin.to_array(),
            size: grid.size,
            half_height: grid.half_height,
            columns: grid.columns,
            rows: grid.rows,
            cells,
        }
    }

    /// # Errors
    /// Where the bytes are no manifest of this format and version, or its grid is none.
    pub fn read(bytes: &[u8]) -> Result<Self, ManifestError> {
        let m: Self = serde_json::from_slice(bytes).map_err(|e| ManifestError(e.to_string()))?;
        let wrong = |what: String| Err(ManifestError(what));
        if (m.format.as_str(), m.version) != (FORMAT, VERSION) {
            return wrong(format!("expected the format {FORMAT} {VERSION}, found {} {}", m.format, m.version));
        }
        let finite = m.origin.iter().chain([&m.size, &m.half_height]).all(|n| n.is_finite());
        if !finite || m.size <= 0.0 || m.half_height < 0.0 || m.columns == 0 || m.rows == 0 {
            return wrong("expected a grid of cells with an extent".into());
        }
        if !m.cells.is_sorted_by(|a, b| a.name < b.name) {
            return wrong("expected cells sorted by name, each once".into());
        }
        Ok(m)
    }

    pub fn grid(&self) -> HexGrid {
        HexGrid {
            origin: DVec3::from(self.origin),
            size: self.size,
            half_height: self.half_height,
            columns: self.columns,
            rows: self.rows,
        }
    }

    /// The number in `cells` of the cell over which `eye` stands; `None` outside of the grid, or where that cell was not baked.
    pub fn locate(&self, eye: DVec3) -> Option<usize> {
        let (c, r) = self.grid().locate(eye)?;
        self.number(&HexGrid::name(c, r))
    }

    /// The number in `cells` of the cell of that name.
    pub fn number(&self, name: &str) -> Option<usize> {
        self.cells.binary_search_by(|e| e.name.as_str().cmp(name)).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_found_and_nonsense_is_refused() {
        let grid = HexGrid { origin: DVec3::ZERO, size: 10.0, half_height: 1.0, columns: 3, rows: 3 };
        let entry =
            |c, r| Entry { name: HexGrid::name(c, r), centre: grid.cell(c, r).centre.to_array(), ..Entry::default() };
        let manifest = Manifest::new(&grid, vec![entry(2, 1), entry(0, 0)]);
        let bytes = serde_json::to_vec(&manifest).unwrap();
        let read = Manifest::read(&bytes).unwrap();
        assert_eq!((&read, read.grid()), (&manifest, grid));
        assert_eq!(read.locate(grid.cell(2, 1).centre).map(|i| read.cells[i].name.as_str()), Some("2,1"));
        assert_eq!(read.locate(grid.cell(1, 1).centre), None);
        for wrong in [
            Manifest { size: 0.0, ..manifest.clone() },
            Manifest { format: "other".into(), ..manifest.clone() },
            Manifest { cells: manifest.cells.iter().rev().cloned().collect(), ..manifest },
        ] {
            assert!(Manifest::read(&serde_json::to_vec(&wrong).unwrap()).is_err());
        }
        assert!(Manifest::read(b"{").is_err());
    }
}
