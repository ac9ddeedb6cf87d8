//! What leaves the pipeline: `[outputs]` and `[files]`.

use super::{
    axes::{self, NodeAxes},
    draft::Draft,
    item::{Item, what},
    link::{Links, Output},
    problem::Problem,
    source::TextSpan,
};
use crate::engine::publish::names;
use std::collections::BTreeMap;
use toml::de::DeValue;

/// An entry of `[files]`: path and output.
pub type FileEntry = (String, Output);

/// The output that an entry of `section` names.
fn output(section: &str, item: Item, links: &Links, problems: &mut Vec<Problem>) -> Option<Output> {
    match item.value {
        DeValue::String(s) => links.find(s, item.place, section, problems),
        other => {
            let message = format!("{section}: {} where an output is named", what(other));
            problems.push(Problem::at(item.place, message, "not a reference").help("write \"node.output\""));
            None
        }
    }
}

/// `[outputs]`: every entry names an output.
pub fn outputs(draft: &Draft, links: &Links, problems: &mut Vec<Problem>) {
    for (name, item) in &draft.outputs {
        if !super::item::valid_name(name) {
            let message = format!("`{name}` is no name for an output");
            problems.push(Problem::at(item.key, message, "not a name").help("letters, digits, `-` and `_`"));
        }
        output("[outputs]", *item, links, problems);
    }
}

/// `[files]`, in the order of the file.
pub fn files(draft: &Draft, links: &Links, known: &[Option<NodeAxes>], problems: &mut Vec<Problem>) -> Vec<FileEntry> {
    let mut entries: Vec<(&str, Item)> = draft.files.iter().map(|(k, v)| (*k, *v)).collect();
    entries.sort_by_key(|(_, item)| item.key);
    let mut taken: BTreeMap<String, (TextSpan, &str)> = BTreeMap::new();
    let mut files = Vec::new();
    for (path, item) in entries {
        let folder = path.ends_with('/');
        let checked = match path {
            // The output folder itself.
            "./" => Ok(()),
            _ => check_path(path.strip_suffix('/').unwrap_or(path)),
        };
        let sound = checked.is_ok();
        if let Err((message, help)) = checked {
            problems.push(Problem::at(item.key, format!("[files]: {message}"), "no path for a file").help(help));
        } else if !folder {
            collide(path, item.key, &mut taken, problems);
        }
        let Some(from) = output("[files]", item, links, problems) else { continue };
        let Some(spec) = links.output(from.0, from.1) else { continue };
        let name = || links.output_name(from);
        let wrong = match (spec.ty.name, folder) {
            ("File", false) | ("Bundle", true) => None,
            ("File", true) => Some((
                format!("[files]: `{path}` is a folder, `{}` is one file", name()),
                "a file's path has no `/` at its end".to_owned(),
            )),
            ("Bundle", false) => Some((
                format!("[files]: `{path}` is one file, `{}` is a bundle of files", name()),
                format!("a folder's path ends with `/`: \"{path}/\", or \"./\" for the output folder itself"),
            )),
            (other, _) => Some((
                format!("[files] publishes values of type File or Bundle, `{}` is a {other}", name()),
                match links.of_type(usize::MAX, "Bundle") {
                    bundles if folder => bundles,
                    _ => links.of_type(usize::MAX, "File"),
                },
            )),
        };
        if let Some((message, help)) = wrong {
            problems.push(Problem::at(item.place, message, format!("a {}", spec.ty.name)).help(help));
            continue;
        }
        let Some(axes) = axes::of_output(links, known, from) else { continue };
        match (axes.is_empty(), path.contains("{name}")) {
            _ if !sound => {}
            (false, false) => {
                let message = format!("`{}` is a list of files, which need different paths", links.output_name(from));
                let (stem, end) = path.rsplit_once('.').unwrap_or((path, ""));
                let dot = if end.is_empty() { "" } else { "." };
                let better = if folder {
                    format!("{}{{name}}/", path.strip_prefix("./").unwrap_or(path))
                } else {
                    format!("{stem}-{{name}}{dot}{end}")
                };
                let help = format!("{{name}} stands for the element's name: \"{better}\"");
                problems.push(Problem::at(item.key, message, "one path for many files").help(help));
            }
            (true, true) => {
                let message = format!("`{}` is a single file, its path has no {{name}}", links.output_name(from));
                problems.push(Problem::at(item.key, message, "nothing to name").help("remove {name} from the path"));
            }
            _ => files.push((path.to_owned(), from)),
        }
    }
    files
}

