//! Buffer views compressed by meshoptimizer: EXT_meshopt_compression and KHR_meshopt_compression.
//!
//! The codecs are meshoptimizer's own; they accept any bytes. The filters are written out here by the reference in the
//! extension's text, because meshoptimizer's vector code approximates reciprocal roots, which differ from processor to processor.

use super::schema::Meshopt;

/// What a compressed view holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// Most bytes that one byte of each mode can stand for: a control byte for four columns of 256 bytes; a code byte for a triangle;
/// at least one byte for an index.
fn most(mode: Mode, encoded: usize, stride: u64) -> u64 {
    let encoded = encoded as u64;
    match mode {
        Mode::Attributes => encoded.saturating_mul(1024),
        Mode::Triangles => encoded.saturating_mul(3 * stride),
        Mode::Indices => encoded.saturating_mul(stride),
    }
}

/// Bytes of the decoded view.
pub(super) fn size(view: &Meshopt) -> Option<u64> {
    view.count.checked_mul(view.byte_stride)
}

/// Decodes `count` elements of `byte_stride` bytes. `limit` bounds the bytes of the result.
pub(super) fn decode(view: &Meshopt, encoded: &[u8], limit: u64) -> Result<Vec<u8>, String> {
    let stride = view.byte_stride;
    let mode = match view.mode.as_str() {
        "ATTRIBUTES" => Mode::Attributes,
        "TRIANGLES" => Mode::Triangles,
        "INDICES" => Mode::Indices,
        other => return Err(format!("compression mode `{other}`; expected ATTRIBUTES, TRIANGLES or INDICES")),
    };
    let fits = match mode {
        Mode::Attributes => (4..=256).contains(&stride) && stride.is_multiple_of(4),
        Mode::Triangles => matches!(stride, 2 | 4) && view.count.is_multiple_of(3),
        Mode::Indices => matches!(stride, 2 | 4),
    };
    if !fits {
        return Err(format!("{} elements of {stride} bytes cannot be compressed as {}", view.count, view.mode));
    }
    let bytes = size(view).filter(|n| *n <= limit);
    let bytes =
        bytes.ok_or_else(|| format!("{} elements of {stride} bytes; the limit is {limit} bytes", view.count))?;
    if bytes > most(mode, encoded.len(), stride) {
        return Err(format!("truncated: {} bytes cannot hold {} elements", encoded.len(), view.count));
    }
    let count = view.count as usize;
    let broken = |_| format!("its {} bytes are not {count} elements compressed as {}", encoded.len(), view.mode);
    let mut out = match (mode, stride) {
        (Mode::Attributes, _) => attributes(encoded, count, stride as usize).map_err(broken)?,
        (Mode::Triangles, 2) => little(meshopt::decode_index_buffer::<u16>(encoded, count).map_err(|_| broken(()))?),
        (Mode::Triangles, _) => little(meshopt::decode_index_buffer::<u32>(encoded, count).map_err(|_| broken(()))?),
        (Mode::Indices, 2) => little(meshopt::decode_index_sequence::<u16>(encoded, count).map_err(|_| broken(()))?),
        (Mode::Indices, _) => little(meshopt::decode_index_sequence::<u32>(encoded, count).map_err(|_| broken(()))?),
    };
    let filter = view.filter.as_deref().unwrap_or("NONE");
    if filter != "NONE" && mode != Mode::Attributes {
        return Err(format!("filter `{filter}` on {}", view.mode));
    }
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => out.chunks_exact_mut(4).for_each(octahedral::<1>),
        ("OCTAHEDRAL", 8) => out.chunks_exact_mut(8).for_each(octahedral::<2>),
        ("QUATERNION", 8) => out.chunks_exact_mut(8).for_each(quaternion),
        ("EXPONENTIAL", _) => out.chunks_exact_mut(4).for_each(exponential),
        ("COLOR", 4) => out.chunks_exact_mut(4).for_each(color::<1>),
        ("COLOR", 8) => out.chunks_exact_mut(8).for_each(color::<2>),
        _ => return Err(format!("filter `{filter}` on elements of {stride} bytes")),
    }
    Ok(out)
}

