//! What a sound file means.

use super::check;
use farfield::engine::plan::{Axis, NodeId, OutputRef, Plan, PlanNode};
use serde_json::json;

fn sound(text: &str, set: &[&str]) -> Plan {
    check(text, set).unwrap_or_else(|problems| panic!("{problems}"))
}

fn node<'a>(plan: &'a Plan, name: &str) -> &'a PlanNode {
    plan.nodes.iter().find(|n| n.name == name).unwrap()
}

fn output(plan: &Plan, name: &str, port: u32) -> OutputRef {
    OutputRef { node: NodeId(plan.nodes.iter().position(|n| n.name == name).unwrap() as u32), port }
}

const BASE: &str = "[pipeline]\nbase = \"stock\"\n";

#[test]
fn a_stock_pipeline_is_mapped_and_gathered() {
    let plan = sound(BASE, &[]);
    assert_eq!(plan.name, "test", "a derived pipeline is named after its file");
    let meshes: Vec<Axis> = vec![output(&plan, "mesh", 0)];
    assert!(node(&plan, "mesh").axes.is_empty());
    assert_eq!(node(&plan, "collapse").axes, meshes);
    assert_eq!(node(&plan, "collapse").inputs[0].from, Some(meshes[0]));
    assert_eq!(node(&plan, "collapse").inputs[1].from, None);
    let write = node(&plan, "write");
    assert!(write.axes.is_empty());
    assert_eq!((&write.inputs[0].axes, &write.inputs[0].gathered), (&meshes, &meshes));
    assert_eq!(plan.files.iter().map(|f| f.path.as_str()).collect::<Vec<_>>(), ["a.glb", "{name}.png"]);
    assert_eq!(plan.files[0].from, output(&plan, "write", 0));
    let require = &plan.require[0];
    assert_eq!((require.path.as_str(), require.min, require.max), ("crack_px.total", None, Some(0.0)));
    assert_eq!(require.from, output(&plan, "write", 1));
}

#[test]
fn parameters_get_defaults_knobs_and_settings() {
    let factor = |text: &str, set: &[&str]| node(&sound(text, set), "collapse").params.json()["factor"].clone();
    assert_eq!(factor(BASE, &[]), json!(2.0));
    assert_eq!(factor(&format!("{BASE}[params]\nfactor = 3"), &[]), json!(3.0), "an integer is a number");
    assert_eq!(factor(&format!("{BASE}[nodes.collapse]\nfactor = 1.5"), &[]), json!(1.5));
    assert_eq!(factor(BASE, &["factor=4"]), json!(4.0));
    assert_eq!(factor(BASE, &["factor=4", "collapse.factor=5"]), json!(5.0));
    assert_eq!(factor(BASE, &["factor=4", "factor=6"]), json!(6.0), "the last counts");
    let params = |set: &[&str]| node(&sound(BASE, set), "collapse").params.json().clone();
    let p = params(&["collapse.policy=quadric"]);
    assert_eq!((&p["policy"], &p["max_layers"]), (&json!("quadric"), &json!(100)));
    let p = params(&["collapse.label=2024", "collapse.limits={angle=3}"]);
    assert_eq!((&p["label"], &p["limits"]), (&json!("2024"), &json!({ "angle": 3.0 })));
    let p = params(&["collapse.max_layers=0x1_0", "collapse.centre=[1, 2.5, -3e2]"]);
    assert_eq!((&p["max_layers"], &p["centre"]), (&json!(16), &json!([1.0, 2.5, -300.0])));
}

#[test]
fn source_paths_start_from_the_file_that_names_them() {
    let path =
        |text: &str, set: &[&str]| node(&sound(text, set), "load").params.json()["path"].as_str().unwrap().to_owned();
    assert_eq!(path(BASE, &[]), "builtin:city");
    let found = path(&format!("{BASE}[params]\nscene = \"town.glb\""), &[]);
    assert!(std::path::Path::new(&found).is_absolute() && found.ends_with("town.glb"), "{found}");
    assert_eq!(path(BASE, &["scene=town.glb"]), found, "an argument needs no quotes");
    assert_eq!(path(BASE, &["scene=\"town.glb\""]), found);

    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("part")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("part/ship.glb", "x");
    write("part/ship.toml", "[pipeline]\nbase = \"stock\"\n[params]\nscene = \"ship.glb\"");
    write("mine.toml", "[pipeline]\nname = \"mine\"\nbase = \"part/ship.toml\"\n[nodes.collapse]\nfactor = 3");
    let request = farfield::engine::pipeline::Request::new("mine.toml", folder.path(), super::STOCK);
    let plan = farfield::engine::pipeline::load(&request, &super::kinds::registry()).unwrap_or_else(|p| panic!("{p}"));
    assert_eq!(plan.name, "mine");
    assert!(node(&plan, "load").params.json()["path"].as_str().unwrap().ends_with("ship.glb"));
    assert_eq!(node(&plan, "collapse").params.json()["factor"], json!(3.0));
}

