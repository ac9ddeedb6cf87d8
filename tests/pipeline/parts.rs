//! Pipelines in the place of nodes.

use super::check;
use farfield::engine::plan::{NodeId, OutputRef, Plan, PlanNode};
use serde_json::{Value, json};

fn sound(text: &str, set: &[&str]) -> Plan {
    check(text, set).unwrap_or_else(|problems| panic!("{problems}"))
}

fn node<'a>(plan: &'a Plan, name: &str) -> &'a PlanNode {
    plan.nodes.iter().find(|n| n.name == name).unwrap_or_else(|| panic!("{name}: {:?}", names(plan)))
}

fn output(plan: &Plan, name: &str, port: u32) -> OutputRef {
    OutputRef { node: NodeId(plan.nodes.iter().position(|n| n.name == name).unwrap() as u32), port }
}

fn names(plan: &Plan) -> Vec<&str> {
    plan.nodes.iter().map(|n| n.name.as_str()).collect()
}

fn param(plan: &Plan, name: &str, param: &str) -> Value {
    node(plan, name).params.json()[param].clone()
}

/// The files of a part are not published, and what only they need is not there.
const ONE: &str = "
    [params]\nhow = 3
    [nodes.make]\nkind = \"make-scene\"\nseed = 1
    [nodes.far]\npipeline = \"part\"\nscene = \"make\"\nfactor = \"{how}\"
    [nodes.write]\nkind = \"write-glb\"\nmeshes = \"far\"
    [files]\n\"far.glb\" = \"write\"\n";

#[test]
fn a_part_is_put_among_the_nodes_and_its_input_plugged_in() {
    let plan = sound(ONE, &[]);
    assert_eq!(names(&plan), ["make", "far/mesh", "far/collapse", "write"]);
    assert_eq!(node(&plan, "far/mesh").inputs[0].from, Some(output(&plan, "make", 0)));
    assert_eq!(node(&plan, "write").inputs[0].from, Some(output(&plan, "far/collapse", 0)), "its first output");
    assert_eq!(plan.files.iter().map(|f| f.path.as_str()).collect::<Vec<_>>(), ["far.glb"]);
    assert_eq!(node(&plan, "far/collapse").axes, [output(&plan, "far/mesh", 0)]);
    assert_eq!(
        (param(&plan, "far/collapse", "factor"), param(&plan, "far/collapse", "max_layers")),
        (json!(3.0), json!(5))
    );
}

#[test]
fn an_input_that_nobody_plugs_in_has_its_default() {
    let plan =
        sound(&ONE.replace("scene = \"make\"\n", "").replace("[nodes.make]\nkind = \"make-scene\"\nseed = 1", ""), &[]);
    assert_eq!(names(&plan), ["far/load", "far/mesh", "far/collapse", "write"]);
    assert_eq!(param(&plan, "far/load", "path"), json!("builtin:city"));
    // Baked by itself, the pipeline publishes what it says.
    let alone = sound("[pipeline]\nbase = \"part\"\n", &[]);
    assert_eq!(names(&alone), ["load", "mesh", "collapse", "write"]);
    assert_eq!(alone.files.len(), 1);
}

#[test]
fn arguments_reach_into_parts() {
    let factor = |set: &[&str]| param(&sound(ONE, set), "far/collapse", "factor");
    assert_eq!(factor(&["how=4"]), json!(4.0));
    assert_eq!(factor(&["how=4", "far.factor=5"]), json!(5.0));
    assert_eq!(factor(&["far/collapse.factor=6"]), json!(6.0));
    assert_eq!(param(&sound(ONE, &["far.layers=7"]), "far/collapse", "max_layers"), json!(7));
}

#[test]
fn one_pipeline_stands_in_two_places_and_parts_hold_parts() {
    let text = "
        [nodes.make]\nkind = \"make-scene\"\nseed = 1
        [nodes.a]\npipeline = \"both\"\nscene = \"make\"\nfactor = 7
        [nodes.b]\npipeline = \"part\"
        [nodes.one]\nkind = \"write-glb\"\nmeshes = \"a.meshes\"
        [nodes.two]\nkind = \"write-glb\"\nmeshes = \"b.meshes\"
        [files]\n\"one.glb\" = \"one\"\n\"two.glb\" = \"two\"\n\"b.glb\" = \"b.glb\"\n\"a.glb\" = \"a.glb\"\n";
    let plan = sound(text, &[]);
    let of = |name: &str| param(&plan, name, "factor");
    // `both` has two of `part`; its second gives a knob, its first passes one on.
    assert_eq!((of("a/x/collapse"), of("a/y/collapse"), of("b/collapse")), (json!(7.0), json!(8.0), json!(2.0)));
    assert_eq!(node(&plan, "a/x/mesh").inputs[0].from, Some(output(&plan, "make", 0)), "through two inputs");
    assert_eq!(node(&plan, "a/y/mesh").inputs[0].from, Some(output(&plan, "make", 0)));
    assert_eq!(node(&plan, "b/mesh").inputs[0].from, Some(output(&plan, "b/load", 0)));
    assert_eq!(node(&plan, "one").inputs[0].from, Some(output(&plan, "a/x/collapse", 0)), "an output of an output");
    assert_eq!(plan.files[3].from, output(&plan, "a/y/write", 0));
    assert!(!names(&plan).contains(&"a/x/write") && !names(&plan).contains(&"a/x/load"));
}

