//! Rows that still arrive: what is there already, and what comes to be known.

use super::{Binding, Feed, Groups, Live, Port, Rows, Taken, pick, projection, row};
use crate::engine::{
    hash::Digest,
    plan::{OutputRef, PlanNode, Relation},
    value::ValueRef,
};
use std::sync::Arc;

impl Binding {
    /// Whether all rows that `element` takes one by one are there.
    pub fn has_all(&self, element: &str, live: &dyn Live) -> bool {
        self.ports.iter().all(|port| match port {
            Port::One { feed, columns, whole } => {
                row(feed.from, feed.rows.as_ref(), &projection(element, columns, *whole), usize::MAX, live).is_some()
            }
            Port::Many { feed: Feed { via: Some(via), .. }, .. } => via.row(element, live).is_some(),
            Port::Many { feed, columns, .. } if feed.rows.is_none() => {
                live.is_whole(feed.from, &pick(element, columns))
            }
            _ => true,
        })
    }

    /// Relations that `element` needs and that are not decoded yet: port, output and value.
    pub fn undecoded(&self, element: &str, live: &dyn Live) -> Vec<(usize, OutputRef, ValueRef)> {
        let ports = self.ports.iter().enumerate();
        let via = ports.filter_map(|(i, port)| match port {
            Port::Many { feed: Feed { via: Some(via), .. }, .. } => Some((i, via)),
            _ => None,
        });
        let missing = via.filter_map(|(i, via)| {
            let value = via.row(element, live)?;
            (!via.relations.contains_key(&value.hash)).then_some((i, via.from, value))
        });
        missing.collect()
    }

    /// Takes in a relation that has arrived.
    pub fn decoded(&mut self, port: usize, hash: Digest, relation: Arc<Relation>) {
        if let Port::Many { feed: Feed { via: Some(via), .. }, .. } = &mut self.ports[port] {
            via.relations.insert(hash, relation);
        }
    }

    /// Outputs whose rows were still to come, and how many of the node's axes, from the first on, each has or gathers
    /// below.
    pub fn arriving(&self) -> Vec<(OutputRef, usize)> {
        let of = |port: &Port| match port {
            Port::One { feed, columns, .. } | Port::Many { feed, columns, .. } if feed.rows.is_none() => {
                Some((feed.from, columns.len()))
            }
            Port::Many { feed: Feed { via: Some(via), .. }, .. } if via.rows.is_none() => {
                Some((via.from, via.columns.len()))
            }
            _ => None,
        };
        self.ports.iter().filter_map(of).collect()
    }

    /// All rows of `from` are known. `outer` is what [`Feed::outer`] is for a port of this number.
    pub fn complete(
        &mut self,
        node: &PlanNode,
        from: OutputRef,
        rows: &Rows,
        hash: Digest,
        outer: impl Fn(usize) -> Option<Rows>,
    ) {
        for (i, port) in self.ports.iter_mut().enumerate() {
            match port {
                Port::One { feed, .. } if feed.from == from => (feed.rows, feed.hash) = (Some(rows.clone()), hash),
                Port::Many { feed, groups, .. } if feed.from == from && feed.rows.is_none() => {
                    *groups = Groups::new(node, i, rows);
                    (feed.rows, feed.hash, feed.outer) = (Some(rows.clone()), hash, outer(i));
                }
                Port::Many { feed: Feed { via: Some(via), .. }, .. } if via.from == from => {
                    via.rows = Some(rows.clone());
                }
                _ => {}
            }
        }
    }

    /// What `element` takes through one port, if it can.
    pub fn taken(&self, port: usize, element: &str, live: &dyn Live) -> Option<Taken> {
        self.take_port(&self.ports[port], self.names[port], element, usize::MAX, live).ok()
    }
}
