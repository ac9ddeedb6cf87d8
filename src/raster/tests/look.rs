//! What surfaces look like: interpolation, textures, normals, averaging.

use super::*;
use crate::{
    image::srgb,
    scene::{Image, Texture, Wrap},
};

fn textured(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Material {
    let texture = Texture {
        image: Arc::new(Image { name: String::new(), width, height, texels: texels.into() }),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Repeat; 2],
        smooth: true,
    };
    Material { base_color_texture: Some(texture), ..Material::default() }
}

fn one(mesh: Mesh, material: Material) -> Scene {
    Scene { objects: vec![object("a", mesh, material)] }
}

/// Vertex colours that are the position must come out as the point that the ray meets.
#[test]
fn attributes_are_perspective_correct() {
    let points = [[-2.0, -1.0, 0.5], [2.0, -1.0, -3.0], [0.2, 1.5, -1.0]];
    let mut m = mesh(&points, &[[0, 1, 2]]);
    m.colors = points.map(|[x, y, z]| [x * 0.1 + 0.5, y * 0.1 + 0.5, z * 0.1 + 0.5, 1.0]).to_vec().into();
    let scene = one(m, Material::default());
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    for projection in [None, Some((-2.0, 2.0))] {
        let mut view = ahead(2.0, 64, 64);
        if let Some((left, right)) = projection {
            view.projection = crate::view::Projection::Orthographic { left, right, bottom: -2.0, top: 2.0 };
        }
        let near = first(&scene, &view);
        let mut seen = 0;
        for i in (0..64 * 64).filter(|i| near.triangle[*i] == 0) {
            let (px, py) = ((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
            let p = view.unproject(px, py, near.depth[i] as f64).as_vec3();
            let s = shader.shade(&view, px, py, 0);
            let expect = p * 0.1 + 0.5;
            assert!((Vec3::new(s.color[0], s.color[1], s.color[2]) - expect).length() < 1e-3, "{s:?} {expect}");
            seen += 1;
        }
        assert!(seen > 200);
    }
}

#[test]
fn normals_face_the_eye() {
    let mut m = square();
    let scene_flat = one(m.clone(), Material::default());
    m.normals = vec![[0.6, 0.0, 0.8]; 4].into();
    let mut smooth = one(m, Material::default());
    smooth.objects[0].transform = Mat4::from_scale(Vec3::new(2.0, 1.0, 1.0));
    for (scene, front) in [(scene_flat, Vec3::Z), (smooth, Vec3::new(0.3, 0.0, 0.8).normalize())] {
        let geometry = Geometry::new(&scene);
        let shader = Shader::new(&geometry);
        let from = |eye: f64| {
            let view = View::look_at(DVec3::Z * eye, DVec3::ZERO, DVec3::Y, 1.0, 8, 8, 0.1, 9.0);
            shader.shade(&view, 4.2, 4.3, 0).normal
        };
        assert!((from(2.0) - front).length() < 1e-6);
        assert!((from(-2.0) + front).length() < 1e-6);
    }
}

/// A normal map that leans towards +u, and one that leans up in the image, with and without tangents.
#[test]
fn normal_maps_bend_normals() {
    for (texel, expect) in [([255, 128, 128, 255], Vec3::X), ([128, 255, 128, 255], Vec3::Y)] {
        for tangents in [false, true] {
            for mirror in [1.0f32, -1.0] {
                let mut m = square();
                m.normals = vec![[0.0, 0.0, 1.0]; 4].into();
                if tangents {
                    m.tangents = vec![[1.0, 0.0, 0.0, 1.0]; 4].into();
                }
                let material =
                    Material { normal_texture: textured(1, 1, vec![texel]).base_color_texture, ..Material::default() };
                let mut scene = one(m, material);
                scene.objects[0].transform = Mat4::from_scale(Vec3::new(mirror, 1.0, 1.0));
                let geometry = Geometry::new(&scene);
                let s = Shader::new(&geometry).shade(&ahead(2.0, 9, 9), 4.0, 4.5, 0);
                let expect = expect * Vec3::new(mirror, 1.0, 1.0);
                assert!((s.normal - expect).length() < 0.02, "{texel:?} {tangents} {mirror}: {}", s.normal);
            }
        }
    }
}

/// Red, green, blue and white quarters come out where they belong: v points down, u to the right.
#[test]
fn textures_are_the_right_way_up() {
    let quarters = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
    let mut material = textured(2, 2, quarters.clone());
    if let Some(t) = &mut material.base_color_texture {
        t.smooth = false;
    }
    let at = |material: &Material, x: usize, y: usize| {
        let scene = one(square(), material.clone());
        let how = Rendering::default().with_samples(1);
        let done =
            render(&Cpu, &Shader::new(&Geometry::new(&scene)), &ahead(1.0, 64, 64), &how, &Stop::default()).unwrap();
        done.picture.texels[y * 64 + x]
    };
    for (i, (x, y)) in [(10, 10), (50, 10), (10, 50), (50, 50)].into_iter().enumerate() {
        assert_eq!(at(&material, x, y), quarters[i]);
    }
    // KHR_texture_transform: a quarter turn counter-clockwise of the coordinates turns the image clockwise.
    if let Some(t) = &mut material.base_color_texture {
        t.rotation = std::f32::consts::FRAC_PI_2;
        t.offset = [0.0, 1.0];
    }
    assert_eq!(at(&material, 10, 10), quarters[2]);
    assert_eq!(at(&material, 50, 10), quarters[0]);
}

/// A chessboard far away is its mean in linear light, not in sRGB.
#[test]
fn distant_textures_are_averaged_in_linear_light() {
    let texels = (0..64 * 64).map(|i| if (i % 64 + i / 64) % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] }).collect();
    let scene = one(square(), textured(64, 64, texels));
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    let c = shader.shade(&ahead(4.0, 16, 16), 8.3, 8.2, 0).color;
    assert!((c[0] - 0.5).abs() < 4e-3 && c[3] == 1.0, "{c:?}");
    // Near, single texels are seen.
    let near = ahead(0.11, 4096, 4096);
    let c = shader.shade(&near, 2048.0, 2048.0, 0).color[0];
    assert!((c - 0.5).abs() < 1e-3, "between four texels: {c}");
    let (px, py, _) = near.project(DVec3::new(1.0 / 64.0, 1.0 / 64.0, 0.0));
    let c = shader.shade(&near, px, py, 0).color[0];
    assert!(!(0.02..=0.98).contains(&c), "{c}");
}

