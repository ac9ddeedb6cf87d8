//! OBJ and MTL.

use super::*;

const OBJ: &str = "# two things
mtllib stuff.mtl
v 0 0 0
v 1 0 0 \\
  1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0.25
vn 0 0 2
o first thing
usemtl red
f 1/1/1 2/2/1 3/1/1 4/2/1
usemtl none such
f -4 -3 -2
o second
usemtl red
f 1//1 3//1 4//1
l 1 2
";

const MTL: &str = "newmtl red\nKd 1 0.5 0\nd 0.5\nmap_Kd -s 2 3 1 -o 0.5 0.25 tex ture.png\nnewmtl other\nKd 0 0 0\n";

pub(super) fn png() -> Vec<u8> {
    let scene = everything();
    let t = &scene.objects[0].parts[0].material.base_color_texture;
    let image = &t.as_ref().unwrap().image;
    let mut out = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut out);
    use image::ImageEncoder;
    let texels = bytemuck::cast_slice(&image.texels);
    encoder.write_image(texels, image.width, image.height, image::ExtendedColorType::Rgba8).unwrap();
    out
}

#[test]
fn objects_materials_and_corners() {
    let files = Memory::of([("d/a.obj", OBJ.as_bytes()), ("d/stuff.mtl", MTL.as_bytes()), ("d/tex ture.png", &png())]);
    let (scene, warnings) = files.load("d/a.obj");
    let scene = scene.unwrap();
    assert_eq!(
        warnings,
        [
            "d/a.obj: 1 points, lines and curves are left out",
            "d/stuff.mtl: material `red`: shown opaque: d or Tr gives half of opacity or more, and nothing is blended",
            "d/a.obj: materials without a definition, shown white: none such",
        ]
    );
    let names: Vec<_> = scene.objects.iter().map(|o| (o.name.as_str(), o.parts.len())).collect();
    assert_eq!(names, [("first thing", 2), ("second", 1)]);
    let [white, red] = &scene.objects[0].parts[..] else { panic!() };
    assert_eq!(white.material.base_color, [1.0; 4]);
    assert_eq!(red.mesh.triangles[..], [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(red.mesh.normals[0], [0.0, 0.0, 1.0]);
    assert_eq!(red.mesh.uv[0][1], [1.0, 0.75]);
    assert_eq!(red.mesh.colors[..2], [[1.0, 1.0, 1.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
    let [r, g, b, a] = red.material.base_color;
    assert_eq!([r, b, a], [1.0, 0.0, 0.5]);
    assert!((g - 0.21404114).abs() < 1e-6, "materials are sRGB: {g}");
    assert_eq!(red.material.alpha, Alpha::Blend);
    let t = red.material.base_color_texture.as_ref().unwrap();
    // v' = 3 v + 0.25 with v up: at the bottom (v up 0, v down 1) it is 0.25, that is 0.75 down.
    assert_eq!(t.scale[1] * 1.0 + t.offset[1], 0.75);
    assert_eq!((t.image.width, t.image.name.as_str()), (4, "tex ture.png"));
    assert!(Arc::ptr_eq(&red.material, &scene.objects[1].parts[0].material));
}

#[test]
fn errors_name_the_line() {
    let error = |from: &str, to: &str| {
        let bad = OBJ.replacen(from, to, 1);
        assert_ne!(bad, OBJ);
        let files = [("a.obj", bad.as_bytes()), ("stuff.mtl", MTL.as_bytes()), ("tex ture.png", &png())];
        Memory::of(files).error("a.obj")
    };
    assert_eq!(error("3/1/1", "3/x/1"), "a.obj: line 13: `3/x/1` is no corner of a face");
    assert_eq!(error("3/1/1", "3/1/1/1"), "a.obj: line 13: `3/1/1/1` is no corner of a face");
    assert_eq!(error("v 1 1 0", "v 1 one 0"), "a.obj: line 6: `one` is no number");
    assert_eq!(error("vn 0 0 2", "vn 0 0"), "a.obj: line 10: 2 numbers where 3 are needed");
    assert_eq!(
        error("stuff.mtl", "../stuff.mtl"),
        "a.obj: `../stuff.mtl` lies outside the scene's folder .; `--allow-outside` permits it"
    );
}

#[test]
fn a_missing_library_is_a_warning_a_missing_texture_an_error() {
    let (scene, warnings) = Memory::of([("a.obj", OBJ.as_bytes())]).load("a.obj");
    assert!(scene.is_ok());
    assert_eq!(warnings[1], "a.obj: line 2: the material library `stuff.mtl` does not exist; looked for stuff.mtl");
    let files = Memory::of([("a.obj", OBJ.as_bytes()), ("stuff.mtl", MTL.as_bytes())]);
    assert_eq!(
        files.error("a.obj"),
        "stuff.mtl: line 4: the texture `tex ture.png` does not exist; looked for tex ture.png"
    );
    // A texture that no face shows need not be there.
    let other = OBJ.replace("usemtl red", "usemtl other");
    let files = Memory::of([("a.obj", other.as_bytes()), ("stuff.mtl", MTL.as_bytes())]);
    files.load("a.obj").0.unwrap();
}

#[test]
fn an_alpha_map_cuts_holes() {
    let mtl = "newmtl red\nmap_Kd t.png\nmap_d t.png\n";
    let files = Memory::of([("a.obj", OBJ.as_bytes()), ("stuff.mtl", mtl.as_bytes()), ("t.png", &png())]);
    let scene = files.load("a.obj").0.unwrap();
    let m = &scene.objects[1].parts[0].material;
    assert_eq!(m.alpha, Alpha::Mask { cutoff: 0.5 });
    assert_eq!(m.base_color_texture.as_ref().unwrap().image.texels[5][3], 10);
}

/// The scene of an OBJ beside an MTL and a texture, and the warnings.
fn with_mtl(obj: &str, mtl: &str) -> (Scene, Vec<String>) {
    let files = Memory::of([("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_bytes()), ("t.png", &png())]);
    let (scene, warnings) = files.load("a.obj");
    (scene.unwrap(), warnings)
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

fn material(mtl: &str) -> (Arc<Material>, Vec<String>) {
    let (scene, warnings) =
        with_mtl(&format!("mtllib m.mtl\n{TRIANGLE}usemtl red\nf 1/1 2/2 3/3\n"), &format!("newmtl red\n{mtl}"));
    (scene.objects[0].parts[0].material.clone(), warnings)
}

#[test]
fn concave_faces_keep_their_notches() {
    // A wall with a doorway, and a quad whose second corner is its notch.
    let wall = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 2 2 0\nv 2 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\n";
    let obj = format!("{wall}v 9 0 0\nv 7.5 .5 0\nv 7 2 0\nv 7 0 0\nf 1 2 3 4 5 6 7 8\nf -4 -3 -2 -1\n");
    let scene = Memory::of([("a.obj", obj.as_bytes())]).scene("a.obj");
    let mesh = &scene.objects[0].parts[0].mesh;
    assert_eq!(mesh.triangles.len(), 6 + 2);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| glam::Vec3::from(mesh.positions[v as usize]));
        (b - a).cross(c - a).z * 0.5
    };
    assert!(mesh.triangles[..6].iter().all(|t| area(t) > 0.0), "the winding is kept");
    assert!((mesh.triangles[..6].iter().map(area).sum::<f32>() - 7.0).abs() < 1e-5);
    assert!(mesh.triangles[6..].iter().all(|t| area(t) > 0.0));
    assert!((mesh.triangles[6..].iter().map(area).sum::<f32>() - 1.0).abs() < 1e-5);
}

#[test]
fn what_a_face_lacks_takes_nothing_from_the_others() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 5 5 5\nvt 0 0\nvt inf 0\nvn 0 0 1\n\
        f 1/1/1 2/1/1 3/1/1\nf 1 2 3\nf 1//1 2//1 3//1\nf 1/1/1 2/2/1 3/1/1\nf 1/9/1 2/1/1 3/1/1\n\
        f 1 2 4\nf 1 2\nf 1 1 2\nf 1 2 77\nf 0 1 2\nf 1 2 -9999999999\n";
    let (scene, warnings) = Memory::of([("a.obj", obj.as_bytes())]).load("a.obj");
    let scene = scene.unwrap();
    let parts: Vec<_> = scene.objects[0].parts.iter().map(|p| &p.mesh).collect();
    let has = |m: &Mesh| (m.triangles.len(), !m.uv[0].is_empty(), !m.normals.is_empty());
    assert_eq!(
        parts.iter().map(|m| has(m)).collect::<Vec<_>>(),
        [(1, false, false), (3, false, true), (1, true, true)]
    );
    assert_eq!(
        warnings,
        [
            "a.obj: faces left out: 3 with a vertex number that does not exist, the first in line 17",
            "a.obj: faces left out: 1 with a corner that is no finite number, the first in line 14",
            "a.obj: faces left out: 2 without area, the first in line 15",
            "a.obj: faces shown without texture coordinates or normals: 2 whose own do not exist or are not finite, \
             the first in line 12",
        ]
    );
}

#[test]
fn faces_may_stand_before_their_vertices() {
    let scene = Memory::of([("a.obj", b"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n")]).scene("a.obj");
    assert_eq!(scene.triangle_count(), 1);
}

#[test]
fn every_encoding_and_line_end_gives_the_same_scene() {
    let obj = format!("mtllib m.mtl\no Tête\n{TRIANGLE}usemtl Tête\nf 1/1 2/2 \\\n 3/3\n");
    let mtl = "newmtl Tête\nKd 1 0 0\n";
    let load = |obj: Vec<u8>, mtl: Vec<u8>| Memory::of([("a.obj", &obj), ("m.mtl", &mtl)]).scene("a.obj");
    let plain = load(obj.clone().into(), mtl.into());
    assert_eq!(plain.objects[0].parts[0].material.base_color, [1.0, 0.0, 0.0, 1.0]);
    let latin = |text: &str| text.chars().map(|c| c as u8).collect::<Vec<u8>>();
    let wide = |text: &str| format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<u8>>();
    let marked = |text: &str| format!("\u{feff}{text}").into_bytes();
    let cr = |text: &str| text.replace('\n', "\r").into_bytes();
    let crlf = |text: &str| text.replace('\n', " \t\r\n").into_bytes();
    for write in [&latin as &dyn Fn(&str) -> Vec<u8>, &wide, &marked, &cr, &crlf] {
        assert_eq!(load(write(&obj), write(mtl)), plain);
    }
    let error = Memory::of([("a.obj", b"v 0 0 0\nv 1 \0 0\n")]).error("a.obj");
    assert_eq!(error, "a.obj: line 2: a NUL byte; the file is damaged or no text");
}

#[test]
fn names_of_materials_are_found_however_they_are_written() {
    for (library, new, used) in [
        ("mtllib m.mtl", "newmtl Material #25", "usemtl Material #25"),
        ("MTLLIB none.mtl m.mtl", "NewMtl wood#1", "UseMtl wood#1"),
        ("mtllib C:\\work\\n.mtl C:\\work\\m.mtl", "newmtl red", "usemtl red"),
        ("mtllib m.mtl C:\\work\\n.mtl", "newmtl red", "usemtl red"),
        ("mtllib m.mtl # the materials", "newmtl red # bright", "usemtl red"),
        ("mtllib .\\m.mtl", "newmtl red", "usemtl red # bright"),
        ("mtllib \"m.mtl\"", "newmtl \"red brick\"", "usemtl red brick"),
        ("mtllib\tC:\\work\\m.mtl", "newmtl\tred", "usemtl\t\"red\"\t"),
    ] {
        let mtl = format!("newmtl Material #24\nKd 0 1 0\n{new}\nkD 1 0 0\n");
        let (scene, _) = with_mtl(&format!("{library}\n{TRIANGLE}{used}\nf 1 2 3\n"), &mtl);
        assert_eq!(scene.objects[0].parts[0].material.base_color, [1.0, 0.0, 0.0, 1.0], "{library} {new} {used}");
    }
}

#[test]
fn textures_are_found_beside_the_library_with_a_warning() {
    for (name, warned) in [
        ("t.png", false),
        (".\\t.png", false),
        ("\"t.png\"", false),
        ("t.png # the map", false),
        ("-S 1 1 1 -bm 0.5 -clamp on -mm 0 1 t.png", false),
        ("\t-o 0 0\tt.png", false),
        ("C:\\Users\\anna\\t.png", true),
        ("/home/anna/t.png", true),
        ("\\\\server\\share\\t.png", true),
        ("textures/t.png", true),
    ] {
        let (m, warnings) = material(&format!("Kd 1 1 1\nmap_KD {name}\n"));
        assert!(m.base_color_texture.is_some(), "{name}");
        assert_eq!(warnings.len(), usize::from(warned), "{name}: {warnings:?}");
        assert!(warnings.iter().all(|w| w.ends_with("; t.png is used")), "{warnings:?}");
    }
}

#[test]
fn materials_look_as_viewers_show_them_or_a_warning_says_why_not() {
    let look = |mtl: &str| {
        let (m, warnings) = material(mtl);
        assert!(warnings.len() <= 1, "{warnings:?}");
        let warning = warnings.into_iter().next().unwrap_or_default();
        (m, warning.strip_prefix("m.mtl: material `red`: ").unwrap_or(&warning).to_owned())
    };
    let (m, why) = look("Kd 0 0 0\nmap_Kd t.png\n");
    assert_eq!((m.base_color, m.base_color_texture.is_some()), ([1.0; 4], true));
    assert_eq!(why, "Kd 0 0 0 beside map_Kd; the texture is shown as it is");
    let opaque = "shown opaque: d or Tr gives half of opacity or more, and nothing is blended";
    for (mtl, alpha, warning) in [
        ("d 1\nTr 0", 1.0, ""),
        ("Tr 0.25", 0.75, opaque),
        ("d 0.5\nTr 1", 0.5, opaque),
        ("Tr 1", 1.0, "Tr 1 without d; shown opaque, as the exporters that write it mean"),
        ("d 1\nTr 1", 1.0, ""),
        ("Tr 1\nd 1", 1.0, ""),
        ("d 0\nTr 0", 1.0, "d 0 says invisible, Tr 0 says opaque; shown opaque"),
        ("d 0\nTr 1", 0.0, "invisible: d 0"),
        ("d -halo 0.5", 0.5, opaque),
        ("d 0.3", 0.3, "invisible: d or Tr gives less than half of opacity, and nothing is blended"),
    ] {
        let (m, why) = look(mtl);
        assert_eq!((m.base_color[3], why.as_str()), (alpha, warning), "{mtl}");
        assert_eq!(m.alpha == Alpha::Blend, alpha < 1.0);
    }
    let (m, why) = look("Kd 0 0 0\nmap_Ke t.png\n");
    assert!(m.unlit && m.base_color_texture.is_some() && m.emissive_texture.is_none() && m.emissive == [0.0; 3]);
    assert_eq!(
        (m.base_color, why.as_str()),
        ([1.0; 4], "black but for Ke or map_Ke; shown unlit in the colour that it emits")
    );
    let (m, why) = look("Kd 0 0 0\n");
    assert_eq!((m.base_color, why.as_str()), ([0.0, 0.0, 0.0, 1.0], "shown black: Kd 0 0 0, and no texture"));
}

#[test]
fn colours_up_to_255_are_bytes() {
    let obj = |color: &str| format!("v 0 0 0 {color}\nv 1 0 0 {color}\nv 0 1 0 0 0 0\nf 1 2 3\n");
    let load = |color: &str| {
        let (scene, warnings) = Memory::of([("a.obj", obj(color).as_bytes())]).load("a.obj");
        (scene.unwrap().objects[0].parts[0].mesh.colors[0], warnings.len())
    };
    assert_eq!(load("255 51 0"), (load("1 0.2 0").0, 1));
    assert_eq!(load("255 51 0 255"), (load("1 0.2 0").0, 1));
    assert_eq!(load("1.0001 0.2 0"), (load("1 0.2 0").0, 0));
    assert_eq!(load("1 nan 0").1, 0);
}

#[test]
fn a_scan_far_from_the_origin_keeps_its_shape() {
    let obj = |[x, y, z]: [f64; 3]| {
        let at = |i: f64, j: f64| format!("v {:.3} {:.3} {:.3}\n", x + i * 0.001, y + j * 0.002, z + i * j * 0.001);
        let grid = (0..9).flat_map(|i| (0..9).map(move |j| (i as f64, j as f64)));
        let mut text = grid.map(|(i, j)| at(i, j)).collect::<String>();
        for k in 0..71 {
            text += &format!("f {} {} {}\n", k + 1, k + 2, k + 10);
        }
        text
    };
    let load = |origin| Memory::of([("a.obj", obj(origin).as_bytes())]).scene("a.obj");
    let far = [500_000.123, 5_400_000.456, 50.0];
    let (near, far_scene) = (load([0.0; 3]), load(far));
    assert_eq!(near.objects[0].transform, Mat4::IDENTITY);
    let world = |s: &Scene| {
        let o = &s.objects[0];
        let m = o.parts[0].mesh.clone();
        m.positions
            .iter()
            .map(|p| o.transform.as_dmat4().transform_point3(glam::Vec3::from(*p).as_dvec3()))
            .collect::<Vec<_>>()
    };
    for (a, b) in world(&near).into_iter().zip(world(&far_scene)) {
        assert!((b - glam::DVec3::from(far) - a).abs().max_element() < 5e-8, "{a} {b}");
    }
}
