//! The nearest valid name. Called only where there is an error.

/// Problems of one file for which near names are looked for: a report shows fewer, and to compare every wrong name with
/// every right one would take long in a large file.
const HINTS: usize = 200;

/// Whether the next of so many problems is worth a search for near names.
pub fn worthwhile(problems: usize) -> bool {
    problems < HINTS
}

/// `text`, or its beginning and end where it has more than `most` characters.
pub fn elide(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let (head, tail) = (most * 2 / 3, most / 3);
    let start: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    format!("{start} … {end}")
}

/// The candidate that `wrong` most likely means, if one is near: at most a third of its letters differ, or it is the
/// same word in another spelling, or one is the beginning of the other.
pub fn nearest<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |s: &str| s.to_lowercase().replace('_', "-");
    let wrong = plain(wrong);
    let limit = (wrong.chars().count().max(3)) / 3;
    let score = |name: &str| {
        let name = plain(name);
        if name.chars().count().abs_diff(wrong.chars().count()) > limit {
            let related = wrong.len() >= 3 && name.len() >= 3 && (name.starts_with(&wrong) || wrong.starts_with(&name));
            return related.then_some(limit + 1);
        }
        let distance = distance(&wrong, &name);
        (distance <= limit).then_some(distance)
    };
    candidates.into_iter().filter_map(|c| Some((score(c)?, c))).min().map(|(_, c)| c)
}

/// "did you mean …? " or nothing.
pub fn did_you_mean<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    nearest(wrong, candidates).map(|name| format!("did you mean `{name}`? ")).unwrap_or_default()
}

/// Insertions, deletions, replacements and swaps of neighbours that turn `a` into `b` (optimal string alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(80).collect(), b.chars().take(80).collect());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let mut best = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + usize::from(a[i - 1] != b[j - 1]));
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(before[j - 2] + 1);
            }
            row.push(best);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

/// `a`, `b` and `c`; at most twelve of them.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let shown: Vec<String> = names.iter().take(12).map(|n| format!("`{}`", elide(n, 60))).collect();
    match (shown.split_last(), names.len() > 12) {
        (None, _) => "none".to_owned(),
        (_, true) => format!("{} and {} more", shown.join(", "), names.len() - 12),
        (Some((last, [])), _) => last.clone(),
        (Some((last, rest)), _) => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        for (a, b, d) in [("", "", 0), ("a", "", 1), ("factor", "facter", 1), ("ab", "ba", 1), ("kitten", "sitting", 3)]
        {
            assert_eq!((distance(a, b), distance(b, a)), (d, d), "{a} {b}");
        }
    }

    #[test]
    fn nearest_names() {
        let names = ["collapse", "factor", "max_layers", "resolution", "views"];
        for (wrong, expect) in [
            ("colapse", Some("collapse")),
            ("facotr", Some("factor")),
            ("max-layers", Some("max_layers")),
            ("res", Some("resolution")),
            ("Views", Some("views")),
            ("view", Some("views")),
            ("banana", None),
            ("", None),
        ] {
            assert_eq!(nearest(wrong, names), expect, "{wrong}");
        }
    }

    #[test]
    fn long_texts_lose_their_middle() {
        assert_eq!(elide("abc", 3), "abc");
        assert_eq!(elide(&"é".repeat(100), 9), "éééééé … ééé");
        assert!(list([&*"n".repeat(100_000)]).len() < 100);
    }

    #[test]
    fn lists() {
        assert_eq!(list([]), "none");
        assert_eq!(list(["a"]), "`a`");
        assert_eq!(list(["a", "b", "c"]), "`a`, `b` and `c`");
    }
}
