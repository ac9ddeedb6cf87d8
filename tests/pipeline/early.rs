//! What is found out before anything runs: measures, bounds of the command line, files that are no scenes, values that
//! cannot be meant; and how much is said of a file in which much is wrong.

use super::{STOCK, check, kinds};
use farfield::engine::{
    pipeline::{Problems, Request, load_text},
    plan::Plan,
};
use std::{fmt::Write as _, path::Path};

/// The bounds of a pipeline of one judge: path, min, max.
type Bounds = Vec<(String, Option<f64>, Option<f64>)>;

const JUDGE: &str = "[nodes.judge]\nkind = \"judge\"\n[require.judge]\n\"crack_px.total\" = { min = 1, max = 3 }\n";

fn with(text: &str, require: &[&str], name: Option<&str>, folder: &Path) -> Result<Plan, Problems> {
    let require: Vec<String> = require.iter().map(|s| (*s).to_owned()).collect();
    let request = Request { require: &require, name, ..Request::new("test.toml", folder, STOCK) };
    load_text("test.toml", text, &request, &kinds::registry())
}

fn bounds(require: &[&str]) -> Bounds {
    let plan = with(JUDGE, require, None, Path::new(".")).unwrap_or_else(|problems| panic!("{problems}"));
    plan.require.into_iter().map(|r| (r.path, r.min, r.max)).collect()
}

/// The only message and its help.
fn wrong(text: &str, require: &[&str]) -> String {
    let problems = with(text, require, None, Path::new(".")).map(|_| ()).unwrap_err();
    assert_eq!(problems.list.len(), 1, "{problems}");
    format!("{}; {}", problems.list[0].message, problems.list[0].help.clone().unwrap_or_default())
}

#[test]
fn requirements_are_overridden() {
    let crack = |min, max| vec![("crack_px.total".to_owned(), min, max)];
    assert_eq!(bounds(&[]), crack(Some(1.0), Some(3.0)));
    assert!(bounds(&["judge.crack_px.total=off"]).is_empty());
    assert_eq!(bounds(&["judge.crack_px.total<=5"]), crack(Some(1.0), Some(5.0)));
    assert_eq!(bounds(&["judge.crack_px.total=..5"]), crack(None, Some(5.0)));
    assert_eq!(bounds(&["judge.crack_px.total=2"]), crack(Some(2.0), Some(2.0)));
    assert_eq!(bounds(&["judge.crack_px.total=off", "judge.crack_px.total >= 2"]), crack(Some(2.0), None));
    assert_eq!(bounds(&["judge.psnr_y_object_db.mean=30.."]).len(), 2);
    // What is not required may be switched off: nothing follows from it.
    assert_eq!(bounds(&["judge.psnr_y_object_db.min=off"]).len(), 1);
}

#[test]
fn wrong_requirements_are_found_before_anything_runs() {
    for (argument, expect) in [
        ("judge.psnr_y_objct_db.mean>=30", "measures no `psnr_y_objct_db.mean`; did you mean `psnr_y_object_db.mean`?"),
        ("judge.crack_px<=0", "it has the parts `crack_px.ratio` and `crack_px.total`"),
        ("judge.crack_px.sum<=0", "`crack_px."),
        ("jugde.crack_px.total=off", "no node `jugde`; did you mean `judge`?"),
        ("judge.crack_px.total", "there is no bound"),
        ("crack_px=off", "is no NODE.MEASURE"),
        ("judge=off", "is no NODE.MEASURE"),
        ("judge.crack_px.total=none", "`none` is no bound"),
        ("judge.crack_px.total>=9", "min is above max"),
    ] {
        let argument_error = with(JUDGE, &[argument], None, Path::new(".")).map(|_| ()).unwrap_err();
        let problem = &argument_error.list[0];
        let text = format!("{}; {}", problem.message, problem.help.clone().unwrap_or_default());
        assert!(argument_error.list.len() == 1 && text.contains(expect), "{argument}: {text}");
        // The report quotes the argument.
        assert!(argument_error.to_string().contains("--require"), "{argument_error}");
    }
    let file = |line: &str| wrong(&format!("[nodes.judge]\nkind = \"judge\"\n[require.judge]\n{line}\n"), &[]);
    let text = file("\"psnr_y_objct_db.mean\" = { min = 30 }");
    assert!(text.contains("did you mean `psnr_y_object_db.mean`?") && text.contains("about psnr"), "{text}");
    let text = file("\"crack_px.total\" = { maximum = 0 }");
    assert!(text.contains("a bound has no `maximum`; did you mean `max`?") && !text.contains("quotes"), "{text}");
    let text = file("\"crack_px.total\" = { at_least = 0 }");
    assert!(text.contains("did you mean `min`?"), "{text}");
    assert!(file("crack_px.total = { max = 0 }").contains("needs quotes"));
}

#[test]
fn a_name_of_the_command_line_counts() {
    assert_eq!(with(JUDGE, &[], Some("town"), Path::new(".")).map(|p| p.name).ok().as_deref(), Some("town"));
    let problems = with(JUDGE, &[], Some("../town"), Path::new(".")).map(|_| ()).unwrap_err();
    assert!(problems.to_string().contains("--name"), "{problems}");
}

#[test]
fn the_plan_knows_what_it_was_given() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("models");
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(folder.join("town.glb"), "scene").unwrap();
    let text = "[params]\nscene = \"./town.glb\"\n[nodes.a]\nkind = \"judge\"\npath = \"{scene}\"\n\
                [nodes.b]\nkind = \"judge\"\npath = \"../models/town.glb\"\n[nodes.c]\nkind = \"single-mesh\"\n";
    let plan = with(text, &[], None, &folder).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(plan.sources, ["models/town.glb"]);
    assert_eq!(serde_json::to_value(&plan.knobs).unwrap(), serde_json::json!({ "scene": "./town.glb" }));
}

