//! What a certificate says to people: verdict, sentence, summary. It is read as plain JSON: a kind's certificate that has none of
//! these says nothing here.

use super::terminal;
use serde_json::Value;

/// Verdict, sentence and the lines of the summary; empty where the certificate has no verdict.
pub fn text(certificate: &Value) -> String {
    let word = |name: &str| certificate.get(name).and_then(Value::as_str);
    let Some(verdict) = word("verdict") else { return String::new() };
    let mut out = format!("verdict: {verdict}");
    if let Some(sentence) = word("sentence") {
        out += &format!(". {sentence}");
    }
    out = terminal::fill_output(&out) + "\n";
    for line in certificate.get("summary").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str) {
        out += &(terminal::fill_output(&format!("  {line}")) + "\n");
    }
    out
}

/// What a certificate tells about one of its numbers.
#[derive(Debug, Default, PartialEq)]
pub struct About<'a> {
    pub about: Option<&'a str>,
    pub picture: Option<&'a str>,
    /// `finer` or `coarser`: what makes it better.
    pub helps: Option<&'a str>,
}

/// What `certificate` tells about the number at `path`.
pub fn about<'a>(certificate: &'a Value, path: &str) -> About<'a> {
    let entry = certificate.get("about").and_then(|all| all.get(path));
    let word = |name: &str| entry?.get(name)?.as_str();
    About { about: word("about"), picture: word("picture"), helps: word("helps") }
}

/// True where the stand-in has no fewer triangles than what it stands in for.
pub fn is_heavier(certificate: &Value) -> bool {
    let number = |name: &str| certificate.get(name).and_then(Value::as_u64);
    matches!((number("triangles"), number("original_triangles")), (Some(after), Some(before)) if after >= before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn certificates_speak_and_others_are_silent() {
        let c = json!({ "verdict": "good", "sentence": "It is.", "summary": ["triangles 9 → 3"], "about": {
            "a.b": { "about": "what it is", "picture": "worst-a", "helps": "finer" } } });
        assert_eq!(text(&c), "verdict: good. It is.\n  triangles 9 → 3\n");
        assert_eq!(
            about(&c, "a.b"),
            About { about: Some("what it is"), picture: Some("worst-a"), helps: Some("finer") }
        );
        assert_eq!(about(&c, "a"), About::default());
        assert_eq!(text(&json!({ "wrong_points": 0 })), "");
        assert!(!is_heavier(&c) && is_heavier(&json!({ "triangles": 3, "original_triangles": 3 })));
    }
}
