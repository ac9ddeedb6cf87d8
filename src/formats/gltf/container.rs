//! GLB's chunks, URIs and base64.

use super::FormatError;
use crate::array::Bytes;
use std::{ops::Range, path::Path};

/// Bytes within a larger buffer.
#[derive(Clone)]
pub(super) struct Span {
    pub bytes: Bytes,
    pub range: Range<usize>,
}

impl Span {
    pub fn whole(bytes: Bytes) -> Self {
        let range = 0..(*bytes).as_ref().len();
        Self { bytes, range }
    }

    pub fn get(&self) -> &[u8] {
        &(*self.bytes).as_ref()[self.range.clone()]
    }
}

/// The JSON chunk and the first binary chunk of a GLB. What viewers read in spite of it is no error but a warning: a wrong length in
/// the header, chunks that are not padded, bytes after the last chunk.
pub(super) fn split(
    file: &Path,
    all: &Bytes,
    warn: &mut dyn FnMut(String),
) -> Result<(Span, Option<Span>), FormatError> {
    let bytes: &[u8] = (**all).as_ref();
    let bad = |place: &str, what: String| FormatError::invalid(file, place, what);
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes(b.try_into().expect("four bytes")));
    let header = "GLB header";
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(bad(header, format!("truncated: {} of 12 bytes", bytes.len())));
    };
    if version != 2 {
        return Err(bad(header, format!("version {version}; only version 2 can be read")));
    }
    let end = length as usize;
    if end > bytes.len() {
        return Err(bad(header, format!("truncated: it says {end} bytes, the file has {}", bytes.len())));
    }
    let (mut json, mut binary, mut at) = (None, None, 12usize);
    while at < end {
        let place = format!("GLB chunk at byte {at}");
        let rest = &bytes[at..end];
        let (Some(size), Some(kind)) = (word(at).filter(|_| rest.len() >= 8), word(at + 4)) else {
            if json.is_none() {
                return Err(bad(&place, "truncated".into()));
            }
            if rest.iter().any(|b| *b != 0) {
                warn(format!("{place}: {} bytes after the last chunk; left out", rest.len()));
            }
            break;
        };
        let known = matches!(&kind.to_le_bytes(), b"JSON" | b"BIN\0");
        if json.is_some() && !known && rest.iter().all(|b| *b == 0) {
            // Padding of the whole file.
            break;
        }
        let start = at + 8;
        // The header's length is wrong where a chunk needs more and the file has it.
        let have = if known { bytes.len() } else { end };
        let stop = start.checked_add(size as usize).filter(|stop| *stop <= have);
        let Some(stop) = stop else {
            if json.is_some() && !known {
                warn(format!("{place}: {} bytes after the last chunk; left out", rest.len()));
                break;
            }
            return Err(bad(&place, format!("{size} bytes leave the file's {have}")));
        };
        if stop > end {
            warn(format!("GLB header: it says {end} bytes, the chunks have more; read by the chunks"));
        }
        let span = Span { bytes: all.clone(), range: start..stop };
        match (&kind.to_le_bytes(), &json) {
            (b"JSON", None) => json = Some(span),
            (b"BIN\0", Some(_)) if binary.is_none() => binary = Some(span),
            (_, None) => return Err(bad(&place, "the first chunk must be JSON".into())),
            // Chunks of unknown kinds are to be skipped.
            _ => {}
        }
        let follows = |at: usize| word(at + 4).is_some_and(|k| matches!(&k.to_le_bytes(), b"JSON" | b"BIN\0"));
        at = stop.next_multiple_of(4);
        if at != stop && follows(stop) && !follows(at) {
            warn(format!("{place}: not padded to a multiple of four bytes"));
            at = stop;
        }
    }
    Ok((json.ok_or_else(|| bad(header, "no JSON chunk".into()))?, binary))
}

/// The JSON text of a chunk or file: without byte order mark and without the zeros that some exporters pad with.
pub(super) fn text(bytes: &[u8]) -> Result<&str, String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("UTF-16; JSON is UTF-8: save the file as UTF-8".into());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |i| i + 1);
    let text = std::str::from_utf8(&bytes[..end]);
    text.map_err(|e| format!("not UTF-8 after byte {}: save the file as UTF-8", e.valid_up_to()))
}

/// What a URI stands for.
pub(super) enum Target {
    Data(Vec<u8>),
    /// A path relative to the file.
    File(String),
}

pub(super) fn target(uri: &str) -> Result<Target, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (head, body) = data.split_once(',').ok_or("data URI without a comma")?;
        if !head.ends_with(";base64") {
            return Err("data URI that is not base64".into());
        }
        return Ok(Target::Data(base64(body)?));
    }
    if uri.contains("://") {
        return Err(format!("`{uri}` is no file"));
    }
    Ok(Target::File(unescape(uri)?))
}

/// Standard base64 with or without padding.
fn base64(text: &str) -> Result<Vec<u8>, String> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for (i, quad) in text.chunks(4).enumerate() {
        let mut word = 0u32;
        for (j, c) in quad.iter().enumerate() {
            let six = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return Err(format!("byte {} is not base64", i * 4 + j)),
            };
            word |= (six as u32) << (18 - 6 * j);
        }
        match quad.len() {
            1 => return Err("base64 ends in the middle of a byte".into()),
            n => out.extend(&word.to_be_bytes()[1..n]),
        }
    }
    Ok(out)
}

/// Resolves `%20` and its like.
fn unescape(uri: &str) -> Result<String, String> {
    let bad = || format!("`{uri}` is no valid URI");
    let mut out = Vec::with_capacity(uri.len());
    let mut bytes = uri.bytes();
    while let Some(b) = bytes.next() {
        if b == b'%' {
            let mut digit = || bytes.next().and_then(|b| (b as char).to_digit(16)).ok_or_else(bad);
            out.push((digit()? * 16 + digit()?) as u8);
        } else {
            out.push(b);
        }
    }
    String::from_utf8(out).map_err(|_| bad())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_every_length() {
        assert_eq!(base64("").unwrap(), b"");
        assert_eq!(base64("Zg==").unwrap(), b"f");
        assert_eq!(base64("Zm8=").unwrap(), b"fo");
        assert_eq!(base64("Zm9v").unwrap(), b"foo");
        assert_eq!(base64("Zm9vYg").unwrap(), b"foob");
        assert!(base64("Zm9vY").is_err());
        assert!(base64("Zm 9").is_err());
    }

    #[test]
    fn uris() {
        assert_eq!(unescape("a%20b%C3%A9").unwrap(), "a bé");
        assert!(unescape("a%2").is_err());
        assert!(unescape("%ff").is_err());
        assert!(target("https://x/y.png").is_err());
    }
}
