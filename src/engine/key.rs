//! Keys: what a run's result depends on, and nothing else. One walk over the fields feeds a visitor; the visitor that
//! hashes and the one that explains see the same fields, so they cannot drift apart.
//!
//! A key has a fixed part (kind, version, formats, parameters, execution identity), hashed once per node, and the
//! contents of the inputs. No path, node name, time, thread count or machine enters it. NaN cannot: JSON has none.

use super::{
    hash::Digest,
    node::{Arity, KindSpec},
};
use serde_json::Value;
use std::fmt::Write as _;

/// Version of the key itself.
const KEY: u64 = 1;

/// One field of a key.
#[derive(Clone, Copy, Debug)]
pub enum Field<'a> {
    Text(&'a str),
    Int(i128),
    Float(f64),
    Bool(bool),
    Null,
    /// Length of a list or number of members.
    Len(u64),
    Digest(Digest),
}

/// Receives a key's fields in their fixed order.
pub trait Visit {
    fn field(&mut self, path: &str, value: Field);
}

/// The visitor that hashes.
#[derive(Default)]
pub struct Hash(blake3::Hasher);

impl Hash {
    pub fn finish(self) -> Digest {
        self.0.finalize().into()
    }
}

impl Visit for Hash {
    fn field(&mut self, path: &str, value: Field) {
        self.0.update(&(path.len() as u32).to_le_bytes());
        self.0.update(path.as_bytes());
        let mut put = |tag: u8, bytes: &[u8]| {
            self.0.update(&[tag]);
            self.0.update(bytes);
        };
        match value {
            Field::Text(t) => {
                put(0, &(t.len() as u64).to_le_bytes());
                self.0.update(t.as_bytes());
            }
            Field::Int(v) => put(1, &v.to_le_bytes()),
            // -0.0 + 0.0 is 0.0: the two zeros are one value.
            Field::Float(v) => put(2, &(v + 0.0).to_bits().to_le_bytes()),
            Field::Bool(v) => put(3, &[u8::from(v)]),
            Field::Null => put(4, &[]),
            Field::Len(n) => put(5, &n.to_le_bytes()),
            Field::Digest(d) => put(6, &d.0),
        }
    }
}

/// The visitor that explains: each field as text.
#[derive(Default)]
pub struct Explain(pub Vec<(String, String)>);

impl Visit for Explain {
    fn field(&mut self, path: &str, value: Field) {
        let text = match value {
            Field::Text(t) => t.to_owned(),
            Field::Int(v) => v.to_string(),
            Field::Float(v) => (v + 0.0).to_string(),
            Field::Bool(v) => v.to_string(),
            Field::Null => "none".to_owned(),
            Field::Len(n) => format!("{n} items"),
            Field::Digest(d) => d.hex(),
        };
        self.0.push((path.to_owned(), text));
    }
}

/// A source path as it enters the key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SourceKey {
    /// `builtin:…`, or no path at all.
    Text(String),
    /// Content and lowercase extension of the root file.
    File { hash: Digest, extension: String },
}

/// The names of the parameters that are source paths.
pub fn source_params(spec: &KindSpec) -> Vec<&str> {
    let Some(properties) = spec.params.get("properties").and_then(Value::as_object) else { return Vec::new() };
    let is = |schema: &Value| schema.get("format").and_then(Value::as_str) == Some("source-path");
    properties.iter().filter(|(_, schema)| is(schema)).map(|(name, _)| name.as_str()).collect()
}

/// The fixed part's fields. `sources` gives each source parameter's share.
pub fn fixed_fields(spec: &KindSpec, params: &Value, sources: &[(String, SourceKey)], v: &mut impl Visit) {
    v.field("key", Field::Len(KEY));
    v.field("kind", Field::Text(spec.name));
    v.field("version", Field::Int(spec.version.into()));
    let method = |(name, value): (&str, &str)| params.get(name).and_then(Value::as_str) == Some(value);
    v.field("execution", Field::Text(execution(spec.native || spec.native_when.is_some_and(method))));
    for (side, ports) in [("input", &spec.inputs), ("output", &spec.outputs)] {
        v.field(side, Field::Len(ports.len() as u64));
        for port in ports {
            let shape = match port.arity {
                Arity::One => "",
                Arity::Optional => " or none",
                Arity::Many { .. } => " list",
            };
            let path = format!("{side} {}", port.name);
            v.field(&path, Field::Text(&format!("{} format {}{shape}", port.ty.name, port.ty.format)));
        }
    }
    let mut path = String::from("parameter ");
    let Some(members) = params.as_object() else {
        return param(params, &mut path, v);
    };
    let mut names: Vec<&String> = members.keys().collect();
    names.sort();
    v.field("parameters", Field::Len(names.len() as u64));
    for name in names {
        path.truncate("parameter ".len());
        path.push_str(name);
        match sources.iter().find(|(n, _)| n == name) {
            Some((_, SourceKey::Text(text))) => v.field(&path, Field::Text(text)),
            Some((_, SourceKey::File { hash, extension })) => {
                v.field(&path, Field::Digest(*hash));
                path.push_str(" extension");
                v.field(&path, Field::Text(extension));
            }
            None => param(&members[name], &mut path, v),
        }
    }
}

