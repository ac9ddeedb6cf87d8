//! The pipelines that the program carries, against the kinds that it carries.

use farfield::{
    cli::stock::STOCK,
    engine::pipeline::{Request, load},
    nodes,
};

#[test]
fn every_stock_pipeline_is_listed() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    let mut files: Vec<String> =
        folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    let listed: Vec<String> = STOCK.iter().map(|(name, _)| format!("{name}.toml")).collect();
    let mut sorted = listed.clone();
    sorted.sort();
    assert_eq!(files, sorted);
}

#[test]
fn every_stock_pipeline_checks() {
    let registry = nodes::registry();
    for (name, _) in STOCK {
        let folder = std::env::current_dir().unwrap();
        // The scene of one is made of model files that are not in the repository.
        let set = if *name == "park-8m" { vec!["scene=builtin:park".to_owned()] } else { Vec::new() };
        let request = Request { set: &set, ..Request::new(name, &folder, STOCK) };
        let plan = load(&request, &registry).unwrap_or_else(|problems| panic!("{name}\n{problems}"));
        assert_eq!(&plan.name, name);
    }
}

#[test]
fn every_stock_pipeline_has_the_common_knobs() {
    let registry = nodes::registry();
    let folder = std::env::current_dir().unwrap();
    let set: Vec<String> = ["scene=builtin:car", "resolution=256", "views=8"].iter().map(|s| (*s).to_owned()).collect();
    for (name, _) in STOCK {
        let request = Request { set: &set, ..Request::new(name, &folder, STOCK) };
        load(&request, &registry).unwrap_or_else(|problems| panic!("{name}\n{problems}"));
    }
}

/// `farfield nodes --schema > farfield.schema.json` in the repository's folder makes the file for editors.
#[test]
fn every_stock_pipeline_names_its_schema() {
    for (name, text) in STOCK {
        assert_eq!(text.lines().next(), Some("#:schema ../farfield.schema.json"), "{name}");
    }
}
