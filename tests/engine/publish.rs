//! What lies below the output folder.

use super::{Bench, ok, support::*, tree};
use farfield::{
    engine::{
        bake::{Options, Outcome, bake},
        events::{Event, Events, Silent},
        plan::Plan,
        publish::FolderLock,
    },
    math::Stop,
};
use serde_json::json;
use std::{
    collections::BTreeSet,
    fs,
    path::Path,
    process::{Command, Stdio},
    sync::Mutex,
    time::Duration,
};

/// Why a bake was refused.
fn refused(t: &Bench, plan: &Plan, change: impl FnOnce(&mut Options)) -> String {
    let mut options = t.options();
    change(&mut options);
    bake(plan, &options, &Stop::default(), &Silent).unwrap_err().to_string()
}

/// Publishes what a source file says, as `file`.
fn from_source(source: &Path, file: &str) -> Plan {
    let mut b = Builder::default();
    let number = b.node::<Source>("number", json!({ "path": source }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(number)]);
    b.file(file, print);
    b.plan()
}

/// Publishes a number, and an element per name, as `{name}.txt`.
fn number(value: i64, names: &[&str]) -> Plan {
    let mut b = Builder::default();
    let c = b.node::<Constant>("c", json!({ "value": value }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(c)]);
    b.file("number.txt", print);
    let values: Vec<i64> = names.iter().map(|_| value).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
    let each = b.node::<Print>("each", json!({}), &[From::Node(list)]);
    b.file("deep/{name}.txt", each);
    b.plan()
}

/// Publishes two elements, `a` and `name`, as `file`.
fn two_files(name: &str, file: &str) -> Plan {
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", name], "values": [1, 2] }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(list)]);
    b.file(file, print);
    b.plan()
}

#[test]
fn out_is_mended_and_only_our_files_go() {
    let t = Bench::new();
    let build = |name: &str| two_files(name, "deep/{name}.txt");
    ok(&t.bake(&build("b")));
    let before = tree(&t.path("out"));
    fs::write(t.path("out/test/deep/a.txt"), "edited").unwrap();
    fs::remove_file(t.path("out/test/deep/b.txt")).unwrap();
    fs::write(t.path("out/test/deep/mine.txt"), "mine").unwrap();
    let r = t.bake(&build("b"));
    assert_eq!((ok(&r).runs(), r.published.len()), (0, 2));
    fs::remove_file(t.path("out/test/deep/mine.txt")).unwrap();
    assert_eq!(tree(&t.path("out")), before);
    fs::write(t.path("out/test/deep/mine.txt"), "mine").unwrap();
    ok(&t.bake(&build("c")));
    let left: Vec<String> = tree(&t.path("out/test")).into_keys().collect();
    assert_eq!(left, ["deep/a.txt", "deep/c.txt", "deep/mine.txt", "manifest.json"]);
    // What was ours and was edited since is no longer ours to delete.
    fs::write(t.path("out/test/deep/c.txt"), "edited").unwrap();
    ok(&t.bake(&build("d")));
    assert_eq!(t.file("deep/c.txt"), "edited");
}

#[test]
fn names_cannot_leave_the_output_folder() {
    let t = Bench::new();
    let build = |name: &str| two_files(name, "{name}.txt");
    for bad in ["..", "../x", "x/y", "A", "con", "x:y"] {
        let e = bake(&build(bad), &t.options(), &Stop::default(), &Silent).unwrap_err();
        assert!(e.exit_code() == 1 && e.to_string().contains("cannot publish"), "{bad}: {e}");
    }
    assert!(tree(&t.path("out")).is_empty());
    #[cfg(unix)]
    {
        fs::create_dir_all(t.path("outside")).unwrap();
        fs::create_dir_all(t.path("out")).unwrap();
        std::os::unix::fs::symlink(t.path("outside"), t.path("out/test")).unwrap();
        let e = bake(&build("b"), &t.options(), &Stop::default(), &Silent).unwrap_err();
        assert!(e.to_string().contains("symbolic link"), "{e}");
        assert!(tree(&t.path("outside")).is_empty());
    }
}

