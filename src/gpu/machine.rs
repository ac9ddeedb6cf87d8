//! The rasteriser's shaders on an open device, run by one thread.

use super::{
    device::{Buffer, Device, GpuError},
    ori_pipeline::Pipeline,
    passes::Passes,
    work::{Frame, Item, Work},
};
use crate::{math::Stop, sprite};
use std::cell::OnceCell;

/// A device with the rasteriser's shaders.
pub struct Machine {
    pub device: Device,
    layout: wgpu::BindGroupLayout,
    nearest: Pipelines,
    fragments: Pipelines,
    /// Made when it is first wanted.
    classify: OnceCell<(wgpu::BindGroupLayout, wgpu::ComputePipeline)>,
    pub(super) dmesh: OnceCell<Passes>,
    pub(super) ori: OnceCell<Pipeline>,
}

/// One operation's entry points.
struct Pipelines {
    small: wgpu::ComputePipeline,
    large: wgpu::ComputePipeline,
}

/// Sources of the operations' shaders.
pub const NEAREST: &str = concat!(include_str!("../../shaders/cover.wgsl"), include_str!("../../shaders/nearest.wgsl"));
pub const FRAGMENTS: &str =
    concat!(include_str!("../../shaders/cover.wgsl"), include_str!("../../shaders/fragments.wgsl"));

/// `Sprite` of shaders/sprite.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Sprite {
    pub world_to_texture: [[f32; 4]; 3],
    pub region: [u32; 4],
    pub sections: [u32; 4],
    pub size: [u32; 2],
    pub packing: u32,
    pub depth_complexity: u32,
    pub depth_base: u32,
    pub depth_step: f32,
    pub padding: [u32; 2],
}

/// Source of the shader that classifies points.
pub fn classify_source() -> String {
    [sprite::SHADER, sprite::CLASSIFY].concat()
}

#[cfg(test)]
pub fn probe_source() -> String {
    [sprite::SHADER, include_str!("../../shaders/probe.wgsl")].concat()
}

/// Work groups in a row of a dispatch; every device allows as many.
const GROUPS: u32 = 65535;
/// Threads of a work group.
const THREADS: u32 = 64;
/// Most items handed over at once. One of `large` may stand for 4,096 samples: drivers end what takes seconds.
const SMALL: u64 = 1 << 20;
const LARGE: u64 = 1 << 15;

impl Machine {
    pub fn new(device: Device) -> Result<Self, GpuError> {
        let d = &device.device;
        let layout = layout_of(d, &[Kind::Uniform, Kind::Read, Kind::Read, Kind::Write, Kind::Write, Kind::Write]);
        let (nearest, fragments) = (Pipelines::new(d, &layout, NEAREST), Pipelines::new(d, &layout, FRAGMENTS));
        device.check()?;
        Ok(Self {
            layout,
            nearest,
            fragments,
            classify: OnceCell::new(),
            dmesh: OnceCell::new(),
            ori: OnceCell::new(),
            device,
        })
    }

    /// For every pixel the least and the greatest number among the triangles that may be the nearest, biased so that
    /// zero means no triangle: the least as its complement, the greatest plus one.
    pub fn nearest(&self, work: &Work, stop: &Stop) -> Result<[Vec<u32>; 2], GpuError> {
        let [near, least, greatest] = [(); 3].map(|()| self.device.zeros(work.pixels as u64 * 4));
        for round in 0..2 {
            self.round(work, round, &self.nearest, [&near, &least, &greatest], stop)?;
        }
        Ok([self.device.read(&least, work.pixels, stop)?, self.device.read(&greatest, work.pixels, stop)?])
    }

    /// How many triangles cover each pixel.
    pub fn count(&self, work: &Work, stop: &Stop) -> Result<Vec<u32>, GpuError> {
        let (counts, unused) = (self.device.zeros(work.pixels as u64 * 4), [(); 2].map(|()| self.device.zeros(16)));
        self.round(work, 0, &self.fragments, [&counts, &unused[0], &unused[1]], stop)?;
        self.device.read(&counts, work.pixels, stop)
    }

    /// The numbers of the triangles that cover each pixel, in any order; a pixel's begin at `starts`, and there are `total`.
    pub fn list(&self, work: &Work, starts: &[u32], total: usize, stop: &Stop) -> Result<Vec<u32>, GpuError> {
        let cursor = self.device.upload(starts, wgpu::BufferUsages::STORAGE);
        let [list, unused] = [total, 4].map(|n| self.device.zeros(n as u64 * 4));
        self.round(work, 1, &self.fragments, [&cursor, &list, &unused], stop)?;
        self.device.read(&list, total, stop)
    }

