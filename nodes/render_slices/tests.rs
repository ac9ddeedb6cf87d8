use super::*;
use crate::{
    engine::artifact::to_bytes,
    nodes::testing::{self, refused},
    scene::{Material, Mesh, Object, Part},
};
use glam::{DVec3, Mat4, Vec3};

/// A box as an object.
fn cuboid(name: &str, min: [f32; 3], max: [f32; 3]) -> Object {
    let at = |i: u32, k: usize| if i >> k & 1 == 0 { min[k] } else { max[k] };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mesh = Mesh {
        positions: (0..8).map(|i| [at(i, 0), at(i, 1), at(i, 2)]).collect(),
        triangles: quads.iter().flat_map(|[i, j, k, l]| [[*i, *j, *k], [*i, *k, *l]]).collect(),
        ..Mesh::default()
    };
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(Material::default()) };
    Object { name: name.into(), transform: Mat4::IDENTITY, parts: vec![part] }
}

fn scene(objects: Vec<Object>) -> Arc<Scene> {
    Arc::new(Scene { objects })
}

const CELL: Cell = Cell { centre: DVec3::ZERO, half: DVec3::splat(0.5) };

fn run(params: &Params, scene: &Arc<Scene>) -> (Result<Out, NodeError>, Vec<String>) {
    testing::run::<RenderSlices>(params, In { scene: scene.clone(), cell: Arc::new(CELL) })
}

fn small() -> Params {
    Params { resolution: 96, ..Params::default() }
}

fn error(scene: &Arc<Scene>) -> String {
    run(&small(), scene).0.err().unwrap().to_string()
}

fn seen(out: &Out) -> Vec<String> {
    let mut names: Vec<_> = out.fields.0.iter().flat_map(|(_, f)| f.objects.clone()).collect();
    names.sort();
    names.dedup();
    names
}

#[test]
fn a_hidden_object_changes_no_byte() {
    let around = |hidden: Option<Vec3>| {
        // A wall, oblique so that it crosses many layers, and something far behind that bounds the selection.
        let mut wall = cuboid("wall", [-2.0, -2.0, -0.1], [2.0, 2.0, 0.1]);
        wall.transform = Mat4::from_translation(Vec3::new(0.0, 0.0, -5.0)) * Mat4::from_rotation_y(0.7);
        let mut objects = vec![cuboid("far", [-6.0, -3.0, -20.3], [6.0, 3.0, -20.2]), wall];
        if let Some(at) = hidden {
            let mut object = cuboid("hidden", [-0.2; 3], [0.2; 3]);
            object.transform = Mat4::from_translation(at);
            objects.insert(1, object);
        }
        let out = run(&small(), &scene(objects)).0.unwrap();
        let fields: Vec<_> = out.fields.0.iter().map(|(name, f)| (name.clone(), to_bytes(&**f))).collect();
        (seen(&out), to_bytes(&*out.slices), fields)
    };
    let without = around(None);
    assert_eq!(without.0, ["far", "wall"]);
    for at in [Vec3::new(0.0, 0.0, -8.0), Vec3::new(0.3, -0.2, -7.5), Vec3::new(-0.4, 0.3, -9.0)] {
        assert!(around(Some(at)) == without, "{at}");
    }
    // The same object beside the wall is seen.
    assert_eq!(around(Some(Vec3::new(3.5, 0.0, -8.0))).0, ["far", "hidden", "wall"]);
}

#[test]
fn nothing_shows_through_the_seams_of_a_room() {
    let room = |shell: bool| {
        let mut objects = vec![cuboid("room", [-3.0, -2.0, -2.5], [3.5, 2.2, 3.1])];
        if shell {
            objects.insert(0, cuboid("beyond", [-9.0; 3], [9.0; 3]));
        }
        run(&Params { resolution: 48, ..Params::default() }, &scene(objects)).0.unwrap()
    };
    let out = room(true);
    assert_eq!(out.fields.0.iter().map(|(n, _)| n.as_str()).collect::<Vec<_>>(), ["+x", "+y", "+z", "-x", "-y", "-z"]);
    assert_eq!(seen(&out), ["room"]);
    for ((_, field), f) in out.fields.0.iter().zip(&out.slices.frusta) {
        // Every pixel of every face looks at a wall.
        let mut columns: Vec<_> = field.voxels.iter().map(|v| (v.y, v.x)).collect();
        columns.sort_unstable();
        columns.dedup();
        assert_eq!(columns.len() as u32, f.size[0] * f.size[1]);
    }
}

