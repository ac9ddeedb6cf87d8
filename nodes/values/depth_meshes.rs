//! Depth-meshes of one camera.

use super::camera::{get_view, put_view};
use crate::{
    depth_mesh::{DepthMesh, MeshedLayer, MeshedView, Options, Strips},
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
struct Head {
    diagonal: f64,
    double_sided: bool,
    options: Options,
    epsilon: f32,
    /// Number and cut triangles of each layer.
    layers: Vec<(u32, usize)>,
}

impl Artifact for MeshedView {
    const TYPE: &'static str = "DepthMeshes";
    const FORMAT: u32 = 2;

    fn encode(&self, out: &mut Encoder) {
        put_view(out, &self.view);
        out.json(
            "head",
            &Head {
                diagonal: self.diagonal,
                double_sided: self.double_sided,
                options: self.options.clone(),
                epsilon: self.epsilon,
                layers: self.layers.iter().map(|l| (l.layer, l.mesh.cut)).collect(),
            },
        );
        for (i, layer) in self.layers.iter().enumerate() {
            let mesh = &layer.mesh;
            out.array(format!("depth {i}"), &layer.depth);
            out.array(format!("color {i}"), &layer.color);
            out.array(format!("normal {i}"), &layer.normal);
            out.array(format!("grid {i}"), &mesh.grid);
            out.array(format!("positions {i}"), &mesh.positions);
            out.array(format!("normals {i}"), &mesh.normals);
            out.array(format!("quality {i}"), &mesh.quality);
            out.array(format!("uv {i}"), &mesh.uv);
            out.array(format!("triangles {i}"), &mesh.triangles);
            out.array(format!("strips {i}"), &mesh.strips.indices);
            out.array(format!("starts {i}"), &mesh.strips.starts);
        }
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let head: Head = data.json("head")?;
        let view = get_view(data)?;
        let pixels = view.width as usize * view.height as usize;
        let layer = |(i, (layer, cut)): (usize, &(u32, usize))| {
            let mesh = DepthMesh {
                grid: data.array(&format!("grid {i}"))?.into_vec(),
                positions: data.array(&format!("positions {i}"))?.into_vec(),
                normals: data.array(&format!("normals {i}"))?.into_vec(),
                quality: data.array(&format!("quality {i}"))?.into_vec(),
                uv: data.array(&format!("uv {i}"))?.into_vec(),
                triangles: data.array(&format!("triangles {i}"))?.into_vec(),
                strips: Strips {
                    indices: data.array(&format!("strips {i}"))?.into_vec(),
                    starts: data.array(&format!("starts {i}"))?.into_vec(),
                },
                cut: *cut,
            };
            let out = MeshedLayer {
                layer: *layer,
                depth: data.array(&format!("depth {i}"))?,
                color: data.array(&format!("color {i}"))?,
                normal: data.array(&format!("normal {i}"))?,
                mesh,
            };
            match fault(&out, pixels) {
                Some(what) => Err(DecodeError::section("layers", format!("layer {layer}: {what}"))),
                None => Ok(out),
            }
        };
        let layers = head.layers.iter().enumerate().map(layer).collect::<Result<_, DecodeError>>()?;
        let Head { diagonal, double_sided, options, epsilon, .. } = head;
        Ok(Self { view, diagonal, double_sided, options, epsilon, layers })
    }
}

/// What a reader of the layer would stumble over.
fn fault(layer: &MeshedLayer, pixels: usize) -> Option<&'static str> {
    let DepthMesh { grid, positions, normals, quality, uv, triangles, strips, .. } = &layer.mesh;
    let n = positions.len();
    let starts = &strips.starts;
    if layer.depth.len() != pixels || layer.color.len() != pixels || layer.normal.len() != pixels {
        Some("images of another size than the view")
    } else if [grid.len(), normals.len(), quality.len(), uv.len()] != [n; 4] {
        Some("vertices whose attributes have other lengths")
    } else if triangles.iter().flatten().chain(&strips.indices).any(|v| *v as usize >= n) {
        Some("a vertex number beyond the vertices")
    } else if starts.first().is_some_and(|s| *s != 0)
        || !starts.is_sorted()
        || starts.last().is_some_and(|s| *s as usize > strips.indices.len())
    {
        Some("strips that begin in disorder")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::artifact::{from_bytes, to_bytes},
        view::View,
    };
    use glam::DVec3;
    use std::sync::Arc;

    fn meshed() -> MeshedView {
        let mesh = DepthMesh {
            grid: vec![0, 1, 3],
            positions: vec![[0.0; 3]; 3],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            quality: vec![0.5; 3],
            uv: vec![[0.5; 2]; 3],
            triangles: vec![[0, 2, 1]],
            strips: Strips { indices: vec![0, 2, 1], starts: vec![0] },
            cut: 4,
        };
        let layer = MeshedLayer {
            layer: 0,
            depth: vec![1.0; 9].into(),
            color: vec![[1; 4]; 9].into(),
            normal: vec![[2; 4]; 9].into(),
            mesh,
        };
        MeshedView {
            view: View::look_at(DVec3::ONE, DVec3::ZERO, DVec3::Y, 0.7, 3, 3, 0.1, 9.0),
            diagonal: 2.0,
            double_sided: false,
            options: Options::for_extent(1.0),
            epsilon: 0.01,
            layers: vec![layer],
        }
    }

    #[test]
    fn decodes_what_was_encoded() {
        assert_eq!(from_bytes::<MeshedView>(Arc::new(to_bytes(&meshed()))), Ok(meshed()));
    }

    #[test]
    fn refuses_numbers_that_lead_outside() {
        let breaks: [fn(&mut MeshedLayer); 5] = [
            |l| l.mesh.triangles[0][0] = 3,
            |l| l.mesh.strips.indices[0] = 3,
            |l| l.mesh.strips.starts[0] = 1,
            |l| l.mesh.quality = vec![],
            |l| l.color = vec![].into(),
        ];
        for change in breaks {
            let mut wrong = meshed();
            change(&mut wrong.layers[0]);
            assert!(from_bytes::<MeshedView>(Arc::new(to_bytes(&wrong))).is_err());
        }
    }
}
