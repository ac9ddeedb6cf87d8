//! Relief impostors drawn by a device: the draw call of shaders/ori.wgsl.
//!
//! The device computes in 32-bit floats where the CPU prepares rays in 64, and filters with 8 bits of fraction: a ray that grazes a surface may
//! miss it on one of them.

use super::{
    DrawnByGpu, Gpu,
    device::{Buffer, Device, GpuError},
    dmesh,
    machine::Machine,
    ori_pipeline::{Arrays, Pipeline},
    samples::{DEPTH, PICTURE, begin, resolve, target},
};
use crate::{
    image::Picture,
    math::Stop,
    raster::{Rendering, Shading},
    relief::{DepthBits, Search, Strategy},
    runtime::ori::{Instance, MAPS, Model},
    view::{Projection, View},
};
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use std::sync::Arc;

/// `Frame` of shaders/ori.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Frame {
    pub clip: [[f32; 4]; 4],
    pub depth: [f32; 4],
    pub eye: [f32; 4],
    pub to_sun: [f32; 4],
    pub sun: [f32; 4],
    pub sky: [f32; 4],
    pub ground: [f32; 4],
    pub near: f32,
    pub far: f32,
    pub sample_size: f32,
    pub shading: u32,
}

/// `Impostor` of shaders/ori.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Impostor {
    pub centre: [f32; 4],
    pub extent: [f32; 4],
    pub side: u32,
    pub squares: u32,
    pub depths: u32,
    pub codes: u32,
    pub levels: u32,
    pub emits: u32,
    pub strategy: u32,
    pub steps: u32,
    pub halvings: u32,
    pub wall: f32,
    pub padding: [u32; 2],
}

/// `Map` of shaders/ori.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Map {
    pub rows: [[f32; 4]; 3],
    pub window: [f32; 4],
    pub deep: f32,
    pub step: f32,
    pub texel: f32,
    pub first: u32,
}

/// `Instance` of shaders/ori.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Place {
    pub place: [f32; 4],
    pub rotation: [f32; 4],
    pub maps: [u32; 4],
}

/// A relief impostor in a device's memory.
#[derive(Clone)]
pub struct LoadedOri {
    pub(super) model: Arc<Model>,
    parts: Arc<Parts>,
    /// What it takes there.
    bytes: u64,
}

/// Its buffers and textures.
pub(super) struct Parts {
    pub impostor: Buffer,
    pub maps: Buffer,
    pub ranges: Buffer,
    pub arrays: Arrays,
}

/// Stands for infinite depths, which shaders do not have to know.
const NOTHING: f32 = 3e38;
/// Ends an instance's list of maps.
const NO_MAP: u32 = 0xffff;

impl Gpu {
    /// Copies an impostor into the device's memory.
    ///
    /// # Errors
    /// Where the device fails, or its memory, its buffers or its textures are too small.
    pub fn load_ori(&self, model: Arc<Model>) -> Result<LoadedOri, GpuError> {
        let bytes = bytes_of(&model);
        if bytes > self.room().memory {
            return Err(GpuError::TooSmall { need: bytes, limit: self.room().memory });
        }
        let inner = model.clone();
        let parts = self.call(move |machine| {
            let parts = upload(&machine.device, &inner)?;
            machine.device.check()?;
            Ok(parts)
        })?;
        Ok(LoadedOri { model, parts: Arc::new(parts), bytes })
    }

