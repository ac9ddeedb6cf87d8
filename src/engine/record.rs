//! What the index remembers: results of runs, of whole maps, and whole bakes.

use super::{
    hash::Digest,
    value::{PortOut, ValueRef},
    wire::{Reader, RecordPlace, Writer},
};
use std::path::Path;

/// A file that a run read through the door, by its path relative to the root file's folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Read {
    pub path: String,
    /// `None`: there was no such file.
    pub hash: Option<Digest>,
}

/// The result of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunRecord {
    /// Hash of the key's fixed part (kind, version, parameters), explained in the index.
    pub fixed: Digest,
    /// Hash of what came through each input port; zero where it was absent.
    pub inputs: Vec<Digest>,
    pub outputs: Vec<PortOut>,
    pub warnings: Vec<String>,
    pub seconds: f64,
    /// Sorted by path.
    pub reads: Vec<Read>,
}

/// One element of a mapped node.
#[derive(Clone, Debug, PartialEq)]
pub struct MapRow {
    pub name: String,
    pub key: Digest,
    pub outputs: Vec<PortOut>,
}

/// The result of a mapped node as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct MapRecord {
    pub fixed: Digest,
    pub inputs: Vec<Digest>,
    /// Sorted by name.
    pub rows: Vec<MapRow>,
    /// Element and text.
    pub warnings: Vec<(String, String)>,
}

/// What a bake record says of one output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceOut {
    /// Of the value, or of the list.
    pub hash: Digest,
    /// Of the value; `None` for a list.
    pub size: Option<u64>,
}

/// What a bake did with one node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeTrace {
    pub name: String,
    /// Of the run, or of the whole map.
    pub key: Digest,
    /// Which of the records under that key: the hash of the files read; zero where none are.
    pub variant: Digest,
    pub mapped: bool,
    /// Elements in all, and how many of them ran.
    pub elements: u64,
    pub ran: u64,
    /// Why it ran although its key was known: `forced`, `lost`; empty otherwise.
    pub note: String,
    pub outputs: Vec<TraceOut>,
    pub warnings: Vec<(String, String)>,
}

/// A file below the output folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublishedFile {
    pub path: String,
    /// Its path within the bundle that the value is; empty where the value is the file.
    pub part: String,
    /// The stored value it was made from.
    pub value: Digest,
    /// Of the file's own bytes.
    pub file: Digest,
    pub size: u64,
}

/// A number read from a certificate.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    pub certificate: Digest,
    pub path: String,
    pub number: Option<f64>,
}

/// One bake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeRecord {
    /// Seconds since 1970.
    pub at: i64,
    pub nodes: Vec<NodeTrace>,
    pub files: Vec<PublishedFile>,
    pub measured: Vec<Measured>,
}

/// How records know an output folder: by its full path.
pub fn folder_key(folder: &Path) -> String {
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned()).to_string_lossy().into_owned()
}

fn put_value(w: &mut Writer, v: &ValueRef) {
    w.digest(&v.hash);
    w.u64(v.size);
}

fn value(r: &mut Reader) -> Option<ValueRef> {
    Some(ValueRef { hash: r.digest()?, size: r.u64()? })
}

fn put_out(w: &mut Writer, out: &PortOut) {
    match out {
        PortOut::One(v) => {
            w.u8(0);
            put_value(w, v);
        }
        PortOut::Many(rows) => {
            w.u8(1);
            w.list(rows, |w, (name, v)| {
                w.str(name);
                put_value(w, v);
            });
        }
    }
}

fn out(r: &mut Reader) -> Option<PortOut> {
    Some(match r.u8()? {
        0 => PortOut::One(value(r)?),
        1 => PortOut::Many(r.list(|r| Some((r.str()?.to_owned(), value(r)?)))?),
        _ => return None,
    })
}

fn put_pairs(w: &mut Writer, pairs: &[(String, String)]) {
    w.list(pairs, |w, (a, b)| {
        w.str(a);
        w.str(b);
    });
}

fn pairs(r: &mut Reader) -> Option<Vec<(String, String)>> {
    r.list(|r| Some((r.str()?.to_owned(), r.str()?.to_owned())))
}

impl RunRecord {
    /// The bytes of the record under `key`.
    pub fn to_bytes(&self, key: &Digest) -> Vec<u8> {
        let mut w = Writer::default();
        w.digest(&self.fixed);
        w.list(&self.inputs, Writer::digest);
        w.list(&self.outputs, put_out);
        w.list(&self.warnings, |w, t| w.str(t));
        w.f64(self.seconds);
        w.list(&self.reads, |w, f| {
            w.str(&f.path);
            w.option(&f.hash, Writer::digest);
        });
        w.seal(&RecordPlace::Run { key, variant: &self.variant() })
    }

