//! The table of requirements: what was demanded, what was measured, and by how much it is met or missed.

use super::{
    Bound,
    markup::Markup,
    numbers::{amount, number, place},
};

pub fn bounds(m: &mut Markup, bounds: &[Bound]) {
    // One certificate needs no name.
    let named = bounds.iter().any(|b| b.node != bounds[0].node);
    m.element("table", &[("class", "bounds")], |m| {
        m.heads(&[("", ""), ("What", ""), ("Measured", "n"), ("Required", "n"), ("", ""), ("By how much", "")]);
        m.element("tbody", &[], |m| {
            for bound in bounds {
                m.element("tr", &[("class", if bound.met { "met" } else { "missed" })], |m| row(m, bound, named));
            }
        });
    });
}

fn row(m: &mut Markup, bound: &Bound, named: bool) {
    let (sign, word) = if bound.met { ("✓", "met") } else { ("✗", "missed") };
    m.element("td", &[("class", "state")], |m| {
        m.with_text("span", &[("title", word), ("aria-label", word), ("role", "img")], sign);
    });
    m.element("td", &[], |m| {
        m.text(if bound.about.is_empty() { &bound.path } else { &bound.about });
        let name = if named { format!("{}: {}", bound.node, bound.path) } else { bound.path.clone() };
        m.raw("<br>").with_text("code", &[], &name);
    });
    let measured = bound.measured.map_or("no number".to_owned(), |v| amount(v, &bound.unit));
    m.with_text("td", &[("class", "n")], &measured).with_text("td", &[("class", "n")], &demand(bound));
    m.element("td", &[("class", "bars")], |m| {
        if let Some(share) = used(bound) {
            m.element("i", &[("style", &format!("width:{}%", place(share.min(1.0) * 100.0)))], |_| {});
        }
    });
    m.with_text("td", &[], &margin(bound));
}

fn demand(bound: &Bound) -> String {
    let unit = if bound.unit.is_empty() { String::new() } else { format!(" {}", bound.unit) };
    match (bound.min, bound.max) {
        (Some(a), Some(b)) if a == b => format!("{}{unit}", number(a)),
        (Some(a), Some(b)) => format!("{} to {}{unit}", number(a), number(b)),
        (Some(a), None) => format!("≥ {}{unit}", number(a)),
        (None, Some(b)) => format!("≤ {}{unit}", number(b)),
        (None, None) => "a number".to_owned(),
    }
}

/// How much of what an upper bound allows was used.
fn used(bound: &Bound) -> Option<f64> {
    let (measured, max) = (bound.measured?, bound.max.filter(|_| bound.min.is_none())?);
    (max > 0.0 && measured >= 0.0).then_some(measured / max)
}

/// By how much a bound is met or missed.
fn margin(bound: &Bound) -> String {
    let Some(measured) = bound.measured else { return "missed: the certificate has no such number".to_owned() };
    let by = |v: f64| amount(v, &bound.unit);
    match (bound.min, bound.max) {
        (Some(min), _) if measured < min => format!("missed by {}", by(min - measured)),
        (_, Some(max)) if measured > max && max > 0.0 => {
            format!("missed by {}: {} × the limit", by(measured - max), number(measured / max))
        }
        (_, Some(max)) if measured > max => format!("missed by {}", by(measured - max)),
        (Some(min), Some(max)) if min == max => "met exactly".to_owned(),
        (Some(min), None) => format!("met with {} to spare", by(measured - min)),
        (None, Some(_)) if measured == 0.0 => "met: there is none".to_owned(),
        (None, Some(max)) if max > 0.0 && measured > 0.0 => {
            format!("met with {} % of the limit", number((100.0 * measured / max).round()))
        }
        (Some(min), Some(max)) => format!("met with {} to spare", by((measured - min).min(max - measured))),
        _ if bound.met => "met".to_owned(),
        _ => "missed".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_say_by_how_much() {
        let bound = |measured: f64, min: Option<f64>, max: Option<f64>| Bound {
            measured: Some(measured),
            min,
            max,
            unit: "dB".into(),
            ..Bound::default()
        };
        for (b, expect) in [
            (bound(25.0, Some(18.0), None), "met with 7 dB to spare"),
            (bound(17.5, Some(18.0), None), "missed by 0.5 dB"),
            (bound(0.25, None, Some(1.0)), "met with 25 % of the limit"),
            (bound(0.0, None, Some(1.0)), "met: there is none"),
            (bound(3.0, None, Some(2.0)), "missed by 1 dB: 1.5 × the limit"),
            (bound(3.0, None, Some(0.0)), "missed by 3 dB"),
            (bound(3.0, Some(3.0), Some(3.0)), "met exactly"),
            (bound(3.0, Some(1.0), Some(10.0)), "met with 2 dB to spare"),
            (bound(-3.0, None, Some(-4.0)), "missed by 1 dB"),
            (Bound::default(), "missed: the certificate has no such number"),
        ] {
            assert_eq!(margin(&b), expect, "{b:?}");
        }
        assert_eq!(demand(&bound(0.0, Some(1.0), Some(2.0))), "1 to 2 dB");
        assert_eq!(used(&bound(3.0, None, Some(2.0))), Some(1.5));
    }
}
