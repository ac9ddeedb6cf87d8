//! Wavefront OBJ with MTL: an object for every `o` or `g` that has faces, a part for every material in it.
//!
//! Own reader: `tobj` names no line in its errors and cuts words inside a character. Vertices with equal numbers of
//! position, texture coordinate and normal become one. Texture coordinates have v up in the file. Colours of vertices
//! (`v x y z r g b`) and of materials are sRGB, as viewers show them. Keywords count in any case.
//!
//! A face that cannot be shown is left out and counted in a warning: one that names a vertex that does not exist, one
//! with a corner that is no finite number, one without area. Text that cannot be read is an error with its line.

mod build;
mod library;
mod mtl;
mod paths;
mod shape;

use super::{
    FormatError,
    loader::Loader,
    polygon::MOST_CORNERS,
    text::{self, number, short, trim, unquote, word, words},
};
use crate::{array::Bytes, scene::Object};
use shape::{ABSENT, BEYOND, Corner, Shapes};
use std::path::Path;

/// The numbers of a file, as faces refer to them.
#[derive(Default)]
struct Pool {
    positions: Vec<[f64; 3]>,
    /// Red, green, blue and opacity as they are written; as long as the positions, or empty while no vertex has had a
    /// colour. What is NaN is not written.
    colors: Vec<[f32; 4]>,
    uv: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
}

/// The colour of a vertex without one, beside others that have one.
const NO_COLOR: [f32; 4] = [f32::NAN; 4];

pub(super) fn read(loader: &mut Loader, file: &Path, bytes: Bytes) -> Result<Vec<Object>, FormatError> {
    let text = text::decode((*bytes).as_ref()).map_err(|(at, what)| FormatError::invalid(file, at, what))?;
    let mut pool = Pool::default();
    let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mut shapes = Shapes::new(stem);
    let mut libraries = Vec::new();
    let mut corners = Vec::new();
    let mut skipped = 0u64;
    for (number, line) in text::statements(&text) {
        if number % 4096 == 0 {
            loader.stop.check()?;
        }
        let bad = |what: String| FormatError::invalid(file, format!("line {number}"), what);
        let (key, rest) = word(&line);
        let mut buffer = [0; 8];
        match lower(key, &mut buffer) {
            "v" => {
                loader.count_vertices(file, "v", 1)?;
                let (xyz, color) = vertex(plain(rest)).map_err(bad)?;
                if color.is_some() && pool.colors.is_empty() {
                    pool.colors = vec![NO_COLOR; pool.positions.len()];
                }
                pool.positions.push(xyz);
                if !pool.colors.is_empty() || color.is_some() {
                    pool.colors.push(color.unwrap_or(NO_COLOR));
                }
            }
            "vt" => {
                let [u, v] = numbers::<2>(plain(rest), &[0.0]).map_err(bad)?;
                pool.uv.push([u as f32, (1.0 - v) as f32]);
            }
            "vn" => pool.normals.push(numbers::<3>(plain(rest), &[]).map_err(bad)?.map(|v| v as f32)),
            "f" | "fo" => {
                let counts = [pool.positions.len(), pool.uv.len(), pool.normals.len()];
                corners.clear();
                for word in words(plain(rest)) {
                    corners.push(corner(word, counts).map_err(bad)?);
                }
                if corners.len() > MOST_CORNERS {
                    return Err(bad(format!("a face of {} corners; at most {MOST_CORNERS} are read", corners.len())));
                }
                shapes.face(number, &corners);
            }
            "o" | "g" => shapes.name(unquote(heading(rest))),
            "usemtl" => shapes.material(unquote(rest)),
            "mtllib" if !rest.is_empty() => libraries.push((number, rest.to_owned())),
            "p" | "l" | "curv" | "curv2" | "surf" => skipped += 1,
            // Smoothing groups, and what else is no geometry.
            _ => {}
        }
    }
    if skipped > 0 {
        loader.warn(file, format!("{skipped} points, lines and curves are left out"));
    }
    let shapes = shapes.finish();
    let used = shapes.iter().map(|(_, material, _)| material.as_str()).collect();
    let materials = library::materials(loader, file, &libraries, &used)?;
    build::objects(loader, file, &pool, shapes, &materials)
}

/// `word` in lower case; a word longer than every keyword comes back empty.
fn lower<'a, const N: usize>(word: &str, buffer: &'a mut [u8; N]) -> &'a str {
    let Some(room) = buffer.get_mut(..word.len()) else { return "" };
    room.copy_from_slice(word.as_bytes());
    room.make_ascii_lowercase();
    std::str::from_utf8(room).unwrap_or_default()
}

/// Numbers without the comment after them.
fn plain(rest: &str) -> &str {
    rest.split('#').next().unwrap_or_default()
}

/// A name without the comment after it: ` # comment` is one, the number in `Box #12` is none.
fn heading(rest: &str) -> &str {
    let is_comment = |at: &usize| rest[at + 1..].is_empty() || rest[at + 1..].starts_with([' ', '\t']);
    let mut from = 0;
    while let Some(at) = text::comment(&rest[from..]).map(|at| from + at) {
        if is_comment(&at) {
            return trim(&rest[..at]);
        }
        from = at + 1;
    }
    rest
}

/// `N` numbers; the last ones may be missing where `defaults` has them.
fn numbers<const N: usize>(text: &str, defaults: &[f64]) -> Result<[f64; N], String> {
    let mut out = [0.0; N];
    let mut words = words(text);
    for (i, v) in out.iter_mut().enumerate() {
        *v = match words.next() {
            Some(word) => number(word)?,
            None => match defaults.len().checked_sub(N - i) {
                Some(k) => defaults[k],
                None => return Err(format!("{i} numbers where {N} are needed")),
            },
        };
    }
    Ok(out)
}

/// `x y z`, `x y z w`, `x y z r g b` or `x y z r g b a`.
fn vertex(text: &str) -> Result<([f64; 3], Option<[f32; 4]>), String> {
    let xyz = numbers::<3>(text, &[])?;
    if words(text).nth(5).is_none() {
        return Ok((xyz, None));
    }
    let [_, _, _, rgba @ ..] = numbers::<7>(text, &[f64::NAN])?;
    Ok((xyz, Some(rgba.map(|c| c as f32))))
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`; numbers count from 1, negative ones back from the last so far.
fn corner(word: &str, counts: [usize; 3]) -> Result<Corner, String> {
    let wrong = || format!("`{}` is no corner of a face", short(word));
    let mut out = [ABSENT; 3];
    let mut fields = word.split('/');
    for (slot, count) in out.iter_mut().zip(counts) {
        let Some(field) = fields.next().filter(|f| !f.is_empty()) else { continue };
        let n: i64 = field.parse().map_err(|_| wrong())?;
        let at = if n > 0 { n - 1 } else { n.saturating_add(count as i64) };
        // 0 names nothing.
        let at = if n == 0 { BEYOND } else { u32::try_from(at).unwrap_or(BEYOND) };
        *slot = at.min(BEYOND);
    }
    if out[0] == ABSENT || fields.next().is_some() { Err(wrong()) } else { Ok(out) }
}
