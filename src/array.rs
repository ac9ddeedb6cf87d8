//! `Array<T>`: an immutable, cheaply cloned slice that is owned or lies in a file map.
//!
//! It is what lets a decoded artifact be read in place: a clone shares, nothing is copied, and whoever
//! only reads sees a plain `&[T]`.

use bytemuck::Pod;
use std::{fmt, ops::Deref, sync::Arc};

/// Bytes that outlive every slice taken from them: a file map or a buffer.
pub type Bytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// An immutable shared slice of plain values.
#[derive(Clone)]
pub struct Array<T: Pod>(Store<T>);

#[derive(Clone)]
enum Store<T> {
    Owned(Arc<Vec<T>>),
    /// `bytes[start..start + len * size_of::<T>()]`, checked at construction for bounds and alignment.
    Lent {
        bytes: Bytes,
        start: usize,
        len: usize,
    },
}

impl<T: Pod> Array<T> {
    /// A slice of `len` elements that begins `start` bytes into `bytes`.
    /// `None` where it would leave `bytes` or is not aligned for `T`.
    pub fn lent(bytes: Bytes, start: usize, len: usize) -> Option<Self> {
        let size = len.checked_mul(size_of::<T>())?;
        let range = (*bytes).as_ref().get(start..start.checked_add(size)?)?;
        bytemuck::try_cast_slice::<u8, T>(range).ok()?;
        Some(Self(Store::Lent { bytes, start, len }))
    }

    /// The elements `start..start + len`; shares them where this array is lent, copies them where it is owned.
    /// `None` where the range leaves the array.
    pub fn slice(&self, start: usize, len: usize) -> Option<Self> {
        let range = self.get(start..start.checked_add(len)?)?;
        Some(match &self.0 {
            Store::Owned(_) => range.to_vec().into(),
            Store::Lent { bytes, start: base, .. } => {
                Self(Store::Lent { bytes: bytes.clone(), start: base + start * size_of::<T>(), len })
            }
        })
    }

    pub fn as_slice(&self) -> &[T] {
        match &self.0 {
            Store::Owned(v) => v,
            Store::Lent { bytes, start, len } => {
                bytemuck::cast_slice(&(**bytes).as_ref()[*start..*start + *len * size_of::<T>()])
            }
        }
    }

    /// The elements as a vector of their own; copies only where they are shared or lent.
    pub fn into_vec(self) -> Vec<T> {
        match self.0 {
            Store::Owned(v) => Arc::try_unwrap(v).unwrap_or_else(|v| v.to_vec()),
            Store::Lent { .. } => self.as_slice().to_vec(),
        }
    }
}

impl<T: Pod> Deref for Array<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        self.as_slice()
    }
}

impl<T: Pod> From<Vec<T>> for Array<T> {
    fn from(v: Vec<T>) -> Self {
        Self(Store::Owned(Arc::new(v)))
    }
}

impl<T: Pod> FromIterator<T> for Array<T> {
    fn from_iter<I: IntoIterator<Item = T>>(iter: I) -> Self {
        iter.into_iter().collect::<Vec<_>>().into()
    }
}

impl<T: Pod> Default for Array<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T: Pod + PartialEq> PartialEq for Array<T> {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_slice(), f)
    }
}
