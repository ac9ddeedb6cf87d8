//! Scene TOML: places other files, as often as one likes.
//!
//! ```toml
//! [[place]]
//! file       = "house.glb"          # relative to this file; also another scene TOML
//! name       = "north"              # before the names of the file's objects; default: the file's name
//! translate  = [10.0, 0.0, -3.5]    # metres
//! rotate_deg = [0.0, 90.0, 0.0]     # about the fixed axes X, then Y, then Z; or quaternion = [x, y, z, w]
//! scale      = 2.0                  # or [x, y, z]
//! ```
//!
//! Order: scale, rotate, translate. A file placed twice is read once and shares its meshes.

use super::{FormatError, loader::Loader};
use crate::{array::Bytes, scene::Object};
use glam::{DMat4, DQuat, DVec3};
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    place: Vec<Spanned<PlacedFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlacedFile {
    file: Spanned<String>,
    name: Option<Spanned<String>>,
    translate: Option<[f64; 3]>,
    rotate_deg: Option<[f64; 3]>,
    quaternion: Option<Spanned<[f64; 4]>>,
    scale: Option<Spanned<toml::Value>>,
}

pub(super) fn read(loader: &mut Loader, file: &Path, bytes: Bytes) -> Result<Vec<Object>, FormatError> {
    let text = std::str::from_utf8((*bytes).as_ref())
        .map_err(|e| FormatError::invalid(file, "scene TOML", format!("not UTF-8 after byte {}", e.valid_up_to())))?;
    let document: Document = toml::from_str(text).map_err(|e| {
        let place = e.span().map_or_else(|| "scene TOML".into(), |s| position(text, s.start));
        FormatError::invalid(file, place, e.message().to_owned())
    })?;
    if loader.includes() > loader.limits.includes as usize {
        let what = format!("more than {} scene files include each other", loader.limits.includes);
        return Err(FormatError::invalid(file, "scene TOML", what));
    }
    let mut out = Vec::new();
    for place in &document.place {
        let at = place.span().start;
        let place = place.as_ref();
        let bad = |start: usize, what: String| FormatError::invalid(file, position(text, start), what);
        let own = transform(place).map_err(|(start, what)| bad(start.unwrap_or(at), what))?;
        let target = place.file.as_ref();
        let path = loader.resolve(file, target)?;
        let objects = loader.objects(&path).map_err(|e| match e {
            FormatError::Missing { file } => bad(place.file.span().start, format!("{}: no such file", file.display())),
            e => e,
        })?;
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let prefix = place.name.as_ref().map_or(stem.as_str(), |n| n.as_ref().as_str());
        if prefix.is_empty() {
            return Err(bad(at, "an empty name".into()));
        }
        for object in objects {
            // A file of one unnamed thing, such as a PLY, is that thing.
            let name = if object.name == stem { prefix.to_owned() } else { format!("{prefix}/{}", object.name) };
            if name.len() as u64 > loader.limits.name {
                return Err(bad(at, format!("a name of {} bytes; the limit is {}", name.len(), loader.limits.name)));
            }
            let transform = (own * object.transform.as_dmat4()).as_mat4();
            if !transform.is_finite() {
                return Err(bad(at, format!("the transform of `{name}` is not finite")));
            }
            loader.count_object(file, &name, object.triangle_count() as u64)?;
            out.push(Object { name, transform, parts: object.parts });
        }
    }
    Ok(out)
}

/// Line and column, from 1.
fn position(text: &str, at: usize) -> String {
    let before = &text.as_bytes()[..at.min(text.len())];
    let line = before.iter().filter(|b| **b == b'\n').count() + 1;
    let column = before.iter().rev().take_while(|b| **b != b'\n').count() + 1;
    format!("line {line}, column {column}")
}

fn transform(place: &PlacedFile) -> Result<DMat4, (Option<usize>, String)> {
    let finite = |name: &str, v: &[f64]| match v.iter().find(|v| !v.is_finite()) {
        Some(v) => Err((None, format!("{name}: {v} is not finite"))),
        None => Ok(()),
    };
    let translate = place.translate.unwrap_or_default();
    finite("translate", &translate)?;
    let rotation = match (&place.rotate_deg, &place.quaternion) {
        (Some(_), Some(q)) => return Err((Some(q.span().start), "give rotate_deg or quaternion, not both".into())),
        (Some(degrees), None) => {
            finite("rotate_deg", degrees)?;
            let [x, y, z] = degrees.map(|d| {
                let half = d.to_radians() * 0.5;
                (libm::sin(half), libm::cos(half))
            });
            DQuat::from_xyzw(0.0, 0.0, z.0, z.1)
                * DQuat::from_xyzw(0.0, y.0, 0.0, y.1)
                * DQuat::from_xyzw(x.0, 0.0, 0.0, x.1)
        }
        (None, Some(q)) => {
            let raw = DQuat::from_array(*q.as_ref());
            let length = raw.length();
            if !(length > 1e-6 && length.is_finite()) {
                return Err((Some(q.span().start), "a quaternion [x, y, z, w] of length 1 is expected".into()));
            }
            raw.normalize()
        }
        (None, None) => DQuat::IDENTITY,
    };
    let scale = match &place.scale {
        None => [1.0; 3],
        Some(s) => scale(s.as_ref()).map_err(|what| (Some(s.span().start), what))?,
    };
    Ok(DMat4::from_scale_rotation_translation(DVec3::from(scale), rotation, DVec3::from(translate)))
}

fn scale(value: &toml::Value) -> Result<[f64; 3], String> {
    let number = |v: &toml::Value| v.as_float().or(v.as_integer().map(|i| i as f64));
    let all = match value {
        toml::Value::Array(items) => items.iter().map(number).collect::<Option<Vec<_>>>(),
        v => number(v).map(|s| vec![s; 3]),
    };
    let three = all.and_then(|v| <[f64; 3]>::try_from(v).ok());
    three
        .filter(|v| v.iter().all(|s| s.is_finite() && *s != 0.0))
        .ok_or_else(|| "a scale is one number or [x, y, z], finite and not 0".into())
}
