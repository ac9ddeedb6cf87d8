//! Points against depth sprites, many at a time.

use super::{Gpu, device::GpuError, machine::Sprite};
use crate::{
    math::Stop,
    sprite::{Layout, Packed, Section},
};
use glam::DAffine3;
use std::sync::Arc;

impl Gpu {
    /// Which of `points`, in texture space, lie inside: what [`Packed::contains`] says, bit for bit.
    pub fn classify(&self, packed: &Packed, points: &[[f32; 3]], stop: &Stop) -> Result<Vec<bool>, GpuError> {
        let (data, sections) = packed.file();
        let room = self.room().of(4);
        // With the copy that it is uploaded from.
        if data.len() as u64 * 2 > room {
            return Err(GpuError::TooSmall { need: data.len() as u64 * 8, limit: self.room().memory });
        }
        let sprite = sprite(packed, &sections, 0, &DAffine3::IDENTITY);
        let data = Arc::new(data);
        let mut inside = Vec::with_capacity(points.len());
        // Points as four numbers, and the copy that they are uploaded from.
        for points in points.chunks((room / 32).clamp(64, 1 << 22) as usize) {
            let padded: Vec<[f32; 4]> = points.iter().map(|[s, t, r]| [*s, *t, *r, 0.0]).collect();
            let (data, stop) = (data.clone(), stop.clone());
            let bits = self.call(move |machine| machine.classify(sprite, &data, &padded, &stop))?;
            inside.extend((0..points.len()).map(|i| bits[i / 32] >> (i % 32) & 1 == 1));
        }
        Ok(inside)
    }
}

/// What a shader needs to know of a sprite whose file begins at word `first` of the data.
pub(super) fn sprite(packed: &Packed, sections: &[Section], first: u32, to_texture: &DAffine3) -> Sprite {
    let mut begin = [0; 4];
    for (begin, section) in begin.iter_mut().zip(sections) {
        *begin = first + section.offset as u32 / 4;
    }
    let row = |i: usize| to_texture.matrix3.row(i).extend(to_texture.translation[i]).as_vec4().to_array();
    let region = packed.region();
    Sprite {
        world_to_texture: [row(0), row(1), row(2)],
        region: [region.x, region.y, region.width, region.height],
        sections: begin,
        size: packed.size(),
        packing: match packed.layout() {
            Layout::Raw => 0,
            Layout::Ranges => 1,
            Layout::Rows => 2,
            Layout::Runs => 3,
        },
        depth_complexity: packed.depth_complexity(),
        depth_base: packed.grid().map_or(0, |grid| grid.parts()[1]),
        depth_step: packed.grid().map_or(0.0, |grid| grid.step()),
        padding: [0; 2],
    }
}
