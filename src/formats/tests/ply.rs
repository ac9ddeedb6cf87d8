//! PLY in its three encodings.

use super::*;

/// A tetrahedron's base as a quad, with everything a vertex can have.
const HEADER: &str = "comment made by hand
element vertex 4
property float x
property double y
property short z
property list uchar int ignored
property uchar red
property uchar green
property uchar blue
property float s
property float t
element edge 1
property int a
element face 2
property uchar flags
property list uchar uint vertex_indices
end_header
";

/// The same content in ASCII, little-endian and big-endian.
fn file(encoding: &str) -> Vec<u8> {
    let mut out = format!("ply\nformat {encoding} 1.0\n{HEADER}").into_bytes();
    let corners = [[0i16, 0], [1, 0], [1, 1], [0, 1]];
    if encoding == "ascii" {
        for [x, y] in corners {
            out.extend(format!("{x} {y}e0 7  2 5 6 255 0 128 {x}.0 {y}\n").bytes());
        }
        out.extend(b"9\n0 4 0 1 2 3\n1\t3 0 2 3");
        return out;
    }
    let big = encoding == "binary_big_endian";
    let mut put = |bytes: &[u8]| if big { out.extend(bytes.iter().rev()) } else { out.extend(bytes) };
    for [x, y] in corners {
        put(&(x as f32).to_le_bytes());
        put(&(y as f64).to_le_bytes());
        put(&7i16.to_le_bytes());
        put(&[2]);
        put(&5i32.to_le_bytes());
        put(&6i32.to_le_bytes());
        [255, 0, 128].iter().for_each(|c| put(&[*c]));
        put(&(x as f32).to_le_bytes());
        put(&(y as f32).to_le_bytes());
    }
    put(&9i32.to_le_bytes());
    for face in [&[0u32, 1, 2, 3][..], &[0, 2, 3]] {
        put(&[0]);
        put(&[face.len() as u8]);
        face.iter().for_each(|v| put(&v.to_le_bytes()));
    }
    out
}

#[test]
fn the_three_encodings_hold_the_same_scene() {
    let read = |encoding| Memory::of([("dir/quad.ply", &file(encoding))]).scene("dir/quad.ply");
    let scene = read("ascii");
    assert_eq!(scene, read("binary_little_endian"));
    assert_eq!(scene, read("binary_big_endian"));
    assert_eq!(scene.objects[0].name, "quad");
    let mesh = &scene.objects[0].parts[0].mesh;
    assert_eq!(mesh.positions[2], [1.0, 1.0, 7.0]);
    assert_eq!(mesh.triangles[..], [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
    assert_eq!(mesh.uv[0][1], [1.0, 1.0], "v is up in the file and down in a scene");
    let [r, g, b, a] = mesh.colors[0];
    assert_eq!([r, g, a], [1.0, 0.0, 1.0]);
    assert!((b - 0.2158605).abs() < 1e-6, "128 is 21.6 % of the light: {b}");
}

#[test]
fn strips_turn_every_second_triangle() {
    let text = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z
element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n7 0 1 2 3 -1 0 1\n";
    let scene = Memory::of([("s.ply", text)]).scene("s.ply");
    assert_eq!(scene.objects[0].parts[0].mesh.triangles[..], [[0, 1, 2], [1, 3, 2]]);
}

#[test]
fn errors_name_the_place() {
    let good = String::from_utf8(file("ascii")).unwrap();
    let error = |from: &str, to: &str| {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good);
        Memory::of([("q.ply", bad.as_bytes())]).error("q.ply")
    };
    assert_eq!(
        error("0 0e0 7", "0 nan 7"),
        "q.ply: mesh `q`, vertex 0: its position is [0.0, NaN, 7.0]; it must be finite"
    );
    assert_eq!(
        error("4 0 1 2 3", "4 0 1 2 4"),
        "q.ply: mesh `q`, triangle 1: vertex numbers [0, 2, 4]; there are 4 vertices"
    );
    assert_eq!(error("4 0 1 2 3", "4 0 1 2 -3"), "q.ply: face 0: vertex number -3");
    assert_eq!(error("4 0 1 2 3", "99 0 1 2 3"), "q.ply: face 0: a list of 99 numbers, 18 bytes left");
    assert_eq!(error("1 1e0 7", "1 one 7"), "q.ply: vertex 2: `one` is no F64");
    assert_eq!(
        error("element vertex 4", "element vertex 4000000000"),
        "q.ply: vertex: truncated: 4000000000 elements of at least 18 bytes, 147 bytes left"
    );
    assert_eq!(error("element edge 1", "element vertex 1"), "q.ply: header line 14: element `vertex` twice");
    assert_eq!(error("end_header", "# "), "q.ply: header line 19: cannot read `#`");
    assert_eq!(error("double y", "double yy"), "q.ply: header: vertices without x, y, z");
    assert_eq!(error("ply\n", "obj\n"), "q.ply: header line 1: not a PLY file: it does not begin with `ply`");
}

#[test]
fn a_truncated_file_is_an_error_wherever_it_ends() {
    for encoding in ["binary_little_endian", "binary_big_endian"] {
        let good = file(encoding);
        for end in 0..good.len() {
            Memory::of([("q.ply", &good[..end])]).load("q.ply").0.unwrap_err();
        }
    }
}

#[test]
fn textures_are_left_out_with_a_warning() {
    let text = "ply\nformat ascii 1.0\ncomment TextureFile red brick.png\ncomment by hand\nelement vertex 3\n\
                property float x\nproperty float y\nproperty float z\nelement face 1\n\
                property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let (scene, warnings) = Memory::of([("a.ply", text.as_bytes())]).load("a.ply");
    assert_eq!(scene.unwrap().objects.len(), 1);
    assert!(
        matches!(&warnings[..], [one] if one.starts_with("a.ply: ") && one.contains("red brick.png")),
        "{warnings:?}"
    );
}
