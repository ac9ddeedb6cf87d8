#![no_main]

#[path = "../entries.rs"]
#[expect(dead_code, reason = "other targets use the rest")]
mod entries;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let folder = std::env::temp_dir().join(format!("farfield-fuzz-index-{}", std::process::id()));
    entries::index(&folder, data);
});
