//! Where statues stand: circles on a rectangle that do not overlap, by rejection.
//!
//! What always holds: the places of `count` statues are the first ones of those of any larger count, so that a small park is a
//! subset of a large one, as the 2M-, 4M- and 8M-scenes of Chen et al. 2003, section 4.1.1, are. For that, the order in which kinds
//! take turns depends on their shares only, and a statue's random numbers on the seed, its kind and its number in that kind only.

use super::super::random::Random;
use std::{collections::BTreeMap, f64::consts::TAU};

/// Least and greatest detail of procedural statues.
pub const DETAIL: [f64; 2] = [0.25, 8.0];
/// Places tried for one statue before the rectangle counts as full.
pub const TRIES: u32 = 1000;
/// Most statues of one park.
pub const MOST_STATUES: u32 = 100_000;
/// Longest side of a park, metres: coordinates in 32 bits stay exact to 4 mm.
pub const LONGEST_SIDE: f64 = 65_536.0;
/// Least distance between the circles of two statues, metres.
pub const CLEARANCE: f64 = 1.0;

/// How many statues stand where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Park {
    /// Statues, 1 to [`MOST_STATUES`].
    pub count: u32,
    pub seed: u64,
    /// Along x and along z, metres, above 0 and at most [`LONGEST_SIDE`]. The centre of the park is the origin.
    pub width: f64,
    pub depth: f64,
}

/// The size and number of statues of the paper's 2M-scene.
impl Default for Park {
    fn default() -> Self {
        Self { count: 64, seed: 1, width: 1650.0, depth: 2035.0 }
    }
}

/// What a kind of statue needs of its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Of the circle around its axis that holds it, metres.
    pub radius: f64,
    /// How many of the statues are of this kind, in proportion to the shares of the others.
    pub share: u32,
}

/// A statue's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Number of the kind.
    pub kind: usize,
    /// From 1, among those of its kind.
    pub number: u32,
    /// Where its axis meets the ground, metres.
    pub x: f64,
    pub z: f64,
    /// Counter-clockwise about the y axis, radians, 0 to 2π.
    pub turn: f64,
}

/// Why there is no such park.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParkError {
    #[error("{0} statues: expected 1 to {MOST_STATUES}")]
    Count(u32),
    #[error("a park of {width} m × {depth} m: both sides must be above 0 m and at most {LONGEST_SIDE} m")]
    Area { width: f64, depth: f64 },
    #[error("detail {0}: expected {least} to {most}", least = DETAIL[0], most = DETAIL[1])]
    Detail(f64),
    #[error("there is no kind of statue: the scene of models has no object with triangles")]
    NoKinds,
    #[error("{found} shares for {kinds} kinds of statue: expected one for each ({names}), in this order")]
    Shares { found: usize, kinds: usize, names: String },
    #[error("all shares are 0: no kind would get a statue")]
    NoShares,
    #[error("kind `{name}`: {what}")]
    Kind { name: String, what: String },
    #[error(
        "no free place for statue {statue} of {count} in {TRIES} tries: an area of {width} m × {depth} m is too small for \
         a circle of {radius:.2} m radius beside those that stand; take fewer statues or a larger area"
    )]
    Crowded { statue: u32, count: u32, radius: f64, width: f64, depth: f64 },
}

/// Whose turn it is: kinds in proportion to their shares, in every prefix as well as possible.
pub struct Turns {
    shares: Vec<u64>,
    total: u64,
    given: Vec<u64>,
    turn: u64,
}

impl Turns {
    /// # Errors
    /// Where no share is above 0.
    pub fn new(shares: impl IntoIterator<Item = u32>) -> Result<Self, ParkError> {
        let shares: Vec<u64> = shares.into_iter().map(u64::from).collect();
        let total = shares.iter().sum();
        if total == 0 {
            return Err(ParkError::NoShares);
        }
        Ok(Self { given: vec![0; shares.len()], shares, total, turn: 0 })
    }

    /// The kind of the next statue and its number among its kind, from 1.
    pub fn take(&mut self) -> (usize, u32) {
        self.turn += 1;
        let turn = self.turn;
        // Most behind what it should have by now; of equals the first.
        let behind = |k: usize| {
            i128::from(self.shares[k]) * i128::from(turn) - i128::from(self.given[k]) * i128::from(self.total)
        };
        let open = (0..self.shares.len()).filter(|k| self.shares[*k] > 0);
        let kind = open.max_by_key(|k| (behind(*k), std::cmp::Reverse(*k))).unwrap_or_default();
        self.given[kind] += 1;
        (kind, self.given[kind] as u32)
    }
}

/// Numbers of one statue: other statues' tries do not change them.
fn stream(seed: u64, kind: usize, number: u32) -> Random {
    let mut mixed = Random::new(seed);
    let mixed = mixed.bits() ^ ((kind as u64) << 32 | u64::from(number));
    Random::new(Random::new(mixed).bits())
}

/// Uniform in [0, 1), of 53 bits.
fn unit(random: &mut Random) -> f64 {
    (random.bits() >> 11) as f64 / (1u64 << 53) as f64
}

/// Circles that stand, in squares as wide as the largest circle with its clearance.
struct Standing {
    side: f64,
    squares: BTreeMap<(i64, i64), Vec<[f64; 3]>>,
}

impl Standing {
    fn square(&self, x: f64, z: f64) -> (i64, i64) {
        ((x / self.side).floor() as i64, (z / self.side).floor() as i64)
    }

