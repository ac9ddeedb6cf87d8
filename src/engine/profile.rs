//! A Chrome trace of the bake (`chrome://tracing`, Perfetto): one row per slot, one span per run.

use super::cache::files::nanoseconds;
use serde_json::json;
use std::{
    fs, io,
    path::Path,
    time::{Instant, SystemTime},
};

pub struct Profile {
    began: Instant,
    began_at: i128,
    on: bool,
    spans: Vec<Span>,
}

struct Span {
    lane: usize,
    category: &'static str,
    name: String,
    from: f64,
    length: f64,
}

impl Profile {
    /// `on`: whether spans are kept at all.
    pub fn new(on: bool) -> Self {
        Self { began: Instant::now(), began_at: nanoseconds(SystemTime::now()), on, spans: Vec::new() }
    }

    /// Nanoseconds since 1970.
    pub fn began_at(&self) -> i128 {
        self.began_at
    }

    /// Seconds since the beginning.
    pub fn seconds(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Lane 0 is the scheduler; `name` is made only where spans are kept.
    pub fn span(
        &mut self,
        lane: usize,
        category: &'static str,
        name: impl FnOnce() -> String,
        from: Instant,
        to: Instant,
    ) {
        if self.on {
            let micros = |t: Instant| t.saturating_duration_since(self.began).as_secs_f64() * 1e6;
            let (from, to) = (micros(from), micros(to));
            self.spans.push(Span { lane, category, name: name(), from, length: to - from });
        }
    }

    pub fn write(&self, path: &Path) -> io::Result<()> {
        let span = |s: &Span| json!({ "ph": "X", "pid": 1, "tid": s.lane, "cat": s.category, "name": s.name, "ts": s.from, "dur": s.length });
        let events: Vec<_> = self.spans.iter().map(span).collect();
        fs::write(path, serde_json::to_vec(&json!({ "displayTimeUnit": "ms", "traceEvents": events }))?)
    }
}