    /// Draws a view of instances: what [`draw_instances`](crate::runtime::ori::draw_instances) draws, but with `how.samples_per_axis` squared samples of
    /// every pixel, textures filtered over a sample. Each sample is rounded to 8 bits before pixels take their mean. Instances of models that are
    /// not there are left out.
    ///
    /// # Errors
    /// Where the device fails, its memory or its textures are too small for the view, or the shading is noise, which the shader does not have.
    pub fn draw_ori(
        &self,
        models: &[&LoadedOri],
        instances: &[Instance],
        view: &View,
        how: &Rendering,
        stop: &Stop,
    ) -> Result<DrawnByGpu, GpuError> {
        if matches!(how.shading, Shading::Noise(_)) {
            return Err(GpuError::Failed("ori.wgsl has no noise".into()));
        }
        if view.width == 0 || view.height == 0 {
            return Ok(DrawnByGpu { picture: Picture::default(), depth: Vec::new() });
        }
        let n = how.samples_per_axis.max(1);
        let samples = u64::from(view.width) * u64::from(view.height) * u64::from(n) * u64::from(n);
        let loaded: u64 = models.iter().map(|m| m.bytes).sum();
        // Colour and depth of a sample as targets, as buffers and as what those are read through; instances with what they are filled through.
        let need = loaded + samples * 24 + 2 * std::mem::size_of_val(instances) as u64;
        if need > self.room().memory {
            return Err(GpuError::TooSmall { need, limit: self.room().memory });
        }
        let batches: Vec<Batch> = (0..)
            .zip(models)
            .map(|(number, loaded)| {
                let own = instances.par_iter().filter(|i| i.model == number);
                let places = own.map(|i| place(&loaded.model, i, view)).collect();
                Batch { parts: loaded.parts.clone(), places }
            })
            .collect();
        let order = Order { view: *view, how: *how, batches };
        let stop = stop.clone();
        // Where no sample lies at a pixel's centre, depths come from a picture of their own.
        let (samples, centres) = self.call(move |machine| {
            let samples = draw(machine, &order, n, &stop)?;
            let centres = if n.is_multiple_of(2) { Some(draw(machine, &order, 1, &stop)?) } else { None };
            Ok((samples, centres))
        })?;
        let drawn = resolve(view, n, how.background, &samples[0], &samples[1]);
        let depth = centres.map(|c| resolve(view, 1, how.background, &c[0], &c[1]).depth);
        Ok(DrawnByGpu { depth: depth.unwrap_or(drawn.depth), picture: drawn.picture })
    }
}

/// Instances of one model.
struct Batch {
    parts: Arc<Parts>,
    places: Vec<Place>,
}

/// One picture.
struct Order {
    view: View,
    how: Rendering,
    batches: Vec<Batch>,
}

fn bytes_of(model: &Model) -> u64 {
    let Some(first) = model.maps.first() else { return 0 };
    let (side, squares) = (u64::from(first.field.side), u64::from(first.field.side.next_power_of_two()));
    let emissive = if first.emissive.is_some() { 4 } else { 0 };
    // Mip levels and pyramids are a third more; buffers exist with what they are filled through, and so do textures.
    let texels = side * side * ((4 + 2 + emissive) * 4 / 3 + 4) * 2;
    let ranges = squares * squares * 8 * 4 / 3 * 2;
    model.maps.len() as u64 * (texels + ranges)
}

fn upload(device: &Device, model: &Model) -> Result<Parts, GpuError> {
    let ori = model.ori();
    let first = &model.maps[0];
    let bits = ori.maps[0].1.bits;
    let ranges: Vec<[f32; 2]> = model
        .maps
        .iter()
        .flat_map(|m| m.field.ranges())
        .map(|range| range.map(|w| w.clamp(-NOTHING, NOTHING)))
        .collect();
    let each = ranges.len() / model.maps.len();
    let maps = model.maps.iter().enumerate().map(|(i, m)| Map {
        rows: m.field.rows(model.centre).map(|r| r.as_vec4().to_array()),
        window: m.field.window(),
        deep: m.field.deep,
        step: (m.range / m.field.texel / f64::from(bits.levels() - 1)) as f32,
        texel: m.field.texel as f32,
        first: (i * each) as u32,
    });
    let (steps, halvings) = match ori.drawing.trace.search {
        Search::Pyramid => (0, 0),
        Search::Linear { steps, halvings } => (steps.max(1), halvings),
    };
    let reach = model.reach();
    let impostor = Impostor {
        centre: model.centre.extend(1.0).as_vec4().to_array(),
        extent: ((reach.max - reach.min) * 0.5).extend(0.0).as_vec4().to_array(),
        side: first.field.side,
        squares: first.field.side.next_power_of_two(),
        depths: bits.levels(),
        codes: bits.codes(),
        levels: first.color.levels().len() as u32,
        emits: u32::from(first.emissive.is_some()),
        strategy: number_of(ori.drawing.strategy),
        steps,
        halvings,
        wall: ori.drawing.trace.wall,
        padding: [0; 2],
    };
    let bytes = std::mem::size_of_val(&ranges[..]) as u64;
    if bytes > device.largest_buffer() {
        return Err(GpuError::TooSmall { need: bytes, limit: device.largest_buffer() });
    }
    let storage = wgpu::BufferUsages::STORAGE;
    Ok(Parts {
        arrays: Arrays::new(device, model)?,
        impostor: device.upload(&[impostor], wgpu::BufferUsages::UNIFORM),
        maps: device.upload(&maps.collect::<Vec<_>>(), storage),
        ranges: device.upload(&ranges, storage),
    })
}

