//! The kind that stands before a list port which a pipeline feeds from several outputs, `{ impostor = "impostor.bundle", mesh = "mesh.bundle" }`: one list of all
//! of them.
//!
//! Elements are named by the word of their output, `impostor`; those of a list by word and name, `impostor/house 3`. No pipeline names this kind: it is put in by the
//! engine, and its ports take the type of the one that asked.

use super::{
    node::{Arity, Ctx, Head, Kind, KindSpec, NodeError, ParamError, Parameters, PortSpec, Slot, TypeInfo},
    value::shown,
};
use serde_json::{Value, json};
use std::{path::Path, sync::Arc};

/// The kind's name.
pub const KIND: &str = "collect";

/// Outputs that one port takes, at most.
pub const MOST: usize = 16;

const PORTS: [&str; MOST] = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "13", "14", "15", "16"];

struct Collect {
    spec: KindSpec,
}

/// The kind for `count` outputs, at most [`MOST`], of type `ty`.
pub fn kind(ty: TypeInfo, count: usize) -> Arc<dyn Kind> {
    let port = |name, doc| PortSpec { name, doc, ty, arity: Arity::Many { may_be_empty: true, may_be_absent: false } };
    let spec = KindSpec {
        name: KIND,
        method: "",
        version: 1,
        native: false,
        uses_name: false,
        inputs: PORTS.iter().take(count).map(|name| port(name, "A value, or a list.")).collect(),
        outputs: vec![port("list", "All of them.")],
        params: json!({ "type": "object", "description": "Lists of several outputs as one." }),
        measures: Vec::new(),
    };
    Arc::new(Collect { spec })
}

/// Its parameters: the word of each output.
pub fn parameters(words: Vec<String>) -> Parameters {
    Parameters::new(json!({ "words": words }), Arc::new(words))
}

impl Kind for Collect {
    fn spec(&self) -> &KindSpec {
        &self.spec
    }

    fn accept(&self, params: Value) -> Result<Parameters, ParamError> {
        Ok(parameters(serde_json::from_value(params.get("words").cloned().unwrap_or_default())?))
    }

    fn doubts(&self, _: &Parameters) -> Vec<(&'static str, String)> {
        Vec::new()
    }

    fn check_source(&self, _: &str, _: &Path, _: Head) -> Result<(), String> {
        Ok(())
    }

    fn memory(&self, _: &Parameters, _: &[u64]) -> u64 {
        // Values are handed on as they are.
        1 << 20
    }

    fn run(&self, params: &Parameters, inputs: Vec<Slot>, ctx: &Ctx) -> Result<Vec<Slot>, NodeError> {
        let words: &Vec<String> = params.typed().expect("the engine's own parameters");
        let mut all = Vec::new();
        for (word, slot) in words.iter().zip(inputs) {
            ctx.stop.check()?;
            let Slot::Many(list) = slot else { unreachable!("arity is checked in the plan") };
            all.extend(list.into_iter().map(|(name, data)| match name.is_empty() {
                true => (word.clone(), data),
                false => (format!("{word}/{}", shown(&name)), data),
            }));
        }
        Ok(vec![Slot::Many(all)])
    }
}
