//! How often a measure has which value, as SVG.

use super::{
    Series,
    markup::Markup,
    numbers::{amount, number, place},
};

const WIDTH: f64 = 330.0;
const HEIGHT: f64 = 96.0;
/// Bins at most.
const BINS: f64 = 22.0;
/// Bins for which there is room at least.
const SLOTS: usize = 10;

/// Bins of equal width from `start` on.
#[derive(Clone, Debug, PartialEq)]
struct Bins {
    start: f64,
    step: f64,
    counts: Vec<usize>,
}

/// A chart for every measure that differs between views, and in words those that do not.
pub fn histograms(m: &mut Markup, all: &[Series]) {
    let differs = |s: &&Series| s.values.iter().any(|v| *v != s.values[0]);
    let (charts, same): (Vec<&Series>, Vec<&Series>) = all.iter().partition(differs);
    m.element("div", &[("class", "histograms")], |m| charts.into_iter().for_each(|s| histogram(m, s)));
    let same = same.into_iter().filter_map(|s| {
        let value = amount(*s.values.first()?, s.unit);
        Some(format!("{}: {value} in all {} {}", s.title, s.values.len(), s.of))
    });
    let same: Vec<String> = same.collect();
    if !same.is_empty() {
        m.with_text("p", &[("class", "dim")], &format!("{}.", same.join("; ")));
    }
}

/// One chart with its summary in words.
fn histogram(m: &mut Markup, series: &Series) {
    let Series { title, unit, higher_is_better, values, .. } = series;
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    let (Some(low), Some(high)) = (sorted.first().copied(), sorted.last().copied()) else { return };
    let middle = sorted[(sorted.len() - 1) / 2];
    let worst = if *higher_is_better { low } else { high };
    m.element("figure", &[("class", "histogram")], |m| {
        m.element("figcaption", &[], |m| {
            m.with_text("b", &[], title);
            let text = format!("worst {}, median {}", amount(worst, unit), amount(middle, unit));
            m.with_text("span", &[], &text);
        });
        chart(m, &bins(&sorted, low, high), series);
    });
}

fn chart(m: &mut Markup, bins: &Bins, series: &Series) {
    let most = bins.counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    // Few bins leave room at the right instead of being wide.
    let step = WIDTH / bins.counts.len().max(SLOTS) as f64;
    let frame = format!("0 0 {WIDTH} {}", HEIGHT + 18.0);
    let label = format!("How many {} have which value", series.of);
    m.element("svg", &[("viewBox", &frame), ("role", "img"), ("aria-label", &label)], |m| {
        for (k, count) in bins.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            // One view of a hundred thousand is seen.
            let height = ((HEIGHT - 14.0) * *count as f64 / most).max(1.5);
            let (x, y) = (place(k as f64 * step + 0.5), place(HEIGHT - height));
            let (w, h) = (place(step - 1.0), place(height));
            let all = [("class", "bar"), ("x", &*x), ("y", &y), ("width", &w), ("height", &h), ("rx", "1.5")];
            m.element("rect", &all, |m| {
                let (from, to) = (bins.start + k as f64 * bins.step, bins.start + (k + 1) as f64 * bins.step);
                let range = format!("{} to {}: {count} {}", number(from), amount(to, series.unit), series.of);
                m.with_text("title", &[], &range);
            });
            if *count as f64 == most {
                let (x, y) = (place((k as f64 + 0.5) * step), place(HEIGHT - height - 4.0));
                m.with_text("text", &[("class", "most"), ("x", &x), ("y", &y)], &count.to_string());
            }
        }
        let length = step * bins.counts.len() as f64;
        let (right, bottom, below) = (place(length), place(HEIGHT), place(HEIGHT + 14.0));
        m.element("line", &[("class", "axis"), ("x1", "0"), ("x2", &right), ("y1", &bottom), ("y2", &bottom)], |_| {});
        let end = bins.start + bins.counts.len() as f64 * bins.step;
        m.with_text("text", &[("class", "tick"), ("x", "0"), ("y", &below)], &number(bins.start));
        m.with_text("text", &[("class", "tick end"), ("x", &right), ("y", &below)], &amount(end, series.unit));
    });
}

/// Bins whose width is 1, 2 or 5 times a power of ten, and that start at a multiple of it. `sorted` rises from `low` to `high` > `low`.
fn bins(sorted: &[f64], low: f64, high: f64) -> Bins {
    let rough = (high - low) / BINS;
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let whole = sorted.iter().all(|v| v.fract() == 0.0);
    let steps = [1.0, 2.0, 5.0, 10.0].map(|k| k * power);
    let step = steps.into_iter().find(|s| *s >= rough).unwrap_or(rough);
    // Numbers of pixels have bins of whole numbers.
    let step = if whole { step.max(1.0) } else { step };
    let start = (low / step).floor() * step;
    let count = (((high - start) / step).floor() as usize + 1).min(2 * BINS as usize);
    let mut counts = vec![0; count];
    for v in sorted {
        counts[(((v - start) / step) as usize).min(count - 1)] += 1;
    }
    Bins { start, step, counts }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_a_bin_of_round_numbers() {
        let values: Vec<f64> = (0..100).map(|i| 20.03 + f64::from(i) * 0.05).collect();
        let b = bins(&values, 20.03, values[99]);
        assert!((b.step - 0.5).abs() < 1e-12 && (b.start - 20.0).abs() < 1e-9, "{b:?}");
        assert_eq!(b.counts.iter().sum::<usize>(), 100);
        let counted = bins(&[0.0, 0.0, 1.0, 4.0], 0.0, 4.0);
        assert_eq!((counted.step, counted.counts), (1.0, vec![2, 1, 0, 0, 1]));
        // Ends far apart and ends next to each other.
        for (low, high) in [(0.0, 1e18), (1.0, 1.0 + f64::EPSILON), (-3.0, 1e-9), (0.0, 5e-324)] {
            let b = bins(&[low, high], low, high);
            assert!(b.counts.len() < 50 && b.counts.iter().sum::<usize>() == 2, "{low} {high} {b:?}");
        }
    }
}
