//! Files that OBJ and MTL name: with blanks, backslashes, quotes, and paths of the machine that exported them.

use crate::{
    array::Bytes,
    formats::{FormatError, loader::Loader},
};
use std::path::{Path, PathBuf};

/// What a file's name led to.
pub(super) enum Found {
    /// The file.
    File(PathBuf, Bytes),
    /// Nothing; where it was looked for.
    Nothing(Vec<PathBuf>),
}

/// The file that `file` calls `target`, only by its path.
pub(super) fn exact(loader: &Loader, file: &Path, target: &str) -> Result<Found, FormatError> {
    let name = target.replace('\\', "/");
    if is_absolute(&name) && !loader.limits.allow_outside {
        return Ok(Found::Nothing(Vec::new()));
    }
    let path = loader.resolve(file, &name)?;
    Ok(match loader.find(&path)? {
        Some(bytes) => Found::File(path, bytes),
        None => Found::Nothing(vec![path]),
    })
}

/// The file that `file` calls `target`: by its path, and where none is there, by its name beside `file` and in `home`,
/// the folder of the OBJ. The latter is a warning.
pub(super) fn find(loader: &mut Loader, file: &Path, home: &Path, target: &str) -> Result<Found, FormatError> {
    let mut tried = match exact(loader, file, target)? {
        Found::Nothing(tried) => tried,
        found => return Ok(found),
    };
    let name = target.replace('\\', "/");
    let absolute = is_absolute(&name);
    let last = name.rsplit('/').next().unwrap_or_default();
    if last.is_empty() || last == "." || last == ".." {
        return Ok(Found::Nothing(tried));
    }
    for folder in [file.parent().unwrap_or(Path::new("")), home] {
        let path = loader.resolve(&folder.join("_"), last)?;
        if tried.contains(&path) {
            continue;
        }
        if let Some(bytes) = loader.find(&path)? {
            let why = if absolute { "is an absolute path" } else { "does not exist" };
            loader.warn(file, format!("`{target}` {why}; {} is used", path.display()));
            return Ok(Found::File(path, bytes));
        }
        tried.push(path);
    }
    Ok(Found::Nothing(tried))
}

/// Why nothing was found.
pub(super) fn nowhere(target: &str, tried: &[PathBuf]) -> String {
    let places: Vec<_> = tried.iter().map(|p| p.display().to_string()).collect();
    let absolute = if is_absolute(&target.replace('\\', "/")) { " (an absolute path)" } else { "" };
    format!("`{target}`{absolute} does not exist; looked for {}", places.join(" and "))
}

/// An absolute path of Unix or Windows, or a network path.
fn is_absolute(name: &str) -> bool {
    let drive = matches!(name.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic());
    name.starts_with('/') || drive
}
