//! References: what feeds a port, and what a section names, by "node" or "node.output".

use super::{
    draft,
    item::{Item, what},
    link::{Input, Links, Output},
    problem::Problem,
    source::TextSpan,
};
use crate::engine::node::{Arity, PortSpec};
use crate::engine::suggest;
use toml::de::DeValue;

/// References that lead to references, at most: inputs of parts of parts, and their outputs.
const STEPS: u32 = 1024;

impl<'s> Links<'s> {
    /// The port `spec` of node `at`, fed as `item` says.
    pub fn input(&self, at: usize, spec: &PortSpec, item: Item<'s>, problems: &mut Vec<Problem>) -> Input {
        let who = format!("port `{}`", spec.name);
        let mut input = Input { place: item.place, ..Input::default() };
        match item.value {
            DeValue::String(s) => input.from = self.typed(at, spec, s, item.place, problems),
            DeValue::Table(table) => {
                let source = item.place.source;
                let mut from = None;
                for (key, value) in table {
                    let place = TextSpan::new(source, value.span());
                    match (&**key.get_ref(), value.get_ref()) {
                        ("from", DeValue::String(s)) => from = Some((&**s, place)),
                        ("via", DeValue::String(s)) => {
                            input.via = self.find(s, place, &who, problems);
                            if let Some((node, port)) = input.via
                                && let Some(output) = self.output(node, port)
                                && output.ty.name != "Relation"
                            {
                                input.via = None;
                                let message = format!("`via` takes a Relation, `{s}` is a {}", output.ty.name);
                                let help = format!(
                                    "a Relation says which names belong to which; {}",
                                    self.of_type(at, "Relation")
                                );
                                problems.push(Problem::at(place, message, "wrong type").help(help));
                            }
                            if input.via.is_none() {
                                return input;
                            }
                        }
                        (name @ ("from" | "via"), other) => {
                            let message = format!("`{name}` is {}, expected \"node.output\"", what(other));
                            problems.push(Problem::at(place, message, "not a reference"));
                            return input;
                        }
                        (other, _) => {
                            let place = TextSpan::new(source, key.span());
                            let hint = suggest::did_you_mean(other, ["from", "via"]);
                            let help = format!(
                                "{hint}a port's table is {{ from = \"node.output\", via = \"node.relation\" }}"
                            );
                            problems.push(
                                Problem::at(place, format!("unknown key `{other}` in {who}"), "no such key").help(help),
                            );
                            return input;
                        }
                    }
                }
                match from {
                    Some((s, place)) => input.from = self.typed(at, spec, s, place, problems),
                    None => problems.push(
                        Problem::at(item.place, format!("{who} does not say `from`"), "no `from`")
                            .help("{ from = \"node.output\", via = \"node.relation\" }"),
                    ),
                }
                if input.via.is_some() && !matches!(spec.arity, Arity::Many { .. }) {
                    let message = format!("{who} takes one value, `via` picks elements of a list");
                    problems.push(Problem::at(item.place, message, "not a list port"));
                    input.from = None;
                }
            }
            other => {
                let message = format!("{who} is {}, expected \"node.output\"", what(other));
                let help = match other {
                    DeValue::Array(_) => {
                        "a list port takes one list, \"node.output\", or several under names of their own, \
                                          { near = \"node.output\", far = \"node.output\" }"
                            .to_owned()
                    }
                    _ => format!("a port names what feeds it: {} = \"…\", {}", spec.name, self.sources_of(at, spec)),
                };
                problems.push(Problem::at(item.place, message, "not a reference").help(help));
            }
        }
        input
    }

    /// The output `text`, if its type is the port's.
    pub fn typed(
        &self,
        at: usize,
        spec: &PortSpec,
        text: &str,
        place: TextSpan,
        problems: &mut Vec<Problem>,
    ) -> Option<Output> {
        let (node, port) = self.find(text, place, &format!("port `{}`", spec.name), problems)?;
        let output = self.output(node, port)?;
        if output.ty.name == spec.ty.name {
            return Some((node, port));
        }
        let message = format!(
            "port `{}` takes a {}, `{}.{}` is a {}",
            spec.name, spec.ty.name, self.nodes[node].name, output.name, output.ty.name
        );
        problems.push(Problem::at(place, message, format!("a {}", output.ty.name)).help(self.sources_of(at, spec)));
        None
    }

    pub fn output(&self, node: usize, port: u32) -> Option<&PortSpec> {
        self.nodes[node].info.as_ref()?.outputs().get(port as usize)
    }

    /// `node.output`, for messages.
    pub fn output_name(&self, (node, port): Output) -> String {
        let output = self.output(node, port).map_or("?", |o| o.name);
        format!("{}.{output}", self.nodes[node].name)
    }

    pub fn node(&self, name: &str) -> Option<usize> {
        self.nodes[..self.named].binary_search_by(|n| n.name.cmp(name)).ok()
    }

    /// The output that `text`, "node", "node.output" or an input, names at `place`; `who` asks. `None` without a problem where the node's
    /// kind is unknown.
    pub fn find(&self, text: &str, place: TextSpan, who: &str, problems: &mut Vec<Problem>) -> Option<Output> {
        self.follow(text, place, 0, Some((who, problems)))
    }

    /// The same, and nothing is told of what cannot be found.
    pub fn known(&self, text: &str, place: TextSpan) -> Option<Output> {
        self.follow(text, place, 0, None)
    }

