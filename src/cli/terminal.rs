//! What is written for people: as wide as their terminal, and bars only where there is one.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};

/// Columns of the terminal that a stream goes to; `None` where it goes elsewhere: lines of a log are not broken.
macro_rules! columns {
    ($stream:expr) => {{
        let stream = $stream;
        stream.is_terminal().then(|| terminal_size::terminal_size_of(&stream).map_or(80, |(w, _)| usize::from(w.0)))
    }};
}

/// `text`, for standard error, broken at blanks to the terminal's width; what follows its first line is indented.
pub fn fill(text: &str) -> String {
    fill_to(text, columns!(std::io::stderr()))
}

/// The same for standard output.
pub fn fill_output(text: &str) -> String {
    fill_to(text, columns!(std::io::stdout()))
}

fn fill_to(text: &str, width: Option<usize>) -> String {
    let Some(width) = width else { return text.to_owned() };
    let broken = |line: &str| {
        let indent = " ".repeat(line.len() - line.trim_start().len() + 2);
        let options = textwrap::Options::new(width.max(20))
            .subsequent_indent(&indent)
            .break_words(false)
            .word_separator(textwrap::WordSeparator::AsciiSpace)
            .word_splitter(textwrap::WordSplitter::NoHyphenation);
        textwrap::fill(line, options)
    };
    text.split('\n').map(broken).collect::<Vec<_>>().join("\n")
}

/// Writes a line to standard error. `eprintln!` panics where its reader has left, which is no failure.
pub fn say(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// A bar on the terminal, for `what`; nothing where there is no terminal.
pub fn bar(what: &'static str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg}, {eta} left");
    let bar = ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.with_message(what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_terminals_edge_and_go_on_indented() {
        let text = "warning: one two three four five\n  and a line that is indented";
        let wrapped = fill_to(text, Some(24));
        assert_eq!(wrapped, "warning: one two three\n  four five\n  and a line that is\n    indented");
        assert!(wrapped.lines().all(|l| l.len() <= 24));
        assert_eq!(fill_to(text, None), text);
        // A path is not cut: whoever copies it wants it whole.
        assert_eq!(fill_to("wrote a/very/long/path/of/more/than/24/columns", Some(24)).lines().count(), 2);
    }
}