#[test]
fn files_that_are_no_scenes_are_refused_with_their_place() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(dir.path().join(name), bytes).unwrap();
    write("good.glb", b"scene");
    write("bad.glb", b"# Title");
    write("large.glb", &vec![b' '; 1 << 20]);
    let text = |file: &str| format!("[nodes.judge]\nkind = \"judge\"\npath = \"{file}\"\n");
    assert!(with(&text("good.glb"), &[], None, dir.path()).is_ok());
    for (file, expect) in [
        ("bad.glb", "`bad.glb` is no scene (7 bytes, whole: true)"),
        ("large.glb", "`large.glb` is no scene (65536 bytes, whole: false)"),
    ] {
        let problems = with(&text(file), &[], None, dir.path()).map(|_| ()).unwrap_err();
        let report = problems.to_string();
        assert!(report.contains(expect) && report.contains("test.toml:3"), "{report}");
    }
    #[cfg(unix)]
    if std::process::Command::new("mkfifo").arg(dir.path().join("pipe.glb")).status().is_ok_and(|s| s.success()) {
        let problems = with(&text("pipe.glb"), &[], None, dir.path()).map(|_| ()).unwrap_err();
        assert!(problems.to_string().contains("is a FIFO, expected a regular file"), "{problems}");
    }
    // Suggestions are files that can be meant.
    for name in ["towns.txt", "town.md", "twon.glb"] {
        write(name, b"scene");
    }
    let near = |file: &str| with(&text(file), &[], None, dir.path()).map(|_| ()).unwrap_err().to_string();
    assert!(near("town.glb").contains("did you mean `twon.glb`?"));
    std::fs::remove_file(dir.path().join("twon.glb")).unwrap();
    assert!(!near("towns.glb").contains("did you mean `town.md`"));
}

#[test]
fn values_that_cannot_be_meant_are_doubted() {
    let text = "[params]\nangle = 0.785\n[nodes.judge]\nkind = \"judge\"\nfov = \"{angle}\"\n";
    let plan = check(text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(plan.doubts, ["test.toml:2: node `judge`, `fov`: degrees are meant"]);
    assert!(check(JUDGE, &[]).unwrap_or_else(|problems| panic!("{problems}")).doubts.is_empty());
}

#[test]
fn windows_paths_are_explained() {
    for line in ["scene = \"C:\\models\\town.glb\"", "scene = \"C:\\Users\\me\\town.glb\"", "scene = \"D:\\x.glb\""] {
        let problems = check(&format!("[params]\n{line}\n"), &[]).map(|_| ()).unwrap_err();
        let text = problems.to_string();
        assert!(text.contains("single quotes") && text.contains("C:/models"), "{line}: {text}");
        assert_eq!(problems.list.len(), 1, "{text}");
    }
    // Where every backslash begins an escape that TOML knows, the path is not what was meant.
    let text = "[nodes.a]\nkind = \"judge\"\npath = \"C:\\town\\new.glb\"\n";
    let text = check(text, &[]).map(|_| ()).unwrap_err().to_string();
    assert!(text.contains(r"no file `C:\town\new.glb`") && text.contains("a control character"), "{text}");
}

#[test]
fn a_report_is_short_however_much_is_wrong() {
    let mut many = String::new();
    for i in 0..4000 {
        let _ = write!(many, "[nodes.n{i}]\nkind = \"collapse\"\nmesh = \"gone{i}\"\n");
    }
    let problems = check(&many, &[]).map(|_| ()).unwrap_err();
    assert_eq!(problems.list.len(), 4000);
    let report = problems.to_string();
    assert!(report.contains("and 3960 more problems") && report.lines().count() < 600, "{}", report.lines().count());

    let long = "x".repeat(100_000);
    let cycle: String =
        (0..500).map(|i| format!("[nodes.n{i}]\nkind = \"collapse\"\nmesh = \"n{}\"\n", (i + 1) % 500)).collect();
    for text in [
        cycle,
        format!("[nodes.{long}]\nkind = \"collapse\"\n"),
        format!("[nodes.a]\nkind = \"{long}\"\n"),
        format!("[nodes.a]\nkind = \"collapse\"\nmesh = \"{long}\"\n"),
        format!("[nodes.a]\nkind = \"collapse\"\nmesh = [\n{}]\n", "1,\n".repeat(5000)),
        format!("[nodes.a]\nkind = \"collapse\"\n{long} = 1\n"),
        format!("[params]\nscene = {long}\n"),
    ] {
        let problems = check(&text, &[]).map(|_| ()).unwrap_err();
        let report = problems.to_string();
        let start: String = text.chars().take(60).collect();
        assert!(
            report.len() < 6000 * problems.list.len() && report.lines().count() < 60 * problems.list.len(),
            "{start}"
        );
        assert!(report.lines().all(|line| line.chars().count() < 1500), "{start}: {}", report.len());
    }
}

#[test]
fn files_that_some_systems_cannot_tell_apart_are_spelled_out() {
    let text = "[nodes.a]\nkind = \"single-mesh\"\n[files]\n\"caf\u{e9}.png\" = \"a.picture\"\n\"cafe\u{301}.png\" = \"a.picture\"\n";
    let problems = check(text, &[]).map(|_| ()).unwrap_err().to_string();
    assert!(problems.contains("caf{U+00E9}.png") && problems.contains("cafe{U+0301}.png"), "{problems}");
}
