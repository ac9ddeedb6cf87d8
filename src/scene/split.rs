//! A scene as a tree of regions, each a part of its parent's box (Andújar et al. 2007, section 5).

use super::{
    Object, Scene,
    clip::{Piece, clip_object},
};
use crate::math::{Aabb, Stop, Stopped};
use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a region's box is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Division {
    /// Into eight, at its centre. Sides without extent are not divided.
    #[default]
    Octree,
    /// Into two, at the middle of its longest side.
    Bintree,
    /// Into two across its longest side, so that half of the triangles' centroids lie in each.
    Kd,
}

/// How a scene is split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splitting {
    pub division: Division,
    /// Times that the box of the scene is divided.
    pub levels: u32,
    /// Regions with fewer triangles are not divided.
    pub min_triangles: usize,
}

/// By how much of its parent's longest side a region's box is inflated before the scene is clipped to it.
const INFLATION: f64 = 0.01;

/// Regions of a tree, at most.
pub const MOST: usize = 4096;

/// A region that is not empty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionNode {
    /// `root`, or the parent's name, a dot and the number of the part: bit 0 is set where it is the upper one in x, bit 1 in y, bit 2 in z; of two parts 0 is the lower
    /// one and 1 the upper one.
    pub name: String,
    /// Metres: least and greatest corner. The boxes of a region's children, empty ones included, are those that its own is divided into.
    pub bounds: [[f64; 3]; 2],
    /// What the region's scene was clipped to. That of the root is its box.
    pub inflated: [[f64; 3]; 2],
    /// Triangles of the region's scene.
    pub triangles: u64,
    /// Names of the children that are not empty.
    pub children: Vec<String>,
}

/// The regions of a scene, sorted by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RegionTree {
    pub regions: Vec<RegionNode>,
}

impl RegionTree {
    /// What is wrong with a tree; `None` where it is as it should be: sorted, one root, every other region a child of the one that its name says.
    pub fn fault(&self) -> Option<String> {
        let find = |name: &str| self.regions.binary_search_by(|r| r.name.as_str().cmp(name)).ok();
        if !self.regions.is_sorted_by(|a, b| a.name < b.name) || find("root") != Some(0) {
            return Some("expected sorted names, the first of them `root`".into());
        }
        for region in &self.regions {
            let RegionNode { name, bounds, inflated, children, .. } = region;
            let proper = |[lo, hi]: &[[f64; 3]; 2]| (0..3).all(|k| lo[k] <= hi[k] && (hi[k] - lo[k]).is_finite());
            if !proper(bounds) || !proper(inflated) {
                return Some(format!("`{name}`: expected boxes that are finite and not empty"));
            }
            let own = |child: &String| child.rsplit_once('.').is_some_and(|(parent, _)| parent == name);
            if !children.iter().all(|c| own(c) && find(c).is_some()) {
                return Some(format!("`{name}`: a child that does not exist or is not its own"));
            }
        }
        let children: usize = self.regions.iter().map(|r| r.children.len()).sum();
        (children + 1 != self.regions.len()).then(|| "a region that is no child of another".into())
    }
}

/// Why a scene was not split.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SplitError {
    #[error("the scene has no triangles: there is nothing to split")]
    Empty,
    #[error("more than {MOST} regions; expected fewer `levels` or a greater `min_triangles`")]
    Many,
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// The tree of a scene's regions, and the scene that belongs to each, in the same order: the whole scene for the root, for the others
/// its part in their inflated box.
pub fn split(scene: &Scene, how: Splitting, stop: &Stop) -> Result<(RegionTree, Vec<Scene>), SplitError> {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return Err(SplitError::Empty);
    }
    let mut splitter = Splitter { scene, how, stop, done: Vec::new() };
    let pieces: Vec<Piece> = scene
        .objects
        .iter()
        .map(|o| Piece { parts: o.parts.iter().map(|p| (0..p.mesh.triangles.len() as u32).collect()).collect() })
        .collect();
    let root = Node { name: "root".into(), bounds, inflated: bounds, pieces, scene: scene.clone() };
    splitter.visit(root, 0)?;
    splitter.done.sort_by(|a, b| a.0.name.cmp(&b.0.name));
    let (regions, scenes) = splitter.done.into_iter().unzip();
    Ok((RegionTree { regions }, scenes))
}

struct Node {
    name: String,
    bounds: Aabb,
    inflated: Aabb,
    /// The triangles that touch the inflated box, object by object.
    pieces: Vec<Piece>,
    scene: Scene,
}

struct Splitter<'a> {
    scene: &'a Scene,
    how: Splitting,
    stop: &'a Stop,
    done: Vec<(RegionNode, Scene)>,
}