    fn is_free(&self, x: f64, z: f64, radius: f64) -> bool {
        let (i, j) = self.square(x, z);
        let near = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| (i, j)));
        near.filter_map(|s| self.squares.get(&s)).flatten().all(|[ox, oz, r]| {
            let apart = r + radius + CLEARANCE;
            (x - ox) * (x - ox) + (z - oz) * (z - oz) >= apart * apart
        })
    }

    fn add(&mut self, x: f64, z: f64, radius: f64) {
        self.squares.entry(self.square(x, z)).or_default().push([x, z, radius]);
    }
}

/// Places for `park.count` statues of these kinds, in the order in which they take turns. Their circles lie in the rectangle and do
/// not overlap.
///
/// # Errors
/// A count, an area or shares out of range, and where no free place is found in [`TRIES`] tries.
pub fn places(kinds: &[Footprint], park: &Park) -> Result<Vec<Place>, ParkError> {
    let Park { count, seed, width, depth } = *park;
    if count == 0 || count > MOST_STATUES {
        return Err(ParkError::Count(count));
    }
    if !(width > 0.0 && width <= LONGEST_SIDE && depth > 0.0 && depth <= LONGEST_SIDE) {
        return Err(ParkError::Area { width, depth });
    }
    let largest = kinds.iter().map(|k| k.radius).fold(0.0, f64::max);
    let mut standing = Standing { side: 2.0 * largest + CLEARANCE, squares: BTreeMap::new() };
    let mut turns = Turns::new(kinds.iter().map(|k| k.share))?;
    let mut places = Vec::with_capacity(count as usize);
    for statue in 1..=count {
        let (kind, number) = turns.take();
        let radius = kinds[kind].radius;
        let mut random = stream(seed, kind, number);
        let turn = unit(&mut random) * TAU;
        let (wide, deep) = (width - 2.0 * radius, depth - 2.0 * radius);
        let fits = wide >= 0.0 && deep >= 0.0;
        let found = (0..TRIES).filter(|_| fits).find_map(|_| {
            let (x, z) = ((unit(&mut random) - 0.5) * wide, (unit(&mut random) - 0.5) * deep);
            standing.is_free(x, z, radius).then_some((x, z))
        });
        let Some((x, z)) = found else {
            return Err(ParkError::Crowded { statue, count, radius, width, depth });
        };
        standing.add(x, z, radius);
        places.push(Place { kind, number, x, z, turn });
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(shares: &[u32]) -> Vec<Footprint> {
        shares.iter().enumerate().map(|(i, share)| Footprint { radius: 5.0 + i as f64 * 3.0, share: *share }).collect()
    }

    #[test]
    fn a_small_park_is_the_beginning_of_a_large_one() {
        for shares in [&[1, 1, 1][..], &[18, 26, 4, 97], &[0, 7], &[1, 1000]] {
            let kinds = kinds(shares);
            let all = places(&kinds, &Park { count: 200, ..Park::default() }).unwrap();
            for count in [1, 2, 63, 64, 132, 199] {
                assert_eq!(places(&kinds, &Park { count, ..Park::default() }).unwrap(), all[..count as usize]);
            }
        }
    }

    #[test]
    fn circles_lie_apart_and_inside() {
        let kinds = kinds(&[2, 1, 1]);
        // Dense: about a third of the area is covered.
        let park = Park { count: 60, seed: 7, width: 200.0, depth: 300.0 };
        let all = places(&kinds, &park).unwrap();
        for (i, a) in all.iter().enumerate() {
            let r = kinds[a.kind].radius;
            assert!(a.x.abs() + r <= 100.0 && a.z.abs() + r <= 150.0);
            assert!((0.0..TAU).contains(&a.turn));
            for b in &all[..i] {
                let apart = libm::hypot(a.x - b.x, a.z - b.z);
                assert!(apart >= r + kinds[b.kind].radius + CLEARANCE, "{a:?} {b:?}");
            }
        }
        let other = places(&kinds, &Park { seed: 8, ..park }).unwrap();
        assert_ne!(all, other);
    }

    #[test]
    fn every_prefix_follows_the_shares() {
        let shares = [18u32, 26, 4, 4, 4, 4, 97, 96];
        let total: u32 = shares.iter().sum();
        let mut turns = Turns::new(shares).unwrap();
        let mut given = [0u32; 8];
        for turn in 1..=total {
            let (kind, number) = turns.take();
            given[kind] += 1;
            assert_eq!(given[kind], number);
            for (share, given) in shares.iter().zip(given) {
                let due = f64::from(*share) * f64::from(turn) / f64::from(total);
                assert!((f64::from(given) - due).abs() < 2.0, "{given} of {due} after {turn}");
            }
        }
        assert_eq!(given, shares);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let error = |shares: &[u32], park: Park| places(&kinds(shares), &park).unwrap_err().to_string();
        let usual = Park::default();
        assert_eq!(error(&[1], Park { count: 0, ..usual }), "0 statues: expected 1 to 100000");
        assert_eq!(error(&[1], Park { count: 100_001, ..usual }), "100001 statues: expected 1 to 100000");
        for width in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e6] {
            let text = error(&[1], Park { width, ..usual });
            assert!(text.starts_with(&format!("a park of {width} m × 2035 m: both sides")), "{text}");
        }
        assert_eq!(error(&[0, 0], usual), "all shares are 0: no kind would get a statue");
        assert_eq!(error(&[], usual), "all shares are 0: no kind would get a statue");
        // Four circles of 5 m fit, not forty; and a circle that is wider than the area fits never.
        let text = error(&[1], Park { count: 40, width: 30.0, depth: 30.0, ..usual });
        assert!(text.contains("no free place for statue") && text.contains("30 m × 30 m is too small"), "{text}");
        let text = error(&[1], Park { width: 9.0, ..usual });
        assert!(text.starts_with("no free place for statue 1 of 64"), "{text}");
    }
}
