//! Connected meshes over voxels: what `voxel-mesh` makes and `collapse` simplifies.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    voxel::VoxelMesh,
};

impl Artifact for VoxelMesh {
    const TYPE: &'static str = "VoxelMesh";
    const FORMAT: u32 = 3;

    fn encode(&self, out: &mut Encoder) {
        out.array("frustum", &[self.frustum]);
        out.array("factor", &[self.factor]);
        out.array("alpha", &[u32::from(self.alpha)]);
        out.array("vertices", &self.vertices);
        out.array("flags", &self.flags);
        out.array("faces", &self.faces);
        out.array("cover_start", &self.cover_start);
        out.array("cover", &self.cover);
        out.array("voxels", &self.voxels);
        out.array("quarters", &self.quarters);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let single = |name: &str, len: usize| {
            if len == 1 { Ok(()) } else { Err(DecodeError::section(name, format!("expected one value, found {len}"))) }
        };
        let frustum = data.array::<u32>("frustum")?;
        single("frustum", frustum.len())?;
        let factor = data.array::<f64>("factor")?;
        single("factor", factor.len())?;
        let alpha = data.array::<u32>("alpha")?;
        single("alpha", alpha.len())?;
        if alpha[0] > 1 {
            return Err(DecodeError::section("alpha", format!("expected 0 or 1, found {}", alpha[0])));
        }
        let mesh = Self {
            frustum: frustum[0],
            vertices: data.array("vertices")?,
            flags: data.array("flags")?,
            faces: data.array("faces")?,
            cover_start: data.array("cover_start")?,
            cover: data.array("cover")?,
            voxels: data.array("voxels")?,
            quarters: data.array("quarters")?,
            factor: factor[0],
            alpha: alpha[0] == 1,
        };
        mesh.validate().map_err(|(section, what)| DecodeError::section(section, what))?;
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::artifact::{from_bytes, to_bytes},
        voxel::Voxel,
    };
    use bytemuck::Zeroable;
    use std::sync::Arc;

    fn sample() -> VoxelMesh {
        VoxelMesh {
            frustum: 2,
            vertices: vec![[1, 1, 0], [1, 3, 0], [3, 3, 0]].into(),
            flags: vec![0, 1, 0].into(),
            faces: vec![[0, 1, 2]].into(),
            cover_start: vec![0, 1].into(),
            cover: vec![0].into(),
            voxels: vec![Voxel::zeroed()].into(),
            quarters: vec![[[1, 2, 3, 255]; 4]].into(),
            factor: 2.0,
            alpha: false,
        }
    }

    fn round_trip(mesh: &VoxelMesh) -> Result<VoxelMesh, DecodeError> {
        from_bytes(Arc::new(to_bytes(mesh)))
    }

    #[test]
    fn decodes_what_was_encoded() {
        assert_eq!(round_trip(&sample()), Ok(sample()));
    }

    #[test]
    fn refuses_numbers_that_lead_outside() {
        let breaks: [fn(&mut VoxelMesh); 7] = [
            |m| m.faces = vec![[0, 1, 3]].into(),
            |m| m.flags = vec![0].into(),
            |m| m.cover = vec![1].into(),
            |m| m.cover_start = vec![0, 2].into(),
            |m| m.cover_start = vec![].into(),
            |m| m.cover_start = vec![1, 0].into(),
            |m| m.factor = f64::NAN,
        ];
        for (i, damage) in breaks.iter().enumerate() {
            let mut mesh = sample();
            damage(&mut mesh);
            assert!(round_trip(&mesh).is_err(), "damage {i}");
        }
    }
}
