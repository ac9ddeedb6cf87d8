//! The rasteriser's shaders on an open device, run by one thread.

use super::{
    device::{Buffer, Device, GpuError},
    work::{Frame, Item, Work},
};
use crate::math::Stop;

/// A device with the rasteriser's shaders.
pub struct Machine {
    pub device: Device,
    layout: wgpu::BindGroupLayout,
    nearest: Pipelines,
    fragments: Pipelines,
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
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let layout = d.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform),
                entry(1, storage(true)),
                entry(2, storage(true)),
                entry(3, storage(false)),
                entry(4, storage(false)),
                entry(5, storage(false)),
            ],
        });
        let (nearest, fragments) = (Pipelines::new(d, &layout, NEAREST), Pipelines::new(d, &layout, FRAGMENTS));
        device.check()?;
        Ok(Self { layout, nearest, fragments, device })
    }

    /// For every pixel the least and the greatest number among the triangles that may be the nearest, each turned round so that
    /// 0 means none: the least as its complement, the greatest plus one.
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
        let d = &self.device.device;
        let uniform = self.device.upload(&[frame], wgpu::BufferUsages::UNIFORM);
        let items = self.device.upload(items, wgpu::BufferUsages::STORAGE);
        let [first, second, third] = targets;
        let buffers = [&uniform, triangles, &items, first, second, third];
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.buffer.as_entire_binding() })
            .collect();
        let group =
            d.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &self.layout, entries: &entries });
        let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            let groups = frame.items.div_ceil(each);
            pass.dispatch_workgroups(groups.min(GROUPS), groups.div_ceil(GROUPS), 1);
        }
        self.device.queue.submit([encoder.finish()]);
        self.device.finish(stop)
    }
}

impl Pipelines {
    fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, source: &str) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self { small: pipeline("small"), large: pipeline("large") }
    }
}
