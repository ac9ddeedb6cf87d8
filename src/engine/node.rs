//! Node kinds: the typed trait that a kind implements, and the object-safe form in which the engine holds it.
//!
//! Adding a kind, or a method of one, means one type with [`Node`] and its two lines in `nodes/mod.rs`. Ports are declared with [`ports!`](crate::ports), which
//! keeps their doc comments as data; a kind's own documentation is the doc comment of its `Params`.

use super::{
    artifact::{self, Artifact, DecodeError},
    types::{self, Ty},
};
use crate::{array::Bytes, math::Stop};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;
use std::{any::Any, collections::BTreeMap, marker::PhantomData, path::Path, sync::Arc};

/// A value in memory whose type the engine does not know.
pub type Data = Arc<dyn Any + Send + Sync>;

/// A type that flows on edges, as data.
#[derive(Clone, Copy)]
pub struct TypeInfo {
    pub name: &'static str,
    pub format: u32,
    pub encode: fn(&Data) -> Vec<u8>,
    pub decode: fn(Bytes) -> Result<Data, DecodeError>,
}

impl TypeInfo {
    pub fn of<A: Artifact>() -> Self {
        Self {
            name: A::TYPE,
            format: A::FORMAT,
            encode: |data| artifact::to_bytes(data.downcast_ref::<A>().expect("ports are checked in the plan")),
            decode: |bytes| Ok(Arc::new(artifact::from_bytes::<A>(bytes)?)),
        }
    }
}

/// How many values a port carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arity {
    One,
    /// An input that may be left out.
    Optional,
    /// A list; as an output it makes an axis, as an input it gathers.
    Many {
        may_be_empty: bool,
        /// An input that may be left out.
        may_be_absent: bool,
    },
}

impl Arity {
    /// Whether an input may be left out.
    pub fn may_be_absent(self) -> bool {
        matches!(self, Self::Optional | Self::Many { may_be_absent: true, .. })
    }
}

/// A port, as data.
#[derive(Clone)]
pub struct PortSpec {
    pub name: &'static str,
    /// Its doc comment.
    pub doc: &'static str,
    pub ty: TypeInfo,
    pub arity: Arity,
}

/// A list of named values, sorted by name, names unique. `EMPTY` says whether it may be empty.
pub struct List<A, const EMPTY: bool = false>(pub Vec<(String, Arc<A>)>);

/// Values handed to or taken from a kind through one port.
#[derive(Clone)]
pub enum Slot {
    One(Data),
    /// An optional input that is absent.
    Absent,
    Many(Vec<(String, Data)>),
}

/// The type of a field in a [`ports!`](crate::ports) struct: `Arc<A>`, `List<A>`, or, for inputs only, an `Option` of one of them.
pub trait Port: Sized {
    const ARITY: Arity;
    fn type_info() -> TypeInfo;
    fn from_slot(slot: Slot) -> Self;
    fn into_slot(self) -> Slot;
}

fn downcast<A: Artifact>(data: Data) -> Arc<A> {
    data.downcast().expect("ports are checked in the plan")
}

impl<A: Artifact> Port for Arc<A> {
    const ARITY: Arity = Arity::One;
    fn type_info() -> TypeInfo {
        TypeInfo::of::<A>()
    }
    fn from_slot(slot: Slot) -> Self {
        match slot {
            Slot::One(data) => downcast(data),
            _ => unreachable!("arity is checked in the plan"),
        }
    }
    fn into_slot(self) -> Slot {
        Slot::One(self)
    }
}

impl<A: Artifact> Port for Option<Arc<A>> {
    const ARITY: Arity = Arity::Optional;
    fn type_info() -> TypeInfo {
        TypeInfo::of::<A>()
    }
    fn from_slot(slot: Slot) -> Self {
        match slot {
            Slot::One(data) => Some(downcast(data)),
            _ => None,
        }
    }
    fn into_slot(self) -> Slot {
        self.map_or(Slot::Absent, |a| Slot::One(a))
    }
}

impl<A: Artifact, const EMPTY: bool> Port for List<A, EMPTY> {
    const ARITY: Arity = Arity::Many { may_be_empty: EMPTY, may_be_absent: false };
    fn type_info() -> TypeInfo {
        TypeInfo::of::<A>()
    }
    fn from_slot(slot: Slot) -> Self {
        match slot {
            Slot::Many(items) => Self(items.into_iter().map(|(n, d)| (n, downcast(d))).collect()),
            _ => unreachable!("arity is checked in the plan"),
        }
    }
    fn into_slot(self) -> Slot {
        Slot::Many(self.0.into_iter().map(|(n, a)| (n, a as Data)).collect())
    }
}

