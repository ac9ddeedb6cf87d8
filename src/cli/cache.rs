//! `farfield cache`.

use super::{
    Done, Exit,
    folders::CacheArg,
    interrupt, print,
    quantity::{bytes, duration, show_bytes},
};
use crate::engine::cache::{self, Limits};
use std::time::Duration;

/// Looks after the cache
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Says what the cache holds
    Stats {
        #[command(flatten)]
        cache: CacheArg,
    },
    /// Reads every value and compares it with its hash; what is bad is set aside and will be computed again
    Verify {
        #[command(flatten)]
        cache: CacheArg,
    },
    /// Removes what was not used for longest; what recent bakes need stays
    Gc {
        #[command(flatten)]
        cache: CacheArg,
        /// Shrink the cache to this size: 20GiB
        #[arg(long, value_name = "SIZE", value_parser = bytes, required_unless_present = "max_age")]
        max_size: Option<u64>,
        /// Remove what was not used for so long: 30d
        #[arg(long, value_name = "AGE", value_parser = duration)]
        max_age: Option<Duration>,
    },
}

pub fn run(args: &Args) -> Done {
    match &args.action {
        Action::Stats { cache } => {
            let s = cache::stats(&cache.folder())?;
            print(&format!(
                "cache    {}\nresults  {} runs, {} maps\nvalues   {}, {}\nin index {}, {}\nindex    {}\nbakes    {} on record\n",
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
            let v = cache::verify(&cache.folder(), &interrupt::stop()?)?;
            for bad in &v.bad {
                print(&format!("bad: {bad}\n"))?;
            }
            if v.bad.is_empty() && v.dropped_records == 0 {
                return print(&format!("clean: {} values, {}\n", v.values, show_bytes(v.bytes)));
            }
            let found = format!("{} bad values set aside, {} records removed", v.bad.len(), v.dropped_records);
            Err(Exit::say(1, format!("{found}; the next bake computes them again")))
        }
        Action::Gc { cache, max_size, max_age } => {
            let limits = Limits { max_bytes: *max_size, max_age: *max_age };
            let c = cache::gc(&cache.folder(), &limits)?;
            print(&format!(
                "removed {} runs and {} values ({}); {} remain\n",
                c.runs,
                c.values,
                show_bytes(c.bytes),
                show_bytes(c.left_bytes)
            ))
        }
    }
}
