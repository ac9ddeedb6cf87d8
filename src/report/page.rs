//! The page as a whole: its parts in order, with style and script inside.

use super::{
    Certificate, Page,
    bounds::bounds,
    budget::budget,
    drawing::graph,
    histogram::histograms,
    markup::Markup,
    numbers::{amount, bytes, count, number, seconds},
    reasons::reasons,
    views::{link, views},
};

/// Nothing is loaded from anywhere, and of scripts only the page's own runs.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'nonce-farfield'; \
                      base-uri 'none'; form-action 'none'";
/// Published files that are listed before the rest is counted.
const LISTED: usize = 60;

/// The page as an HTML document without its doctype.
pub fn html(page: &Page) -> String {
    document(&format!("{}: farfield report", page.name), |m| {
        head(m, page);
        m.element("main", &[], |m| contents(m, page));
        m.element("footer", &[], |m| {
            m.text(&format!("farfield {}, {}. ", page.version, page.at));
            m.text("Times and hits are of the bake that wrote this page. The same numbers for programs are in ");
            link(m, "run.json");
            m.text(", hashes in ");
            link(m, "manifest.json");
            m.text(".");
        });
        m.element("script", &[("nonce", "farfield")], |m| {
            m.raw(include_str!("report.js"));
        });
    })
}

/// A document with what `inside` writes as its body.
pub fn document(title: &str, inside: impl FnOnce(&mut Markup)) -> String {
    let mut m = Markup::default();
    m.element("html", &[("lang", "en")], |m| {
        m.element("head", &[], |m| {
            m.void("meta", &[("charset", "utf-8")]);
            m.void("meta", &[("http-equiv", "Content-Security-Policy"), ("content", POLICY)]);
            m.void("meta", &[("name", "viewport"), ("content", "width=device-width, initial-scale=1")]);
            m.void("meta", &[("name", "color-scheme"), ("content", "light dark")]);
            m.with_text("title", &[], title);
            m.element("style", &[], |m| {
                m.raw(include_str!("report.css"));
            });
        });
        m.element("body", &[], inside);
    });
    m.finish() + "\n"
}

fn head(m: &mut Markup, page: &Page) {
    m.element("header", &[], |m| {
        m.with_text("h1", &[], &page.name);
        if !page.about.is_empty() {
            m.with_text("p", &[("class", "about")], &page.about);
        }
        let (hits, runs) = page.nodes.iter().fold((0, 0), |(h, r), n| (h + n.hits, r + n.runs));
        let mut facts =
            vec![page.at.clone(), seconds(page.seconds), count(runs as usize, "run"), count(hits as usize, "hit")];
        facts.extend(page.peak_memory.map(|peak| format!("peak {}", bytes(peak as f64))));
        if page.warnings > 0 {
            facts.push(count(page.warnings, "warning"));
        }
        m.element("p", &[("class", "facts")], |m| {
            for fact in &facts {
                m.with_text("span", &[], fact);
            }
        });
        let missed = page.bounds.iter().filter(|b| !b.met).count();
        if let Some(text) = &page.rejected {
            m.element("p", &[("class", "banner failed"), ("role", "alert")], |m| {
                m.with_text("b", &[], "Rejected. ");
                m.text(&format!("{missed} of {} missed. {text}", count(page.bounds.len(), "requirement")));
            });
        }
        for certificate in &page.certificates {
            verdict(m, certificate, page.certificates.len() > 1);
        }
        if page.certificates.iter().all(|c| c.verdict.is_none()) && page.rejected.is_none() && !page.bounds.is_empty() {
            m.element("p", &[("class", "banner good")], |m| {
                m.with_text("b", &[], &format!("{} met", count(page.bounds.len(), "requirement")));
            });
        }
    });
}

fn verdict(m: &mut Markup, certificate: &Certificate, named: bool) {
    let Some(verdict) = &certificate.verdict else { return };
    let class = match &**verdict {
        "indistinguishable" | "good" => "banner good",
        "visible" => "banner visible",
        _ => "banner failed",
    };
    m.element("p", &[("class", class)], |m| {
        if named {
            m.with_text("code", &[], &certificate.path).text(" ");
        }
        m.with_text("b", &[], verdict).text(" ").text(&certificate.sentence);
    });
}

fn section(m: &mut Markup, id: &str, title: &str, inside: impl FnOnce(&mut Markup)) {
    m.element("section", &[("id", id)], |m| {
        m.with_text("h2", &[], title);
        inside(m);
    });
}

