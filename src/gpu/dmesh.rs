//! DMeshes drawn by a device: the passes of shaders/dmesh.wgsl.
//!
//! Coverage is the device's own, so pixels at edges may differ from the CPU's; colours elsewhere differ by rounding.

use super::{
    Gpu,
    device::{Buffer, Device, GpuError},
    machine::Machine,
    passes::{CENTRES, Passes},
};
use crate::{
    image::Picture,
    math::Stop,
    raster::{Gloss, Mips, Rendering, Shading, Sides},
    runtime::dmesh::{Blending, Model, select},
    view::{Projection, View},
};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, DVec4};
use std::sync::Arc;

/// `Frame` of shaders/dmesh.wgsl.
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
    pub background: [f32; 4],
    pub shading: u32,
    pub period: f32,
    pub samples: u32,
    pub layers: u32,
}

/// `Reference` of shaders/dmesh.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Reference {
    pub texel: [f32; 4],
    pub spread: f32,
    pub slack: f32,
    pub weight: f32,
    pub quality: f32,
    pub mapped: f32,
    pub padding: [f32; 3],
}

/// A DMesh in a device's memory.
#[derive(Clone)]
pub struct LoadedDmesh {
    model: Arc<Model>,
    parts: Arc<Vec<Part>>,
    /// What it takes there.
    bytes: u64,
}

/// One reference's buffers and pictures.
pub(super) struct Part {
    /// Position, normal, uv, quality.
    pub vertices: [Buffer; 4],
    pub indices: Buffer,
    pub count: u32,
    pub picture: wgpu::TextureView,
    pub normal_map: wgpu::TextureView,
}

/// A reference to draw.
pub(super) struct Job {
    pub part: usize,
    pub uniform: Reference,
}

/// One picture.
pub(super) struct Order {
    pub frame: Frame,
    pub jobs: Vec<Job>,
    /// Pixels of the picture.
    pub size: [u32; 2],
    pub back_faces: bool,
    pub parts: Arc<Vec<Part>>,
}

/// A picture by a device.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnByGpu {
    /// Alpha 255.
    pub picture: Picture,
    /// Planar depth of the nearest fragment at every pixel centre, metres; infinite where there is nothing.
    pub depth: Vec<f32>,
}

impl Gpu {
    /// Copies a DMesh into the device's memory.
    pub fn load_dmesh(&self, model: Arc<Model>) -> Result<LoadedDmesh, GpuError> {
        let bytes = bytes_of(&model);
        if bytes > self.room().memory {
            return Err(GpuError::TooSmall { need: bytes, limit: self.room().memory });
        }
        let inner = model.clone();
        let parts = self.call(move |machine| {
            let parts = (0..inner.dmesh().references.len()).map(|i| upload(&machine.device, &inner, i));
            let parts = parts.collect::<Result<Vec<_>, _>>()?;
            machine.device.check()?;
            Ok(parts)
        })?;
        Ok(LoadedDmesh { model, parts: Arc::new(parts), bytes })
    }

    /// Draws a view: what [`Model::draw`] draws, but shades every sample by itself whatever `how.shades_per_axis` says.
    ///
    /// # Errors
    /// Where the device fails, or its memory or its textures are too small for the view.
    pub fn draw_dmesh(
        &self,
        dmesh: &LoadedDmesh,
        view: &View,
        how: &Rendering,
        blending: &Blending,
        stop: &Stop,
    ) -> Result<DrawnByGpu, GpuError> {
        let model = &dmesh.model;
        let selected = select(model.dmesh(), view, blending.weights);
        let jobs: Vec<Job> = selected
            .iter()
            .map(|s| Job { part: s.reference, uniform: reference(model, s.reference, s.weight, blending) })
            .collect();
        let size = [view.width, view.height];
        if view.width == 0 || view.height == 0 {
            return Ok(DrawnByGpu { picture: Picture::default(), depth: Vec::new() });
        }
        let pixels = u64::from(view.width) * u64::from(view.height);
        let samples = pixels * u64::from(how.samples_per_axis).pow(2);
        let need = dmesh.bytes + samples * (8 + 8 * jobs.len().max(1) as u64) + pixels * (8 + 4 + 8);
        if need > self.room().memory {
            return Err(GpuError::TooSmall { need, limit: self.room().memory });
        }
        let order = Order {
            frame: frame(view, how, jobs.len() as u32),
            jobs,
            size,
            back_faces: model.dmesh().double_sided || how.options.sides == Sides::Both,
            parts: dmesh.parts.clone(),
        };
        let stop = stop.clone();
        let (texels, depth) = self.call(move |machine| draw(machine, &order, &stop))?;
        let picture = Picture { width: view.width, height: view.height, texels };
        Ok(DrawnByGpu { picture, depth })
    }
}

