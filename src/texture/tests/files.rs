use super::*;
use proptest::prelude::*;

type Write = fn(&TextureArray) -> Result<Vec<u8>, TextureError>;
type Read = fn(&[u8]) -> Result<TextureArray, TextureError>;
const KINDS: [(&str, Write, Read); 2] = [("KTX2", ktx2::write, ktx2::read), ("DDS", dds::write, dds::read)];

fn variants() -> impl Iterator<Item = (Format, bool)> {
    Format::ALL.into_iter().flat_map(|f| [(f, false), (f, true)]).filter(|(f, srgb)| f.has_srgb() || !srgb)
}

#[test]
fn what_was_written_is_read() {
    for (format, srgb) in variants() {
        let two = array(format, srgb);
        let one = TextureArray { layers: 1, levels: vec![two.texels(0, 1).unwrap().to_vec()], ..two.clone() };
        for (name, write, read) in KINDS {
            for a in [&one, &two] {
                assert_eq!(read(&write(a).unwrap()).as_ref(), Ok(a), "{name} of {format:?}");
            }
        }
    }
}

#[test]
fn layers_and_levels_are_found() {
    for (format, _) in variants().filter(|(f, srgb)| *f != Format::R16 && !srgb) {
        let a = array(format, false);
        for (seed, layer) in [(0, 0), (60, 1)] {
            for (level, mip) in (0..).zip(chain(&image(6, 5, seed), &[255; 30], Rule::Data, 9)) {
                let bytes = encode(format, false, mip.width, mip.height, &mip.texels);
                assert_eq!(a.texels(level, layer), Some(&bytes[..]), "{format:?}");
                let shown = a.decode(level, layer).unwrap();
                assert_eq!((shown.width, shown.height), a.size(level));
            }
        }
        assert_eq!((a.texels(3, 0), a.texels(0, 2)), (None, None));
    }
}

