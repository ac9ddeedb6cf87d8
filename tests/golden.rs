//! The bytes that every kind and method makes of a small fixed input (`golden/kinds.toml`), as hashes (`golden/hashes.txt`).
//!
//! A line is `kind method version inputs port hash`; `-` stands for no method, `inputs` is a hash of parameters and inputs. Other bytes
//! from the same inputs under the same version would be taken from caches that hold the old ones: such a change needs a new `VERSION`.
//! `FARFIELD_UPDATE_GOLDEN=1 cargo test --test golden` writes the hashes anew, except where a version must be raised first.

use farfield::{
    engine::{
        bake::{Options, Outcome, bake},
        cache::Cache,
        events::Silent,
        hash::Digest,
        pipeline::{Request, load_text},
        plan::{Plan, PlanNode},
        record::{BakeRecord, NodeTrace},
        value::PortOut,
    },
    math::Stop,
    nodes,
};
use std::{collections::BTreeMap, fmt, path::Path};

/// What a port made, and of what.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Made {
    version: u32,
    inputs: String,
    hash: String,
}

/// Kind, method and port.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Port(String, String, String);

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self(kind, method, port) = self;
        write!(f, "{kind} {method}, output `{port}`")
    }
}

type Hashes = BTreeMap<Port, Made>;

fn file(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name)
}

fn read(text: &str) -> Hashes {
    let line = |line: &str| {
        let [kind, method, version, inputs, port, hash] = line.split_whitespace().collect::<Vec<_>>()[..] else {
            panic!("expected `kind method version inputs port hash`, found `{line}`");
        };
        let port = Port(kind.into(), method.into(), port.into());
        (port, Made { version: version.parse().unwrap(), inputs: inputs.into(), hash: hash.into() })
    };
    text.lines().filter(|l| !l.starts_with('#')).map(line).collect()
}

fn write(hashes: &Hashes) -> String {
    let line = |(Port(kind, method, port), made): (&Port, &Made)| {
        format!("{kind} {method} {} {} {port} {}\n", made.version, made.inputs, made.hash)
    };
    "# Written by FARFIELD_UPDATE_GOLDEN=1 cargo test --test golden\n".to_owned()
        + &hashes.iter().map(line).collect::<String>()
}

/// What has changed in a way that it may not, in words.
fn judge(expected: &Hashes, found: &Hashes) -> Vec<String> {
    let mut wrong = Vec::new();
    for (port, made) in found {
        match expected.get(port) {
            Some(old) if old.version == made.version && old.inputs == made.inputs && old.hash != made.hash => {
                let v = made.version;
                wrong.push(format!(
                    "{port}: other bytes from the same inputs under version {v}; raise its VERSION to {}",
                    v + 1
                ));
            }
            Some(old) if old.version > made.version => {
                wrong.push(format!("{port}: version {} is less than the recorded {}", made.version, old.version));
            }
            _ => {}
        }
    }
    wrong
}

/// A hash of several, shortened: equal by chance once in 2⁶⁴.
fn short(parts: impl IntoIterator<Item = (String, Digest)>) -> String {
    let mut text = String::new();
    for (name, digest) in parts {
        text += &format!("{name} {}\n", digest.hex());
    }
    Digest::of(text.as_bytes()).hex()[..16].to_owned()
}

