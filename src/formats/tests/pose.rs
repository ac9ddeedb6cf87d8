//! glTF: skins, morph targets, instances, visibility.

use super::{document::Document, *};
use glam::{Vec3, vec3};
use serde_json::json;

fn near(found: &[Vec3], expect: &[[f32; 3]]) {
    let close = found.len() == expect.len() && found.iter().zip(expect).all(|(a, b)| a.abs_diff_eq((*b).into(), 1e-5));
    assert!(close, "{found:?} {expect:?}");
}

/// The triangle bound to two joints, of which the second is turned by a quarter about Z and moved; the node itself stands elsewhere.
pub(super) fn skinned(component: u64) -> Document {
    let mut d = Document::triangle();
    let joints = match component {
        5121 => d.accessor("VEC4", 5121, &[[0u8, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]]),
        _ => d.accessor("VEC4", 5123, &[[0u16, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]]),
    };
    let weights = match component {
        5126 => d.floats("VEC4", &[[1.0f32, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]]),
        5121 => d.accessor("VEC4", 5121, &[[255u8, 0, 0, 0], [255, 0, 0, 0], [100, 100, 0, 0]]),
        _ => d.accessor("VEC4", 5123, &[[65535u16, 0, 0, 0], [65535, 0, 0, 0], [4000, 4000, 0, 0]]),
    };
    let normals = d.floats("VEC3", &[[0.0f32, 0.0, 1.0]; 3]);
    let p = d.primitive();
    (p["attributes"]["JOINTS_0"], p["attributes"]["WEIGHTS_0"]) = (json!(joints), json!(weights));
    p["attributes"]["NORMAL"] = json!(normals);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    d.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
        { "children": [2], "translation": [0, 0, 5] },
        { "translation": [10, 0, 0], "rotation": [0, 0, half, half] },
    ]);
    d.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    d.json["skins"] = json!([{ "joints": [1, 2] }]);
    d
}

#[test]
fn skins_bend_by_their_joints_own_place() {
    // Without inverse bind matrices: joint 1 moves by (0, 0, 5); joint 2 turns (x, y) to (−y, x) and moves by (10, 0, 5).
    for component in [5126, 5121, 5123] {
        let scene = skinned(component).scene();
        near(&document::corners(&scene, 0), &[[0.0, 0.0, 5.0], [10.0, 1.0, 5.0], [4.0, 1.0, 5.0]]);
        assert_eq!(scene.objects[0].transform, Mat4::IDENTITY);
        assert!(scene.objects[0].parts[0].mesh.normals.iter().all(|n| Vec3::from(*n).abs_diff_eq(Vec3::Z, 1e-6)));
    }
    let mut d = skinned(5126);
    // The bind pose stood at (1, 2, 3) and was twice as large.
    let inverse = (Mat4::from_translation(vec3(1.0, 2.0, 3.0)) * Mat4::from_scale(Vec3::splat(2.0))).inverse();
    let matrices = d.floats("MAT4", &[Mat4::IDENTITY.to_cols_array(), inverse.to_cols_array()]);
    d.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    near(&d.corners()[1..2], &[[11.0, 0.0, 3.5]]);
}

#[test]
fn a_second_set_of_joints_counts() {
    let mut d = skinned(5126);
    let joints = d.accessor("VEC4", 5121, &[[1u8, 0, 0, 0]; 3]);
    let weights = d.floats("VEC4", &[[1.0f32, 0.0, 0.0, 0.0], [0.0; 4], [1.0, 0.0, 0.0, 0.0]]);
    let p = d.primitive();
    (p["attributes"]["JOINTS_1"], p["attributes"]["WEIGHTS_1"]) = (json!(joints), json!(weights));
    // Weights are shares of their sum.
    near(&d.corners(), &[[5.0, 0.0, 5.0], [10.0, 1.0, 5.0], [6.0, 0.5, 5.0]]);
}

#[test]
fn a_mirroring_node_turns_the_triangles_of_its_skinned_mesh_round() {
    let mut d = skinned(5126);
    assert_eq!(d.scene().objects[0].parts[0].mesh.triangles[..], [[0, 1, 2]]);
    d.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    assert_eq!(d.scene().objects[0].parts[0].mesh.triangles[..], [[0, 2, 1]]);
}

#[test]
fn what_is_odd_in_a_skin_is_said() {
    // No weights: the vertex follows its first joint.
    let mut d = skinned(5126);
    let none = d.floats("VEC4", &[[0.0f32; 4]; 3]);
    d.primitive()["attributes"]["WEIGHTS_0"] = json!(none);
    near(&d.corners(), &[[0.0, 0.0, 5.0], [10.0, 1.0, 5.0], [0.0, 2.0, 5.0]]);
    // No joints: the primitive stands where its node does.
    let mut d = skinned(5126);
    d.primitive()["attributes"].as_object_mut().unwrap().remove("JOINTS_0");
    let (scene, warnings) = d.load();
    near(&document::corners(&scene.unwrap(), 0)[..1], &[[100.0, 0.0, 0.0]]);
    assert_eq!(warnings, ["a.glb: mesh 0 `m`, primitive 0: has a skin but no joints; it stands where its node does"]);
    // Joints that the skin lacks.
    let mut d = skinned(5126);
    d.json["skins"][0]["joints"] = json!([1]);
    let (scene, warnings) = d.load();
    assert!(scene.is_ok());
    assert_eq!(warnings, ["a.glb: mesh 0 `m`, primitive 0: 2 vertices are bound to joints that the skin lacks"]);
    for (skins, error) in [
        (json!([]), "a.glb: skins[0]: does not exist; there are 0"),
        (json!([{ "joints": [9] }]), "a.glb: skins[0]: joint 9 does not exist, or lies too deep"),
    ] {
        d.json["skins"] = skins;
        assert_eq!(d.load().0.unwrap_err().to_string(), error);
    }
}

