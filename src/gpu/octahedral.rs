//! Octahedral impostors drawn by a device: the draw call of shaders/octahedral.wgsl.
//!
//! The device filters with 8 bits of fraction and in 32-bit floats, so outlines may differ from the CPU's by a sample.

use super::{
    DrawnByGpu, Gpu,
    device::{Device, GpuError},
    dmesh,
    machine::Machine,
    samples::{self, DEPTH, PICTURE, begin, resolve, target},
};
use crate::{
    array::Array,
    math::Stop,
    octahedral::Atlas,
    raster::{Rendering, Shading},
    runtime::octahedral::{Model, SHADER},
    view::{Projection, View},
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// `Frame` of shaders/octahedral.wgsl.
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
    pub shading: u32,
    pub sample_size: f32,
    pub padding: [f32; 2],
}

/// `Impostor` of shaders/octahedral.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Impostor {
    pub window: [f32; 4],
    pub card: [[f32; 4]; 4],
    pub corners: u32,
    pub frames: u32,
    pub tile: u32,
    pub levels: u32,
    pub hemi: u32,
    pub steps: u32,
    pub emits: u32,
    pub padding: u32,
}

impl Gpu {
    /// Draws a view of an impostor: what its stand-in draws, but each sample is rounded to 8 bits before pixels take their mean.
    ///
    /// # Errors
    /// Where the device fails, its memory or its textures are too small, or the shading is noise, which the shader does not have.
    pub fn draw_octahedral(
        &self,
        model: Arc<Model>,
        view: &View,
        how: &Rendering,
        stop: &Stop,
    ) -> Result<DrawnByGpu, GpuError> {
        if matches!(how.shading, Shading::Noise(_)) {
            return Err(GpuError::Failed("octahedral.wgsl has no noise".into()));
        }
        let n = how.samples_per_axis;
        let texels: u64 = model.levels().iter().flat_map(|l| l.images()).map(|i| i.len() as u64 * 4).sum();
        let need = 2 * texels + u64::from(view.width) * u64::from(view.height) * u64::from(n * n) * 24;
        if need > self.room().memory {
            return Err(GpuError::TooSmall { need, limit: self.room().memory });
        }
        let (view, how, stop) = (*view, *how, stop.clone());
        let (colors, depths) = self.call(move |machine| draw(machine, &model, &view, &how, &stop))?;
        Ok(resolve(&view, how.samples_per_axis, how.background, &colors, &depths))
    }
}

/// The samples' colours and depths as the device stores them, row by row.
fn draw(
    machine: &Machine,
    model: &Model,
    view: &View,
    how: &Rendering,
    stop: &Stop,
) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
    let device = &machine.device;
    let d = &device.device;
    let n = how.samples_per_axis;
    let size = [view.width * n, view.height * n];
    let most = d.limits().max_texture_dimension_2d;
    if size.iter().any(|s| *s > most) || model.impostor().atlas.side > most {
        return Err(GpuError::Failed(format!("a view or an atlas too large for the adapter's limit of {most} a side")));
    }
    let (frame, impostor) = uniforms(model, view, how);
    let corners = impostor.corners;
    let uniform = wgpu::BufferUsages::UNIFORM;
    let (frame, impostor) = (device.upload(&[frame], uniform), device.upload(&[impostor], uniform));
    let levels = model.levels();
    let light = wgpu::TextureFormat::Rgba8UnormSrgb;
    let color = atlas(device, levels, light, |l| Some(&l.color));
    let normal = atlas(device, levels, wgpu::TextureFormat::Rgba8Unorm, |l| Some(&l.normal));
    let emissive = atlas(device, levels, light, |l| l.emissive.as_ref());
    let sampler = d.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    let pipeline = pipeline(d);
    let resources = [
        frame.buffer.as_entire_binding(),
        impostor.buffer.as_entire_binding(),
        wgpu::BindingResource::TextureView(&color),
        wgpu::BindingResource::TextureView(&normal),
        wgpu::BindingResource::TextureView(&emissive),
        wgpu::BindingResource::Sampler(&sampler),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    let layout = pipeline.get_bind_group_layout(0);
    let group = d.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
    let (picture, depth) = (target(d, PICTURE, size), target(d, DEPTH, size));
    let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = begin(&mut encoder, &picture, &depth);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3 * (corners - 2), 0..1);
    }
    device.queue.submit([encoder.finish()]);
    device.check()?;
    Ok((dmesh::read(device, &picture, size, stop)?, dmesh::read(device, &depth, size, stop)?))
}

fn uniforms(model: &Model, view: &View, how: &Rendering) -> (Frame, Impostor) {
    let impostor = model.impostor();
    // The same camera and light as those of depth-meshes.
    let shared = dmesh::frame(view, how, 0);
    let (Projection::Perspective { left, right, .. } | Projection::Orthographic { left, right, .. }) = view.projection;
    let frame = Frame {
        clip: shared.clip,
        depth: shared.depth,
        eye: shared.eye,
        to_sun: shared.to_sun,
        sun: shared.sun,
        sky: shared.sky,
        ground: shared.ground,
        shading: shared.shading,
        sample_size: ((right - left) / f64::from(view.width * how.samples_per_axis)) as f32,
        padding: [0.0; 2],
    };
    let mut card = [[0.0; 4]; 4];
    for (i, corner) in impostor.card.iter().enumerate().take(8) {
        card[i / 2][i % 2 * 2..][..2].copy_from_slice(&corner.map(|c| c as f32));
    }
    let [x, y, z] = impostor.centre.as_vec3().to_array();
    let uniform = Impostor {
        window: [x, y, z, impostor.radius as f32],
        card,
        corners: impostor.card.len() as u32,
        frames: impostor.grid.side,
        tile: impostor.tile,
        levels: model.levels().len() as u32,
        hemi: u32::from(impostor.grid.hemi),
        steps: model.drawing().steps,
        emits: u32::from(impostor.atlas.emissive.is_some()),
        padding: 0,
    };
    (frame, uniform)
}

fn pipeline(d: &wgpu::Device) -> wgpu::RenderPipeline {
    let entries = ["card_vertex", "card_fragment"];
    let call = samples::DrawCall { label: "octahedral", wgsl: SHADER, entries, layout: None, buffers: &[], cull: None };
    samples::pipeline(d, &call)
}

/// An image of all levels; one texel where there is none.
fn atlas(
    device: &Device,
    levels: &[Atlas],
    format: wgpu::TextureFormat,
    image: fn(&Atlas) -> Option<&Array<[u8; 4]>>,
) -> wgpu::TextureView {
    let images: Vec<(u32, &[[u8; 4]])> = levels.iter().filter_map(|l| Some((l.side, image(l)?.as_slice()))).collect();
    let images = if images.is_empty() { vec![(1, &[[0; 4]][..])] } else { images };
    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: images[0].0, height: images[0].0, depth_or_array_layers: 1 },
        mip_level_count: images.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, (side, texels)) in (0..).zip(images) {
        let target = wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side * 4), rows_per_image: None };
        let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
        device.queue.write_texture(target, bytemuck::cast_slice(texels), layout, size);
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
