//! The verdict: what an eye would say, decided by a few figures with limits.
//!
//! Every requirement has a limit for each verdict; the worst one decides. The limits were set by looking at bakes of models of
//! many kinds beside their originals.

use super::{about::Better, certificate::Certificate, figures::rounded};
use serde::Serialize;

/// What an eye would say of the stand-in, seen from the cell; the better one first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nobody tells it from the original at its resolution.
    Indistinguishable,
    /// It passes for the original; side by side there are small differences.
    Good,
    /// Differences are seen without a comparison.
    Visible,
    /// It does not stand in for the original.
    Failed,
}

impl Verdict {
    pub fn word(self) -> &'static str {
        match self {
            Self::Indistinguishable => "indistinguishable",
            Self::Good => "good",
            Self::Visible => "visible",
            Self::Failed => "failed",
        }
    }
}

/// Up to where a figure earns a verdict; beyond `visible` it is `failed`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    pub indistinguishable: f64,
    pub good: f64,
    pub visible: f64,
}

/// A figure that decides on the verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Requirement {
    /// Its path in the certificate.
    pub measure: &'static str,
    pub value: f64,
    /// Higher is better for these; lower for the others.
    pub better: Better,
    pub limits: Limits,
    /// What this figure alone earns.
    pub verdict: Verdict,
}

type Read = fn(&Certificate) -> f64;
/// Says the figure for an artist.
type Say = fn(&Certificate) -> String;

struct Criterion {
    measure: &'static str,
    better: Better,
    limits: [f64; 3],
    read: Read,
    say: Say,
}

/// The most telling first: a sentence names the first two of those that decide.
const CRITERIA: [Criterion; 8] = [
    Criterion {
        measure: "missing_px.ratio",
        better: Better::Lower,
        limits: [2e-5, 1e-3, 1e-2],
        read: |c| c.figures.missing_px.ratio,
        say: |c| format!("holes cover {} of it", percent(c.figures.missing_px.ratio)),
    },
    Criterion {
        measure: "wrong_surface_px.ratio",
        better: Better::Lower,
        limits: [2e-5, 1e-3, 1e-2],
        read: |c| c.figures.wrong_surface_px.ratio,
        say: |c| format!("on {} of it a surface behind shows", percent(c.figures.wrong_surface_px.ratio)),
    },
    Criterion {
        measure: "lost_detail_px.ratio",
        better: Better::Lower,
        limits: [2e-4, 2e-3, 3e-2],
        read: |c| c.figures.lost_detail_px.ratio,
        say: |c| format!("thin parts vanish ({} of it)", percent(c.figures.lost_detail_px.ratio)),
    },
    Criterion {
        measure: "crack_px.ratio",
        better: Better::Lower,
        limits: [2e-6, 2e-5, 5e-4],
        read: |c| c.figures.crack_px.ratio,
        say: |c| format!("it has cracks ({} pixels in {} views)", c.figures.crack_px.total, c.views),
    },
    Criterion {
        measure: "in_front_px.ratio",
        better: Better::Lower,
        limits: [2e-5, 2e-3, 2e-2],
        read: |c| c.figures.in_front_px.ratio,
        say: |c| format!("parts stick out in front of {} of it", percent(c.figures.in_front_px.ratio)),
    },
    Criterion {
        measure: "extra_px.ratio",
        better: Better::Lower,
        limits: [2e-5, 2e-3, 2e-2],
        read: |c| c.figures.extra_px.ratio,
        say: |c| format!("its outline is exceeded by {} of its size", percent(c.figures.extra_px.ratio)),
    },
    Criterion {
        measure: "psnr_y_object_db.mean",
        better: Better::Higher,
        limits: [38.0, 24.0, 18.0],
        read: |c| c.figures.psnr_y_object_db.mean,
        say: |c| format!("its colours and outlines match at {:.1} dB", c.figures.psnr_y_object_db.mean),
    },
    Criterion {
        measure: "psnr_y_object_db.min",
        better: Better::Higher,
        limits: [34.0, 20.0, 14.0],
        read: |c| c.figures.psnr_y_object_db.min,
        say: |c| format!("in its worst view it matches at {:.1} dB", c.figures.psnr_y_object_db.min),
    },
];

