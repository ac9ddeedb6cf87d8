//! Texts that a pipeline is made of, and places in them.

use std::{ops::Range, path::PathBuf, sync::Arc};

/// A span of bytes in one of the [`Sources`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct TextSpan {
    pub source: u32,
    pub start: u32,
    pub end: u32,
}

impl TextSpan {
    pub fn new(source: u32, span: Range<usize>) -> Self {
        // Texts are at most `read::MAX_BYTES` long.
        Self { source, start: span.start as u32, end: span.end as u32 }
    }
}

/// One text: a pipeline file, a stock pipeline or a `--set` argument.
#[derive(Clone, Debug)]
pub struct Source {
    /// What messages call it.
    pub name: String,
    pub text: Arc<str>,
    /// The folder that its relative paths start from.
    pub folder: PathBuf,
    /// A `--set` argument: its text may stand for a string without quotes.
    pub argument: bool,
    /// The file that the text was read from; `None` for a stock pipeline or an argument.
    pub file: Option<PathBuf>,
    /// The part of the pipeline that it belongs to: see [`part`](super::part). 0 for what is baked and for arguments.
    pub part: usize,
}

/// All texts: the given file first, then its bases, then its parts with theirs, then the arguments.
#[derive(Clone, Debug, Default)]
pub struct Sources(Vec<Source>);

impl Sources {
    pub fn add(&mut self, source: Source) -> u32 {
        self.0.push(source);
        (self.0.len() - 1) as u32
    }

    pub fn get(&self, place: TextSpan) -> &Source {
        &self.0[place.source as usize]
    }

    pub fn by_number(&self, source: u32) -> &Source {
        &self.0[source as usize]
    }

    /// Whether not even the first text could be read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The files that texts were read from.
    pub fn files(&self) -> Vec<PathBuf> {
        self.0.iter().filter_map(|source| source.file.clone()).collect()
    }

    /// The text at `place`.
    pub fn text(&self, place: TextSpan) -> &str {
        self.get(place).text.get(place.start as usize..place.end as usize).unwrap_or_default()
    }

    /// Bytes of the longest of the lines that a report quotes for `place`: its first, the one before and the one after.
    pub fn longest_line(&self, place: TextSpan) -> usize {
        let text = self.get(place).text.as_bytes();
        let at = (place.start as usize).min(text.len());
        let end = |from: usize| text[from..].iter().position(|b| *b == b'\n').map_or(text.len(), |n| from + n);
        let start = |to: usize| text[..to].iter().rposition(|b| *b == b'\n').map_or(0, |n| n + 1);
        let (first, last) = (start(at), end(at));
        let before = first.saturating_sub(1);
        let after = (last + 1).min(text.len());
        (last - first).max(before - start(before)).max(end(after) - after)
    }

    /// `file:line`, the line counted from 1.
    pub fn line(&self, place: TextSpan) -> String {
        let source = self.get(place);
        let before = source.text.as_bytes().get(..place.start as usize).unwrap_or_default();
        format!("{}:{}", source.name, before.iter().filter(|b| **b == b'\n').count() + 1)
    }
}
