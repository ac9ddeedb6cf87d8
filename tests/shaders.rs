//! The translations of shaders that ship are those that naga makes of them today. `FARFIELD_TRANSLATE=1` writes them anew.

use farfield::{
    runtime::{dmesh, hybrid_lod, octahedral, ori},
    sprite,
};
use naga::{ShaderStage, back, front::wgsl, valid};
use std::path::Path;

/// A shader and the GLSL files of its entry points; the other languages hold all of them in one file.
struct Source {
    name: &'static str,
    wgsl: String,
    glsl: &'static [(&'static str, ShaderStage, &'static str)],
}

fn sources() -> [Source; 5] {
    use ShaderStage::{Compute, Fragment, Vertex};
    [
        Source {
            name: "sprite",
            wgsl: [sprite::SHADER, sprite::CLASSIFY].concat(),
            glsl: &[("sprite.comp", Compute, "classify")],
        },
        Source {
            name: "dmesh",
            wgsl: dmesh::SHADER.into(),
            glsl: &[
                ("dmesh-depth.vert", Vertex, "depth_vertex"),
                ("dmesh-depth.frag", Fragment, "depth_fragment"),
                ("dmesh-color.vert", Vertex, "color_vertex"),
                ("dmesh-color.frag", Fragment, "color_fragment"),
                ("dmesh-combine.vert", Vertex, "screen_vertex"),
                ("dmesh-combine.frag", Fragment, "combine_fragment"),
            ],
        },
        Source {
            name: "hybrid-lod",
            wgsl: hybrid_lod::SHADER.into(),
            glsl: &[("hybrid-lod.vert", Vertex, "cell_vertex"), ("hybrid-lod.frag", Fragment, "cell_fragment")],
        },
        Source {
            name: "octahedral",
            wgsl: octahedral::SHADER.into(),
            glsl: &[("octahedral.vert", Vertex, "card_vertex"), ("octahedral.frag", Fragment, "card_fragment")],
        },
        Source {
            name: "ori",
            wgsl: ori::SHADER.into(),
            glsl: &[("ori.vert", Vertex, "box_vertex"), ("ori.frag", Fragment, "ori_fragment")],
        },
    ]
}

fn translations(source: &Source) -> Vec<(String, Vec<u8>)> {
    let module = wgsl::parse_str(&source.wgsl).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source.wgsl)));
    let mut validator = valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::default());
    let info = validator.validate(&module).unwrap();
    let bounds = naga::proc::BoundsCheckPolicies::default();
    let mut files = Vec::new();

    // Clip space stays as the caller's matrix makes it.
    let writer_flags = back::glsl::WriterFlags::empty();
    let version = back::glsl::Version::Desktop(450);
    let options = back::glsl::Options { version, writer_flags, ..Default::default() };
    for (file, shader_stage, entry) in source.glsl {
        let mut glsl = String::new();
        let entry =
            back::glsl::PipelineOptions { shader_stage: *shader_stage, entry_point: (*entry).into(), multiview: None };
        let mut writer = back::glsl::Writer::new(&mut glsl, &module, &info, &options, &entry, bounds).unwrap();
        writer.write().unwrap();
        files.push(((*file).to_owned(), glsl.into_bytes()));
    }

    let mut hlsl = String::new();
    let options = back::hlsl::Options { fake_missing_bindings: true, ..Default::default() };
    let pipeline = back::hlsl::PipelineOptions::default();
    back::hlsl::Writer::new(&mut hlsl, &options, &pipeline).write(&module, &info, None).unwrap();
    files.push((format!("{}.hlsl", source.name), hlsl.into_bytes()));

    let options = back::msl::Options { lang_version: (2, 0), fake_missing_bindings: true, ..Default::default() };
    let (metal, _) = back::msl::write_string(&module, &info, &options, &back::msl::PipelineOptions::default()).unwrap();
    files.push((format!("{}.metal", source.name), metal.into_bytes()));

    let options = back::spv::Options { lang_version: (1, 3), ..Default::default() };
    let words = back::spv::write_vec(&module, &info, &options, None).unwrap();
    files.push((format!("{}.spv", source.name), words.iter().flat_map(|w| w.to_le_bytes()).collect()));
    files
}

#[test]
fn translations_are_current() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/translated");
    for (name, bytes) in sources().iter().flat_map(translations) {
        let path = folder.join(name);
        if std::env::var_os("FARFIELD_TRANSLATE").is_some() {
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(&path, &bytes).unwrap();
        }
        let stored = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(stored == bytes, "{} is not current: run this test with FARFIELD_TRANSLATE=1", path.display());
    }
}

#[test]
fn translations_hold_every_function() {
    for text in [sprite::GLSL, sprite::HLSL, sprite::METAL] {
        for name in ["sprite_texture", "sprite_contains", "sprite_zone", "sprite_enter", "classify"] {
            // GLSL's entry point is main.
            assert!(text.contains(name) || (name == "classify" && text.contains("void main()")), "{name}");
        }
    }
    assert_eq!(sprite::SPIRV[..4], 0x0723_0203u32.to_le_bytes());
}
