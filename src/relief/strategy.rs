//! Which of several maps decides a pixel (section 3.3, figure 6).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How fragments of several maps at one pixel are ranked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// 1: the map whose plane is nearest to the eye.
    Plane,
    /// 2: the surface that is nearest to the eye.
    Depth,
    /// 3: the map whose direction is nearest to the direction of view, of those whose surface lies no more than [`Candidate::tolerance`] behind the
    /// nearest one. The paper knows no tolerance and needs none, because its rays end at walls; those that go on may see what others hide.
    #[default]
    Direction,
    /// 4: the map that saw the surface most squarely.
    Normal,
    /// 5: the nearest surface, those seen squarely up to 1/32 of the map's depth range nearer than they are.
    BiasedDepth,
}

/// A fragment that one map offers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Depth of the map's plane along the ray.
    pub plane: f32,
    /// Depth of the surface along the ray.
    pub depth: f32,
    /// Depth range of the map, in the same unit.
    pub range: f32,
    /// Cosine of the angle between map and surface normal.
    pub cos: f32,
    /// How much nearer another surface must be to be another one.
    pub tolerance: f32,
}

/// Strategy 5: 1/32 of a map's range of depths, which is what codes from 0 to 1 span.
const BIAS: f32 = 1.0 / 32.0;

/// The number of the fragment that is shown; candidates are in the order of their maps, the one whose direction is nearest to the
/// direction of view first. Of equals the first.
pub fn resolve(strategy: Strategy, candidates: &[Option<Candidate>]) -> Option<usize> {
    let nearest = candidates.iter().flatten().map(|c| c.depth).fold(f32::INFINITY, f32::min);
    let rank = |c: &Candidate| match strategy {
        Strategy::Plane => c.plane,
        Strategy::Depth => c.depth,
        Strategy::Direction => f32::from(u8::from(c.depth > nearest + c.tolerance)),
        Strategy::Normal => -c.cos,
        Strategy::BiasedDepth => c.depth - BIAS * c.range * c.cos,
    };
    let mut best: Option<(usize, f32)> = None;
    for (i, c) in candidates.iter().enumerate().filter_map(|(i, c)| Some((i, c.as_ref()?))) {
        let rank = rank(c);
        if best.is_none_or(|(_, least)| rank < least) {
            best = Some((i, rank));
        }
    }
    best.map(|b| b.0)
}
