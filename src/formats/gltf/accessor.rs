//! Reading accessors: typed numbers in buffer views, with strides, normalisation and sparse replacements.
//!
//! Nothing is allocated before the accessor's range has been found inside its view and the view inside its buffer.

use super::{FormatError, container::Span, schema};
use std::{ops::Range, path::Path};

/// The document's numbers.
pub(super) struct Numbers<'a> {
    pub file: &'a Path,
    pub root: &'a schema::Root,
    pub buffers: Vec<Span>,
    /// Most elements of an accessor without a view.
    pub implied: u64,
}

/// glTF's component types.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Elements where they lie: element `i` at `i * stride`.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Whether integers are fractions of their type's maximum.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Integers {
    AsTold,
    Fractions,
}

impl Numbers<'_> {
    fn bad(&self, index: u64, what: impl Into<String>) -> FormatError {
        FormatError::invalid(self.file, format!("accessors[{index}]"), what)
    }

    fn accessor(&self, index: u64, from: &str) -> Result<&schema::Accessor, FormatError> {
        let accessors = &self.root.accessors;
        let found = usize::try_from(index).ok().and_then(|i| accessors.get(i));
        let missing = || format!("accessor {index} does not exist; there are {}", accessors.len());
        found.ok_or_else(|| FormatError::invalid(self.file, from, missing()))
    }

    /// How many elements accessor `index` has, according to itself; `from` says who asks.
    pub fn count(&self, index: u64, from: &str) -> Result<u64, FormatError> {
        Ok(self.accessor(index, from)?.count)
    }

    /// Where the bytes of a buffer view lie, and its stride.
    pub fn view(&self, index: u64, from: &str) -> Result<(Span, Option<u64>), FormatError> {
        let (buffer, range, stride) = self.locate(index, from)?;
        Ok((Span { bytes: self.buffers[buffer].bytes.clone(), range }, stride))
    }

    fn locate(&self, index: u64, from: &str) -> Result<(usize, Range<usize>, Option<u64>), FormatError> {
        let views = &self.root.buffer_views;
        let missing = || format!("buffer view {index} does not exist; there are {}", views.len());
        let view = usize::try_from(index).ok().and_then(|i| views.get(i));
        let view = view.ok_or_else(|| FormatError::invalid(self.file, from, missing()))?;
        let bad = |what: String| FormatError::invalid(self.file, format!("bufferViews[{index}]"), what);
        let number = usize::try_from(view.buffer).unwrap_or(usize::MAX);
        let buffer = self.buffers.get(number).ok_or_else(|| bad(format!("buffer {} does not exist", view.buffer)))?;
        let size = buffer.range.len() as u64;
        let end = view.byte_offset.checked_add(view.byte_length).filter(|end| *end <= size);
        let end = end.ok_or_else(|| {
            bad(format!("{} bytes at {} leave the buffer's {size}", view.byte_length, view.byte_offset))
        })?;
        let start = buffer.range.start;
        Ok((number, start + view.byte_offset as usize..start + end as usize, view.byte_stride))
    }

    /// `count` elements of `size` bytes each in a view, from `offset`.
    fn elements(
        &self,
        index: u64,
        view: u64,
        offset: u64,
        count: u64,
        size: usize,
    ) -> Result<Elements<'_>, FormatError> {
        let (buffer, range, stride) = self.locate(view, &format!("accessors[{index}]"))?;
        let stride = stride.unwrap_or(size as u64);
        if !(size as u64..=252).contains(&stride) {
            return Err(self.bad(index, format!("byte stride {stride} for elements of {size} bytes")));
        }
        let have = range.len() as u64;
        let need = match count {
            0 => Some(offset),
            n => (n - 1).checked_mul(stride).and_then(|b| b.checked_add(size as u64)?.checked_add(offset)),
        };
        if need.is_none_or(|need| need > have) {
            let what =
                format!("{count} elements of {size} bytes at {offset} leave the {have} bytes of buffer view {view}");
            return Err(self.bad(index, what));
        }
        let all: &[u8] = (*self.buffers[buffer].bytes).as_ref();
        Ok(Elements { bytes: &all[range][offset as usize..], stride: stride as usize })
    }

    /// The elements of an accessor, of one of the given widths, as vectors; missing components are `fill`.
    pub fn vectors<const N: usize>(
        &self,
        index: u64,
        from: &str,
        widths: &[usize],
        integers: Integers,
        fill: f32,
    ) -> Result<Vec<[f32; N]>, FormatError>
    where
        [f32; N]: bytemuck::Pod,
    {
        let a = self.accessor(index, from)?;
        let (component, width) = self.kind(index, a.component_type, &a.shape)?;
        if !widths.contains(&width) {
            return Err(self.bad(index, format!("{} where {from} needs {widths:?} components", a.shape)));
        }
        let size = component.size() * width;
        let get = component.reader(a.normalized || integers == Integers::Fractions);
        let vector = |bytes: &[u8]| {
            let mut v = [fill; N];
            for (v, b) in v.iter_mut().zip(bytes[..size].chunks_exact(component.size())) {
                *v = get(b);
            }
            v
        };
        let mut out: Vec<[f32; N]> = match a.buffer_view {
            None => {
                let count = self.implied(index, a)?;
                let mut zero = [fill; N];
                zero[..width].fill(0.0);
                vec![zero; count]
            }
            Some(view) => {
                let e = self.elements(index, view, a.byte_offset, a.count, size)?;
                let count = a.count as usize;
                if component == Component::F32 && width == N && e.stride == size {
                    bytemuck::pod_collect_to_vec(&e.bytes[..count * size])
                } else {
                    (0..count).map(|i| vector(&e.bytes[i * e.stride..])).collect()
                }
            }
        };
        self.replace(index, a, size, |i, bytes| out[i] = vector(bytes))?;
        Ok(out)
    }

    /// The elements of an accessor of vertex numbers.
    pub fn indices(&self, index: u64, from: &str) -> Result<Vec<u32>, FormatError> {
        let a = self.accessor(index, from)?;
        let (component, width) = self.kind(index, a.component_type, &a.shape)?;
        let Some(get) = component.index_reader().filter(|_| width == 1) else {
            return Err(self.bad(index, format!("{} of type {} as vertex numbers", a.shape, a.component_type)));
        };
        let size = component.size();
        let mut out = match a.buffer_view {
            None => vec![0; self.implied(index, a)?],
            Some(view) => {
                let e = self.elements(index, view, a.byte_offset, a.count, size)?;
                (0..a.count as usize).map(|i| get(&e.bytes[i * e.stride..])).collect()
            }
        };
        self.replace(index, a, size, |i, bytes| out[i] = get(bytes))?;
        Ok(out)
    }

    fn kind(&self, index: u64, code: u64, shape: &str) -> Result<(Component, usize), FormatError> {
        let component = Component::of(code).ok_or_else(|| self.bad(index, format!("unknown component type {code}")))?;
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            other => return Err(self.bad(index, format!("a {other} where a scalar or vector is needed"))),
        };
        Ok((component, width))
    }

    /// The length of an accessor whose elements are zero because it has no view.
    fn implied(&self, index: u64, a: &schema::Accessor) -> Result<usize, FormatError> {
        if a.count > self.implied {
            let what = format!("{} elements that are not stored; at most {} may be implied", a.count, self.implied);
            return Err(self.bad(index, what));
        }
        Ok(a.count as usize)
    }

    /// Calls `put` with every sparse replacement of an accessor.
    fn replace(
        &self,
        index: u64,
        a: &schema::Accessor,
        size: usize,
        mut put: impl FnMut(usize, &[u8]),
    ) -> Result<(), FormatError> {
        let Some(sparse) = &a.sparse else { return Ok(()) };
        let code = sparse.indices.component_type;
        let component = Component::of(code).and_then(|c| Some((c.size(), c.index_reader()?)));
        let (width, get) = component.ok_or_else(|| self.bad(index, format!("sparse indices of type {code}")))?;
        let at = &sparse.indices;
        let indices = self.elements(index, at.buffer_view, at.byte_offset, sparse.count, width)?;
        let at = &sparse.values;
        let values = self.elements(index, at.buffer_view, at.byte_offset, sparse.count, size)?;
        for i in 0..sparse.count as usize {
            let target = get(&indices.bytes[i * indices.stride..]);
            if target as u64 >= a.count {
                return Err(self.bad(index, format!("sparse index {target} of {} elements", a.count)));
            }
            put(target as usize, &values.bytes[i * values.stride..]);
        }
        Ok(())
    }
}

