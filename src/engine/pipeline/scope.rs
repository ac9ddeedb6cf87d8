//! What the text of a pipeline, or of a part of one, can refer to.

use super::{
    item::{Item, Items},
    source::TextSpan,
};
use std::collections::BTreeMap;

/// What a parent may plug in.
pub struct Input<'s> {
    pub key: TextSpan,
    /// The type of its values.
    pub ty: &'s str,
    pub default: Option<Item<'s>>,
    /// What the parent says.
    pub given: Option<Item<'s>>,
}

/// A part, or the pipeline itself, as its own text sees it.
#[derive(Default)]
pub struct Part<'s> {
    /// The node that it stands for.
    pub node: &'s str,
    pub knobs: Items<'s>,
    pub inputs: BTreeMap<&'s str, Input<'s>>,
    pub outputs: Items<'s>,
    /// Names of lists that no node of it gathers.
    pub per: Vec<(&'s str, TextSpan)>,
    /// What its own text calls a node, and what the node is called among all; `None` for the pipeline itself, where both are one.
    pub names: Option<&'s BTreeMap<String, String>>,
}

impl<'s> Part<'s> {
    /// What a node that its text calls `name` is called among all.
    pub fn full<'n>(&self, name: &'n str) -> Option<&'n str>
    where
        's: 'n,
    {
        // What lies in a part is the part's own.
        self.names.map_or_else(|| Some(name).filter(|n| !n.contains('/')), |names| names.get(name).map(String::as_str))
    }

    /// Names as its own text writes them, of the nodes of all.
    pub fn own<'n>(&self, names: impl Iterator<Item = &'n str> + Clone) -> impl Iterator<Item = &'n str> + Clone {
        let prefix = if self.node.is_empty() { String::new() } else { format!("{}/", self.node) };
        names.filter_map(move |name| name.strip_prefix(&*prefix)).filter(|name| !name.contains('/'))
    }

    /// The output that the part gives where its parent names none.
    pub fn first_output(&self) -> Option<Item<'s>> {
        self.outputs.values().min_by_key(|item| item.key).copied()
    }
}
