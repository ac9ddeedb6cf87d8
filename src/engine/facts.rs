//! What a report of a bake is made of.

use super::{
    plan::Plan,
    record::PublishedFile,
    report::{Reason, Report},
};

/// A bake that published, or that found published what it would have.
pub struct Facts<'a> {
    pub plan: &'a Plan,
    pub report: &'a Report,
    /// What lies in the folder.
    pub files: &'a [PublishedFile],
    /// Why nodes ran, in the plan's order; with those that did not and still passed a change on.
    pub reasons: &'a [Reason],
    /// When the bake ended, UTC.
    pub at: String,
    /// Where a bound was missed: when the results were published that the pipeline's folder still holds, UTC.
    pub accepted: Option<String>,
}
