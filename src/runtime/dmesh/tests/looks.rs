//! Colours, light and noise against the rasteriser's.

use super::*;
use crate::{
    image::{Picture, measure},
    raster::{
        Cpu, Geometry, Gloss, Light, NOTHING, Noise, Shader, Shading, picture, render,
        tests::{object, octahedron},
    },
    scene::{Image, Material, Texture, Wrap},
    view::Projection,
};
use glam::DVec3;
use std::sync::Arc;

#[test]
fn from_its_own_camera_a_reference_shows_its_picture() {
    let scene = solids();
    let view = towards(&scene, DVec3::new(1.0, 0.6, 0.8), 129);
    let reference = reference(&scene, "a", &view);
    let dmesh = Dmesh { references: vec![reference], epsilon: 0.0, diagonal: 1.0, double_sided: false };
    let drawn = draw(&dmesh, &view, &one_sample());
    let covered = dmesh.references[0].mesh.positions.len();
    let mut seen = 0;
    for (i, texel) in drawn.picture.texels.iter().enumerate().filter(|(i, _)| drawn.surface[*i] != NOTHING) {
        let expect = &dmesh.references[0].color.texels[i];
        assert!(far(texel, expect) <= 1, "{i}: {texel:?} {expect:?}, triangle {}", drawn.surface[i]);
        seen += 1;
    }
    assert!(seen * 10 > covered * 8, "{seen} of {covered}");
}

/// Two triangles that reach far into the depth show the picture that a perspective camera took of them where it belongs, however large
/// they are.
#[test]
fn pictures_are_cast_on_large_triangles() {
    let (mut floor, size) = (square("a", DVec3::Z * 3.0, DVec3::ZERO, [0; 3], 1.0), 128u32);
    let view =
        View::look_at(DVec3::new(0.0, 1.0, 4.0), DVec3::new(0.0, 0.0, -3.0), DVec3::Y, 0.9, size, size, 0.1, 99.0);
    let corners = [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 0.0, -9.0], [-1.0, 0.0, -9.0f32]];
    let uv = corners.map(|p| {
        let (px, py, _) = view.project(glam::Vec3::from(p).as_dvec3());
        [(px / f64::from(size)) as f32, (py / f64::from(size)) as f32]
    });
    let mesh = Mesh { positions: corners.to_vec().into(), uv: uv.to_vec().into(), ..(*floor.mesh).clone() };
    let texels = (0..size * size).map(|i| [(i % size * 2) as u8, (i / size * 2) as u8, 0, 255]).collect();
    floor.color = Arc::new(Image { name: String::new(), width: size, height: size, texels });
    (floor.mesh, floor.view) = (Arc::new(mesh), view);
    let dmesh = Dmesh { references: vec![floor], epsilon: 0.0, diagonal: 1.0, double_sided: false };
    let drawn = draw(&dmesh, &view, &one_sample());
    let mut seen = 0;
    for (i, texel) in drawn.picture.texels.iter().enumerate().filter(|(i, _)| drawn.surface[*i] != NOTHING) {
        assert!(far(texel, &dmesh.references[0].color.texels[i]) <= 1, "{i}: {texel:?}");
        seen += 1;
    }
    assert!(seen > 1500, "{seen}");
}

/// A sphere with a texture whose coordinates stay within 0 to 1.
fn sphere(levels: u32) -> Scene {
    let mut mesh = octahedron(levels);
    let unit = |p: &[f32; 3]| glam::Vec3::from(*p).normalize().to_array();
    mesh.positions = mesh.positions.iter().map(unit).collect();
    mesh.normals = mesh.positions.clone();
    mesh.uv[0] = mesh.positions.iter().map(|p| [0.5 + 0.45 * p[0], 0.5 + 0.45 * p[1]]).collect();
    let texels = (0..64 * 64u32).map(|i| [(i % 64 * 3) as u8 + 60, 200 - (i / 64 * 2) as u8, 120, 255]).collect();
    let texture = Texture {
        image: Arc::new(Image { name: String::new(), width: 64, height: 64, texels }),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Clamp; 2],
        smooth: true,
    };
    let material = Material { base_color_texture: Some(texture), double_sided: false, ..Material::default() };
    Scene { objects: vec![object("sphere", mesh, material)] }
}

