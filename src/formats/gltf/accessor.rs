//! Reading accessors: typed numbers in buffer views, with strides, normalisation and sparse replacements.
//!
//! Nothing is allocated before the accessor's range has been found inside its view and the view inside its buffer.

use super::{FormatError, container::Span, meshopt, schema};
use std::{
    cell::{Cell, OnceCell},
    path::Path,
    sync::Arc,
};

/// The document's numbers.
pub(super) struct Numbers<'a> {
    pub file: &'a Path,
    pub root: &'a schema::Root,
    /// `None` for a buffer without bytes, which only compressed views may name.
    pub buffers: Vec<Option<Span>>,
    /// Most elements of an accessor without a view.
    pub implied: u64,
    /// Decompressed views.
    decoded: Vec<OnceCell<Span>>,
    /// Bytes that decompressed views may still take.
    room: Cell<u64>,
}

/// What an accessor is read as.
#[derive(Clone, Copy)]
pub(super) struct Want<'a> {
    /// Who asks.
    pub from: &'a str,
    /// Components that an element may have.
    pub widths: &'a [usize],
    pub integers: Integers,
    /// Stands for missing components.
    pub fill: f32,
    /// Elements that are known to be stored elsewhere: as many may be implied.
    pub known: u64,
}

impl<'a> Want<'a> {
    pub fn new(from: &'a str, widths: &'a [usize]) -> Self {
        Self { from, widths, integers: Integers::AsTold, fill: 0.0, known: 0 }
    }
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
struct Elements {
    span: Span,
    stride: usize,
}

impl Elements {
    fn bytes(&self) -> &[u8] {
        self.span.get()
    }
}

/// Whether integers are fractions of their type's maximum.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Integers {
    AsTold,
    Fractions,
}

impl<'a> Numbers<'a> {
    /// `bytes`: what decompressed views may take in all.
    pub fn new(file: &'a Path, root: &'a schema::Root, buffers: Vec<Option<Span>>, implied: u64, bytes: u64) -> Self {
        let decoded = root.buffer_views.iter().map(|_| OnceCell::new()).collect();
        Self { file, root, buffers, implied, decoded, room: Cell::new(bytes) }
    }

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

    /// Whether the file stores elements of accessor `index`, instead of implying zeros.
    pub fn stored(&self, index: u64, from: &str) -> Result<bool, FormatError> {
        let accessor = self.accessor(index, from)?;
        Ok(accessor.buffer_view.is_some() || accessor.sparse.is_some())
    }

    /// Where the bytes of a buffer view lie, and its stride. A compressed view is decompressed the first time.
    pub fn view(&self, index: u64, from: &str) -> Result<(Span, Option<u64>), FormatError> {
        let views = &self.root.buffer_views;
        let missing = || format!("buffer view {index} does not exist; there are {}", views.len());
        let at = usize::try_from(index).ok().filter(|i| *i < views.len());
        let at = at.ok_or_else(|| FormatError::invalid(self.file, from, missing()))?;
        let view = &views[at];
        let Some(packed) = view.extensions.meshopt.as_ref().or(view.extensions.khr_meshopt.as_ref()) else {
            let span = self.range(index, view.buffer, view.byte_offset, view.byte_length)?;
            return Ok((span, view.byte_stride));
        };
        let stride = Some(packed.byte_stride);
        if let Some(span) = self.decoded[at].get() {
            return Ok((span.clone(), stride));
        }
        let encoded = self.range(index, packed.buffer, packed.byte_offset, packed.byte_length)?;
        let bytes = meshopt::decode(packed, encoded.get(), self.room.get());
        let bytes = bytes.map_err(|what| FormatError::invalid(self.file, format!("bufferViews[{index}]"), what))?;
        self.room.set(self.room.get() - bytes.len() as u64);
        let span = Span::whole(Arc::new(bytes));
        Ok((self.decoded[at].get_or_init(|| span).clone(), stride))
    }