#[test]
fn a_base_can_lose_parts() {
    let plan = sound(
        "[pipeline]\nbase = \"stock\"\n[nodes]\nwrite = false\n[files]\n\"a.glb\" = false\n[require]\nwrite = false",
        &[],
    );
    assert_eq!(plan.nodes.iter().map(|n| n.name.as_str()).collect::<Vec<_>>(), ["load", "mesh", "collapse"]);
    assert_eq!((plan.files.len(), plan.require.len()), (1, 0));
}

#[test]
fn a_changed_kind_replaces_the_node() {
    let text = "[pipeline]\nbase = \"stock\"\n[nodes.load]\nkind = \"make-scene\"\nseed = 18446744073709551615";
    let plan = sound(text, &[]);
    assert_eq!(*node(&plan, "load").params.json(), json!({ "seed": u64::MAX }));
}

#[test]
fn nodes_follow_what_they_read_and_else_the_file() {
    let text = "
        [nodes.z]\nkind = \"make-scene\"\nseed = 1
        [nodes.w]\nkind = \"voxel-mesh\"\nscene = \"a\"
        [nodes.a]\nkind = \"make-scene\"\nseed = 1
        [nodes.b]\nkind = \"make-scene\"\nseed = 1";
    let names: Vec<String> = sound(text, &[]).nodes.into_iter().map(|n| n.name).collect();
    assert_eq!(names, ["z", "a", "w", "b"]);
}

const LISTS: &str = "
    [nodes.load]\nkind = \"make-scene\"\nseed = 1
    [nodes.cells]\nkind = \"hex-cells\"\nscene = \"load\"
    [nodes.mesh]\nkind = \"voxel-mesh\"\nscene = \"load\"
    [nodes.pair]\nkind = \"pair\"\nmesh = \"mesh\"\ncell = \"cells\"\ncross = true\n";

#[test]
fn crossed_lists_give_both_axes_in_the_order_of_the_ports() {
    let plan = sound(LISTS, &[]);
    assert_eq!(node(&plan, "pair").axes, [output(&plan, "mesh", 0), output(&plan, "cells", 0)]);
}

#[test]
fn shared_axes_join_and_fewer_axes_repeat() {
    let plan = sound(
        &format!("{LISTS}[nodes.again]\nkind = \"pair\"\nmesh = \"pair\"\ncell = \"cells\"\njoin = \"inner\""),
        &[],
    );
    let again = node(&plan, "again");
    assert_eq!(again.axes, [output(&plan, "mesh", 0), output(&plan, "cells", 0)]);
    assert!(again.join_inner && !node(&plan, "pair").join_inner);
    assert_eq!(again.inputs[1].axes, [output(&plan, "cells", 0)]);
}

#[test]
fn a_transient_node_says_so_and_changes_no_key() {
    let text = LISTS.replace("kind = \"voxel-mesh\"", "kind = \"voxel-mesh\"\ntransient = true");
    let (plan, kept) = (sound(&text, &[]), sound(LISTS, &[]));
    assert!(node(&plan, "mesh").transient && !node(&plan, "pair").transient && !node(&kept, "mesh").transient);
    assert_eq!(node(&plan, "mesh").params.json(), node(&kept, "mesh").params.json());
    assert!(!node(&sound(LISTS, &["mesh.transient=false"]), "mesh").transient);
}

#[test]
fn per_keeps_an_axis_from_being_gathered() {
    let plan = sound(&format!("{LISTS}[nodes.write]\nkind = \"write-glb\"\nmeshes = \"pair\"\nper = [\"cells\"]"), &[]);
    let (cells, meshes) = (output(&plan, "cells", 0), output(&plan, "mesh", 0));
    let write = node(&plan, "write");
    assert_eq!(write.axes, [cells]);
    assert_eq!(write.inputs[0].axes, [meshes, cells]);
    assert_eq!(write.inputs[0].gathered, [meshes]);
}

