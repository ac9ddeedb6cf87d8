//! A low-discrepancy sequence with a seed: Roberts' generalisation of the golden ratio, shifted at random.
//!
//! Point i of dimension D is frac(shift + i · (1/φ, 1/φ², …, 1/φᴰ)), φ the positive root of x^(D+1) = x + 1; the
//! shift (Cranley and Patterson) comes from the seed. Multiples of a constant lose at most half their bits at
//! i = 2²⁶, far beyond what is drawn here, and need no transcendental function.

/// A sequence of points in [0, 1)ᴰ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sequence<const D: usize> {
    shift: [f64; D],
    step: [f64; D],
}

impl<const D: usize> Sequence<D> {
    pub fn new(seed: u64) -> Self {
        // Newton's iteration on x^(D+1) − x − 1 from above converges to the root.
        let mut phi = 2.0_f64;
        for _ in 0..64 {
            let power = (0..D).fold(1.0, |p, _| p * phi);
            phi -= (power * phi - phi - 1.0) / ((D + 1) as f64 * power - 1.0);
        }
        let (mut step, mut power) = ([0.0; D], 1.0);
        for s in &mut step {
            power /= phi;
            *s = power;
        }
        let mut state = seed;
        Self { shift: std::array::from_fn(|_| (splitmix(&mut state) >> 11) as f64 / (1_u64 << 53) as f64), step }
    }

    pub fn point(&self, i: u32) -> [f64; D] {
        std::array::from_fn(|k| {
            let x = self.shift[k] + f64::from(i) * self.step[k];
            x - x.floor()
        })
    }
}

/// The SplitMix64 generator (Steele, Lea and Flood 2014).
fn splitmix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_dimension_is_the_golden_ratio() {
        let s = Sequence::<1>::new(3);
        assert!((s.step[0] - 0.618_033_988_749_895).abs() < 1e-12);
    }

    #[test]
    fn points_fill_the_cube_evenly() {
        for seed in 0..4 {
            let s = Sequence::<3>::new(seed);
            let mut octants = [0; 8];
            for i in 0..800 {
                let p = s.point(i);
                assert!(p.iter().all(|x| (0.0..1.0).contains(x)));
                octants[p.iter().enumerate().map(|(k, x)| usize::from(*x >= 0.5) << k).sum::<usize>()] += 1;
            }
            assert!(octants.iter().all(|n| (85..=115).contains(n)), "{octants:?}");
        }
    }

    #[test]
    fn the_seed_moves_every_point() {
        assert_ne!(Sequence::<3>::new(1).point(5), Sequence::<3>::new(2).point(5));
        assert_eq!(Sequence::<3>::new(1).point(5), Sequence::<3>::new(1).point(5));
    }
}