    /// Bytes of a buffer, for view `index`.
    fn range(&self, index: u64, buffer: u64, offset: u64, length: u64) -> Result<Span, FormatError> {
        let bad = |what: String| FormatError::invalid(self.file, format!("bufferViews[{index}]"), what);
        let number = usize::try_from(buffer).unwrap_or(usize::MAX);
        let all = self.buffers.get(number).ok_or_else(|| bad(format!("buffer {buffer} does not exist")))?;
        let all = all.as_ref().ok_or_else(|| {
            bad(format!("buffer {buffer} has neither a URI nor a binary chunk, and the view is not compressed"))
        })?;
        let size = all.range.len() as u64;
        let end = offset.checked_add(length).filter(|end| *end <= size);
        let end = end.ok_or_else(|| bad(format!("{length} bytes at {offset} leave the buffer's {size}")))?;
        let start = all.range.start;
        Ok(Span { bytes: all.bytes.clone(), range: start + offset as usize..start + end as usize })
    }

    /// `count` elements of `size` bytes each in a view, from `offset`.
    fn elements(&self, index: u64, view: u64, offset: u64, count: u64, size: usize) -> Result<Elements, FormatError> {
        let (span, stride) = self.view(view, &format!("accessors[{index}]"))?;
        let stride = stride.unwrap_or(size as u64);
        if !(size as u64..=256).contains(&stride) {
            return Err(self.bad(index, format!("byte stride {stride} for elements of {size} bytes")));
        }
        let have = span.range.len() as u64;
        let need = match count {
            0 => Some(offset),
            n => (n - 1).checked_mul(stride).and_then(|b| b.checked_add(size as u64)?.checked_add(offset)),
        };
        if need.is_none_or(|need| need > have) {
            let what =
                format!("{count} elements of {size} bytes at {offset} leave the {have} bytes of buffer view {view}");
            return Err(self.bad(index, what));
        }
        let range = span.range.start + offset as usize..span.range.end;
        Ok(Elements { span: Span { bytes: span.bytes, range }, stride: stride as usize })
    }

    /// The elements of an accessor, of one of the given widths, as vectors; missing components are `fill`.
    pub fn vectors<const N: usize>(&self, index: u64, want: &Want) -> Result<Vec<[f32; N]>, FormatError>
    where
        [f32; N]: bytemuck::Pod,
    {
        let Want { from, widths, integers, fill, known } = *want;
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
                let count = self.implied(index, a, known)?;
                let mut zero = [fill; N];
                zero[..width].fill(0.0);
                vec![zero; count]
            }
            Some(view) => {
                let e = self.elements(index, view, a.byte_offset, a.count, size)?;
                let (count, bytes) = (a.count as usize, e.bytes());
                if component == Component::F32 && width == N && e.stride == size {
                    bytemuck::pod_collect_to_vec(&bytes[..count * size])
                } else {
                    (0..count).map(|i| vector(&bytes[i * e.stride..])).collect()
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
            None => vec![0; self.implied(index, a, 0)?],
            Some(view) => {
                let e = self.elements(index, view, a.byte_offset, a.count, size)?;
                let bytes = e.bytes();
                (0..a.count as usize).map(|i| get(&bytes[i * e.stride..])).collect()
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
            "MAT4" => 16,
            other => {
                return Err(self.bad(index, format!("a {other} where a scalar, a vector or a 4 × 4 matrix is needed")));
            }
        };
        Ok((component, width))
    }

    /// The length of an accessor whose elements are zero because it has no view.
    fn implied(&self, index: u64, a: &schema::Accessor, known: u64) -> Result<usize, FormatError> {
        if a.count > self.implied.max(known) {
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
            let target = get(&indices.bytes()[i * indices.stride..]);
            if target as u64 >= a.count {
                return Err(self.bad(index, format!("sparse index {target} of {} elements", a.count)));
            }
            put(target as usize, &values.bytes()[i * values.stride..]);
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
