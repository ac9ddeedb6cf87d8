//! Images of 8 bits a channel to texels of a format, and back.

use super::{Format, bc1, bc4, format::MOST_SIDE};
use rayon::prelude::*;

/// Texels of a format, from an image row by row from the top. R8, RG8, BC4 and BC5 take red, or red and green; BC1 takes the colour without alpha;
/// R16 takes red times 257. The texels beyond the edge that fill blocks repeat those at the edge. `srgb` weights the errors of BC1 and BC3 for the eye.
///
/// # Panics
/// Where `texels` are not `width` × `height`.
pub fn encode(format: Format, srgb: bool, width: u32, height: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let texels = Grid::new(width, height, texels);
    match format {
        Format::R8 => texels.values.iter().map(|t| t[0]).collect(),
        Format::Rg8 => texels.values.iter().flat_map(|t| [t[0], t[1]]).collect(),
        Format::Rgba8 => texels.values.as_flattened().to_vec(),
        Format::R16 => texels.values.iter().flat_map(|t| (u16::from(t[0]) * 257).to_le_bytes()).collect(),
        Format::Bc1 => texels.blocks(|b, out| out.extend(bc1::encode(&b.map(|[r, g, b, _]| [r, g, b]), srgb, false))),
        Format::Bc3 => texels.blocks(|b, out| {
            out.extend(bc4::encode(&b.map(|t| t[3])));
            out.extend(bc1::encode(&b.map(|[r, g, b, _]| [r, g, b]), srgb, true));
        }),
        Format::Bc4 => texels.blocks(|b, out| out.extend(bc4::encode(&b.map(|t| t[0])))),
        Format::Bc5 => texels.blocks(|b, out| {
            out.extend(bc4::encode(&b.map(|t| t[0])));
            out.extend(bc4::encode(&b.map(|t| t[1])));
        }),
    }
}

/// Texels of R16 from an image of 16 bits.
pub fn encode16(texels: &[u16]) -> Vec<u8> {
    texels.iter().flat_map(|t| t.to_le_bytes()).collect()
}

/// The image that texels of a format show, rounded to 8 bits; channels that the format lacks are 0, alpha is 255. `None` where `bytes` are not as many
/// as the format needs.
pub fn decode(format: Format, width: u32, height: u32, bytes: &[u8]) -> Option<Vec<[u8; 4]>> {
    if !fits(format, width, height, bytes) {
        return None;
    }
    let gray = |r: u8| [r, 0, 0, 255];
    let blocks = |of: fn(&[u8]) -> [[u8; 4]; 16]| unblock(format, width, height, bytes, of);
    Some(match format {
        Format::R8 => bytes.iter().map(|r| gray(*r)).collect(),
        Format::R16 => decode16(bytes).iter().map(|v| gray(((u32::from(*v) + 128) / 257) as u8)).collect(),
        Format::Rg8 => bytes.as_chunks().0.iter().map(|[r, g]| [*r, *g, 0, 255]).collect(),
        Format::Rgba8 => bytes.as_chunks().0.to_vec(),
        Format::Bc1 => blocks(|b| bc1::decode(half(b, 0), false).map(|[r, g, b]| [r, g, b, 255])),
        Format::Bc3 => blocks(|b| {
            let (alpha, colors) = (bc4::decode(half(b, 0)), bc1::decode(half(b, 1), true));
            std::array::from_fn(|i| [colors[i][0], colors[i][1], colors[i][2], alpha[i]])
        }),
        Format::Bc4 => blocks(|b| bc4::decode(half(b, 0)).map(|r| [r, 0, 0, 255])),
        Format::Bc5 => blocks(|b| {
            let (red, green) = (bc4::decode(half(b, 0)), bc4::decode(half(b, 1)));
            std::array::from_fn(|i| [red[i], green[i], 0, 255])
        }),
    })
}

/// The image of 16 bits that texels of R16 show.
pub fn decode16(bytes: &[u8]) -> Vec<u16> {
    bytes.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect()
}

/// Whether there are as many bytes as an image needs.
fn fits(format: Format, width: u32, height: u32, bytes: &[u8]) -> bool {
    width.max(height) <= MOST_SIDE && format.bytes(width, height) == bytes.len() as u64
}

/// The first or second 8 bytes of a block.
fn half(block: &[u8], which: usize) -> [u8; 8] {
    let mut out = [0; 8];
    out.copy_from_slice(&block[8 * which..8 * which + 8]);
    out
}

fn unblock(format: Format, width: u32, height: u32, bytes: &[u8], of: fn(&[u8]) -> [[u8; 4]; 16]) -> Vec<[u8; 4]> {
    let (w, wide) = (width as usize, width.div_ceil(4) as usize);
    let mut out = vec![[0; 4]; w * height as usize];
    if out.is_empty() {
        return out;
    }
    let size = format.block_bytes() as usize;
    out.par_chunks_mut(4 * w).zip(bytes.par_chunks(wide * size)).for_each(|(rows, blocks)| {
        for (bx, block) in blocks.chunks_exact(size).enumerate() {
            let texels = of(block);
            for (y, row) in rows.chunks_exact_mut(w).enumerate() {
                for (x, texel) in row[4 * bx..].iter_mut().take(4).enumerate() {
                    *texel = texels[4 * y + x];
                }
            }
        }
    });
    out
}

