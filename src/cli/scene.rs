//! Scenes that arguments name.

use super::{Done, Exit, terminal};
use crate::{
    formats::{self, DiskFiles, Limits},
    math::Stop,
    regular,
    scene::{Scene, builtin},
};
use std::path::Path;

/// A path that leads to no file is a wrong argument.
pub fn exists(path: &Path) -> Done {
    if path.to_str().is_some_and(|p| p.starts_with("builtin:")) {
        return Ok(());
    }
    let found = std::fs::metadata(path).and_then(|meta| regular::check(&meta));
    found.map_err(|e| {
        let what =
            if e.kind() == std::io::ErrorKind::NotFound { "there is no such file".into() } else { e.to_string() };
        Exit::say(2, format!("{}: {what}", path.display()))
    })
}

/// The scene at `path`; its warnings go to standard error, also where it fails.
pub fn load(path: &Path, limits: &Limits, stop: &Stop) -> Result<Scene, Exit> {
    if let Some(name) = path.to_str().and_then(|p| p.strip_prefix("builtin:")) {
        let known = builtin::NAMES.join(", ");
        return builtin::make(name, 1)
            .ok_or_else(|| Exit::say(2, format!("there is no built-in scene `{name}`; there are {known}")));
    }
    let mut warn = |text: String| terminal::say(terminal::fill(&format!("warning: {text}")));
    formats::load_with(path, &DiskFiles, limits, stop, &mut warn)
        .map_err(|e| Exit::say(if stop.is_set() { 130 } else { 1 }, e))
}