impl<A: Artifact, const EMPTY: bool> Port for Option<List<A, EMPTY>> {
    const ARITY: Arity = Arity::Many { may_be_empty: EMPTY, may_be_absent: true };
    fn type_info() -> TypeInfo {
        TypeInfo::of::<A>()
    }
    fn from_slot(slot: Slot) -> Self {
        match slot {
            Slot::Absent => None,
            slot => Some(List::from_slot(slot)),
        }
    }
    fn into_slot(self) -> Slot {
        self.map_or(Slot::Absent, Port::into_slot)
    }
}

/// A struct of ports; implemented by [`ports!`](crate::ports).
pub trait Ports: Sized {
    fn specs() -> Vec<PortSpec>;
    /// One slot per port, in the order of `specs`.
    fn from_slots(slots: Vec<Slot>) -> Self;
    fn into_slots(self) -> Vec<Slot>;
}

/// Declares a struct of ports whose fields' doc comments become data.
#[macro_export]
macro_rules! ports {
    ($(#[doc = $sdoc:literal])* $vis:vis struct $name:ident { $($(#[doc = $doc:literal])+ $field:ident : $ty:ty),* $(,)? }) => {
        $(#[doc = $sdoc])*
        $vis struct $name { $($(#[doc = $doc])+ pub $field: $ty),* }
        impl $crate::engine::node::Ports for $name {
            fn specs() -> Vec<$crate::engine::node::PortSpec> {
                vec![$($crate::engine::node::PortSpec {
                    name: stringify!($field),
                    doc: concat!($($doc, "\n"),+).trim_ascii(),
                    ty: <$ty as $crate::engine::node::Port>::type_info(),
                    arity: <$ty as $crate::engine::node::Port>::ARITY,
                }),*]
            }
            #[expect(clippy::allow_attributes, reason = "a struct without ports uses none of these")]
            #[allow(unused_mut, unused_variables)]
            fn from_slots(slots: Vec<$crate::engine::node::Slot>) -> Self {
                let mut slots = slots.into_iter();
                Self { $($field: $crate::engine::node::Port::from_slot(slots.next().expect("one slot per port"))),* }
            }
            fn into_slots(self) -> Vec<$crate::engine::node::Slot> {
                vec![$($crate::engine::node::Port::into_slot(self.$field)),*]
            }
        }
    };
}

/// Why a run gave no result.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// A message for the user: what was expected, what was found, what to do.
    #[error("{0}")]
    Failed(String),
    #[error(transparent)]
    Stopped(#[from] crate::math::Stopped),
}

impl NodeError {
    /// Any error as a message, with its causes.
    pub fn from_error(e: &dyn std::error::Error) -> Self {
        let mut text = e.to_string();
        let mut cause = e.source();
        while let Some(c) = cause {
            text = format!("{text}: {c}");
            cause = c.source();
        }
        Self::Failed(text)
    }
}

/// The one door through which kinds read the outside world. What passes is recorded by name and content hash,
/// absent files too.
pub trait Door: Sync {
    /// The file's bytes; `Ok(None)` where there is no such file.
    fn read(&self, path: &Path) -> Result<Option<Bytes>, NodeError>;
}

/// Something to compute on, whose type the engine does not know.
pub type Device = dyn Any + Send + Sync;

/// What a run may use besides its inputs.
pub struct Ctx<'a> {
    pub stop: &'a Stop,
    pub door: &'a dyn Door,
    /// The element's name, where the kind's `USES_NAME` is set and the node is mapped.
    pub element: Option<&'a str>,
    /// What the program computes on, where it says so; kinds that can use it know its type. It changes no result.
    pub device: Option<&'a Device>,
    /// Bytes that all runs may take together, as the user allows: what a file may make a kind allocate stays below it.
    pub memory: u64,
    /// Receives what the user should know although the run succeeds; stored with the result, repeated on a hit.
    pub warn: &'a (dyn Fn(String) + Sync),
    /// Is told how many of how many steps of the run are done, from any thread. What a step is, is the kind's matter.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
}

/// A path parameter that names a file of the outside world: not part of the key, resolved against the
/// folder of the file that gives it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SourcePath(pub String);

impl JsonSchema for SourcePath {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "SourcePath".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "format": "source-path" })
    }
}

/// A number in a kind's certificate, of which a pipeline can require something.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Measure {
    /// Into the certificate's JSON, members separated by dots: `crack_px.total`.
    pub path: String,
    /// What it means, in one line.
    pub about: String,
    /// Such as `px`; empty for ratios and counts.
    pub unit: String,
    /// The name of the picture that shows it: an element of one of the kind's lists of files.
    pub picture: Option<String>,
}

