//! The plan: a checked pipeline, ready to run. Everything in it has passed validation: ports exist and agree in type
//! and arity, parameters are typed, there is no cycle, nodes come after what they read.

pub use super::file::{Bundle, File};
use super::{
    artifact::{Artifact, DecodeError, Decoder, Encoder},
    node::{Kind, Parameters},
};
use serde_json::{Map, Value};
use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

/// A node's number in [`Plan::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub u32);

/// Output port `port` of node `node`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OutputRef {
    pub node: NodeId,
    pub port: u32,
}

/// An axis is named by the list output that made it.
pub type Axis = OutputRef;

/// A checked pipeline.
#[derive(Clone, Default)]
pub struct Plan {
    /// `[pipeline] name`: also the folder below `out/`.
    pub name: String,
    /// `[pipeline] about`, of the file or of the nearest base that has one.
    pub about: String,
    /// The pipeline file, as given.
    pub file: PathBuf,
    /// In an order in which every node follows what it reads.
    pub nodes: Vec<PlanNode>,
    /// What `[files]` publishes, in the order of the file.
    pub files: Vec<Publish>,
    /// What `[require]` demands.
    pub require: Vec<Requirement>,
    /// The files that the pipeline's own text was read from: `file` and its bases.
    pub texts: Vec<PathBuf>,
    /// Names of the rows of `[batch]`; empty where it is baked once.
    pub rows: Vec<String>,
    /// What the row of `[batch]` that it is gives: knobs, and parameters as `node.param`.
    pub given: Vec<(String, Value)>,
    /// The knobs' values, as written.
    pub knobs: Map<String, Value>,
    /// The scenes and other files that its nodes are given, each with its folder's name: `town/town.glb`. In the order
    /// of the nodes, each once.
    pub sources: Vec<String>,
    /// What is allowed but can hardly be meant, for the user: place and text.
    pub doubts: Vec<String>,
}

#[derive(Clone)]
pub struct PlanNode {
    /// Unique; `part/node` inside a sub-pipeline.
    pub name: String,
    pub kind: Arc<dyn Kind>,
    /// Parsed; source paths are absolute.
    pub params: Parameters,
    /// One entry per input port of the kind, in its order.
    pub inputs: Vec<PlanInput>,
    /// The axes over which the node is mapped, in a fixed order; empty: it runs once.
    /// A list output's axes are these followed by its own.
    pub axes: Vec<Axis>,
    /// Elements missing on one side of a join are dropped instead of being an error.
    pub join_inner: bool,
    /// Its outputs are cheaper to make again than to keep: of their bytes the cache takes only the hashes. Changes no key.
    pub transient: bool,
}

#[derive(Clone, Debug, Default)]
pub struct PlanInput {
    /// `None`: an optional port that is absent.
    pub from: Option<OutputRef>,
    /// The axes of `from`, in its order.
    pub axes: Vec<Axis>,
    /// A `Relation` output: of the list `from` only the elements related to this node's element are gathered.
    pub via: Option<OutputRef>,
    /// For a list port: which of `axes` are gathered (all but those in the node's own `axes`).
    pub gathered: Vec<Axis>,
}

/// One entry of `[files]`.
#[derive(Clone, Debug)]
pub struct Publish {
    /// Path below the output folder with `/`; `{name}` stands for the element's name where `from` is a list. A bundle's is that of a
    /// folder and ends with `/`; `./` is the output folder itself.
    pub path: String,
    /// An output of type `File` or `Bundle`.
    pub from: OutputRef,
}

impl Publish {
    /// The folder of a bundle: empty, or ending with `/`. `None` for a file.
    pub fn folder(&self) -> Option<&str> {
        self.path.ends_with('/').then(|| if self.path == "./" { "" } else { &*self.path })
    }
}

/// One bound from `[require]`.
#[derive(Clone, Debug)]
pub struct Requirement {
    /// The node whose output of type `File` named `certificate` is judged.
    pub from: OutputRef,
    /// Path into its JSON, such as `crack_px.total`.
    pub path: String,
    pub min: Option<f64>,
    pub max: Option<f64>,
}

/// Names related to names: neighbours, clusters, children.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Relation(pub BTreeMap<String, Vec<String>>);

impl Artifact for Relation {
    const TYPE: &'static str = "Relation";
    const FORMAT: u32 = 1;
    fn encode(&self, out: &mut Encoder) {
        out.json("names", &self.0);
    }
    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        Ok(Self(data.json("names")?))
    }
}
