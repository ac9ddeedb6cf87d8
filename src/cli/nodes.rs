//! `farfield nodes`: the reference of the kinds, made of the doc comments of their ports and parameters.

use super::{Done, Exit, print, schema};
use crate::engine::{
    node::{Arity, KindSpec, PortSpec},
    pipeline::{self, Ty},
    registry::{About, Registry, Unknown},
};
use serde_json::Value;

/// Shows the node kinds: what they do, their ports and parameters
#[derive(clap::Args)]
pub struct Args {
    /// One kind, in full; of a kind with several methods, what these are
    kind: Option<String>,
    /// One method of the kind, in full
    method: Option<String>,
    /// The reference page of all kinds, as Markdown
    #[arg(long, conflicts_with_all = ["kind", "schema"])]
    markdown: bool,
    /// The JSON schema of pipeline files, for editors
    #[arg(long, conflicts_with = "kind")]
    schema: bool,
}

pub fn run(args: &Args, registry: &Registry) -> Done {
    if args.schema {
        return print(&format!("{:#}\n", schema::of(registry)));
    }
    if args.markdown {
        return print(&markdown(registry));
    }
    let Some(wanted) = &args.kind else { return print(&list(registry)) };
    match registry.find(wanted, args.method.as_deref()) {
        Ok(kind) => print(&(page(kind.spec(), Form::Terminal) + &planned(registry, wanted))),
        Err(unknown) if unknown.about == About::NoMethod => print(&methods(registry, wanted)),
        Err(Unknown { message, help, .. }) => Err(Exit::say(2, format!("{message}; {help}"))),
    }
}

/// Every kind and method with its first sentence.
fn list(registry: &Registry) -> String {
    let lines = lines(&registry.iter().map(|k| k.spec()).collect::<Vec<_>>());
    lines + "\n`farfield nodes KIND`, or `farfield nodes KIND METHOD`, shows one in full.\n"
}

/// The methods of a kind that has several.
fn methods(registry: &Registry, kind: &str) -> String {
    let lines = lines(&registry.methods(kind).map(|k| k.spec()).collect::<Vec<_>>());
    let planned = planned(registry, kind);
    format!(
        "{lines}{planned}\n`farfield nodes {kind} METHOD` shows one in full. A node writes kind = \"{kind}\", method = \"…\".\n"
    )
}

/// A line per kind and method.
fn lines(specs: &[&KindSpec]) -> String {
    let width = specs.iter().map(|s| s.title().len()).max().unwrap_or(0);
    let line =
        |spec: &&KindSpec| format!("{}\n", wrap(&format!("{:width$}  ", spec.title()), &spec.summary(), width + 2));
    specs.iter().map(line).collect()
}

/// The methods of a kind that are not built yet.
fn planned(registry: &Registry, kind: &str) -> String {
    match registry.planned(kind) {
        [] => String::new(),
        methods => format!("\nNot built yet: {}\n", pipeline::name_list(methods.iter().copied())),
    }
}

/// All kinds, as a page.
fn markdown(registry: &Registry) -> String {
    let mut out = String::from(
        "# Node kinds\n\nMade by `farfield nodes --markdown` from the doc comments. Ports are fed by `\"node\"` or `\"node.output\"`; \
         parameters stand beside them.\n",
    );
    for kind in registry.iter() {
        out += &format!("\n## {}\n\n{}", kind.spec().title(), page(kind.spec(), Form::Markdown));
    }
    out
}

#[derive(Clone, Copy, PartialEq)]
enum Form {
    Terminal,
    Markdown,
}

/// One kind: documentation, ports, parameters.
fn page(spec: &KindSpec, form: Form) -> String {
    let mut out = match form {
        Form::Terminal => {
            format!("{} (version {})\n\n{}\n", spec.title(), spec.version, wrap("", &flow(spec.about()), 0))
        }
        Form::Markdown => format!("{}\n", flow(spec.about())),
    };
    let port = |port: &PortSpec, input: bool| (port.name.to_owned(), port_type(port, input), flow(port.doc));
    let inputs: Vec<_> = spec.inputs.iter().map(|p| port(p, true)).collect();
    let outputs: Vec<_> = spec.outputs.iter().map(|p| port(p, false)).collect();
    let (types, required) = pipeline::parameters(&spec.params);
    // In the order in which the code declares them, which goes from the important to the rare.
    let properties = spec.params.get("properties").and_then(Value::as_object);
    let params: Vec<_> = properties
        .into_iter()
        .flatten()
        .map(|(name, schema)| {
            let mut ty = types.get(name).map(Ty::describe).unwrap_or_default();
            if required.contains(name) {
                ty += ", required";
            } else if let Some(default) = schema.get("default").filter(|d| !d.is_null() && d.as_str() != Some("")) {
                ty += &format!(", default {default}");
            }
            let doc = schema.get("description").and_then(Value::as_str).unwrap_or_default();
            (name.clone(), ty, flow(doc))
        })
        .collect();
    for (title, rows) in [("Inputs", inputs), ("Outputs", outputs), ("Parameters", params)] {
        if !rows.is_empty() {
            out += &section(title, &rows, form);
        }
    }
    if form == Form::Terminal && !spec.measures.is_empty() {
        out += &section("Measures, for [require] and --require", &measures(spec), form);
    }
    out
}

