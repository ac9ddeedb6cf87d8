//! What must hold for the numbers in a [`VoxelMesh`], whoever made it.

use super::{
    Voxel, VoxelMesh,
    touch::{Point, point},
};

impl VoxelMesh {
    /// The voxels that face `f` covers, numbers into `voxels`.
    pub fn covered_by(&self, f: usize) -> &[u32] {
        &self.cover[self.cover_start[f] as usize..self.cover_start[f + 1] as usize]
    }

    /// The corners of face `f`, quarter units.
    pub fn triangle(&self, f: usize) -> [Point; 3] {
        self.faces[f].map(|v| point(self.vertices[v as usize]))
    }

    /// Checks that every number leads to something: lengths, faces, cover lists, order of the voxels.
    /// The error names the array and what is wrong with it.
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let vertices = self.vertices.len();
        if self.flags.len() != vertices {
            return Err(("flags", format!("{} for {vertices} vertices", self.flags.len())));
        }
        if let Some(f) = self.faces.iter().position(|f| f.iter().any(|v| *v as usize >= vertices)) {
            return Err(("faces", format!("face {f} names a vertex beyond {vertices}")));
        }
        let starts = &self.cover_start;
        if starts.len() != self.faces.len() + 1 {
            return Err(("cover_start", format!("{} for {} faces", starts.len(), self.faces.len())));
        }
        let ends = (starts[0], starts[self.faces.len()] as usize);
        if ends != (0, self.cover.len()) || !starts.windows(2).all(|w| w[0] <= w[1]) {
            return Err(("cover_start", format!("does not ascend from 0 to {}", self.cover.len())));
        }
        if self.cover.iter().any(|v| *v as usize >= self.voxels.len()) {
            return Err(("cover", format!("names a voxel beyond {}", self.voxels.len())));
        }
        let key = |v: &Voxel| (v.layer, v.y, v.x);
        if !self.voxels.windows(2).all(|w| key(&w[0]) < key(&w[1])) {
            return Err(("voxels", "not sorted by layer, y and x".into()));
        }
        if ![0, self.voxels.len()].contains(&self.quarters.len()) {
            return Err(("quarters", format!("{} for {} voxels", self.quarters.len(), self.voxels.len())));
        }
        if !(self.factor.is_finite() && self.factor >= 0.0) {
            return Err(("factor", format!("{} is no box size", self.factor)));
        }
        Ok(())
    }
}
