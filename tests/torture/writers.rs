//! Eight bakes of one cache, some of them into one folder, while sweeps delete what they may and processes are stopped for a while.

#![cfg(unix)]

use super::{
    Bench, cases,
    child::{Job, undisturbed},
    tree,
};
use std::{
    fs,
    process::{Child, Command},
    time::{Duration, Instant},
};

const ELEMENTS: i64 = 8;
const WRITERS: usize = 8;
/// Variants: each is baked by two of the writers at a time.
const VARIANTS: i64 = 4;
/// After so long without an end the processes are locked up.
const PATIENCE: Duration = Duration::from_secs(120);

fn signal(name: &str, child: &Child) {
    // One that has ended meanwhile cannot be signalled.
    let _ = Command::new("kill").args([name, &child.id().to_string()]).stderr(std::process::Stdio::null()).status();
}

/// What the system says of a process.
fn state(child: &Child) -> String {
    let read = |name: &str| fs::read_to_string(format!("/proc/{}/{name}", child.id())).unwrap_or_default();
    let status: String =
        read("status").lines().filter(|l| l.starts_with("State") || l.starts_with("Threads")).collect();
    format!("{} {status} waits in {}", child.id(), read("wchan"))
}

/// Ends the processes, whatever becomes of the test.
struct Children(Vec<(Job, Child)>);

impl Drop for Children {
    fn drop(&mut self) {
        for (_, child) in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Children {
    fn start(&mut self, t: &Bench, job: Job) {
        self.0.push((job, job.command(&t.path("")).spawn().unwrap()));
    }

    /// Waits for the end of the bakes, or of all, stopping and waking others meanwhile. Gives how often.
    fn torment(&mut self, all: bool, mut random: impl FnMut(usize) -> usize) -> usize {
        let (began, mut stops) = (Instant::now(), 0);
        loop {
            // Only those whose end was not met: the number of any other may be another process's by now.
            let mut living = Vec::new();
            for (i, (_, child)) in self.0.iter_mut().enumerate() {
                if child.try_wait().unwrap().is_none() {
                    living.push(i);
                }
            }
            if !living.iter().any(|i| all || matches!(self.0[*i].0, Job::Bake(..))) {
                return stops;
            }
            let chosen: Vec<usize> = (0..2).map(|_| living[random(living.len())]).collect();
            chosen.iter().for_each(|i| signal("-STOP", &self.0[*i].1));
            std::thread::sleep(Duration::from_millis(20 + random(150) as u64));
            chosen.iter().for_each(|i| signal("-CONT", &self.0[*i].1));
            stops += chosen.len();
            std::thread::sleep(Duration::from_millis(random(40) as u64));
            if began.elapsed() > PATIENCE {
                let states: Vec<String> =
                    self.0.iter().map(|(job, child)| format!("{job:?} {}", state(child))).collect();
                panic!("no end after {PATIENCE:?}:\n{}", states.join("\n"));
            }
        }
    }
}

#[test]
fn eight_writers_with_sweeps_and_stops_end_well() {
    let clean = Bench::new();
    for variant in 0..VARIANTS {
        undisturbed(&clean, variant, ELEMENTS);
    }
    let mut seed = 7u32;
    let mut random = move |n: usize| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as usize % n
    };
    let (rounds, mut stops) = (cases(3, 300), 0);
    for round in 0..rounds {
        let t = Bench::new();
        let mut children = Children(Vec::new());
        // The first sweep finds a cache.
        undisturbed(&t, 0, 1);
        children.start(&t, Job::Sweeps);
        for i in 0..WRITERS {
            children.start(&t, Job::Bake(i as i64 % VARIANTS, ELEMENTS));
        }
        stops += children.torment(false, &mut random);
        fs::write(t.path("done"), "").unwrap();
        children.torment(true, &mut random);
        for (job, child) in std::mem::take(&mut children.0) {
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "round {round}: {job:?}: {:?}\n{said}", output.status);
        }
        // A list of which a sweep took a part may lead nowhere, no value is bad, and what is found does not last.
        let found = t.verify();
        assert!(found.bad.is_empty(), "round {round}: {found:?}");
        assert!(t.verify().is_clean(), "round {round}");
        for variant in 0..VARIANTS {
            let out = format!("out-{variant}");
            assert!(tree(&t.path(&out)) == tree(&clean.path(&out)), "round {round}: other outputs of {variant}");
            undisturbed(&t, variant, ELEMENTS);
        }
    }
    println!("{rounds} rounds of {WRITERS} writers, {stops} stops");
}