#[test]
fn a_missed_bound_keeps_the_last_good_output() {
    let t = Bench::new();
    let build = |value: i64| {
        let mut b = Builder::default();
        let c = b.node::<Constant>("c", json!({ "value": value }), &[]);
        let cert = b.node::<Certify>("certify", json!({}), &[From::Node(c)]);
        b.file("certificate.json", cert);
        b.require(cert, "error.max", 10.0);
        b.plan()
    };
    ok(&t.bake(&build(5)));
    let good = t.file("certificate.json");
    for again in 0..2 {
        let r = t.bake(&build(50));
        assert_eq!((r.outcome, r.outcome.exit_code()), (Outcome::NotMet, 3));
        assert_eq!((r.unmet[0].measured, r.runs()), (Some(50.0), if again == 0 { 2 } else { 0 }));
        assert_eq!(t.file("certificate.json"), good);
        assert!(t.file("rejected/certificate.json").contains("50"));
    }
    ok(&t.bake(&build(5)));
    assert!(!t.path("out/test/rejected").exists());
}

#[test]
fn what_the_bake_reads_is_never_overwritten() {
    let t = Bench::new();
    fs::create_dir_all(t.path("out/test/sub")).unwrap();
    let input = t.path("out/test/in.txt");
    fs::write(&input, "5").unwrap();
    fs::write(t.path("out/test/sub/extra.txt"), "1").unwrap();
    fs::write(t.path("out/test/sub/root.txt"), "5").unwrap();
    // The file itself; one that a run read beside its source; both with and without `--overwrite`.
    for (plan, file) in [
        (from_source(&input, "in.txt"), "in.txt"),
        (from_source(&t.path("out/../out/test/in.txt"), "in.txt"), "in.txt"),
        (from_source(&t.path("out/test/sub/root.txt"), "sub/extra.txt"), "sub/extra.txt"),
    ] {
        for overwrite in [false, true] {
            let before = tree(&t.path("out"));
            let e = refused(&t, &plan, |o| o.overwrite = overwrite);
            let why = if overwrite { "this bake reads that file" } else { "farfield did not write" };
            assert!(e.contains(file) && (e.contains("this bake reads that file") || e.contains(why)), "{e}");
            let after: Vec<_> = tree(&t.path("out")).into_iter().filter(|(name, _)| !name.contains("-lock")).collect();
            assert_eq!(after, before.into_iter().filter(|(n, _)| !n.contains("-lock")).collect::<Vec<_>>());
        }
    }
    // The pipeline's own text.
    let text = t.path("out/test/number.txt");
    fs::write(&text, "a pipeline").unwrap();
    let plan = Plan { texts: vec![text.clone()], ..number(1, &["a"]) };
    assert!(refused(&t, &plan, |o| o.overwrite = true).contains("this bake reads that file"));
    assert_eq!(fs::read_to_string(&text).unwrap(), "a pipeline");
}

#[cfg(unix)]
#[test]
fn a_source_is_known_by_links_too_and_is_not_deleted() {
    use std::os::unix::fs::symlink;
    let t = Bench::new();
    ok(&t.bake(&number(1, &["a", "b"])));
    // A published file becomes the source of the next bake, through a link and a hard link elsewhere.
    symlink(t.path("out/test/number.txt"), t.path("link.txt")).unwrap();
    fs::hard_link(t.path("out/test/number.txt"), t.path("hard.txt")).unwrap();
    fs::write(t.path("out/test/number.txt"), "7").unwrap();
    for name in ["link.txt", "hard.txt"] {
        let e = refused(&t, &from_source(&t.path(name), "number.txt"), |_| {});
        assert!(e.contains("this bake reads that file (as ") && e.contains(name), "{e}");
    }
    fs::copy(t.path("out/test/deep/a.txt"), t.path("kept")).unwrap();
    // It is stale for the new bake, but its source: it stays.
    let r = t.bake(&from_source(&t.path("out/test/deep/a.txt"), "other.txt"));
    assert_eq!(fs::read(t.path("out/test/deep/a.txt")).unwrap(), fs::read(t.path("kept")).unwrap());
    assert!(r.errors.is_empty() && !t.path("out/test/deep/b.txt").exists());
}

