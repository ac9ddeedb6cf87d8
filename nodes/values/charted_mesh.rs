//! Meshes with their texels in charts: what `resample` makes and `pack-atlas` packs.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    mesh::ChartedMesh,
};

impl Artifact for ChartedMesh {
    const TYPE: &'static str = "ChartedMesh";
    const FORMAT: u32 = 2;

    fn encode(&self, out: &mut Encoder) {
        out.array("origin", &[self.origin]);
        out.array("positions", &self.positions);
        out.array("uv", &self.uv);
        out.array("triangles", &self.triangles);
        out.array("chart_of", &self.chart_of);
        out.array("chart_size", &self.chart_size);
        out.array("color", &self.color);
        out.array("normal", &self.normal);
        out.array("bound_px", &[self.bound_px]);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let bound = data.array::<f64>("bound_px")?;
        let [origin] = data.array::<[f64; 3]>("origin")?[..] else {
            return Err(DecodeError::section("origin", "expected one position"));
        };
        let mesh = Self {
            origin,
            positions: data.array("positions")?,
            uv: data.array("uv")?,
            triangles: data.array("triangles")?,
            chart_of: data.array("chart_of")?,
            chart_size: data.array("chart_size")?,
            color: data.array("color")?,
            normal: data.array("normal")?,
            bound_px: bound.first().copied().unwrap_or(f64::NAN),
        };
        validate(&mesh, bound.len()).map_err(|(section, what)| DecodeError::section(section, what))?;
        Ok(mesh)
    }
}

/// All that the type promises: numbers exist, lengths agree, floats are finite, no chart is empty.
fn validate(m: &ChartedMesh, bounds: usize) -> Result<(), (&'static str, String)> {
    let count = |section, found: usize, expected: usize| {
        if found == expected { Ok(()) } else { Err((section, format!("expected {expected} values, found {found}"))) }
    };
    count("bound_px", bounds, 1)?;
    count("uv", m.uv.len(), m.positions.len())?;
    count("chart_of", m.chart_of.len(), m.triangles.len())?;
    if !m.origin.iter().all(|c| c.is_finite()) {
        return Err(("origin", "not finite".into()));
    }
    if !m.positions.iter().flatten().all(|c| c.is_finite()) {
        return Err(("positions", "not finite".into()));
    }
    if !m.uv.iter().flatten().all(|c| c.is_finite()) {
        return Err(("uv", "not finite".into()));
    }
    if !m.bound_px.is_finite() {
        return Err(("bound_px", "not finite".into()));
    }
    if let Some(v) = m.triangles.iter().flatten().find(|v| **v as usize >= m.positions.len()) {
        return Err(("triangles", format!("vertex {v} of {}", m.positions.len())));
    }
    if let Some(c) = m.chart_of.iter().find(|c| **c as usize >= m.chart_size.len()) {
        return Err(("chart_of", format!("chart {c} of {}", m.chart_size.len())));
    }
    let mut texels = 0usize;
    for [w, h] in m.chart_size.iter() {
        let area = (*w as usize).checked_mul(*h as usize).filter(|a| *a > 0);
        texels =
            area.and_then(|a| texels.checked_add(a)).ok_or(("chart_size", format!("a chart of {w} × {h} texels")))?;
    }
    count("color", m.color.len(), texels)?;
    if m.normal.is_empty() { Ok(()) } else { count("normal", m.normal.len(), texels) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::artifact::{from_bytes, to_bytes};
    use std::sync::Arc;

    fn sample() -> ChartedMesh {
        ChartedMesh {
            origin: [0.0, 8.0, 0.0],
            positions: vec![[0.0, 1.0, 2.0]; 3].into(),
            uv: vec![[2.0, 2.5]; 3].into(),
            triangles: vec![[0, 1, 2]].into(),
            chart_of: vec![0].into(),
            chart_size: vec![[5, 4]].into(),
            color: vec![[1, 2, 3, 255]; 20].into(),
            normal: Vec::new().into(),
            bound_px: 3.1,
        }
    }

    fn round_trip(mesh: &ChartedMesh) -> Result<ChartedMesh, DecodeError> {
        from_bytes(Arc::new(to_bytes(mesh)))
    }

    #[test]
    fn decodes_what_was_encoded() {
        assert_eq!(round_trip(&sample()), Ok(sample()));
        let mapped = ChartedMesh { normal: sample().color, ..sample() };
        assert_eq!(round_trip(&mapped), Ok(mapped));
    }

    #[test]
    fn refuses_what_does_not_fit() {
        let breaks: [fn(&mut ChartedMesh); 9] = [
            |m| m.triangles = vec![[0, 1, 3]].into(),
            |m| m.chart_of = vec![1].into(),
            |m| m.chart_of = vec![].into(),
            |m| m.chart_size = vec![[u32::MAX; 2]].into(),
            |m| m.chart_size = vec![[20, 0]].into(),
            |m| m.color = vec![[0; 4]; 19].into(),
            |m| m.normal = vec![[0; 4]; 19].into(),
            |m| m.uv = vec![[f32::NAN; 2]; 3].into(),
            |m| m.bound_px = f64::INFINITY,
        ];
        for (i, damage) in breaks.iter().enumerate() {
            let mut mesh = sample();
            damage(&mut mesh);
            assert!(round_trip(&mesh).is_err(), "damage {i}");
        }
    }
}
