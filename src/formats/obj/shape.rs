//! Faces, sorted by the object and the material that they belong to.

use std::collections::BTreeMap;

/// Numbers of a corner's position, texture coordinate and normal, from 0; [`ABSENT`] where it has none. A number may
/// lie beyond what the file holds.
pub(super) type Corner = [u32; 3];

/// No texture coordinate, or no normal.
pub(super) const ABSENT: u32 = u32::MAX;
/// A number that no file reaches.
pub(super) const BEYOND: u32 = u32::MAX - 1;

/// Faces of any number of corners.
#[derive(Default)]
pub(super) struct Faces {
    corners: Vec<Corner>,
    /// Where each face ends in `corners`, and its line.
    ends: Vec<(usize, u32)>,
}

impl Faces {
    /// Every face: its line and its corners.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[Corner])> {
        let starts = std::iter::once(0).chain(self.ends.iter().map(|e| e.0));
        starts.zip(&self.ends).map(|(start, (end, line))| (*line, &self.corners[start..*end]))
    }
}

/// Collects faces under the object and material that are current.
pub(super) struct Shapes {
    name: String,
    material: String,
    /// Numbers of (object, material) in order of first use.
    order: BTreeMap<(String, String), usize>,
    faces: Vec<Faces>,
    current: Option<usize>,
}

impl Shapes {
    /// `name` is what faces before the first `o` or `g` belong to.
    pub fn new(name: String) -> Self {
        Self { name, material: String::new(), order: BTreeMap::new(), faces: Vec::new(), current: None }
    }

    pub fn name(&mut self, name: &str) {
        if !name.is_empty() {
            self.name = name.to_owned();
            self.current = None;
        }
    }

    pub fn material(&mut self, material: &str) {
        self.material = material.to_owned();
        self.current = None;
    }

    /// Adds a face.
    pub fn face(&mut self, line: usize, corners: &[Corner]) {
        let next = self.faces.len();
        let key = || (self.name.clone(), self.material.clone());
        let at = *self.current.get_or_insert_with(|| *self.order.entry(key()).or_insert(next));
        if at == next {
            self.faces.push(Faces::default());
        }
        let faces = &mut self.faces[at];
        faces.corners.extend_from_slice(corners);
        faces.ends.push((faces.corners.len(), u32::try_from(line).unwrap_or(u32::MAX)));
    }

    /// Object, material and faces; parts of one object follow each other.
    pub fn finish(mut self) -> Vec<(String, String, Faces)> {
        let take =
            |((name, material), at): ((String, String), usize)| (name, material, std::mem::take(&mut self.faces[at]));
        self.order.into_iter().map(take).collect()
    }
}