/// Two targets: one lifts the corners, the other (sparse, with nothing else stored) moves one of them.
pub(super) fn morphing() -> Document {
    let mut d = Document::triangle();
    let lift = d.floats("VEC3", &[[0.0f32, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 3.0]]);
    let (at, by) = (d.view(&[1u8]), d.view(bytemuck::cast_slice(&[4.0f32, 0.0, 0.0])));
    let sparse = d.push(
        "accessors",
        json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {
            "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": by } } }),
    );
    let uv = d.floats("VEC2", &[[0.5f32, 0.5]; 3]);
    d.primitive()["targets"] = json!([{ "POSITION": lift, "TEXCOORD_0": uv }, { "POSITION": sparse }]);
    d
}

#[test]
fn morph_weights_of_node_and_mesh_are_the_pose() {
    let mut d = morphing();
    near(&d.corners(), &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    d.json["meshes"][0]["weights"] = json!([1.0, 0.5]);
    near(&d.corners(), &[[0.0, 0.0, 1.0], [3.0, 0.0, 2.0], [0.0, 2.0, 3.0]]);
    assert_eq!(d.scene().objects[0].parts[0].mesh.uv[0][0], [0.5, 0.5]);
    // The node's own go before; missing ones are 0.
    d.json["nodes"][0]["weights"] = json!([2.0]);
    near(&d.corners(), &[[0.0, 0.0, 2.0], [1.0, 0.0, 4.0], [0.0, 2.0, 6.0]]);
    // Nodes with different weights have different meshes.
    d.json["nodes"] = json!([{ "mesh": 0, "name": "a", "weights": [0.0, 1.0] }, { "mesh": 0, "name": "b" }]);
    let scene = d.scene();
    near(&document::corners(&scene, 0)[1..2], &[[5.0, 0.0, 0.0]]);
    near(&document::corners(&scene, 1)[1..2], &[[3.0, 0.0, 2.0]]);
}

#[test]
fn morphs_come_before_skins() {
    let mut d = skinned(5126);
    let lift = d.floats("VEC3", &[[0.0f32; 3], [1.0, 0.0, 0.0], [0.0; 3]]);
    d.primitive()["targets"] = json!([{ "POSITION": lift }]);
    d.json["meshes"][0]["weights"] = json!([1.0]);
    near(&d.corners()[1..2], &[[10.0, 2.0, 5.0]]);
}

#[test]
fn instances_stand_where_their_rows_say() {
    let mut d = Document::triangle();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let t = d.floats("VEC3", &[[1.0f32, 0.0, 0.0], [0.0, 10.0, 0.0]]);
    let r = d.accessor("VEC4", 5122, &[[0i16, 0, 0, 32767], [0, 0, (half * 32767.0) as i16, (half * 32767.0) as i16]]);
    let s = d.floats("VEC3", &[[1.0f32, 1.0, 1.0], [2.0, 2.0, 2.0]]);
    d.json["accessors"][r]["normalized"] = json!(true);
    d.json["nodes"][0]["translation"] = json!([0, 0, 7]);
    let attributes = json!({ "TRANSLATION": t, "ROTATION": r, "SCALE": s, "_ID": t });
    d.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    d.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = d.scene();
    assert_eq!(scene.objects.iter().map(|o| &o.name[..]).collect::<Vec<_>>(), ["n/0", "n/1"]);
    near(&document::corners(&scene, 0), &[[1.0, 0.0, 7.0], [2.0, 0.0, 7.0], [1.0, 2.0, 7.0]]);
    near(&document::corners(&scene, 1), &[[0.0, 10.0, 7.0], [0.0, 12.0, 7.0], [-4.0, 10.0, 7.0]]);
    assert!(Arc::ptr_eq(&scene.objects[0].parts[0].mesh, &scene.objects[1].parts[0].mesh));
    d.json["accessors"][s]["count"] = json!(1);
    let error = d.load().0.unwrap_err().to_string();
    assert!(error.ends_with("EXT_mesh_gpu_instancing: its accessors have different numbers of elements"), "{error}");
    for a in [t, r, s] {
        d.json["accessors"][a]["count"] = json!(1u64 << 40);
    }
    let error = d.load().0.unwrap_err().to_string();
    assert!(error.ends_with("1099511627776 instances; the limit is 1024"), "{error}");
}

#[test]
fn hidden_nodes_are_left_out() {
    let mut d = Document::triangle();
    d.json["nodes"] = json!([
        { "mesh": 0, "name": "a" },
        { "name": "b", "children": [2], "extensions": { "KHR_node_visibility": { "visible": false } } },
        { "mesh": 0, "name": "c" },
    ]);
    let (scene, warnings) = d.load();
    assert_eq!(scene.unwrap().objects.len(), 1);
    assert_eq!(warnings, ["a.glb: nodes[1]: is marked as not visible; left out with all below it"]);
}
