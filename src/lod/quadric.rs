//! Quadrics: weighted sums of squared distances from planes (Garland and Heckbert, *Surface Simplification Using Quadric Error Metrics*, 1997).

use glam::{DMat3, DVec3};

/// Σ w (n·p + d)² over planes, as a function of p.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quadric {
    /// Σ w n nᵀ.
    a: DMat3Zero,
    /// Σ w d n.
    b: DVec3,
    /// Σ w d².
    c: f64,
    /// Σ w.
    w: f64,
}

/// A matrix whose default is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DMat3Zero(DMat3);

impl Default for DMat3Zero {
    fn default() -> Self {
        Self(DMat3::ZERO)
    }
}

impl Quadric {
    /// The plane through `p` with unit normal `n`.
    pub fn plane(p: DVec3, n: DVec3, w: f64) -> Self {
        let d = -n.dot(p);
        let outer = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        Self { a: DMat3Zero(outer * w), b: n * (d * w), c: d * d * w, w }
    }

    pub fn add(&self, o: &Self) -> Self {
        Self { a: DMat3Zero(self.a.0 + o.a.0), b: self.b + o.b, c: self.c + o.c, w: self.w + o.w }
    }

    /// Its value at a point; never negative.
    pub fn at(&self, p: DVec3) -> f64 {
        (p.dot(self.a.0 * p) + 2.0 * self.b.dot(p) + self.c).max(0.0)
    }

    pub fn weight(&self) -> f64 {
        self.w
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_of_squared_distances() {
        let q = Quadric::plane(DVec3::X, DVec3::X, 2.0).add(&Quadric::plane(DVec3::Y * 3.0, DVec3::Y, 0.5));
        assert!((q.at(DVec3::new(4.0, 1.0, 9.0)) - (2.0 * 9.0 + 0.5 * 4.0)).abs() < 1e-12);
        assert_eq!((q.at(DVec3::new(1.0, 3.0, -5.0)), q.weight()), (0.0, 2.5));
    }
}
