//! The header: byte order, elements and their properties.

use crate::formats::{colors::full_scale, text};

/// Where, and what is wrong there.
type Fault = (String, String);

/// Types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
    /// The type of a list's length.
    pub list: Option<Kind>,
}

pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Names in comments `TextureFile NAME`, which MeshLab and others write.
    pub textures: Vec<String>,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What stands for 1 in channels of this type whose greatest value is `greatest`. Whole numbers count to the
    /// type's end, or, where none is larger, to 255 or 65535.
    pub fn full_scale(self, (greatest, whole): (f64, bool)) -> f64 {
        let own = match self {
            Self::F32 | Self::F64 => return full_scale(greatest, whole),
            Self::I8 | Self::U8 => return 255.0,
            Self::I16 => i16::MAX as f64,
            Self::U16 => u16::MAX as f64,
            Self::I32 => i32::MAX as f64,
            Self::U32 => u32::MAX as f64,
        };
        [255.0, 65535.0].into_iter().find(|s| *s < own && greatest <= *s).unwrap_or(own)
    }
}

/// The header, and where the body begins.
pub(super) fn parse(bytes: &[u8]) -> Result<(Header, usize), Fault> {
    // Lines end as the first one does: LF, CR LF, or CR alone.
    let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'));
    let eol = first.map_or(b'\n', |at| if bytes[at..].starts_with(b"\r\n") { b'\n' } else { bytes[at] });
    let mut at = 0;
    let mut number = 0;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut textures = Vec::new();
    loop {
        number += 1;
        let fault = |what: String| (format!("header line {number}"), what);
        let rest = &bytes[at..];
        let end = rest.iter().position(|b| *b == eol).ok_or_else(|| fault("truncated: no end_header".into()))?;
        at += end + 1;
        let line = text::line(&rest[..end]);
        let line = line.trim();
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(fault("not a PLY file: it does not begin with `ply`".into())),
            ["format", kind, _] => {
                encoding = Some(match kind {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(fault(format!("unknown format `{kind}`"))),
                })
            }
            ["comment", "TextureFile", ref name @ ..] => textures.push(name.join(" ")),
            ["comment", ..] | ["obj_info", ..] | [] => {}
            ["element", name, count] => {
                let count = count.parse().map_err(|_| fault(format!("`{count}` is no count")))?;
                if elements.iter().any(|e| e.name == name) {
                    return Err(fault(format!("element `{name}` twice")));
                }
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref what @ ..] => {
                let kind = |name: &str| Kind::of(name).ok_or_else(|| fault(format!("unknown type `{name}`")));
                let property = match *what {
                    ["list", length, value, name] => {
                        Property { name: name.to_owned(), kind: kind(value)?, list: Some(kind(length)?) }
                    }
                    [value, name] => Property { name: name.to_owned(), kind: kind(value)?, list: None },
                    _ => return Err(fault(format!("cannot read `{}`", text::short(line)))),
                };
                let element = elements.last_mut().ok_or_else(|| fault("a property before any element".into()))?;
                element.properties.push(property);
            }
            ["end_header"] => break,
            _ => return Err(fault(format!("cannot read `{}`", text::short(line)))),
        }
    }
    let encoding = encoding.ok_or_else(|| ("header".to_owned(), "no format".to_owned()))?;
    Ok((Header { encoding, elements, textures }, at))
}
