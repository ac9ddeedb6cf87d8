//! View cells.

use crate::math::Aabb;
use glam::DVec3;

/// A view cell: an axis-aligned box from anywhere in which the stand-in must look right. Metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    pub centre: DVec3,
    /// Half extents, each > 0.
    pub half: DVec3,
}

impl Cell {
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.centre - self.half, max: self.centre + self.half }
    }

    pub fn corners(&self) -> [DVec3; 8] {
        self.bounds().corners()
    }
}
