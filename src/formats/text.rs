//! Text as exporters write it: UTF-8 with or without a mark, UTF-16, Latin-1; lines that end in LF, CR LF or CR.

use std::borrow::Cow;

/// The text of a file. UTF-16 is told by its byte order mark or by the NULs in its first bytes; lines that are
/// not UTF-8 are read as Latin-1. NUL bytes at the end are padding; elsewhere they are an error, with the line.
pub(super) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, (String, String)> {
    if let [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] = bytes {
        return Err(("line 1".into(), "the text is UTF-32; save it as UTF-8".into()));
    }
    if let Some((rest, read)) = as_utf16(bytes) {
        return utf16(rest, read).map(Cow::Owned);
    }
    let bytes = trim_nul(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    if let Some(at) = bytes.iter().position(|b| *b == 0) {
        return Err((line_of(bytes, at), "a NUL byte; the file is damaged or no text".into()));
    }
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => latin(bytes).into(),
    })
}

fn trim_nul(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |i| i + 1);
    &bytes[..end]
}

fn line_of(bytes: &[u8], at: usize) -> String {
    let ends = (0..at).filter(|i| bytes[*i] == b'\n' || bytes[*i] == b'\r' && bytes.get(i + 1) != Some(&b'\n'));
    format!("line {}", ends.count() + 1)
}

fn utf16(bytes: &[u8], read: fn([u8; 2]) -> u16) -> Result<String, (String, String)> {
    let (pairs, odd) = bytes.as_chunks::<2>();
    let mut out = String::with_capacity(bytes.len() / 2);
    let line = |text: &str| line_of(text.as_bytes(), text.len());
    for c in char::decode_utf16(pairs.iter().map(|p| read(*p))) {
        match c {
            Ok(c) => out.push(c),
            Err(_) => return Err((line(&out), "broken UTF-16; save the file as UTF-8".into())),
        }
    }
    if odd.iter().any(|b| *b != 0) {
        return Err((line(&out), "truncated: half a UTF-16 character at the end".into()));
    }
    let end = out.trim_end_matches('\0').len();
    out.truncate(end);
    match out.find('\0') {
        Some(at) => Err((line_of(out.as_bytes(), at), "a NUL character; the file is damaged or no text".into())),
        None => Ok(out),
    }
}

/// UTF-8 where a line is UTF-8, else Latin-1, so that names keep what tells them apart.
fn latin(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len() + bytes.len() / 8);
    for bytes in bytes.split_inclusive(|b| matches!(b, b'\n' | b'\r')) {
        out.push_str(&line(bytes));
    }
    out
}

/// One line: UTF-8, else Latin-1.
pub(super) fn line(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(line) => line.into(),
        Err(_) => bytes.iter().map(|b| *b as char).collect::<String>().into(),
    }
}

/// The characters of UTF-16 and their byte order, by the mark or by a NUL in every other of the first bytes.
fn as_utf16(bytes: &[u8]) -> Option<(&[u8], fn([u8; 2]) -> u16)> {
    match *bytes {
        [0xff, 0xfe, ..] => Some((&bytes[2..], u16::from_le_bytes)),
        [0xfe, 0xff, ..] => Some((&bytes[2..], u16::from_be_bytes)),
        [a, 0, b, 0, ..] if a != 0 && b != 0 => Some((bytes, u16::from_le_bytes)),
        [0, a, 0, b, ..] if a != 0 && b != 0 => Some((bytes, u16::from_be_bytes)),
        _ => None,
    }
}

/// Whether text is UTF-16.
pub(super) fn is_utf16(bytes: &[u8]) -> bool {
    as_utf16(bytes).is_some()
}

/// Lines with their numbers, from 1. A line ends in LF, CR LF or CR.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text);
    let lines = std::iter::from_fn(move || {
        let all = rest.filter(|r| !r.is_empty())?;
        match all.find(['\n', '\r']) {
            Some(end) => {
                let eol = if all[end..].starts_with("\r\n") { 2 } else { 1 };
                rest = Some(&all[end + eol..]);
                Some(&all[..end])
            }
            None => rest.take(),
        }
    });
    (1..).zip(lines)
}

/// [`lines`] where a backslash before the end continues a line, blanks after it or not; a comment is never continued.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut all = lines(text);
    std::iter::from_fn(move || {
        let (number, first) = all.next()?;
        let mut line = Cow::Borrowed(first);
        let mut from = 0;
        while let Some(end) = continued(&line, from) {
            let mut whole = line.into_owned();
            whole.truncate(end);
            whole.push(' ');
            from = whole.len();
            let more = all.next();
            whole.push_str(more.map_or("", |(_, more)| more));
            line = whole.into();
            if more.is_none() {
                break;
            }
        }
        Some((number, line))
    })
}

/// Where the backslash stands that continues the line; the part before `from` holds no comment.
fn continued(line: &str, from: usize) -> Option<usize> {
    let part = &line[from..];
    let head = part.trim_end_matches(|c: char| c.is_ascii() && blank(c as u8)).strip_suffix('\\')?;
    comment(head).is_none().then_some(from + head.len())
}

