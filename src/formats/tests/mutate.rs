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
const TOML: &[u8] =
    b"[[place]]\nfile = 'a.toml'\nname = 'x'\ntranslate = [1.0, 2, 3]\nrotate_deg = [0, 1, 2]\nscale = 2\n";

#[test]
fn the_undamaged_files_load() {
    for (name, bytes) in [("a.ply", PLY), ("a.ply", ASCII), ("a.obj", OBJ)] {
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
    fn scene_toml(d in damage()) {
        try_load("a.toml", &apply(TOML.to_vec(), &d));
    }
}
