//! Reads a depth sprite that `farfield bake vds` wrote and says which points lie inside, from the files alone:
//! `cargo run --example classify -- out/vds/vds.json "0 1 2.5" "3 4 5"`. Points are in the world, metres.

use serde_json::Value;
use std::{error::Error, path::Path};

type Failure = Box<dyn Error>;

struct Sprite {
    manifest: Value,
    data: Vec<u8>,
}

impl Sprite {
    fn open(path: &Path) -> Result<Self, Failure> {
        let manifest: Value = serde_json::from_slice(&std::fs::read(path)?)?;
        let name = manifest["data"]["file"].as_str().ok_or("the manifest names no data file")?;
        let data = std::fs::read(path.with_file_name(name))?;
        if manifest["data"]["blake3"] != blake3::hash(&data).to_hex().as_str() {
            return Err(format!("{name} is not the file that the manifest was written with").into());
        }
        Ok(Self { manifest, data })
    }

    fn number(&self, pointer: &str) -> Result<f64, Failure> {
        let value = self.manifest.pointer(pointer).and_then(Value::as_f64);
        Ok(value.ok_or_else(|| format!("the manifest has no number at {pointer}"))?)
    }

    /// Word `i` of the section that has this number.
    fn word(&self, section: usize, i: usize) -> Result<u32, Failure> {
        let at = self.number(&format!("/sections/{section}/offset"))? as usize + 4 * i;
        let bytes = self.data.get(at..at + 4).ok_or("the data file is too short")?;
        Ok(u32::from_le_bytes(bytes.try_into()?))
    }

    /// Of `count` ranges in a section from the one that has number `first` on.
    fn in_ranges(&self, section: usize, first: usize, count: usize, r: f32) -> Result<bool, Failure> {
        let short = self.manifest["depths"]["form"] == "u16";
        for i in first..first + count {
            let [start, end] = if short {
                let (base, step) = (self.number("/depths/base")? as u32, self.number("/depths/step")? as f32);
                let word = self.word(section, i)?;
                [word & 0xffff, word >> 16].map(|k| (base + k) as f32 * step)
            } else {
                [self.word(section, 2 * i)?, self.word(section, 2 * i + 1)?].map(f32::from_bits)
            };
            if start <= r && r <= end {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn contains(&self, world: [f64; 3]) -> Result<bool, Failure> {
        let mut point = [0.0f32; 3];
        for (i, out) in point.iter_mut().enumerate() {
            let m = |k: usize| self.number(&format!("/world_to_texture/{i}/{k}"));
            *out = (m(0)? * world[0] + m(1)? * world[1] + m(2)? * world[2] + m(3)?) as f32;
        }
        let [s, t, r] = point;
        let mut region = [0i64; 4];
        for (k, out) in region.iter_mut().enumerate() {
            *out = self.number(&format!("/region/{k}"))? as i64;
        }
        let [x0, y0, width, height] = region;
        let x = (s * self.number("/size/0")? as f32).floor() as i64 - x0;
        let y = (t * self.number("/size/1")? as f32).floor() as i64 - y0;
        if x < 0 || y < 0 || x >= width || y >= height {
            return Ok(false);
        }
        let (x, y, width) = (x as usize, y as usize, width as usize);
        let texel = y * width + x;
        match self.manifest["layout"].as_str() {
            Some("raw") => {
                let n = width * height as usize;
                let layers = self.number("/depth_complexity")? as usize;
                for k in (0..layers).step_by(2) {
                    let (start, end) = (self.word(0, k * n + texel)?, self.word(0, (k + 1) * n + texel)?);
                    // 1 stands for no depth.
                    let (start, end) = (f32::from_bits(start), f32::from_bits(end));
                    if start < 1.0 && start <= r && r <= end {
                        return Ok(true);
                    }
                }
                Ok(false)
            }
            Some("ranges") => {
                let (first, count) = (self.word(0, 2 * texel)?, self.word(0, 2 * texel + 1)?);
                self.in_ranges(0, first as usize, count as usize, r)
            }
            Some("rows") => {
                let prefix = |i: usize| Ok::<u32, Failure>(self.word(1, i / 2)? >> (16 * (i % 2)) & 0xffff);
                let before = self.word(0, y)?;
                let first = before + prefix(texel)?;
                let end = if x + 1 < width { before + prefix(texel + 1)? } else { self.word(0, y + 1)? };
                self.in_ranges(2, first as usize, (end - first) as usize, r)
            }
            Some("runs") => {
                for i in self.word(0, y)?..self.word(0, y + 1)? {
                    let place = self.word(1, 3 * i as usize)?;
                    let (first, length) = ((place & 0xffff) as usize, (place >> 16) as usize);
                    if (first..first + length).contains(&x) {
                        let (count, start) = (self.word(1, 3 * i as usize + 1)?, self.word(1, 3 * i as usize + 2)?);
                        let along = (x - first) * count as usize;
                        return self.in_ranges(2, start as usize + along, count as usize, r);
                    }
                }
                Ok(false)
            }
            other => Err(format!("the layout {other:?} is unknown").into()),
        }
    }
}

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("expected a manifest and points such as \"0 1 2.5\"")?;
    let sprite = Sprite::open(Path::new(&path))?;
    for text in arguments {
        let numbers: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let point: [f64; 3] = numbers.try_into().map_err(|_| format!("`{text}`: expected three numbers"))?;
        println!("{text}: {}", if sprite.contains(point)? { "inside" } else { "outside" });
    }
    Ok(())
}
