//! `farfield cache`.

use super::{
    Done, Exit,
    folders::CacheArg,
    interrupt, print,
    quantity::{bytes, duration, show_bytes},
};
use crate::engine::cache::{self, Collected, Limits, Rebuilt};
use std::time::Duration;

/// Shows, verifies and shrinks the cache
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Shows what the cache holds
    Stats {
        #[command(flatten)]
        cache: CacheArg,
    },
    /// Checks the index and compares every value with its hash; damaged values are set aside and will be recomputed
    Verify {
        #[command(flatten)]
        cache: CacheArg,
    },
    /// Makes the index anew from the values and from what a damaged index still says
    Rebuild {
        #[command(flatten)]
        cache: CacheArg,
    },
    /// Evicts the least recently used results, except those that recent bakes need. At least one limit is needed
    Gc {
        #[command(flatten)]
        cache: CacheArg,
        /// Evict the least recently used results until the values take at most this: 20GiB
        #[arg(long, value_name = "SIZE", value_parser = bytes, required_unless_present_any = ["max_age", "keep_bakes"])]
        max_size: Option<u64>,
        /// Evict results that were not used for this long: 30d
        #[arg(long, value_name = "AGE", value_parser = duration)]
        max_age: Option<Duration>,
        /// Keep only the records of the last N bakes, over all pipelines, and what they need [default: all records, and what the last 20 need]
        #[arg(long, value_name = "N")]
        keep_bakes: Option<u64>,
    },
}

pub fn run(args: &Args) -> Done {
    match &args.action {
        Action::Stats { cache } => {
            let Some(s) = cache::stats(&cache.folder())? else { return none(cache) };
            let read_only = s.read_only.map_or(String::new(), |why| format!("read only {why}\n"));
            print(&format!(
                "cache    {}\nresults  {} runs, {} maps\nvalues   {}, {}\nin index {}, {}\nindex    {}\nbakes    {} on record\n{read_only}",
                cache.folder().display(),
                s.runs,
                s.maps,
                s.values,
                show_bytes(s.bytes),
                s.inline_values,
                show_bytes(s.inline_bytes),
                show_bytes(s.index_bytes),
                s.bakes
            ))
        }
        Action::Verify { cache } => {
            let Some(v) = cache::verify(&cache.folder(), &interrupt::stop()?)? else { return none(cache) };
            for bad in &v.bad {
                print(&format!("bad: {bad}\n"))?;
            }
            if v.is_clean() {
                return print(&format!("clean: {} values, {}\n", v.values, show_bytes(v.bytes)));
            }
            let (bad, records) = (count(v.bad.len() as u64, "bad value"), count(v.dropped_records, "bad record"));
            Err(Exit::say(
                1,
                match v.read_only {
                    Some(why) => format!("{bad}, {records}; they stay, because the cache cannot be written ({why})"),
                    None => format!("{bad} set aside, {records} removed; the next bake computes them again"),
                },
            ))
        }
        Action::Rebuild { cache } => {
            let Some(r) = cache::rebuild(&cache.folder(), &interrupt::stop()?)? else { return none(cache) };
            print(&rebuilt(&r))
        }
        Action::Gc { cache, max_size, max_age, keep_bakes } => {
            let limits = Limits { max_bytes: *max_size, max_age: *max_age, keep_bakes: *keep_bakes };
            let Some(c) = cache::gc(&cache.folder(), &limits)? else { return none(cache) };
            print(&collected(&c, &limits))
        }
    }
}

fn none(cache: &CacheArg) -> Done {
    print(&format!("{}: no cache yet; a bake makes it\n", cache.folder().display()))
}

fn count(n: u64, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// What the new index holds, and what was lost.
fn rebuilt(r: &Rebuilt) -> String {
    let mut out: String = r.bad.iter().map(|bad| format!("bad: {bad}\n")).collect();
    let (runs, maps, bakes) = (count(r.runs, "run"), count(r.maps, "map"), count(r.bakes, "record"));
    out += &format!("the index is made anew: {runs}, {maps}, {bakes} of bakes, ");
    out += &format!("{} ({})\n", count(r.values, "value"), show_bytes(r.bytes));
    if !r.bad.is_empty() || r.dropped_records > 0 {
        let (bad, records) = (count(r.bad.len() as u64, "bad value"), count(r.dropped_records, "record"));
        out += &format!("{bad} set aside, {records} dropped; the next bake computes again what it needs\n");
    }
    out
}

/// What a sweep did, and why it did not do more.
fn collected(c: &Collected, limits: &Limits) -> String {
    let mut out = String::new();
    if let Some(what) = &c.damaged {
        out += &format!("the index was damaged ({what}) and set aside, and all results with it\n");
    }
    let (runs, values) = (count(c.runs, "result"), count(c.values, "value"));
    out += &format!("removed {runs} and {values} ({}); {} remain\n", show_bytes(c.bytes), show_bytes(c.left_bytes));
    if let Some(max) = limits.max_bytes.filter(|max| c.left_bytes > *max) {
        let bakes = if c.kept_bakes == 1 {
            "the last bake on record needs".to_owned()
        } else {
            format!("the last {} bakes on record need", c.kept_bakes)
        };
        out += &format!("that is more than {}: {bakes} {}", show_bytes(max), show_bytes(c.kept_bytes));
        out += if c.living { ", and a bake is at work\n" } else { "\n" };
        if c.kept_bakes > 0 {
            out += "with `--keep-bakes 1` only the last one keeps its results, with `--keep-bakes 0` none; what is missing is \
                    computed again when a bake needs it\n";
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_that_cannot_reach_the_size_says_why() {
        let limits = Limits { max_bytes: Some(1_000_000), ..Limits::default() };
        let kept = Collected { left_bytes: 3 << 20, kept_bytes: 3 << 20, kept_bakes: 2, ..Collected::default() };
        let text = collected(&kept, &limits);
        assert!(text.contains("the last 2 bakes on record need 3.0 MiB") && text.contains("--keep-bakes 0"), "{text}");
        let reached = Collected { left_bytes: 5, ..Collected::default() };
        assert_eq!(collected(&reached, &limits).lines().count(), 1);
    }
}