/// A file byte by byte, from the two specifications.
#[test]
fn a_ktx2_file_is_as_the_specification_says() {
    // Two layers of 2 × 2 texels with two levels.
    let a = TextureArray {
        format: Format::Rgba8,
        srgb: true,
        width: 2,
        height: 2,
        layers: 2,
        levels: vec![(1..=32).collect(), (101..=108).collect()],
    };
    let mut expected = vec![0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n'];
    let mut words = |words: &[u32]| expected.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    // VK_FORMAT_R8G8B8A8_SRGB, typeSize, size, depth, layers, faces, levels, no supercompression.
    words(&[43, 1, 2, 2, 0, 2, 1, 2, 0]);
    // Descriptor of 92 bytes after two level entries, keys, no global data.
    words(&[128, 92, 220, 48, 0, 0, 0, 0]);
    // Levels: the smaller first in the file.
    words(&[276, 0, 32, 0, 32, 0]);
    words(&[268, 0, 8, 0, 8, 0]);
    // Descriptor: total size; vendor and type; version 2 and block size 88; model RGBSDA, BT.709, sRGB, straight; one texel a block; 4 bytes.
    words(&[92, 0, 2 | 88 << 16, 1 | 1 << 8 | 2 << 16, 0, 4, 0]);
    // Samples of 8 bits: red, green, blue; alpha is linear.
    words(&[7 << 16, 0, 0, 255]);
    words(&[8 | 7 << 16 | 1 << 24, 0, 0, 255]);
    words(&[16 | 7 << 16 | 2 << 24, 0, 0, 255]);
    words(&[24 | 7 << 16 | 0x1f << 24, 0, 0, 255]);
    words(&[18]);
    expected.extend(b"KTXorientation\0rd\0\0\0");
    expected.extend(19_u32.to_le_bytes());
    expected.extend(b"KTXwriter\0farfield\0\0");
    assert_eq!(expected.len(), 268);
    expected.extend(101..=108);
    expected.extend(1..=32);
    assert_eq!(ktx2::write(&a).unwrap(), expected);
}

#[test]
fn a_dds_file_is_as_the_specification_says() {
    let a = TextureArray {
        format: Format::Bc1,
        srgb: true,
        width: 4,
        height: 4,
        layers: 2,
        levels: vec![(1..=16).collect(), (21..=36).collect(), (41..=56).collect()],
    };
    let mut expected = b"DDS ".to_vec();
    let mut words = |words: &[u32]| expected.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    // Size, flags (caps, height, width, pixel format, mip levels, linear size), height, width, bytes of the first level, depth, levels.
    words(&[124, 0x000a_1007, 4, 4, 8, 0, 3]);
    words(&[0; 11]);
    // Pixel format: size, FourCC.
    words(&[32, 4, u32::from_le_bytes(*b"DX10"), 0, 0, 0, 0, 0]);
    // Caps: complex, texture, mip levels.
    words(&[0x0040_1008, 0, 0, 0, 0]);
    // BC1_UNORM_SRGB, 2D, no flags, two layers, opaque.
    words(&[72, 3, 0, 2, 3]);
    // Each layer with its levels.
    expected.extend((1..=8).chain(21..=28).chain(41..=48));
    expected.extend((9..=16).chain(29..=36).chain(49..=56));
    assert_eq!(dds::write(&a).unwrap(), expected);
}

#[test]
fn wrong_arrays_are_refused() {
    let good = array(Format::Bc1, true);
    let refused = |change: fn(&mut TextureArray)| {
        let mut a = good.clone();
        change(&mut a);
        let found = a.check().unwrap_err();
        assert_eq!((ktx2::write(&a), dds::write(&a)), (Err(found.clone()), Err(found.clone())));
        found.to_string()
    };
    assert_eq!(refused(|a| a.format = Format::Bc4), "format: Bc4 has no sRGB variant");
    assert_eq!(refused(|a| a.width = 0), "size: 0×5; expected 1 to 16384 texels a side");
    assert_eq!(refused(|a| a.height = 16385), "size: 6×16385; expected 1 to 16384 texels a side");
    assert_eq!(refused(|a| a.layers = 0), "layers: 0; expected 1 to 2048");
    assert_eq!(refused(|a| a.levels.clear()), "levels: 0; expected 1 to 3 for 6×5");
    assert_eq!(refused(|a| a.levels.push(vec![0; 16])), "levels: 4; expected 1 to 3 for 6×5");
    assert_eq!(refused(|a| a.levels[1].truncate(15)), "levels: level 1 has 15 bytes; expected 16");
    assert!(TextureArray::encode(Format::R8, false, &[]).is_err());
    assert!(TextureArray::encode(Format::R8, false, &[vec![image(4, 4, 0), image(2, 1, 0)]]).is_err());
    assert!(TextureArray::encode(Format::R8, false, &[vec![image(4, 4, 0)], vec![image(4, 2, 0)]]).is_err());
}

#[test]
fn files_of_other_contents_are_refused() {
    let file = ktx2::write(&array(Format::Bc1, true)).unwrap();
    let changed = |at: usize, byte: u8| {
        let mut bytes = file.clone();
        bytes[at] = byte;
        ktx2::read(&bytes).unwrap_err().to_string()
    };
    assert_eq!(changed(5, b'1'), "identifier: this is no KTX 2.0 file");
    assert_eq!(changed(44, 2), "supercompressionScheme: 2; expected 0");
    assert_eq!(changed(36, 6), "faceCount: 6; expected 1");
    assert!(changed(12, 146).starts_with("vkFormat: 146; expected"), "{}", changed(12, 146));
    // An array of 514 layers that the file does not hold.
    assert!(changed(33, 2).contains("level 0 has 64 bytes; expected 16448"), "{}", changed(33, 2));
    assert!(changed(152 + 14, 1).contains("transfer function"));
    let file = dds::write(&array(Format::Bc1, true)).unwrap();
    let changed = |at: usize, byte: u8| {
        let mut bytes = file.clone();
        bytes[at] = byte;
        dds::read(&bytes).unwrap_err().to_string()
    };
    assert_eq!(changed(128, 95), "DDS: DXGI format 95 is not among those read here");
    assert_eq!(changed(136, 4), "DDS: expected a texture of two dimensions, no cube and no volume");
    assert!(changed(141, 2).contains("bytes of texels; expected"));
}

proptest! {
    #[test]
    fn damaged_files_give_errors(
        which in 0..11_usize,
        kind in 0..2_usize,
        changes in prop::collection::vec((0..1000_usize, any::<u8>()), 0..4),
        keep in 0..1200_usize,
    ) {
        let (format, srgb) = variants().nth(which).unwrap();
        let (_, write, read) = KINDS[kind];
        let mut bytes = write(&array(format, srgb)).unwrap();
        let whole = bytes.len();
        for (at, byte) in changes {
            bytes[at % whole] = byte;
        }
        bytes.truncate(keep);
        if let Ok(a) = read(&bytes) {
            prop_assert!(keep >= whole);
            prop_assert_eq!(a.check(), Ok(()));
            // What was read can be written, decoded, and read again.
            prop_assert_eq!(read(&write(&a).unwrap()), Ok(a.clone()));
            for level in 0..a.levels.len() as u32 {
                prop_assert!(a.decode(level, a.layers - 1).is_some());
            }
        }
    }

    #[test]
    fn any_bytes_give_errors(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for (_, _, read) in KINDS {
            prop_assert!(read(&bytes).is_err());
        }
    }
}
