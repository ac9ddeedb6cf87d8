#![no_main]

use farfield::texture::{TextureArray, dds, ktx2};

/// What was read can be decoded, written and read again.
fn check(array: &TextureArray, again: Option<TextureArray>) {
    assert_eq!(again.as_ref(), Some(array));
    for level in 0..array.levels.len() as u32 {
        assert!(array.decode(level, array.layers - 1).is_some());
    }
}

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    if let Ok(array) = ktx2::read(data) {
        check(&array, ktx2::write(&array).ok().and_then(|bytes| ktx2::read(&bytes).ok()));
    }
    if let Ok(array) = dds::read(data) {
        check(&array, dds::write(&array).ok().and_then(|bytes| dds::read(&bytes).ok()));
    }
});
