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

fn png() -> Vec<u8> {
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
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert_eq!(warnings[0], "d/a.obj: 1 points, lines and curves are left out");
    assert_eq!(warnings[1], "d/a.obj: materials without a definition, shown white: none such");
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
    assert_eq!(error("3/1/1", "5/1/1"), "a.obj: line 13: vertex 5 does not exist; there are 4 so far");
    assert_eq!(error("3/1/1", "0/1/1"), "a.obj: line 13: vertex 0 does not exist; there are 4 so far");
    assert_eq!(
        error("-4", "-9223372036854775808"),
        "a.obj: line 15: vertex -9223372036854775808 does not exist; there are 4 so far"
    );
    assert_eq!(error("vn 0 0 2", "vn 0 0"), "a.obj: line 10: 2 numbers where 3 are needed");
    assert_eq!(error("f -4 -3 -2", "f -4 -3"), "a.obj: line 15: a face with 2 corners");
    assert_eq!(
        error("v 0 1 0", "v 0 inf 0"),
        "a.obj: object `first thing`, vertex 3: its position is [0.0, inf, 0.0]; it must be finite"
    );
    assert_eq!(
        error("stuff.mtl", "../stuff.mtl"),
        "a.obj: `../stuff.mtl` lies outside the scene's folder ; `allow_outside` permits it"
    );
}

#[test]
fn a_missing_library_is_a_warning_a_missing_texture_an_error() {
    let (scene, warnings) = Memory::of([("a.obj", OBJ.as_bytes())]).load("a.obj");
    assert!(scene.is_ok());
    assert!(warnings[1].contains("`stuff.mtl` does not exist"), "{warnings:?}");
    let files = Memory::of([("a.obj", OBJ.as_bytes()), ("stuff.mtl", MTL.as_bytes())]);
    assert_eq!(files.error("a.obj"), "tex ture.png: no such file");
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