fn bytes_of(model: &Model) -> u64 {
    let of = |r: &crate::runtime::dmesh::Reference| {
        let arrays = r.mesh.positions.len() as u64 * 36 + r.mesh.triangles.len() as u64 * 12;
        let texels = r.color.texels.len() + r.normal_map.as_ref().map_or(0, |n| n.texels.len());
        // Buffers and what they are filled through; mip levels are a third more.
        arrays * 2 + texels as u64 * 4 * 8 / 3
    };
    model.dmesh().references.iter().map(of).sum()
}

fn upload(device: &Device, model: &Model, i: usize) -> Result<Part, GpuError> {
    let mesh = &model.dmesh().references[i].mesh;
    let part = model.part(i).1;
    let vertex = wgpu::BufferUsages::VERTEX;
    // Where the vertices have no normals, each gets the sum of its triangles'.
    let normals =
        if mesh.normals.is_empty() { summed(&mesh.positions, &mesh.triangles) } else { mesh.normals.to_vec() };
    let normal_map = match &part.normals {
        Some(mips) => texture(device, mips, wgpu::TextureFormat::Rgba8Unorm)?,
        None => blank(device),
    };
    Ok(Part {
        vertices: [
            device.upload(&mesh.positions, vertex),
            device.upload(&normals, vertex),
            device.upload(&mesh.uv, vertex),
            device.upload(&mesh.quality, vertex),
        ],
        indices: device.upload(&mesh.triangles, wgpu::BufferUsages::INDEX),
        count: mesh.triangles.len() as u32 * 3,
        picture: texture(device, &part.color, wgpu::TextureFormat::Rgba8UnormSrgb)?,
        normal_map,
    })
}

fn summed(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![glam::Vec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| glam::Vec3::from(positions[i as usize]));
        t.iter().for_each(|i| sums[*i as usize] += (b - a).cross(c - a));
    }
    sums.into_iter().map(|n| n.normalize_or(glam::Vec3::Y).to_array()).collect()
}

