//! The folders that the system tells about.

use crate::cli::terminal::{fill, say};
use notify_debouncer_mini::{
    Config, DebounceEventResult, DebouncedEventKind, Debouncer, new_debouncer_opt,
    notify::{self, RecommendedWatcher, RecursiveMode},
};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    time::Duration,
};

/// A file in which nothing happened for so long is saved to its end.
pub const QUIET: Duration = Duration::from_millis(80);

pub struct Folders {
    debouncer: Debouncer<RecommendedWatcher>,
    told: BTreeSet<PathBuf>,
    /// Folders that could not be watched; each is told once.
    refused: BTreeSet<PathBuf>,
}

impl Folders {
    /// `touched` is called with the paths at which something happened, once they are quiet.
    pub fn new(touched: impl Fn(Vec<PathBuf>) + Send + 'static) -> notify::Result<Self> {
        let handler = move |events: DebounceEventResult| {
            // Errors name no path; what is missed is found when all files are looked at.
            let quiet = events.into_iter().flatten().filter(|event| event.kind == DebouncedEventKind::Any);
            let paths: Vec<PathBuf> = quiet.map(|event| event.path).collect();
            if !paths.is_empty() {
                touched(paths);
            }
        };
        let config = Config::default().with_timeout(QUIET).with_batch_mode(false);
        let debouncer = new_debouncer_opt(config, handler)?;
        Ok(Self { debouncer, told: BTreeSet::new(), refused: BTreeSet::new() })
    }

    /// Watches these folders and no others. A folder that is not there is tried again the next time.
    pub fn follow(&mut self, wanted: &BTreeSet<PathBuf>) {
        for folder in self.told.difference(wanted) {
            // It may be gone, and with it what was watched.
            let _ = self.debouncer.watcher().unwatch(folder);
        }
        self.told.retain(|folder| wanted.contains(folder));
        for folder in wanted {
            if self.told.contains(folder) || !folder.is_dir() {
                continue;
            }
            match self.debouncer.watcher().watch(folder, RecursiveMode::NonRecursive) {
                Ok(()) => _ = self.told.insert(folder.clone()),
                Err(e) if self.refused.insert(folder.clone()) => {
                    let text =
                        format!("warning: {} cannot be watched ({e}); it is looked at now and then", folder.display());
                    say(fill(&text));
                }
                Err(_) => {}
            }
        }
    }

    /// The folder of `file` may be another one than it was, under the same name.
    pub fn renew(&mut self, file: &Path) {
        if let Some(folder) = file.parent()
            && self.told.remove(folder)
        {
            let _ = self.debouncer.watcher().unwatch(folder);
        }
    }
}
