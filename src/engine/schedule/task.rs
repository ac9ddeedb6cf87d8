//! What a worker does: decodes the inputs, runs the kind, stores what came out. It waits for nothing.

use crate::{
    engine::{
        cache::{
            NewValue, Place, Stored,
            blob::{Bad, Blobs, INLINE},
        },
        hash::Digest,
        node::{Arity, Ctx, Data, Device, Kind, NodeError, Parameters, PortSpec, Slot},
        record::Read,
        source::{Recorder, Root},
        value::{PortOut, ValueRef, bad_name, shown},
    },
    math::Stop,
};
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

/// Where a task finds an input value.
pub enum From {
    /// Already decoded.
    Data(Data),
    Inline(Arc<Vec<u8>>),
    File,
}

pub struct Load {
    pub hash: Digest,
    pub from: From,
    pub verified: bool,
    /// Hand the decoded value back: other elements take it too.
    pub share: bool,
}

impl Load {
    pub fn new(hash: Digest, stored: Stored, verified: bool, share: bool) -> Self {
        let from = match stored {
            Stored::Inline(bytes) => From::Inline(bytes),
            // What is not kept is told apart before; no file has its name.
            Stored::File | Stored::NotKept => From::File,
        };
        Self { hash, from, verified, share }
    }
}

pub enum TaskSlot {
    Absent,
    One(Load),
    Many(Vec<(String, Load)>),
}

pub struct Task {
    pub kind: Arc<dyn Kind>,
    pub params: Parameters,
    pub inputs: Vec<TaskSlot>,
    /// For kinds that use it.
    pub element: Option<String>,
    pub roots: Arc<Vec<Root>>,
    pub stop: Stop,
    pub blobs: Blobs,
    pub device: Option<Arc<Device>>,
    /// Is told how many of how many steps are done.
    pub progress: Box<dyn Fn(u64, u64) + Send + Sync>,
    /// See [`Ctx::memory`].
    pub memory: u64,
    /// Whether the cache takes the outputs' bytes, and not only their hashes.
    pub keep: bool,
}

/// Between two reports of a run's progress.
const REPORT_EVERY: Duration = Duration::from_millis(100);

/// What a run gave.
pub struct Made {
    pub outputs: Vec<PortOut>,
    pub values: Vec<NewValue>,
    /// The decoded outputs by port, for those who take them next.
    pub data: Vec<(u32, ValueRef, Data)>,
    pub warnings: Vec<String>,
    /// Contents of the root files that were read, by parameter.
    pub roots: Vec<(String, Digest)>,
}

pub enum TaskError {
    /// Inputs whose stored bytes are bad or missing: port, value, what is wrong.
    Lost(Vec<(usize, Digest, String)>),
    /// The kind's own message, or its panic's.
    Failed(String),
    Stopped,
    /// The cache could not be read or written.
    Cache(String),
}

pub struct Done {
    pub result: Result<Made, TaskError>,
    /// What it read or looked for besides root files, whether it came to its end or not.
    pub reads: Vec<Read>,
    /// Inputs decoded here that others take too.
    pub shared: Vec<(Digest, u64, Data)>,
    /// Values whose bytes proved good.
    pub verified: Vec<Digest>,
    pub began: Instant,
    pub ended: Instant,
}

/// Runs `task` to its end.
pub fn perform(task: Task) -> Done {
    let began = Instant::now();
    let (mut shared, mut verified, mut reads) = (Vec::new(), Vec::new(), Vec::new());
    let result = perform_inner(task, &mut shared, &mut verified, &mut reads);
    Done { result, reads, shared, verified, began, ended: Instant::now() }
}

fn perform_inner(
    task: Task,
    shared: &mut Vec<(Digest, u64, Data)>,
    verified: &mut Vec<Digest>,
    reads: &mut Vec<Read>,
) -> Result<Made, TaskError> {
    let Task { kind, params, inputs, element, roots, stop, blobs, device, memory, progress, keep } = task;
    let spec = kind.spec();
    let mut lost = Vec::new();
    let mut slots = Vec::with_capacity(inputs.len());
    for (port, slot) in inputs.into_iter().enumerate() {
        let mut load = |load: Load| -> Result<Option<Data>, TaskError> {
            match fetch(&load, &spec.inputs[port], &blobs) {
                Ok((data, size)) => {
                    if !load.verified && matches!(load.from, From::File) {
                        verified.push(load.hash);
                    }
                    if load.share {
                        shared.push((load.hash, size, data.clone()));
                    }
                    Ok(Some(data))
                }
                Err(FetchError::Bad(what)) => {
                    lost.push((port, load.hash, what));
                    Ok(None)
                }
                Err(FetchError::Other(e)) => Err(e),
            }
        };
        slots.push(match slot {
            TaskSlot::Absent => Slot::Absent,
            TaskSlot::One(one) => load(one)?.map_or(Slot::Absent, Slot::One),
            TaskSlot::Many(many) => {
                let mut list = Vec::with_capacity(many.len());
                for (name, one) in many {
                    list.extend(load(one)?.map(|data| (name, data)));
                }
                Slot::Many(list)
            }
        });
    }
    if !lost.is_empty() {
        return Err(TaskError::Lost(lost));
    }
    let door = Recorder::new(roots);
    let warnings = Mutex::new(Vec::new());
    // A kind may warn from many threads: their order is not the run's to give.
    let warn = |text: String| warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    // A kind may take a million steps a second: nobody wants to read them all.
    let reported = Mutex::new(Instant::now());
    let progress = |done: u64, total: u64| {
        let Ok(mut last) = reported.try_lock() else { return };
        if last.elapsed() >= REPORT_EVERY {
            *last = Instant::now();
            progress(done, total);
        }
    };
    let (element, device) = (element.as_deref(), device.as_deref());
    let ctx = Ctx { stop: &stop, door: &door, element, device, memory, warn: &warn, progress: &progress };
    let made = guard(|| {
        let slots = kind.run(&params, slots, &ctx).map_err(|e| match e {
            NodeError::Stopped(_) if stop.is_set() => TaskError::Stopped,
            other => TaskError::Failed(other.to_string()),
        })?;
        store(&spec.outputs, slots, &blobs, keep)
    });
    let mut warnings = warnings.into_inner().unwrap_or_else(PoisonError::into_inner);
    warnings.sort();
    warnings.dedup();
    let (read, roots) = door.finish();
    *reads = read;
    let (outputs, values, data) = made.map_err(|e| with_warnings(e, &warnings))?;
    Ok(Made { outputs, values, data, warnings, roots })
}

