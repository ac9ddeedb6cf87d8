//! Keys: what a run's result depends on, and nothing else. One walk over the fields feeds a visitor; the visitor that
//! hashes and the one that explains see the same fields, so they cannot drift apart.
//!
//! A key has a fixed part (kind, method, version, formats, parameters, execution identity), hashed once per node, and the
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

/// The visitor that hashes. It gathers the fields first: one call on some hundred bytes costs less than many on few.
pub struct Hash(Vec<u8>);

impl Default for Hash {
    fn default() -> Self {
        Self(Vec::with_capacity(512))
    }
}

impl Hash {
    pub fn finish(self) -> Digest {
        Digest::of(&self.0)
    }
}

impl Visit for Hash {
    fn field(&mut self, path: &str, value: Field) {
        self.0.extend((path.len() as u32).to_le_bytes());
        self.0.extend(path.as_bytes());
        let mut put = |tag: u8, bytes: &[u8]| {
            self.0.push(tag);
            self.0.extend(bytes);
        };
        match value {
            Field::Text(t) => {
                put(0, &(t.len() as u64).to_le_bytes());
                self.0.extend(t.as_bytes());
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

/// The kind's own share of the fixed part.
pub fn kind_fields(spec: &KindSpec, v: &mut impl Visit) {
    v.field("key", Field::Len(KEY));
    v.field("kind", Field::Text(spec.name));
    if !spec.method.is_empty() {
        v.field("method", Field::Text(spec.method));
    }
    v.field("version", Field::Int(spec.version.into()));
    v.field("execution", Field::Text(execution(spec.native)));
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
}

/// The parameters' share of the fixed part. `sources` gives what stands for each source parameter.
pub fn param_fields(params: &Value, sources: &[(String, SourceKey)], v: &mut impl Visit) {
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

/// The fixed part as text, for `why`.
pub fn explain(spec: &KindSpec, params: &Value, sources: &[(String, SourceKey)]) -> Vec<(String, String)> {
    let mut out = Explain::default();
    kind_fields(spec, &mut out);
    param_fields(params, sources, &mut out);
    out.0
}

/// Hash of the kind's share.
pub fn kind(spec: &KindSpec) -> Digest {
    let mut h = Hash::default();
    kind_fields(spec, &mut h);
    h.finish()
}

/// Hash of the fixed part; `kind` is the hash of the kind's share.
pub fn fixed(kind: Digest, params: &Value, sources: &[(String, SourceKey)]) -> Digest {
    let mut h = Hash::default();
    h.field("kind", Field::Digest(kind));
    param_fields(params, sources, &mut h);
    h.finish()
}

/// The key of one run: the fixed part, what came through each port (`None`: absent), and the element's name where the
/// kind asks for it.
pub fn run(fixed: Digest, inputs: &[Option<Digest>], element: Option<&str>) -> Digest {
    Runs::new(fixed).key(inputs, element)
}

/// Keys of many runs of one node.
pub struct Runs {
    hash: Hash,
    /// Bytes of the part that all have.
    fixed: usize,
}

impl Runs {
    pub fn new(fixed: Digest) -> Self {
        let mut hash = Hash::default();
        hash.field("fixed", Field::Digest(fixed));
        let fixed = hash.0.len();
        Self { hash, fixed }
    }

    /// See [`run`].
    pub fn key(&mut self, inputs: &[Option<Digest>], element: Option<&str>) -> Digest {
        self.hash.0.truncate(self.fixed);
        for input in inputs {
            self.hash.field("in", input.map_or(Field::Null, Field::Digest));
        }
        if let Some(name) = element {
            self.hash.field("element", Field::Text(name));
        }
        Digest::of(&self.hash.0)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{
        artifact::{Artifact, DecodeError, Decoder, Encoder},
        node::{Ctx, Node, NodeError, SourcePath, kind as kind_of},
    };
    use schemars::JsonSchema;
    use serde::{Deserialize, Serialize};
    use serde_json::json;
    use std::sync::Arc;

    struct Thing;
    impl Artifact for Thing {
        const TYPE: &'static str = "Thing";
        const FORMAT: u32 = 3;
        fn encode(&self, _: &mut Encoder) {}
        fn decode(_: &Decoder) -> Result<Self, DecodeError> {
            Ok(Self)
        }
    }

    crate::ports! { struct In {
        /// A thing.
        thing: Arc<Thing>,
    } }
    crate::ports! { struct Out {
        /// Another.
        thing: Arc<Thing>,
    } }

    #[derive(Default, Serialize, Deserialize, JsonSchema)]
    #[serde(default, deny_unknown_fields)]
    struct Params {
        factor: f64,
        count: u32,
        names: Vec<String>,
        path: SourcePath,
    }

    struct Golden;
    impl Node for Golden {
        const KIND: &'static str = "golden";
        const VERSION: u32 = 7;
        type Params = Params;
        type In = In;
        type Out = Out;
        fn memory(_: &Params, _: &[u64]) -> u64 {
            0
        }
        fn run(_: &Params, i: In, _: &Ctx) -> Result<Out, NodeError> {
            Ok(Out { thing: i.thing })
        }
    }

    fn key(params: Value, source: &SourceKey) -> Digest {
        let golden = kind_of::<Golden>();
        let params = golden.accept(params).unwrap();
        let spec = golden.spec();
        assert_eq!(source_params(spec), ["path"]);
        let fixed = fixed(kind(spec), params.json(), &[("path".to_owned(), source.clone())]);
        run(fixed, &[Some(Digest::of(b"input")), None], None)
    }

    fn file(bytes: &[u8], extension: &str) -> SourceKey {
        SourceKey::File { hash: Digest::of(bytes), extension: extension.to_owned() }
    }

    /// Keys are the same on every machine and in every release until [`KEY`] changes.
    #[test]
    fn a_key_is_what_it_was() {
        let params = json!({ "factor": 1.5, "count": 3, "names": ["a", "b"], "path": "/x/y.glb" });
        assert_eq!(key(params, &file(b"glb", "glb")).hex(), GOLDEN);
    }
    const GOLDEN: &str = "083207d2fb91eebdd8971d176e747a8d3176c2175bfca6246135ab9be09cb852";

    #[test]
    fn keys_tell_values_apart_and_nothing_else() {
        let f = file(b"glb", "glb");
        let base = key(json!({ "factor": 0.0 }), &f);
        let same =
            [json!({ "factor": -0.0 }), json!({ "count": 0, "factor": 0 }), json!({ "path": "/elsewhere/z.glb" })];
        for params in same {
            assert_eq!(key(params.clone(), &f), base, "{params}");
        }
        let other = [
            json!({ "factor": 1e-300 }),
            json!({ "count": 1 }),
            json!({ "names": [""] }),
            json!({ "names": ["", ""] }),
        ];
        for params in other {
            assert_ne!(key(params.clone(), &f), base, "{params}");
        }
        assert_ne!(key(json!({ "names": ["ab", "c"] }), &f), key(json!({ "names": ["a", "bc"] }), &f));
        for source in [file(b"other", "glb"), file(b"glb", "ply"), SourceKey::Text("builtin:city".to_owned())] {
            assert_ne!(key(json!({}), &source), base);
        }
        // JSON has no NaN: what typed parameters make of it is refused when they are read back.
        assert!(kind_of::<Golden>().accept(json!({ "factor": f64::NAN })).is_err());
    }

    #[test]
    fn the_explanation_has_every_field_that_is_hashed() {
        struct Both(Vec<String>);
        impl Visit for Both {
            fn field(&mut self, path: &str, _: Field) {
                self.0.push(path.to_owned());
            }
        }
        let params = json!({ "factor": 1.5, "names": ["a"], "path": "x.glb" });
        let sources = [("path".to_owned(), file(b"glb", "glb"))];
        let golden = kind_of::<Golden>();
        let mut both = Both(Vec::new());
        kind_fields(golden.spec(), &mut both);
        param_fields(&params, &sources, &mut both);
        let told: Vec<String> = explain(golden.spec(), &params, &sources).into_iter().map(|(path, _)| path).collect();
        assert_eq!(told, both.0);
        for path in [
            "version",
            "execution",
            "input thing",
            "parameter factor",
            "parameter names[0]",
            "parameter path extension",
        ] {
            assert!(told.iter().any(|p| p == path), "{path}");
        }
    }
}
