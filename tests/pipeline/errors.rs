//! Mistakes as data: each file of `cases/` is a pipeline file (lines `# set: name=value` are arguments), its report lies
//! beside it as `.txt`. `FARFIELD_UPDATE_CASES=1 cargo test` writes the reports anew; read what it wrote.

use super::check;
use std::path::Path;

#[test]
fn reports_of_mistakes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pipeline/cases");
    let update = std::env::var_os("FARFIELD_UPDATE_CASES").is_some();
    let mut cases: Vec<_> = folder.read_dir().unwrap().map(|e| e.unwrap().path()).collect();
    cases.retain(|p| p.extension().is_some_and(|e| e == "toml"));
    cases.sort();
    assert!(cases.len() >= 20);
    let mut wrong = Vec::new();
    for case in cases {
        let text = std::fs::read_to_string(&case).unwrap();
        let set: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("# set: ")).collect();
        let report = match check(&text, &set) {
            Ok(_) => "ok\n".to_owned(),
            // Wide, so that no line breaks where the length of this folder's own path puts it.
            Err(problems) => problems.render(miette::GraphicalTheme::unicode_nocolor(), 100_000),
        };
        // Where the folder lies is no part of a report's meaning.
        let here = format!("{}/", folder.with_file_name("folder").display());
        let report: String = report.replace(&here, "…/").lines().map(|l| format!("{}\n", l.trim_end())).collect();
        let expected = case.with_extension("txt");
        if update {
            std::fs::write(&expected, &report).unwrap();
        } else if std::fs::read_to_string(&expected).unwrap_or_default() != report {
            wrong.push(format!("{}:\n{report}", case.display()));
        }
    }
    assert!(wrong.is_empty(), "these reports changed:\n{}", wrong.join("\n"));
}
