//! Relief maps, what they cover, and which of them are used.

use super::camera::{get_view, put_view};
use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    relief::{
        DepthBits, ReliefMap, Search, Trace,
        coverage::Mask,
        measure::{Coverage, Selection},
        select::{Choice, Covered, Subset},
    },
};
use glam::DVec3;
use serde::{Deserialize, Serialize};

impl Artifact for ReliefMap {
    const TYPE: &'static str = "ReliefMap";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        put_view(out, &self.view);
        out.array("bits", &[self.bits.codes().ilog2()]);
        match self.bits {
            DepthBits::Eight => out.bytes("depth", self.depth.iter().map(|c| *c as u8).collect()),
            DepthBits::Sixteen => out.array("depth", &self.depth),
        }
        out.array("color", &self.color);
        out.array("normal", &self.normal);
        out.array("orm", &self.orm);
        out.array("emissive", &self.emissive);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let (bits, depth) = match data.array::<u32>("bits")?[..] {
            [8] => (DepthBits::Eight, data.array::<u8>("depth")?.iter().map(|c| u16::from(*c)).collect()),
            [16] => (DepthBits::Sixteen, data.array("depth")?),
            _ => return Err(DecodeError::section("bits", "expected 8 or 16")),
        };
        let map = Self {
            view: get_view(data)?,
            bits,
            depth,
            color: data.array("color")?,
            normal: data.array("normal")?,
            orm: data.array("orm")?,
            emissive: data.array("emissive")?,
        };
        map.check().map_err(|e| DecodeError::section("map", e.to_string()))?;
        Ok(map)
    }
}

/// [`Trace`], stored.
#[derive(Serialize, Deserialize)]
struct Rays {
    search: String,
    steps: [u32; 2],
    wall: f32,
}

impl Rays {
    fn of(trace: &Trace) -> Self {
        let (search, steps) = match trace.search {
            Search::Linear { steps, halvings } => ("linear", [steps, halvings]),
            Search::Pyramid => ("pyramid", [0; 2]),
        };
        Self { search: search.into(), steps, wall: trace.wall }
    }

    fn trace(&self) -> Result<Trace, DecodeError> {
        let search = match (&*self.search, self.steps) {
            ("linear", [steps, halvings]) if steps > 0 => Search::Linear { steps, halvings },
            ("pyramid", _) => Search::Pyramid,
            _ => return Err(DecodeError::section("head", "expected a search")),
        };
        Ok(Trace { search, wall: self.wall })
    }
}

#[derive(Serialize, Deserialize)]
struct CoverageHead {
    size: u32,
    rays: Rays,
    maps: Vec<(String, [f64; 3])>,
    directions: Vec<[f64; 3]>,
    /// The maps of each direction.
    nearest: Vec<Vec<u32>>,
}

impl Artifact for Coverage {
    const TYPE: &'static str = "Coverage";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json(
            "head",
            &CoverageHead {
                size: self.size,
                rays: Rays::of(&self.trace),
                maps: self.maps.iter().map(|(n, d)| (n.clone(), d.to_array())).collect(),
                directions: self.directions.iter().map(DVec3::to_array).collect(),
                nearest: self.covered.iter().map(|c| c.maps.iter().map(|m| m.0).collect()).collect(),
            },
        );
        let mut words: Vec<u64> = Vec::new();
        for c in &self.covered {
            words.extend(&c.original.0);
            words.extend(c.maps.iter().flat_map(|m| &m.1.0));
        }
        out.array("masks", &words);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let head: CoverageHead = data.json("head")?;
        let words = data.array::<u64>("masks")?;
        let wrong = |what: &str| DecodeError::section("masks", what);
        let each = (u64::from(head.size) * u64::from(head.size)).div_ceil(64) as usize;
        let masks: usize = head.nearest.iter().map(|n| n.len() + 1).sum();
        if head.nearest.len() != head.directions.len() || masks.checked_mul(each) != Some(words.len()) || each == 0 {
            return Err(wrong("expected the masks of every direction"));
        }
        if head.nearest.iter().flatten().any(|m| *m as usize >= head.maps.len()) {
            return Err(wrong("a number beyond the maps"));
        }
        let mut masks = words.chunks_exact(each).map(|w| Mask(w.to_vec()));
        let mut next = || masks.next().unwrap_or_else(|| Mask::empty(0));
        let covered =
            head.nearest.iter().map(|n| Covered { original: next(), maps: n.iter().map(|m| (*m, next())).collect() });
        Ok(Self {
            covered: covered.collect(),
            size: head.size,
            trace: head.rays.trace()?,
            maps: head.maps.into_iter().map(|(n, d)| (n, d.into())).collect(),
            directions: head.directions.into_iter().map(DVec3::from).collect(),
        })
    }
}

#[derive(Serialize, Deserialize)]
struct SelectionHead {
    size: u32,
    rays: Rays,
    /// Of the best subset, with the number of neighbours.
    goal: Option<(f64, u32)>,
    /// Of the closest maps.
    closest: Option<u32>,
    maps: Vec<String>,
    directions: Vec<[f64; 3]>,
    /// Maps, missing and extra pixels of each direction.
    subsets: Vec<(Vec<u32>, u64, u64)>,
}

