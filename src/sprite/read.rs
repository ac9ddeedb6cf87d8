//! Reading a sprite's files: the manifest and the data that `Packed::file` laid out. Any bytes give an image or an error.

use super::{CubeFrame, LayeredDepthImage, Layout, Region, layered::INVALID};
use crate::raster::MAX_SIDE;
use glam::DVec3;
use serde::Deserialize;
use serde_json::Value;

/// What the manifest of a sprite calls itself.
pub const FORMAT: &str = "farfield depth sprite";
const VERSION: u32 = 2;

/// Texels that a file of any size may have, and so many more for each of its bytes.
const EMPTY: u64 = 1 << 22;
const BYTE: u64 = 1 << 10;

/// Why files are no sprite.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("depth sprite, {place}: {what}")]
pub struct ReadError {
    /// The member of the manifest, or the section of the data.
    pub place: String,
    pub what: String,
}

impl ReadError {
    pub fn new(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self { place: place.into(), what: what.into() }
    }
}

#[derive(Deserialize)]
struct Manifest {
    version: u32,
    size: [u32; 2],
    region: [u32; 4],
    layout: String,
    depth_complexity: u32,
    depths: Depths,
    world_to_texture: [[f64; 4]; 3],
    sections: Vec<Section>,
}

#[derive(Deserialize)]
struct Depths {
    form: String,
    #[serde(default)]
    base: u32,
    #[serde(default)]
    step: f32,
}

#[derive(Deserialize)]
struct Section {
    name: String,
    count: u64,
    offset: u64,
}

/// The name of the data file beside the manifest.
pub fn data_file(manifest: &Value) -> Result<&str, ReadError> {
    let name = manifest.pointer("/data/file").and_then(Value::as_str);
    name.ok_or_else(|| ReadError::new("data.file", "expected the name of the data file"))
}

/// The image that the data hold, and its place in the world.
pub fn sprite(manifest: &Value, data: &[u8]) -> Result<(LayeredDepthImage, CubeFrame), ReadError> {
    let m = Manifest::deserialize(manifest).map_err(|e| ReadError::new("manifest", e.to_string()))?;
    if m.version != VERSION {
        return Err(ReadError::new("version", format!("{}; expected {VERSION}", m.version)));
    }
    let layout = Layout::ALL.into_iter().find(|l| l.name() == m.layout);
    let layout = layout.ok_or_else(|| ReadError::new("layout", format!("`{}` is not known", m.layout)))?;
    let [x, y, width, height] = m.region;
    let region = Region { x, y, width, height };
    let texels = u64::from(width) * u64::from(height);
    // Empty texels take no bytes in some layouts: what is claimed must stand in some relation to what is there.
    let most = EMPTY + BYTE * data.len() as u64;
    if width > MAX_SIDE || height > MAX_SIDE || texels > most {
        let what = format!("{width} × {height} texels; expected at most {MAX_SIDE} a side, and {most} for such data");
        return Err(ReadError::new("region", what));
    }
    let texels = texels as usize;
    let file = File { sections: &m.sections, data, depths: &m.depths };
    let (starts, depths) = match layout {
        Layout::Raw => file.raw(texels, m.depth_complexity as usize)?,
        Layout::Ranges => file.ranges(texels)?,
        Layout::Rows => file.rows(width as usize, height as usize)?,
        Layout::Runs => file.runs(width as usize, height as usize)?,
    };
    let image = LayeredDepthImage::from_parts(m.size, region, starts, depths);
    let image = image.map_err(|what| ReadError::new("data", what))?;
    Ok((image, frame(&m.world_to_texture)?))
}

