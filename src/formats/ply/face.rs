//! Faces: polygons with their colours, and strips of triangles.

use super::{Body, ColorColumns, Colors, Element, Fault};
use crate::formats::polygon::MOST_CORNERS;

#[derive(Default)]
pub(super) struct Faces {
    corners: Vec<u32>,
    /// Where each face ends in `corners`.
    ends: Vec<usize>,
    /// A colour for every face, or none.
    pub colors: Option<Colors>,
    /// Triangles of strips, after the faces.
    pub strips: Vec<[u32; 3]>,
}

impl Faces {
    /// The corners of every face. A corner may lie beyond the vertices.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(start, end)| &self.corners[*start..*end])
    }

    pub fn read(&mut self, body: &mut Body, element: &Element) -> Result<(), Fault> {
        let list = element.properties.iter().position(|p| p.list.is_some() && p.name.starts_with("vertex_ind"));
        if list.is_none() {
            return Err(Fault::At("header".into(), "faces without the list vertex_indices".into()));
        }
        let color = ColorColumns::of(element);
        let mut colors = Vec::new();
        let mut row = vec![0.0f64; element.properties.len()];
        let mut polygon = Vec::new();
        self.ends.reserve(element.count as usize);
        for i in 0..element.count {
            body.read(element, i, &mut row, list, &mut polygon)?;
            if polygon.len() > MOST_CORNERS {
                let what = format!("{} corners; at most {MOST_CORNERS} are read", polygon.len());
                return Err(Fault::At(format!("face {i}"), what));
            }
            self.corners.extend_from_slice(&polygon);
            self.ends.push(self.corners.len());
            if let Some(at) = &color {
                colors.push(at.pick(element, &row));
            }
        }
        self.colors = color.map(|at| Colors { rows: colors, kinds: at.kinds(element) });
        Ok(())
    }

    /// Strips of triangles in one list, -1 between them.
    pub fn read_strips(&mut self, body: &mut Body, element: &Element) -> Result<(), Fault> {
        let list = element.properties.iter().position(|p| p.list.is_some());
        if list.is_none() {
            return Err(Fault::At("header".into(), "tristrips without a list".into()));
        }
        let mut row = vec![0.0f64; element.properties.len()];
        let mut order = Vec::new();
        for i in 0..element.count {
            body.read(element, i, &mut row, list, &mut order)?;
            for strip in order.split(|v| *v == u32::MAX) {
                for (k, w) in strip.windows(3).enumerate() {
                    let [a, b, c] = [w[0], w[1], w[2]];
                    // Strips turn corners by repeating vertices.
                    if a != b && b != c && a != c {
                        self.strips.push(if k % 2 == 0 { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        Ok(())
    }
}