impl Component {
    /// Reads one number; integers as fractions of their maximum if `normalized` (glTF 2.0, section 3.11).
    fn reader(self, normalized: bool) -> fn(&[u8]) -> f32 {
        match (self, normalized) {
            (Self::I8, true) => |b| (b[0] as i8 as f32 / 127.0).max(-1.0),
            (Self::U8, true) => |b| b[0] as f32 / 255.0,
            (Self::I16, true) => |b| (i16::from_le_bytes([b[0], b[1]]) as f32 / 32767.0).max(-1.0),
            (Self::U16, true) => |b| u16::from_le_bytes([b[0], b[1]]) as f32 / 65535.0,
            (Self::U32, true) => |b| (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f64 / u32::MAX as f64) as f32,
            (Self::I8, false) => |b| b[0] as i8 as f32,
            (Self::U8, false) => |b| b[0] as f32,
            (Self::I16, false) => |b| i16::from_le_bytes([b[0], b[1]]) as f32,
            (Self::U16, false) => |b| u16::from_le_bytes([b[0], b[1]]) as f32,
            (Self::U32, false) => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            (Self::F32, _) => |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }

    /// Reads one vertex number; `None` for types that hold none.
    fn index_reader(self) -> Option<fn(&[u8]) -> u32> {
        Some(match self {
            Self::U8 => |b| b[0] as u32,
            Self::U16 => |b| u16::from_le_bytes([b[0], b[1]]) as u32,
            Self::U32 => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            _ => return None,
        })
    }
}