#[test]
fn what_is_not_ours_is_replaced_only_when_asked() {
    let t = Bench::new();
    fs::create_dir_all(t.path("out/test/deep")).unwrap();
    let mine = t.path("out/test/deep/b.txt");
    fs::write(&mine, "mine").unwrap();
    let e = refused(&t, &number(1, &["a", "b"]), |_| {});
    assert!(e.contains("b.txt") && e.contains("--overwrite"), "{e}");
    assert_eq!(tree(&t.path("out/test")).into_keys().collect::<Vec<_>>(), ["deep/b.txt"], "nothing is half published");
    ok(&t.bake_with(&number(1, &["a", "b"]), |o| o.overwrite = true));
    assert!(t.file("deep/b.txt").starts_with('1'));
    // From now on it is ours.
    ok(&t.bake(&number(2, &["a", "b"])));
    // Single files, `run.json` and a foreign manifest are seen before anything runs.
    for name in ["number.txt", "run.json", "manifest.json"] {
        let t = Bench::new();
        fs::create_dir_all(t.path("out/test")).unwrap();
        fs::write(t.path("out/test").join(name), "{\"name\":\"my web app\"}").unwrap();
        let e = refused(&t, &number(1, &["a"]), |_| {});
        assert!(e.contains(name) && e.contains("--overwrite"), "{e}");
        ok(&t.bake_with(&number(1, &["a"]), |o| o.overwrite = true));
        assert_eq!(ok(&t.bake(&number(1, &["a"]))).published.len(), 0);
    }
    // A folder in the way is named, `--overwrite` or not.
    let t = Bench::new();
    fs::create_dir_all(t.path("out/test/number.txt")).unwrap();
    for overwrite in [false, true] {
        let e = refused(&t, &number(1, &["a"]), |o| o.overwrite = overwrite);
        assert!(e.contains("number.txt") && e.contains("folder"), "{e}");
    }
}

#[cfg(unix)]
#[test]
fn what_cannot_be_read_is_rewritten_where_it_is_ours() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    let t = Bench::new();
    ok(&t.bake(&number(1, &["a", "b"])));
    let good = tree(&t.path("out"));
    fs::set_permissions(t.path("out/test/number.txt"), fs::Permissions::from_mode(0o000)).unwrap();
    fs::remove_file(t.path("out/test/deep/a.txt")).unwrap();
    symlink("/nowhere/at/all", t.path("out/test/deep/a.txt")).unwrap();
    ok(&t.bake(&number(1, &["a", "b"])));
    fs::set_permissions(t.path("out/test/number.txt"), fs::Permissions::from_mode(0o644)).unwrap();
    assert_eq!(tree(&t.path("out")), good);
    // A link that is not ours is refused.
    symlink("/nowhere/at/all", t.path("out/test/deep/c.txt")).unwrap();
    assert!(refused(&t, &number(1, &["c"]), |_| {}).contains("c.txt"));
}

#[cfg(unix)]
#[test]
fn a_bake_that_changes_nothing_needs_no_writable_folder() {
    use std::os::unix::fs::PermissionsExt as _;
    let t = Bench::new();
    ok(&t.bake(&number(1, &["a"])));
    let before = tree(&t.path("out"));
    let allow = |mode: u32| {
        for folder in ["out/test/deep", "out/test", "out"] {
            fs::set_permissions(t.path(folder), fs::Permissions::from_mode(mode)).unwrap();
        }
    };
    // Also where even the lock cannot be made.
    for lock in [true, false] {
        if !lock {
            fs::remove_file(FolderLock::path(&t.path("out"), "test")).unwrap();
        }
        allow(0o555);
        let writable = fs::write(t.path("out/probe"), "").is_ok();
        let same = t.bake(&number(1, &["a"]));
        let changed = bake(&number(2, &["a"]), &t.options(), &Stop::default(), &Silent);
        allow(0o755);
        assert_eq!((ok(&same).runs(), same.published.len()), (0, 0));
        // For the administrator every folder is writable.
        if writable {
            return;
        }
        assert!(changed.unwrap_err().to_string().contains("cannot publish"));
        let after = tree(&t.path("out")).into_iter().filter(|(name, _)| !name.contains("-lock"));
        assert!(after.eq(before.clone().into_iter().filter(|(name, _)| !name.contains("-lock"))));
    }
}

