//! The thread on which transfers run, many at a time, and what the engine says to it.

use super::{
    Found, Outgoing, RemoteOptions, Reply, Traffic, address, bundle,
    fault::Fault,
    health::{Deed, Health},
    store::{self, Got, MOST_OF_RUN, MOST_OF_VALUE, Store},
};
use crate::{
    engine::{
        cache::{
            NewValue, Place,
            blob::{Blobs, INLINE},
            pack,
        },
        error::EngineError,
        hash::Digest,
        lookup::DigestSet,
    },
    math::Stop,
};
use std::{
    sync::{
        Arc, Condvar, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};
use tokio::sync::{Semaphore, mpsc};

/// Records, and values, that are asked for or sent at a time.
const RECORDS: usize = 48;
const VALUES: usize = 6;
/// Values of more bytes than this are handled one at a time, so that memory is bounded.
const LARGE: u64 = 64 << 20;
/// Results, and bytes of small values, that wait to be sent; who has more waits.
const WAITING: (u64, u64) = (10_000, 64 << 20);
/// How often who waits looks whether a stop was asked for.
const POLL: Duration = Duration::from_millis(20);

enum Job {
    Ask(Digest, Reply<Vec<Found>>),
    Fetch(Digest, Reply<NewValue>),
    Store(Outgoing, Waiting),
    End,
}

/// What is known on both sides.
struct Shared {
    store: Store,
    blobs: Blobs,
    health: Health,
    /// Results and bytes that wait to be sent.
    waiting: Mutex<(u64, u64)>,
    less: Condvar,
    /// Values that were stored there, or found there, in this bake.
    sent: Mutex<DigestSet>,
    records: Semaphore,
    values: Semaphore,
    large: Semaphore,
    ended: AtomicBool,
}

/// A result that waits to be sent, with the bytes of its small values; counted until it is dropped.
struct Waiting(Arc<Shared>, u64);

impl Drop for Waiting {
    fn drop(&mut self) {
        let mut waiting = self.0.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        (waiting.0, waiting.1) = (waiting.0 - 1, waiting.1 - self.1);
        self.0.less.notify_all();
    }
}

/// An open second level.
pub struct Remote {
    shared: Arc<Shared>,
    jobs: mpsc::UnboundedSender<Job>,
    thread: Option<JoinHandle<()>>,
}

impl Remote {
    /// Opens it; `blobs` are the files of the local cache. Nothing is asked of the store yet.
    pub fn open(options: &RemoteOptions, blobs: Blobs) -> Result<Self, EngineError> {
        let opened = address::open(options)?;
        let fail = |e: std::io::Error| EngineError::Remote { url: options.url.clone(), what: e.to_string() };
        let shared = Arc::new(Shared {
            store: Store::new(opened.store, opened.prefix),
            blobs,
            health: Health::new(options.url.clone(), opened.hint, options.write),
            waiting: Mutex::default(),
            less: Condvar::new(),
            sent: Mutex::default(),
            records: Semaphore::new(RECORDS),
            values: Semaphore::new(VALUES),
            large: Semaphore::new(1),
            ended: AtomicBool::new(false),
        });
        let (jobs, mut list) = mpsc::unbounded_channel();
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(8).build().map_err(fail)?;
        let own = shared.clone();
        let work = move || {
            runtime.block_on(async {
                while let Some(job) = list.recv().await {
                    match job {
                        Job::Ask(key, reply) => drop(tokio::spawn(ask(own.clone(), key, reply))),
                        Job::Fetch(hash, reply) => drop(tokio::spawn(fetch(own.clone(), hash, reply))),
                        Job::Store(result, waiting) => drop(tokio::spawn(store(own.clone(), result, waiting))),
                        Job::End => break,
                    }
                }
            });
            // What is still out has no one who waits for it.
            runtime.shutdown_background();
        };
        let thread = std::thread::Builder::new().name("remote cache".to_owned()).spawn(work).map_err(fail)?;
        Ok(Self { shared, jobs, thread: Some(thread) })
    }

    /// Whether it is worth to ask.
    pub fn reads(&self) -> bool {
        self.shared.health.is_on(Deed::Read)
    }

    /// Whether it takes results.
    pub fn writes(&self) -> bool {
        self.shared.health.is_on(Deed::Write)
    }

    /// Asks for the results of a key.
    pub fn ask(&self, key: Digest, reply: Reply<Vec<Found>>) {
        // A job that nobody takes is dropped, and its reply with it.
        let _ = self.jobs.send(Job::Ask(key, reply));
    }

    /// Asks for a value, which is stored among the local cache's files if it is large.
    pub fn fetch(&self, hash: Digest, reply: Reply<NewValue>) {
        let _ = self.jobs.send(Job::Fetch(hash, reply));
    }

    /// Hands over a result to be stored: its values first, so that no record leads to nothing. Waits only while very
    /// much is on its way.
    pub fn store(&self, result: Outgoing) {
        if !self.writes() {
            return;
        }
        let bytes =
            result.values.iter().map(|v| if let Place::Inline(b) = &v.place { b.len() as u64 } else { 0 }).sum();
        let mut waiting = self.shared.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        while (waiting.0 >= WAITING.0 || waiting.1 >= WAITING.1) && self.writes() {
            let wait = self.shared.less.wait_timeout(waiting, POLL);
            waiting = wait.unwrap_or_else(PoisonError::into_inner).0;
        }
        (waiting.0, waiting.1) = (waiting.0 + 1, waiting.1 + bytes);
        drop(waiting);
        let _ = self.jobs.send(Job::Store(result, Waiting(self.shared.clone(), bytes)));
    }

    /// What is to be told since it was asked last.
    pub fn warnings(&self) -> Vec<String> {
        self.shared.health.warnings()
    }

    /// Waits until all results are stored, or given up. Afterwards nothing more is read or written.
    pub fn finish(&self, stop: &Stop) -> Traffic {
        let mut waiting = self.shared.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        while waiting.0 > 0 && !stop.is_set() && self.writes() {
            let wait = self.shared.less.wait_timeout(waiting, POLL);
            waiting = wait.unwrap_or_else(PoisonError::into_inner).0;
        }
        self.shared.health.close(waiting.0);
        self.shared.health.traffic()
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::Relaxed);
        let _ = self.jobs.send(Job::End);
        if let Some(thread) = self.thread.take() {
            // It has told what it had to tell.
            let _ = thread.join();
        }
    }
}

