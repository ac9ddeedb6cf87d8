//! glTF 2.0 and GLB: the JSON, its buffers, and the scene they describe in the pose that the file shows: morph weights and
//! skins count, animations do not.

mod accessor;
mod container;
mod material;
mod meshopt;
mod nodes;
mod pose;
mod primitive;
pub(super) mod schema;
mod tidy;

use super::{FormatError, loader::Loader};
use crate::{array::Bytes, scene::Object};
use accessor::{Numbers, Want};
use container::{Span, Target};
use std::{path::Path, sync::Arc};

/// Extensions that change what a file means and that this reader follows.
const KNOWN: [&str; 12] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// The objects of a file: every node with a mesh, in the file's own order.
pub(super) fn read(loader: &mut Loader, file: &Path, bytes: Bytes) -> Result<Vec<Object>, FormatError> {
    with_numbers(loader, file, bytes, nodes::objects)
}

/// An attribute of one number a vertex, of the first primitive of the first mesh; empty where the file has no mesh.
pub(super) fn scalars(loader: &mut Loader, file: &Path, bytes: Bytes, name: &str) -> Result<Vec<f32>, FormatError> {
    with_numbers(loader, file, bytes, |loader, numbers| {
        let Some(primitive) = numbers.root.meshes.first().and_then(|m| m.primitives.first()) else {
            return Ok(Vec::new());
        };
        let place = "meshes[0].primitives[0]";
        let Some(accessor) = primitive.attributes.get(name) else {
            return Err(FormatError::invalid(file, place, format!("has no attribute {name}")));
        };
        loader.count_vertices(file, place, numbers.count(*accessor, place)?)?;
        let values = numbers.vectors::<1>(*accessor, &Want::new(place, &[1]))?;
        Ok(values.into_iter().map(|[v]| v).collect())
    })
}

fn with_numbers<R>(
    loader: &mut Loader,
    file: &Path,
    bytes: Bytes,
    work: impl FnOnce(&mut Loader, &Numbers) -> Result<R, FormatError>,
) -> Result<R, FormatError> {
    let glb = (*bytes).as_ref().starts_with(b"glTF");
    let (json, binary) = match glb {
        true => container::split(file, &bytes, &mut |what| loader.warn(file, what))?,
        false => (Span::whole(bytes), None),
    };
    let text = container::text(json.get()).map_err(|what| FormatError::invalid(file, "JSON", what))?;
    let root: schema::Root =
        serde_json::from_str(text).map_err(|e| FormatError::invalid(file, "JSON", without_position_of_glb(e, glb)))?;
    check_version(file, &root)?;
    extensions(loader, file, &root)?;
    let buffers = buffers(loader, file, &root, binary)?;
    let numbers = Numbers::new(file, &root, buffers, loader.limits.implied, loader.limits.bytes);
    work(loader, &numbers)
}

/// serde_json's message; the line in a GLB's JSON chunk helps nobody, the column does.
fn without_position_of_glb(e: serde_json::Error, glb: bool) -> String {
    if glb { format!("{e} of the JSON chunk") } else { e.to_string() }
}

fn check_version(file: &Path, root: &schema::Root) -> Result<(), FormatError> {
    let needs = root.asset.min_version.as_deref().unwrap_or(&root.asset.version);
    if needs.starts_with("2.") && (root.asset.min_version.is_none() || needs == "2.0") {
        return Ok(());
    }
    Err(FormatError::invalid(file, "asset", format!("version `{needs}`; this reader knows glTF 2.0")))
}

/// Extensions that change light, gloss or metadata, but neither shape nor base colour.
const HARMLESS: [&str; 6] =
    ["KHR_materials_", "KHR_lights_", "EXT_lights_", "KHR_animation_pointer", "KHR_audio", "KHR_xmp"];

fn extensions(loader: &mut Loader, file: &Path, root: &schema::Root) -> Result<(), FormatError> {
    let unknown = |list: &[String]| list.iter().filter(|e| !KNOWN.contains(&e.as_str())).cloned().collect::<Vec<_>>();
    let mut required = unknown(&root.extensions_required);
    // They are named with those that are only used, which they have to be too.
    required.retain(|e| !HARMLESS.iter().any(|h| e.starts_with(h)));
    if !required.is_empty() {
        let what = format!("{} cannot be read; export the file without", required.join(", "));
        return Err(FormatError::invalid(file, "extensionsRequired", what));
    }
    let ignored = unknown(&root.extensions_used);
    if !ignored.is_empty() {
        loader.warn(file, format!("ignores {}", ignored.join(", ")));
    }
    Ok(())
}

fn buffers(
    loader: &mut Loader,
    file: &Path,
    root: &schema::Root,
    mut binary: Option<Span>,
) -> Result<Vec<Option<Span>>, FormatError> {
    let mut out = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        let place = format!("buffers[{i}]");
        let bad = |what: String| FormatError::invalid(file, &place, what);
        let mut span = match &buffer.uri {
            None => match binary.take().filter(|_| i == 0) {
                Some(span) => span,
                // Views that are stored compressed lie in such a buffer.
                None => {
                    out.push(None);
                    continue;
                }
            },
            Some(uri) => Span::whole(fetch(loader, file, &place, uri)?),
        };
        let have = span.range.len() as u64;
        if buffer.byte_length > have {
            return Err(bad(format!("truncated: it says {} bytes, there are {have}", buffer.byte_length)));
        }
        span.range.end = span.range.start + buffer.byte_length as usize;
        out.push(Some(span));
    }
    Ok(out)
}

/// The bytes that a URI stands for.
fn fetch(loader: &Loader, file: &Path, place: &str, uri: &str) -> Result<Bytes, FormatError> {
    match container::target(uri).map_err(|what| FormatError::invalid(file, place, what))? {
        Target::Data(bytes) => Ok(Arc::new(bytes)),
        Target::File(name) => loader.read(&loader.resolve(file, &name)?),
    }
}