#[test]
fn what_is_too_near_stays_geometry() {
    let objects = vec![
        cuboid("far", [-1.0, -1.0, -9.0], [1.0, 1.0, -8.0]),
        cuboid("floor", [-0.6, -0.7, -6.0], [0.6, -0.6, -0.1]),
        cuboid("near", [-0.2, -0.2, -0.7], [0.2, 0.2, -0.6]),
    ];
    let (out, warnings) = run(&small(), &scene(objects));
    let out = out.unwrap();
    assert_eq!(
        out.near.objects.iter().map(|o| (o.name.as_str(), o.triangle_count() > 0)).collect::<Vec<_>>(),
        [("floor", true), ("near", true)]
    );
    assert_eq!(out.near.objects[1].triangle_count(), 12);
    assert!(warnings.len() == 1 && warnings[0].contains("2 objects stay geometry"), "{warnings:?}");
    // The floor goes on as voxels; the near box is geometry only.
    assert_eq!(seen(&out), ["far", "floor"]);

    let few = Params { max_layers: 4, ..small() };
    let out = run(&few, &scene(vec![cuboid("deep", [-1.0, -1.0, -30.0], [1.0, 1.0, -3.0])])).0.unwrap();
    assert!(out.slices.layers.len() <= 4 && out.near.triangle_count() > 0);
}

#[test]
fn nothing_too_near_means_no_near_objects() {
    let (out, warnings) = run(&small(), &scene(vec![cuboid("far", [-1.0, -1.0, -9.0], [1.0, 1.0, -8.0])]));
    assert_eq!((out.unwrap().near.objects.len(), warnings.len()), (0, 0));
}

#[test]
fn mistakes_are_named() {
    let crossing = scene(vec![
        cuboid("crate", [0.3, 0.3, -2.0], [1.0, 1.0, 1.0]),
        cuboid("far", [-1.0; 3].map(|c: f32| c - 9.0), [-9.0; 3]),
    ]);
    let message = error(&crossing);
    assert!(message.contains("intersects the view cell") && message.contains("`crate`") && !message.contains("`far`"));
    assert!(error(&scene(vec![])).contains("no triangles"));
    assert!(error(&scene(vec![cuboid("near", [-0.2, -0.2, -0.7], [0.2, 0.2, -0.6])])).contains("would be empty"));
    let speck = cuboid("speck", [0.0, 0.0, -500.0], [1e-4, 1e-4, -499.9999]);
    assert!(error(&scene(vec![speck])).contains("no sample of any layer is covered"));
}

#[test]
fn ranges_of_parameters() {
    let bad = [
        (Params { resolution: 0, ..small() }, "resolution"),
        (Params { fov: 180.0, ..small() }, "fov"),
        (Params { fov: f64::NAN, ..small() }, ""),
        (Params { skirt: 9, ..small() }, "skirt"),
        (Params { samples: 2, ..small() }, "samples"),
        (Params { max_layers: 0, ..small() }, "max_layers"),
        (Params { max_layers: 70000, ..small() }, "max_layers"),
    ];
    for (params, name) in bad {
        assert_eq!(refused::<RenderSlices>(&params).as_deref(), Some(name));
    }
    assert_eq!(refused::<RenderSlices>(&small()), None);
}

/// The object with one side: its front, or what was its back.
fn one_sided(mut object: Object, inward: bool) -> Object {
    for part in &mut object.parts {
        let mut mesh = (*part.mesh).clone();
        if inward {
            mesh.triangles = mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        }
        part.mesh = Arc::new(mesh);
        part.material = Arc::new(Material { double_sided: false, ..Material::default() });
    }
    object
}

#[test]
fn the_near_wall_of_a_room_is_not_there_where_it_shows_its_back() {
    let lamp = || cuboid("lamp", [-0.3, -0.3, -7.3], [0.3, 0.3, -6.7]);
    let room = || cuboid("room", [-2.0, -2.0, -9.0], [2.0, 2.0, -5.0]);
    let names = |room: Object| seen(&run(&small(), &scene(vec![lamp(), room])).0.unwrap());
    assert_eq!(names(room()), ["room"], "two-sided");
    assert_eq!(names(one_sided(room(), false)), ["room"], "a box from outside");
    assert_eq!(names(one_sided(room(), true)), ["lamp", "room"], "a room from outside");
    // A mirroring transform leaves insides inside.
    let mirrored =
        |inward| Object { transform: Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)), ..one_sided(room(), inward) };
    assert_eq!(names(mirrored(true)), ["lamp", "room"]);
    assert_eq!(names(mirrored(false)), ["room"]);
}

#[test]
fn a_back_stays_where_some_of_the_cell_sees_the_front() {
    // A sheet beside the line of sight that faces +X; the cell reaches to x = 0.5.
    let sheet = |x: f32| {
        let mut sheet = one_sided(cuboid("sheet", [x, -1.0, -7.0], [x, 1.0, -4.0]), false);
        let mesh = (*sheet.parts[0].mesh).clone();
        sheet.parts[0].mesh = Arc::new(Mesh { triangles: mesh.triangles[2..4].to_vec().into(), ..mesh });
        sheet
    };
    let names = |x: f32| {
        seen(&run(&small(), &scene(vec![cuboid("wall", [-4.0, -3.0, -9.1], [4.0, 3.0, -9.0]), sheet(x)])).0.unwrap())
    };
    assert_eq!(names(0.3), ["sheet", "wall"]);
    assert_eq!(names(0.7), ["wall"]);
    assert_eq!(names(-0.7), ["sheet", "wall"], "faces the cell");
}