/// A part that each certificate has, if any has it.
fn of_certificates(
    m: &mut Markup,
    page: &Page,
    (id, title): (&str, &str),
    has: impl Fn(&Certificate) -> bool,
    show: impl Fn(&mut Markup, usize, &Certificate),
) {
    if !page.certificates.iter().any(&has) {
        return;
    }
    section(m, id, title, |m| {
        for (k, certificate) in page.certificates.iter().enumerate().filter(|(_, c)| has(c)) {
            if page.certificates.len() > 1 {
                m.with_text("h3", &[], &certificate.path);
            }
            show(m, k, certificate);
        }
    });
}

fn contents(m: &mut Markup, page: &Page) {
    of_certificates(m, page, ("budget", "Before and after"), |c| !c.costs.is_empty(), |m, _, c| budget(m, c));
    if !page.bounds.is_empty() {
        let met = page.bounds.iter().filter(|b| b.met).count();
        section(m, "requirements", &format!("Requirements: {met} of {} met", page.bounds.len()), |m| {
            m.element("div", &[("class", "scroll")], |m| bounds(m, &page.bounds));
        });
    }
    let seen = |c: &Certificate| !c.views.is_empty() || !c.other_pictures.is_empty();
    of_certificates(m, page, ("views", "Views"), seen, |m, k, c| views(m, c, &format!("view-{k}-")));
    of_certificates(
        m,
        page,
        ("errors", "Errors over the views"),
        |c| !c.series.is_empty(),
        |m, _, c| histograms(m, &c.series),
    );
    of_certificates(m, page, ("figures", "Figures"), |c| !c.figures.is_empty(), |m, _, c| figures(m, c));
    section(m, "graph", "Nodes", |m| {
        m.element("p", &[("class", "key")], |m| {
            m.raw("<span class=\"ran\">ran</span><span class=\"hit\">taken from the cache</span>");
            m.raw("<span class=\"many\">once for each element</span><span class=\"bar\">share of the time</span>");
        });
        graph(m, page);
    });
    section(m, "why", "What ran and why", |m| reasons(m, page));
    section(m, "settings", "Settings and files", |m| settings(m, page));
}

/// All numbers of a certificate. Where there is a verdict they are for those who ask.
fn figures(m: &mut Markup, certificate: &Certificate) {
    let open: &[_] = if certificate.verdict.is_none() { &[("open", "")] } else { &[] };
    m.element("details", open, |m| {
        m.with_text("summary", &[], &format!("{} of {}", count(certificate.figures.len(), "number"), certificate.path));
        m.element("table", &[], |m| {
            m.heads(&[("What", ""), ("Value", "n"), ("In the certificate", "")]);
            m.element("tbody", &[], |m| {
                for f in &certificate.figures {
                    m.element("tr", &[], |m| {
                        m.with_text("td", &[], &f.about).with_text("td", &[("class", "n")], &amount(f.value, &f.unit));
                        m.element("td", &[], |m| {
                            m.with_text("code", &[], &f.path);
                        });
                    });
                }
            });
        });
    });
}

fn settings(m: &mut Markup, page: &Page) {
    m.element("div", &[("class", "columns")], |m| {
        m.element("table", &[], |m| {
            m.element("tbody", &[], |m| {
                let mut row = |name: &str, value: &str, code: bool| {
                    m.element("tr", &[], |m| {
                        m.with_text("th", &[("scope", "row")], name);
                        m.element("td", &[], |m| {
                            m.with_text(if code { "code" } else { "span" }, &[], value);
                        });
                    });
                };
                row("pipeline file", &page.file, true);
                page.sources.iter().for_each(|source| row("source", source, true));
                page.knobs.iter().for_each(|(name, value)| row(name, value, true));
            });
        });
        m.element("table", &[], |m| {
            m.heads(&[("File", ""), ("Size", "n")]);
            m.element("tbody", &[], |m| {
                for file in page.files.iter().take(LISTED) {
                    m.element("tr", &[], |m| {
                        m.element("td", &[], |m| link(m, &file.path));
                        m.with_text("td", &[("class", "n")], &bytes(file.bytes as f64));
                    });
                }
                let size = |files: &[super::File]| bytes(files.iter().map(|f| f.bytes as f64).sum());
                let rest = page.files.get(LISTED..).unwrap_or_default();
                let mut sum = |name: String, size: &str| {
                    m.element("tr", &[("class", "sum")], |m| {
                        m.with_text("td", &[], &name).with_text("td", &[("class", "n")], size);
                    });
                };
                if !rest.is_empty() {
                    sum(format!("and {} more", number(rest.len() as f64)), &size(rest));
                }
                sum(count(page.files.len(), "file"), &size(&page.files));
            });
        });
    });
}