impl Measure {
    /// One that no picture shows.
    pub fn new(path: &str, about: &str, unit: &str) -> Self {
        Self { path: path.to_owned(), about: about.to_owned(), unit: unit.to_owned(), picture: None }
    }
}

/// The beginning of a source file, for [`Node::check_source`].
#[derive(Clone, Copy, Debug)]
pub struct Head<'a> {
    pub bytes: &'a [u8],
    /// Whether these bytes are the whole file.
    pub whole: bool,
}

/// A node kind, or one method of a kind. `run` is a pure function of parameters, inputs and what it reads through the door.
pub trait Node: Send + Sync + 'static {
    const KIND: &'static str;
    /// Which of the kind's methods this is. Kind and method together name the type. Empty: the kind has one method and no name for it.
    const METHOD: &'static str = "";
    /// Increased whenever the same inputs give other bytes.
    const VERSION: u32;
    /// True where `run` calls C, C++ or other code whose results may depend on target and CPU.
    const NATIVE: bool = false;
    /// True where the element's name changes the result; it then enters the key.
    const USES_NAME: bool = false;
    /// Typed parameters; its doc comment documents the kind, its fields' comments the parameters.
    /// `#[serde(default, deny_unknown_fields)]`; floats are f64.
    type Params: Serialize + DeserializeOwned + JsonSchema + Send + Sync + 'static;
    type In: Ports;
    type Out: Ports;
    /// Working memory in bytes, besides inputs and outputs, from the inputs' stored sizes (bytes, one per port).
    fn memory(params: &Self::Params, sizes: &[u64]) -> u64;
    /// What type and schema cannot say, such as combinations, checked before anything runs. `Err((parameter, message))`. Ranges of
    /// numbers stand in the schema (`#[schemars(range(…))]`, with the unit as `extend("x-unit" = "px")`) and are checked before.
    fn check(_params: &Self::Params) -> Result<(), (&'static str, String)> {
        Ok(())
    }
    /// What is allowed but can hardly be meant, for a warning before anything runs: parameter and message.
    fn doubts(_params: &Self::Params) -> Vec<(&'static str, String)> {
        Vec::new()
    }
    /// Whether the file that source parameter `param` names can be what the kind reads, judged by its beginning and
    /// before anything runs. The error says what it is and what is expected.
    fn check_source(_param: &str, _path: &Path, _head: Head) -> Result<(), String> {
        Ok(())
    }
    /// The numbers in the output `certificate`, for kinds that have one. Empty: not known, and any path may be required.
    fn measures() -> Vec<Measure> {
        Vec::new()
    }
    fn run(params: &Self::Params, inputs: Self::In, ctx: &Ctx) -> Result<Self::Out, NodeError>;
}

/// A kind, as data.
#[derive(Clone)]
pub struct KindSpec {
    pub name: &'static str,
    /// Empty where the kind has no methods.
    pub method: &'static str,
    pub version: u32,
    pub native: bool,
    pub uses_name: bool,
    pub inputs: Vec<PortSpec>,
    pub outputs: Vec<PortSpec>,
    /// JSON schema of the parameters (an object schema; `description` documents the kind).
    pub params: Value,
    /// See [`Node::measures`].
    pub measures: Vec<Measure>,
}

impl KindSpec {
    /// `collapse quadric`: the kind, and its method where it has one.
    pub fn title(&self) -> String {
        if self.method.is_empty() { self.name.to_owned() } else { format!("{} {}", self.name, self.method) }
    }

    /// "kind `load-scene`" or "method `quadric` of `collapse`", for messages.
    pub fn phrase(&self) -> String {
        match self.method {
            "" => format!("kind `{}`", self.name),
            method => format!("method `{method}` of `{}`", self.name),
        }
    }

    /// The documentation: the doc comment of the parameters' type.
    pub fn about(&self) -> &str {
        self.params.get("description").and_then(Value::as_str).unwrap_or_default()
    }

