//! Amounts with a unit: bytes, durations, shares; as arguments and as text.

use std::time::Duration;

/// `4GiB`, `500 MB`, `1048576`: bytes.
pub fn bytes(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, u64); 10] = [
        ("", 1),
        ("b", 1),
        ("kb", 1000),
        ("mb", 1_000_000),
        ("gb", 1_000_000_000),
        ("tb", 1_000_000_000_000),
        ("kib", 1 << 10),
        ("mib", 1 << 20),
        ("gib", 1 << 30),
        ("tib", 1 << 40),
    ];
    let bytes = scaled(text, &UNITS.map(|(n, v)| (n, v as f64)));
    bytes.map(|v| v as u64).ok_or_else(|| "expected a size such as 4GiB or 500MB".to_owned())
}

/// `30d`, `12h`, `90min`, `45s`.
pub fn duration(text: &str) -> Result<Duration, String> {
    const UNITS: [(&str, f64); 5] = [("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0), ("w", 604_800.0)];
    let seconds = scaled(text, &UNITS).and_then(|s| Duration::try_from_secs_f64(s).ok());
    seconds.ok_or_else(|| "expected an age such as 30d, 12h or 90min".to_owned())
}

/// `5%` or `0.05`: a share in 0 … 1.
pub fn share(text: &str) -> Result<f64, String> {
    let share = scaled(text, &[("", 1.0), ("%", 0.01)]).filter(|v| *v <= 1.0);
    share.ok_or_else(|| "expected a share such as 5%".to_owned())
}

fn scaled(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let text = text.trim();
    let split = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let unit = text[split..].trim().to_lowercase();
    let scale = units.iter().find(|(name, _)| *name == unit)?.1;
    Some(text[..split].parse::<f64>().ok()? * scale).filter(|v| v.is_finite() && *v < 1.8e19)
}

/// Bytes for people.
pub fn show_bytes(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} B"),
        1024..1_048_576 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        1_048_576..1_073_741_824 => format!("{:.1} MiB", bytes as f64 / 1_048_576.0),
        _ => format!("{:.2} GiB", bytes as f64 / 1_073_741_824.0),
    }
}

/// Seconds for people.
pub fn show_seconds(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{:.0} ms", s * 1000.0),
        s if s < 100.0 => format!("{s:.1} s"),
        s => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        for (text, expect) in [
            ("4GiB", Some(4 << 30)),
            ("1.5 kb", Some(1500)),
            ("7", Some(7)),
            ("", None),
            ("4 lumps", None),
            ("-1MB", None),
        ] {
            assert_eq!(bytes(text).ok(), expect, "{text}");
        }
        assert_eq!(show_bytes(3 << 29), "1.50 GiB");
    }

    #[test]
    fn ages_and_shares() {
        assert_eq!(duration("2d"), Ok(Duration::from_secs(172_800)));
        assert!(duration("2").is_err() && duration("x").is_err());
        assert_eq!((share("5%"), share("0.5"), share("101%").is_err()), (Ok(0.05), Ok(0.5), true));
        assert_eq!(show_seconds(3661.0), "61 min 01 s");
    }
}
