//! From a capture to the meshes of its layers, with the pictures that they are drawn with.
//!
//! The paper meshes the nearest surface of each pixel and names layers as future work (section 8). Here every layer of a capture is a
//! depth image of its own: what a layer does not hold is background, at which its triangles are cut.

use super::{DepthMap, DepthMesh, Hierarchy, MapError, Options, OptionsError, resample};
use crate::{
    array::Array,
    capture::{Capture, dilate},
    math::{Stop, Stopped},
    view::View,
};

/// How a capture is meshed.
#[derive(Clone, Debug, PartialEq)]
pub struct Meshing {
    pub options: Options,
    /// Tolerance of the static mesh, metres, ≥ 0.
    pub epsilon: f32,
    /// Captures of sizes other than 2^k+1 are resampled to the next such size; else they are an error.
    pub resample: bool,
}

/// One camera's meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshedView {
    /// Its pixels are the texels of the pictures and the points of the grids.
    pub view: View,
    /// The captured scene's bounding box, metres: diagonal.
    pub diagonal: f64,
    pub double_sided: bool,
    pub options: Options,
    /// Metres.
    pub epsilon: f32,
    /// From near to far; those without a triangle are left out.
    pub layers: Vec<MeshedLayer>,
}

/// One layer's mesh and pictures. The pictures have a texel for each pixel of the view, row by row; beside the surface they hold the
/// nearest texel of it, so that filtering brings in no other colour.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshedLayer {
    /// Which layer of the capture.
    pub layer: u32,
    /// Planar depth, metres; infinite where there is nothing. From it [`Hierarchy`] is made again where views are followed.
    pub depth: Array<f32>,
    /// Unlit, sRGB-encoded.
    pub color: Array<[u8; 4]>,
    /// World space, n·0.5 + 0.5.
    pub normal: Array<[u8; 4]>,
    pub mesh: DepthMesh,
}

/// Why a capture cannot be meshed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LayerError {
    #[error(transparent)]
    Map(#[from] MapError),
    #[error(transparent)]
    Options(#[from] OptionsError),
    #[error("the tolerance is {0} m, expected a length of at least 0")]
    Epsilon(f32),
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Meshes all layers of a capture. A capture that shows nothing gives a view without layers.
pub fn mesh_capture(capture: &Capture, how: &Meshing, stop: &Stop) -> Result<MeshedView, LayerError> {
    if !(how.epsilon >= 0.0 && how.epsilon.is_finite()) {
        return Err(LayerError::Epsilon(how.epsilon));
    }
    let mut view = capture.view;
    let mut layers = Vec::new();
    for (layer, images) in (0..).zip(&capture.layers) {
        stop.check()?;
        let (map, source) = if how.resample {
            let resampled = resample(&capture.view, &images.depth)?;
            (resampled.map, resampled.source)
        } else {
            let map = DepthMap::new(capture.view, images.depth.to_vec())?;
            (map, (0..images.depth.len() as u32).collect())
        };
        view = *map.view();
        if images.is_empty() {
            continue;
        }
        let side = map.side();
        let known: Vec<bool> = map.depth().iter().map(|z| z.is_finite()).collect();
        let depth: Array<f32> = map.depth().to_vec().into();
        let mut color: Vec<[u8; 4]> = source.iter().map(|i| images.color[*i as usize]).collect();
        let mut normal: Vec<[u8; 4]> = source.iter().map(|i| shown(images.normal[*i as usize])).collect();
        dilate(&mut color, &known, side);
        dilate(&mut normal, &known, side);
        stop.check()?;
        let mesh = Hierarchy::new(map, &how.options)?.static_mesh(how.epsilon);
        if !mesh.triangles.is_empty() {
            layers.push(MeshedLayer { layer, depth, color: color.into(), normal: normal.into(), mesh });
        }
    }
    Ok(MeshedView {
        view,
        diagonal: capture.bounds.diagonal(),
        double_sided: capture.double_sided,
        options: how.options.clone(),
        epsilon: how.epsilon,
        layers,
    })
}

/// A captured normal as a texel.
fn shown(n: [i16; 4]) -> [u8; 4] {
    let c = |v: i16| ((f32::from(v) / 32767.0 * 0.5 + 0.5) * 255.0).round() as u8;
    [c(n[0]), c(n[1]), c(n[2]), 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        capture::{Capturing, capture},
        raster::{Cpu, Geometry, Shader},
        scene::{Scene, builtin},
    };
    use glam::DVec3;

    fn taken(scene: &Scene, side: u32, layers: u32, direction: DVec3) -> Capture {
        let geometry = Geometry::new(scene);
        let bounds = scene.bounds();
        let (eye, d) = (bounds.centre() + direction * bounds.diagonal() * 2.0, bounds.diagonal());
        let view = View::look_at(eye, eye - direction, DVec3::Y, 0.6, side, side, 0.5 * d, 3.5 * d);
        let how = Capturing { layers, backs: true };
        capture(&Cpu, &Shader::new(&geometry), bounds, &view, how, &Stop::default()).unwrap()
    }

    fn how(resample: bool) -> Meshing {
        Meshing { options: Options::for_extent(1.0), epsilon: 0.01, resample }
    }

    #[test]
    fn each_layer_gets_a_mesh_of_its_own_surfaces() {
        let capture = taken(&builtin::make("city", 1).unwrap(), 129, 3, DVec3::new(0.5, 0.5, 0.7).normalize());
        let meshed = mesh_capture(&capture, &how(false), &Stop::default()).unwrap();
        assert_eq!(meshed.layers.iter().map(|l| l.layer).collect::<Vec<_>>(), [0, 1, 2]);
        for layer in &meshed.layers {
            assert!(layer.mesh.grid.iter().all(|i| layer.depth[*i as usize].is_finite()));
            assert!(layer.color.iter().all(|c| c[3] == 255), "every texel has a colour");
        }
    }

    #[test]
    fn other_sizes_are_refused_or_resampled() {
        let capture = taken(&builtin::make("car", 1).unwrap(), 100, 1, DVec3::Z);
        let e = mesh_capture(&capture, &how(false), &Stop::default()).unwrap_err().to_string();
        assert!(e.contains("2^k+1") && e.contains("100 × 100"), "{e}");
        let meshed = mesh_capture(&capture, &how(true), &Stop::default()).unwrap();
        assert_eq!((meshed.view.width, meshed.layers[0].color.len()), (129, 129 * 129));
    }

    #[test]
    fn a_view_of_nothing_has_no_layers() {
        let scene = builtin::make("car", 1).unwrap();
        let mut capture = taken(&scene, 33, 2, DVec3::Z);
        let geometry = Geometry::new(&scene);
        let away = View { forward: -capture.view.forward, right: -capture.view.right, ..capture.view };
        let how_deep = Capturing { layers: 2, backs: true };
        let empty =
            crate::capture::capture(&Cpu, &Shader::new(&geometry), scene.bounds(), &away, how_deep, &Stop::default())
                .unwrap();
        assert!(empty.layers.iter().all(crate::capture::Layer::is_empty));
        assert_eq!(mesh_capture(&empty, &how(false), &Stop::default()).unwrap().layers, []);
        capture.layers.truncate(1);
        let e = mesh_capture(&capture, &Meshing { epsilon: f32::NAN, ..how(false) }, &Stop::default());
        assert!(e.unwrap_err().to_string().contains("tolerance"));
    }
}