fn plan() -> Plan {
    let text = std::fs::read_to_string(file("kinds.toml")).unwrap();
    let folder = file("");
    let request = Request::new("kinds.toml", &folder, &[]);
    load_text("kinds.toml", &text, &request, &nodes::registry()).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Inputs, and per row what came out of each port.
fn looked_up(cache: &mut Cache, trace: &NodeTrace) -> (Vec<Digest>, Vec<(String, Vec<PortOut>)>) {
    if trace.mapped {
        let map = cache.map(&trace.key).unwrap().unwrap();
        return (map.inputs, map.rows.into_iter().map(|row| (row.name.to_string(), row.outputs)).collect());
    }
    let (_, run) = cache.runs(&trace.key).unwrap().pop().unwrap();
    (run.inputs.clone(), vec![(String::new(), run.outputs.clone())])
}

fn hashes(node: &PlanNode, trace: &NodeTrace, cache: &mut Cache) -> Hashes {
    let spec = node.kind.spec();
    let (inputs, rows) = looked_up(cache, trace);
    let params = ("params".to_owned(), Digest::of(node.params.json().to_string().as_bytes()));
    let inputs = short(inputs.into_iter().map(|hash| ("input".to_owned(), hash)).chain([params]));
    let method = if spec.method.is_empty() { "-" } else { spec.method };
    let ports = spec.outputs.iter().enumerate().map(|(at, port)| {
        let mut parts = Vec::new();
        for (row, outputs) in &rows {
            match &outputs[at] {
                PortOut::One(value) => parts.push((row.clone(), value.hash)),
                PortOut::Many(items) => parts.extend(items.iter().map(|(name, v)| (format!("{row}/{name}"), v.hash))),
            }
        }
        // `take-chosen` hands on inputs as they are, and without certificates, which native code makes, nothing is chosen.
        let may_be_nothing = port.ty.name == "Scene" || spec.name == "take-chosen";
        assert!(!parts.is_empty() || may_be_nothing, "{} makes nothing through {}", node.name, port.name);
        let made = Made { version: spec.version, inputs: inputs.clone(), hash: short(parts) };
        (Port(spec.name.into(), method.into(), port.name.into()), made)
    });
    ports.collect()
}

#[test]
fn the_same_inputs_give_the_same_bytes_until_the_version_grows() {
    let plan = plan();
    for kind in nodes::registry().iter() {
        let spec = kind.spec();
        let shown = plan.nodes.iter().any(|n| n.kind.spec().title() == spec.title());
        // What native code gives may depend on target and CPU, so no hash holds everywhere.
        assert!(shown || spec.native, "{}: tests/golden/kinds.toml has no node of it", spec.title());
    }
    let folder = tempfile::tempdir().unwrap();
    let (at_cache, out) = (folder.path().join("cache"), folder.path().join("out"));
    let report = bake(&plan, &Options::new(&at_cache, &out), &Stop::default(), &Silent).unwrap();
    assert_eq!(report.outcome, Outcome::Baked, "{:?}", report.errors);
    let mut cache = Cache::open(&at_cache, false).unwrap();
    let key = std::path::absolute(out.join(&plan.name)).unwrap().to_string_lossy().into_owned();
    let record: BakeRecord = cache.bakes(&plan.name, &key, 1).unwrap().records.pop().unwrap();
    let mut found = Hashes::new();
    for node in plan.nodes.iter().filter(|n| !n.kind.spec().native) {
        let trace = record.node(&node.name).unwrap();
        found.extend(hashes(node, trace, &mut cache));
    }
    let path = file("hashes.txt");
    let expected = read(&std::fs::read_to_string(&path).unwrap_or_default());
    let wrong = judge(&expected, &found);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    if std::env::var_os("FARFIELD_UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, write(&found)).unwrap();
    } else {
        let (expected, found) = (write(&expected), write(&found));
        assert_eq!(expected, found, "run FARFIELD_UPDATE_GOLDEN=1 cargo test --test golden and read what it changed");
    }
}

#[test]
fn only_a_new_version_or_other_inputs_excuse_other_bytes() {
    let made = |version: u32, inputs: &str, hash: &str| {
        let text = format!("collapse voxel-cover {version} {inputs} mesh {hash}\n");
        assert_eq!(write(&read(&text)).lines().nth(1), text.lines().next());
        read(&text)
    };
    let old = made(2, "a", "x");
    assert_eq!(judge(&old, &made(2, "a", "x")), Vec::<String>::new());
    assert_eq!(judge(&old, &made(3, "a", "y")), Vec::<String>::new());
    assert_eq!(judge(&old, &made(2, "b", "y")), Vec::<String>::new());
    let expect =
        "collapse voxel-cover, output `mesh`: other bytes from the same inputs under version 2; raise its VERSION to 3";
    assert_eq!(judge(&old, &made(2, "a", "y")), [expect]);
    assert_eq!(judge(&old, &made(1, "a", "x")).len(), 1);
}
