//! Ctrl-C and SIGTERM: the first asks the bake to finish what it holds, the second leaves at once.

use super::Exit;
use crate::math::Stop;
use std::sync::atomic::{AtomicBool, Ordering};

/// A stop that the first interruption sets.
pub fn stop() -> Result<Stop, Exit> {
    let stop = Stop::default();
    let (set, again) = (stop.clone(), AtomicBool::new(false));
    let handler = move || {
        if again.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        super::terminal::say("interrupted: finishing what runs (a second Ctrl-C leaves at once)");
        set.set();
    };
    ctrlc::set_handler(handler).map_err(|e| Exit::say(1, format!("cannot listen for Ctrl-C: {e}")))?;
    Ok(stop)
}