#[test]
fn pictures_average_coverage_in_linear_light() {
    // The square covers the left three quarters of the middle pixel of nine.
    let mut scene = one(square(), Material::default());
    scene.objects[0].transform = Mat4::from_translation(Vec3::new(-0.75, 0.0, 0.0));
    for samples in [4, 8] {
        let how = Rendering { background: [0.0; 3], ..Rendering::default().with_samples(samples) };
        let geometry = Geometry::new(&scene);
        let view = View { width: 9, height: 9, ..ahead(4.5, 9, 9) };
        let done = render(&Cpu, &Shader::new(&geometry), &view, &how, &Stop::default()).unwrap();
        let row = &done.picture.texels[4 * 9..][..9];
        assert_eq!(row[3], [255; 4]);
        let share = srgb::from_linear(0.75);
        assert_eq!(row[4], [share, share, share, 255]);
        assert_eq!(row[5], [0, 0, 0, 255]);
        assert_eq!(done.nearest, first(&scene, &view));
    }
}

/// Sample counts whose tiles are not 64 pixels wide, and views that end within a tile.
#[test]
fn any_number_of_samples() {
    let scene = scene(octahedron(3));
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    let how = |samples_per_axis| Rendering::default().with_samples(samples_per_axis);
    let view = ahead(1.6, 71, 67);
    let mean = |samples| {
        let p = picture(&Cpu, &shader, &view, &how(samples), &Stop::default()).unwrap();
        p.texels.iter().map(|t| t[0] as f64).sum::<f64>() / p.texels.len() as f64
    };
    let fine = mean(8);
    for samples in [1, 2, 3, 5, 7] {
        assert!((mean(samples) - fine).abs() < 2.0, "{samples}: {} {fine}", mean(samples));
    }
}

#[test]
fn lit_surfaces_know_the_sun() {
    let light = Light::default();
    assert!((light.to_sun.length() - 1.0).abs() < 1e-6);
    let surface = |normal, unlit| Surface {
        position: glam::DVec3::ZERO,
        color: [0.5, 0.5, 0.5, 1.0],
        normal,
        to_eye: Vec3::Z,
        emissive: [0.1, 0.0, 0.0],
        unlit,
    };
    let lit = Shading::Lit(light);
    let (sunny, shady) = (surface(light.to_sun, false).seen(&lit), surface(-light.to_sun, false).seen(&lit));
    assert!(sunny[1] > 3.0 * shady[1] && shady[1] > 0.0);
    assert_eq!(surface(Vec3::Y, true).seen(&lit), [0.5; 3]);
    assert_eq!(surface(Vec3::Y, false).seen(&Shading::Unlit), [0.5; 3]);
}

#[test]
fn highlights_lie_between_sun_and_eye() {
    let gloss = Some(Gloss { strength: 0.5, exponent: 40.0 });
    let light = Light { to_sun: Vec3::Y, gloss, ..Light::default() };
    let matt = Light { gloss: None, ..light };
    let seen = |normal: Vec3, to_eye: Vec3, light: Light| {
        let color = [0.2, 0.3, 0.4, 1.0];
        let s = Surface { position: DVec3::ZERO, color, normal, to_eye, emissive: [0.0; 3], unlit: false };
        Vec3::from(s.seen(&Shading::Lit(light)))
    };
    let halfway = (Vec3::X + Vec3::Y).normalize();
    let extra = |normal, to_eye| seen(normal, to_eye, light) - seen(normal, to_eye, matt);
    let peak = Vec3::from(light.sun) * 0.5 * halfway.y;
    assert!((extra(halfway, Vec3::X) - peak).length() < 1e-6);
    assert!(extra(Vec3::Y, Vec3::X).length() < 0.01 * peak.length());
    assert_eq!(extra(Vec3::NEG_Y, Vec3::NEG_Y), Vec3::ZERO);
}

/// Shading squares of samples together changes a smooth picture little, and its outline not at all.
#[test]
fn shared_shades_are_close_to_single_ones() {
    let texels = (0..32 * 32).map(|i| if (i / 4 + i / 128) % 2 == 0 { [30, 60, 90, 255] } else { [220; 4] }).collect();
    let mut scene = one(square(), textured(32, 32, texels));
    scene.objects[0].transform = Mat4::from_rotation_x(-1.1) * Mat4::from_rotation_z(0.3);
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    let draw = |how: Rendering| picture(&Cpu, &shader, &ahead(1.5, 96, 96), &how, &Stop::default()).unwrap();
    let (shared, single) = (draw(Rendering::default()), draw(Rendering::default().with_samples(4)));
    let far = |a: &[u8; 4], b: &[u8; 4]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b) as u32).max().unwrap_or(0);
    let differences = shared.texels.iter().zip(&single.texels).map(|(a, b)| far(a, b));
    let (most, sum) = differences.fold((0, 0), |(m, s), d| (m.max(d), s + d));
    assert!(most > 0 && most < 60 && sum < 2 * 96 * 96, "{most} {sum}");
}
