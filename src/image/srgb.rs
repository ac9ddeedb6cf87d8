//! The sRGB transfer curve (IEC 61966-2-1) between bytes and linear light, by tables: same bits everywhere.

use std::sync::LazyLock;

fn decode(byte: f64) -> f64 {
    let c = byte / 255.0;
    if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| decode(i as f64) as f32));
/// Linear light half way (in code values) between byte i and the next.
static BETWEEN: LazyLock<[f32; 255]> = LazyLock::new(|| std::array::from_fn(|i| decode(i as f64 + 0.5) as f32));
/// The byte of the linear value i/4096: where the search for a value's byte begins. Codes are at least 1.2/4096 apart.
static FIRST: LazyLock<[u8; 4097]> =
    LazyLock::new(|| std::array::from_fn(|i| BETWEEN.partition_point(|t| *t <= i as f32 / 4096.0) as u8));

/// Linear light, 0 to 1, of an sRGB byte.
pub fn to_linear(byte: u8) -> f32 {
    LINEAR[byte as usize]
}

/// The sRGB byte nearest to a linear value, which is clamped to 0 to 1.
pub fn from_linear(value: f32) -> u8 {
    let mut code = FIRST[(value * 4096.0).clamp(0.0, 4096.0) as usize];
    while BETWEEN.get(code as usize).is_some_and(|t| *t <= value) {
        code += 1;
    }
    code
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for b in 0..=255 {
            assert_eq!(from_linear(to_linear(b)), b);
        }
        assert_eq!((from_linear(-1.0), from_linear(2.0), from_linear(f32::NAN)), (0, 255, 0));
        for i in 0..=100_000 {
            let v = i as f32 / 100_000.0;
            assert_eq!(from_linear(v) as usize, BETWEEN.partition_point(|t| *t <= v), "{v}");
        }
        assert!((to_linear(188) - 0.503).abs() < 1e-3);
    }
}
