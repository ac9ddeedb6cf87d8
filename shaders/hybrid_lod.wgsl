// Stand-ins of one cell of hybrid textured LOD meshes (Chen et al. 2003, section 3.2): simplified meshes on which cameras cast their pictures, by
// projective texture mapping. The twin of src/runtime/hybrid_lod. Colours are in linear light: the texture and the target are bound with sRGB formats.
//
// A draw call shows all parts of the cell that have one atlas page, or some of them: triangles with indices, counter-clockwise is the front, backs are
// culled, depth test on, no blending. Vertex buffers, from the GLB of the cell:
//
//   location 0  POSITION        metres about the cell's centre (the nodes' translation is that centre, `centre` in hybrid-lod.json)
//   location 1  TEXCOORD_0      on the part's page: (0, 0) is its upper left corner, (1, 1) its lower right one
//   location 2  TEXCOORD_1, x   d: depth in the view that the texture was captured from, > 0, metres; 1 for colours without a view. Bound as
//                               it is, two floats: the second is not read
//
//   group 0 binding 0  Frame
//   group 0 binding 1  pages           an sRGB format, a page in each layer; only the base level, as in the KTX2 file: pictures were taken about as large as
//                                      they are seen, and coarser levels mix parts of a page
//   group 0 binding 2  smooth_sampler  linear, clamped
//   group 1 binding 0  Page            of the draw call
//
// Pages are the images of the GLB, `atlas 0`, `atlas 1` and so on, which differ in size. Layers of the KTX2 file have the size of the largest width
// and the largest height of all pages, page n lies in layer n, in its upper left corner. Page.scale then is the image's width and height over the layer's. Where each
// page has a texture of its own, with one layer, Page.scale is (1, 1) and Page.layer 0.
//
// Objects that hybrid-lod.json names as `inside` are drawn as the renderer draws its other objects.
//
// In the GLSL files binding b of group g is the uniform _group_g_binding_b_vs or _fs, a texture is a sampler2DArray with its sampler, and clip
// space is that of `clip` as it is given.

struct Frame {
    // From metres about the cell's centre to clip space. The depth buffer may run either way.
    clip: mat4x4<f32>,
}

struct Page {
    // Size of the page over that of a layer.
    scale: vec2<f32>,
    // Of `pages`.
    layer: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var pages: texture_2d_array<f32>;
@group(0) @binding(2) var smooth_sampler: sampler;
@group(1) @binding(0) var<uniform> page: Page;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    // u·d, v·d, d: on a plane they are affine functions of the point, u and v are not.
    @location(0) ratios: vec3<f32>,
}

@vertex
fn cell_vertex(@location(0) position: vec3<f32>, @location(1) uv: vec2<f32>, @location(2) depth: f32) -> Fragment {
    let ratios = vec3<f32>(uv * page.scale, 1.0) * depth;
    return Fragment(frame.clip * vec4<f32>(position, 1.0), ratios);
}

@fragment
fn cell_fragment(in: Fragment) -> @location(0) vec4<f32> {
    let at = in.ratios.xy / in.ratios.z;
    return vec4<f32>(textureSample(pages, smooth_sampler, at, page.layer).rgb, 1.0);
}