/// Inverse of [`CubeFrame::to_texture`].
fn frame(rows: &[[f64; 4]; 3]) -> Result<CubeFrame, ReadError> {
    let wrong = || ReadError::new("world_to_texture", "expected axes of one length at right angles");
    let [r, d, f] = rows.map(|row| DVec3::new(row[0], row[1], row[2]));
    let side = 1.0 / r.length();
    let axes = [r * side, -d * side, f * side];
    // p ↦ M·p + t has the cube's middle at ½.
    let rest = rows.map(|row| 0.5 - row[3]);
    let centre = (axes[0] * rest[0] - axes[1] * rest[1] + axes[2] * rest[2]) * side;
    let [right, up, forward] = axes;
    if !(centre.is_finite() && side.is_finite()) {
        return Err(wrong());
    }
    CubeFrame::from_parts([right, up, forward], centre, side).ok_or_else(wrong)
}

struct File<'a> {
    sections: &'a [Section],
    data: &'a [u8],
    depths: &'a Depths,
}

/// Starts of every texel, and the last one's end; and all depths.
type Lists = (Vec<u32>, Vec<f32>);

impl File<'_> {
    /// The bytes of a section with elements of `size` bytes.
    fn section(&self, name: &str, size: usize) -> Result<&[u8], ReadError> {
        let section = self.sections.iter().find(|s| s.name == name);
        let section = section.ok_or_else(|| ReadError::new("sections", format!("`{name}` is missing")))?;
        let bytes = || {
            let from = usize::try_from(section.offset).ok()?;
            let length = usize::try_from(section.count).ok()?.checked_mul(size)?;
            self.data.get(from..from.checked_add(length)?)
        };
        bytes().ok_or_else(|| {
            let (n, at, have) = (section.count, section.offset, self.data.len());
            ReadError::new(name, format!("{n} elements of {size} bytes at {at} leave the {have} bytes of the data"))
        })
    }

    fn words(&self, name: &str) -> Result<Vec<u32>, ReadError> {
        Ok(words(self.section(name, 4)?))
    }

    /// The depths of `ranges`, two each.
    fn of_ranges(&self) -> Result<Vec<f32>, ReadError> {
        match self.depths.form.as_str() {
            "f32" => Ok(words(self.section("ranges", 8)?).into_iter().map(f32::from_bits).collect()),
            "u16" => {
                let shorts = self.section("ranges", 4)?.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
                // (base + number)·step, as the writer rounds.
                let depth = |k: u16| self.depths.base.saturating_add(k.into()) as f32 * self.depths.step;
                Ok(shorts.map(depth).collect())
            }
            other => Err(ReadError::new("depths.form", format!("`{other}`; expected `f32` or `u16`"))),
        }
    }

    fn raw(&self, texels: usize, layers: usize) -> Result<Lists, ReadError> {
        let depths = self.words("depths")?;
        if texels.checked_mul(layers) != Some(depths.len()) {
            let what = format!("{} depths for {layers} layers of {texels} texels", depths.len());
            return Err(ReadError::new("depths", what));
        }
        let ray = |i: usize| depths.iter().skip(i).step_by(texels.max(1)).map(|bits| f32::from_bits(*bits));
        lists((0..texels).map(|i| ray(i).take_while(|d| *d != INVALID).collect::<Vec<_>>()))
    }

    fn ranges(&self, texels: usize) -> Result<Lists, ReadError> {
        let words = words(self.section("texels", 8)?);
        let pairs: Vec<[u32; 2]> = words.chunks_exact(2).map(|w| [w[0], w[1]]).collect();
        let wrong = |i: usize| {
            ReadError::new("texels", format!("the ranges of texel {i} leave the texture, or are those of others"))
        };
        // Each range belongs to one texel: no more of them than the texture has room for.
        let (mut rays, mut used) = (Vec::new(), 0);
        for i in 0..texels {
            let [offset, count] = *pairs.get(i).ok_or_else(|| wrong(i))?;
            let end = (offset as usize).checked_add(count as usize).ok_or_else(|| wrong(i))?;
            let list = pairs.get(offset as usize..end).ok_or_else(|| wrong(i))?;
            used += list.len();
            if (count > 0 && (offset as usize) < texels) || used > pairs.len() {
                return Err(wrong(i));
            }
            rays.push(list);
        }
        lists(rays.into_iter().map(|r| r.iter().flatten().map(|b| f32::from_bits(*b)).collect::<Vec<_>>()))
    }

    fn rows(&self, width: usize, height: usize) -> Result<Lists, ReadError> {
        let before = self.words("before")?;
        let prefix = self.section("prefix", 2)?.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
        let prefix: Vec<u16> = prefix.collect();
        let depths = self.of_ranges()?;
        if before.len() != height + 1 || Some(prefix.len()) != width.checked_mul(height) {
            return Err(ReadError::new("before", format!("expected {height} rows of {width} texels")));
        }
        let mut starts: Vec<u32> = Vec::with_capacity(prefix.len() + 1);
        for (row, own) in prefix.chunks(width.max(1)).enumerate() {
            starts.extend(own.iter().map(|p| before[row].saturating_add((*p).into())));
        }
        starts.push(before[height]);
        doubled(starts, depths)
    }

    fn runs(&self, width: usize, height: usize) -> Result<Lists, ReadError> {
        let first = self.words("first")?;
        let runs = self.section("runs", 12)?;
        let depths = self.of_ranges()?;
        if first.len() != height + 1 {
            return Err(ReadError::new("first", format!("expected {} numbers, found {}", height + 1, first.len())));
        }
        let wrong = |row: usize| ReadError::new("runs", format!("those of row {row} are in disorder"));
        let mut starts = Vec::new();
        let mut next = 0u32;
        for row in 0..height {
            let (from, to) = (first[row] as usize, first[row + 1] as usize);
            let bytes = from.checked_mul(12).zip(to.checked_mul(12)).and_then(|(a, b)| runs.get(a..b));
            let mut x = 0;
            for run in bytes.ok_or_else(|| wrong(row))?.chunks_exact(12) {
                let begin = usize::from(u16::from_le_bytes([run[0], run[1]]));
                let length = usize::from(u16::from_le_bytes([run[2], run[3]]));
                let count = u32::from_le_bytes([run[4], run[5], run[6], run[7]]);
                let start = u32::from_le_bytes([run[8], run[9], run[10], run[11]]);
                if begin < x || begin + length > width || start != next {
                    return Err(wrong(row));
                }
                starts.resize(starts.len() + begin - x, next);
                for _ in 0..length {
                    starts.push(next);
                    next = next.checked_add(count).ok_or_else(|| wrong(row))?;
                }
                x = begin + length;
            }
            starts.resize(starts.len() + width - x, next);
        }
        starts.push(next);
        doubled(starts, depths)
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn lists(rays: impl Iterator<Item = Vec<f32>>) -> Result<Lists, ReadError> {
    let (mut starts, mut depths) = (vec![0], Vec::new());
    for ray in rays {
        depths.extend(ray);
        starts.push(u32::try_from(depths.len()).map_err(|_| ReadError::new("data", "more than 2^32 depths"))?);
    }
    Ok((starts, depths))
}

/// Starts that count ranges as starts that count depths.
fn doubled(starts: Vec<u32>, depths: Vec<f32>) -> Result<Lists, ReadError> {
    let twice = |s: u32| s.checked_mul(2).ok_or_else(|| ReadError::new("data", "more than 2^32 depths"));
    Ok((starts.into_iter().map(twice).collect::<Result<_, _>>()?, depths))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sprite::{DepthQuantizer, Packed};
    use proptest::prelude::*;
    use serde_json::json;

    fn image() -> LayeredDepthImage {
        let rays: Vec<Vec<f32>> = (0..48u8)
            .map(|i| match i % 5 {
                0 => vec![],
                1 | 2 => vec![0.25, 0.5],
                _ => vec![0.0, 0.125, 0.5, 0.75 + f32::from(i) / 256.0],
            })
            .collect();
        LayeredDepthImage::new([8, 6], rays).crop().unwrap()
    }

    fn files(packed: &Packed, frame: &CubeFrame) -> (Value, Vec<u8>) {
        let (bytes, sections) = packed.file();
        let sections: Vec<Value> = sections
            .iter()
            .map(|s| json!({ "name": s.name, "element": s.element, "count": s.count, "offset": s.offset }))
            .collect();
        let (m, region) = (frame.to_texture(), packed.region());
        let rows: Vec<[f64; 4]> =
            (0..3).map(|i| [m.matrix3.row(i).x, m.matrix3.row(i).y, m.matrix3.row(i).z, m.translation[i]]).collect();
        let depths = match packed.grid() {
            None => json!({ "form": "f32" }),
            Some(g) => json!({ "form": "u16", "base": g.parts()[1], "step": g.step() }),
        };
        let manifest = json!({
            "format": FORMAT,
            "version": VERSION,
            "size": packed.size(),
            "region": [region.x, region.y, region.width, region.height],
            "layout": packed.layout().name(),
            "depth_complexity": packed.depth_complexity(),
            "depths": depths,
            "world_to_texture": rows,
            "data": { "file": "vds.bin" },
            "sections": sections,
        });
        (manifest, bytes)
    }

    fn all() -> Vec<Packed> {
        let image = image();
        let grid = DepthQuantizer::around(&image);
        let both = Layout::ALL.map(|l| [Packed::new(&image, l), Packed::short(&image, l, grid)]);
        both.into_iter().flatten().flatten().collect()
    }

    fn frame() -> CubeFrame {
        let turn = glam::DMat3::from_rotation_y(0.7) * glam::DMat3::from_rotation_x(0.4);
        CubeFrame::from_parts([turn * DVec3::X, turn * DVec3::Y, turn * -DVec3::Z], DVec3::new(1.0, -2.0, 30.0), 4.0)
            .unwrap()
    }

    #[test]
    fn every_layout_comes_back() {
        for packed in all() {
            let (manifest, bytes) = files(&packed, &frame());
            assert_eq!(data_file(&manifest), Ok("vds.bin"));
            let (image, placed) = sprite(&manifest, &bytes).unwrap();
            assert_eq!(image, packed.unpack(), "{}", packed.layout().name());
            let (axes, centre, side) = placed.parts();
            let (expected_axes, expected_centre, expected_side) = frame().parts();
            assert!(axes.iter().zip(expected_axes).all(|(a, b)| a.distance(b) < 1e-12));
            assert!(centre.distance(expected_centre) < 1e-9 && (side - expected_side).abs() < 1e-9);
        }
    }

    #[test]
    fn claims_that_the_data_cannot_bear_are_refused() {
        for packed in all() {
            let (mut manifest, bytes) = files(&packed, &frame());
            for side in ["/region/2", "/region/3"] {
                *manifest.pointer_mut(side).unwrap() = json!(16_384);
            }
            manifest["size"] = json!([16_384, 16_384]);
            assert_eq!(sprite(&manifest, &bytes).unwrap_err().place, "region");
            *manifest.pointer_mut("/region/2").unwrap() = json!(u32::MAX);
            assert_eq!(sprite(&manifest, &bytes).unwrap_err().place, "region");
        }
    }

    proptest! {
        #[test]
        fn damaged_files_are_errors_or_images(
            which in 0..6usize,
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            keep in 0.1..1.1f64,
            (member, number) in (any::<prop::sample::Index>(), any::<u32>()),
        ) {
            let (mut manifest, mut bytes) = files(&all()[which], &frame());
            for (at, byte) in changes {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            bytes.truncate((bytes.len() as f64 * keep) as usize);
            let _ = sprite(&manifest, &bytes);
            let names = ["size/0", "region/0", "region/2", "region/3", "depth_complexity", "sections/0/count", "sections/0/offset"];
            *manifest.pointer_mut(&format!("/{}", names[member.index(names.len())])).unwrap() = json!(number);
            let _ = sprite(&manifest, &bytes);
        }
    }
}
