//! Objects by name, with limits of time and size around every request.

use super::fault::Fault;
use crate::engine::hash::Digest;
use futures_util::StreamExt as _;
use object_store::{ObjectStore, ObjectStoreExt as _, PutMode, PutOptions, PutPayload, path::Path};
use std::{future::Future, sync::Arc, time::Duration};

/// The layout of objects; another layout has another folder.
const LAYOUT: &str = "v1";
/// How long a server may keep silent.
const SILENCE: Duration = Duration::from_secs(10);
/// Bytes that go out in a second at least.
const SLOWEST: u64 = 64 << 10;
/// Bytes of an object of a key at most.
pub const MOST_OF_RUN: u64 = 256 << 20;
/// Bytes of a value's object at most; larger values stay local.
pub const MOST_OF_VALUE: u64 = 2 << 30;

pub struct Store {
    store: Arc<dyn ObjectStore>,
    prefix: Path,
}

/// What an answer to a request was.
pub enum Got {
    Bytes(Vec<u8>),
    /// It has more bytes than any object of its sort.
    TooLarge,
    /// It needs more memory than can be had just now; ask again when it is there.
    Large,
}

/// The last parts of the names of objects.
pub fn run(key: &Digest) -> String {
    name("run", key)
}

pub fn value(hash: &Digest) -> String {
    name("value", hash)
}

fn name(sort: &str, digest: &Digest) -> String {
    let hex = digest.hex();
    format!("{LAYOUT}/{sort}/{}/{hex}", &hex[..2])
}

async fn within<T>(limit: Duration, what: impl Future<Output = object_store::Result<T>>) -> Result<T, Fault> {
    match tokio::time::timeout(limit, what).await {
        Ok(answer) => answer.map_err(|e| Fault::of(&e)),
        Err(_) => Err(Fault::Silent(format!("no answer within {} s", limit.as_secs()))),
    }
}

impl Store {
    pub fn new(store: Arc<dyn ObjectStore>, prefix: Path) -> Self {
        Self { store, prefix }
    }

    fn path(&self, name: &str) -> Path {
        self.prefix.parts().chain(Path::from(name).parts()).collect()
    }

    /// The bytes of an object. `at_once`: how many are taken without asking again.
    pub async fn get(&self, name: &str, most: u64, at_once: u64) -> Result<Got, Fault> {
        let path = self.path(name);
        let got = within(SILENCE, self.store.get(&path)).await?;
        let size = got.meta.size;
        if size > most {
            return Ok(Got::TooLarge);
        }
        if size > at_once {
            return Ok(Got::Large);
        }
        let mut bytes = Vec::new();
        let mut stream = got.into_stream();
        // What arrives is believed, not what was said to come.
        while let Some(part) = within(SILENCE, async { stream.next().await.transpose() }).await? {
            if bytes.len() as u64 + part.len() as u64 > size {
                return Ok(Got::TooLarge);
            }
            bytes.extend_from_slice(&part);
        }
        Ok(Got::Bytes(bytes))
    }

    /// The size of an object; `None` where there is none.
    pub async fn size(&self, name: &str) -> Result<Option<u64>, Fault> {
        let path = self.path(name);
        match within(SILENCE, self.store.head(&path)).await {
            Ok(meta) => Ok(Some(meta.size)),
            Err(Fault::Absent) => Ok(None),
            Err(fault) => Err(fault),
        }
    }

    /// Stores an object; with `replace` in the place of one that is there, else [`Fault::Present`] says that one is.
    pub async fn put(&self, name: &str, bytes: Vec<u8>, replace: bool) -> Result<(), Fault> {
        let limit = SILENCE + Duration::from_secs(bytes.len() as u64 / SLOWEST);
        let path = self.path(name);
        let payload = PutPayload::from(bytes);
        let put = async |mode: PutMode| {
            let options = PutOptions { mode, ..PutOptions::default() };
            within(limit, self.store.put_opts(&path, payload.clone(), options)).await.map(drop)
        };
        if replace {
            return put(PutMode::Overwrite).await;
        }
        match put(PutMode::Create).await {
            // Servers and file systems that cannot put an object only where none is; equal keys have equal results.
            Err(Fault::Other(text)) if cannot_create(&text) => put(PutMode::Overwrite).await,
            other => other,
        }
    }
}

fn cannot_create(text: &str) -> bool {
    ["NotImplemented", "501", "not supported", "Operation not permitted"].iter().any(|sign| text.contains(sign))
}
