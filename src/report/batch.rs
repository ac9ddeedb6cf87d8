//! The table of a batch as a page.

use super::{
    markup::Markup,
    numbers::{bytes, number},
    page::document,
};

/// What a batch came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    pub name: String,
    pub about: String,
    /// Titles of the values that differ between the bakes.
    pub given: Vec<String>,
    /// Titles of the numbers.
    pub measured: Vec<Column>,
    pub rows: Vec<BatchRow>,
    /// Of the program.
    pub version: String,
}

/// A column of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    pub title: String,
    /// How it is shown.
    pub is_bytes: bool,
}

/// One bake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchRow {
    pub name: String,
    /// Its report, below the page's folder; absent where there is none.
    pub report: Option<String>,
    /// `baked`, `failed`, ….
    pub outcome: String,
    pub good: bool,
    /// Of its first certificate.
    pub verdict: String,
    /// Requirements that are met, and all.
    pub met: [usize; 2],
    /// One for each of [`Batch::given`].
    pub given: Vec<String>,
    /// One for each of [`Batch::measured`].
    pub measured: Vec<Option<f64>>,
}

/// The page as an HTML document without its doctype. It tells no times.
pub fn batch(batch: &Batch) -> String {
    document(&format!("{}: farfield summary", batch.name), |m| {
        m.element("header", &[], |m| {
            m.with_text("h1", &[], &batch.name);
            if !batch.about.is_empty() {
                m.with_text("p", &[("class", "about")], &batch.about);
            }
            let good = batch.rows.iter().filter(|row| row.good).count();
            let class = if good == batch.rows.len() { "banner good" } else { "banner failed" };
            m.element("p", &[("class", class)], |m| {
                m.with_text("b", &[], &format!("{good} of {} bakes", batch.rows.len()))
                    .text(" met all that is required.");
            });
        });
        m.element("main", &[], |m| {
            m.element("section", &[], |m| {
                m.element("div", &[("class", "scroll")], |m| table(m, batch));
            });
        });
        m.with_text(
            "footer",
            &[],
            &format!("farfield {}. The same numbers for programs are in summary.csv.", batch.version),
        );
    })
}

fn table(m: &mut Markup, batch: &Batch) {
    m.element("table", &[], |m| {
        let mut heads = vec![("bake", ""), ("outcome", ""), ("verdict", ""), ("met", "n")];
        heads.extend(batch.given.iter().map(|title| (title.as_str(), "")));
        heads.extend(batch.measured.iter().map(|column| (column.title.as_str(), "n")));
        m.heads(&heads);
        m.element("tbody", &[], |m| {
            for row in &batch.rows {
                m.element("tr", &[("class", if row.good { "met" } else { "missed" })], |m| cells(m, batch, row));
            }
        });
    });
}

fn cells(m: &mut Markup, batch: &Batch, row: &BatchRow) {
    m.element("th", &[("scope", "row")], |m| {
        match &row.report {
            Some(path) => m.with_text("a", &[("href", path)], &row.name),
            None => m.text(&row.name),
        };
    });
    m.with_text("td", &[], &row.outcome).with_text("td", &[], &row.verdict);
    let [met, all] = row.met;
    m.with_text("td", &[("class", "n")], &if all > 0 { format!("{met} of {all}") } else { String::new() });
    for value in &row.given {
        m.with_text("td", &[], value);
    }
    for (column, value) in batch.measured.iter().zip(&row.measured) {
        let text = value.map_or(String::new(), |v| if column.is_bytes { bytes(v) } else { number(v) });
        m.with_text("td", &[("class", "n")], &text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bake_has_a_row() {
        let row = |name: &str, good: bool| BatchRow {
            name: name.into(),
            report: good.then(|| format!("{name}/report.html")),
            outcome: if good { "baked" } else { "failed" }.into(),
            good,
            met: [2, 3],
            given: vec!["<b>".into()],
            measured: vec![Some(2048.0), None],
            ..BatchRow::default()
        };
        let column = |title: &str, is_bytes| Column { title: title.into(), is_bytes };
        let page = batch(&Batch {
            name: "models".into(),
            given: vec!["scene".into()],
            measured: vec![column("memory", true), column("dB", false)],
            rows: vec![row("a", true), row("b", false)],
            ..Batch::default()
        });
        for expect in ["1 of 2 bakes", "href=\"a/report.html\"", "2.0 KiB", "&lt;b&gt;", "2 of 3", "class=\"missed\""] {
            assert!(page.contains(expect), "{expect}: {page}");
        }
        assert!(!page.contains("<b>&") && !page.contains("b/report.html") && !page.contains("<script"));
    }
}
