//! Damaged files: never a panic, and a scene that comes out keeps its promises.

use super::*;
use crate::formats::{GlbOptions, write_glb};
use proptest::prelude::*;

/// Changes to a file: where, and the new byte; or a cut.
fn damage() -> impl Strategy<Value = (Vec<(prop::sample::Index, u8)>, Option<prop::sample::Index>)> {
    (
        prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        prop::option::weighted(0.2, any::<prop::sample::Index>()),
    )
}

fn apply(
    mut bytes: Vec<u8>,
    (changes, cut): &(Vec<(prop::sample::Index, u8)>, Option<prop::sample::Index>),
) -> Vec<u8> {
    for (at, byte) in changes {
        let at = at.index(bytes.len());
        bytes[at] = *byte;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut.index(bytes.len()));
    }
    bytes
}

fn try_load(name: &str, bytes: &[u8]) {
    // `load` checks the promises of what comes out.
    let _ = Memory::of([(name, bytes)]).load(name);
}

const PLY: &[u8] = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z
element face 1\nproperty list uchar int vertex_index\nend_header\n\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\
\x03\0\0\0\0\x01\0\0\0\x02\0\0\0";
const ASCII: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z
element face 1\nproperty list int int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0 1 1 1\nvt 0 0\nvn 0 0 1\no a\nusemtl b\nf 1/1/1 2/1/1 -1/1/1\nf 1 2 3\n";
/// A concave face, continued lines, several libraries, colours up to 255, coordinates far away.
const RICH: &[u8] =
    b"mtllib none.mtl m.mtl\nv 5e5 0 0 255 0 0\nv 500004 0 0 0 0 9\nv 500001 1 0\nv 5e5 4 0\nv nan 0 0\nvt 0 0\n\
usemtl \"a #1\"\nf 1/1 2/1 \\ \n3/1 4/1 \\\n\\\n\nf -1 1 2 3 4 # c\\\nf 4 4 4\nf 1/1 2/1 3/1\n";
const MTL: &[u8] = b"newmtl a #1 # c\nKd 0 0 0\nmap_Kd -s 1 1 1 -o 0 0 \"C:\\x\\t.png\"\nd 0\nTr 1\nmap_Ke t.png\nmap_d -mm 0 1 t.png # x\n";
/// Colours of faces, a concave face, doubles.
const COLORED: &[u8] = b"ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_index\nproperty float red\nproperty char green\n\
property ushort blue\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\nend_header\n5 0 1 2 3 4 255 -1 9\n3 0 1 2 1 0 0\n\
5e5 0 0\n500004 0 0\n500004 4 0\n500002 1 0\n5e5 4 0\n";
const TOML: &[u8] =
    b"[[place]]\nfile = 'a.toml'\nname = 'x'\ntranslate = [1.0, 2, 3]\nrotate_deg = [0, 1, 2]\nscale = 2\n";

fn utf16(text: &[u8]) -> Vec<u8> {
    std::iter::once(0xfeff).chain(text.iter().map(|b| u16::from(*b))).flat_map(u16::to_le_bytes).collect()
}

#[test]
fn the_undamaged_files_load() {
    for (name, bytes) in [("a.ply", PLY), ("a.ply", ASCII), ("a.obj", OBJ), ("a.obj", RICH), ("a.ply", COLORED)] {
        assert!(Memory::of([(name, bytes)]).load(name).0.unwrap().triangle_count() > 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn glb(d in damage()) {
        let good = write_glb(&everything(), &GlbOptions { unlit: false, normal_maps: true }).unwrap();
        try_load("a.glb", &apply(good, &d));
    }

    #[test]
    fn json_of_a_glb(at in any::<prop::sample::Index>(), digit in 0u8..10, more in any::<bool>()) {
        // Numbers are where a GLB's JSON hurts: change one digit, or put one more before it.
        let mut bytes = write_glb(&everything(), &GlbOptions { unlit: false, normal_maps: true }).unwrap();
        let json = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let digits: Vec<usize> = (20..20 + json).filter(|i| bytes[*i].is_ascii_digit()).collect();
        let at = digits[at.index(digits.len())];
        if more {
            // One of the trailing blanks, if there is one, makes room; else the chunk is one byte short.
            bytes.insert(at, b'0' + digit);
            bytes.remove(20 + json);
        } else {
            bytes[at] = b'0' + digit;
        }
        try_load("a.glb", &bytes);
    }

    #[test]
    fn compressed_skinned_and_morphing_glbs(d in damage(), which in 0..3) {
        let mut document = match which {
            0 => packed::compressed(),
            1 => pose::skinned(5123),
            _ => pose::morphing(),
        };
        if which == 2 {
            document.json["meshes"][0]["weights"] = serde_json::json!([1.0, 0.5]);
        }
        try_load("a.glb", &apply(document.glb(), &d));
    }

    #[test]
    fn compressed_bytes(d in damage()) {
        let mut document = packed::compressed();
        document.binary = apply(document.binary, &(d.0, None));
        try_load("a.glb", &document.glb());
    }

    #[test]
    fn numbers_of_a_compressed_glb(at in any::<prop::sample::Index>(), digit in 0u8..10) {
        let mut document = packed::compressed();
        let mut text = document.json.to_string().into_bytes();
        let digits: Vec<usize> = (0..text.len()).filter(|i| text[*i].is_ascii_digit()).collect();
        text[digits[at.index(digits.len())]] = b'0' + digit;
        if let Ok(json) = serde_json::from_slice(&text) {
            document.json = json;
            if document.json["buffers"][0].is_object() {
                try_load("a.glb", &document.glb());
            }
        }
    }

    #[test]
    fn pictures(d in damage(), format in prop::sample::select(vec![
        image::ImageFormat::Png, image::ImageFormat::Jpeg, image::ImageFormat::WebP,
    ])) {
        let mut file = std::io::Cursor::new(Vec::new());
        let picture = image::RgbImage::from_fn(9, 7, |x, y| image::Rgb([x as u8 * 20, y as u8 * 30, 128]));
        image::DynamicImage::from(picture).write_to(&mut file, format).unwrap();
        let bytes = apply(file.into_inner(), &d);
        if let Ok(image) = crate::formats::picture::decode(&bytes, "x", 1 << 20) {
            prop_assert_eq!(image.texels.len() as u64, u64::from(image.width) * u64::from(image.height));
        }
    }

    #[test]
    fn ply_binary(d in damage()) {
        try_load("a.ply", &apply(PLY.to_vec(), &d));
    }

    #[test]
    fn ply_ascii(d in damage()) {
        try_load("a.ply", &apply(ASCII.to_vec(), &d));
    }

    #[test]
    fn obj(d in damage()) {
        try_load("a.obj", &apply(OBJ.to_vec(), &d));
    }

    #[test]
    fn rich_obj(d in damage(), library in damage(), wide in any::<bool>()) {
        let text = if wide { utf16(RICH) } else { RICH.to_vec() };
        let (obj, mtl) = (apply(text, &d), apply(MTL.to_vec(), &library));
        let _ = Memory::of([("a.obj", &obj), ("m.mtl", &mtl), ("t.png", &super::obj::png())]).load("a.obj");
    }

    #[test]
    fn ply_with_colors(d in damage(), wide in any::<bool>()) {
        try_load("a.ply", &apply(if wide { utf16(COLORED) } else { COLORED.to_vec() }, &d));
    }

    #[test]
    fn scene_toml(d in damage()) {
        try_load("a.toml", &apply(TOML.to_vec(), &d));
    }
}