struct Grid<'a> {
    width: usize,
    height: usize,
    values: &'a [[u8; 4]],
}

impl<'a> Grid<'a> {
    fn new(width: u32, height: u32, values: &'a [[u8; 4]]) -> Self {
        let (width, height) = (width as usize, height as usize);
        assert_eq!(values.len(), width * height, "texels of an image of {width} × {height}");
        Self { width, height, values }
    }

    /// What `write` makes of all blocks, row by row.
    fn blocks(&self, write: impl Fn(&[[u8; 4]; 16], &mut Vec<u8>) + Sync) -> Vec<u8> {
        let rows: Vec<Vec<u8>> = (0..self.height.div_ceil(4))
            .into_par_iter()
            .map(|by| {
                let mut out = Vec::with_capacity(self.width.div_ceil(4) * 16);
                for bx in 0..self.width.div_ceil(4) {
                    let texel = |i: usize| {
                        let (x, y) = ((4 * bx + i % 4).min(self.width - 1), (4 * by + i / 4).min(self.height - 1));
                        self.values[y * self.width + x]
                    };
                    write(&std::array::from_fn(texel), &mut out);
                }
                out
            })
            .collect();
        rows.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn image(width: u32, height: u32) -> Vec<[u8; 4]> {
        let texel = |i: u32| {
            let (x, y) = (i % width.max(1), i / width.max(1));
            [40 + 5 * x + 2 * y, 968 - 3 * x - y, 90 + x + 4 * y, 767 - 9 * x].map(|v| v as u8)
        };
        (0..width * height).map(texel).collect()
    }

    #[test]
    fn images_come_back_nearly() {
        for (width, height) in [(1, 1), (3, 5), (4, 4), (6, 2), (13, 9), (16, 16)] {
            let texels = image(width, height);
            for format in Format::ALL {
                let bytes = encode(format, false, width, height, &texels);
                assert_eq!(bytes.len() as u64, format.bytes(width, height), "{format:?}");
                let decoded = decode(format, width, height, &bytes).unwrap();
                let compressed = format.block_side() > 1;
                for (a, b) in decoded.iter().zip(&texels) {
                    for c in 0..4 {
                        let stored = c < format.channels() as usize;
                        let expected = match (stored, c) {
                            (true, _) => b[c],
                            (false, 3) => 255,
                            (false, _) => 0,
                        };
                        let most = if !compressed || !stored { 0 } else { 12 };
                        assert!(a[c].abs_diff(expected) <= most, "{format:?} {width}×{height}: {a:?} for {b:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bytes() {
        let texels = image(50, 30);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Format::ALL.map(|f| encode(f, true, 50, 30, &texels)))
        };
        assert_eq!(with(1), with(5));
    }

    #[test]
    fn blocks_keep_their_bytes() {
        // Stored textures hold these: another encoder or another version of one needs a new version of what calls it.
        let texels = image(12, 8);
        let hash = |f: Format| blake3::hash(&encode(f, true, 12, 8, &texels)).to_hex()[..16].to_owned();
        let found: Vec<String> = [Format::Bc1, Format::Bc3, Format::Bc4, Format::Bc5].map(hash).to_vec();
        assert_eq!(found, ["f2e951025a400817", "e8810d1b026bc024", "f60920a13a5c29e1", "a7f5557358ac2ff9"]);
    }

    #[test]
    fn sixteen_bits_keep_them() {
        let values: Vec<u16> = vec![0, 1, 256, 0xfffe, 0xffff];
        assert_eq!(decode16(&encode16(&values)), values);
        let shown = decode(Format::R16, 5, 1, &encode16(&values)).unwrap();
        assert_eq!(shown.iter().map(|t| t[0]).collect::<Vec<_>>(), [0, 0, 1, 255, 255]);
    }

    proptest! {
        #[test]
        fn any_bytes_decode(which in 0..8_usize, width in 0..10_u32, height in 0..10_u32, bytes in prop::collection::vec(any::<u8>(), 0..160)) {
            let format = Format::ALL[which];
            let need = format.bytes(width, height) as usize;
            prop_assert_eq!(decode(format, width, height, &bytes).is_some(), bytes.len() == need);
            if let Some(enough) = bytes.get(..need) {
                let image = decode(format, width, height, enough).unwrap();
                prop_assert_eq!(image.len() as u32, width * height);
                if format.channels() < 4 {
                    prop_assert!(image.iter().all(|t| t[3] == 255));
                }
            }
        }
    }
}
