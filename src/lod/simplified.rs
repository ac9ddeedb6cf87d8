//! What a collapse leaves of a surface.

use glam::DVec3;

/// A simplified subject: the vertices that are left, all lists of one length, and the triangles between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simplified {
    /// About the cell's centre, metres.
    pub positions: Vec<DVec3>,
    /// Base colours of the original, sRGB.
    pub colors: Vec<[u8; 4]>,
    /// One bit for each window that sees the vertex.
    pub views: Vec<u32>,
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// By how much the mesh that it started from may differ from the original, metres.
    pub error: f64,
    /// Triangles before the collapse.
    pub before: u64,
}