impl Shared {
    /// Notes how a request went; its answer, where there is one.
    fn note<T>(&self, deed: Deed, object: &str, answer: Result<T, Fault>) -> Option<T> {
        match answer {
            Ok(answer) => {
                self.health.worked();
                Some(answer)
            }
            Err(Fault::Absent | Fault::Present) => {
                self.health.worked();
                None
            }
            Err(fault) => {
                self.health.failed(deed, object, &fault);
                None
            }
        }
    }

    fn is_on(&self, deed: Deed) -> bool {
        !self.ended.load(Ordering::Relaxed) && self.health.is_on(deed)
    }

    fn was_sent(&self, hash: &Digest) -> bool {
        self.sent.lock().unwrap_or_else(PoisonError::into_inner).contains(hash)
    }

    fn note_sent(&self, hash: Digest) {
        self.sent.lock().unwrap_or_else(PoisonError::into_inner).insert(hash);
    }
}

/// Runs what computes or waits for the disk beside the transfers.
async fn beside<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    tokio::task::spawn_blocking(work).await.ok()
}

async fn ask(shared: Arc<Shared>, key: Digest, reply: Reply<Vec<Found>>) {
    let Ok(_permit) = shared.records.acquire().await else { return };
    if !shared.is_on(Deed::Read) {
        return;
    }
    let object = store::run(&key);
    let answer = shared.store.get(&object, MOST_OF_RUN, MOST_OF_RUN).await;
    let bytes = match shared.note(Deed::Read, &object, answer) {
        Some(Got::Bytes(bytes)) => bytes,
        Some(_) => return shared.health.damaged(key, &object, "it is too large"),
        None => return,
    };
    let size = bytes.len() as u64;
    match beside(move || bundle::results(&bytes, &key)).await.flatten() {
        Some(found) => {
            shared.health.count(|t| t.fetched_bytes += size);
            reply.give(Some(found));
        }
        None => shared.health.damaged(key, &object, "its checksum is wrong"),
    }
}

async fn fetch(shared: Arc<Shared>, hash: Digest, reply: Reply<NewValue>) {
    let Ok(_permit) = shared.values.acquire().await else { return };
    if !shared.is_on(Deed::Read) {
        return;
    }
    let object = store::value(&hash);
    let mut answer = shared.store.get(&object, MOST_OF_VALUE, LARGE).await;
    let mut _alone = None;
    if matches!(answer, Ok(Got::Large)) {
        _alone = shared.large.acquire().await.ok();
        answer = shared.store.get(&object, MOST_OF_VALUE, MOST_OF_VALUE).await;
    }
    let bytes = match shared.note(Deed::Read, &object, answer) {
        Some(Got::Bytes(bytes)) => bytes,
        Some(_) => return shared.health.damaged(hash, &object, "it is too large"),
        None => return,
    };
    let (size, blobs) = (bytes.len() as u64, shared.blobs.clone());
    match beside(move || take_in(&blobs, hash, bytes)).await {
        Some(Ok(value)) => {
            shared.health.count(|t| t.fetched_bytes += size);
            shared.note_sent(hash);
            reply.give(Some(value));
        }
        Some(Err(what)) => shared.health.damaged(hash, &object, &what),
        None => {}
    }
}