/// Names that Windows keeps for devices, and that we keep for ourselves at the top of the folder.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];
const OURS: [&str; 4] = ["run.json", "manifest.json", "report.html", "rejected"];

/// What is wrong with a path below the output folder, and what to do.
fn check_path(path: &str) -> Result<(), (String, String)> {
    let fail = |message: String, help: &str| Err((message, help.to_owned()));
    if path.is_empty() {
        return fail("the path is empty".into(), "a path below the output folder, such as \"mesh.glb\"");
    }
    if path.len() > 200 {
        return fail(format!("the path has {} bytes", path.len()), "at most 200, so that every system can hold it");
    }
    if path.starts_with(['/', '\\', '~']) || path.as_bytes().get(1) == Some(&b':') {
        return fail(
            format!("`{path}` is not below the output folder"),
            "paths start from the output folder: no `/` in front, no drive",
        );
    }
    let plain = path.replace("{name}", "name");
    if let Some(c) = plain.chars().find(|c| c.is_control() || "\\<>:\"|?*{}".contains(*c)) {
        let help = match c {
            '\\' => "folders are separated by `/`",
            '{' | '}' => "the only placeholder is {name}, the element's name",
            _ => "not every system can hold this character in a file's name",
        };
        return fail(format!("`{path}` has the character {c:?}"), help);
    }
    for (depth, part) in plain.split('/').enumerate() {
        let lower = part.to_lowercase();
        let stem = lower.split('.').next().unwrap_or_default();
        let numbered = |prefix: &str| {
            stem.strip_prefix(prefix).is_some_and(|n| n.len() == 1 && n != "0" && n.as_bytes()[0].is_ascii_digit())
        };
        if part.is_empty() {
            return fail(format!("`{path}` has an empty folder name"), "one `/` between names, none at the end");
        } else if part == ".." || part == "." {
            return fail(format!("`{path}` leaves the output folder"), "a path without `.` and `..`");
        } else if part.ends_with(['.', ' ']) || part.starts_with(' ') {
            return fail(
                format!("`{part}` begins or ends with a space or a dot"),
                "not every system can hold such a name",
            );
        } else if DEVICES.contains(&stem) || numbered("com") || numbered("lpt") {
            return fail(format!("`{part}` is the name of a device on Windows"), "choose another name");
        } else if depth == 0 && (OURS.contains(&lower.as_str()) || lower.starts_with(".farfield")) {
            return fail(format!("`{part}` is kept for the bake's own records"), "choose another name");
        }
    }
    Ok(())
}

/// Two paths that some system cannot tell apart, or one that is a folder of the other.
fn collide<'s>(
    path: &'s str,
    place: TextSpan,
    taken: &mut BTreeMap<String, (TextSpan, &'s str)>,
    problems: &mut Vec<Problem>,
) {
    let lower = names::folded(path);
    let mut report = |(other, name): (TextSpan, &str), why: &str| {
        let (path, name) = names::told_apart(path, name);
        let message = format!("[files]: `{path}` and `{name}` {why}");
        problems.push(Problem::at(place, message, "this one").also(other, "and this one").help("choose another name"));
    };
    if let Some(old) = taken.get(&lower) {
        let why = if old.1.to_lowercase() == path.to_lowercase() {
            "are one file where case does not count"
        } else {
            "are one file where the forms of Unicode do not count"
        };
        return report(*old, why);
    }
    let inside = format!("{lower}/");
    let above = lower.match_indices('/').find_map(|(at, _)| taken.get(&lower[..at]));
    let below = taken.range(inside.clone()..).next().filter(|(k, _)| k.starts_with(&inside)).map(|(_, v)| v);
    if let Some(old) = above.or(below) {
        return report(*old, "cannot both be: one is a folder of the other");
    }
    taken.insert(lower, (place, path));
}
