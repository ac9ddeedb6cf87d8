use super::*;
use std::collections::{BTreeMap, BTreeSet};

fn made(count: u32, detail: f64) -> Scene {
    scatter(&procedural(detail, &[]).unwrap(), &Park { count, ..Park::default() }).unwrap()
}

fn meshes(scene: &Scene) -> usize {
    let parts = scene.objects.iter().flat_map(|o| &o.parts);
    parts.map(|p| Arc::as_ptr(&p.mesh).addr()).collect::<BTreeSet<_>>().len()
}

type Key = [u32; 3];

/// Triangles as corners whose places are one where their bits are.
fn corners(mesh: &Mesh) -> Vec<[Key; 3]> {
    mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize].map(f32::to_bits))).collect()
}

#[test]
fn statues_are_closed_and_every_piece_is_wound_outwards() {
    for detail in [0.25, 0.6, 1.0, 2.5] {
        for kind in procedural(detail, &[]).unwrap() {
            let mesh = &kind.parts[0].mesh;
            let triangles = corners(mesh);
            let mut edges = BTreeMap::<(Key, Key), i32>::new();
            for t in &triangles {
                (0..3).for_each(|k| *edges.entry((t[k], t[(k + 1) % 3])).or_default() += 1);
            }
            let open = edges.iter().filter(|((a, b), n)| edges.get(&(*b, *a)) != Some(n)).count();
            assert_eq!(open, 0, "{} at detail {detail}", kind.name);

            // Pieces that hang together, and the volume of each.
            let mut ids = BTreeMap::new();
            triangles.iter().flatten().for_each(|p| {
                let next = ids.len();
                ids.entry(*p).or_insert(next);
            });
            let mut root: Vec<usize> = (0..ids.len()).collect();
            fn find(root: &mut [usize], mut i: usize) -> usize {
                while root[i] != i {
                    root[i] = root[root[i]];
                    i = root[i];
                }
                i
            }
            for t in &triangles {
                for k in 1..3 {
                    let (a, b) = (find(&mut root, ids[&t[0]]), find(&mut root, ids[&t[k]]));
                    root[a] = b;
                }
            }
            let mut volumes = BTreeMap::<usize, f64>::new();
            for t in &triangles {
                let [a, b, c] = t.map(|p| DVec3::from(p.map(|v| f64::from(f32::from_bits(v)))));
                *volumes.entry(find(&mut root, ids[&t[0]])).or_default() += a.dot(b.cross(c)) / 6.0;
            }
            assert!(volumes.values().all(|v| *v > 0.1), "{} at detail {detail}: {volumes:?}", kind.name);
        }
    }
}

#[test]
fn normals_and_colours_fit_the_surface() {
    for kind in procedural(1.0, &[]).unwrap() {
        let mesh = &kind.parts[0].mesh;
        let n = mesh.positions.len();
        assert_eq!([mesh.normals.len(), mesh.uv[0].len(), mesh.colors.len()], [n; 3]);
        let mut against = 0;
        for t in mesh.triangles.iter() {
            let [a, b, c] = t.map(|i| glam::Vec3::from(mesh.positions[i as usize]));
            let face = (b - a).cross(c - a).normalize_or_zero();
            against += t.iter().filter(|i| face.dot(mesh.normals[**i as usize].into()) < 0.0).count();
        }
        // The thin lip of the vase is a crease with one normal for both of its sides.
        assert!(against * 100 < mesh.triangles.len() * 3, "{}: {against} corners face inwards", kind.name);
        assert!(mesh.normals.iter().all(|n| (glam::Vec3::from(*n).length() - 1.0).abs() < 1e-3));
        let red: BTreeSet<u32> = mesh.colors.iter().map(|c| (c[0] * 255.0) as u32).collect();
        assert!(red.len() > 20, "{}: {} shades", kind.name, red.len());
        assert!(kind.parts[0].material.base_color_texture.is_some());
    }
}

#[test]
fn kinds_differ_and_detail_refines_them() {
    let counts = |detail| -> Vec<usize> {
        procedural(detail, &[]).unwrap().iter().map(|k| k.parts[0].mesh.triangles.len()).collect()
    };
    let usual = counts(1.0);
    assert!(usual.len() >= 5);
    assert_eq!(usual.iter().collect::<BTreeSet<_>>().len(), usual.len(), "{usual:?}");
    assert!(usual.iter().max().unwrap() > &(10 * usual.iter().min().unwrap()), "{usual:?}");
    for (fine, usual) in counts(2.0).iter().zip(&usual) {
        assert!((2.0..4.5).contains(&(*fine as f64 / *usual as f64)), "{usual} and {fine}");
    }
    for detail in [0.0, 0.2, 8.5, f64::NAN, f64::INFINITY] {
        let text = procedural(detail, &[]).unwrap_err().to_string();
        assert_eq!(text, format!("detail {detail}: expected 0.25 to 8"));
    }
}

#[test]
fn a_small_park_is_a_subset_of_a_large_one() {
    let large = made(253, 0.25);
    for count in [1, 64, 132] {
        let small = made(count, 0.25);
        assert_eq!(small.objects.len(), count as usize);
        for object in &small.objects {
            let same = large.objects.iter().find(|o| o.name == object.name).unwrap();
            assert_eq!(same, object);
        }
    }
}

