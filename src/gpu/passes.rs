//! The pipelines and passes of shaders/dmesh.wgsl.

use super::{
    device::{Buffer, Device, GpuError},
    dmesh::{Frame, Order, Part},
    samples::{DEPTH, nearest_wins},
};
use crate::runtime::dmesh;
use wgpu::{BindGroup, BindGroupEntry, BindGroupLayout, BindingResource, RenderPipeline, ShaderStages, TextureFormat};

/// Depths from here on stand for nothing: half the shader's NOTHING.
pub const CENTRES: f32 = 1.5e38;
const NOTHING: f64 = 3e38;

const FRONT: TextureFormat = TextureFormat::R32Float;
const IMAGES: TextureFormat = TextureFormat::Rgba16Float;
const PICTURE: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// Pipelines that every picture shares.
pub struct Passes {
    frame: BindGroupLayout,
    reference: BindGroupLayout,
    images: BindGroupLayout,
    /// Without and with the backs of faces.
    depth: [RenderPipeline; 2],
    color: [RenderPipeline; 2],
    combine: RenderPipeline,
    sampler: wgpu::Sampler,
}

/// A texture that passes draw into.
pub struct Target {
    pub texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl Target {
    fn new(device: &Device, format: TextureFormat, [width, height]: [u32; 2], layers: u32) -> Self {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
            | if format == DEPTH { wgpu::TextureUsages::empty() } else { wgpu::TextureUsages::TEXTURE_BINDING }
            | if format == DEPTH { wgpu::TextureUsages::empty() } else { wgpu::TextureUsages::COPY_SRC };
        let texture = device.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view }
    }

    fn layer(&self, layer: u32) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..wgpu::TextureViewDescriptor::default()
        })
    }

    fn array(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..wgpu::TextureViewDescriptor::default()
        })
    }
}

impl Passes {
    pub fn new(device: &Device) -> Self {
        let d = &device.device;
        let module = d.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("dmesh"),
            source: wgpu::ShaderSource::Wgsl(dmesh::SHADER.into()),
        });
        let both = ShaderStages::VERTEX_FRAGMENT;
        let only = ShaderStages::FRAGMENT;
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = |filterable, view_dimension| wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension,
            multisampled: false,
        };
        let (flat, array) = (wgpu::TextureViewDimension::D2, wgpu::TextureViewDimension::D2Array);
        let layout = |entries: &[(u32, ShaderStages, wgpu::BindingType)]| {
            let entry = |(binding, visibility, ty): &(u32, ShaderStages, wgpu::BindingType)| {
                wgpu::BindGroupLayoutEntry { binding: *binding, visibility: *visibility, ty: *ty, count: None }
            };
            let entries: Vec<_> = entries.iter().map(entry).collect();
            d.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
        };
        let frame = layout(&[(0, both, uniform)]);
        let reference = layout(&[
            (0, both, uniform),
            (1, only, texture(false, flat)),
            (2, only, texture(true, flat)),
            (3, only, texture(true, flat)),
            (4, only, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        ]);
        let images = layout(&[(5, only, texture(false, array))]);
        let pipeline = |entry: [&str; 2], layouts: &[Option<&BindGroupLayout>], buffers, format, back_faces| {
            pipeline(d, &module, entry, layouts, buffers, format, back_faces)
        };
        let depth = |back_faces| pipeline(["depth_vertex", "depth_fragment"], &[Some(&frame)], 1, FRONT, back_faces);
        let color = |back_faces| {
            pipeline(["color_vertex", "color_fragment"], &[Some(&frame), Some(&reference)], 4, IMAGES, back_faces)
        };
        Self {
            depth: [depth(false), depth(true)],
            color: [color(false), color(true)],
            combine: pipeline(["screen_vertex", "combine_fragment"], &[Some(&frame), Some(&images)], 0, PICTURE, true),
            sampler: d.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            }),
            frame,
            reference,
            images,
        }
    }

    /// Pass 1 with `samples` samples along a pixel's side: Z_e.
    pub fn depth(&self, device: &Device, order: &Order, samples: u32) -> Target {
        let size = order.size.map(|n| n * samples);
        let front = Target::new(device, FRONT, size, 1);
        let depth = Target::new(device, DEPTH, size, 1);
        let (_uniform, frame) = self.frame(device, &order.frame);
        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = begin(&mut encoder, &front.view, NOTHING, Some(&depth.view));
            pass.set_pipeline(&self.depth[usize::from(order.back_faces)]);
            pass.set_bind_group(0, &frame, &[]);
            for job in &order.jobs {
                draw(&mut pass, &order.parts[job.part], 1);
            }
        }
        device.queue.submit([encoder.finish()]);
        front
    }

    /// All passes.
    pub fn picture(&self, device: &Device, order: &Order) -> Result<Target, GpuError> {
        let front = self.depth(device, order, order.frame.samples);
        let size = order.size.map(|n| n * order.frame.samples);
        let images = Target::new(device, IMAGES, size, order.jobs.len().max(1) as u32);
        let depth = Target::new(device, DEPTH, size, 1);
        let (_uniform, frame) = self.frame(device, &order.frame);
        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut uniforms: Vec<Buffer> = Vec::new();
        for (layer, job) in (0..).zip(&order.jobs) {
            let part = &order.parts[job.part];
            let uniform = device.upload(&[job.uniform], wgpu::BufferUsages::UNIFORM);
            let group = bind(
                device,
                &self.reference,
                &[
                    (0, uniform.buffer.as_entire_binding()),
                    (1, BindingResource::TextureView(&front.view)),
                    (2, BindingResource::TextureView(&part.picture)),
                    (3, BindingResource::TextureView(&part.normal_map)),
                    (4, BindingResource::Sampler(&self.sampler)),
                ],
            );
            uniforms.push(uniform);
            let target = images.layer(layer);
            let mut pass = begin(&mut encoder, &target, 0.0, Some(&depth.view));
            pass.set_pipeline(&self.color[usize::from(order.back_faces)]);
            pass.set_bind_group(0, &frame, &[]);
            pass.set_bind_group(1, &group, &[]);
            draw(&mut pass, part, 4);
        }
        let picture = Target::new(device, PICTURE, order.size, 1);
        let group = bind(device, &self.images, &[(5, BindingResource::TextureView(&images.array()))]);
        {
            let mut pass = begin(&mut encoder, &picture.view, 0.0, None);
            pass.set_pipeline(&self.combine);
            pass.set_bind_group(0, &frame, &[]);
            pass.set_bind_group(1, &group, &[]);
            pass.draw(0..3, 0..1);
        }
        device.queue.submit([encoder.finish()]);
        device.check()?;
        Ok(picture)
    }

    fn frame(&self, device: &Device, frame: &Frame) -> (Buffer, BindGroup) {
        let uniform = device.upload(&[*frame], wgpu::BufferUsages::UNIFORM);
        let group = bind(device, &self.frame, &[(0, uniform.buffer.as_entire_binding())]);
        (uniform, group)
    }
}

