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

/// An ASCII file of vertices `x y z` with more properties, and of faces.
fn ascii(vertex: &str, face: &str, vertices: &[&str], faces: &[&str]) -> String {
    let properties = |list: &str| list.lines().map(|p| format!("property {p}\n")).collect::<String>();
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\n{}element face {}\nproperty list uchar int vertex_indices\n{}end_header\n{}\n{}\n",
        vertices.len(),
        properties(&format!("float x\nfloat y\nfloat z\n{vertex}")),
        faces.len(),
        properties(face),
        vertices.join("\n"),
        faces.join("\n"),
    )
}

const SQUARE: [&str; 4] = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"];

#[test]
fn one_bad_vertex_or_face_is_left_out_with_a_warning() {
    let vertices = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "-nan(ind) 0 0", "1e39 0 0"];
    let faces = ["3 0 1 2", "3 0 1 4", "3 0 1 5", "2 0 1", "3 0 1 9", "3 0 1 -1", "3 0 0 1", "4 0 1 2 3", "0"];
    let text = ascii("", "", &vertices, &faces);
    let (scene, warnings) = Memory::of([("a.ply", text.as_bytes())]).load("a.ply");
    assert_eq!(scene.unwrap().objects[0].parts[0].mesh.triangles[..], [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
    assert_eq!(
        warnings,
        [
            "a.ply: faces left out: 2 with a vertex number that does not exist, the first is face 4",
            "a.ply: faces left out: 2 with a corner that is no finite number, the first is face 1",
            "a.ply: faces left out: 2 without area, the first is face 3",
        ]
    );
}

#[test]
fn a_concave_face_keeps_its_notch() {
    let text = ascii("", "", &["-1 -1 0", "1 -1 0", "1 1 0", "0 -.5 0", "-1 1 0"], &["5 0 1 2 3 4"]);
    let scene = Memory::of([("a.ply", text.as_bytes())]).scene("a.ply");
    let mesh = &scene.objects[0].parts[0].mesh;
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| glam::Vec3::from(mesh.positions[v as usize]));
        (b - a).cross(c - a).z * 0.5
    };
    assert!(mesh.triangles.iter().all(|t| area(t) > 0.0));
    assert!((mesh.triangles.iter().map(area).sum::<f32>() - 2.5).abs() < 1e-6);
}

#[test]
fn colours_of_faces_and_colours_up_to_255() {
    let reds = "float red\nfloat green\nfloat blue";
    let bytes = reds.replace("float", "uchar");
    let load = |text: &str| {
        let (scene, warnings) = Memory::of([("a.ply", text.as_bytes())]).load("a.ply");
        (scene.unwrap().objects[0].parts[0].mesh.clone(), warnings)
    };
    let two = ["3 0 1 2 255 0 0", "3 0 2 3 0 51 255"];
    let (faces, warnings) = load(&ascii("", &bytes, &SQUARE, &two));
    assert_eq!(warnings, [""; 0]);
    assert_eq!(faces.positions.len(), 6, "the two vertices on the border are split");
    let color = |face: usize, corner: usize| faces.colors[faces.triangles[face][corner] as usize];
    assert!((0..3).all(|c| color(0, c) == [1.0, 0.0, 0.0, 1.0]));
    assert!((0..3).all(|c| color(1, c)[2] == 1.0 && (color(1, c)[1] - 0.033_104_8).abs() < 1e-6));
    // The same as floats and as ints up to 255, with a warning; as fractions without one.
    for (kind, warned) in [("float", 1), ("int", 1), ("ushort", 1), ("char", 0)] {
        let (mesh, warnings) = load(&ascii("", &reds.replace("float", kind), &SQUARE, &two));
        assert_eq!((mesh, warnings.len()), (faces.clone(), warned), "{kind}");
    }
    assert_eq!(load(&ascii("", reds, &SQUARE, &["3 0 1 2 1 0 0", "3 0 2 3 0 .2 1"])).0, faces);
    // Colours of vertices count before those of faces.
    let vertices: Vec<_> = SQUARE.iter().map(|v| format!("{v} 0 255 0")).collect();
    let vertices: Vec<_> = vertices.iter().map(String::as_str).collect();
    let (both, _) = load(&ascii(&bytes, &bytes, &vertices, &two));
    assert_eq!(both.colors[..], [[0.0, 1.0, 0.0, 1.0]; 4]);
}

#[test]
fn headers_in_any_encoding() {
    let text = ascii("", "", &SQUARE, &["4 0 1 2 3"]).replacen("element", "comment Tête\nelement", 1);
    let load = |bytes: &[u8]| Memory::of([("a.ply", bytes)]).scene("a.ply");
    let plain = load(text.as_bytes());
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let wide: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    let all = [
        latin,
        wide,
        format!("\u{feff}{text}").into(),
        text.replace('\n', "\r").into(),
        text.replace('\n', "\r\n").into(),
    ];
    for bytes in all {
        assert_eq!(load(&bytes), plain);
    }
    // After a header that ends in CR alone a binary body may begin with any byte.
    let binary = file("binary_little_endian");
    let at = binary.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let mut cr: Vec<u8> = binary[..at].iter().map(|b| if *b == b'\n' { b'\r' } else { *b }).collect();
    cr.extend(&binary[at..]);
    assert_eq!(load(&cr), load(&binary));
}

#[test]
fn a_scan_far_from_the_origin_keeps_its_shape() {
    let text = ascii(
        "",
        "",
        &["500000.001 5400000.002 7", "500000.003 5400000.001 7.001", "500000.002 5400000.004 7"],
        &["3 0 1 2"],
    );
    let scene = Memory::of([("a.ply", text.replace("float", "double").as_bytes())]).scene("a.ply");
    let object = &scene.objects[0];
    let p = glam::Vec3::from(object.parts[0].mesh.positions[1]).as_dvec3();
    let world = object.transform.as_dmat4().transform_point3(p);
    assert!(world.abs_diff_eq(glam::dvec3(500_000.003, 5_400_000.001, 7.001), 5e-8), "{world}");
}