#[test]
fn a_list_made_by_a_mapped_node_has_both_axes() {
    let text = "
        [nodes.load]\nkind = \"make-scene\"\nseed = 1
        [nodes.mesh]\nkind = \"voxel-mesh\"\nscene = \"load\"
        [nodes.write]\nkind = \"write-glb\"\nmeshes = \"collapse\"
        [nodes.collapse]\nkind = \"collapse\"\nmesh = \"mesh\"";
    let plan = sound(text, &[]);
    assert_eq!(node(&plan, "write").inputs[0].gathered, [output(&plan, "mesh", 0)]);
}

#[test]
fn a_relation_picks_among_the_elements() {
    let text = "
        [nodes.load]\nkind = \"make-scene\"\nseed = 1
        [nodes.cells]\nkind = \"hex-cells\"\nscene = \"load\"
        [nodes.one]\nkind = \"single-mesh\"
        [nodes.capture]\nkind = \"pair\"\ncell = \"cells\"\nmesh = \"one\"
        [nodes.blend]\nkind = \"neighbours\"\ncell = \"cells\"
        meshes = { from = \"capture\", via = \"cells.neighbours\" }";
    let plan = sound(text, &[]);
    let (cells, blend) = (output(&plan, "cells", 0), node(&plan, "blend"));
    assert_eq!(blend.axes, [cells]);
    assert_eq!(blend.inputs[1].via, Some(output(&plan, "cells", 1)));
    assert_eq!((&blend.inputs[1].axes, &blend.inputs[1].gathered), (&vec![cells], &vec![cells]));
}

const METHODS: &str = "[params]\nangle = 20\n[nodes.load]\nkind = \"load-scene\"\npath = \"builtin:city\"\n[nodes.mesh]\n\
                       kind = \"voxel-mesh\"\nscene = \"load\"\n[nodes.simple]\nkind = \"simplify\"\nmethod = \"sharp\"\n\
                       mesh = \"mesh\"\nangle = \"{angle}\"\nfactor = 3\n";

#[test]
fn kind_and_method_name_a_type_together() {
    let spec = |set: &[&str]| node(&sound(METHODS, set), "simple").kind.spec().title();
    assert_eq!(spec(&[]), "simplify sharp");
    assert_eq!(spec(&["simple.method=smooth"]), "simplify smooth");
    let only = METHODS.replace("kind = \"simplify\"\nmethod = \"sharp\"", "kind = \"bend\"");
    let only = only.replace("angle = \"{angle}\"\nfactor = 3\n", "").replace("angle = 20\n", "");
    assert_eq!(node(&sound(&only, &[]), "simple").kind.spec().title(), "bend round", "the only method needs no name");
    let named = only.replace("kind = \"bend\"", "kind = \"bend\"\nmethod = \"round\"");
    assert_eq!(node(&sound(&named, &[]), "simple").kind.spec().title(), "bend round");
}

#[test]
fn another_method_keeps_the_keys_that_it_has() {
    let params = |set: &[&str]| node(&sound(METHODS, set), "simple").params.json().clone();
    assert_eq!(params(&[]), json!({ "angle": 20.0, "factor": 3.0 }));
    assert_eq!(params(&["simple.method=smooth"]), json!({ "factor": 3.0 }));
    assert_eq!(params(&["simple.factor=4", "simple.method=smooth"]), json!({ "factor": 4.0 }));
    // Nothing is dropped of what is said for the new method, in whatever order.
    for set in [["simple.method=smooth", "simple.angle=1"], ["simple.angle=1", "simple.method=smooth"]] {
        let problems = check(METHODS, &set).err().unwrap();
        assert_eq!(problems.list[0].message, "method `smooth` of `simplify` has no `angle`");
    }
    let problems = check(METHODS, &["simple.method=sharp", "simple.kind=collapse"]).err().unwrap();
    assert_eq!(problems.list[0].message, "node `simple` has no `mesh`", "another kind loses every key");

    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("base.toml", METHODS);
    write("mine.toml", "[pipeline]\nbase = \"base.toml\"\n[nodes.simple]\nmethod = \"smooth\"\nfactor = 5\n");
    let request = farfield::engine::pipeline::Request::new("mine.toml", folder.path(), &[]);
    let plan = farfield::engine::pipeline::load(&request, &super::kinds::registry()).unwrap_or_else(|p| panic!("{p}"));
    assert_eq!(*node(&plan, "simple").params.json(), json!({ "factor": 5.0 }));
}