fn shadings() -> [Shading; 4] {
    let gloss = Some(Gloss { strength: 0.6, exponent: 20.0 });
    [
        Shading::Unlit,
        Shading::Lit(Light::default()),
        Shading::Lit(Light { gloss, ..Light::default() }),
        Shading::Noise(Noise { period: 0.3 }),
    ]
}

/// The very mesh and texture of a scene as the only reference: every shading equals the rasteriser's.
#[test]
fn a_mesh_of_its_own_is_drawn_as_the_rasteriser_draws_it() {
    let scene = sphere(3);
    let part = &scene.objects[0].parts[0];
    let mesh = Mesh {
        positions: part.mesh.positions.clone(),
        normals: part.mesh.normals.clone(),
        quality: vec![0.7; part.mesh.positions.len()].into(),
        uv: part.mesh.uv[0].clone(),
        triangles: part.mesh.triangles.clone(),
    };
    let view = towards(&scene, DVec3::new(0.3, 0.5, 1.0), 90);
    let color = part.material.base_color_texture.as_ref().unwrap().image.clone();
    // Captured by a camera that casts its picture in parallel, so that coordinates are affine as the rasteriser's are.
    let projection = Projection::Orthographic { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
    let captured = View { projection, ..view };
    let reference = Reference { name: "a".into(), view: captured, mesh: Arc::new(mesh), color, normal_map: None };
    let dmesh = Dmesh { references: vec![reference], epsilon: 0.0, diagonal: 1.0, double_sided: false };
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    for shading in shadings() {
        let how = Rendering { shading, ..Rendering::default() };
        let drawn = draw(&dmesh, &view, &how);
        let expect = render(&Cpu, &shader, &view, &how, &Stop::default()).unwrap();
        let worst = drawn.picture.texels.iter().zip(&expect.picture.texels).map(|(a, b)| far(a, b)).max();
        assert!(worst <= Some(1), "{shading:?}: {worst:?}");
        assert_eq!(drawn.depth, expect.nearest.depth);
        assert_eq!(drawn.surface, expect.nearest.triangle);
    }
}

/// A captured sphere seen from between its references, with normals from maps and from vertices, under a light with highlights.
#[test]
fn a_relit_sphere_equals_the_lit_sphere() {
    let scene = sphere(6);
    let mapped = captured(&scene, 129);
    let mut bare = mapped.clone();
    bare.references.iter_mut().for_each(|r| r.normal_map = None);
    let view = towards(&scene, DVec3::new(0.7, 0.6, 1.0), 120);
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    for shading in shadings() {
        let how = Rendering { shading, ..Rendering::default() };
        let expect = picture(&Cpu, &shader, &view, &how, &Stop::default()).unwrap();
        for dmesh in [&mapped, &bare] {
            let drawn = draw(dmesh, &view, &how);
            let floats = |p: &Picture| p.texels.iter().flatten().map(|c| f32::from(*c) / 255.0).collect::<Vec<_>>();
            let db = measure::psnr(&floats(&expect), &floats(&drawn.picture));
            assert!(db > 40.0, "{shading:?}: {db} dB");
            // Inside, where pixels and their neighbours see the sphere on both sides.
            let centre = |i: usize| libm::hypot((i % 120) as f64 - 59.5, (i / 120) as f64 - 59.5);
            let inner = (0..120 * 120).filter(|i| centre(*i) < 26.0);
            let worst = inner.map(|i| far(&expect.texels[i], &drawn.picture.texels[i])).max();
            assert!(worst <= Some(6), "{shading:?}: {worst:?}");
        }
    }
}
