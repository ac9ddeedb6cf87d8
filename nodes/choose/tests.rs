use super::*;
use crate::{
    engine::plan::Bundle,
    nodes::{
        take_chosen::{self, TakeChosen},
        testing::{World, run},
    },
    scene::builtin,
};
use serde_json::json;

fn certificate(verdict: &str, triangles: u64, texels: u64, deviation_px: f64) -> Arc<File> {
    let json = json!({ "verdict": verdict, "sentence": "", "max_deviation_px": deviation_px,
        "psnr_y_object_db": { "mean": 33.0 }, "triangles": triangles, "texels": texels,
        "memory_bytes": 4 * texels, "draw_calls": 1 });
    Arc::new(File { media_type: "application/json".into(), bytes: json.to_string().into_bytes() })
}

fn car() -> Scene {
    let car = builtin::make("car", 1).unwrap();
    Scene { objects: car.objects.into_iter().take(4).collect() }
}

/// Inputs whose certificates are those of `offers`: method, object, certificate.
fn inputs(scene: &Scene, offers: &[(&str, usize, Arc<File>)]) -> In {
    let mut list: Vec<(String, Arc<File>)> =
        offers.iter().map(|(m, o, c)| (format!("{m}/{}", scene.objects[*o].name), c.clone())).collect();
    list.sort_by(|a, b| a.0.cmp(&b.0));
    In { scene: Arc::new(scene.clone()), certificates: Some(List(list)), meshes: None, groups: None, members: None }
}

fn json_of(out: &Out) -> Value {
    serde_json::from_slice(&out.certificate.bytes).unwrap()
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|o| o.name.as_str()).collect()
}

#[test]
fn what_is_cheapest_and_good_enough_is_chosen_and_the_rest_kept() {
    let scene = car();
    let offers = [
        ("card", 0, certificate("good", 2, 0, 1.0)),
        ("card", 1, certificate("failed", 2, 0, 1.0)),
        ("card", 2, certificate("good", 2, 0, 9.0)),
        ("large", 0, certificate("good", 2, 1 << 24, 0.1)),
    ];
    let out = run::<Choose>(&Params::default(), inputs(&scene, &offers)).0.unwrap();
    assert_eq!(names(&out.scene), names(&scene)[1..].to_vec());
    let name = |k: usize| scene.objects[k].name.clone();
    assert_eq!(out.chosen.0, BTreeMap::from([(String::new(), vec![]), (name(0), vec!["card".into()])]));
    let table = json_of(&out);
    assert_eq!(
        (&table["verdict"], &table["by_stand_in"]),
        (&json!("within budget"), &json!({ "card": 1, "original": 3 }))
    );
    assert!(table["proved"] == json!(true) && table["alone"]["card"]["objects"] == json!(1));
    let row =
        |k: usize| table["objects"].as_array().unwrap().iter().find(|r| r["name"] == json!(name(k))).unwrap().clone();
    assert_eq!((&row(0)["chosen"], &row(0)["why"]), (&json!("card"), &json!("the cheapest that meets the target")));
    assert_eq!(row(1)["why"], json!("no stand-in meets the target"));
    assert!(row(2)["candidates"][0]["misses"][0].as_str().unwrap().contains("9.0 px"));
    let csv = String::from_utf8(out.table.bytes.clone()).unwrap();
    assert_eq!(csv.lines().count(), 1 + 4 + 4, "a line for each object and candidate: {csv}");
    // What was chosen is taken; objects that are kept have nothing to take.
    let taken = |element: Option<&str>| {
        let bundle = |bytes: &[u8]| {
            let file = File { media_type: "text/plain".into(), bytes: bytes.to_vec() };
            Arc::new(Bundle::new("a.glb", BTreeMap::from([("a.glb".into(), file)])).unwrap())
        };
        let stand_ins = List(vec![("card".into(), bundle(b"card")), ("large".into(), bundle(b"large"))]);
        let inputs = take_chosen::In { chosen: out.chosen.clone(), stand_ins };
        let (taken, _) =
            World::default().visit(|ctx| TakeChosen::run(&take_chosen::Params {}, inputs, &Ctx { element, ..*ctx }));
        taken.unwrap().stand_in.0.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
    };
    assert_eq!(taken(Some(&name(0))), ["card"]);
    assert!(taken(Some(&name(1))).is_empty() && taken(None).is_empty());
}

