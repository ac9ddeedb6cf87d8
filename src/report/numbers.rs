//! Numbers for people.

/// A number with about four digits: `158,978`, `23.14`, `2.1e-5`.
pub fn number(v: f64) -> String {
    let size = v.abs();
    match size {
        _ if !v.is_finite() => "–".to_owned(),
        0.0 => "0".to_owned(),
        s if s >= 9_999.5 => grouped(v.round()),
        s if s.fract() == 0.0 => format!("{v}"),
        s if s >= 99.95 => trimmed(format!("{v:.1}")),
        s if s >= 0.9995 => trimmed(format!("{v:.2}")),
        s if s >= 0.000_999_5 => trimmed(format!("{v:.4}")),
        _ => format!("{v:.1e}").replace(".0e", "e"),
    }
}

/// With its unit.
pub fn amount(v: f64, unit: &str) -> String {
    if unit.is_empty() { number(v) } else { format!("{} {unit}", number(v)) }
}

fn trimmed(text: String) -> String {
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A whole number with commas.
fn grouped(v: f64) -> String {
    let digits = format!("{:.0}", v.abs());
    let mut out = String::from(if v < 0.0 { "-" } else { "" });
    for (i, d) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(d);
    }
    out
}

pub fn bytes(n: f64) -> String {
    match n {
        n if n < 1024.0 => format!("{n:.0} B"),
        n if n < 1_048_576.0 => format!("{:.1} KiB", n / 1024.0),
        n if n < 1_073_741_824.0 => format!("{:.1} MiB", n / 1_048_576.0),
        n => format!("{:.2} GiB", n / 1_073_741_824.0),
    }
}

pub fn seconds(s: f64) -> String {
    match s {
        s if s < 0.0005 => "0 ms".to_owned(),
        s if s < 0.9995 => format!("{:.0} ms", s * 1000.0),
        s if s < 99.95 => format!("{s:.1} s"),
        s => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
    }
}

/// `1 node`, `2 nodes`.
pub fn count(n: usize, what: &str) -> String {
    let ending = if n == 1 { "" } else { "s" };
    format!("{} {what}{ending}", number(n as f64))
}

/// A coordinate of a drawing.
pub fn place(v: f64) -> String {
    trimmed(format!("{v:.1}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (v, expect) in [
            (0.0, "0"),
            (158_978.0, "158,978"),
            (-12_345_678.4, "-12,345,678"),
            (9999.0, "9999"),
            (231.46, "231.5"),
            (23.146, "23.15"),
            (2.5, "2.5"),
            (0.03, "0.03"),
            (0.00123, "0.0012"),
            (2e-5, "2e-5"),
            (2.14e-5, "2.1e-5"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(number(v), expect);
        }
        assert_eq!((amount(1.0, "dB"), amount(1.0, "")), ("1 dB".to_owned(), "1".to_owned()));
        assert_eq!([0.0, 2048.0, 3e9].map(bytes), ["0 B", "2.0 KiB", "2.79 GiB"]);
        assert_eq!([0.0, 0.25, 12.34, 125.0].map(seconds), ["0 ms", "250 ms", "12.3 s", "2 min 05 s"]);
        assert_eq!((count(1, "node"), count(3, "node")), ("1 node".to_owned(), "3 nodes".to_owned()));
        assert_eq!([10.0, 0.25, 100.04].map(place), ["10", "0.2", "100"]);
    }
}