/// A failure with what its run warned of before, which may be the reason.
fn with_warnings(error: TaskError, warnings: &[String]) -> TaskError {
    const SHOWN: usize = 3;
    let TaskError::Failed(mut text) = error else { return error };
    for warning in warnings.iter().take(SHOWN) {
        text += &format!("\n  before that: {warning}");
    }
    if warnings.len() > SHOWN {
        text += &format!("\n  and {} more warnings", warnings.len() - SHOWN);
    }
    TaskError::Failed(text)
}

/// Turns a panic of the kind's code into its failure.
fn guard<T>(f: impl FnOnce() -> Result<T, TaskError>) -> Result<T, TaskError> {
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_else(|payload| Err(TaskError::Failed(panic_text(&*payload))))
}

/// What a panic said.
pub fn panic_text(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
    format!("the kind's code panicked: {text} (a defect in it: please report it)")
}

/// Why a value cannot be handed on.
pub enum FetchError {
    /// Missing, or other bytes than its hash says.
    Bad(String),
    Other(TaskError),
}

/// Reads, checks and decodes one value; also gives its stored size.
pub fn fetch(load: &Load, port: &PortSpec, blobs: &Blobs) -> Result<(Data, u64), FetchError> {
    let bytes: crate::array::Bytes = match &load.from {
        From::Data(data) => return Ok((data.clone(), 0)),
        From::Inline(bytes) => {
            // Always: a row of the index that was there is not replaced by a run that makes the value again.
            if Digest::of(bytes) != load.hash {
                return Err(FetchError::Bad("its bytes in the index are not what its hash says".to_owned()));
            }
            bytes.clone()
        }
        From::File => blobs.get(&load.hash, load.verified).map_err(|Bad(what)| FetchError::Bad(what))?,
    };
    let size = (*bytes).as_ref().len() as u64;
    // The bytes are those that its producer stored: to run that again would give the same.
    let defect = |e| {
        let text = format!(
            "input `{}`: the stored {} cannot be decoded: {e} (a defect of that type)",
            port.name, port.ty.name
        );
        FetchError::Other(TaskError::Failed(text))
    };
    Ok(((port.ty.decode)(bytes).map_err(defect)?, size))
}

type StoredOutputs = (Vec<PortOut>, Vec<NewValue>, Vec<(u32, ValueRef, Data)>);

/// Stores what a run gave; where that is not to be kept, only hashes are taken.
fn store(ports: &[PortSpec], slots: Vec<Slot>, blobs: &Blobs, keep: bool) -> Result<StoredOutputs, TaskError> {
    let (mut outputs, mut values, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    let mut put = |at: usize, port: &PortSpec, data: Data| -> Result<ValueRef, TaskError> {
        let bytes = (port.ty.encode)(&data);
        let value = ValueRef { hash: Digest::of(&bytes), size: bytes.len() as u64 };
        let full = |e| TaskError::Cache(format!("a value of {} bytes cannot be written: {e}", value.size));
        let place = match bytes.len() {
            _ if !keep => Place::NotKept,
            n if n <= INLINE => Place::Inline(bytes),
            _ => Place::File(blobs.put(&value.hash, &bytes).map_err(full)?),
        };
        values.push(NewValue { hash: value.hash, place });
        kept.push((at as u32, value, data));
        Ok(value)
    };
    for (at, (port, slot)) in ports.iter().zip(slots).enumerate() {
        outputs.push(match (slot, port.arity) {
            (Slot::One(data), Arity::One) => PortOut::One(put(at, port, data)?),
            (Slot::Many(mut list), Arity::Many { may_be_empty, .. }) => {
                if list.is_empty() && !may_be_empty {
                    return Err(TaskError::Failed(format!("output `{}` is an empty list", port.name)));
                }
                list.sort_by(|a, b| a.0.cmp(&b.0));
                if let Some((name, what)) = list.iter().find_map(|(n, _)| Some((n, bad_name(n)?))) {
                    return Err(TaskError::Failed(format!("output `{}`: the element name {name:?} {what}", port.name)));
                }
                if let Some(pair) = list.windows(2).find(|p| p[0].0 == p[1].0) {
                    let name = shown(&pair[0].0);
                    return Err(TaskError::Failed(format!("output `{}` has two elements named `{name}`", port.name)));
                }
                let named = list.into_iter().map(|(name, data)| Ok((name, put(at, port, data)?)));
                PortOut::Many(named.collect::<Result<_, TaskError>>()?)
            }
            _ => return Err(TaskError::Failed(format!("output `{}` is missing", port.name))),
        });
    }
    Ok((outputs, values, kept))
}
