//! Colours of vertices and faces as files write them: fractions, or numbers up to 255 or 65535.

/// What stands for 1 in channels whose greatest value is `greatest`, and whether they are `whole` numbers.
///
/// The formats mean fractions. Exporters that write 0 to 255 are told by a channel that no fraction would have.
pub(super) fn full_scale(greatest: f64, whole: bool) -> f64 {
    match greatest {
        g if !(g >= 2.0) || (!whole && g <= 16.0) => 1.0,
        g if g <= 255.0 => 255.0,
        g if g <= 65535.0 => 65535.0,
        _ => 1.0,
    }
}

/// The greatest of `values` and whether all are whole; what is not finite counts as nothing.
pub(super) fn survey(values: impl Iterator<Item = f64>) -> (f64, bool) {
    values.filter(|v| v.is_finite()).fold((0.0, true), |(most, whole), v| (v.max(most), whole && v.fract() == 0.0))
}

/// sRGB to linear (IEC 61966-2-1) of a value that is clamped to 0…1; what is no number counts as 1.
pub(super) fn linear(c: f32) -> f32 {
    let c = if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) };
    if c <= 0.04045 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) }
}

/// An opacity, clamped to 0…1; what is no number counts as 1.
pub(super) fn opacity(a: f32) -> f32 {
    if a.is_nan() { 1.0 } else { a.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_told_from_the_values() {
        let scale = |values: &[f64]| {
            let (most, whole) = survey(values.iter().copied());
            full_scale(most, whole)
        };
        assert_eq!(scale(&[0.0, 0.5, 1.0, f64::NAN]), 1.0);
        assert_eq!(scale(&[0.2, 1.0001]), 1.0);
        assert_eq!(scale(&[0.2, 4.5]), 1.0, "bright light, not bytes");
        assert_eq!(scale(&[0.0, 2.0]), 255.0);
        assert_eq!(scale(&[12.5, 200.25]), 255.0);
        assert_eq!(scale(&[0.0, 40000.0]), 65535.0);
        assert_eq!([linear(f32::NAN), linear(7.0), linear(-1.0), opacity(3.0)], [1.0, 1.0, 0.0, 1.0]);
    }
}
