//! The report beside what a bake publishes: its parts, that no text in it becomes markup, when it is written and when it is left alone.

mod support;

use std::{collections::BTreeMap, fs, path::Path};
use tempfile::TempDir;

const CUBE: &str = "
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6
";

const EVIL: &str = "<img src=x onerror=alert(1)>";

/// A stand-in of two cubes, with a certificate.
const YARD: &str = "
[pipeline]
base  = \"tdm\"
about = \"<script>alert('about')</script> & more\"
[params]
scene      = \"scene.toml\"
resolution = 64
views      = 8
";

/// The objects of the same scene one by one; nothing is judged.
const OBJECTS: &str = "
[nodes.load]
kind = \"load-scene\"
path = \"scene.toml\"
[nodes.objects]
kind  = \"split-objects\"
scene = \"load\"
[nodes.place]
kind   = \"separate-placement\"
object = \"objects\"
[nodes.write]
kind   = \"write\"
method = \"glb\"
name   = \"scene\"
scene  = \"load\"
[files]
\"./\" = \"write\"
";

struct Site(TempDir);

impl Site {
    fn new() -> Self {
        let site = Self(tempfile::tempdir().unwrap());
        for (name, text) in [("cube.obj", CUBE), ("yard.toml", YARD), ("objects.toml", OBJECTS)] {
            fs::write(site.0.path().join(name), text).unwrap();
        }
        site.place(3.0);
        site
    }

    /// Two cubes; the second stands at `x`.
    fn place(&self, x: f64) {
        let place = |name: &str, x: f64| {
            format!("[[place]]\nfile = \"cube.obj\"\nname = \"{name}\"\ntranslate = [{x:?}, 0.0, 0.0]\n")
        };
        fs::write(self.0.path().join("scene.toml"), place("still", -3.0) + &place(EVIL, x)).unwrap();
    }

    fn out(&self, path: &str) -> std::path::PathBuf {
        self.0.path().join("out").join(path)
    }

    fn report(&self, pipeline: &str) -> String {
        fs::read_to_string(self.out(pipeline).join("report.html")).unwrap()
    }

    /// Exit code, nodes that ran, what was said.
    fn bake(&self, pipeline: &str, arguments: &[&str]) -> (i32, Vec<String>, String) {
        let mut command = support::command(self.0.path(), &format!("{pipeline}.toml"));
        command.args(arguments);
        support::outcome(command, self.0.path(), pipeline)
    }
}

/// All files below `folder` and when they were written, but `run.json`.
fn files(folder: &Path) -> BTreeMap<String, (Vec<u8>, std::time::SystemTime)> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(below, file)| (format!("{name}/{below}"), file)));
        } else if name != "run.json" {
            let at = fs::metadata(&path).unwrap().modified().unwrap();
            found.insert(name, (fs::read(path).unwrap(), at));
        }
    }
    found
}

#[test]
fn a_bake_leaves_a_report_and_a_bake_that_changes_nothing_leaves_it_alone() {
    let site = Site::new();
    let (code, _, said) = site.bake("yard", &[]);
    assert_eq!(code, 0, "{said}");
    let page = Path::new("out").join("yard").join("report.html");
    assert!(said.contains(&format!("report: {}", page.display())), "{said}");
    let report = site.report("yard");
    for id in ["budget", "requirements", "views", "errors", "figures", "graph", "why", "settings"] {
        assert!(report.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    for text in ["5 of 5 met", "Likeness over the object", "class=\"node ran\"", "13 nodes", "class=\"banner "] {
        assert!(report.contains(text), "{text}");
    }
    assert!(report.contains("<figure class=\"stand-in\"><img src=\"data:image/png;base64,iVBOR"));
    // Nothing comes from elsewhere, and the pipeline's text stays text.
    assert!(!report.contains("://") && !report.contains("<link") && !report.contains("url("));
    assert!(report.contains("&lt;script&gt;alert(&#39;about&#39;)&lt;/script&gt; &amp; more"));
    assert_eq!(report.matches("<script").count(), 1);
    // The manifest, and with it what is published, does not know the report.
    assert!(!fs::read_to_string(site.out("yard/manifest.json")).unwrap().contains("report.html"));

    let before = files(&site.out("yard"));
    let (code, ran, said) = site.bake("yard", &[]);
    assert_eq!((code, ran), (0, Vec::new()), "{said}");
    assert!(before == files(&site.out("yard")), "not a byte, and no file is written again");

    // One that is gone is made again, of the same certificate.
    fs::remove_file(site.out("yard/report.html")).unwrap();
    site.bake("yard", &[]);
    assert!(site.report("yard").contains("Nothing ran") && site.report("yard").contains("5 of 5 met"));
    let again = files(&site.out("yard"));
    assert!(before.iter().all(|(name, file)| name == "report.html" || again[name] == *file));
}

#[test]
fn a_missed_bound_has_its_report_beside_the_rejected_results() {
    let site = Site::new();
    assert_eq!(site.bake("yard", &[]).0, 0);
    let accepted = site.report("yard");
    let (code, _, said) = site.bake("yard", &["--require", "evaluate.psnr_y_object_db.mean=101.."]);
    assert_eq!(code, 3, "{said}");
    assert_eq!(site.report("yard"), accepted);
    let rejected = site.report("yard/rejected");
    assert!(rejected.contains("Rejected. ") && rejected.contains("4 of 5 met") && rejected.contains("missed by"));
    // Accepted again, the rejected results go with their report.
    let (code, _, said) = site.bake("yard", &[]);
    assert!(code == 0 && !site.out("yard/rejected").exists(), "{said}");
    // A bound that changes without being missed is told, though nothing runs.
    let (code, ran, _) = site.bake("yard", &["--require", "evaluate.psnr_y_object_db.mean=1.5.."]);
    assert_eq!((code, ran), (0, Vec::new()));
    assert!(site.report("yard").contains("≥ 1.5 dB"));
}

#[test]
fn elements_are_named_and_stay_text() {
    let site = Site::new();
    assert_eq!(site.bake("objects", &[]).0, 0);
    site.place(4.0);
    let (code, ran, said) = site.bake("objects", &[]);
    assert!(code == 0 && ran.contains(&"place 1".to_owned()), "{ran:?} {said}");
    let report = site.report("objects");
    assert!(report.contains("element `&lt;img src=x onerror=alert(1)&gt;` changed"), "{report}");
    assert!(!report.contains("<img"));
    // Without a certificate there are none of its parts.
    for id in ["budget", "requirements", "views", "errors", "figures"] {
        assert!(!report.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    assert!(report.contains("for 1 of 2 elements"));
}

#[test]
fn a_report_that_cannot_be_written_fails_no_bake_and_none_is_written_unasked() {
    let site = Site::new();
    let at = site.out("objects/report.html");
    fs::create_dir_all(site.out("objects")).unwrap();
    fs::write(&at, "my own notes").unwrap();
    let (code, _, said) = site.bake("objects", &[]);
    assert!(code == 0 && said.contains("warning: ") && said.contains("did not write"), "{said}");
    assert_eq!(fs::read_to_string(&at).unwrap(), "my own notes");
    let (code, _, said) = site.bake("objects", &["--overwrite"]);
    assert!(code == 0 && site.report("objects").starts_with("<!doctype html>"), "{said}");
    // One of other results would lie: it goes with them.
    let (code, _, _) = site.bake("objects", &["--no-report"]);
    assert!(code == 0 && at.exists(), "nothing changed");
    site.place(5.0);
    let (code, _, said) = site.bake("objects", &["--no-report"]);
    assert!(code == 0 && !at.exists() && !said.contains("report: "), "{said}");
}