    /// `told`: who asks, and to whom it is told where there is no such output.
    fn follow(
        &self,
        text: &str,
        place: TextSpan,
        steps: u32,
        told: Option<(&str, &mut Vec<Problem>)>,
    ) -> Option<Output> {
        let part = &self.draft.parts[self.sources.get(place).part];
        if steps > STEPS {
            let (who, problems) = told?;
            problems.push(Problem::at(place, format!("{who}: `{text}` leads back to itself"), "round and round"));
            return None;
        }
        if let Some(input) = part.inputs.get(text) {
            let Some(item) = input.given.or(input.default) else {
                let (who, problems) = told?;
                let message = format!("{who}: nothing is plugged into the input `{text}`, and it has no default");
                let help = match part.node {
                    "" => "a pipeline with such an input is made to be a part of another".to_owned(),
                    node => {
                        format!("give it in [nodes.{node}]: {text} = \"…\", {}", self.of_type(usize::MAX, input.ty))
                    }
                };
                problems.push(Problem::at(place, message, "nothing there").also(input.key, "declared here").help(help));
                return None;
            };
            return self.follow(item.value.as_str()?, item.place, steps + 1, told);
        }
        let (name, output) = text.split_once('.').map_or((text, None), |(n, o)| (n, Some(o)));
        let full = part.full(name);
        if let Some(host) = full.and_then(|full| self.draft.hosts.get(full)) {
            let outputs = &self.draft.parts[host.part?];
            let item = match output {
                Some(output) => outputs.outputs.get(output).copied(),
                None => outputs.first_output(),
            };
            let Some(item) = item else {
                let (who, problems) = told?;
                let names = || outputs.outputs.keys().copied();
                let (message, help) = match output {
                    Some(output) => (
                        format!("{who}: the pipeline of node `{name}` has no output `{output}`"),
                        format!(
                            "{}its [outputs] are {}",
                            suggest::did_you_mean(output, names()),
                            suggest::list(names())
                        ),
                    ),
                    None => (
                        format!("{who}: the pipeline of node `{name}` has no outputs"),
                        "give it a section [outputs] with lines of name = \"node.output\"".to_owned(),
                    ),
                };
                problems.push(Problem::at(place, message, "no such output").help(help));
                return None;
            };
            return self.follow(item.value.as_str()?, item.place, steps + 1, told);
        }
        let Some(node) = full.and_then(|full| self.node(full)) else {
            let (who, problems) = told?;
            if text.starts_with('{') {
                let help = "a knob holds a value, not a node; write \"node.output\"";
                problems.push(Problem::at(place, format!("{who} refers to a knob"), "not a node").help(help));
            } else {
                let who = format!("{who}: ");
                let hosts = self.draft.hosts.keys().copied();
                let names = part.own(self.names().chain(hosts)).chain(part.inputs.keys().copied());
                problems.push(draft::no_node(name, place, &who, names, problems.len()));
            }
            return None;
        };
        let info = self.nodes[node].info.as_ref()?;
        let Some(output) = output else {
            if info.outputs().is_empty() {
                let (who, problems) = told?;
                let message = format!("{who}: node `{name}` has no output");
                problems.push(Problem::at(place, message, "nothing comes out"));
            }
            return (!info.outputs().is_empty()).then_some((node, 0));
        };
        if let Some(port) = info.outputs().iter().position(|o| o.name == output) {
            return Some((node, port as u32));
        }
        let (who, problems) = told?;
        let names = || info.outputs().iter().map(|o| o.name);
        let help = format!(
            "{}`{name}` is a `{}` and has the outputs {}",
            suggest::did_you_mean(output, names()),
            info.kind.spec().title(),
            suggest::list(names())
        );
        problems.push(
            Problem::at(place, format!("{who}: node `{name}` has no output `{output}`"), "no such output").help(help),
        );
        None
    }

    /// Which outputs could feed a port, for messages.
    pub fn sources_of(&self, at: usize, spec: &PortSpec) -> String {
        self.of_type(at, spec.ty.name)
    }

    /// The outputs of type `ty` of nodes other than `at`, for messages.
    pub fn of_type(&self, at: usize, ty: &str) -> String {
        let mut found = Vec::new();
        // What the asking text can name: nodes of its own part, and outputs of the parts in it.
        let part = self.nodes.get(at).map_or(0, |node| node.part);
        let own = |name: &'s str| self.draft.parts[part].own(std::iter::once(name)).next();
        for (name, host) in &self.draft.hosts {
            let Some((name, inner)) = own(name).zip(host.part) else { continue };
            for (output, item) in &self.draft.parts[inner].outputs {
                let from = item.value.as_str().and_then(|text| self.known(text, item.place));
                let fits = from.and_then(|(node, port)| self.output(node, port)).is_some_and(|o| o.ty.name == ty);
                found.extend(fits.then(|| format!("{name}.{output}")));
            }
        }
        let nodes = &self.nodes[..self.named];
        for node in nodes.iter().enumerate().filter(|(i, node)| *i != at && node.part == part).map(|(_, n)| n) {
            let Some(name) = own(node.name) else { continue };
            let outputs = node.info.as_ref().map_or(&[][..], |i| i.outputs());
            found.extend(outputs.iter().filter(|o| o.ty.name == ty).map(|o| format!("{name}.{}", o.name)));
            if found.len() > 12 {
                break;
            }
        }
        if found.is_empty() {
            let makers = self.registry.iter().filter(|k| k.spec().outputs.iter().any(|o| o.ty.name == ty));
            let makers: Vec<String> = makers.map(|k| k.spec().title()).collect();
            let makers = suggest::list(makers.iter().map(String::as_str));
            return format!("no node of this pipeline makes a {ty}; kinds that do: {makers}");
        }
        format!("a {ty} comes from {}", suggest::list(found.iter().map(String::as_str)))
    }
}
