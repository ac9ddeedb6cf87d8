//! The second level in a build without it: it cannot be opened.

use super::{Found, Outgoing, RemoteOptions, Reply, Traffic};
use crate::{
    engine::{
        cache::{NewValue, blob::Blobs},
        error::EngineError,
        hash::Digest,
    },
    math::Stop,
};

/// There is none.
pub enum Remote {}

impl Remote {
    pub fn open(options: &RemoteOptions, _: Blobs) -> Result<Self, EngineError> {
        let what = "this program was built without remote caches: build it with `--features remote`".to_owned();
        Err(EngineError::Remote { url: options.url.clone(), what })
    }

    pub fn reads(&self) -> bool {
        match *self {}
    }

    pub fn writes(&self) -> bool {
        match *self {}
    }

    pub fn ask(&self, _: Digest, _: Reply<Vec<Found>>) {
        match *self {}
    }

    pub fn fetch(&self, _: Digest, _: Reply<NewValue>) {
        match *self {}
    }

    pub fn store(&self, _: Outgoing) {
        match *self {}
    }

    pub fn warnings(&self) -> Vec<String> {
        match *self {}
    }

    pub fn finish(&self, _: &Stop) -> Traffic {
        match *self {}
    }
}
