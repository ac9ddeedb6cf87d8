//! The second level of the cache: a folder or an S3 bucket that machines share, behind the local cache.
//!
//! What always holds: nothing from it is believed before its hash or checksum proved it, and it enters the local cache
//! as a computed result does, so that a wrong object costs time and changes nothing; a store that fails costs time once,
//! then it is off for the rest of the bake. The engine asks and hands over, and waits for nothing: all transfers run on
//! a thread of their own.
//!
//! Without the feature `remote` there is nothing behind this interface.

#[cfg(not(feature = "remote"))]
mod absent;
#[cfg(feature = "remote")]
mod address;
pub mod bundle;
#[cfg(feature = "remote")]
mod fault;
#[cfg(feature = "remote")]
mod health;
#[cfg(feature = "remote")]
mod store;
#[cfg(feature = "remote")]
mod worker;

#[cfg(not(feature = "remote"))]
pub use absent::Remote;
#[cfg(feature = "remote")]
pub use worker::Remote;

use super::{
    cache::{Fields, NewValue},
    hash::Digest,
    record::RunRecord,
};
use std::{collections::BTreeMap, sync::Arc};

/// Where the second level is, and what may be done there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RemoteOptions {
    /// `s3://bucket/prefix`, `file:///folder`, or a folder.
    pub url: String,
    /// Whether results are uploaded. Who may write can lead others to wrong results, since no hash proves which result
    /// belongs to a key: so this is asked for.
    pub write: bool,
    /// Endpoint, region and credentials of a bucket, by the names of the environment variables that usually say them: `AWS_…`.
    pub settings: BTreeMap<String, String>,
}

/// What went over the wire in one bake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Runs whose results were found there.
    pub fetched: u64,
    /// Bytes of records and values received.
    pub fetched_bytes: u64,
    /// Runs whose results were stored there.
    pub stored: u64,
    /// Bytes of records and values sent.
    pub stored_bytes: u64,
}

/// A run's result as the second level has it.
pub struct Found {
    pub record: RunRecord,
    /// The small values. The others are [`Place::NotKept`](super::cache::Place::NotKept) until somebody needs them.
    pub values: Vec<NewValue>,
    /// What the fixed part of the key means, for `why`.
    pub fields: Fields,
}

/// A run's result on its way out. Large values lie in the local cache.
pub struct Outgoing {
    pub key: Digest,
    pub record: Arc<RunRecord>,
    pub values: Vec<NewValue>,
    pub fields: Arc<Fields>,
}

/// Takes an answer, from another thread. Whatever happens it is called once: dropped, it says that there is none.
pub struct Reply<T>(Option<Box<dyn FnOnce(Option<T>) + Send>>);

impl<T> Reply<T> {
    pub fn new(take: impl FnOnce(Option<T>) + Send + 'static) -> Self {
        Self(Some(Box::new(take)))
    }

    #[cfg(feature = "remote")]
    fn give(mut self, answer: Option<T>) {
        if let Some(take) = self.0.take() {
            take(answer);
        }
    }
}

impl<T> Drop for Reply<T> {
    fn drop(&mut self) {
        if let Some(take) = self.0.take() {
            take(None);
        }
    }
}
