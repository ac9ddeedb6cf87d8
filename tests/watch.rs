//! `farfield watch` as a user runs it: files are saved, broken, taken away and mended while it runs.
#![cfg(feature = "watch")]

use std::{
    io::{BufRead as _, BufReader},
    path::Path,
    process::{Child, Command, Stdio},
    sync::mpsc::{self, Receiver},
    time::{Duration, Instant},
};

/// A scene of one file, a pipeline that makes a GLB of it, and another that is based on that one.
const SCENE: &str = "[[place]]\nfile = \"box.ply\"\nname = \"box\"\ntranslate = [1.0, 0.0, 0.0]\n";
const BOX: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const BASE: &str = "
[params]
scene = \"town.toml\"
unlit = true
[nodes.load]
kind = \"load-scene\"
path = \"{scene}\"
[nodes.write]
kind   = \"write\"
method = \"glb\"
name   = \"town\"
unlit  = \"{unlit}\"
scene  = \"load\"
[files]
\"./\" = \"write\"
";

/// Far more than any of it takes: the machine may be busy.
const LONG: Duration = Duration::from_secs(120);

struct Watch {
    child: Child,
    lines: Receiver<String>,
}

impl Watch {
    fn start(folder: &Path, args: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_farfield"));
        command.current_dir(folder).arg("watch").args(args).env_remove("FARFIELD_CACHE").env_remove("NO_COLOR");
        // One pipe for both streams: their lines keep their order.
        let (read, written) = std::io::pipe().unwrap();
        command.stdin(Stdio::null()).stdout(written.try_clone().unwrap()).stderr(written);
        let child = command.spawn().unwrap();
        let (tell, lines) = mpsc::channel();
        std::thread::spawn(move || {
            BufReader::new(read).lines().map_while(Result::ok).for_each(|line| drop(tell.send(line)));
        });
        Self { child, lines }
    }

    /// What was said up to a line that holds `text`.
    fn until(&self, text: &str) -> String {
        let end = Instant::now() + LONG;
        let mut said = String::new();
        while let Ok(line) = self.lines.recv_timeout(end.saturating_duration_since(Instant::now())) {
            said += &format!("{line}\n");
            if line.contains(text) {
                return said;
            }
        }
        panic!("`{text}` was not said, but\n{said}");
    }

    fn end(mut self) -> Option<i32> {
        #[cfg(unix)]
        assert!(Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap().success());
        #[cfg(not(unix))]
        self.child.kill().unwrap();
        self.child.wait().unwrap().code()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        // A test that failed leaves nothing behind; one that ended it has nothing to kill.
        let _ = self.child.kill();
    }
}

fn write(folder: &Path, name: &str, text: &str) {
    // As editors do: a new file takes the old one's name.
    let new = folder.join(format!("{name}~"));
    std::fs::write(&new, text).unwrap();
    std::fs::rename(new, folder.join(name)).unwrap();
}

#[test]
fn what_is_saved_is_baked_and_what_is_broken_keeps_the_last_output() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let pipeline = |change: &str| format!("[pipeline]\nbase = \"base.toml\"\nname = \"town\"\n{change}");
    write(folder, "box.ply", BOX);
    write(folder, "town.toml", SCENE);
    write(folder, "base.toml", BASE);
    write(folder, "p.toml", &pipeline(""));
    let glb = || std::fs::read(folder.join("out/town/town.glb")).unwrap();
    let holds = |text: &str| glb().windows(text.len()).any(|w| w == text.as_bytes());

    let watch = Watch::start(folder, &["p.toml"]);
    let said = watch.until("watching ");
    assert!(said.contains("baked: town, 0 hits, 2 ran, ") && said.ends_with("watching 4 files\n"), "{said}");
    assert!(holds("KHR_materials_unlit"));

    // A parameter.
    write(folder, "p.toml", &pipeline("[params]\nunlit = false\n"));
    let said = watch.until("watching ");
    assert!(said.starts_with("p.toml was saved\n"), "{said}");
    assert!(
        said.contains("baked: town, 1 hits, 1 ran, ") && said.contains(" from the save to the finished output"),
        "{said}"
    );
    assert!(!holds("KHR_materials_unlit"));

    // The file broken: the error, and the output stays.
    let good = glb();
    write(folder, "p.toml", &pipeline("[params]\nunlit = flase\n"));
    let said = watch.until("watching ");
    assert!(said.contains("p.toml:5") && said.contains("the last good output stays"), "{said}");
    assert_eq!(glb(), good);

    // Mended: all is there already.
    write(folder, "p.toml", &pipeline("[params]\nunlit = false\n"));
    let said = watch.until("watching ");
    assert!(said.contains("baked: town, 2 hits, 0 ran, "), "{said}");

    // The base, and what the scene names.
    write(folder, "base.toml", &BASE.replace("town\"\nunlit", "village\"\nunlit"));
    let said = watch.until("watching ");
    assert!(said.starts_with("base.toml was saved\n") && folder.join("out/town/village.glb").is_file(), "{said}");
    write(folder, "box.ply", &BOX.replace("0 1 0", "0 2 0"));
    let said = watch.until("watching ");
    assert!(said.starts_with("box.ply was saved\n") && said.contains(", 2 ran, "), "{said}");

    // A scene that cannot be read.
    let good = std::fs::read(folder.join("out/town/village.glb")).unwrap();
    write(folder, "box.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
    let said = watch.until("watching ");
    assert!(said.contains("error: load: ") && said.contains("the last good output stays"), "{said}");
    assert_eq!(std::fs::read(folder.join("out/town/village.glb")).unwrap(), good);

    // Taken away: said once, and baked when it is back.
    std::fs::remove_file(folder.join("box.ply")).unwrap();
    watch.until("box.ply is gone; the last good output stays, and it is watched for");
    write(folder, "box.ply", BOX);
    let said = watch.until("watching ");
    assert!(said.starts_with("box.ply is there\n") && said.contains("baked: town, "), "{said}");
    assert!(!said.contains("is gone"), "{said}");

    let code = watch.end();
    assert!(cfg!(not(unix)) || code == Some(130), "{code:?}");
}