/// Its number in section 3.3.
fn number_of(strategy: Strategy) -> u32 {
    match strategy {
        Strategy::Plane => 1,
        Strategy::Depth => 2,
        Strategy::Direction => 3,
        Strategy::Normal => 4,
        Strategy::BiasedDepth => 5,
    }
}

/// What stands for a depth code in the texture, and its format.
pub(super) fn depth_texels(bits: DepthBits, codes: &[u16]) -> (wgpu::TextureFormat, Vec<u8>) {
    match bits {
        DepthBits::Eight => (wgpu::TextureFormat::R8Unorm, codes.iter().map(|c| *c as u8).collect()),
        // Textures of 16 bits normalised are a feature that not every device has.
        DepthBits::Sixteen => {
            let values = codes.iter().flat_map(|c| (f32::from(*c) / 65535.0).to_le_bytes());
            (wgpu::TextureFormat::R32Float, values.collect())
        }
    }
}

fn place(model: &Model, instance: &Instance, view: &View) -> Place {
    let mut maps = [NO_MAP; MAPS];
    for (slot, map) in maps.iter_mut().zip(model.select(&instance.view(view))) {
        *slot = map;
    }
    Place {
        place: instance.translation.extend(instance.scale).as_vec4().to_array(),
        rotation: instance.rotation.as_quat().to_array(),
        maps: std::array::from_fn(|k| maps[2 * k] | maps[2 * k + 1] << 16),
    }
}

/// `n`: samples along a pixel's side.
fn frame(view: &View, how: &Rendering, n: u32) -> Frame {
    // The same camera and light as those of depth-meshes.
    let shared = dmesh::frame(view, how, 0);
    let (Projection::Perspective { left, right, .. } | Projection::Orthographic { left, right, .. }) = view.projection;
    Frame {
        clip: shared.clip,
        depth: shared.depth,
        eye: shared.eye,
        to_sun: shared.to_sun,
        sun: shared.sun,
        sky: shared.sky,
        ground: shared.ground,
        near: view.near as f32,
        far: view.far as f32,
        sample_size: ((right - left) / (f64::from(view.width) * f64::from(n))) as f32,
        shading: shared.shading,
    }
}

/// The samples' colours and depths as the device stores them, row by row.
fn draw(machine: &Machine, order: &Order, n: u32, stop: &Stop) -> Result<[Vec<u32>; 2], GpuError> {
    let device = &machine.device;
    let d = &device.device;
    let pipeline = machine.ori.get_or_init(|| Pipeline::new(d));
    let size = [order.view.width, order.view.height].map(|s| s.saturating_mul(n));
    let most = d.limits().max_texture_dimension_2d;
    if size.iter().any(|s| *s > most) {
        let [width, height] = [order.view.width, order.view.height];
        let what =
            format!("a view of {width} × {height} pixels of {n} × {n} samples; the adapter allows {most} a side");
        return Err(GpuError::Failed(what));
    }
    let frame = device.upload(&[frame(&order.view, &order.how, n)], wgpu::BufferUsages::UNIFORM);
    let (picture, depth) = (target(d, PICTURE, size), target(d, DEPTH, size));
    let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    // They live until the work is done.
    let mut buffers: Vec<Buffer> = Vec::new();
    {
        let mut pass = begin(&mut encoder, &picture, &depth);
        for batch in order.batches.iter().filter(|b| !b.places.is_empty()) {
            let places = device.upload(&batch.places, wgpu::BufferUsages::STORAGE);
            pipeline.draw(d, &mut pass, &frame, &batch.parts, &places, batch.places.len() as u32);
            buffers.push(places);
        }
    }
    device.queue.submit([encoder.finish()]);
    device.check()?;
    Ok([dmesh::read(device, &picture, size, stop)?, dmesh::read(device, &depth, size, stop)?])
}
