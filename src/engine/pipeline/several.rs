//! Several outputs for one list port: `stand_ins = { impostor = "impostor.bundle", mesh = "mesh.bundle" }`.

use super::{
    item::{Item, valid_name, what},
    kind::KindInfo,
    link::{Input, Link, Links},
    problem::Problem,
    source::TextSpan,
};
use crate::engine::{
    collect,
    node::{Arity, PortSpec},
    suggest,
};
use std::rc::Rc;
use toml::de::{DeTable, DeValue};

/// Words of the other table that a port may be given.
const PICK: [&str; 2] = ["from", "via"];

impl<'s> Links<'s> {
    /// The table, where the port `spec` is given several outputs by it.
    pub fn collected(&self, spec: &PortSpec, item: Item<'s>) -> Option<&'s DeTable<'s>> {
        let table = item.value.as_table().filter(|_| matches!(spec.arity, Arity::Many { .. }))?;
        let named = |key: &str| !PICK.contains(&key) && suggest::nearest(key, PICK).is_none();
        (!table.is_empty() && table.keys().all(|key| named(key.get_ref()))).then_some(table)
    }

    /// The port `spec` of node `at`, fed by all outputs of `table`: by a node of its own that collects them.
    pub fn collect(
        &mut self,
        at: usize,
        spec: &PortSpec,
        item: Item<'s>,
        table: &'s DeTable<'s>,
        problems: &mut Vec<Problem>,
    ) -> Input {
        let nothing = Input { place: item.place, ..Input::default() };
        let who = format!("port `{}`", spec.name);
        if table.len() > collect::MOST {
            let message = format!("{who} takes {} outputs, at most {} are allowed", table.len(), collect::MOST);
            problems.push(Problem::at(item.place, message, "too many"));
            return nothing;
        }
        let before = problems.len();
        let (mut words, mut inputs) = (Vec::new(), Vec::new());
        for (key, value) in table {
            let place = TextSpan::new(item.place.source, value.span());
            let word = &**key.get_ref();
            if !valid_name(word) {
                let place = TextSpan::new(item.place.source, key.span());
                problems.push(
                    Problem::at(place, format!("{who}: `{word}` is no name for an output"), "not a name")
                        .help("letters, digits, `-` and `_`"),
                );
                continue;
            }
            match value.get_ref() {
                DeValue::String(text) => {
                    let from = self.typed(at, spec, text, place, problems);
                    words.push(word.to_owned());
                    inputs.push(Input { from, via: None, place });
                }
                other => {
                    let message = format!("{who}: `{word}` is {}, expected \"node.output\"", what(other));
                    problems.push(Problem::at(place, message, "not a reference"));
                }
            }
        }
        if problems.len() > before || inputs.iter().any(|input| input.from.is_none()) {
            return nothing;
        }
        let node = &self.nodes[at];
        let (name, order, part) = (node.name, node.order, node.part);
        self.nodes.push(Link {
            name,
            of_port: Some(spec.name),
            order,
            part,
            info: Some(Rc::new(KindInfo::new(&collect::kind(spec.ty, words.len())))),
            params: Some(collect::parameters(words)),
            inputs,
            broken: false,
            join_inner: false,
            cross: None,
            transient: None,
            per: Vec::new(),
        });
        Input { from: Some((self.nodes.len() - 1, 0)), via: None, place: item.place }
    }
}
