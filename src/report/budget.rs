//! What original and stand-in cost: bars of one scale for each pair.

use super::{
    Certificate, Cost, Unit,
    markup::Markup,
    numbers::{bytes, number, place},
};

pub fn budget(m: &mut Markup, certificate: &Certificate) {
    m.element("dl", &[("class", "costs")], |m| {
        for cost in &certificate.costs {
            m.element("div", &[], |m| one(m, cost));
        }
    });
}

fn one(m: &mut Markup, cost: &Cost) {
    let show = |v: f64| if cost.unit == Unit::Bytes { bytes(v) } else { number(v) };
    m.element("dt", &[], |m| {
        m.text(cost.what);
        if let Some(word) = cost.before.and_then(|before| change(before, cost.after)) {
            m.with_text("small", &[("class", if cost.before < Some(cost.after) { "more" } else { "less" })], &word);
        }
    });
    let most = cost.before.unwrap_or(0.0).max(cost.after);
    let mut bar = |class: &'static str, name: &str, v: f64| {
        m.element("dd", &[("class", class)], |m| {
            m.with_text("span", &[], name).with_text("b", &[], &show(v));
            let share = if most > 0.0 { 100.0 * v / most } else { 0.0 };
            m.element("i", &[("style", &format!("width:{}%", place(share)))], |_| {});
        });
    };
    if let Some(before) = cost.before {
        bar("before", "original", before);
    }
    bar("after", "stand-in", cost.after);
}

/// `81 × fewer`; nothing where both are equal or one is nothing.
fn change(before: f64, after: f64) -> Option<String> {
    let ratio = if before > after { before / after } else { after / before };
    let word = if before > after { "less" } else { "more" };
    match ratio {
        r if !r.is_finite() || r < 1.005 => None,
        r if r < 2.0 => Some(format!("{:.0} % {word}", 100.0 * (after / before - 1.0).abs())),
        r if r < 10.0 => Some(format!("{r:.1} × {word}")),
        r => Some(format!("{} × {word}", number(r.round()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_in_words() {
        for (before, after, expect) in [
            (158_978.0, 1950.0, Some("82 × less")),
            (100.0, 80.0, Some("20 % less")),
            (10.0, 25.0, Some("2.5 × more")),
            (5.0, 5.0, None),
            (0.0, 3.0, None),
            (3.0, 0.0, None),
        ] {
            assert_eq!(change(before, after).as_deref(), expect, "{before} {after}");
        }
    }
}