#[test]
fn a_group_stands_for_its_members() {
    let scene = car();
    let part = Scene { objects: scene.objects[1..].to_vec() };
    let with = |verdict: &str| In {
        groups: Some(List(vec![("far".into(), certificate(verdict, 10, 0, 0.5))])),
        members: Some(List(vec![("far".into(), Arc::new(part.clone()))])),
        ..inputs(&scene, &[("card", 1, certificate("good", 2, 0, 1.0))])
    };
    let out = run::<Choose>(&Params::default(), with("good")).0.unwrap();
    assert_eq!(names(&out.scene), names(&scene)[..1].to_vec());
    assert_eq!(out.chosen.0, BTreeMap::from([(String::new(), vec!["far".to_owned()])]));
    let out = run::<Choose>(&Params::default(), with("visible")).0.unwrap();
    assert_eq!(out.chosen.0[""], Vec::<String>::new());
    assert_eq!(json_of(&out)["groups"][0]["chosen"], json!("no"));
}

#[test]
fn simpler_meshes_are_drawn_with_what_is_kept() {
    let scene = car();
    let mut simple = scene.objects[0].clone();
    for part in &mut simple.parts {
        let triangles = part.mesh.triangles.iter().copied().step_by(2).collect::<Vec<_>>().into();
        part.mesh = Arc::new(crate::scene::Mesh { triangles, ..(*part.mesh).clone() });
    }
    let name = format!("simple/{}", simple.name);
    let In { scene: whole, certificates, .. } =
        inputs(&scene, &[("simple", 0, certificate("good", 999_999, 1 << 30, 0.5))]);
    let simple = Arc::new(Scene { objects: vec![simple] });
    // Textures of the original are its own, so only triangles count here.
    let weights = Weights { triangles: 1.0, texels: 0.0, memory_bytes: 0.0, draw_calls: 0.0 };
    let meshes = Some(List(vec![(name, simple.clone())]));
    let inputs = In { scene: whole, certificates, meshes, groups: None, members: None };
    let out = run::<Choose>(&Params { weights, ..Params::default() }, inputs).0.unwrap();
    assert_eq!(names(&out.scene), names(&scene));
    assert_eq!(json_of(&out)["by_stand_in"]["simple"], json!(1), "weighed by the mesh, not by its file");
    assert_eq!(out.scene.objects[0], simple.objects[0]);
}

#[test]
fn budgets_that_nothing_meets_give_the_nearest() {
    let scene = car();
    let offers = [("card", 0, certificate("good", 2, 64, 0.5))];
    let budget = Budget { triangles: 3, ..Budget::default() };
    let out = run::<Choose>(&Params { budget, ..Params::default() }, inputs(&scene, &offers)).0.unwrap();
    let table = json_of(&out);
    assert!(table["budget_taken"].as_f64().unwrap() > 1.0 && table["lower_bound"] == Value::Null);
    assert_eq!(table["verdict"], json!("over budget"));
    assert_eq!(table["by_stand_in"]["card"], json!(1), "the nearest");
}

#[test]
fn mistakes_are_told() {
    let scene = car();
    let said = |inputs: In| run::<Choose>(&Params::default(), inputs).0.map(|_| ()).unwrap_err().to_string();
    let good = certificate("good", 2, 0, 1.0);
    let named = |name: &str, file: &Arc<File>| In {
        certificates: Some(List(vec![(name.into(), file.clone())])),
        ..inputs(&scene, &[])
    };
    assert!(said(named("wheel", &good)).contains("does not say its method"));
    assert!(said(named("card/nobody", &good)).contains("no such object"));
    assert!(said(named(&format!("original/{}", scene.objects[0].name), &good)).contains("another name"));
    let text = |bytes: &[u8]| Arc::new(File { media_type: "text/plain".into(), bytes: bytes.to_vec() });
    let name = format!("card/{}", scene.objects[0].name);
    assert!(said(named(&name, &text(b"{"))).contains(&format!("the certificate of `{name}`")));
    assert!(said(named(&name, &text(b"{}"))).contains("verdict"));
    let lonely = In { groups: Some(List(vec![("far".into(), good.clone())])), ..inputs(&scene, &[]) };
    assert!(said(lonely).contains("the group `far`"));
    let mesh = In { meshes: Some(List(vec![("card/x".into(), Arc::new(scene.clone()))])), ..inputs(&scene, &[]) };
    assert!(said(mesh).contains("has no certificate"));
    let nothing = Weights { triangles: 0.0, texels: 0.0, memory_bytes: 0.0, draw_calls: 0.0 };
    let refused = crate::nodes::testing::refused::<Choose>(&Params { weights: nothing, ..Params::default() });
    assert_eq!(refused.as_deref(), Some("weights"));
}