#[test]
fn a_killed_publication_is_taken_up_and_leaves_nothing() {
    let t = Bench::new();
    ok(&t.bake(&number(1, &["a"])));
    let clean = tree(&t.path("out"));
    // As a bake leaves it that was killed while it moved its files: a new file in its place, one beside its place.
    let lock = FolderLock::take(&t.path("out"), "test").unwrap().unwrap();
    let left = lock.stage(&t.path("out/test/deep/c.txt"), b"half").unwrap();
    drop(lock);
    fs::write(t.path("out/test/deep/b.txt"), "new").unwrap();
    let entry = |text: &str| json!({ "blake3": blake3::hash(text.as_bytes()).to_hex().as_str(), "bytes": text.len() });
    let pending = json!({ "pipeline": "", "files": { "deep/b.txt": entry("new"), "deep/c.txt": entry("half") } });
    fs::write(t.path("out/test/.farfield-pending.json"), pending.to_string()).unwrap();
    ok(&t.bake(&number(1, &["a"])));
    assert!(!left.exists());
    assert_eq!(tree(&t.path("out")), clean);
    // Its new file may be replaced.
    fs::write(t.path("out/test/deep/b.txt"), "new").unwrap();
    fs::write(t.path("out/test/.farfield-pending.json"), pending.to_string()).unwrap();
    ok(&t.bake(&number(1, &["a", "b"])));
    assert!(t.file("deep/b.txt").starts_with('1'));
}

#[derive(Default)]
struct Warnings(Mutex<Vec<String>>);

impl Events for Warnings {
    fn event(&self, event: &Event) {
        match event {
            Event::Warning { text, .. } => self.0.lock().unwrap().push((*text).to_owned()),
            Event::Waiting { what, holder } => self.0.lock().unwrap().push(format!("waits for {what}: {holder}")),
            _ => {}
        }
    }
}

#[test]
fn a_bake_that_waits_says_so() {
    let t = Bench::new();
    let lock = FolderLock::take(&t.path("out"), "test").unwrap().unwrap();
    let told = Warnings::default();
    std::thread::scope(|scope| {
        let baking = scope.spawn(|| bake(&number(1, &["a"]), &t.options(), &Stop::default(), &told).unwrap());
        while told.0.lock().unwrap().is_empty() {
            std::thread::sleep(Duration::from_millis(5));
        }
        drop(lock);
        ok(&baking.join().unwrap());
    });
    let told = told.0.into_inner().unwrap();
    let own = format!("process {}", std::process::id());
    assert!(told.len() == 1 && told[0].contains("waits for the output folder") && told[0].contains(&own), "{told:?}");
}

#[test]
fn replacing_another_scenes_results_is_told() {
    let t = Bench::new();
    let of = |scene: &str, value: i64| Plan { sources: vec![scene.to_owned()], ..number(value, &["a"]) };
    let told = |plan: &Plan| {
        let told = Warnings::default();
        ok(&bake(plan, &t.options(), &Stop::default(), &told).unwrap());
        told.0.into_inner().unwrap()
    };
    assert!(told(&of("a/town.glb", 1)).is_empty());
    assert!(told(&of("a/town.glb", 2)).is_empty());
    let text = told(&of("b/town.glb", 3));
    assert!(text.len() == 1 && text[0].contains("`a/town.glb`") && text[0].contains("--name"), "{text:?}");
    assert!(told(&of("b/town.glb", 4)).is_empty());
}

const CHILD: &str = "FARFIELD_TEST_PUBLISH_CHILD";

/// Not a test of its own: one of the bakes that the test below starts.
#[test]
fn child() {
    let Ok(spec) = std::env::var(CHILD) else { return };
    let [value, cache, out] = spec.splitn(3, ' ').collect::<Vec<_>>()[..] else { panic!("{spec}") };
    let value: i64 = value.parse().unwrap();
    let options = Options { jobs: 2, ..Options::new(cache, out) };
    let report = bake(&many_files(value), &options, &Stop::default(), &Silent).unwrap();
    ok(&report);
}

