//! Runs nodes in tests: what a run needs besides its parameters and inputs.

use crate::{
    array::Bytes,
    engine::node::{Ctx, Device, Door, Node, NodeError, ParamError, kind},
    math::Stop,
};
use std::{
    path::Path,
    sync::{Mutex, PoisonError},
};

/// A world without files.
pub struct NoFiles;

impl Door for NoFiles {
    fn read(&self, _: &Path) -> Result<Option<Bytes>, NodeError> {
        Ok(None)
    }
}

/// What a run finds outside its inputs.
pub struct World<'a> {
    pub door: &'a dyn Door,
    pub device: Option<&'a Device>,
    /// Bytes that the run may take.
    pub memory: u64,
}

impl Default for World<'_> {
    fn default() -> Self {
        Self { door: &NoFiles, device: None, memory: 1 << 32 }
    }
}

impl World<'_> {
    /// Gives `work` the context of a run; returns what came of it, and the warnings.
    pub fn visit<R>(&self, work: impl FnOnce(&Ctx) -> R) -> (R, Vec<String>) {
        let warnings = Mutex::new(Vec::new());
        let warn = |text| warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text);
        let Self { door, device, memory } = *self;
        let stop = Stop::default();
        let done = work(&Ctx { stop: &stop, door, element: None, device, memory, warn: &warn, progress: &|_, _| {} });
        (done, warnings.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// Runs a node; returns what came of it, and the warnings.
    pub fn run<N: Node>(&self, params: &N::Params, inputs: N::In) -> (Result<N::Out, NodeError>, Vec<String>) {
        self.visit(|ctx| N::run(params, inputs, ctx))
    }
}

/// Runs a node in a world without files; returns what came of it, and the warnings.
pub fn run<N: Node>(params: &N::Params, inputs: N::In) -> (Result<N::Out, NodeError>, Vec<String>) {
    World::default().run::<N>(params, inputs)
}

/// The parameter that a plan would refuse; `None` where it takes all. Numbers that JSON does not have are refused under no name.
pub fn refused<N: Node>(params: &N::Params) -> Option<String> {
    let json = serde_json::to_value(params).expect("parameters are plain data");
    match kind::<N>().accept(json) {
        Ok(_) => None,
        Err(ParamError::Refused { param, .. }) => Some(param),
        Err(ParamError::Type(_)) => Some(String::new()),
    }
}
