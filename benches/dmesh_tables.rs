//! Tables 1 to 4 of Pajarola, Sainz and Meng (2003) for models of your own, with the same columns:
//! `cargo bench --bench dmesh_tables -- dragon.ply happy-buddha.ply`. Medians of five, milliseconds, pictures of 512² with one sample a pixel.

use farfield::{
    capture::{Capture, Capturing, capture},
    depth_mesh::{DepthMap, Hierarchy, MeshedView, Meshing, Options, mesh_capture},
    formats::{DiskFiles, Limits, load},
    math::{Aabb, Stop},
    raster::{Cpu, Geometry, Rendering, Shader, Shading, render},
    runtime::dmesh::{Blending, Dmesh, Frames, Meshes, Model, Reference, select},
    scene::{Image, Scene},
    view::View,
};
use glam::DVec3;
use rayon::prelude::*;
use std::{path::Path, sync::Arc, time::Instant};

const SIDE: u32 = 513;
const PICTURE: u32 = 512;
const FOV: f64 = std::f64::consts::FRAC_PI_4;

/// The median of five, milliseconds, and the last result.
fn timed<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let result = work();
        times.push(start.elapsed().as_secs_f64() * 1e3);
        if times.len() == 5 {
            times.sort_by(f64::total_cmp);
            return (times[2], result);
        }
    }
}

/// Cameras outside the faces of the box.
fn cameras(bounds: &Aabb) -> Vec<View> {
    let half = (bounds.max - bounds.min) * 0.5;
    let camera = |direction: DVec3| {
        let deep = half.dot(direction.abs());
        let wide = (half * (DVec3::ONE - direction.abs())).max_element();
        let away = wide / (libm::tan(FOV * 0.5) * (f64::from(SIDE) - 2.0) / f64::from(SIDE));
        let eye = bounds.centre() + direction * (deep + away);
        View::look_at(eye, bounds.centre(), DVec3::Y, FOV, SIDE, SIDE, away * 0.99, (away + 2.0 * deep) * 1.01)
    };
    DVec3::AXES.into_iter().flat_map(|a| [camera(a), camera(-a)]).collect()
}

fn dmesh(views: &[MeshedView], bounds: &Aabb) -> (Dmesh, Frames) {
    let image = |v: &MeshedView, texels: &farfield::array::Array<[u8; 4]>| {
        Arc::new(Image { name: String::new(), width: v.view.width, height: v.view.height, texels: texels.clone() })
    };
    let reference = |(i, v): (usize, &MeshedView)| {
        let layer = &v.layers[0];
        Reference {
            name: format!("r{i}"),
            view: v.view,
            mesh: Arc::new(layer.mesh.clone().into()),
            color: image(v, &layer.color),
            normal_map: Some(image(v, &layer.normal)),
        }
    };
    let frames = Frames {
        tau: 1.0,
        options: views[0].options.clone(),
        depths: views.iter().map(|v| v.layers[0].depth.clone()).collect(),
    };
    let references = views.iter().enumerate().map(reference).collect();
    let epsilon = f64::from(views[0].epsilon);
    (Dmesh { references, epsilon, diagonal: bounds.diagonal(), double_sided: true }, frames)
}

