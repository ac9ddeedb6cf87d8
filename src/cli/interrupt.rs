//! Ctrl-C and SIGTERM: the first asks to finish what is held, the second leaves at once.

use super::{Done, Exit};
use crate::math::Stop;
use std::sync::atomic::{AtomicBool, Ordering};

/// A stop that the first interruption sets.
pub fn stop() -> Result<Stop, Exit> {
    let stop = Stop::default();
    let set = stop.clone();
    on(move || {
        super::terminal::say("interrupted: finishing what runs (a second Ctrl-C leaves at once)");
        set.set();
    })?;
    Ok(stop)
}

/// Calls `first` at the first interruption; the second leaves at once.
pub fn on(first: impl Fn() + Send + 'static) -> Done {
    let again = AtomicBool::new(false);
    let handler = move || {
        if again.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        first();
    };
    ctrlc::set_handler(handler).map_err(|e| Exit::say(1, format!("cannot listen for Ctrl-C: {e}")))
}