impl Splitter<'_> {
    fn visit(&mut self, node: Node, level: u32) -> Result<(), SplitError> {
        self.stop.check()?;
        if self.done.len() == MOST {
            return Err(SplitError::Many);
        }
        let triangles = node.scene.triangle_count();
        let corners = |b: &Aabb| [b.min.to_array(), b.max.to_array()];
        let at = self.done.len();
        let region = RegionNode {
            name: node.name.clone(),
            bounds: corners(&node.bounds),
            inflated: corners(&node.inflated),
            triangles: triangles as u64,
            children: Vec::new(),
        };
        self.done.push((region, node.scene.clone()));
        if level == self.how.levels || triangles < self.how.min_triangles {
            return Ok(());
        }
        for (number, bounds) in self.divide(&node) {
            let margin = INFLATION * node.bounds.size().max_element();
            let inflated = Aabb { min: bounds.min - margin, max: bounds.max + margin };
            let (pieces, scene) = self.inside(&node.pieces, &inflated);
            if scene.objects.is_empty() {
                continue;
            }
            let name = format!("{}.{number}", node.name);
            self.done[at].0.children.push(name.clone());
            self.visit(Node { name, bounds, inflated, pieces, scene }, level + 1)?;
        }
        Ok(())
    }

    /// The boxes that a node's box is divided into, by number; none where it has no extent.
    fn divide(&self, node: &Node) -> Vec<(u32, Aabb)> {
        let (bounds, size) = (node.bounds, node.bounds.size());
        let longest = size.max_element();
        let axis = (0..3).find(|k| size[*k] == longest).unwrap_or(0);
        if !(longest > 0.0) {
            return Vec::new();
        }
        let in_two = |at: f64| {
            let (mut low, mut high) = (bounds, bounds);
            (low.max[axis], high.min[axis]) = (at, at);
            vec![(0, low), (1, high)]
        };
        match self.how.division {
            Division::Octree => {
                let middle = bounds.centre();
                // Sides that are thin beside the longest are not divided: no part has only its lower or upper half.
                let divided: Vec<usize> = (0..3).filter(|k| size[*k] > 1e-6 * longest).collect();
                let whole = |number: u32| (0..3).all(|k| number >> k & 1 == 0 || divided.contains(&k));
                let part = |number: u32| {
                    let mut part = bounds;
                    for k in &divided {
                        let upper = number >> k & 1 == 1;
                        if upper { part.min[*k] = middle[*k] } else { part.max[*k] = middle[*k] }
                    }
                    (number, part)
                };
                (0..8).filter(|n| whole(*n)).map(part).collect()
            }
            Division::Bintree => in_two(bounds.centre()[axis]),
            Division::Kd => in_two(self.median(node, axis)),
        }
    }

    /// The median of the centroids of a node's triangles along an axis; at least 5 % of the box away from its ends.
    fn median(&self, node: &Node, axis: usize) -> f64 {
        let (lo, hi) = (node.bounds.min[axis], node.bounds.max[axis]);
        let mut places = Vec::new();
        for (object, piece) in self.scene.objects.iter().zip(&node.pieces) {
            for_each(object, piece, |_, _, corners| {
                let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
                places.push(centroid[axis].clamp(lo, hi));
            });
        }
        places.sort_by(f64::total_cmp);
        let median = places.get(places.len() / 2).copied().unwrap_or((lo + hi) * 0.5);
        let least = 0.05 * (hi - lo);
        median.clamp(lo + least, hi - least)
    }

    /// What of the pieces touches a box, and the scene clipped to it.
    fn inside(&self, pieces: &[Piece], bounds: &Aabb) -> (Vec<Piece>, Scene) {
        let (mut kept, mut objects) = (Vec::with_capacity(pieces.len()), Vec::new());
        for (object, piece) in self.scene.objects.iter().zip(pieces) {
            let mut own = Piece { parts: vec![Vec::new(); piece.parts.len()] };
            for_each(object, piece, |part, triangle, corners| {
                if bounds.overlaps(&corners.into_iter().collect()) {
                    own.parts[part].push(triangle);
                }
            });
            objects.extend(clip_object(object, &own, bounds));
            kept.push(own);
        }
        (kept, Scene { objects })
    }
}

/// Calls `work` with part, number and corners (world space) of each triangle of a piece.
fn for_each(object: &Object, piece: &Piece, mut work: impl FnMut(usize, u32, [DVec3; 3])) {
    let transform = object.transform.as_dmat4();
    for (k, (part, triangles)) in object.parts.iter().zip(&piece.parts).enumerate() {
        let place = |i: u32| transform.transform_point3(Vec3::from(part.mesh.positions[i as usize]).as_dvec3());
        for t in triangles {
            work(k, *t, part.mesh.triangles[*t as usize].map(place));
        }
    }
}