    /// The first sentence of the documentation, in one line.
    pub fn summary(&self) -> String {
        let paragraph = self.about().split("\n\n").next().unwrap_or_default().replace('\n', " ");
        let end = paragraph.find(". ").map_or(paragraph.len(), |at| at + 1);
        paragraph[..end].trim().to_owned()
    }
}

/// Why parameters are none of a kind's.
#[derive(Debug, thiserror::Error)]
pub enum ParamError {
    /// They do not fit the type.
    #[error(transparent)]
    Type(#[from] serde_json::Error),
    /// They fit the type, but a number is out of its range or [`Node::check`] refuses them.
    #[error("`{param}`: {message}")]
    Refused { param: String, message: String },
}

/// Parameters that a kind has accepted: parsed once, when the plan is made.
#[derive(Clone)]
pub struct Parameters {
    json: Arc<Value>,
    typed: Arc<dyn Any + Send + Sync>,
}

impl Parameters {
    pub(super) fn new(json: Value, typed: Arc<dyn Any + Send + Sync>) -> Self {
        Self { json: Arc::new(json), typed }
    }

    pub(super) fn typed<T: Any>(&self) -> Option<&T> {
        self.typed.downcast_ref()
    }

    /// Re-serialised from the type: defaults filled in, fields in the type's order.
    pub fn json(&self) -> &Value {
        &self.json
    }

    /// One parameter's value.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.json.get(name)
    }
}

/// The object-safe form of [`Node`]. Its methods take parameters that the same kind has accepted.
pub trait Kind: Send + Sync {
    fn spec(&self) -> &KindSpec;
    /// Reads and checks parameters.
    fn accept(&self, params: Value) -> Result<Parameters, ParamError>;
    fn doubts(&self, params: &Parameters) -> Vec<(&'static str, String)>;
    fn check_source(&self, param: &str, path: &Path, head: Head) -> Result<(), String>;
    fn memory(&self, params: &Parameters, sizes: &[u64]) -> u64;
    fn run(&self, params: &Parameters, inputs: Vec<Slot>, ctx: &Ctx) -> Result<Vec<Slot>, NodeError>;
}

struct Erased<N> {
    spec: KindSpec,
    /// The parameters' types.
    types: BTreeMap<String, Ty>,
    node: PhantomData<fn() -> N>,
}

/// The object-safe form of kind `N`.
pub fn kind<N: Node>() -> Arc<dyn Kind> {
    let spec = KindSpec {
        name: N::KIND,
        method: N::METHOD,
        version: N::VERSION,
        native: N::NATIVE,
        uses_name: N::USES_NAME,
        inputs: N::In::specs(),
        outputs: N::Out::specs(),
        params: schemars::schema_for!(N::Params).to_value(),
        measures: N::measures(),
    };
    let (types, _) = types::parameters(&spec.params);
    Arc::new(Erased::<N> { spec, types, node: PhantomData })
}

impl<N: Node> Erased<N> {
    fn typed(params: &Parameters) -> &N::Params {
        params.typed().expect("a plan's parameters are those of its node's kind")
    }
}

impl<N: Node> Kind for Erased<N> {
    fn spec(&self) -> &KindSpec {
        &self.spec
    }
    fn accept(&self, params: Value) -> Result<Parameters, ParamError> {
        let typed: N::Params = serde_json::from_value(params)?;
        let json = serde_json::to_value(&typed)?;
        for (name, ty) in &self.types {
            if let Some(message) = json.get(name).and_then(|value| ty.out_of_range(value)) {
                return Err(ParamError::Refused { param: name.clone(), message });
            }
        }
        N::check(&typed).map_err(|(param, message)| ParamError::Refused { param: param.to_owned(), message })?;
        Ok(Parameters::new(json, Arc::new(typed)))
    }
    fn doubts(&self, params: &Parameters) -> Vec<(&'static str, String)> {
        N::doubts(Self::typed(params))
    }
    fn check_source(&self, param: &str, path: &Path, head: Head) -> Result<(), String> {
        N::check_source(param, path, head)
    }
    fn memory(&self, params: &Parameters, sizes: &[u64]) -> u64 {
        N::memory(Self::typed(params), sizes)
    }
    fn run(&self, params: &Parameters, inputs: Vec<Slot>, ctx: &Ctx) -> Result<Vec<Slot>, NodeError> {
        Ok(N::run(Self::typed(params), N::In::from_slots(inputs), ctx)?.into_slots())
    }
}
