//! Stand-ins of a cell of hybrid textured LOD meshes drawn by a device: the draw calls of shaders/hybrid_lod.wgsl.
//!
//! Coverage is the device's own, so pixels at edges may differ from the CPU's; colours elsewhere differ by rounding and by the filter's footprint,
//! which devices take from differences between pixels.

use super::{
    DrawnByGpu, Gpu,
    device::{Buffer, Device, GpuError},
    dmesh,
    machine::Machine,
    samples::{self, DEPTH, PICTURE, begin, resolve, target},
};
use crate::{
    math::Stop,
    raster::{Mips, Rendering, Role, Shading, Sides},
    runtime::hybrid_lod::SHADER,
    scene::{Image, Mesh, Object, Part, Scene},
    view::View,
};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, Mat4};
use std::sync::Arc;

/// `Frame` of shaders/hybrid_lod.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Frame {
    pub clip: [[f32; 4]; 4],
}

/// `Page` of shaders/hybrid_lod.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Page {
    pub scale: [f32; 2],
    pub layer: u32,
    pub padding: u32,
}

impl Gpu {
    /// Draws a view of a cell's stand-ins, as its GLB holds them: what [`crate::runtime::hybrid_lod::cell_stand_in`] draws, but each sample is rounded to 8 bits
    /// before pixels take their mean.
    ///
    /// # Errors
    /// Where the scene is not that of a cell's stand-ins, the device fails, its memory or its textures are too small, or the shading is noise, which the
    /// shader does not have.
    pub fn draw_hybrid_lod(
        &self,
        stand_ins: Arc<Scene>,
        view: &View,
        how: &Rendering,
        stop: &Stop,
    ) -> Result<DrawnByGpu, GpuError> {
        if matches!(how.shading, Shading::Noise(_)) {
            return Err(GpuError::Failed("hybrid_lod.wgsl has no noise".into()));
        }
        let pages = pages(&stand_ins)?;
        let n = u64::from(how.samples_per_axis);
        let [width, height] = layer_size(&pages).map(u64::from);
        let vertices: u64 = parts(&stand_ins).map(|(_, p)| p.mesh.positions.len() as u64 * 28).sum();
        // Buffers and what they are filled through; mip levels are a third more.
        let data = 2 * (vertices + stand_ins.triangle_count() as u64 * 12) + width * height * pages.len() as u64 * 11;
        let need = data + u64::from(view.width) * u64::from(view.height) * n * n * 24;
        if need > self.room().memory {
            return Err(GpuError::TooSmall { need, limit: self.room().memory });
        }
        let (view, how, stop) = (*view, *how, stop.clone());
        let samples = how.samples_per_axis;
        let (colors, depths) = self.call(move |machine| draw(machine, &stand_ins, &pages, &view, &how, &stop))?;
        Ok(resolve(&view, samples, how.background, &colors, &depths))
    }
}

fn parts(scene: &Scene) -> impl Iterator<Item = (&Object, &Part)> {
    scene.objects.iter().flat_map(|o| o.parts.iter().map(move |p| (o, p)))
}

/// The distinct images of a cell's scene, in the order of their first use.
///
/// # Errors
/// Where something is not as in a cell's GLB.
fn pages(scene: &Scene) -> Result<Vec<Arc<Image>>, GpuError> {
    let mut pages: Vec<Arc<Image>> = Vec::new();
    let first = scene.objects.first().map_or(Mat4::IDENTITY, |o| o.transform);
    for (object, part) in parts(scene) {
        let expected = |what: &str| {
            let name = &object.name;
            Err(GpuError::Failed(format!("`{name}` is no stand-in of a cell of hybrid LOD meshes: expected {what}")))
        };
        let Mesh { positions, uv, .. } = &*part.mesh;
        if object.transform != first {
            return expected("one transform for all objects");
        }
        if uv.iter().any(|set| set.len() != positions.len()) {
            return expected("two sets of texture coordinates");
        }
        if !uv[1].iter().all(|d| d[0] > 0.0 && d[0].is_finite()) {
            return expected("depths above 0 as second texture coordinates");
        }
        let Some(texture) = &part.material.base_color_texture else {
            return expected("a texture");
        };
        let image = &texture.image;
        if image.texels.is_empty() || image.texels.len() as u64 != u64::from(image.width) * u64::from(image.height) {
            return expected("as many texels as the texture's width times its height");
        }
        if !pages.iter().any(|page| Arc::ptr_eq(page, image)) {
            pages.push(image.clone());
        }
    }
    Ok(pages)
}

/// The largest width and the largest height; 1 × 1 where there are no pages.
fn layer_size(pages: &[Arc<Image>]) -> [u32; 2] {
    pages.iter().fold([1; 2], |[w, h], page| [w.max(page.width), h.max(page.height)])
}

