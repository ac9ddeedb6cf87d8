//! Pipeline files: what they mean and what is said of mistakes in them.

mod early;
mod errors;
mod fuzz;
mod incremental;
mod kinds;
mod meaning;
mod stock;

use farfield::engine::{
    pipeline::{Problems, Request, Stock, load_text},
    plan::Plan,
};

/// Pipelines that cases are based on.
const STOCK: &[Stock] = &[("stock", include_str!("stock.toml"))];

/// Checks `text` as the file `test.toml` in a folder that holds `town.glb`.
fn check(text: &str, set: &[&str]) -> Result<Plan, Problems> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pipeline/folder");
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    let request = Request {
        file: "test.toml",
        folder: &folder,
        set: &set,
        stock: STOCK,
        require: &[],
        name: None,
        everywhere: &[],
    };
    load_text("test.toml", text, &request, &kinds::registry())
}
