//! Pictures that are drawn sample by sample and averaged here.

use super::DrawnByGpu;
use crate::{
    image::{Picture, srgb},
    view::{Projection, View},
};
use wgpu::TextureFormat;

pub const PICTURE: TextureFormat = TextureFormat::Rgba8UnormSrgb;
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// The depth test of all passes: depths run from the far plane at 0 to the near one, so the greater wins.
pub fn nearest_wins() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// What a shader that draws into [`PICTURE`] and [`DEPTH`] is made of.
pub struct DrawCall<'a> {
    pub label: &'a str,
    pub wgsl: &'a str,
    /// Entry points of the vertices and the fragments.
    pub entries: [&'a str; 2],
    /// That of the shader itself where there is none.
    pub layout: Option<&'a wgpu::PipelineLayout>,
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub cull: Option<wgpu::Face>,
}

/// The pipeline in which the nearest fragment wins.
pub fn pipeline(d: &wgpu::Device, s: &DrawCall) -> wgpu::RenderPipeline {
    let source = wgpu::ShaderSource::Wgsl(s.wgsl.into());
    let module = d.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(s.label), source });
    d.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(s.label),
        layout: s.layout,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(s.entries[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: s.buffers,
        },
        primitive: wgpu::PrimitiveState { cull_mode: s.cull, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(nearest_wins()),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(s.entries[1]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(PICTURE.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A texture that is drawn into and read back.
pub fn target(d: &wgpu::Device, format: TextureFormat, [width, height]: [u32; 2]) -> wgpu::Texture {
    d.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// A pass into both targets, cleared to nothing and to the far plane.
pub fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    picture: &wgpu::Texture,
    depth: &wgpu::Texture,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &picture.create_view(&wgpu::TextureViewDescriptor::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth.create_view(&wgpu::TextureViewDescriptor::default()),
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// Pixels as means of their `n` × `n` samples over the background, and the planar depth of the sample below and right of their centre, which
/// for odd `n` is the centre's.
pub fn resolve(view: &View, n: u32, background: [f32; 3], colors: &[u32], depths: &[u32]) -> DrawnByGpu {
    let n = n as usize;
    let width = view.width as usize * n;
    let (near, far) = (view.near, view.far);
    let planar = |stored: u32| {
        let z = f64::from(f32::from_bits(stored));
        let depth = match view.projection {
            Projection::Perspective { .. } => near * far / (z * (far - near) + near),
            Projection::Orthographic { .. } => far - z * (far - near),
        };
        if z > 0.0 { depth as f32 } else { f32::INFINITY }
    };
    let (mut texels, mut depth) = (Vec::new(), Vec::new());
    for y in 0..view.height as usize {
        for x in 0..view.width as usize {
            let mut sum = [0.0; 3];
            for k in 0..n * n {
                let [r, g, b, a] = colors[(y * n + k / n) * width + x * n + k % n].to_le_bytes();
                let seen = [r, g, b].map(srgb::to_linear);
                let seen = if a > 0 { seen } else { background };
                (0..3).for_each(|c| sum[c] += seen[c] / (n * n) as f32);
            }
            let [r, g, b] = sum.map(srgb::from_linear);
            texels.push([r, g, b, 255]);
            depth.push(planar(depths[(y * n + n / 2) * width + x * n + n / 2]));
        }
    }
    DrawnByGpu { picture: Picture { width: view.width, height: view.height, texels }, depth }
}
