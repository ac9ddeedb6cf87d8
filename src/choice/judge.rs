//! Whether a certificate is good enough.

use super::cost::{Cost, RESOURCES};
use serde::Serialize;
use serde_json::Value;

/// What a stand-in must keep to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Outlines move by at most so many pixels.
    pub deviation_px: Option<f64>,
    /// Luminance over the object's pixels, mean over the views, is at least so good, dB.
    pub psnr_db: Option<f64>,
    /// The verdict is at least this.
    pub verdict: Option<&'static str>,
}

/// Verdicts, the best first.
const VERDICTS: [&str; 4] = ["indistinguishable", "good", "visible", "failed"];

/// What a certificate says of a stand-in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    pub verdict: String,
    pub deviation_px: f64,
    pub psnr_db: f64,
    #[serde(skip)]
    pub cost: Cost,
    /// What it misses the target by, in words; empty where it meets it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub misses: Vec<String>,
}

/// Reads a certificate, as `evaluate` writes it.
///
/// # Errors
/// Names the number that it lacks.
pub fn judge(certificate: &Value, target: &Target) -> Result<Judged, String> {
    let number = |path: &str| {
        let found = path.split('.').try_fold(certificate, |value, name| value.get(name));
        found.and_then(Value::as_f64).filter(|v| v.is_finite()).ok_or_else(|| {
            format!("a certificate has no number `{path}`; expected one of `evaluate` with the method `views` or `directions`")
        })
    };
    let verdict = certificate.get("verdict").and_then(Value::as_str);
    let verdict = verdict.ok_or("a certificate has no `verdict`")?.to_owned();
    let (deviation_px, psnr_db) = (number("max_deviation_px")?, number("psnr_y_object_db.mean")?);
    let mut cost = [0.0; 4];
    for (cost, name) in cost.iter_mut().zip(RESOURCES) {
        *cost = number(name)?.max(0.0);
    }
    let mut misses = Vec::new();
    if let Some(most) = target.deviation_px.filter(|most| deviation_px > *most) {
        misses.push(format!("outlines move by {deviation_px:.1} px, at most {most} px are allowed"));
    }
    if let Some(least) = target.psnr_db.filter(|least| psnr_db < *least) {
        misses.push(format!("it matches at {psnr_db:.1} dB, at least {least} dB are asked for"));
    }
    let rank = |word: &str| VERDICTS.iter().position(|v| *v == word).unwrap_or(VERDICTS.len());
    if let Some(least) = target.verdict.filter(|least| rank(&verdict) > rank(least)) {
        let sentence = certificate.get("sentence").and_then(Value::as_str).unwrap_or_default();
        misses.push(format!("its verdict is {verdict}, at least {least} is asked for: {sentence}"));
    }
    Ok(Judged { verdict, deviation_px, psnr_db, cost, misses })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_a_certificate_misses_is_told() {
        let certificate = json!({ "verdict": "good", "sentence": "It is.", "max_deviation_px": 1.25, "triangles": 7,
            "psnr_y_object_db": { "mean": 31.5 }, "texels": 64, "memory_bytes": 999, "draw_calls": 2 });
        let target = |deviation_px, psnr_db, verdict| Target { deviation_px, psnr_db, verdict };
        let found = |t: Target| judge(&certificate, &t).unwrap();
        let met = found(target(Some(1.25), Some(31.5), Some("visible")));
        assert!(met.misses.is_empty() && met.cost == [7.0, 64.0, 999.0, 2.0], "{met:?}");
        assert!(found(target(None, None, None)).misses.is_empty());
        let missed = found(target(Some(1.0), Some(40.0), Some("indistinguishable"))).misses;
        assert_eq!(missed.len(), 3);
        assert!(missed[0].contains("1.2 px") && missed[1].contains("31.5 dB") && missed[2].contains("It is."));
        for lacking in ["verdict", "max_deviation_px", "psnr_y_object_db", "texels"] {
            let mut poor = certificate.clone();
            poor.as_object_mut().unwrap().remove(lacking);
            assert!(judge(&poor, &target(None, None, None)).unwrap_err().contains(lacking));
        }
    }
}