fn tables(path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let scene: Scene = load(path, &DiskFiles, &Limits::default())?;
    let (bounds, stop) = (scene.bounds(), Stop::default());
    let diagonal = bounds.diagonal();
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    println!("\n{}: {} triangles", path.display(), scene.triangle_count());

    // Table 1.
    let views = cameras(&bounds);
    let how = Capturing { layers: 1, backs: false };
    let take = |v: &View| capture(&Cpu, &shader, bounds, v, how, &stop).expect("nobody stops it");
    let (captured, captures) = timed(|| views.iter().map(take).collect::<Vec<Capture>>());
    let extent = (bounds.max - bounds.min).max_element() as f32;
    let options = Options { lambda: 0.02 * extent, ..Options::default() };
    let maps: Vec<DepthMap> =
        captures.iter().map(|c| DepthMap::new(c.view, c.layers[0].depth.to_vec())).collect::<Result<_, _>>()?;
    let new = |map: &DepthMap| Hierarchy::new(map.clone(), &options).expect("options of its own");
    let (six, _) = timed(|| maps.par_iter().map(new).collect::<Vec<_>>());
    let (one, _) = timed(|| new(&maps[0]));
    println!("table 1: capture of six {captured:.0} ms; hierarchies of six {six:.1} ms, of one {one:.1} ms");

    let epsilon = (diagonal * 1e-3) as f32;
    let meshing = Meshing { options: options.clone(), epsilon, resample: false };
    let meshed: Vec<MeshedView> =
        captures.iter().map(|c| mesh_capture(c, &meshing, &stop)).collect::<Result<_, _>>()?;
    let strips: usize = meshed.iter().map(|m| m.layers[0].mesh.strips.len()).sum();
    let all: usize = meshed.iter().map(|m| m.layers[0].mesh.triangles.len()).sum();
    let (dmesh, frames) = dmesh(&meshed, &bounds);
    let model = Model::new(dmesh)?;
    let meshes = Meshes::new(model.dmesh(), &frames)?;
    let rendering = Rendering { shading: Shading::Lit(Default::default()), ..Rendering::default() }.with_samples(1);
    let blending = Blending::default();
    let look = |times: f64| {
        let eye = bounds.centre() + DVec3::new(0.45, 0.35, 0.82).normalize() * diagonal * times;
        let (near, far) = ((times - 0.6).max(0.05) * diagonal, (times + 0.6) * diagonal);
        View::look_at(eye, bounds.centre(), DVec3::Y, FOV, PICTURE, PICTURE, near, far)
    };
    let of = |m: &Model, view: &View| -> usize {
        let selected = select(m.dmesh(), view, blending.weights);
        selected.iter().map(|s| m.dmesh().references[s.reference].mesh.triangles.len()).sum()
    };
    for (i, (name, times)) in [("medium", 1.5), ("far", 6.0), ("near", 0.8)].into_iter().enumerate() {
        let view = look(times);
        let (original, _) = timed(|| render(&Cpu, &shader, &view, &rendering, &stop).is_ok());
        let (fixed, _) = timed(|| model.draw(&view, &rendering, &blending, &stop).is_ok());
        let selected = select(model.dmesh(), &view, blending.weights);
        let (selection, own) = timed(|| meshes.for_view(&view, &selected));
        let (dynamic, now) = timed(|| {
            let model = model.with_meshes(&meshes.for_view(&view, &selected)).expect("meshes of these references");
            let drawn = model.draw(&view, &rendering, &blending, &stop).is_ok();
            (model, drawn)
        });
        let triangles = own.iter().map(|m| m.triangles.len()).sum::<usize>();
        if i == 0 {
            println!(
                "table 2: original {original:.0} ms; {} triangles in {} references, {:.1} a strip, drawn in {fixed:.0} ms",
                of(&model, &view),
                selected.len(),
                all as f64 / strips.max(1) as f64
            );
            println!(
                "table 3: {triangles} triangles, selected and triangulated in {selection:.1} ms, with drawing {dynamic:.0} ms"
            );
        }
        println!(
            "table 4, {name} ({times} diagonals): static {} triangles {fixed:.0} ms, dynamic {} triangles {dynamic:.0} ms",
            of(&model, &view),
            of(&now.0, &view)
        );
    }
    Ok(())
}

fn main() {
    let paths: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if paths.is_empty() {
        println!("dmesh_tables: name PLY, OBJ or glTF files after `--`");
    }
    for path in paths {
        if let Err(e) = tables(Path::new(&path)) {
            println!("{path}: {e}");
        }
    }
}
