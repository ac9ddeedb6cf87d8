//! Faces, sorted by the object and the material that they belong to.

use std::collections::BTreeMap;

/// Numbers of a corner's position, texture coordinate and normal.
pub(super) type Corner = (u32, Option<u32>, Option<u32>);

/// Collects faces under the object and material that are current.
pub(super) struct Shapes {
    name: String,
    material: String,
    /// Numbers of (object, material) in order of first use.
    order: BTreeMap<(String, String), usize>,
    faces: Vec<Vec<[Corner; 3]>>,
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

    /// Adds a polygon as a fan.
    pub fn face(&mut self, corners: &[Corner]) -> Result<(), String> {
        let [first, rest @ ..] = corners else { return Err("a face without corners".into()) };
        if rest.len() < 2 {
            return Err(format!("a face with {} corners", corners.len()));
        }
        let next = self.faces.len();
        let key = || (self.name.clone(), self.material.clone());
        let at = *self.current.get_or_insert_with(|| *self.order.entry(key()).or_insert(next));
        if at == next {
            self.faces.push(Vec::new());
        }
        self.faces[at].extend(rest.windows(2).map(|w| [*first, w[0], w[1]]));
        Ok(())
    }

    /// Object, material and triangles; parts of one object follow each other.
    pub fn finish(mut self) -> Vec<(String, String, Vec<[Corner; 3]>)> {
        let take =
            |((name, material), at): ((String, String), usize)| (name, material, std::mem::take(&mut self.faces[at]));
        self.order.into_iter().map(take).collect()
    }
}