    /// `None` unless these are the bytes of the record under `key` and `variant`.
    pub fn from_bytes(bytes: &[u8], key: &Digest, variant: &Digest) -> Option<Self> {
        let r = &mut Reader::open(bytes, &RecordPlace::Run { key, variant })?;
        Some(Self {
            fixed: r.digest()?,
            inputs: r.list(Reader::digest)?,
            outputs: r.list(out)?,
            warnings: r.list(|r| r.str().map(str::to_owned))?,
            seconds: r.f64()?,
            reads: r.list(|r| Some(Read { path: r.str()?.to_owned(), hash: r.option(Reader::digest)? }))?,
        })
    }

    /// Tells records under one key apart: the hash of what was read; zero where nothing was.
    pub fn variant(&self) -> Digest {
        if self.reads.is_empty() {
            return Digest::default();
        }
        let mut w = Writer::default();
        w.list(&self.reads, |w, f| {
            w.str(&f.path);
            w.option(&f.hash, Writer::digest);
        });
        w.digest_of()
    }
}

impl MapRecord {
    /// The bytes of the record under `key`. `rows`: name, key and outputs of each, sorted by name.
    pub fn write<'a>(
        key: &Digest,
        fixed: Digest,
        inputs: &[Digest],
        rows: impl ExactSizeIterator<Item = (&'a str, Digest, &'a [PortOut])>,
        warnings: &[(String, String)],
    ) -> Vec<u8> {
        let mut w = Writer::default();
        w.digest(&fixed);
        w.list(inputs, Writer::digest);
        w.u32(rows.len() as u32);
        for (name, key, outputs) in rows {
            w.str(name);
            w.digest(&key);
            w.list(outputs, put_out);
        }
        put_pairs(&mut w, warnings);
        w.seal(&RecordPlace::Map { key })
    }

    /// `None` unless these are the bytes of the record under `key`.
    pub fn from_bytes(bytes: &[u8], key: &Digest) -> Option<Self> {
        let r = &mut Reader::open(bytes, &RecordPlace::Map { key })?;
        let row = |r: &mut Reader| Some(MapRow { name: r.str()?.to_owned(), key: r.digest()?, outputs: r.list(out)? });
        Some(Self { fixed: r.digest()?, inputs: r.list(Reader::digest)?, rows: r.list(row)?, warnings: pairs(r)? })
    }
}

impl BakeRecord {
    /// The bytes of the record number `id` of `pipeline` into `folder`.
    pub fn to_bytes(&self, id: i64, pipeline: &str, folder: &str) -> Vec<u8> {
        let mut w = Writer::default();
        w.i64(self.at);
        w.list(&self.nodes, |w, n| {
            w.str(&n.name);
            w.digest(&n.key);
            w.digest(&n.variant);
            w.u8(u8::from(n.mapped));
            w.u64(n.elements);
            w.u64(n.ran);
            w.str(&n.note);
            w.list(&n.outputs, |w, o| {
                w.digest(&o.hash);
                w.option(&o.size, |w, s| w.u64(*s));
            });
            put_pairs(w, &n.warnings);
        });
        w.list(&self.files, |w, f| {
            w.str(&f.path);
            w.str(&f.part);
            w.digest(&f.value);
            w.digest(&f.file);
            w.u64(f.size);
        });
        w.list(&self.measured, |w, m| {
            w.digest(&m.certificate);
            w.str(&m.path);
            w.option(&m.number, |w, v| w.f64(*v));
        });
        w.seal(&RecordPlace::Bake { id, pipeline, folder })
    }

    /// `None` unless these are the bytes of the record number `id` of `pipeline` into `folder`.
    pub fn from_bytes(bytes: &[u8], id: i64, pipeline: &str, folder: &str) -> Option<Self> {
        let r = &mut Reader::open(bytes, &RecordPlace::Bake { id, pipeline, folder })?;
        let node = |r: &mut Reader| {
            Some(NodeTrace {
                name: r.str()?.to_owned(),
                key: r.digest()?,
                variant: r.digest()?,
                mapped: r.u8()? != 0,
                elements: r.u64()?,
                ran: r.u64()?,
                note: r.str()?.to_owned(),
                outputs: r.list(|r| Some(TraceOut { hash: r.digest()?, size: r.option(Reader::u64)? }))?,
                warnings: pairs(r)?,
            })
        };
        let file = |r: &mut Reader| {
            Some(PublishedFile {
                path: r.str()?.to_owned(),
                part: r.str()?.to_owned(),
                value: r.digest()?,
                file: r.digest()?,
                size: r.u64()?,
            })
        };
        let measured = |r: &mut Reader| {
            Some(Measured { certificate: r.digest()?, path: r.str()?.to_owned(), number: r.option(Reader::f64)? })
        };
        Some(Self { at: r.i64()?, nodes: r.list(node)?, files: r.list(file)?, measured: r.list(measured)? })
    }

    pub fn node(&self, name: &str) -> Option<&NodeTrace> {
        self.nodes.iter().find(|n| n.name == name)
    }
}