/// The samples' colours and depths as the device stores them, row by row.
fn draw(
    machine: &Machine,
    scene: &Scene,
    pages: &[Arc<Image>],
    view: &View,
    how: &Rendering,
    stop: &Stop,
) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
    let device = &machine.device;
    let d = &device.device;
    let size = [view.width * how.samples_per_axis, view.height * how.samples_per_axis];
    let layer = layer_size(pages);
    let limits = d.limits();
    if size.iter().chain(&layer).any(|s| *s > limits.max_texture_dimension_2d) {
        let most = limits.max_texture_dimension_2d;
        return Err(GpuError::Failed(format!("a view or an atlas too large for the adapter's limit of {most} a side")));
    }
    if pages.len() > limits.max_texture_array_layers as usize {
        let most = limits.max_texture_array_layers;
        return Err(GpuError::Failed(format!("{} atlas pages, more than the adapter's {most} layers", pages.len())));
    }
    let pipeline = pipeline(d, how.options.sides == Sides::Both);
    let bind = |group: u32, resources: &[wgpu::BindingResource]| {
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let entries: Vec<_> = (0..).zip(resources.iter().cloned()).map(entry).collect();
        let layout = pipeline.get_bind_group_layout(group);
        d.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries })
    };
    let uniform = wgpu::BufferUsages::UNIFORM;
    let frame = device.upload(&[frame(scene, view)], uniform);
    let texture = texture(device, pages, layer);
    let sampler = d.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    let shared = bind(
        0,
        &[
            frame.buffer.as_entire_binding(),
            wgpu::BindingResource::TextureView(&texture),
            wgpu::BindingResource::Sampler(&sampler),
        ],
    );
    let uniforms: Vec<Buffer> = (0..)
        .zip(pages)
        .map(|(i, page)| {
            let scale = [page.width as f32 / layer[0] as f32, page.height as f32 / layer[1] as f32];
            device.upload(&[Page { scale, layer: i, padding: 0 }], uniform)
        })
        .collect();
    let groups: Vec<_> = uniforms.iter().map(|u| bind(1, &[u.buffer.as_entire_binding()])).collect();
    let loaded: Vec<Loaded> = parts(scene).filter_map(|(_, part)| Loaded::new(device, part, pages)).collect();
    let (picture, depth) = (target(d, PICTURE, size), target(d, DEPTH, size));
    let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = begin(&mut encoder, &picture, &depth);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &shared, &[]);
        for part in &loaded {
            pass.set_bind_group(1, &groups[part.page], &[]);
            for (slot, buffer) in (0..).zip(&part.vertices) {
                pass.set_vertex_buffer(slot, buffer.buffer.slice(..));
            }
            pass.set_index_buffer(part.indices.buffer.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..part.count, 0, 0..1);
        }
    }
    device.queue.submit([encoder.finish()]);
    device.check()?;
    Ok((dmesh::read(device, &picture, size, stop)?, dmesh::read(device, &depth, size, stop)?))
}

fn frame(scene: &Scene, view: &View) -> Frame {
    let to_world = scene.objects.first().map_or(DMat4::IDENTITY, |o| o.transform.as_dmat4());
    // The eye is placed about the cell's centre before anything is rounded.
    let clip = dmesh::clip(view) * to_world;
    Frame { clip: clip.as_mat4().to_cols_array_2d() }
}

/// A part in the device's memory.
struct Loaded {
    page: usize,
    /// Positions and both sets of texture coordinates.
    vertices: [Buffer; 3],
    indices: Buffer,
    count: u32,
}

impl Loaded {
    /// `None` where there is nothing to draw.
    fn new(device: &Device, part: &Part, pages: &[Arc<Image>]) -> Option<Self> {
        let mesh = &part.mesh;
        let image = &part.material.base_color_texture.as_ref()?.image;
        let page = pages.iter().position(|page| Arc::ptr_eq(page, image))?;
        let vertex = wgpu::BufferUsages::VERTEX;
        (!mesh.triangles.is_empty()).then(|| Self {
            page,
            vertices: [
                device.upload(&mesh.positions, vertex),
                device.upload(&mesh.uv[0], vertex),
                device.upload(&mesh.uv[1], vertex),
            ],
            indices: device.upload(&mesh.triangles, wgpu::BufferUsages::INDEX),
            count: mesh.triangles.len() as u32 * 3,
        })
    }
}

fn pipeline(d: &wgpu::Device, back_faces: bool) -> wgpu::RenderPipeline {
    let attribute = |shader_location, format| [wgpu::VertexAttribute { format, offset: 0, shader_location }];
    // Of the second texture coordinates only the first number is read.
    let attributes = [
        (12, attribute(0, wgpu::VertexFormat::Float32x3)),
        (8, attribute(1, wgpu::VertexFormat::Float32x2)),
        (8, attribute(2, wgpu::VertexFormat::Float32)),
    ];
    let buffers = attributes.each_ref().map(|(array_stride, attributes)| {
        let step_mode = wgpu::VertexStepMode::Vertex;
        Some(wgpu::VertexBufferLayout { array_stride: *array_stride, step_mode, attributes })
    });
    let call = samples::DrawCall {
        label: "hybrid_lod",
        wgsl: SHADER,
        entries: ["cell_vertex", "cell_fragment"],
        layout: None,
        buffers: &buffers,
        cull: (!back_faces).then_some(wgpu::Face::Back),
    };
    samples::pipeline(d, &call)
}

/// The pages as layers of one size with their mip levels, which the CPU reads too; beyond a page its last row and column go on.
fn texture(device: &Device, pages: &[Arc<Image>], [width, height]: [u32; 2]) -> wgpu::TextureView {
    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: pages.len().max(1) as u32 },
        mip_level_count: width.max(height).ilog2() + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (z, page) in (0..).zip(pages) {
        let at = |i: u32| {
            let (x, y) = ((i % width).min(page.width - 1), (i / width).min(page.height - 1));
            page.texels[(y * page.width + x) as usize]
        };
        let layer = Image { name: String::new(), width, height, texels: (0..width * height).map(at).collect() };
        for (mip_level, level) in (0..).zip(Mips::new(&layer, Role::Color).levels()) {
            let origin = wgpu::Origin3d { x: 0, y: 0, z };
            let target = wgpu::TexelCopyTextureInfo { mip_level, origin, ..texture.as_image_copy() };
            let bytes_per_row = Some(level.width * 4);
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            let size = wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 };
            device.queue.write_texture(target, bytemuck::cast_slice(&level.texels), layout, size);
        }
    }
    let dimension = Some(wgpu::TextureViewDimension::D2Array);
    texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..wgpu::TextureViewDescriptor::default() })
}
