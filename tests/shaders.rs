//! The translations of the sprite's shader are those that naga makes of it today. `FARFIELD_TRANSLATE=1` writes them anew.

use farfield::sprite;
use naga::{back, front::wgsl, valid};
use std::path::Path;

fn translations() -> Vec<(&'static str, Vec<u8>)> {
    let source = [sprite::SHADER, sprite::CLASSIFY].concat();
    let module = wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    let mut validator = valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::default());
    let info = validator.validate(&module).unwrap();
    let bounds = naga::proc::BoundsCheckPolicies::default();

    let mut glsl = String::new();
    let options = back::glsl::Options { version: back::glsl::Version::Desktop(450), ..Default::default() };
    let entry = back::glsl::PipelineOptions {
        shader_stage: naga::ShaderStage::Compute,
        entry_point: "classify".into(),
        multiview: None,
    };
    let mut writer = back::glsl::Writer::new(&mut glsl, &module, &info, &options, &entry, bounds).unwrap();
    writer.write().unwrap();

    let mut hlsl = String::new();
    let options = back::hlsl::Options { fake_missing_bindings: true, ..Default::default() };
    let pipeline = back::hlsl::PipelineOptions::default();
    back::hlsl::Writer::new(&mut hlsl, &options, &pipeline).write(&module, &info, None).unwrap();

    let options = back::msl::Options { lang_version: (2, 0), fake_missing_bindings: true, ..Default::default() };
    let (metal, _) = back::msl::write_string(&module, &info, &options, &back::msl::PipelineOptions::default()).unwrap();

    let options = back::spv::Options { lang_version: (1, 3), ..Default::default() };
    let words = back::spv::write_vec(&module, &info, &options, None).unwrap();
    let spirv = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    vec![
        ("sprite.comp", glsl.into_bytes()),
        ("sprite.hlsl", hlsl.into_bytes()),
        ("sprite.metal", metal.into_bytes()),
        ("sprite.spv", spirv),
    ]
}

#[test]
fn translations_are_current() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/translated");
    for (name, bytes) in translations() {
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
