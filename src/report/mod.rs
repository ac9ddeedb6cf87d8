//! The report of a bake: one page of HTML that needs no other file, no network and no build.
//!
//! What always holds: the page is made of [`Page`] alone, which is plain data; every text in it is escaped ([`markup`]); pictures are embedded,
//! at most [`pictures::MOST_VIEWS`] of them and at most [`pictures::MOST_BYTES`] together.

mod batch;
mod bounds;
mod budget;
pub mod certificate;
mod drawing;
mod graph;
mod histogram;
mod markup;
mod numbers;
mod page;
pub mod pictures;
mod reasons;
mod views;

pub use batch::{Batch, BatchRow, Column, batch};
pub use page::html;

use serde::Serialize;

/// What a report tells.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Page {
    /// The pipeline's name, what it is about, and its file.
    pub name: String,
    pub about: String,
    pub file: String,
    /// The scenes that were baked.
    pub sources: Vec<String>,
    /// Knobs and their values.
    pub knobs: Vec<(String, String)>,
    /// When the bake ended.
    pub at: String,
    /// Wall clock.
    pub seconds: f64,
    /// Bytes.
    pub peak_memory: Option<u64>,
    pub warnings: usize,
    /// Where a bound was missed: what became of the results.
    pub rejected: Option<String>,
    pub bounds: Vec<Bound>,
    pub certificates: Vec<Certificate>,
    /// In an order in which every node follows what it reads.
    pub nodes: Vec<Node>,
    pub edges: Vec<Edge>,
    pub reasons: Vec<Reason>,
    pub files: Vec<File>,
    /// Of the program.
    pub version: String,
}

/// A bound that was demanded of a certificate's number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bound {
    /// The node whose certificate it is.
    pub node: String,
    /// Of the number in the certificate.
    pub path: String,
    pub about: String,
    pub unit: String,
    /// Absent where the certificate has no such number.
    pub measured: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub met: bool,
}

/// What one certificate says.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Certificate {
    /// Of the file, below the output folder.
    pub path: String,
    /// Absent where the method gives none.
    pub verdict: Option<String>,
    pub sentence: String,
    pub costs: Vec<Cost>,
    pub series: Vec<Series>,
    /// Numbers with their meanings.
    pub figures: Vec<Figure>,
    pub views: Vec<View>,
    /// What the colours of the differences mean.
    pub legend: Vec<([u8; 3], String)>,
    /// Pictures that are not embedded: paths below the output folder.
    pub other_pictures: Vec<String>,
}

/// What original and stand-in cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    pub what: &'static str,
    pub unit: Unit,
    /// Absent where the original has no such cost.
    pub before: Option<f64>,
    pub after: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Unit {
    #[default]
    Count,
    Bytes,
}

/// A measure in every view.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Series {
    pub title: String,
    pub unit: &'static str,
    pub higher_is_better: bool,
    /// Finite; views that show nothing are left out.
    pub values: Vec<f64>,
    /// What `values` are of, in the plural.
    pub of: &'static str,
}

/// A number of a certificate.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figure {
    pub about: String,
    pub path: String,
    pub value: f64,
    pub unit: String,
}

/// Pictures of one view.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct View {
    /// What is to be seen: `most holes: 12 px`.
    pub titles: Vec<String>,
    /// Its number and its camera, for people.
    pub place: String,
    pub shown: Shown,
}

/// Pictures as PNG files.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Shown {
    /// Of one size, in pixels.
    Compared {
        size: [u32; 2],
        original: Vec<u8>,
        stand_in: Vec<u8>,
        difference: Vec<u8>,
    },
    Alone {
        size: [u32; 2],
        picture: Vec<u8>,
    },
}

impl Default for Shown {
    fn default() -> Self {
        Self::Alone { size: [1, 1], picture: Vec::new() }
    }
}

/// What became of one node.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Node {
    pub name: String,
    /// Kind and method.
    pub kind: String,
    /// Whether it runs once for each element of a list.
    pub mapped: bool,
    pub hits: u64,
    pub runs: u64,
    /// Summed over the runs.
    pub seconds: f64,
}

/// What flows from one node to another; both by their places in [`Page::nodes`].
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Edge {
    pub from: usize,
    pub to: usize,
    pub label: String,
    /// Gathered into a list.
    pub list: bool,
}

/// Why a node ran.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Reason {
    pub node: String,
    pub did: String,
    pub cause: String,
    /// The node from which the change came.
    pub from: Option<String>,
}

/// A published file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct File {
    pub path: String,
    pub bytes: u64,
}

#[cfg(test)]
mod tests;
