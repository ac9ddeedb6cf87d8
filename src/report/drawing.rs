//! The graph as SVG: a box for each node with its times, runs and hits, and curves for what flows.

use super::{
    Page,
    graph::{Sizes, lay_out},
    markup::Markup,
    numbers::{number, place, seconds},
};
use std::fmt::Write as _;

const SIZES: Sizes = Sizes { width: 196.0, height: 66.0, gap: [22.0, 34.0], lane: 10.0 };
const MARGIN: f64 = 6.0;
/// Characters of a name that fit into a box, and of the lines below it.
const NAME: usize = 24;
const SMALL: usize = 28;

/// The drawing, and the same as a table.
pub fn graph(m: &mut Markup, page: &Page) {
    let ends: Vec<(usize, usize)> = page.edges.iter().map(|e| (e.from, e.to)).collect();
    let drawing = lay_out(page.nodes.len(), &ends, SIZES);
    let most = page.nodes.iter().map(|n| n.seconds).fold(0.0, f64::max);
    let size = drawing.size.map(|s| place(s + 2.0 * MARGIN));
    let frame = format!("0 0 {} {}", size[0], size[1]);
    let attributes = [
        ("class", "graph"),
        ("width", &*size[0]),
        ("height", &size[1]),
        ("viewBox", &frame),
        ("role", "img"),
        ("aria-label", "The graph of nodes; the table below says the same"),
    ];
    m.element("div", &[("class", "scroll")], |m| {
        m.element("svg", &attributes, |m| {
            for (edge, points) in page.edges.iter().zip(&drawing.edges).filter(|(_, p)| !p.is_empty()) {
                let class = if edge.list { "edge list" } else { "edge" };
                let (from, to) = (edge.from.to_string(), edge.to.to_string());
                let attributes = [("class", class), ("d", &*curve(points)), ("data-from", &from), ("data-to", &to)];
                m.element("path", &attributes, |m| {
                    m.with_text("title", &[], &edge.label);
                });
            }
            for (n, corner) in drawing.nodes.iter().enumerate() {
                node(m, page, n, *corner, most);
            }
        });
    });
    m.element("details", &[], |m| {
        m.with_text("summary", &[], "As a table");
        table(m, page);
    });
}

/// Vertical at every point, so that it leaves and enters boxes straight.
fn curve(points: &[[f64; 2]]) -> String {
    let at = |p: [f64; 2]| format!("{} {}", place(p[0] + MARGIN), place(p[1] + MARGIN));
    let mut d = format!("M{}", at(points[0]));
    for pair in points.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let half = (y1 - y0) / 2.0;
        // Writing to a String cannot fail.
        let _ = if (x0 - x1).abs() < 0.05 {
            write!(d, "L{}", at(pair[1]))
        } else {
            write!(d, "C{} {} {}", at([x0, y0 + half]), at([x1, y1 - half]), at(pair[1]))
        };
    }
    d
}

fn node(m: &mut Markup, page: &Page, n: usize, corner: [f64; 2], most: f64) {
    let node = &page.nodes[n];
    let [x, y] = corner.map(|v| v + MARGIN);
    let (class, number_text) = (if node.runs > 0 { "node ran" } else { "node hit" }, n.to_string());
    let text = |m: &mut Markup, class: &str, line: f64, text: &str| {
        let (x, y) = (place(x + 12.0), place(y + line));
        m.with_text("text", &[("class", class), ("x", &x), ("y", &y)], text);
    };
    m.element("g", &[("class", class), ("data-node", &number_text)], |m| {
        let what = format!("{}: {}\n{}, {}", node.name, node.kind, told(node.runs, node.hits), seconds(node.seconds));
        m.with_text("title", &[], &what);
        let (w, h) = (place(SIZES.width), place(SIZES.height));
        let rect = |m: &mut Markup, class: &str, x: f64, y: f64, w: &str, h: &str, r: &str| {
            let (x, y) = (place(x), place(y));
            let all = [("class", class), ("x", &*x), ("y", &y), ("width", w), ("height", h), ("rx", r)];
            m.element("rect", &all, |_| {});
        };
        if node.mapped {
            rect(m, "box behind", x + 4.0, y + 4.0, &w, &h, "7");
        }
        rect(m, "box", x, y, &w, &h, "7");
        text(m, "name", 20.0, &fitted(&node.name, NAME));
        if node.kind != node.name {
            text(m, "kind", 36.0, &fitted(&node.kind, SMALL));
        }
        let time = if node.runs > 0 { format!(" · {}", seconds(node.seconds)) } else { String::new() };
        text(m, "told", 53.0, &fitted(&format!("{}{time}", told(node.runs, node.hits)), SMALL));
        if most > 0.0 && node.seconds > 0.0 {
            let share = ((SIZES.width - 24.0) * node.seconds / most).max(1.0);
            rect(m, "time", x + 12.0, y + SIZES.height - 7.0, &place(share), "3", "1.5");
        }
    });
}

fn told(runs: u64, hits: u64) -> String {
    match (runs, hits) {
        (0, 0) => "no elements".to_owned(),
        (0, 1) => "hit".to_owned(),
        (1, 0) => "ran".to_owned(),
        (runs, 0) => format!("{} ran", number(runs as f64)),
        (0, hits) => format!("{} hits", number(hits as f64)),
        (runs, hits) => format!("{} ran, {} hits", number(runs as f64), number(hits as f64)),
    }
}

/// The text, or its beginning where it is longer than `most` characters.
fn fitted(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

fn table(m: &mut Markup, page: &Page) {
    let most = page.nodes.iter().map(|n| n.seconds).fold(0.0, f64::max);
    m.element("table", &[], |m| {
        m.heads(&[("Node", ""), ("Kind", ""), ("Ran", "n"), ("Hits", "n"), ("Time", "n"), ("", "")]);
        m.element("tbody", &[], |m| {
            for node in &page.nodes {
                m.element("tr", &[], |m| {
                    m.with_text("td", &[], &node.name).with_text("td", &[("class", "dim")], &node.kind);
                    for count in [node.runs, node.hits] {
                        m.with_text("td", &[("class", "n")], &number(count as f64));
                    }
                    let time = if node.runs > 0 { seconds(node.seconds) } else { String::new() };
                    m.with_text("td", &[("class", "n")], &time);
                    m.element("td", &[("class", "bars")], |m| {
                        if most > 0.0 && node.seconds > 0.0 {
                            let style = format!("width:{}%", place((100.0 * node.seconds / most).max(0.5)));
                            m.element("i", &[("style", &style)], |_| {});
                        }
                    });
                });
            }
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_between_characters() {
        assert_eq!((fitted("abc", 3), fitted("äöüß", 3)), ("abc".to_owned(), "äö…".to_owned()));
        assert_eq!(
            [told(0, 1), told(1, 0), told(3, 0), told(0, 2), told(1, 2)],
            ["hit", "ran", "3 ran", "2 hits", "1 ran, 2 hits"]
        );
    }
}
