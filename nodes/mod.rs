//! The node kinds: thin adapters between the engine and the algorithms, one file or folder each. A kind with several methods is a folder
//! with a file per method.

mod cameras;
mod contents;
#[cfg(test)]
mod testing;
pub mod values;
mod volumes;

/// Declares the modules of all kinds and the function that registers them. A new kind is its file and one line here; a new method of a kind its file
/// in the kind's folder and its name in the kind's line.
macro_rules! kinds {
    (
        one method { $($file:ident :: $ty:ident,)* }
        methods { $($(#[$doc:meta])* $kind:ident { $($method:ident :: $method_ty:ident),* $(,)? })* }
    ) => {
        $(pub mod $file;)*
        $($(#[$doc])* pub mod $kind { $(pub mod $method;)* })*

        fn add_all(registry: &mut Registry) {
            $(registry.add::<$file::$ty>();)*
            $($(registry.add::<$kind::$method::$method_ty>();)*)*
        }
    };
}

kinds! {
    one method {
        choose::Choose,
        classify_occlusion::ClassifyOcclusion,
        classify_points::ClassifyPoints,
        clip_scene::ClipScene,
        collide_sprites::CollideSprites,
        cull_occluded::CullOccluded,
        depth_mesh::DepthMesh,
        draw_sprites::DrawSprites,
        field_scene::FieldScene,
        fit_factor::FitFactor,
        hex_cells::HexCells,
        load_scene::LoadScene,
        lod_levels::LodLevels,
        make_scene::MakeScene,
        measure_ceiling::MeasureCeiling,
        measure_coverage::MeasureCoverage,
        pack_atlas::PackAtlas,
        render_slices::RenderSlices,
        select_objects::SelectObjects,
        separate_placement::SeparatePlacement,
        split_objects::SplitObjects,
        split_region::SplitRegion,
        take_chosen::TakeChosen,
        view_cell::ViewCell,
        voxel_mesh::VoxelMeshNode,
    }
    methods {
        /// `collapse`: fewer triangles.
        collapse { quadric::Quadric, silhouette_weight::SilhouetteWeight, voxel_cover::VoxelCover, voxel_quadric::VoxelQuadric }
        /// `compress`: the same in fewer bytes.
        compress { ranges::Ranges, textures::Textures }
        /// `evaluate`: certificates.
        evaluate { coverage::Coverage, directions::Directions, points::Points, views::Views, walk::Walk }
        /// `peel`: more than the nearest surface.
        peel { layers::Layers, solid::Solid, windows::Windows }
        /// `resample`: textures for simplified meshes.
        resample { octahedral::Octahedral, relief::Relief, views::Views, voxels::Voxels }
        /// `select-impostors`: which relief maps a direction of view needs.
        select_impostors { best::Best, closest::Closest }
        /// `select-views`: from where something is looked at.
        select_views {
            box_faces::BoxFaces,
            cell_windows::CellWindows,
            entropy::Entropy,
            entropy_perturbed::EntropyPerturbed,
            icosahedron::Icosahedron,
            min_depth_complexity::MinDepthComplexity,
            octahedral::Octahedral,
        }
        /// `view-region`: the places from which a stand-in is looked at, where they are no view cell.
        view_region { path::Path, sphere::Sphere }
        /// `write`: stand-ins as bundles of files that other programs open.
        write { dmesh::Dmesh, glb::Glb, hybrid_lod::HybridLod, hybrid_lod_cell::HybridLodCell, mix::Mix, mix_objects::MixObjects, octahedral::Octahedral, ori::OriNode, ori_tree::OriTree, sprite::Sprite }
    }
}

use crate::{
    engine::{
        node::{Ctx, NodeError},
        plan::{Bundle, File},
        registry::{Registry, Renamed},
    },
    raster::{Backend, Cpu},
    runtime::BundleFile,
    sprite::PeelError,
};
use std::sync::Arc;

/// Who renders: the device that the program was given, or the CPU.
fn backend<'a>(ctx: &Ctx<'a>) -> &'a dyn Backend {
    ctx.device.and_then(|d| d.downcast_ref::<Arc<dyn Backend>>()).map_or(&Cpu, |b| &**b)
}

/// Along a pixel's or a texel's side, of the numbers of samples that parameters allow.
fn samples_per_side(samples: u32) -> Option<u32> {
    match samples {
        1 => Some(1),
        4 => Some(2),
        16 => Some(4),
        _ => None,
    }
}

/// What to say of a field of view, in degrees, that can hardly be meant.
fn doubt_fov(fov: f64) -> Vec<(&'static str, String)> {
    if !(fov > 0.0 && fov < 5.0) {
        return Vec::new();
    }
    let degrees = fov.to_degrees();
    // A turn and more is no angle of view in radians either.
    let radians = if fov < std::f64::consts::PI { format!("; {fov} radians are {degrees:.1}") } else { String::new() };
    vec![("fov", format!("{fov}: degrees are meant{radians}"))]
}

/// Why a solid was not peeled, as a node's error.
fn peel_error(error: PeelError) -> NodeError {
    match error {
        PeelError::Stopped(stopped) => NodeError::Stopped(stopped),
        other => NodeError::Failed(other.to_string()),
    }
}

/// Whether `name` can be the stem of a file's name in a bundle.
fn check_name(name: &str) -> Result<(), (&'static str, String)> {
    match crate::engine::publish::names::bad_component(name) {
        None if !name.contains('.') => Ok(()),
        None => Err(("name", format!("`{name}`: expected a name without dots; endings are added"))),
        Some(what) => Err(("name", format!("`{name}` {what}"))),
    }
}

/// The files that a writer gave, the first of which is the one to open.
fn bundle(files: Vec<BundleFile>) -> Result<Arc<Bundle>, NodeError> {
    let main = files.first().map(|f| f.path.clone()).unwrap_or_default();
    let file = |f: BundleFile| (f.path, File { media_type: f.media.into(), bytes: f.bytes });
    Ok(Arc::new(Bundle::new(main, files.into_iter().map(file).collect()).map_err(NodeError::Failed)?))
}

/// The text of a JSON file, which ends with a line break.
fn json_bytes(value: &serde_json::Value) -> Result<Vec<u8>, NodeError> {
    let mut bytes = serde_json::to_vec_pretty(value).map_err(|e| NodeError::from_error(&e))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// A JSON file.
fn json_file(value: &serde_json::Value) -> Result<Arc<File>, NodeError> {
    Ok(Arc::new(File { media_type: "application/json".into(), bytes: json_bytes(value)? }))
}

/// Names that pipelines used before kinds had methods.
const RENAMED: [Renamed; 5] = [
    Renamed { kind: "write-glb", param: "", now: "kind = \"write\" and method = \"glb\"; its output is `bundle`" },
    Renamed {
        kind: "write-sprite",
        param: "",
        now: "kind = \"write\" and method = \"sprite\"; its output is `bundle`",
    },
    Renamed { kind: "evaluate-sprite", param: "", now: "kind = \"evaluate\" and method = \"points\"" },
    Renamed {
        kind: "select-direction",
        param: "",
        now: "kind = \"select-views\" and method = \"min-depth-complexity\"",
    },
    Renamed {
        kind: "collapse",
        param: "policy",
        now: "method = \"voxel-cover\", or method = \"voxel-quadric\" for the policy `quadric`",
    },
];

/// Every kind that the program knows.
pub fn registry() -> Registry {
    let mut r = Registry::new(&[], &RENAMED);
    add_all(&mut r);
    r
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::node::Device,
        math::{Stop, Stopped},
        raster::{OnFragments, OnNearest, Prepared},
    };

    /// Renders nothing.
    struct Blind;

    impl Backend for Blind {
        fn nearest(&self, _: &Prepared, _: &Stop, _: &OnNearest) -> Result<(), Stopped> {
            Err(Stopped)
        }
        fn fragments(&self, _: &Prepared, _: &Stop, _: &OnFragments) -> Result<(), Stopped> {
            Err(Stopped)
        }
    }

    #[test]
    fn angles_in_radians_are_doubted() {
        for (fov, expect) in [
            (0.785, Some("0.785: degrees are meant; 0.785 radians are 45.0")),
            (4.0, Some("4: degrees are meant")),
            (5.0, None),
            (45.0, None),
        ] {
            assert_eq!(doubt_fov(fov).first().map(|(_, text)| text.as_str()), expect);
        }
    }

    #[test]
    fn the_device_that_the_program_was_given_renders() {
        let scene = crate::scene::builtin::make("solids", 1).unwrap();
        let direction = crate::sprite::Direction::new(glam::DVec3::NEG_Z).unwrap();
        let geometry = crate::raster::Geometry::new(&scene);
        let run = |device: Option<&Device>| {
            let world = testing::World { device, ..testing::World::default() };
            world.visit(|ctx| crate::sprite::judge(backend(ctx), &geometry, &[direction], 16, ctx.stop).is_ok()).0
        };
        let blind: Arc<dyn Backend> = Arc::new(Blind);
        assert!(run(None) && !run(Some(&blind)) && run(Some(&"another program's device")));
    }
}
