//! Pipeline and textures of shaders/ori.wgsl.

use super::{
    device::{Buffer, Device, GpuError},
    ori::{Parts, depth_texels},
    samples,
};
use crate::{
    raster::Mips,
    runtime::ori::{Model, SHADER},
};
use wgpu::{BindingResource, ShaderStages, TextureFormat};

/// The draw call.
pub struct Pipeline {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
}

/// The maps' images, a layer each.
pub struct Arrays {
    depth: wgpu::TextureView,
    color: wgpu::TextureView,
    normal: wgpu::TextureView,
    emissive: wgpu::TextureView,
}

/// Vertices of the box.
const BOX: u32 = 36;

impl Arrays {
    /// # Errors
    /// Where the adapter allows fewer layers or smaller textures.
    pub fn new(device: &Device, model: &Model) -> Result<Self, GpuError> {
        let (side, layers) = (model.maps[0].field.side, model.maps.len() as u32);
        let limits = device.device.limits();
        if side > limits.max_texture_dimension_2d || layers > limits.max_texture_array_layers {
            let what = format!(
                "{layers} maps of {side} texels a side; the adapter allows {} of {}",
                limits.max_texture_array_layers, limits.max_texture_dimension_2d
            );
            return Err(GpuError::Failed(what));
        }
        let depths = model.ori().maps.iter().map(|(_, m)| depth_texels(m.bits, &m.depth));
        let (formats, depths): (Vec<_>, Vec<_>) = depths.unzip();
        let one_level: Vec<_> = depths.into_iter().map(|bytes| vec![(side, bytes)]).collect();
        let levels = |mips: &Mips, channels: usize| {
            let bytes = |texels: &[[u8; 4]]| texels.iter().flat_map(|t| &t[..channels]).copied().collect::<Vec<u8>>();
            mips.levels().iter().map(|l| (l.width, bytes(&l.texels))).collect::<Vec<_>>()
        };
        let each = |get: &dyn Fn(usize) -> Vec<(u32, Vec<u8>)>| (0..model.maps.len()).map(get).collect::<Vec<_>>();
        let color = each(&|i| levels(&model.maps[i].color, 4));
        let normal = each(&|i| levels(&model.maps[i].normal, 2));
        let emissive: Option<Vec<_>> =
            model.maps.iter().map(|m| m.emissive.as_ref().map(|mips| levels(mips, 4))).collect();
        // One texel where nothing is emitted.
        let emissive = emissive.unwrap_or_else(|| vec![vec![(1, vec![0; 4])]]);
        let light = TextureFormat::Rgba8UnormSrgb;
        Ok(Self {
            depth: array(device, formats[0], &one_level),
            color: array(device, light, &color),
            normal: array(device, TextureFormat::Rg8Unorm, &normal),
            emissive: array(device, light, &emissive),
        })
    }
}

/// A texture of layers, each a list of levels: width and bytes.
fn array(device: &Device, format: TextureFormat, layers: &[Vec<(u32, Vec<u8>)>]) -> wgpu::TextureView {
    let side = layers[0][0].0;
    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers.len() as u32 },
        mip_level_count: layers[0].len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (z, levels) in (0..).zip(layers) {
        for (mip_level, (side, bytes)) in (0..).zip(levels) {
            let origin = wgpu::Origin3d { x: 0, y: 0, z };
            let target = wgpu::TexelCopyTextureInfo { mip_level, origin, ..texture.as_image_copy() };
            let row = bytes.len() as u32 / side;
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
            let size = wgpu::Extent3d { width: *side, height: *side, depth_or_array_layers: 1 };
            device.queue.write_texture(target, bytes, layout, size);
        }
    }
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    })
}

impl Pipeline {
    pub fn new(d: &wgpu::Device) -> Self {
        let (both, only) = (ShaderStages::VERTEX_FRAGMENT, ShaderStages::FRAGMENT);
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let uniform = buffer(wgpu::BufferBindingType::Uniform);
        let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true });
        let texture = |filterable| wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let entries = [
            (both, uniform),
            (both, uniform),
            (only, storage),
            (both, storage),
            (only, storage),
            (only, texture(false)),
            (only, texture(true)),
            (only, texture(true)),
            (only, texture(true)),
            (only, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        ];
        let entries: Vec<_> = (0..)
            .zip(entries)
            .map(|(binding, (visibility, ty))| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
            .collect();
        let layout =
            d.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("ori"), entries: &entries });
        let pipeline_layout = d.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("ori"),
            bind_group_layouts: &[Some(&layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let call = samples::DrawCall {
            label: "ori",
            wgsl: SHADER,
            entries: ["box_vertex", "ori_fragment"],
            layout: Some(&pipeline_layout),
            buffers: &[],
            cull: Some(wgpu::Face::Front),
        };
        let pipeline = samples::pipeline(d, &call);
        let sampler = d.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        Self { layout, pipeline, sampler }
    }

    /// Draws `count` instances of an impostor.
    pub fn draw(
        &self,
        d: &wgpu::Device,
        pass: &mut wgpu::RenderPass,
        frame: &Buffer,
        parts: &Parts,
        places: &Buffer,
        count: u32,
    ) {
        let arrays = &parts.arrays;
        let resources = [
            frame.buffer.as_entire_binding(),
            parts.impostor.buffer.as_entire_binding(),
            parts.maps.buffer.as_entire_binding(),
            places.buffer.as_entire_binding(),
            parts.ranges.buffer.as_entire_binding(),
            BindingResource::TextureView(&arrays.depth),
            BindingResource::TextureView(&arrays.color),
            BindingResource::TextureView(&arrays.normal),
            BindingResource::TextureView(&arrays.emissive),
            BindingResource::Sampler(&self.sampler),
        ];
        let entries: Vec<_> =
            (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        let group = d.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ori"),
            layout: &self.layout,
            entries: &entries,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..BOX, 0..count);
    }
}