/// A share as text with two leading figures.
pub fn percent(ratio: f64) -> String {
    let p = ratio * 100.0;
    match p {
        p if p >= 10.0 => format!("{p:.0} %"),
        p if p >= 0.095 => format!("{p:.1} %"),
        p if p >= 0.0095 => format!("{p:.2} %"),
        p if p >= 0.00095 => format!("{p:.3} %"),
        p if p > 0.0 => format!("{p:.4} %"),
        _ => "0 %".to_owned(),
    }
}

fn earned(value: f64, better: Better, limits: &Limits) -> Verdict {
    let meets = |limit: f64| if better == Better::Higher { value >= limit } else { value <= limit };
    match () {
        () if meets(limits.indistinguishable) => Verdict::Indistinguishable,
        () if meets(limits.good) => Verdict::Good,
        () if meets(limits.visible) => Verdict::Visible,
        () => Verdict::Failed,
    }
}

/// All figures that decide, with their limits.
pub fn requirements(c: &Certificate) -> Vec<Requirement> {
    let one = |k: &Criterion| {
        let value = (k.read)(c);
        let [indistinguishable, good, visible] = k.limits;
        let limits = Limits { indistinguishable, good, visible };
        let verdict = earned(value, k.better, &limits);
        Requirement { measure: k.measure, value, better: k.better, limits, verdict }
    };
    CRITERIA.iter().map(one).collect()
}

/// The worst of what the requirements earn.
pub fn verdict(requirements: &[Requirement]) -> Verdict {
    requirements.iter().map(|r| r.verdict).max().unwrap_or(Verdict::Failed)
}

/// The verdict in words, with the figures that decide.
pub fn sentence(c: &Certificate) -> String {
    let verdict = verdict(&c.requirements);
    let decides = |r: &&Requirement| r.verdict == verdict;
    let say = |r: &Requirement| CRITERIA.iter().find(|k| k.measure == r.measure).map(|k| (k.say)(c));
    let why: Vec<String> = c.requirements.iter().filter(decides).filter_map(say).take(2).collect();
    let why = why.join(", and ");
    let figures = &c.figures;
    let mut text = match verdict {
        Verdict::Indistinguishable => format!(
            "From the view cell the stand-in cannot be told from the original ({:.1} dB, no cracks, nothing lost)",
            figures.psnr_y_object_db.mean
        ),
        Verdict::Good => format!("From the view cell the stand-in passes for the original; side by side {why}"),
        Verdict::Visible => format!("The difference can be seen: {why}"),
        Verdict::Failed => format!("The stand-in does not look like the original: {why}"),
    };
    if !c.bound.held {
        let (most, bound) = (figures.max_deviation_px, c.bound.value);
        text +=
            &format!("; outlines move by up to {} px, more than the {} px meant", rounded(most, 1), rounded(bound, 1));
    }
    text + "."
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::measure;

    #[test]
    fn every_requirement_is_a_measure_with_limits_in_order() {
        for k in &CRITERIA {
            let about = measure(k.measure).unwrap();
            assert_eq!(about.better, k.better, "{}", k.measure);
            let [a, b, c] = k.limits;
            assert!(if k.better == Better::Higher { a > b && b > c } else { a < b && b < c }, "{}", k.measure);
        }
    }

    #[test]
    fn limits_earn_verdicts() {
        let limits = Limits { indistinguishable: 0.1, good: 0.2, visible: 0.3 };
        let of = |v| earned(v, Better::Lower, &limits);
        assert_eq!([of(0.1), of(0.15), of(0.3)], [Verdict::Indistinguishable, Verdict::Good, Verdict::Visible]);
        assert_eq!((of(0.31), of(f64::NAN)), (Verdict::Failed, Verdict::Failed));
        let limits = Limits { indistinguishable: 30.0, good: 20.0, visible: 10.0 };
        let of = |v| earned(v, Better::Higher, &limits);
        assert_eq!([of(31.0), of(20.0), of(9.0)], [Verdict::Indistinguishable, Verdict::Good, Verdict::Failed]);
    }

    #[test]
    fn shares_keep_their_leading_figures() {
        let all = [0.5, 0.047, 0.0004, 0.00002, 1e-6, 0.0].map(percent);
        assert_eq!(all, ["50 %", "4.7 %", "0.04 %", "0.002 %", "0.0001 %", "0 %"]);
    }
}