/// The slices of the city take seconds: there is time for a save.
#[test]
fn a_save_stops_the_bake_that_runs() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let pipeline = |more: &str| format!("[pipeline]\nbase = \"tdm-city\"\nname = \"c\"\n{more}");
    write(folder, "c.toml", &pipeline(""));
    let watch = Watch::start(folder, &["c.toml", "--only", "slices", "--events", "json"]);
    while !watch.until("node-started").contains("\"node\":\"slices\"") {}
    // A pipeline that is ready at once.
    write(folder, "c.toml", "[pipeline]\nname = \"c\"\n[nodes.slices]\nkind = \"make-scene\"\nwhat = \"car\"\n");
    let said = watch.until("watching ");
    assert!(said.contains("c.toml was saved; the bake of what was there before stops"), "{said}");
    assert!(said.contains("\"outcome\":\"interrupted\"") && said.contains("\"outcome\":\"baked\""), "{said}");
    watch.end();
}

#[test]
fn where_there_is_nothing_to_watch_it_ends_with_2() {
    let folder = tempfile::tempdir().unwrap();
    for (args, expect) in [
        (&["tdm"][..], "nothing to watch"),
        (&["tmd"], "did you mean `tdm`?"),
        (&["missing.toml"], "no such file"),
        (&["tdm", "--memory", "lots"], "4GiB"),
    ] {
        let mut watch = Watch::start(folder.path(), args);
        watch.until(expect);
        assert_eq!(watch.child.wait().unwrap().code(), Some(2), "{args:?}");
    }
    assert!(!folder.path().join("out").exists() && !folder.path().join(".farfield").exists());
}

#[test]
fn a_quick_answer_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "box.ply", BOX);
    write(folder, "town.toml", SCENE);
    write(folder, "p.toml", &format!("[pipeline]\nname = \"town\"\n{BASE}"));
    let unlit = || {
        let glb = std::fs::read(folder.join("out/town/town.glb")).unwrap();
        glb.windows(19).any(|w| w == b"KHR_materials_unlit")
    };

    let watch = Watch::start(folder, &["p.toml", "--set", "unlit=false", "--quick", "unlit=true"]);
    let said = watch.until("all of it follows");
    assert!(
        said.contains("baked: town, 0 hits, 2 ran, ") && said.contains("the quick answer, with unlit=true"),
        "{said}"
    );
    let said = watch.until("watching ");
    assert!(said.contains("baked: town, 1 hits, 1 ran, "), "{said}");
    assert!(!unlit());

    // What is broken is said once.
    write(folder, "p.toml", "[pipeline]\nname = town\n");
    let said = watch.until("watching ");
    assert!(said.matches("nothing was run").count() == 1 && !said.contains("quick answer"), "{said}");
    watch.end();

    // A knob that there is not is a mistake before anything runs.
    write(folder, "p.toml", &format!("[pipeline]\nname = \"town\"\n{BASE}"));
    let watch = Watch::start(folder, &["p.toml", "--quick", "views=8"]);
    watch.until("nothing was run");
}
