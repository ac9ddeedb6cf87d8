//! The grid of directions, and which of its frames a view blends.

use crate::view::{
    View,
    directions::{hemi_octahedral, octahedral, octahedral_frame},
};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Directions around an object: `side²` grid points, row by row. Point (column, row) has the octahedral coordinates
/// (column, row)/(side − 1)·2 − 1, so that the outermost points lie on the square's border.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Grid {
    /// Points along a side: 2 to 64 on the upper half, 3 to 64 all around.
    pub side: u32,
    /// Only directions from the horizon upwards (+Y).
    pub hemi: bool,
}

/// A frame that a view blends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pick {
    pub column: u32,
    pub row: u32,
    /// 0 to 1; those of a view's three frames add up to 1.
    pub weight: f64,
}

/// Height that directions below the horizon get on the upper half, before they are made unit vectors again.
const HORIZON: f64 = 1e-3;

impl Grid {
    pub(super) fn is_valid(self) -> bool {
        (if self.hemi { 2..=64 } else { 3..=64 }).contains(&self.side)
    }

    pub(super) fn expected(self) -> &'static str {
        if self.hemi { "2 to 64" } else { "3 to 64" }
    }

    /// Unit vector from the object to the eye of a grid point.
    pub fn direction(self, column: u32, row: u32) -> DVec3 {
        octahedral_frame(column, row, self.side, self.hemi)
    }

    /// The three frames that a view from `direction` (unit, from the object to the eye) blends. Each cell of the grid is cut along the
    /// diagonal from its first to its last point; the weights are barycentric coordinates in the triangle that holds the direction. On the
    /// upper half, directions below the horizon are drawn as those of the horizon.
    pub fn select(self, direction: DVec3) -> [Pick; 3] {
        let e = if self.hemi {
            hemi_octahedral(DVec3 { y: direction.y.max(HORIZON), ..direction })
        } else {
            octahedral(direction)
        };
        let last = f64::from(self.side - 1);
        let g = ((e * 0.5 + 0.5) * last).clamp(DVec2::ZERO, DVec2::splat(last));
        let cell = g.floor().min(DVec2::splat(last - 1.0));
        let f = g - cell;
        let (column, row) = (cell.x as u32, cell.y as u32);
        let pick = |dx: u32, dy: u32, weight: f64| Pick { column: column + dx, row: row + dy, weight };
        if f.x >= f.y {
            [pick(0, 0, 1.0 - f.x), pick(1, 0, f.x - f.y), pick(1, 1, f.y)]
        } else {
            [pick(0, 0, 1.0 - f.y), pick(0, 1, f.y - f.x), pick(1, 1, f.x)]
        }
    }
}

/// Right and up of the picture that looks at the object from the side where `direction` (unit) points: up is +Y as far as
/// possible, and +Z where the direction is vertical.
pub fn axes(direction: DVec3) -> [DVec3; 2] {
    let view = View::look_at(direction, DVec3::ZERO, DVec3::Y, 1.0, 1, 1, 1.0, 2.0);
    [view.right, view.up]
}