    /// What `probe` finds along `rays`: see shaders/probe.wgsl.
    #[cfg(test)]
    pub fn probe(
        &self,
        sprites: &[Sprite],
        data: &[u8],
        rays: &[[[f32; 4]; 2]],
        stop: &Stop,
    ) -> Result<Vec<u32>, GpuError> {
        let d = &self.device.device;
        let layout = layout_of(d, &[Kind::Read, Kind::Read, Kind::Read, Kind::Write]);
        let pipeline = Pipelines::one(d, &layout, &probe_source(), "probe");
        let sprites = self.device.upload(sprites, wgpu::BufferUsages::STORAGE);
        let data = self.device.upload(data, wgpu::BufferUsages::STORAGE);
        let uploaded = self.device.upload(rays, wgpu::BufferUsages::STORAGE);
        let found = self.device.zeros(rays.len() as u64 * 16);
        let groups = (rays.len() as u32).div_ceil(THREADS);
        self.run(&pipeline, &layout, &[&sprites, &data, &uploaded, &found], groups, stop)?;
        self.device.read(&found, rays.len() * 4, stop)
    }

    /// Which of `points`, in texture space, lie inside the first sprite, whose file is the beginning of `data`: a bit each.
    pub fn classify(
        &self,
        sprite: Sprite,
        data: &[u8],
        points: &[[f32; 4]],
        stop: &Stop,
    ) -> Result<Vec<u32>, GpuError> {
        let d = &self.device.device;
        let (layout, pipeline) = self.classify.get_or_init(|| {
            let layout = layout_of(d, &[Kind::Read, Kind::Read, Kind::Read, Kind::Write]);
            let pipeline = Pipelines::one(d, &layout, &classify_source(), "classify");
            (layout, pipeline)
        });
        let words = points.len().div_ceil(32);
        let sprite = self.device.upload(&[sprite], wgpu::BufferUsages::STORAGE);
        let data = self.device.upload(data, wgpu::BufferUsages::STORAGE);
        let uploaded = self.device.upload(points, wgpu::BufferUsages::STORAGE);
        let inside = self.device.zeros(words as u64 * 4);
        let groups = (points.len() as u32).div_ceil(THREADS);
        self.run(pipeline, layout, &[&sprite, &data, &uploaded, &inside], groups, stop)?;
        self.device.read(&inside, words, stop)
    }

    /// One round of an operation over all triangles.
    fn round(
        &self,
        work: &Work,
        round: u32,
        pipelines: &Pipelines,
        targets: [&Buffer; 3],
        stop: &Stop,
    ) -> Result<(), GpuError> {
        // Items and the copies that they are uploaded from take an eighth of the memory.
        let most = |items| (self.device.memory / 16 / size_of::<Item>() as u64).clamp(1, items) as usize;
        for batch in work.batches.iter().filter(|b| !(b.small.is_empty() && b.large.is_empty())) {
            let triangles = self.device.upload(&batch.triangles, wgpu::BufferUsages::STORAGE);
            let lists = [(&batch.small, &pipelines.small, THREADS, SMALL), (&batch.large, &pipelines.large, 1, LARGE)];
            for (items, pipeline, each, limit) in lists {
                for items in items.chunks(most(limit)) {
                    let frame = Frame { base: batch.base, round, items: items.len() as u32, ..work.frame };
                    self.dispatch(frame, items, &triangles, targets, pipeline, each, stop)?;
                }
            }
        }
        Ok(())
    }

    /// Dispatches and waits. `each`: items of a work group.
    fn dispatch(
        &self,
        frame: Frame,
        items: &[Item],
        triangles: &Buffer,
        targets: [&Buffer; 3],
        pipeline: &wgpu::ComputePipeline,
        each: u32,
        stop: &Stop,
    ) -> Result<(), GpuError> {
        let uniform = self.device.upload(&[frame], wgpu::BufferUsages::UNIFORM);
        let items = self.device.upload(items, wgpu::BufferUsages::STORAGE);
        let [first, second, third] = targets;
        let buffers = [&uniform, triangles, &items, first, second, third];
        self.run(pipeline, &self.layout, &buffers, frame.items.div_ceil(each), stop)
    }

    /// Dispatches so many work groups, with buffers bound in their order, and waits.
    fn run(
        &self,
        pipeline: &wgpu::ComputePipeline,
        layout: &wgpu::BindGroupLayout,
        buffers: &[&Buffer],
        groups: u32,
        stop: &Stop,
    ) -> Result<(), GpuError> {
        let d = &self.device.device;
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.buffer.as_entire_binding() })
            .collect();
        let group = d.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups.min(GROUPS), groups.div_ceil(GROUPS), 1);
        }
        self.device.queue.submit([encoder.finish()]);
        self.device.finish(stop)
    }
}

/// What a shader does with a buffer.
#[derive(Clone, Copy)]
enum Kind {
    Uniform,
    Read,
    Write,
}

/// Buffers bound from 0 on.
fn layout_of(device: &wgpu::Device, kinds: &[Kind]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(kinds)
        .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: match kind {
                    Kind::Uniform => wgpu::BufferBindingType::Uniform,
                    Kind::Read => wgpu::BufferBindingType::Storage { read_only: true },
                    Kind::Write => wgpu::BufferBindingType::Storage { read_only: false },
                },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

impl Pipelines {
    fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, source: &str) -> Self {
        let pipeline = |entry| Self::one(device, layout, source, entry);
        Self { small: pipeline("small"), large: pipeline("large") }
    }

    fn one(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, source: &str, entry: &str) -> wgpu::ComputePipeline {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
    }
}
