//! `farfield nodes`: the reference of the kinds, made of the doc comments of their ports and parameters.

use super::{Done, Exit, print, schema};
use crate::engine::{
    node::{Arity, KindSpec, PortSpec, Registry},
    pipeline::{self, Ty},
};
use serde_json::Value;

/// Shows the node kinds: what they do, their ports and parameters
#[derive(clap::Args)]
pub struct Args {
    /// One kind, in full
    kind: Option<String>,
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
    match registry.get(wanted) {
        Some(kind) => print(&page(kind.spec(), Form::Terminal)),
        None => {
            let names = || registry.iter().map(|k| k.spec().name);
            let hint = pipeline::did_you_mean(wanted, names());
            let all = pipeline::name_list(names());
            Err(Exit::say(2, format!("no kind `{wanted}`; {hint}the kinds are {all}")))
        }
    }
}

/// A kind's own documentation.
pub fn about(spec: &KindSpec) -> &str {
    spec.params.get("description").and_then(Value::as_str).unwrap_or_default()
}

/// The first sentence of a text.
fn first_sentence(text: &str) -> String {
    let paragraph = text.split("\n\n").next().unwrap_or_default().replace('\n', " ");
    let end = paragraph.find(". ").map_or(paragraph.len(), |at| at + 1);
    paragraph[..end].trim().to_owned()
}

/// Every kind with its first sentence.
fn list(registry: &Registry) -> String {
    let width = registry.iter().map(|k| k.spec().name.len()).max().unwrap_or(0);
    let line = |spec: &KindSpec| {
        format!("{}\n", wrap(&format!("{:width$}  ", spec.name), &first_sentence(about(spec)), width + 2))
    };
    let lines: String = registry.iter().map(|k| line(k.spec())).collect();
    lines + "\n`farfield nodes KIND` shows one in full.\n"
}

/// All kinds, as a page.
fn markdown(registry: &Registry) -> String {
    let mut out = String::from(
        "# Node kinds\n\nMade by `farfield nodes --markdown` from the doc comments. Ports are fed by `\"node\"` or `\"node.output\"`; \
         parameters stand beside them.\n",
    );
    for kind in registry.iter() {
        out += &format!("\n## {}\n\n{}", kind.spec().name, page(kind.spec(), Form::Markdown));
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
        Form::Terminal => format!("{} (version {})\n\n{}\n", spec.name, spec.version, wrap("", &flow(about(spec)), 0)),
        Form::Markdown => format!("{}\n", flow(about(spec))),
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
        (Arity::Many { may_be_empty: true }, _) => format!("list of {}, may be empty", port.ty.name),
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
            assert!(text.contains(&format!("## {}", spec.name)));
            for port in spec.inputs.iter().chain(&spec.outputs) {
                assert!(text.contains(&format!("| `{}` |", port.name)), "{} {}", spec.name, port.name);
            }
            for name in pipeline::parameters(&spec.params).0.keys() {
                assert!(text.contains(&format!("| `{name}` |")), "{} {name}", spec.name);
            }
        }
    }
}