fn param(value: &Value, path: &mut String, v: &mut impl Visit) {
    let at = path.len();
    match value {
        Value::Null => v.field(path, Field::Null),
        Value::Bool(b) => v.field(path, Field::Bool(*b)),
        Value::String(s) => v.field(path, Field::Text(s)),
        Value::Number(n) => match (n.as_i128(), n.as_f64()) {
            (Some(i), _) => v.field(path, Field::Int(i)),
            (None, Some(f)) => v.field(path, Field::Float(f)),
            (None, None) => v.field(path, Field::Text(&n.to_string())),
        },
        Value::Array(items) => {
            v.field(path, Field::Len(items.len() as u64));
            for (i, item) in items.iter().enumerate() {
                let _ = write!(path, "[{i}]");
                param(item, path, v);
                path.truncate(at);
            }
        }
        Value::Object(members) => {
            v.field(path, Field::Len(members.len() as u64));
            let mut names: Vec<&String> = members.keys().collect();
            names.sort();
            for name in names {
                let _ = write!(path, ".{name}");
                param(&members[name], path, v);
                path.truncate(at);
            }
        }
    }
}

/// Hash of the fixed part.
pub fn fixed(spec: &KindSpec, params: &Value, sources: &[(String, SourceKey)]) -> Digest {
    let mut h = Hash::default();
    fixed_fields(spec, params, sources, &mut h);
    h.finish()
}

/// The key of one run: the fixed part, what came through each port (`None`: absent), and the element's name where the
/// kind asks for it.
pub fn run(fixed: Digest, inputs: &[Option<Digest>], element: Option<&str>) -> Digest {
    let mut h = Hash::default();
    h.field("fixed", Field::Digest(fixed));
    for input in inputs {
        h.field("in", input.map_or(Field::Null, Field::Digest));
    }
    if let Some(name) = element {
        h.field("element", Field::Text(name));
    }
    h.finish()
}

/// The key of a map as a whole. `shape` says how the inputs' axes meet the node's.
pub fn map(fixed: Digest, inputs: &[Option<Digest>], shape: &str) -> Digest {
    let mut h = Hash::default();
    h.field("map", Field::Text(shape));
    h.field("fixed", Field::Digest(fixed));
    for input in inputs {
        h.field("in", input.map_or(Field::Null, Field::Digest));
    }
    h.finish()
}

/// What computes: `cpu`, and for foreign code the target and the CPU's features, since compilers of other languages
/// promise no equal bits.
fn execution(native: bool) -> &'static str {
    static NATIVE: std::sync::OnceLock<String> = std::sync::OnceLock::new();
    if !native {
        return "cpu";
    }
    NATIVE.get_or_init(|| {
        use std::env::consts::{ARCH, OS};
        let environment = if cfg!(target_env = "msvc") {
            "msvc"
        } else if cfg!(target_env = "musl") {
            "musl"
        } else {
            "gnu"
        };
        format!("cpu {ARCH}-{OS}-{environment}{}", cpu_features())
    })
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn cpu_features() -> String {
    macro_rules! detected {
        ($($feature:tt)*) => { [$(($feature, std::arch::is_x86_feature_detected!($feature))),*] };
    }
    let all = detected!("sse3" "ssse3" "sse4.1" "sse4.2" "popcnt" "avx" "f16c" "fma" "bmi1" "bmi2" "avx2" "avx512f");
    all.iter().filter(|(_, on)| *on).map(|(name, _)| format!(" {name}")).collect()
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn cpu_features() -> String {
    String::new()
}
