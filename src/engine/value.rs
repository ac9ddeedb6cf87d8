//! Stored values and lists of them, by name and content hash.
//!
//! An element of a node that is mapped over several axes is named by one name per axis. In memory they are joined with
//! the unit separator, which sorts below every character that a name may hold: the order of joined names is the order
//! of the tuples.

use super::hash::Digest;
use std::sync::Arc;

/// Joins the names of an element's axes.
pub const JOIN: char = '\u{1f}';

/// A stored value: the hash of its bytes and their number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ValueRef {
    pub hash: Digest,
    pub size: u64,
}

/// A value and the element that it belongs to; the name is empty where there is no axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    pub name: Arc<str>,
    pub value: ValueRef,
}

/// What one run gave through one output port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortOut {
    One(ValueRef),
    /// Sorted by name, names unique.
    Many(Vec<(String, ValueRef)>),
}

/// The hash of a list: its names and contents in order.
pub fn list_hash<'a>(rows: impl ExactSizeIterator<Item = (&'a str, Digest)>) -> Digest {
    let mut h = blake3::Hasher::new();
    h.update(&(rows.len() as u64).to_le_bytes());
    for (name, hash) in rows {
        h.update(&(name.len() as u32).to_le_bytes());
        h.update(name.as_bytes());
        h.update(&hash.0);
    }
    h.finalize().into()
}

/// An element's name as people see it.
pub fn shown(name: &str) -> String {
    name.replace(JOIN, "/")
}

/// `outer` and `inner` as one element's name.
pub fn join(outer: &str, inner: &str) -> String {
    match (outer.is_empty(), inner.is_empty()) {
        (true, _) => inner.to_owned(),
        (_, true) => outer.to_owned(),
        _ => format!("{outer}{JOIN}{inner}"),
    }
}

/// Why `name` cannot name an element.
pub fn bad_name(name: &str) -> Option<&'static str> {
    if name.is_empty() {
        Some("is empty")
    } else if name.chars().any(|c| c < ' ') {
        Some("holds a control character")
    } else {
        None
    }
}
