//! A folder with a cache and an output folder, and what tests ask of bakes in it.

use farfield::{
    engine::{
        bake::{Options, Outcome, Report, bake},
        cache,
        events::Silent,
        plan::Plan,
    },
    math::Stop,
};
use std::{collections::BTreeMap, fs, path::Path};

pub struct Bench(pub tempfile::TempDir);

impl Bench {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("works"))
    }
    pub fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }
    pub fn options(&self) -> Options {
        Options { jobs: 2, memory: 1 << 30, ..Options::new(self.path("cache"), self.path("out")) }
    }
    pub fn bake(&self, plan: &Plan) -> Report {
        self.bake_with(plan, |_| {})
    }
    pub fn bake_with(&self, plan: &Plan, change: impl FnOnce(&mut Options)) -> Report {
        let mut options = self.options();
        change(&mut options);
        bake(plan, &options, &Stop::default(), &Silent).expect("works")
    }
    /// What `verify` finds in the cache that is there.
    pub fn verify(&self) -> cache::Verified {
        cache::verify(&self.path("cache"), &Stop::default()).expect("works").expect("a cache")
    }
    pub fn gc(&self, limits: &cache::Limits) -> cache::Collected {
        cache::gc(&self.path("cache"), limits).expect("works").expect("a cache")
    }
    pub fn file(&self, name: &str) -> String {
        fs::read_to_string(self.path("out/test").join(name)).expect("works")
    }
}

/// `hits/runs` per node.
pub fn counts(r: &Report) -> BTreeMap<&str, (u64, u64)> {
    r.nodes.iter().map(|n| (n.name.as_str(), (n.hits, n.runs))).collect()
}

pub fn ran(r: &Report) -> Vec<&str> {
    r.nodes.iter().filter(|n| n.runs > 0).map(|n| n.name.as_str()).collect()
}

pub fn ok(r: &Report) -> &Report {
    assert_eq!(r.outcome, Outcome::Baked, "{:?}", r.errors);
    r
}

/// Everything below a folder but `run.json`.
pub fn tree(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fn walk(root: &Path, at: &Path, out: &mut BTreeMap<String, Vec<u8>>) {
        let Ok(entries) = fs::read_dir(at) else { return };
        for entry in entries {
            let path = entry.expect("works").path();
            if path.is_dir() {
                walk(root, &path, out);
            } else if path.file_name().expect("works") != "run.json" {
                let name = path.strip_prefix(root).expect("works").to_string_lossy().into_owned();
                out.insert(name, fs::read(&path).expect("works"));
            }
        }
    }
    let mut out = BTreeMap::new();
    walk(folder, folder, &mut out);
    out
}