/// The numbers of the kind's certificate: path, unit, meaning.
fn measures(spec: &KindSpec) -> Vec<(String, String, String)> {
    let unit = |unit: &str| if unit.is_empty() { "a number".to_owned() } else { unit.to_owned() };
    spec.measures.iter().map(|m| (m.path.clone(), unit(&m.unit), m.about.clone())).collect()
}

fn port_type(port: &PortSpec, input: bool) -> String {
    match (port.arity, input) {
        (Arity::One, _) => port.ty.name.to_owned(),
        (Arity::Optional, _) => format!("{}, may be left out", port.ty.name),
        (Arity::Many { may_be_absent: true, .. }, _) => format!("list of {}, may be left out", port.ty.name),
        (Arity::Many { may_be_empty: true, .. }, _) => format!("list of {}, may be empty", port.ty.name),
        (Arity::Many { .. }, true) => format!("list of {}, at least one", port.ty.name),
        (Arity::Many { .. }, false) => format!("list of {}", port.ty.name),
    }
}

fn section(title: &str, rows: &[(String, String, String)], form: Form) -> String {
    let cell = |s: &str| s.replace('|', "\\|").replace('\n', " ");
    match form {
        Form::Terminal => {
            let rows = rows.iter().map(|(name, ty, doc)| format!("  {name}: {ty}\n{}\n", wrap("      ", doc, 6)));
            format!("\n{title}\n{}", rows.collect::<String>())
        }
        Form::Markdown => {
            let rows = rows.iter().map(|(name, ty, doc)| format!("| `{name}` | {} | {} |\n", cell(ty), cell(doc)));
            format!("\n| {title} | | |\n|---|---|---|\n{}", rows.collect::<String>())
        }
    }
}

/// Lines joined to paragraphs.
fn flow(text: &str) -> String {
    let paragraphs = text.split("\n\n").map(|p| p.split_whitespace().collect::<Vec<_>>().join(" "));
    paragraphs.collect::<Vec<_>>().join("\n\n")
}

/// `text` in lines of at most 100 columns, the first after `head`, the others indented.
fn wrap(head: &str, text: &str, indent: usize) -> String {
    let mut out = head.to_owned();
    let mut column = head.chars().count();
    for (number, paragraph) in text.split("\n\n").enumerate() {
        if number > 0 {
            out += &format!("\n\n{}", " ".repeat(indent));
            column = indent;
        }
        for word in paragraph.split_whitespace() {
            let width = word.chars().count();
            if column > indent && column + 1 + width > 100 {
                out += &format!("\n{}", " ".repeat(indent));
                column = indent;
            } else if column > indent && !out.ends_with(' ') {
                out.push(' ');
                column += 1;
            }
            out += word;
            column += width;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_keeps_words_and_width() {
        let text = "lorem ipsum dolor sit amet ".repeat(12);
        let wrapped = wrap("name  ", &text, 6);
        assert!(wrapped.lines().all(|l| l.chars().count() <= 100), "{wrapped}");
        let words = |s: &str| s.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&wrapped)[1..], words(&text));
    }

    #[test]
    fn the_reference_names_every_port_and_parameter() {
        let registry = crate::nodes::registry();
        let text = markdown(&registry);
        for kind in registry.iter() {
            let spec = kind.spec();
            assert!(text.contains(&format!("## {}\n", spec.title())));
            for port in spec.inputs.iter().chain(&spec.outputs) {
                assert!(text.contains(&format!("| `{}` |", port.name)), "{} {}", spec.title(), port.name);
            }
            for name in pipeline::parameters(&spec.params).0.keys() {
                assert!(text.contains(&format!("| `{name}` |")), "{} {name}", spec.title());
            }
        }
    }

    #[test]
    fn a_kind_with_methods_lists_them() {
        let registry = crate::nodes::registry();
        let text = methods(&registry, "collapse");
        assert!(
            text.starts_with("collapse quadric            Simplifies every mesh")
                && text.contains("\ncollapse voxel-cover        Contracts the"),
            "{text}"
        );
        assert!(text.contains("\ncollapse voxel-quadric      Simplifies"), "{text}");
        assert!(text.contains("\ncollapse silhouette-weight"), "{text}");
        assert!(!text.contains("\npeel") && list(&registry).contains("\npeel solid"), "{text}");
    }
}
