//! Is a scene a solid?

use crate::raster::Geometry;
use rayon::prelude::*;

/// What the edges of a scene say about its surface, vertices at equal places taken for one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Closedness {
    /// Triangles with three different corners.
    pub triangles: usize,
    /// Edges with an odd number of faces: a ray through the surface may cross it an odd number of times beside them.
    pub open_edges: usize,
}

impl Closedness {
    /// Whether every ray crosses the surface an even number of times.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0
    }
}

/// Whether every edge has as many faces in one direction as in the other, so that the winding number is whole everywhere.
pub fn is_balanced(geometry: &Geometry) -> bool {
    let solid = corners(geometry);
    let edges = |[a, b, c]: &[u32; 3]| [(*a, *b), (*b, *c), (*c, *a)].map(|(a, b)| ([a.min(b), a.max(b)], a < b));
    let mut edges: Vec<([u32; 2], bool)> = solid.par_iter().flat_map_iter(edges).collect();
    edges.par_sort_unstable();
    let balanced = |faces: &[([u32; 2], bool)]| faces.iter().filter(|f| f.1).count() * 2 == faces.len();
    edges.chunk_by(|a, b| a.0 == b.0).all(balanced)
}

/// Counts open edges over all objects of a scene together.
pub fn closedness(geometry: &Geometry) -> Closedness {
    let solid = corners(geometry);
    let edges = |[a, b, c]: &[u32; 3]| [(*a, *b), (*b, *c), (*c, *a)].map(|(a, b)| [a.min(b), a.max(b)]);
    let mut edges: Vec<[u32; 2]> = solid.par_iter().flat_map_iter(edges).collect();
    edges.par_sort_unstable();
    let open_edges = edges.chunk_by(|a, b| a == b).filter(|faces| faces.len() % 2 == 1).count();
    Closedness { triangles: solid.len(), open_edges }
}

/// The corners of all triangles with three different ones, by numbers of places.
fn corners(geometry: &Geometry) -> Vec<[u32; 3]> {
    // The two zeros are one place.
    let places = |t: u32| geometry.positions(t).map(|p| p.to_array().map(|c| (c + 0.0).to_bits()));
    let mut all: Vec<[u64; 3]> = (0..geometry.triangle_count()).into_par_iter().flat_map_iter(places).collect();
    all.par_sort_unstable();
    all.dedup();
    (0..geometry.triangle_count())
        .into_par_iter()
        .map(|t| places(t).map(|p| all.partition_point(|q| *q < p) as u32))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect()
}
