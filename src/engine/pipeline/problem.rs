//! What is wrong with a pipeline: all of it at once, each with its place, what was found there, what was expected and
//! the nearest valid name.

use super::source::{Sources, TextSpan};
use crate::engine::suggest::elide;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, SourceCode};
use std::{fmt, path::PathBuf, sync::Arc};

/// A report shows at most this many problems; a file with more has one cause, and a terminal one screen.
const SHOWN: usize = 40;

/// Bytes of a line of a pipeline file that a report quotes; characters of a message, of a label and of a help.
const LINE: usize = 400;
const MESSAGE: usize = 300;
const LABEL: usize = 80;
const HELP: usize = 700;

/// One thing that is wrong.
#[derive(Clone, Debug)]
pub struct Problem {
    /// What is wrong, in one line.
    pub message: String,
    /// Where; `None` for what is wrong with no text, such as a pipeline file that cannot be read.
    pub place: Option<TextSpan>,
    /// What was found there.
    pub label: String,
    /// Other places that explain it.
    pub also: Vec<(TextSpan, String)>,
    /// What to do.
    pub help: Option<String>,
    /// A file beside the texts that it is about: missing, or not what is read there.
    /// Boxed, because few problems have one.
    pub file: Option<Box<PathBuf>>,
}

impl Problem {
    pub fn at(place: TextSpan, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self { place: Some(place), label: label.into(), ..Self::nowhere(message) }
    }

    pub fn nowhere(message: impl Into<String>) -> Self {
        Self { message: message.into(), place: None, label: String::new(), also: Vec::new(), help: None, file: None }
    }

    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        let help = help.into();
        self.help = (!help.is_empty()).then_some(help).or(self.help);
        self
    }

    #[must_use]
    pub fn of_file(mut self, path: impl Into<PathBuf>) -> Self {
        self.file = Some(Box::new(path.into()));
        self
    }

    #[must_use]
    pub fn also(mut self, place: TextSpan, label: impl Into<String>) -> Self {
        self.also.push((place, label.into()));
        self
    }
}

/// Everything that is wrong with a pipeline, with the texts that it quotes.
#[derive(Clone, Debug)]
pub struct Problems {
    pub sources: Sources,
    /// In the order of the texts.
    pub list: Vec<Problem>,
}

impl std::error::Error for Problems {}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.render(GraphicalTheme::unicode_nocolor(), 100))
    }
}

impl Problems {
    pub(super) fn new(sources: Sources, mut list: Vec<Problem>) -> Self {
        list.sort_by_key(|p| p.place);
        Self { sources, list }
    }

    /// The files that must be changed, or be there, before the pipeline can be right: its texts, and what they name.
    pub fn files(&self) -> Vec<PathBuf> {
        let named = self.list.iter().filter_map(|problem| problem.file.as_deref().cloned());
        self.sources.files().into_iter().chain(named).collect()
    }

    /// A report for people, `width` columns wide.
    pub fn render(&self, theme: GraphicalTheme, width: usize) -> String {
        let handler =
            GraphicalReportHandler::new_themed(theme).with_width(width).with_context_lines(1).with_wrap_lines(false);
        let mut out = String::new();
        for problem in self.list.iter().take(SHOWN) {
            // A line that no terminal holds is not quoted; its place is named.
            let quoted = problem.place.filter(|p| self.sources.longest_line(*p) <= LINE);
            let source = quoted.map(|p| {
                let source = self.sources.get(p);
                NamedSource::new(&source.name, Arc::clone(&source.text)).with_language("toml")
            });
            // miette would break names at their hyphens, so the lines are broken here.
            let shown = Shown { problem, sources: &self.sources, source, width: width.saturating_sub(8) };
            if handler.render_report(&mut out, &shown).is_err() {
                out.push_str(&problem.message);
            }
            out.push('\n');
        }
        if self.list.len() > SHOWN {
            out.push_str(&format!("and {} more problems\n", self.list.len() - SHOWN));
        }
        out
    }
}

/// A problem as miette sees it.
struct Shown<'a> {
    problem: &'a Problem,
    sources: &'a Sources,
    source: Option<NamedSource<Arc<str>>>,
    width: usize,
}

/// `text` in lines of at most `width` columns, broken between words and where it breaks itself.
fn wrap(text: &str, width: usize) -> String {
    text.lines().map(|line| wrap_line(line, width)).collect::<Vec<_>>().join("\n")
}

fn wrap_line(line: &str, width: usize) -> String {
    let mut out = String::new();
    let mut column = 0;
    for word in line.split(' ') {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > width {
            out.push('\n');
            column = 0;
        } else if column > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += length;
    }
    out
}

impl fmt::Debug for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.problem.fmt(f)
    }
}

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let (None, Some(place)) = (&self.source, self.problem.place) {
            write!(f, "{}: ", self.sources.line(place))?;
        }
        f.write_str(&elide(&self.problem.message, MESSAGE))
    }
}

impl std::error::Error for Shown<'_> {}

impl Diagnostic for Shown<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        // A report quotes one text; places in others are named.
        let elsewhere =
            self.problem.also.iter().filter(|(p, _)| Some(p.source) != self.problem.place.map(|p| p.source));
        let mut lines: Vec<String> =
            elsewhere.map(|(p, label)| format!("see {}, {}", self.sources.line(*p), elide(label, LABEL))).collect();
        lines.extend(self.problem.help.as_deref().map(|help| wrap(&elide(help, HELP), self.width)));
        (!lines.is_empty()).then(|| Box::new(lines.join("\n")) as _)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|s| s as _)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.problem.place.filter(|_| self.source.is_some())?;
        let span = move |p: TextSpan, label: &str| {
            let label = (!label.is_empty()).then(|| elide(label, LABEL));
            // Of a value of many lines the first is enough.
            let length = self.sources.text(p).lines().next().map_or(0, str::len);
            LabeledSpan::new(label, p.start as usize, length)
        };
        let short = move |p: &TextSpan| self.sources.longest_line(*p) <= LINE;
        let also = self.problem.also.iter().filter(move |(p, _)| p.source == place.source && *p != place && short(p));
        Some(Box::new(std::iter::once(span(place, &self.problem.label)).chain(also.map(move |(p, l)| span(*p, l)))))
    }
}
