#![no_main]

mod one_file;

libfuzzer_sys::fuzz_target!(|data: &[u8]| one_file::try_load("a.obj", data));
