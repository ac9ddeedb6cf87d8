#![no_main]

use farfield::{engine::artifact::from_bytes, scene::Scene};
use std::sync::Arc;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = from_bytes::<Scene>(Arc::new(data.to_vec()));
});