/// A picture with its mip levels.
fn texture(device: &Device, mips: &Mips, format: wgpu::TextureFormat) -> Result<wgpu::TextureView, GpuError> {
    let levels = mips.levels();
    let (width, height) = (levels[0].width, levels[0].height);
    let most = device.device.limits().max_texture_dimension_2d;
    if width.max(height) > most {
        let what = format!("a picture of {width} × {height} texels; the adapter allows {most} a side");
        return Err(GpuError::Failed(what));
    }
    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, level) in (0..).zip(levels) {
        let target = wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(level.width * 4), rows_per_image: None };
        let size = wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 };
        device.queue.write_texture(target, bytemuck::cast_slice(&level.texels), layout, size);
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// Stands for a picture that is not read.
fn blank(device: &Device) -> wgpu::TextureView {
    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn reference(model: &Model, i: usize, weight: f64, blending: &Blending) -> Reference {
    Reference {
        texel: model.part(i).1.texel.as_vec4().to_array(),
        spread: f32::from(u8::from(blending.offset.is_none())),
        slack: blending.offset.unwrap_or(2.0 * model.dmesh().epsilon) as f32,
        weight: weight as f32,
        quality: f32::from(u8::from(blending.quality)),
        mapped: f32::from(u8::from(model.part(i).1.normals.is_some())),
        padding: [0.0; 3],
    }
}

/// World to clip space. The near plane has depth 1 and the far plane 0: floats then resolve depth evenly.
pub(super) fn clip(view: &View) -> DMat4 {
    let (near, far) = (view.near, view.far);
    let (perspective, l, r, b, t) = match view.projection {
        Projection::Perspective { left, right, bottom, top } => (true, left, right, bottom, top),
        Projection::Orthographic { left, right, bottom, top } => (false, left, right, bottom, top),
    };
    // Rows over (x right, y up, z planar depth, 1).
    let rows = if perspective {
        let scale = near / (far - near);
        [
            DVec4::new(2.0, 0.0, -(l + r), 0.0) / (r - l),
            DVec4::new(0.0, 2.0, -(b + t), 0.0) / (t - b),
            DVec4::new(0.0, 0.0, -scale, scale * far),
            DVec4::Z,
        ]
    } else {
        [
            DVec4::new(2.0, 0.0, 0.0, -(l + r)) / (r - l),
            DVec4::new(0.0, 2.0, 0.0, -(b + t)) / (t - b),
            DVec4::new(0.0, 0.0, -1.0, far) / (far - near),
            DVec4::W,
        ]
    };
    let axis = |a| plane_of(view, a);
    let camera = DMat4::from_cols(axis(view.right), axis(view.up), axis(view.forward), DVec4::W).transpose();
    let [x, y, z, w] = rows;
    DMat4::from_cols(x, y, z, w).transpose() * camera
}

/// How far a point (x, y, z, 1) lies along an axis of the camera.
fn plane_of(view: &View, axis: DVec3) -> DVec4 {
    axis.extend(-axis.dot(view.eye))
}

pub(super) fn frame(view: &View, how: &Rendering, layers: u32) -> Frame {
    let perspective = matches!(view.projection, Projection::Perspective { .. });
    let eye = if perspective { view.eye.extend(1.0) } else { (-view.forward).extend(0.0) };
    let (light, shading, period) = match how.shading {
        Shading::Unlit => (Default::default(), 0, 1.0),
        Shading::Lit(light) => (light, 1, 1.0),
        Shading::Noise(noise) => (Default::default(), 2, noise.period),
    };
    let Gloss { strength, exponent } = light.gloss.unwrap_or(Gloss { strength: 0.0, exponent: 1.0 });
    let with = |[r, g, b]: [f32; 3], a: f32| [r, g, b, a];
    Frame {
        clip: clip(view).as_mat4().to_cols_array_2d(),
        depth: plane_of(view, view.forward).as_vec4().to_array(),
        eye: eye.as_vec4().to_array(),
        to_sun: light.to_sun.extend(exponent).to_array(),
        sun: with(light.sun, strength),
        sky: with(light.sky, 0.0),
        ground: with(light.ground, 0.0),
        background: with(how.background, 0.0),
        shading,
        period: period as f32,
        samples: how.samples_per_axis,
        layers,
    }
}

fn draw(machine: &Machine, order: &Order, stop: &Stop) -> Result<(Vec<[u8; 4]>, Vec<f32>), GpuError> {
    let passes = machine.dmesh.get_or_init(|| Passes::new(&machine.device));
    let [width, height] = order.size;
    let n = order.frame.samples;
    let most = machine.device.device.limits().max_texture_dimension_2d;
    if width.max(height).saturating_mul(n) > most {
        let what =
            format!("a view of {width} × {height} pixels of {n} × {n} samples; the adapter allows {most} a side");
        return Err(GpuError::Failed(what));
    }
    let depth = passes.depth(&machine.device, order, 1);
    let depth = read(&machine.device, &depth.texture, order.size, stop)?;
    let picture = passes.picture(&machine.device, order)?;
    let texels = read(&machine.device, &picture.texture, order.size, stop)?;
    let depth = depth.into_iter().map(f32::from_bits).map(|z| if z < CENTRES { z } else { f32::INFINITY });
    Ok((texels.into_iter().map(|w| w.to_le_bytes()).collect(), depth.collect()))
}

/// The words of a texture of four bytes a texel.
pub(super) fn read(
    device: &Device,
    target: &wgpu::Texture,
    [width, height]: [u32; 2],
    stop: &Stop,
) -> Result<Vec<u32>, GpuError> {
    let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.zeros(u64::from(row) * u64::from(height));
    let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        target.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer.buffer, layout },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    device.queue.submit([encoder.finish()]);
    let words = device.read(&buffer, (row / 4 * height) as usize, stop)?;
    Ok(words.chunks((row / 4) as usize).flat_map(|line| &line[..width as usize]).copied().collect())
}