/// An input of a part that nothing needs names a node that is not there either.
#[test]
fn what_nothing_needs_is_not_missed() {
    let text = format!("{ONE}[nodes.idle]\npipeline = \"part\"\n");
    assert_eq!(names(&sound(&text, &[])), names(&sound(ONE, &[])));
}

#[test]
fn a_part_is_mapped_over_the_lists_of_its_parent() {
    let text = "
        [nodes.make]\nkind = \"make-scene\"\nseed = 1
        [nodes.cells]\nkind = \"hex-cells\"\nscene = \"make\"
        [nodes.mesh]\nkind = \"voxel-mesh\"\nscene = \"make\"
        [nodes.pair]\nkind = \"pair\"\nmesh = \"mesh\"\ncell = \"cells\"\ncross = true
        [nodes.each]\npipeline = \"gather\"\nmeshes = \"pair\"\nper = [\"cells\"]
        [files]\n\"{name}.glb\" = \"each\"\n";
    let plan = sound(text, &[]);
    let (cells, meshes) = (output(&plan, "cells", 0), output(&plan, "mesh", 0));
    assert_eq!(node(&plan, "each/write").axes, [cells]);
    assert_eq!(node(&plan, "each/write").inputs[0].gathered, [meshes]);
    assert!(
        node(&sound(&text.replace("per = [\"cells\"]", "").replace("{name}", "a"), &[]), "each/write").axes.is_empty()
    );
}

/// What is said of a file.
fn wrong(text: &str) -> String {
    check(text, &[]).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn mistakes_are_named_where_they_are_made() {
    for (from, to, expected) in [
        (
            "scene = \"make\"",
            "scne = \"make\"",
            &["the pipeline of node `far` has no `scne`", "did you mean `scene`?"][..],
        ),
        ("pipeline = \"part\"", "pipeline = \"prat\"", &["no pipeline `prat`", "part"]),
        ("scene = \"make\"", "scene = \"write\"", &["input `scene` of `far` takes a Scene, `write.file` is a File"]),
        ("scene = \"make\"", "scene = 3", &["input `scene` is a whole number, expected \"node.output\""]),
        ("scene = \"make\"", "scene = \"mak\"", &["no node `mak`", "did you mean `make`?"]),
        ("meshes = \"far\"", "meshes = \"far.mehses\"", &["has no output `mehses`", "did you mean `meshes`?"]),
        ("meshes = \"far\"", "meshes = \"far/collapse\"", &["no node `far/collapse`"]),
        ("meshes = \"far\"", "meshes = \"far.glb\"", &["`far/write.file` is a File", "a Mesh comes from `far.meshes`"]),
        ("pipeline = \"part\"", "pipeline = \"part\"\nkind = \"make-scene\"", &["both `kind` and `pipeline`"]),
        ("factor = \"{how}\"", "factor = \"{hows}\"", &["no knob `hows`", "did you mean `how`?"]),
        ("factor = \"{how}\"", "factor = 99", &["`factor` is 99, expected a number in 1 … 8"]),
        ("factor = \"{how}\"", "factor = \"{how}\"\nper = 3", &["`per` is no list of names"]),
        ("pipeline = \"part\"", "pipeline = \"bare\"", &["has no `scene`"]),
        ("scene = \"make\"\nfactor = \"{how}\"", "", &["no node uses the knob `how`"]),
    ] {
        assert!(ONE.contains(from), "{from}");
        let text = wrong(&ONE.replace(from, to));
        assert!(expected.iter().all(|e| text.contains(e)), "{to}: {text}");
    }
    let far = |pipeline: &str| {
        format!("[nodes.far]\npipeline = \"{pipeline}\"\n[nodes.write]\nkind = \"write-glb\"\nmeshes = \"far\"\n")
    };
    assert!(wrong(&far("bare")).contains("the pipeline of node `far` has no outputs"));
    let needs = wrong(&far("gather").replace("meshes = \"far\"", "meshes = \"far\"\n[files]\n\"a\" = \"far\""));
    assert!(needs.contains("nothing is plugged into the input `meshes`, and it has no default"), "{needs}");
    // Help that lists outputs comes to the same dead end.
    let dead = "[nodes.far]\npipeline = \"through\"\n[nodes.write]\nkind = \"write-glb\"\nmeshes = \"far\"\n";
    assert!(wrong(dead).contains("nothing is plugged into the input `meshes`"), "{}", wrong(dead));
    // A part that is fed by itself: through its input and its output.
    let round = "[nodes.far]\npipeline = \"through\"\nmeshes = \"far\"\n[nodes.write]\nkind = \"write-glb\"\nmeshes = \"far\"\n";
    assert!(wrong(round).contains("leads back to itself"), "{}", wrong(round));
    let cycle = ONE.replace(
        "[nodes.make]\nkind = \"make-scene\"\nseed = 1",
        "[nodes.make]\nkind = \"field-scene\"\nmesh = \"far\"",
    );
    assert!(check(&cycle, &[]).is_err());
    assert!(
        check(ONE, &["far.pipeline=\"both\""])
            .map(|_| ())
            .unwrap_err()
            .to_string()
            .contains("cannot be given by --set")
    );
}

#[test]
fn a_pipeline_that_is_a_part_of_itself_is_refused() {
    let said = wrong("[nodes.a]\npipeline = \"first\"\n");
    assert!(said.contains("a pipeline is a part of itself: test.toml → first → second → first"), "{said}");
    let many = wrong("[nodes.a]\npipeline = \"many0\"\n");
    assert!(many.contains("more than 256 parts"), "{many}");
}