/// Files with the same names, and some with names of their own, for each value.
fn many_files(value: i64) -> Plan {
    let names: Vec<String> = (0..6).map(|i| format!("n{i}")).chain([format!("own{value}")]).collect();
    number(value, &names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// `FARFIELD_ROUNDS` says how often; 12 by default.
#[test]
fn bakes_with_different_caches_never_mix_files() {
    let rounds: i64 = std::env::var("FARFIELD_ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(12);
    let t = Bench::new();
    let mut expected = Vec::new();
    for value in 0..3 {
        let alone = Bench::new();
        ok(&alone.bake(&many_files(value)));
        expected.push(tree(&alone.path("out/test")));
    }
    let mut last = BTreeSet::new();
    for round in 0..rounds {
        let start = |value: i64| {
            // Another spelling of the folder each.
            let out = [t.path("out"), t.path("x/../out"), t.path("out/.")][value as usize].clone();
            let cache = t.path(&format!("cache{value}"));
            Command::new(std::env::current_exe().unwrap())
                .args(["--exact", "publish::child"])
                .env(CHILD, format!("{value} {} {}", cache.display(), out.display()))
                .arg("--nocapture")
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap()
        };
        fs::create_dir_all(t.path("x")).unwrap();
        let children: Vec<_> = (0..3).map(|i| start((round + i) % 3)).collect();
        for child in children {
            let ran = child.wait_with_output().unwrap();
            assert!(ran.status.success(), "round {round}: {}", String::from_utf8_lossy(&ran.stderr));
        }
        let found = expected.iter().position(|e| *e == tree(&t.path("out/test")));
        last.insert(found.unwrap_or_else(|| panic!("round {round}: mixed {:?}", tree(&t.path("out/test")).keys())));
    }
    assert!(!last.is_empty());
}

fn bundles(value: i64, extra: bool, folders: &[&str]) -> Plan {
    let mut b = Builder::default();
    let c = b.node::<Constant>("c", json!({ "value": value }), &[]);
    let pack = b.node::<Pack>("pack", json!({ "extra": extra }), &[From::Node(c)]);
    folders.iter().for_each(|folder| b.file(folder, pack));
    b.plan()
}

#[test]
fn a_bundle_is_published_below_its_folder() {
    let t = Bench::new();
    let r = t.bake(&bundles(4, true, &["a/", "./"]));
    ok(&r);
    assert_eq!(r.published.len(), 6);
    for folder in ["", "a/"] {
        assert_eq!(t.file(&format!("{folder}main.json")), "4");
        assert_eq!(t.file(&format!("{folder}parts/even.txt")), "4");
    }
    // Nothing to do; then only what differs, and what a bundle no longer holds goes.
    let again = t.bake(&bundles(4, true, &["a/", "./"]));
    assert_eq!((again.runs(), again.published.len()), (0, 0));
    let changed = t.bake(&bundles(5, false, &["a/", "./"]));
    ok(&changed);
    assert_eq!(changed.published, ["a/main.json", "main.json"]);
    assert!(t.path("out/test/parts/even.txt").exists() && !t.path("out/test/parts/extra.txt").exists());
    // A file that was deleted comes back without a run.
    fs::remove_file(t.path("out/test/a/parts/even.txt")).unwrap();
    let mended = t.bake(&bundles(5, false, &["a/", "./"]));
    assert_eq!((mended.runs(), &mended.published[..]), (0, &["a/parts/even.txt".to_owned()][..]));
}

#[test]
fn a_bundle_collides_with_no_other_file() {
    let t = Bench::new();
    let mut b = Builder::default();
    let c = b.node::<Constant>("c", json!({ "value": 1 }), &[]);
    let pack = b.node::<Pack>("pack", json!({}), &[From::Node(c)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(c)]);
    b.file("a/", pack);
    b.file("a/Main.json", print);
    let e = refused(&t, &b.plan(), |_| {});
    assert!(e.contains("collides"), "{e}");
}

#[test]
fn bundles_of_a_list_lie_in_folders_of_their_names() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["x", "y"], "values": [2, 3] }), &[]);
    let pack = b.node::<Pack>("pack", json!({}), &[From::Node(list)]);
    b.file("each/{name}/", pack);
    ok(&t.bake(&b.plan()));
    assert_eq!((t.file("each/x/main.json"), t.file("each/y/main.json")), ("2".into(), "3".into()));
}
