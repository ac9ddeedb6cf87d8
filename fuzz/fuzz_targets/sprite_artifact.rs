#![no_main]

use farfield::{
    engine::artifact::from_bytes,
    nodes::values::Sprite,
    sprite::{Peeled, Placement, Ray, Volume},
};
use glam::DVec3;
use std::sync::Arc;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let bytes = Arc::new(data.to_vec());
    let _ = from_bytes::<Peeled>(bytes.clone());
    if let Ok(Sprite { packed, frame }) = from_bytes::<Sprite>(bytes) {
        // What was read can be asked.
        let volume = Volume::new(packed.unpack(), &frame, &Placement::default());
        let ray = Ray { origin: volume.bounds().min, direction: DVec3::new(0.3, 0.5, 0.7) };
        for span in volume.spans(&ray) {
            volume.normal(&ray, &span.enter);
        }
        packed.contains([0.5, 0.5, 0.5]);
        packed.file();
    }
});
