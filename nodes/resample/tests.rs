//! Colours of surfaces that lie close behind one another, from the scene to the textured mesh.

use super::{In, Params, Voxels};
use crate::{
    engine::node::Node,
    image::Picture,
    math::Stop,
    mesh::ChartedMesh,
    nodes::{collapse::voxel_cover::node as voxel_cover, pack_atlas, render_slices, testing, voxel_mesh},
    raster::{Cpu, Geometry, Rendering, Shader, picture},
    scene::{Material, Mesh, Object, Part, Scene},
    view::Cell,
    view::View,
};
use glam::{DVec3, Mat4};
use std::sync::Arc;

fn run<N: Node>(params: &N::Params, inputs: N::In) -> N::Out {
    testing::run::<N>(params, inputs).0.unwrap()
}

fn object(name: &str, quads: &[[[f32; 3]; 4]], color: [f32; 4], transform: Mat4) -> Object {
    let mesh = Mesh {
        positions: quads.concat().into(),
        triangles: (0..quads.len() as u32)
            .map(|q| q * 4)
            .flat_map(|q| [[q, q + 1, q + 2], [q, q + 2, q + 3]])
            .collect(),
        ..Mesh::default()
    };
    let material = Material { base_color: color, double_sided: true, ..Material::default() };
    let parts = vec![Part { mesh: Arc::new(mesh), material: Arc::new(material) }];
    Object { name: name.into(), transform, parts }
}

/// A vertical wall from (x, z) to (x, z), y from `low` to `high`.
fn wall(from: [f32; 2], to: [f32; 2], low: f32, high: f32) -> [[f32; 3]; 4] {
    [[from[0], low, from[1]], [to[0], low, to[1]], [to[0], high, to[1]], [from[0], high, from[1]]]
}

fn ring(half: f32, height: f32) -> Vec<[[f32; 3]; 4]> {
    let at = [[-half, half], [half, half], [half, -half], [-half, -half]];
    (0..4).map(|i| wall(at[i], at[(i + 1) % 4], -height, height)).collect()
}

/// A closed red box in a blue sleeve that is a little larger, open above and below, with a window in its front.
fn box_in_a_sleeve(gap: f32) -> Scene {
    let turn = Mat4::from_rotation_y(0.5) * Mat4::from_rotation_x(0.15);
    let (inner, outer, window) = (1.0, 1.0 + gap, 0.4);
    let mut closed = ring(inner, 0.9);
    for y in [-0.9, 0.9] {
        closed.push([[-inner, y, -inner], [inner, y, -inner], [inner, y, inner], [-inner, y, inner]]);
    }
    let mut sleeve = ring(outer, 0.85).split_off(1);
    let front = |from: f32, to: f32, low: f32, high: f32| wall([from, outer], [to, outer], low, high);
    sleeve.extend([
        front(-outer, -window, -0.85, 0.85),
        front(window, outer, -0.85, 0.85),
        front(-window, window, -0.85, -window),
        front(-window, window, window, 0.85),
    ]);
    let objects =
        vec![object("box", &closed, [1.0, 0.0, 0.0, 1.0], turn), object("sleeve", &sleeve, [0.0, 0.0, 1.0, 1.0], turn)];
    Scene { objects }
}

/// The picture that the stand-in is made for: pixels along a side, degrees.
const SIDE: u32 = 176;
const FOV: f64 = 24.0;

fn stand_in(scene: &Arc<Scene>, cell: Cell) -> Arc<Scene> {
    let params = render_slices::Params { resolution: SIDE, fov: FOV, ..Default::default() };
    let slices =
        run::<render_slices::RenderSlices>(&params, render_slices::In { scene: scene.clone(), cell: Arc::new(cell) });
    let inputs = voxel_mesh::In { slices: slices.slices.clone(), fields: slices.fields };
    let mut meshes = run::<voxel_mesh::VoxelMeshNode>(&Default::default(), inputs).meshes;
    let charted = meshes.0.drain(..).map(|(name, mesh)| {
        let mesh = run::<voxel_cover::VoxelCover>(&Default::default(), voxel_cover::In { mesh, fitted: None }).mesh;
        let charted: Arc<ChartedMesh> =
            run::<Voxels>(&Params::default(), In { mesh, slices: slices.slices.clone() }).charted;
        (name, charted)
    });
    let meshes = crate::engine::node::List(charted.collect());
    run::<pack_atlas::PackAtlas>(&Default::default(), pack_atlas::In { meshes }).scene
}

fn picture_of(scene: &Scene, eye: DVec3) -> Picture {
    let geometry = Geometry::new(scene);
    let view = View::look_at(eye, DVec3::ZERO, DVec3::Y, FOV.to_radians(), SIDE, SIDE, 0.1, 100.0);
    picture(&Cpu, &Shader::new(&geometry), &view, &Rendering::default(), &Stop::default()).unwrap()
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Seen {
    Box,
    Sleeve,
    Neither,
}

/// What a pixel mostly shows.
fn kinds(picture: &Picture) -> Vec<Seen> {
    let kind = |[r, g, b, _]: [u8; 4]| match (r, g, b) {
        (r, g, b) if r > 128 && g < 90 && b < 90 => Seen::Box,
        (r, g, b) if b > 128 && g < 90 && r < 90 => Seen::Sleeve,
        _ => Seen::Neither,
    };
    picture.texels.iter().map(|p| kind(*p)).collect()
}

/// The inner colour shows through the window and nowhere else, whatever the gap; from the cell's centre and its corners.
#[test]
fn a_hidden_surface_lends_no_colour() {
    let cell = Cell { centre: DVec3::new(0.0, 0.0, 9.0), half: DVec3::ONE };
    // Layers lie about 0.2 m apart there.
    let mut found_wrong = Vec::new();
    for gap in [0.3, 0.5, 0.8] {
        let original = Arc::new(box_in_a_sleeve(gap));
        let stand_in = stand_in(&original, cell);
        for k in 0..9 {
            let sign = |bit: i32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let corner = if k == 8 { DVec3::ZERO } else { DVec3::new(sign(0), sign(1), sign(2)) };
            let [expected, found] =
                [&*original, &*stand_in].map(|s| kinds(&picture_of(s, cell.centre + cell.half * corner)));
            // Pixels farther than the method's bound (3.1 pixels) from every border between what is seen.
            let (mut tested, mut wrong) = ([0; 2], 0);
            let (border, side) = (4, SIDE as usize);
            for y in border..side - border {
                for x in border..side - border {
                    let here = expected[y * side + x];
                    let around = (y - border..=y + border)
                        .all(|v| (x - border..=x + border).all(|u| expected[v * side + u] == here));
                    if here == Seen::Neither || !around {
                        continue;
                    }
                    tested[usize::from(here == Seen::Box)] += 1;
                    wrong += usize::from(found[y * side + x] != here);
                }
            }
            assert!(tested[0] > 2000 && tested[1] > 200, "{tested:?}: both are seen from {corner}");
            if wrong > 0 {
                found_wrong.push(format!("gap {gap}, from {corner}: {wrong} of {tested:?} pixels"));
            }
        }
    }
    assert!(found_wrong.is_empty(), "{found_wrong:#?}");
}
