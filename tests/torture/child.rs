//! Processes to be killed, stopped and lied to: this program again, with a job in an environment variable.

use super::{Bench, plan};
use farfield::{
    engine::{
        bake::{Options, Outcome, bake},
        cache::{self, Limits},
        events::Silent,
    },
    math::Stop,
};
use std::{
    path::Path,
    process::{Command, Stdio},
};

const JOB: &str = "FARFIELD_TEST_TORTURE_JOB";
/// Exit code of a child whose job gave an error, which it has told.
pub const TOLD: i32 = 3;
/// Elements in the lists of children's plans.
pub const ELEMENTS: i64 = 3;

/// What a child does in the folder of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// Bakes this variant, with so many elements, into a folder of the variant's number.
    Bake(i64, i64),
    Sweep,
    Rebuild,
    Verify,
    /// Sweeps and verifies until the file `done` is there.
    Sweeps,
}

/// The least that a sweep may keep.
pub fn nothing_kept() -> Limits {
    Limits { max_bytes: Some(0), max_age: Some(std::time::Duration::ZERO), keep_bakes: Some(0) }
}

impl Job {
    fn text(self) -> String {
        match self {
            Self::Bake(variant, elements) => format!("bake {variant} {elements}"),
            other => format!("{other:?}"),
        }
    }

    /// The child that does it.
    pub fn command(self, folder: &Path) -> Command {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command
            .args(["--exact", "child::child", "--nocapture"])
            .env(JOB, format!("{} {}", self.text(), folder.display()));
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }
}

/// The output folder of a variant.
pub fn options(folder: &Path, variant: i64) -> Options {
    let out = folder.join(format!("out-{variant}"));
    Options { jobs: 2, memory: 1 << 30, ..Options::new(folder.join("cache"), out) }
}

/// Bakes a variant in this process, undisturbed.
pub fn undisturbed(t: &Bench, variant: i64, elements: i64) {
    let report = bake(&plan(variant, elements), &options(&t.path(""), variant), &Stop::default(), &Silent)
        .unwrap_or_else(|e| panic!("an undisturbed bake: {e}"));
    assert_eq!(report.outcome, Outcome::Baked, "{:?}", report.errors);
}

fn baked(folder: &Path, variant: i64, elements: i64) -> Result<(), String> {
    let report = bake(&plan(variant, elements), &options(folder, variant), &Stop::default(), &Silent);
    let report = report.map_err(|e| e.to_string())?;
    match report.outcome {
        Outcome::Baked => Ok(()),
        _ => Err(report.errors.into_iter().map(|e| format!("{}: {}\n", e.node, e.message)).collect()),
    }
}

/// Not a test of its own: what the tests run.
#[test]
fn child() {
    let Ok(job) = std::env::var(JOB) else { return };
    let (job, rest) = job.split_once(' ').unwrap();
    let cache = |folder: &str| Path::new(folder).join("cache");
    let stop = Stop::default();
    let text = |e: farfield::engine::error::EngineError| e.to_string();
    let done = match job {
        "bake" => {
            let [variant, elements, folder] = rest.splitn(3, ' ').collect::<Vec<_>>()[..] else { panic!("{rest}") };
            baked(Path::new(folder), variant.parse().unwrap(), elements.parse().unwrap())
        }
        "Sweep" => cache::gc(&cache(rest), &nothing_kept()).map(drop).map_err(text),
        "Rebuild" => cache::rebuild(&cache(rest), &stop).map(drop).map_err(text),
        "Verify" => cache::verify(&cache(rest), &stop).map(drop).map_err(text),
        "Sweeps" => loop {
            if Path::new(rest).join("done").exists() {
                break Ok(());
            }
            let swept = cache::gc(&cache(rest), &nothing_kept()).map_err(text);
            let verified = cache::verify(&cache(rest), &stop).map_err(text);
            match (swept, verified) {
                (Err(e), _) | (_, Err(e)) => break Err(e),
                // A record may be dropped: a bake stores a list of which the sweep took a part that the bake found before.
                (_, Ok(Some(found))) if !found.bad.is_empty() => break Err(format!("bad values: {found:?}")),
                _ => std::thread::sleep(std::time::Duration::from_millis(10)),
            }
        },
        other => panic!("no such job: {other}"),
    };
    if let Err(what) = done {
        eprintln!("told: {what}");
        std::process::exit(TOLD);
    }
}