#[test]
fn statues_stand_on_the_ground_inside_of_the_park_without_touching() {
    let scene = made(253, 0.5);
    let bounds = scene.bounds();
    assert!(bounds.min.x >= -825.0 && bounds.max.x <= 825.0 && bounds.min.z >= -1017.5 && bounds.max.z <= 1017.5);
    let boxes: Vec<Aabb> = scene.objects.iter().map(Object::bounds).collect();
    for (i, b) in boxes.iter().enumerate() {
        assert!(b.min.y.abs() < 1e-3 && b.max.y > 5.0, "{}", scene.objects[i].name);
    }
    // Circles around the axes, measured on what was placed.
    let circles: Vec<(DVec3, f64)> = (scene.objects.iter())
        .map(|o| {
            let axis = o.transform.w_axis.truncate().as_dvec3().with_y(0.0);
            let points = Scene { objects: vec![o.clone()] }.points();
            (axis, points.iter().map(|p| (p.with_y(0.0) - axis).length()).fold(0.0, f64::max))
        })
        .collect();
    for (i, (a, r)) in circles.iter().enumerate() {
        assert!(circles[..i].iter().all(|(b, s)| (*a - *b).length() > r + s), "{}", scene.objects[i].name);
    }
    let turns: BTreeSet<u32> = scene.objects.iter().map(|o| o.transform.x_axis.x.to_bits()).collect();
    assert!(turns.len() > 240, "statues look in different directions");
}

#[test]
fn every_kind_is_in_memory_once_and_bytes_repeat() {
    let scene = made(100, 1.0);
    assert_eq!(meshes(&scene), procedural(1.0, &[]).unwrap().len());
    assert_eq!(scene, made(100, 1.0));
    assert_ne!(
        scene,
        scatter(&procedural(1.0, &[]).unwrap(), &Park { count: 100, seed: 2, ..Park::default() }).unwrap()
    );
}

/// Two models that lie somewhere: a tetrahedron without colours, turned and scaled, and one with.
fn models() -> Scene {
    let mesh = Mesh {
        positions: vec![[5.0, 5.0, 5.0], [6.0, 5.0, 5.0], [5.0, 7.0, 5.0], [5.0, 5.0, 6.0]].into(),
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].into(),
        ..Mesh::default()
    };
    let coloured = Mesh { colors: vec![[0.5; 4]; 4].into(), ..mesh.clone() };
    let object = |name: &str, transform, mesh: Mesh| Object {
        name: name.into(),
        transform,
        parts: vec![Part { mesh: Arc::new(mesh), material: Arc::default() }],
    };
    let turned = glam::Mat4::from_scale_rotation_translation(
        glam::Vec3::splat(10.0),
        glam::Quat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        glam::vec3(1.0, 2.0, 3.0),
    );
    Scene { objects: vec![object("b", glam::Mat4::IDENTITY, coloured), object("a", turned, mesh)] }
}

#[test]
fn models_stand_upright_as_given_and_are_painted_where_they_are_bare() {
    let kinds = of_models(&models(), &[3, 1]).unwrap();
    assert_eq!(kinds.iter().map(|k| k.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(kinds[0].parts[0].mesh.colors.len(), 4);
    assert_ne!(kinds[0].parts[0].mesh.colors[0], kinds[0].parts[0].mesh.colors[2]);
    assert_eq!(kinds[1].parts[0].mesh.colors[..], [[0.5; 4]; 4]);
    let scene = scatter(&kinds, &Park { count: 40, ..Park::default() }).unwrap();
    assert_eq!(scene.objects.iter().filter(|o| o.name.starts_with("a.")).count(), 30);
    assert_eq!(meshes(&scene), 2);
    for object in &scene.objects {
        let b = object.bounds();
        let height = if object.name.starts_with("a.") { 20.0 } else { 2.0 };
        assert!(b.min.y.abs() < 1e-4 && (b.max.y - height).abs() < 1e-4, "{}: {b:?}", object.name);
    }
}

#[test]
fn models_that_give_no_park_are_refused() {
    let text = |e: ParkError| e.to_string();
    assert_eq!(
        text(of_models(&Scene::default(), &[]).unwrap_err()),
        "there is no kind of statue: the scene of models has no object with triangles"
    );
    assert_eq!(
        text(of_models(&models(), &[1, 2, 3]).unwrap_err()),
        "3 shares for 2 kinds of statue: expected one for each (a, b), in this order"
    );
    let mut empty = models();
    empty.objects[1].parts.clear();
    assert_eq!(text(of_models(&empty, &[]).unwrap_err()), "kind `a`: it has no triangles");
    let mut thin = models();
    thin.objects[1].transform = glam::Mat4::from_scale(glam::vec3(0.0, 1.0, 0.0));
    assert_eq!(text(of_models(&thin, &[]).unwrap_err()), "kind `a`: it has no width");
    let mut twice = of_models(&models(), &[]).unwrap();
    twice[1].name = "a".into();
    assert_eq!(text(scatter(&twice, &Park::default()).unwrap_err()), "kind `a`: two kinds have this name");
}
