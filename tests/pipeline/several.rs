//! Several outputs for one list port, and batches.

use super::check;
use farfield::engine::plan::Plan;
use serde_json::json;

fn sound(text: &str) -> Plan {
    check(text, &[]).unwrap_or_else(|problems| panic!("{problems}"))
}

/// What is said of a file.
fn wrong(text: &str) -> String {
    check(text, &[]).map(|_| ()).unwrap_err().to_string()
}

fn names(plan: &Plan) -> Vec<&str> {
    plan.nodes.iter().map(|n| n.name.as_str()).collect()
}

const TWO: &str = "
    [nodes.make]\nkind = \"make-scene\"\nseed = 1
    [nodes.cells]\nkind = \"hex-cells\"\nscene = \"make\"
    [nodes.a]\nkind = \"voxel-mesh\"\nscene = \"make\"
    [nodes.b]\nkind = \"voxel-mesh\"\nscene = \"make\"
    [nodes.write]\nkind = \"write-glb\"\nmeshes = { near = \"a\", far = \"b\" }
    [files]\n\"a.glb\" = \"write\"\n";

#[test]
fn a_table_of_outputs_is_one_list() {
    let plan = sound(TWO);
    assert_eq!(names(&plan), ["make", "cells", "a", "b", "write.meshes", "write"]);
    let collect = &plan.nodes[4];
    assert_eq!((collect.kind.spec().name, collect.params.json()), ("collect", &json!({ "words": ["far", "near"] })));
    assert!(collect.axes.is_empty() && collect.inputs.iter().all(|input| input.gathered.len() == 1));
    let write = &plan.nodes[5];
    assert_eq!(write.inputs[0].axes, [write.inputs[0].from.unwrap()], "an axis of its own");
    // Whoever names the node means the node of the file.
    assert!(wrong(&TWO.replace("= \"write\"\n", "= \"write.meshes\"\n")).contains("no output `meshes`"));
}

#[test]
fn what_is_not_gathered_is_not_collected_across_it() {
    let text = "
        [nodes.make]\nkind = \"make-scene\"\nseed = 1
        [nodes.cells]\nkind = \"hex-cells\"\nscene = \"make\"
        [nodes.mesh]\nkind = \"voxel-mesh\"\nscene = \"make\"
        [nodes.pair]\nkind = \"pair\"\nmesh = \"mesh\"\ncell = \"cells\"\ncross = true
        [nodes.write]\nkind = \"write-glb\"\nmeshes = { one = \"pair\", other = \"mesh\" }\nper = [\"cells\"]
        [files]\n\"{name}.glb\" = \"write\"\n";
    let plan = sound(text);
    let cells = plan.nodes.iter().position(|n| n.name == "cells").unwrap();
    for name in ["write.meshes", "write"] {
        let node = plan.nodes.iter().find(|n| n.name == name).unwrap();
        assert!(node.axes.len() == 1 && node.axes[0].node.0 as usize == cells, "{name}");
    }
    let apart = text.replace("per = [\"cells\"]", "").replace("{name}", "a");
    assert!(sound(&apart).nodes.iter().find(|n| n.name == "write").unwrap().axes.is_empty());
}

#[test]
fn mistakes_in_a_table_are_told_where_they_are() {
    let table = |table: &str| wrong(&TWO.replace("{ near = \"a\", far = \"b\" }", table));
    assert!(table("{ near = \"a\", far = \"c\" }").contains("no node `c`"));
    assert!(table("{ near = \"a\", far = \"make\" }").contains("`make.scene` is a"));
    assert!(table("{ near = \"a\", far = 3 }").contains("`far` is a whole number"));
    assert!(table("{ near = \"a\", \"b c\" = \"b\" }").contains("no name for an output"));
    assert!(table("{ form = \"a\" }").contains("did you mean `from`?"));
    assert!(table("{ from = \"a\", far = \"b\" }").contains("unknown key `far`"));
    assert!(table("[\"a\", \"b\"]").contains("several under names of their own"));
    let many: Vec<String> = (0..17).map(|i| format!("n{i} = \"a\"")).collect();
    assert!(table(&format!("{{ {} }}", many.join(", "))).contains("at most 16"));
    // A port of one value takes no table of them.
    assert!(
        wrong(&TWO.replace("kind = \"hex-cells\"\nscene = \"make\"", "kind = \"hex-cells\"\nscene = { a = \"make\" }"))
            .contains("unknown key `a`")
    );
}

const BATCH: &str =
    "[pipeline]\nbase = \"stock\"\n[batch]\nfactor = [2, 3]\n\"collapse.policy\" = [\"voxel-cover\", \"quadric\"]\n";

#[test]
fn a_batch_has_every_combination() {
    let plan = sound(BATCH);
    assert_eq!(plan.rows, ["2-voxel-cover", "2-quadric", "3-voxel-cover", "3-quadric"]);
    assert!(plan.given.is_empty() && plan.name == "test");
    let row = |row| super::check_row(BATCH, &[], row).unwrap_or_else(|problems| panic!("{problems}"));
    let third = row(2);
    assert_eq!(third.name, "test-3-voxel-cover");
    assert_eq!(third.given, [("factor".to_owned(), json!(3)), ("collapse.policy".to_owned(), json!("voxel-cover"))]);
    let collapse = |plan: &Plan| plan.nodes.iter().find(|n| n.name == "collapse").unwrap().params.json().clone();
    assert_eq!((&collapse(&third)["factor"], &collapse(&row(1))["policy"]), (&json!(3.0), &json!("quadric")));
    // An argument stands over all rows.
    let set = super::check_row(BATCH, &["factor=7"], 0).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(collapse(&set)["factor"], json!(7.0));
}

#[test]
fn rows_one_by_one_have_names() {
    let text = "[pipeline]\nbase = \"stock\"\n[[batch]]\nname = \"fine\"\nfactor = 1.5\n[[batch]]\nfactor = 4\n[[batch]]\nfactor = 4\n";
    assert_eq!(sound(text).rows, ["fine", "4", "4-2"]);
    let path = "[pipeline]\nbase = \"stock\"\n[[batch]]\n\"collapse.label\" = \"models/Big Car.glb\"\n";
    assert_eq!(sound(path).rows, ["Big-Car"]);
}

#[test]
fn mistakes_in_a_batch() {
    let batch = |batch: &str| wrong(&format!("[pipeline]\nbase = \"stock\"\n{batch}"));
    assert!(batch("[batch]\nfactor = 2\n").contains("expected a list of values"));
    assert!(batch("[batch]\nfactor = []\n").contains("expected a list of values"));
    assert!(batch("[batch]\n").contains("has no values"));
    assert!(batch("[[batch]]\nname = \"a b\"\n").contains("the name of a row"));
    assert!(batch("[[batch]]\nname = \"a\"\n[[batch]]\nname = \"A\"\n").contains("two rows"));
    let many = (0..101).map(|i| i.to_string()).collect::<Vec<_>>().join(", ");
    assert!(
        batch(&format!("[batch]\nfactor = [{many}]\n\"collapse.max_layers\" = [{many}]\n")).contains("more than 10000")
    );
    let row = |text: &str| {
        super::check_row(&format!("[pipeline]\nbase = \"stock\"\n{text}"), &[], 0).map(|_| ()).unwrap_err().to_string()
    };
    assert!(row("[batch]\nfctor = [2]\n").contains("[batch]: no knob `fctor`"));
    assert!(row("[batch]\n\"colapse.factor\" = [2]\n").contains("[batch]: no node `colapse`"));
    assert!(row("[batch]\nfactor = [\"many\"]\n").contains("factor"));
}
