//! Names of published files: they stay below the output folder and mean one file on every system.

use std::{borrow::Cow, collections::BTreeMap};
use unicode_normalization::UnicodeNormalization as _;

/// Names that the engine itself writes.
const OWN: [&str; 5] = ["manifest.json", "run.json", "report.html", "rejected", ".farfield-pending.json"];

/// What is equal for two paths that some system takes for one: case and Unicode's normal forms do not count.
pub fn folded(path: &str) -> String {
    if path.is_ascii() {
        path.to_ascii_lowercase()
    } else {
        path.nfd().collect::<String>().to_lowercase().nfc().collect()
    }
}

/// Two paths for people: where they look alike, what is not ASCII stands as its code.
pub fn told_apart<'a>(a: &'a str, b: &'a str) -> (Cow<'a, str>, Cow<'a, str>) {
    if a == b || a.to_lowercase() == b.to_lowercase() || folded(a) != folded(b) {
        return (a.into(), b.into());
    }
    let escape = |text: &str| -> String {
        text.chars().map(|c| if c.is_ascii() { c.to_string() } else { format!("{{U+{:04X}}}", c as u32) }).collect()
    };
    (escape(a).into(), escape(b).into())
}

/// Why `part` cannot be one component of a path; `None` if it can.
pub fn bad_component(part: &str) -> Option<&'static str> {
    let stem = part.split('.').next().unwrap_or("").trim_end().to_ascii_uppercase();
    let numbered =
        |name: &str| stem.strip_prefix(name).is_some_and(|n| n.len() == 1 && n.as_bytes()[0].is_ascii_digit());
    if part.is_empty() {
        Some("is empty")
    } else if part == "." || part == ".." {
        Some("leads out of its folder")
    } else if part.chars().any(|c| c < ' ' || "/\\:*?\"<>|".contains(c)) {
        Some("holds a character that file names cannot have (one of / \\ : * ? \" < > | or a control character)")
    } else if part.ends_with(['.', ' ']) {
        Some("ends in a dot or a space")
    } else if ["CON", "PRN", "AUX", "NUL"].contains(&stem.as_str()) || numbered("COM") || numbered("LPT") {
        Some("is a reserved name on Windows")
    } else if part.len() > 200 {
        Some("is longer than 200 bytes")
    } else {
        None
    }
}

/// Why `path` (with `/`) cannot be published.
pub fn bad_path(path: &str) -> Option<String> {
    if let Some((part, what)) = path.split('/').find_map(|part| Some((part, bad_component(part)?))) {
        return Some(format!("the name `{part}` {what}"));
    }
    let first = path.split('/').next().unwrap_or("");
    OWN.iter().find(|own| first.eq_ignore_ascii_case(own)).map(|own| format!("`{own}` is written by farfield itself"))
}

/// The template with an element's name in the place of `{name}`. Names of several axes are joined with a comma.
pub fn expand(template: &str, element: &str) -> Result<String, String> {
    let name = element.replace(crate::engine::value::JOIN, ",");
    match bad_component(&name) {
        Some(what) if template.contains("{name}") => Err(format!("the element name `{name}` {what}")),
        _ => Ok(template.replace("{name}", &name)),
    }
}

/// Two paths that are one file, or a file and a folder, on a system that ignores case or Unicode's normal forms.
pub fn collision<'a>(paths: impl Iterator<Item = &'a str> + Clone) -> Option<(&'a str, &'a str)> {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    for path in paths.clone() {
        if let Some(other) = seen.insert(folded(path), path) {
            return Some((other, path));
        }
    }
    for path in paths {
        let low = folded(path);
        for (at, _) in low.match_indices('/') {
            if let Some(file) = seen.get(&low[..at]) {
                return Some((file, path));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_elsewhere_are_refused() {
        for bad in [
            "",
            "..",
            "a/../b",
            "/etc/x",
            "a//b",
            "a\\b",
            "C:x",
            "nul",
            "Com1.png",
            "x.",
            "x ",
            "a\u{1}",
            "run.json",
            "Report.html",
            "Rejected/x",
        ] {
            assert!(bad_path(bad).is_some(), "{bad:?}");
        }
        for good in
            ["a.glb", "pictures/cell 3,4.png", "..a", "com.png", "console", "lpt10", "a/run.json", "a/report.html"]
        {
            assert!(bad_path(good).is_none(), "{good:?}");
        }
        assert!(expand("p/{name}.png", "../x").is_err() && expand("p/{name}.png", "..").is_err());
        assert_eq!(expand("p/{name}.png", "a\u{1f}b").unwrap(), "p/a,b.png");
    }

    #[test]
    fn collisions_ignore_case_and_see_folders() {
        let check =
            |paths: &[&str], expect: bool| assert_eq!(collision(paths.iter().copied()).is_some(), expect, "{paths:?}");
        check(&["a", "b", "c/a"], false);
        check(&["a", "A"], true);
        check(&["x/a", "X/A"], true);
        check(&["x", "x/a"], true);
        check(&["X/a/b", "x/A"], true);
        check(&["caf\u{e9}", "cafe\u{301}"], true);
        check(&["caf\u{c9}/x", "Cafe\u{301}"], true);
        check(&["caf\u{e9}", "cafe"], false);
    }

    #[test]
    fn names_that_look_alike_are_spelled_out() {
        let (a, b) = told_apart("caf\u{e9}.txt", "cafe\u{301}.txt");
        assert_eq!((&*a, &*b), ("caf{U+00E9}.txt", "cafe{U+0301}.txt"));
        assert_eq!(told_apart("A", "a"), ("A".into(), "a".into()));
    }
}