/// Where a comment begins: at a `#` that begins the line or follows a blank.
pub(super) fn comment(line: &str) -> Option<usize> {
    line.bytes().enumerate().position(|(i, b)| b == b'#' && (i == 0 || blank(line.as_bytes()[i - 1])))
}

fn blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0b | 0x0c)
}

/// Without the blanks at both ends; a no-break space is no blank, it may be part of a name.
pub(super) fn trim(text: &str) -> &str {
    text.trim_matches(|c: char| c.is_ascii() && blank(c as u8))
}

/// Words between blanks.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_ascii() && blank(c as u8)).filter(|w| !w.is_empty())
}

/// The first word, and what follows it.
pub(super) fn word(text: &str) -> (&str, &str) {
    let text = trim(text);
    match text.find(|c: char| c.is_ascii() && blank(c as u8)) {
        Some(end) => (&text[..end], trim(&text[end..])),
        None => (text, ""),
    }
}

/// A number; the words by which C libraries write what is no finite number give NaN.
pub(super) fn number(word: &str) -> Result<f64, String> {
    word.parse().or_else(|_| {
        let rest = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
        match ["nan", "inf", "1.#"].iter().any(|start| rest.starts_with(start)) {
            true => Ok(f64::NAN),
            false => Err(format!("`{}` is no number", short(word))),
        }
    })
}

/// The beginning of a word, for messages.
pub(super) fn short(word: &str) -> String {
    word.chars().take(40).collect()
}

/// `text` without the quotes around it.
pub(super) fn unquote(text: &str) -> &str {
    let inner = |q: char| text.strip_prefix(q).and_then(|t| t.strip_suffix(q)).filter(|t| !t.contains(q));
    inner('"').or_else(|| inner('\'')).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> String {
        decode(bytes).unwrap().into_owned()
    }

    fn wide(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "v 1 2 3\nusemtl Tête 😀\n";
        assert_eq!(read(text.as_bytes()), text);
        assert_eq!(read(format!("\u{feff}{text}").as_bytes()), text);
        for bytes in [u16::to_le_bytes as fn(u16) -> [u8; 2], u16::to_be_bytes] {
            assert_eq!(read(&wide(&format!("\u{feff}{text}"), bytes)), text);
            assert_eq!(read(&wide(text, bytes)), text);
            assert_eq!(read(&wide(&format!("{text}\0\0"), bytes)), text);
        }
        assert_eq!(read(b"o T\xeate\nusemtl T\xc3\xaate\n\0\0"), "o Tête\nusemtl Tête\n");
    }

    #[test]
    fn what_is_no_text_is_refused_by_name() {
        let error = |bytes: &[u8]| decode(bytes).unwrap_err();
        assert_eq!(error(b"v 1\r\nv 2\rv \0 3\n").0, "line 3");
        assert!(error(b"\xff\xfe\0\0v\0\0\0").1.contains("UTF-32"));
        assert!(error(b"\xff\xfev\0\x00\xd8v\0").1.contains("broken UTF-16"));
        assert!(error(b"\xff\xfev\0v").1.contains("truncated"));
        assert!(error(b"\xff\xfev\0\n\0\0\0v\0").1.contains("NUL"));
    }

    #[test]
    fn lines_end_in_any_way() {
        let all: Vec<_> = lines("a\nb\r\nc\rd\r\n\ne").collect();
        assert_eq!(all, [(1, "a"), (2, "b"), (3, "c"), (4, "d"), (5, ""), (6, "e")]);
    }

    #[test]
    fn continued_lines_and_comments() {
        let all: Vec<_> = statements("f 1 \\ \t\n2 \\\r\n3\n# c:\\dir\\\nv 1 # to\\\nv 2\\\n").collect();
        let all: Vec<_> = all.iter().map(|(n, l)| (*n, l.as_ref())).collect();
        assert_eq!(all, [(1, "f 1  2  3"), (4, "# c:\\dir\\"), (5, "v 1 # to\\"), (6, "v 2 ")]);
    }

    #[test]
    fn numbers_that_are_not_finite() {
        for word in ["nan", "-nan(ind)", "1.#QNAN", "-1.#IND00", "+inf", "Infinity"] {
            assert!(!number(word).unwrap().is_finite(), "{word}");
        }
        assert_eq!(number("1e2"), Ok(100.0));
        assert_eq!(number("one"), Err("`one` is no number".into()));
    }

    #[test]
    fn words_quotes_and_comments() {
        assert_eq!(word("\tmap_Kd \t a b.png "), ("map_Kd", "a b.png"));
        assert_eq!(words(" a\u{a0}b\tc ").collect::<Vec<_>>(), ["a\u{a0}b", "c"]);
        assert_eq!(
            [unquote("\"a b\""), unquote("'a'"), unquote("\"a\" \"b\""), unquote("\"")],
            ["a b", "a", "\"a\" \"b\"", "\""]
        );
        assert_eq!([comment("#a"), comment("wood#1"), comment("a\t#1")], [Some(0), None, Some(2)]);
    }
}
