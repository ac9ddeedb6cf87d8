//! Meshes far from the origin: stored about an origin of their own, so that rounding to 32 bits keeps their shape.

use super::Aabb;
use glam::DVec3;

/// A mesh is shifted where coordinates are more than so many times as large as the mesh.
const FAR: f64 = 16.0;

/// What to subtract from positions within `bounds` before they are rounded: their centre, as multiples of a power of
/// two near their extent that are exact in 32 bits; zero where they lie about the origin already.
pub fn shift(bounds: &Aabb) -> DVec3 {
    if bounds.is_empty() {
        return DVec3::ZERO;
    }
    let extent = (bounds.max - bounds.min).max_element();
    let reach = bounds.max.abs().max(bounds.min.abs()).max_element();
    if !(extent.is_normal() && extent.is_finite() && reach > FAR * extent) {
        return DVec3::ZERO;
    }
    // The exponent alone: the power of two at or below. A multiple of the step fits into 32 bits.
    let power = |x: f64| f64::from_bits(x.to_bits() & (0x7ff << 52));
    let step = power(extent).max(power(reach) / (1 << 23) as f64);
    let centre = bounds.min + (bounds.max - bounds.min) * 0.5;
    (centre / step).round() * step
}

/// Whether a position can be stored: finite, also in 32 bits.
pub fn storable(p: DVec3) -> bool {
    p.abs().cmple(DVec3::splat(f32::MAX as f64)).all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_far_meshes_are_shifted_and_by_round_numbers() {
        let around = |c: DVec3, half: f64| Aabb { min: c - half, max: c + half };
        let utm = DVec3::new(691_234.567, 5_335_678.912, 500.0);
        let by = shift(&around(utm, 0.5));
        assert_eq!(by, DVec3::new(691_235.0, 5_335_679.0, 500.0));
        assert!((utm - by).abs().max_element() <= 0.5);
        for half in [1e-9, 1e-3, 0.5, 20.0] {
            let by = shift(&around(utm, half));
            assert_eq!(by.as_vec3().as_dvec3(), by);
            assert!((utm - by).abs().max_element() <= half.max(0.25));
        }
        assert_eq!(shift(&around(utm, 1e6)), DVec3::ZERO);
        assert_eq!(shift(&around(DVec3::splat(3.0), 2.0)), DVec3::ZERO);
        assert_eq!(shift(&Aabb::EMPTY), DVec3::ZERO);
        assert_eq!(shift(&around(utm, 0.0)), DVec3::ZERO);
        assert!(storable(utm) && !storable(DVec3::X * 1e39) && !storable(DVec3::Y * f64::NAN));
    }
}
