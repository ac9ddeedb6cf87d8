//! Artifacts: typed, versioned, self-describing values that flow on edges and lie in the cache.
//!
//! Container: a header, a table of named sections, the sections' bytes. Little-endian; every section begins at a
//! multiple of 64 bytes, so that a file map can be read in place. A decoder given any bytes returns an error: it never
//! panics and never allocates what a length only claims.

use crate::array::{Array, Bytes};
use bytemuck::Pod;
use serde::{Serialize, de::DeserializeOwned};

const MAGIC: [u8; 8] = *b"farfield";
/// Version of the container itself.
const CONTAINER: u32 = 1;
const ALIGN: usize = 64;

/// A type whose values can be stored. Equal values must encode to equal bytes.
pub trait Artifact: Sized + Send + Sync + 'static {
    /// The type's name in pipeline files and documentation, such as `Scene`.
    const TYPE: &'static str;
    /// Increased whenever the encoding changes; part of every key that the type takes part in.
    const FORMAT: u32;
    fn encode(&self, out: &mut Encoder);
    fn decode(data: &Decoder) -> Result<Self, DecodeError>;
}

/// Why bytes are not the artifact that they should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    #[error("not a farfield artifact (expected the magic number `farfield`, container version {CONTAINER})")]
    Magic,
    #[error("expected type {expected}, found {found}")]
    Type { expected: String, found: String },
    #[error("section `{section}`: {what}")]
    Section { section: String, what: String },
    #[error("truncated: {what}")]
    Truncated { what: &'static str },
}

impl DecodeError {
    pub fn section(section: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Section { section: section.into(), what: what.into() }
    }
}

/// Collects an artifact's sections. A section's name is unique within its artifact.
#[derive(Default)]
pub struct Encoder {
    sections: Vec<(String, Vec<u8>)>,
}

impl Encoder {
    /// An array section; `T`'s size is stored beside it.
    pub fn array<T: Pod>(&mut self, name: impl Into<String>, values: &[T]) {
        const { assert!(cfg!(target_endian = "little"), "artifacts are little-endian") };
        self.bytes(name, bytemuck::cast_slice(values).to_vec());
    }

    pub fn bytes(&mut self, name: impl Into<String>, bytes: Vec<u8>) {
        let name = name.into();
        debug_assert!(self.sections.iter().all(|(n, _)| *n != name), "section {name} twice");
        self.sections.push((name, bytes));
    }

    /// Small structured data as JSON (maps in it must be sorted).
    pub fn json<T: Serialize + ?Sized>(&mut self, name: impl Into<String>, value: &T) {
        let bytes = serde_json::to_vec(value).expect("plain data serialises");
        self.bytes(name, bytes);
    }

    fn finish(self, ty: &str, format: u32) -> Vec<u8> {
        let mut head = Vec::new();
        let str = |head: &mut Vec<u8>, s: &str| {
            head.extend((s.len() as u32).to_le_bytes());
            head.extend(s.as_bytes());
        };
        head.extend(MAGIC);
        head.extend(CONTAINER.to_le_bytes());
        str(&mut head, ty);
        head.extend(format.to_le_bytes());
        head.extend((self.sections.len() as u32).to_le_bytes());
        let table: usize = self.sections.iter().map(|(n, _)| 4 + n.len() + 16).sum();
        let mut at = (head.len() + table).next_multiple_of(ALIGN);
        for (name, bytes) in &self.sections {
            str(&mut head, name);
            head.extend((at as u64).to_le_bytes());
            head.extend((bytes.len() as u64).to_le_bytes());
            at = (at + bytes.len()).next_multiple_of(ALIGN);
        }
        let mut out = head;
        for (_, bytes) in self.sections {
            out.resize(out.len().next_multiple_of(ALIGN), 0);
            out.extend(bytes);
        }
        out
    }
}

/// Reads an artifact's sections in place.
pub struct Decoder {
    bytes: Bytes,
    sections: Vec<(String, usize, usize)>,
}