/// Checks the bytes of a value and stores them as those of a run are stored.
fn take_in(blobs: &Blobs, hash: Digest, bytes: Vec<u8>) -> Result<NewValue, String> {
    let bytes = if pack::is_packed(&bytes) { pack::unpack(&bytes)? } else { bytes };
    if Digest::of(&bytes) != hash {
        return Err("its bytes are not what its hash says".to_owned());
    }
    let place = match bytes.len() {
        n if n <= INLINE => Place::Inline(bytes),
        _ => Place::File(blobs.put(&hash, &bytes).map_err(|e| format!("it is sound, but cannot be stored here: {e}"))?),
    };
    Ok(NewValue { hash, place })
}

/// Stores a result: values, then the record.
async fn store(shared: Arc<Shared>, result: Outgoing, _waiting: Waiting) {
    let inline = result.values.iter().filter_map(|v| match &v.place {
        Place::Inline(bytes) => Some((&v.hash, &bytes[..])),
        _ => None,
    });
    let (entry, along) = bundle::Entry::new(&result.key, &result.record, &result.fields, inline);
    for value in &result.values {
        let stored = match &value.place {
            Place::NotKept => true,
            Place::Inline(_) if along.contains(&value.hash) => true,
            Place::Inline(bytes) => store_value(&shared, value.hash, Some(bytes.clone())).await,
            Place::File(_) => store_value(&shared, value.hash, None).await,
        };
        if !stored {
            return;
        }
    }
    let Ok(_permit) = shared.records.acquire().await else { return };
    if !shared.is_on(Deed::Write) {
        return;
    }
    let (key, object) = (result.key, store::run(&result.key));
    let damaged = shared.health.is_damaged(&key);
    let mut entries = vec![entry];
    // Results that depend on more files than their key tells share an object. The loss of a race is the loss of one.
    let shares = entries[0].variant != Digest::default();
    if shares && !damaged {
        let answer = shared.store.get(&object, MOST_OF_RUN, MOST_OF_RUN).await;
        if let Some(Got::Bytes(bytes)) = shared.note(Deed::Read, &object, answer) {
            let others = bundle::read(&bytes, &key).unwrap_or_default();
            if others.iter().any(|other| other.variant == entries[0].variant) {
                return;
            }
            entries.splice(0..0, others);
            let surplus = entries.len().saturating_sub(bundle::VARIANTS);
            entries.drain(..surplus);
        }
    }
    let bytes = bundle::write(&key, &entries);
    let size = bytes.len() as u64;
    if size > MOST_OF_RUN {
        return;
    }
    let answer = shared.store.put(&object, bytes, shares || damaged).await;
    if shared.note(Deed::Write, &object, answer).is_some() {
        shared.health.repaired(&key);
        shared.health.count(|t| (t.stored, t.stored_bytes) = (t.stored + 1, t.stored_bytes + size));
    }
}

/// Stores a value: the bytes given, or those of its file. Whether it is there afterwards.
async fn store_value(shared: &Arc<Shared>, hash: Digest, bytes: Option<Vec<u8>>) -> bool {
    let Ok(_permit) = shared.values.acquire().await else { return false };
    if !shared.is_on(Deed::Write) {
        return false;
    }
    if shared.was_sent(&hash) {
        return true;
    }
    let mut _alone = None;
    let bytes = match bytes {
        Some(bytes) => pack::pack(&bytes).unwrap_or(bytes),
        None => {
            if std::fs::metadata(shared.blobs.path(&hash)).is_ok_and(|meta| meta.len() > LARGE) {
                _alone = shared.large.acquire().await.ok();
            }
            let blobs = shared.blobs.clone();
            match beside(move || blobs.packed(&hash)).await {
                Some(Ok(bytes)) if bytes.len() as u64 <= MOST_OF_VALUE => bytes,
                // Lost or damaged since: the bake meets that where it needs the value.
                _ => return false,
            }
        }
    };
    let (object, size) = (store::value(&hash), bytes.len() as u64);
    let damaged = shared.health.is_damaged(&hash);
    if !damaged {
        let there = shared.store.size(&object).await;
        match shared.note(Deed::Write, &object, there) {
            Some(Some(there)) if there == size => {
                shared.note_sent(hash);
                return true;
            }
            Some(_) => {}
            None => return false,
        }
    }
    // What has another size is damaged, or compressed otherwise: the new one is sound.
    let answer = shared.store.put(&object, bytes, true).await;
    if shared.note(Deed::Write, &object, answer).is_none() {
        return false;
    }
    shared.health.repaired(&hash);
    shared.note_sent(hash);
    shared.health.count(|t| t.stored_bytes += size);
    true
}
