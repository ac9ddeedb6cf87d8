//! Why a node ran.

use super::{bake::Options, error::EngineError, plan::Plan};

/// Why `what` (`NODE` or `NODE/ELEMENT`) ran when it last did, as a chain up to the cause.
pub fn why(plan: &Plan, options: &Options, what: &str) -> Result<String, EngineError> {
    let _ = (plan, options, what);
    Err(EngineError::Again("not built yet".into()))
}