impl Decoder {
    fn open(bytes: Bytes, ty: &str, format: u32) -> Result<Self, DecodeError> {
        struct Cursor<'a>(&'a [u8], &'static str);
        impl<'a> Cursor<'a> {
            fn take(&mut self, n: usize) -> Result<&'a [u8], DecodeError> {
                let (head, tail) = self.0.split_at_checked(n).ok_or(DecodeError::Truncated { what: self.1 })?;
                self.0 = tail;
                Ok(head)
            }
            fn u32(&mut self) -> Result<u32, DecodeError> {
                Ok(u32::from_le_bytes(self.take(4)?.try_into().expect("four bytes")))
            }
            fn size(&mut self) -> Result<usize, DecodeError> {
                let v = u64::from_le_bytes(self.take(8)?.try_into().expect("eight bytes"));
                usize::try_from(v).map_err(|_| DecodeError::Truncated { what: self.1 })
            }
            fn str(&mut self) -> Result<&'a str, DecodeError> {
                let n = self.u32()? as usize;
                std::str::from_utf8(self.take(n)?).map_err(|_| DecodeError::Magic)
            }
        }
        let all: &[u8] = (*bytes).as_ref();
        let mut c = Cursor(all, "header");
        if c.take(MAGIC.len())? != MAGIC || c.u32()? != CONTAINER {
            return Err(DecodeError::Magic);
        }
        let (found, version) = (c.str()?, c.u32()?);
        if (found, version) != (ty, format) {
            return Err(DecodeError::Type {
                expected: format!("{ty} v{format}"),
                found: format!("{found} v{version}"),
            });
        }
        let count = c.u32()?;
        let mut sections = Vec::new();
        c.1 = "section table";
        for _ in 0..count {
            let (name, at, len) = (c.str()?, c.size()?, c.size()?);
            if at.checked_add(len).is_none_or(|end| end > all.len()) {
                return Err(DecodeError::section(name, format!("{len} bytes at {at} leave the {} stored", all.len())));
            }
            sections.push((name.to_owned(), at, len));
        }
        Ok(Self { bytes, sections })
    }

    fn find(&self, name: &str) -> Result<(usize, usize), DecodeError> {
        let found = self.sections.iter().find(|(n, ..)| n == name);
        found.map(|(_, at, len)| (*at, *len)).ok_or_else(|| DecodeError::section(name, "missing"))
    }

    /// An array section, read in place.
    pub fn array<T: Pod>(&self, name: &str) -> Result<Array<T>, DecodeError> {
        let (at, len) = self.find(name)?;
        if len % size_of::<T>() != 0 {
            return Err(DecodeError::section(name, format!("{len} bytes are no multiple of {}", size_of::<T>())));
        }
        let count = len / size_of::<T>();
        if let Some(array) = Array::lent(self.bytes.clone(), at, count) {
            return Ok(array);
        }
        // The buffer itself is not aligned: copy.
        Ok(bytemuck::pod_collect_to_vec::<u8, T>(&(*self.bytes).as_ref()[at..at + len]).into())
    }

    pub fn bytes(&self, name: &str) -> Result<&[u8], DecodeError> {
        let (at, len) = self.find(name)?;
        Ok(&(*self.bytes).as_ref()[at..at + len])
    }

    pub fn json<T: DeserializeOwned>(&self, name: &str) -> Result<T, DecodeError> {
        serde_json::from_slice(self.bytes(name)?).map_err(|e| DecodeError::section(name, e.to_string()))
    }
}

/// An artifact's bytes.
pub fn to_bytes<A: Artifact>(value: &A) -> Vec<u8> {
    let mut out = Encoder::default();
    value.encode(&mut out);
    out.finish(A::TYPE, A::FORMAT)
}

/// The artifact that `bytes` hold; arrays stay where they are.
pub fn from_bytes<A: Artifact>(bytes: Bytes) -> Result<A, DecodeError> {
    A::decode(&Decoder::open(bytes, A::TYPE, A::FORMAT)?)
}
