//! Pipeline files: what they mean and what is said of mistakes in them.

mod early;
mod errors;
mod fuzz;
mod incremental;
mod kinds;
mod meaning;
mod parts;
mod several;
mod stock;

use farfield::engine::{
    pipeline::{Problems, Request, Stock, load_text},
    plan::Plan,
};

/// Pipelines that cases are based on.
const STOCK: &[Stock] = &[
    ("stock", include_str!("stock.toml")),
    ("part", include_str!("part.toml")),
    ("both", BOTH),
    ("bare", "[nodes.load]\nkind = \"load-scene\"\npath = \"builtin:city\"\n"),
    ("gather", GATHER),
    ("through", "[inputs]\nmeshes = { type = \"Mesh\" }\n[outputs]\nmeshes = \"meshes\"\n"),
    ("first", "[nodes.a]\npipeline = \"second\"\n"),
    ("second", "[nodes.a]\npipeline = \"first\"\n"),
    ("many0", "[nodes.a]\npipeline = \"many1\"\n[nodes.b]\npipeline = \"many1\"\n"),
    ("many1", "[nodes.a]\npipeline = \"many2\"\n[nodes.b]\npipeline = \"many2\"\n"),
    ("many2", "[nodes.a]\npipeline = \"many3\"\n[nodes.b]\npipeline = \"many3\"\n"),
    ("many3", "[nodes.a]\npipeline = \"many4\"\n[nodes.b]\npipeline = \"many4\"\n"),
    ("many4", "[nodes.a]\npipeline = \"many5\"\n[nodes.b]\npipeline = \"many5\"\n"),
    ("many5", "[nodes.a]\npipeline = \"many6\"\n[nodes.b]\npipeline = \"many6\"\n"),
    ("many6", "[nodes.a]\npipeline = \"many7\"\n[nodes.b]\npipeline = \"many7\"\n"),
    ("many7", "[nodes.a]\npipeline = \"many8\"\n[nodes.b]\npipeline = \"many8\"\n"),
    ("many8", "[nodes.a]\npipeline = \"many9\"\n[nodes.b]\npipeline = \"many9\"\n"),
    ("many9", "[nodes.load]\nkind = \"load-scene\"\npath = \"builtin:city\"\n"),
];

/// A pipeline of two parts.
const BOTH: &str = "
    [params]\nfactor = 1
    [inputs]\nscene = { type = \"Scene\" }
    [nodes.x]\npipeline = \"part\"\nscene = \"scene\"\nfactor = \"{factor}\"
    [nodes.y]\npipeline = \"part\"\nscene = \"scene\"\nfactor = 8
    [outputs]\nmeshes = \"x.meshes\"\nglb = \"y.glb\"\n";

/// One that gathers what is plugged in.
const GATHER: &str = "
    [inputs]\nmeshes = { type = \"Mesh\" }
    [nodes.write]\nkind = \"write-glb\"\nmeshes = \"meshes\"
    [outputs]\nglb = \"write\"\n";

/// Checks `text` as the file `test.toml` in a folder that holds `town.glb`.
fn check(text: &str, set: &[&str]) -> Result<Plan, Problems> {
    of_row(text, set, None)
}

/// The same for a row of its batch.
fn check_row(text: &str, set: &[&str], row: usize) -> Result<Plan, Problems> {
    of_row(text, set, Some(row))
}

fn of_row(text: &str, set: &[&str], row: Option<usize>) -> Result<Plan, Problems> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pipeline/folder");
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    let request = Request { set: &set, row, ..Request::new("test.toml", &folder, STOCK) };
    load_text("test.toml", text, &request, &kinds::registry())
}
