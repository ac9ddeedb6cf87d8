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

/// What makes the number at `path` of `certificate` better: `finer` or `coarser`.
pub fn helps<'a>(certificate: &'a Value, path: &str) -> Option<&'a str> {
    certificate.get("about")?.get(path)?.get("helps")?.as_str()
}

/// True where the stand-in has no fewer triangles than what it stands in for.
pub fn is_heavier(certificate: &Value) -> bool {
    let number = |name: &str| certificate.get(name).and_then(Value::as_u64);
    // A choice among stand-ins is none itself.
    let is_one = certificate.get("budget_taken").is_none();
    is_one
        && matches!((number("triangles"), number("original_triangles")), (Some(after), Some(before)) if after >= before)
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
        assert_eq!((helps(&c, "a.b"), helps(&c, "a")), (Some("finer"), None));
        assert_eq!(text(&json!({ "wrong_points": 0 })), "");
        assert!(!is_heavier(&c) && is_heavier(&json!({ "triangles": 3, "original_triangles": 3 })));
    }
}
