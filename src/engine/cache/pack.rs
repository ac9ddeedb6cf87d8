//! Compressed value files: LZ4 blocks behind a short head. A file that begins with [`MAGIC`] is packed, any other is the
//! value's bytes as they are; a value that begins so itself is packed whether that saves anything or not.
//!
//! ```text
//! MAGIC (8 bytes) | size of the value (u64) | blocks
//! block: packed size (u32) | LZ4 block of the next BLOCK bytes of the value, the last one of what is left
//! ```
//!
//! The numbers in a file may be lies: blocks are unpacked one after the other, and each proves its share of the size
//! before there is memory for the next.

use lz4_flex::block;

pub const MAGIC: [u8; 8] = *b"\0farLZ4\x01";
const HEAD: usize = MAGIC.len() + 8;
/// Bytes of a value that are packed together.
const BLOCK: usize = 1 << 20;
/// After so many blocks without the wanted gain the rest is not tried.
const TRIED: usize = 4;

/// The packed file of a value, where it takes at most three quarters of its bytes.
pub fn pack(bytes: &[u8]) -> Option<Vec<u8>> {
    let must = bytes.starts_with(&MAGIC);
    let gains = |packed: usize, of: usize| must || packed <= of / 4 * 3;
    let mut out = Vec::new();
    out.extend(MAGIC);
    out.extend((bytes.len() as u64).to_le_bytes());
    let mut buffer = vec![0; block::get_maximum_output_size(BLOCK.min(bytes.len()))];
    for (at, part) in bytes.chunks(BLOCK).enumerate() {
        if at == TRIED && !gains(out.len(), at * BLOCK) {
            return None;
        }
        // The buffer holds any outcome: there is no error.
        let size = block::compress_into(part, &mut buffer).ok()?;
        out.extend((size as u32).to_le_bytes());
        out.extend(&buffer[..size]);
    }
    gains(out.len(), bytes.len()).then_some(out)
}

/// Whether a file is packed.
pub fn is_packed(file: &[u8]) -> bool {
    file.starts_with(&MAGIC)
}

/// The value in a packed file; the error says what is wrong with it.
pub fn unpack(file: &[u8]) -> Result<Vec<u8>, String> {
    let cut = || "its compressed file is cut off".to_owned();
    let (head, mut rest) = file.split_at_checked(HEAD).ok_or_else(cut)?;
    let size = u64::from_le_bytes(head[MAGIC.len()..].try_into().map_err(|_| cut())?);
    let mut out = Vec::new();
    while (out.len() as u64) < size {
        let (length, after) = rest.split_at_checked(4).ok_or_else(cut)?;
        let length = u32::from_le_bytes(length.try_into().map_err(|_| cut())?) as usize;
        let (packed, after) = after.split_at_checked(length).ok_or_else(cut)?;
        let (start, want) = (out.len(), (size - out.len() as u64).min(BLOCK as u64) as usize);
        out.resize(start + want, 0);
        match block::decompress_into(packed, &mut out[start..]) {
            Ok(got) if got == want => {}
            Ok(got) => return Err(format!("a block of its compressed file holds {got} bytes where {want} belong")),
            Err(e) => return Err(format!("its compressed file is damaged: {e}")),
        }
        rest = after;
    }
    if !rest.is_empty() {
        return Err(format!("its compressed file has {} bytes too many", rest.len()));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn noise(n: usize) -> Vec<u8> {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        (0..n).map(|_| next()).collect()
    }

    #[test]
    fn what_shrinks_is_packed_and_comes_back() {
        for n in [0, 1, 1000, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 5] {
            let even = vec![7; n];
            if n >= 1000 {
                let packed = pack(&even).unwrap();
                assert!(packed.len() < n / 10 && is_packed(&packed));
                assert_eq!(unpack(&packed).unwrap(), even);
            }
            assert!(pack(&noise(n)).is_none(), "{n} bytes of noise");
        }
        // Noise up to the last block that is tried, and then nothing but zeros: not worth a look.
        let mut late = noise(TRIED * BLOCK);
        late.resize(40 * BLOCK, 0);
        assert!(pack(&late).is_none());
    }

    #[test]
    fn a_value_that_looks_packed_is_packed() {
        let value = [&MAGIC[..], &noise(50)].concat();
        assert_eq!(unpack(&pack(&value).unwrap()).unwrap(), value);
    }

    #[test]
    fn a_lying_size_is_an_error_and_no_allocation() {
        let mut packed = pack(&vec![3; 10_000]).unwrap();
        for size in [u64::MAX, 1 << 40, 10_001, 9_999, 0] {
            packed[8..16].copy_from_slice(&size.to_le_bytes());
            assert!(unpack(&packed).is_err(), "{size}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes_give_a_value_or_an_error(tail in proptest::collection::vec(any::<u8>(), 0..200), size: u64) {
            let file = [&MAGIC[..], &size.to_le_bytes(), &tail].concat();
            if let Ok(value) = unpack(&file) {
                prop_assert_eq!(value.len() as u64, size);
            }
        }

        #[test]
        fn damage_is_an_error_or_other_bytes(n in 1usize..5000, at: usize, bit in 0..8u32) {
            let value: Vec<u8> = (0..n).map(|i| (i / 40) as u8).collect();
            if let Some(mut packed) = pack(&value) {
                let len = packed.len();
                packed[8 + at % (len - 8)] ^= 1u8 << bit;
                prop_assert!(unpack(&packed).map_or(true, |got| got.len() == n));
            }
        }
    }
}
