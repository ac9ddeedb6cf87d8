//! The body: rows of numbers, in text or in bytes.

use super::{Element, Fault, Header, Kind, Property, header::Encoding};
use crate::{
    formats::text::{number, short},
    math::Stop,
};

/// A cursor over the body.
pub(super) struct Body<'a> {
    rest: &'a [u8],
    stop: &'a Stop,
    encoding: Encoding,
}

impl<'a> Body<'a> {
    pub fn new(rest: &'a [u8], header: &Header, stop: &'a Stop) -> Self {
        Self { rest, stop, encoding: header.encoding }
    }

    /// Fails where `element` cannot fit into what is left, so that its count may be trusted for allocation.
    pub fn expect(&self, element: &Element) -> Result<(), Fault> {
        let least = |p: &Property| match self.encoding {
            Encoding::Ascii => 2,
            _ => p.list.unwrap_or(p.kind).size(),
        };
        // The last number of a text may end without a blank.
        let least: usize = element.properties.iter().map(least).sum();
        let need = element.count.checked_mul(least as u64).map(|n| n.saturating_sub(1));
        let have = self.rest.len() as u64;
        if least > 0 && need.is_some_and(|need| need <= have) {
            return Ok(());
        }
        if least == 0 || element.count == 0 {
            return Ok(());
        }
        let what = format!("truncated: {} elements of at least {least} bytes, {have} bytes left", element.count);
        Err(Fault::At(element.name.clone(), what))
    }

    /// The next number.
    fn number(&mut self, kind: Kind) -> Result<f64, String> {
        if self.encoding == Encoding::Ascii {
            let word = self.word()?;
            let integer = !matches!(kind, Kind::F32 | Kind::F64);
            let value = number(word).ok().filter(|v| !integer || v.fract() == 0.0);
            return value.ok_or_else(|| format!("`{}` is no {kind:?}", short(word)));
        }
        let Some((bytes, rest)) = self.rest.split_at_checked(kind.size()) else { return Err("truncated".into()) };
        self.rest = rest;
        let big = self.encoding == Encoding::Big;
        macro_rules! read {
            ($t:ty) => {{
                let bytes = bytes.try_into().expect("as many bytes as the type has");
                (if big { <$t>::from_be_bytes(bytes) } else { <$t>::from_le_bytes(bytes) }) as f64
            }};
        }
        Ok(match kind {
            Kind::I8 => read!(i8),
            Kind::U8 => read!(u8),
            Kind::I16 => read!(i16),
            Kind::U16 => read!(u16),
            Kind::I32 => read!(i32),
            Kind::U32 => read!(u32),
            Kind::F32 => read!(f32),
            Kind::F64 => read!(f64),
        })
    }

    fn word(&mut self) -> Result<&'a str, String> {
        let rest = self.rest.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            return Err("truncated".into());
        }
        std::str::from_utf8(word).map_err(|_| "not text".into())
    }

    /// The length of a list that is about to follow.
    fn length(&mut self, property: &Property, length: Kind) -> Result<usize, String> {
        let n = self.number(length)?;
        let least = if self.encoding == Encoding::Ascii { 1 } else { property.kind.size() };
        let most = self.rest.len() / least;
        if n.fract() == 0.0 && n >= 0.0 && n <= most as f64 {
            Ok(n as usize)
        } else {
            Err(format!("a list of {n} numbers, {} bytes left", self.rest.len()))
        }
    }

    /// Reads element number `i`: its plain properties into `row`, the items of the list property number `list` into
    /// `items`; what is no vertex number becomes `u32::MAX`. Other lists are skipped.
    pub fn read(
        &mut self,
        element: &Element,
        i: u64,
        row: &mut [f64],
        list: Option<usize>,
        items: &mut Vec<u32>,
    ) -> Result<(), Fault> {
        items.clear();
        self.each(element, i, |at, value| {
            match value {
                Value::Plain(v) => row[at] = v,
                Value::Item(v) if list == Some(at) => {
                    let whole = v.fract() == 0.0 && (0.0..u32::MAX as f64).contains(&v);
                    items.push(if whole { v as u32 } else { u32::MAX });
                }
                Value::Item(_) => {}
            }
            Ok(())
        })
    }

    pub fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        if element.properties.is_empty() {
            return Ok(());
        }
        (0..element.count).try_for_each(|i| self.each(element, i, |_, _| Ok(())))
    }

    /// Calls `take` with the property's number and every value of element number `i`.
    #[inline]
    fn each(
        &mut self,
        element: &Element,
        i: u64,
        mut take: impl FnMut(usize, Value) -> Result<(), String>,
    ) -> Result<(), Fault> {
        if i.is_multiple_of(1 << 16) {
            self.stop.check()?;
        }
        let mut all = || {
            for (at, property) in element.properties.iter().enumerate() {
                match property.list {
                    None => take(at, Value::Plain(self.number(property.kind)?))?,
                    Some(length) => {
                        for _ in 0..self.length(property, length)? {
                            take(at, Value::Item(self.number(property.kind)?))?;
                        }
                    }
                }
            }
            Ok(())
        };
        all().map_err(|what: String| Fault::At(format!("{} {i}", element.name), what))
    }
}

enum Value {
    Plain(f64),
    Item(f64),
}