fn little<T: bytemuck::Pod>(values: Vec<T>) -> Vec<u8> {
    bytemuck::cast_slice(&values).to_vec()
}

#[expect(
    unsafe_code,
    reason = "the crate's own function wants the element's size as a type; files state it as a number"
)]
fn attributes(encoded: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, ()> {
    assert!((4..=256).contains(&stride) && stride.is_multiple_of(4), "checked by the caller");
    let mut out = vec![0u8; count * stride];
    // SAFETY: `out` has room for `count` elements of `stride` bytes, a multiple of four up to 256; the decoder reads only within
    // `encoded`, whatever it holds, and writes bytes without alignment.
    let code = unsafe {
        meshopt::ffi::meshopt_decodeVertexBuffer(
            out.as_mut_ptr().cast(),
            count,
            stride,
            encoded.as_ptr(),
            encoded.len(),
        )
    };
    if code == 0 { Ok(out) } else { Err(()) }
}

/// Reads component `i` of `N` bytes, signed.
fn get<const N: usize>(v: &[u8], i: usize) -> i32 {
    if N == 1 { i32::from(v[i] as i8) } else { i32::from(i16::from_le_bytes([v[2 * i], v[2 * i + 1]])) }
}

fn put<const N: usize>(v: &mut [u8], i: usize, value: i32) {
    v[N * i..N * (i + 1)].copy_from_slice(&value.to_le_bytes()[..N]);
}

/// To the nearest integer, halves away from zero.
fn round(x: f32) -> i32 {
    (x + if x >= 0.0 { 0.5 } else { -0.5 }) as i32
}

/// A unit vector from octahedral x and y; z holds what stands for 1.
fn octahedral<const N: usize>(v: &mut [u8]) {
    let most = if N == 1 { 127.0f32 } else { 32767.0 };
    let [mut x, mut y, one] = [0, 1, 2].map(|i| get::<N>(v, i) as f32);
    let z = one - x.abs() - y.abs();
    let t = z.min(0.0);
    x += if x >= 0.0 { t } else { -t };
    y += if y >= 0.0 { t } else { -t };
    let scale = most / (x * x + y * y + z * z).sqrt();
    for (i, c) in [x, y, z].into_iter().enumerate() {
        put::<N>(v, i, round(c * scale));
    }
}

/// A unit quaternion from its three smaller components; the fourth's low bits name the one left out, the rest is the scale.
fn quaternion(v: &mut [u8]) {
    let code = get::<2>(v, 3);
    let [x, y, z] = [0, 1, 2].map(|i| get::<2>(v, i) as f32);
    let s = (code | 3) as f32;
    let w = (s * s * 2.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let scale = 32767.0 / std::f32::consts::SQRT_2 / s;
    for (i, c) in [(1, x), (2, y), (3, z), (0, w)] {
        put::<2>(v, ((code + i) & 3) as usize, round(c * scale));
    }
}

/// A float from a 24-bit mantissa and an 8-bit exponent.
fn exponential(v: &mut [u8]) {
    let code = i32::from_le_bytes([v[0], v[1], v[2], v[3]]);
    let (mantissa, exponent) = (code << 8 >> 8, code >> 24);
    let power = f32::from_bits(((exponent + 127) as u32) << 23);
    v.copy_from_slice(&(power * mantissa as f32).to_le_bytes());
}

/// RGBA from YCoCg with the alpha's leading bit as scale.
fn color<const N: usize>(v: &mut [u8]) {
    let most = if N == 1 { 255.0f32 } else { 65535.0 };
    let unsigned = |v: &[u8], i: usize| get::<N>(v, i) & if N == 1 { 0xff } else { 0xffff };
    let alpha = unsigned(v, 3);
    let mut scale = alpha;
    for shift in [1, 2, 4, 8] {
        scale |= scale >> shift;
    }
    let (y, co, cg) = (unsigned(v, 0), get::<N>(v, 1), get::<N>(v, 2));
    let a = (alpha << 1 & scale) | (alpha & 1);
    let factor = most / scale as f32;
    for (i, c) in [y + co - cg, y + cg, y - co - cg, a].into_iter().enumerate() {
        put::<N>(v, i, (c as f32 * factor + 0.5) as i32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn view(count: usize, stride: usize, mode: &str, filter: Option<&str>) -> Meshopt {
        Meshopt {
            byte_stride: stride as u64,
            count: count as u64,
            mode: mode.into(),
            filter: filter.map(str::to_owned),
            ..Meshopt::default()
        }
    }

    #[test]
    fn all_modes_come_back() {
        let vertices: Vec<[u8; 12]> =
            (0..100u8).map(|i| std::array::from_fn(|k| i.wrapping_mul(k as u8 + 1))).collect();
        let encoded = meshopt::encode_vertex_buffer(&vertices).unwrap();
        let attributes = decode(&view(100, 12, "ATTRIBUTES", None), &encoded, 1200).unwrap();
        assert_eq!(attributes, vertices.concat());
        let indices: Vec<u32> = (0..99).map(|i| i * 7 % 100).collect();
        let sequence = meshopt::encode_index_sequence(&indices, 100).unwrap();
        let wide = decode(&view(99, 4, "INDICES", None), &sequence, 1000).unwrap();
        assert_eq!(bytemuck::pod_collect_to_vec::<u8, u32>(&wide), indices);
        let short = decode(&view(99, 2, "INDICES", Some("NONE")), &sequence, 1000).unwrap();
        assert!(bytemuck::pod_collect_to_vec::<u8, u16>(&short).iter().zip(&indices).all(|(a, b)| u32::from(*a) == *b));
        let triangles = meshopt::encode_index_buffer(&indices, 100).unwrap();
        for stride in [2, 4] {
            let out = decode(&view(99, stride, "TRIANGLES", None), &triangles, 1000).unwrap();
            let out: Vec<u32> = match stride {
                2 => bytemuck::pod_collect_to_vec::<u8, u16>(&out).into_iter().map(u32::from).collect(),
                _ => bytemuck::pod_collect_to_vec::<u8, u32>(&out),
            };
            // The codec may turn a triangle's corners round.
            let turned = |t: &[u32]| {
                let first = (0..3).min_by_key(|i| t[*i]).unwrap();
                [t[first], t[(first + 1) % 3], t[(first + 2) % 3]]
            };
            assert!(out.chunks(3).zip(indices.chunks(3)).all(|(a, b)| turned(a) == turned(b)), "{out:?}");
        }
    }

    #[test]
    fn filters_give_back_what_they_were_given() {
        let unit = |i: usize| {
            let v = glam::Vec4::new(i as f32 - 50.0, 20.0 - (i * 7 % 40) as f32, (i * 13 % 30) as f32 - 15.0, 0.0);
            (v.normalize_or(glam::Vec4::X)).to_array()
        };
        let units: Vec<[f32; 4]> = (0..100).map(unit).collect();
        let oct = meshopt::encode_filter_oct::<i16>(&units, 16);
        let mut bytes: Vec<u8> = bytemuck::cast_slice(&oct).to_vec();
        bytes.chunks_exact_mut(8).for_each(octahedral::<2>);
        for (v, u) in bytemuck::pod_collect_to_vec::<u8, [i16; 4]>(&bytes).iter().zip(&units) {
            assert!((0..3).all(|k| (f32::from(v[k]) / 32767.0 - u[k]).abs() < 1e-4), "{v:?} {u:?}");
        }
        let oct = meshopt::encode_filter_oct::<i8>(&units, 8);
        let mut bytes: Vec<u8> = bytemuck::cast_slice(&oct).to_vec();
        bytes.chunks_exact_mut(4).for_each(octahedral::<1>);
        for (v, u) in bytemuck::pod_collect_to_vec::<u8, [i8; 4]>(&bytes).iter().zip(&units) {
            assert!((0..3).all(|k| (f32::from(v[k]) / 127.0 - u[k]).abs() < 0.03), "{v:?} {u:?}");
        }
        let turns: Vec<[f32; 4]> = (0..100).map(|i| (glam::Vec4::from(unit(i)) + 0.3).normalize().to_array()).collect();
        let mut bytes: Vec<u8> = bytemuck::cast_slice(&meshopt::encode_filter_quat(&turns, 16)).to_vec();
        bytes.chunks_exact_mut(8).for_each(quaternion);
        for (v, q) in bytemuck::pod_collect_to_vec::<u8, [i16; 4]>(&bytes).iter().zip(&turns) {
            let dot: f32 = (0..4).map(|k| f32::from(v[k]) / 32767.0 * q[k]).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-3, "{v:?} {q:?}");
        }
        for (mantissa, exponent, value) in [(3i32, 0i32, 3.0f32), (-5, -2, -1.25), (1, 4, 16.0), (0, 0, 0.0)] {
            let mut v = ((exponent << 24) | (mantissa & 0xff_ffff)).to_le_bytes();
            exponential(&mut v);
            assert_eq!(f32::from_le_bytes(v), value);
        }
    }

    #[test]
    fn colours_come_back() {
        let colors = [[1.0, 0.0, 0.0, 1.0], [0.05, 0.8, 0.35, 1.0], [1.0, 1.0, 1.0, 0.5], [0.0f32; 4]];
        let close = |v: &[f32], c: &[f32; 4], by: f32| v.iter().zip(c).all(|(a, b)| (a - b).abs() <= by);
        let mut bytes: Vec<u8> = meshopt::encode_filter_color::<u8>(&colors, 8).concat();
        bytes.chunks_exact_mut(4).for_each(color::<1>);
        for (v, c) in bytes.chunks(4).zip(&colors) {
            let v: Vec<f32> = v.iter().map(|b| f32::from(*b) / 255.0).collect();
            assert!(close(&v, c, 0.01), "{v:?} {c:?}");
        }
        let wide = meshopt::encode_filter_color::<u16>(&colors, 12);
        let mut bytes: Vec<u8> = bytemuck::cast_slice(&wide).to_vec();
        bytes.chunks_exact_mut(8).for_each(color::<2>);
        for (v, c) in bytemuck::pod_collect_to_vec::<u8, [u16; 4]>(&bytes).iter().zip(&colors) {
            assert!(close(&v.map(|b| f32::from(b) / 65535.0), c, 0.001), "{v:?} {c:?}");
        }
    }

    #[test]
    fn what_cannot_be_is_named() {
        let error = |v: Meshopt| decode(&v, &[0xa0; 40], 1 << 20).unwrap_err();
        assert!(error(view(4, 4, "WAVELET", None)).starts_with("compression mode `WAVELET`"));
        assert!(error(view(4, 6, "ATTRIBUTES", None)).contains("cannot be compressed as ATTRIBUTES"));
        assert!(error(view(4, 4, "TRIANGLES", None)).contains("cannot be compressed as TRIANGLES"));
        assert!(error(view(1 << 40, 4, "ATTRIBUTES", None)).contains("the limit is 1048576 bytes"));
        assert!(error(view(60_000, 4, "INDICES", None)).starts_with("truncated"));
        let encoded = meshopt::encode_vertex_buffer(&[[1u8; 12]; 4]).unwrap();
        assert!(decode(&view(4, 12, "ATTRIBUTES", Some("QUATERNION")), &encoded, 100).is_err());
    }

    proptest! {
        #[test]
        fn any_bytes_give_elements_or_an_error(
            mode in prop::sample::select(vec!["ATTRIBUTES", "TRIANGLES", "INDICES"]),
            filter in prop::sample::select(vec!["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"]),
            head in prop::sample::select(vec![0xa0u8, 0xa1, 0xd0, 0xd1, 0xe0, 0xe1]),
            rest in prop::collection::vec(any::<u8>(), 0..300),
            count in 0..200usize,
            stride in prop::sample::select(vec![2usize, 4, 8, 12, 16, 256]),
        ) {
            let encoded: Vec<u8> = std::iter::once(head).chain(rest).collect();
            if let Ok(out) = decode(&view(count, stride, mode, Some(filter)), &encoded, 1 << 20) {
                prop_assert_eq!(out.len(), count * stride);
            }
        }
    }
}
