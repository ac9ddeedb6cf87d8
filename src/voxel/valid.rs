//! What holds in every [`Slices`] and [`Field`], checked where they come from outside.

use super::{Field, Frustum, Side, Slices};

/// Sides of an image in the order of [`Frustum::across`].
pub const SIDES: [Side; 4] = [Side::Left, Side::Right, Side::Top, Side::Bottom];

impl Slices {
    /// Says what is wrong: which part, and what was found.
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let cell = &self.cell;
        if !(cell.centre.is_finite() && cell.half.is_finite() && cell.half.min_element() > 0.0) {
            return Err(("cell", "expected a finite centre and half extents > 0".into()));
        }
        if !(self.alpha.is_finite() && self.alpha > 0.0) {
            return Err(("alpha", format!("expected a finite angle > 0, found {}", self.alpha)));
        }
        let (layers, borders) = (&self.layers, &self.borders);
        if layers.is_empty() || layers.len() > usize::from(u16::MAX) || borders.len() != layers.len() + 1 {
            return Err(("layers", format!("{} layers with {} borders", layers.len(), borders.len())));
        }
        if let Some(l) = (0..layers.len()).find(|l| !(borders[*l] < layers[*l] && layers[*l] < borders[l + 1])) {
            return Err(("layers", format!("layer {l} does not lie between its borders")));
        }
        if !(borders[0] > 0.0 && layers.iter().all(|s| s.is_finite())) {
            return Err(("borders", format!("expected distances > 0, found {}", borders[0])));
        }
        if self.frusta.is_empty() {
            return Err(("frusta", "expected at least one".into()));
        }
        for (i, f) in self.frusta.iter().enumerate() {
            self.validate_frustum(f).map_err(|what| ("frusta", format!("frustum {i}: {what}")))?;
        }
        Ok(())
    }

    fn validate_frustum(&self, f: &Frustum) -> Result<(), String> {
        let orthonormal = [(f.right, f.up), (f.up, f.forward), (f.forward, f.right)]
            .iter()
            .all(|(a, b)| a.dot(*b).abs() < 1e-9 && (a.length_squared() - 1.0).abs() < 1e-9);
        if !(orthonormal && (f.right.cross(f.up) + f.forward).length() < 1e-9) {
            return Err("its axes are no right-handed frame".into());
        }
        let window = [f.left, f.right_tan, f.bottom, f.top];
        if !(window.iter().all(|t| t.is_finite()) && f.left < f.right_tan && f.bottom < f.top) {
            return Err(format!("expected a window left < right, bottom < top, found {window:?}"));
        }
        if f.size.iter().any(|n| *n == 0 || *n > u32::from(u16::MAX)) {
            return Err(format!("expected 1 to {} pixels a side, found {:?}", u16::MAX, f.size));
        }
        for (side, across) in SIDES.into_iter().zip(f.across) {
            let Some(a) = across else { continue };
            let Some(other) = self.frusta.get(a.frustum as usize) else {
                return Err(format!("its side {side:?} leads to frustum {}, which does not exist", a.frustum));
            };
            if side_pixels(f, side) != side_pixels(other, a.side) {
                return Err(format!("its side {side:?} has not as many pixels as the side it leads to"));
            }
        }
        Ok(())
    }
}

impl Field {
    /// Says what is wrong: which part, and what was found.
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let key = |i: usize| (self.voxels[i].layer, self.voxels[i].y, self.voxels[i].x);
        if let Some(i) = (1..self.voxels.len()).find(|i| key(i - 1) >= key(*i)) {
            return Err(("voxels", format!("voxel {i} is not in the order layer, y, x")));
        }
        if ![0, self.voxels.len()].contains(&self.quarters.len()) {
            return Err(("quarters", format!("{} for {} voxels", self.quarters.len(), self.voxels.len())));
        }
        if let Some(v) = self.voxels.iter().find(|v| v.object as usize >= self.objects.len()) {
            return Err(("voxels", format!("object {} of {}", v.object, self.objects.len())));
        }
        if self.objects.windows(2).any(|w| w[0] >= w[1]) {
            return Err(("objects", "names are not sorted or not unique".into()));
        }
        Ok(())
    }
}

/// Pixels along a side.
pub fn side_pixels(f: &Frustum, side: Side) -> u32 {
    match side {
        Side::Left | Side::Right => f.size[1],
        Side::Top | Side::Bottom => f.size[0],
    }
}