fn bind(device: &Device, layout: &BindGroupLayout, entries: &[(u32, BindingResource)]) -> BindGroup {
    let entry = |e: &(u32, _)| BindGroupEntry { binding: e.0, resource: Clone::clone(&e.1) };
    let entries: Vec<_> = entries.iter().map(entry).collect();
    device.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// A pass into one target, cleared to `clear`; the depth buffer is cleared to the far plane.
fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    clear: f64,
    depth: Option<&wgpu::TextureView>,
) -> wgpu::RenderPass<'a> {
    let color = wgpu::Color { r: clear, g: 0.0, b: 0.0, a: 0.0 };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..wgpu::RenderPassDescriptor::default()
    })
}

fn draw(pass: &mut wgpu::RenderPass, part: &Part, buffers: usize) {
    if part.count == 0 {
        return;
    }
    for (slot, buffer) in (0..).zip(&part.vertices[..buffers]) {
        pass.set_vertex_buffer(slot, buffer.buffer.slice(..));
    }
    pass.set_index_buffer(part.indices.buffer.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..part.count, 0, 0..1);
}

/// `buffers`: how many of position, normal, uv and quality the vertex shader takes; without any, there is no depth buffer.
fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry: [&str; 2],
    layouts: &[Option<&BindGroupLayout>],
    buffers: usize,
    format: TextureFormat,
    back_faces: bool,
) -> RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: layouts,
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let kinds = [
        wgpu::VertexFormat::Float32x3,
        wgpu::VertexFormat::Float32x3,
        wgpu::VertexFormat::Float32x2,
        wgpu::VertexFormat::Float32,
    ];
    let attributes: Vec<_> = (0..)
        .zip(kinds)
        .map(|(shader_location, format)| wgpu::VertexAttribute { format, offset: 0, shader_location })
        .collect();
    let buffer = |a| {
        let attributes: &[wgpu::VertexAttribute] = std::slice::from_ref(a);
        let array_stride = attributes[0].format.size();
        Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
    };
    let layouts: Vec<_> = attributes[..buffers].iter().map(buffer).collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry[1]),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(entry[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &layouts,
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: (!back_faces).then_some(wgpu::Face::Back),
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: (buffers > 0).then(nearest_wins),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry[1]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