impl Artifact for Selection {
    const TYPE: &'static str = "ImpostorSelection";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let (goal, closest) = match self.choice {
            Choice::Best { goal, neighbours } => (Some((goal, neighbours)), None),
            Choice::Closest(m) => (None, Some(m)),
        };
        out.json(
            "head",
            &SelectionHead {
                size: self.size,
                rays: Rays::of(&self.trace),
                goal,
                closest,
                maps: self.maps.clone(),
                directions: self.directions.iter().map(DVec3::to_array).collect(),
                subsets: self.subsets.iter().map(|s| (s.maps.clone(), s.missing, s.extra)).collect(),
            },
        );
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let head: SelectionHead = data.json("head")?;
        let wrong = |what: &str| DecodeError::section("head", what);
        let choice = match (head.goal, head.closest) {
            (Some((goal, neighbours)), None) => Choice::Best { goal, neighbours },
            (None, Some(m)) => Choice::Closest(m),
            _ => return Err(wrong("expected a goal or a number of maps")),
        };
        if head.subsets.len() != head.directions.len() {
            return Err(wrong("expected a subset for every direction"));
        }
        if head.subsets.iter().flat_map(|s| &s.0).any(|m| *m as usize >= head.maps.len()) {
            return Err(wrong("a number beyond the maps"));
        }
        Ok(Self {
            size: head.size,
            trace: head.rays.trace()?,
            choice,
            maps: head.maps,
            directions: head.directions.into_iter().map(DVec3::from).collect(),
            subsets: head.subsets.into_iter().map(|(maps, missing, extra)| Subset { maps, missing, extra }).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::artifact::{from_bytes, to_bytes},
        view::directions::look_along,
    };
    use std::sync::Arc;

    fn map(bits: DepthBits) -> ReliefMap {
        let view = look_along([DVec3::ZERO, DVec3::ONE].into_iter(), DVec3::Z, 2, 0.0).unwrap();
        ReliefMap {
            view,
            bits,
            depth: [0, 7, 200, (bits.codes() - 1) as u16].into_iter().collect(),
            color: [[1, 2, 3, 255]; 4].into_iter().collect(),
            normal: [[127, 254]; 4].into_iter().collect(),
            orm: Default::default(),
            emissive: [[9; 4]; 4].into_iter().collect(),
        }
    }

    #[test]
    fn maps_decode_to_what_was_encoded() {
        for bits in [DepthBits::Eight, DepthBits::Sixteen] {
            assert_eq!(from_bytes::<ReliefMap>(Arc::new(to_bytes(&map(bits)))), Ok(map(bits)));
        }
        let mut wrong = map(DepthBits::Eight);
        wrong.normal = [[0; 2]; 3].into_iter().collect();
        assert!(from_bytes::<ReliefMap>(Arc::new(to_bytes(&wrong))).is_err());
    }

    fn coverage() -> Coverage {
        Coverage {
            size: 9,
            trace: Trace { search: Search::Linear { steps: 16, halvings: 7 }, wall: 4.0 },
            maps: vec![("a".into(), DVec3::X), ("b".into(), DVec3::Y)],
            directions: vec![DVec3::X, DVec3::Z],
            covered: vec![
                Covered { original: Mask(vec![7, 1]), maps: vec![(0, Mask(vec![3, 1])), (1, Mask(vec![8, 0]))] },
                Covered { original: Mask(vec![0, 0]), maps: vec![(1, Mask(vec![1, 1]))] },
            ],
        }
    }

    #[test]
    fn coverage_and_selection_decode_to_what_was_encoded() {
        let coverage = coverage();
        assert_eq!(from_bytes::<Coverage>(Arc::new(to_bytes(&coverage))), Ok(coverage.clone()));
        for choice in [Choice::Best { goal: 0.01, neighbours: 1 }, Choice::Closest(2)] {
            let selection = coverage.select(choice);
            assert_eq!(from_bytes::<Selection>(Arc::new(to_bytes(&selection))), Ok(selection));
        }
    }

    #[test]
    fn numbers_beyond_the_maps_are_refused() {
        let mut wrong = coverage();
        wrong.covered[1].maps[0].0 = 2;
        assert!(from_bytes::<Coverage>(Arc::new(to_bytes(&wrong))).is_err());
        let mut wrong = coverage();
        wrong.covered[0].maps.pop();
        assert!(from_bytes::<Coverage>(Arc::new(to_bytes(&wrong))).is_ok());
        wrong.covered[0].original.0.pop();
        assert!(from_bytes::<Coverage>(Arc::new(to_bytes(&wrong))).is_err());
        let mut wrong = coverage().select(Choice::Closest(2));
        wrong.subsets[0].maps = vec![5];
        assert!(from_bytes::<Selection>(Arc::new(to_bytes(&wrong))).is_err());
    }
}
