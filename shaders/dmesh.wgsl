// Depth-meshes: several textured meshes of one object, blended pixel by pixel (Pajarola, Sainz and Meng 2003, section 6).
// The twin of src/runtime/dmesh. Everything is in linear light; pictures and the target are bound with sRGB formats.
//
// A frame takes these passes, for the references that dmesh.json's rule selects and their weights w:
//
//   1. depth_vertex, depth_fragment: the meshes of all selected references into one target R32Float with a depth buffer, cleared to
//      NOTHING. The target is Z_e, the planar depth of the nearest surface.
//   2. color_vertex, color_fragment: each reference into its own layer of `images`, RGBA16Float, cleared to 0, with a depth buffer that
//      is cleared for each. It keeps the nearest fragment of the mesh where that lies within the offset behind Z_e.
//      rgb is the shaded colour, a = w·ρ the weight of section 6.3; they are multiplied in the next pass, where nothing is rounded.
//   3. screen_vertex, combine_fragment: three vertices without buffers, into the target. It sums the layers, divides by the weight
//      (steps v and vi in one) and averages samples × samples of them for each pixel.
//
// Passes 1 and 2 draw `samples` times as many pixels a side as pass 3. Faces are counter-clockwise from the front; their backs are culled
// unless dmesh.json says double_sided. Vertex buffers: position, normal, uv, quality (POSITION, NORMAL, TEXCOORD_0 and _QUALITY of
// the GLBs) at locations 0 to 3.
//
//   group 0 binding 0  Frame      all passes
//   group 1 binding 0  Reference  pass 2
//   group 1 binding 1  front      pass 2: Z_e
//   group 1 binding 2  picture    pass 2: colour, an sRGB format, with mip levels
//   group 1 binding 3  normal_map pass 2: world-space normals; any texture where Reference.mapped is 0
//   group 1 binding 4  smooth     pass 2: linear, clamped
//   group 1 binding 5  images     pass 3: the layers
//
// In the GLSL files binding b of group g is the uniform _group_g_binding_b_vs or _fs, a texture is a sampler2D or sampler2DArray with its
// sampler, and clip space is that of `clip` as it is given.

struct Frame {
    // World to clip space. The depth buffer may run either way.
    clip: mat4x4<f32>,
    // Planar depth of a world point: dot(depth, (x, y, z, 1)).
    depth: vec4<f32>,
    // The eye and 1; for orthographic views the unit direction towards it and 0.
    eye: vec4<f32>,
    // Unit vector towards the sun; the highlight's exponent.
    to_sun: vec4<f32>,
    // Colour; the highlight's strength, 0 for matt surfaces.
    sun: vec4<f32>,
    // Light that surfaces facing up (+Y) and down get.
    sky: vec4<f32>,
    ground: vec4<f32>,
    // Where nothing is seen.
    background: vec4<f32>,
    // 0 unlit, 1 lit, 2 base colour times noise.
    shading: u32,
    // Of the noise, metres.
    period: f32,
    // Along a pixel's side.
    samples: u32,
    // Layers of `images`.
    layers: u32,
}

struct Reference {
    // dot(texel, (x, y, z, 1)): what a texel measures at a world point, metres. It grows as the depth from the reference camera does, or
    // is the same everywhere if that is orthographic.
    texel: vec4<f32>,
    // How far behind Z_e fragments count: spread · that + slack, metres. Without an offset of its own 1 and 2ε.
    spread: f32,
    slack: f32,
    // w
    weight: f32,
    // 1: fragments count by their quality; 0: all alike.
    quality: f32,
    // 1: normals come from normal_map; 0: from the vertices.
    mapped: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> reference: Reference;
@group(1) @binding(1) var front: texture_2d<f32>;
@group(1) @binding(2) var picture: texture_2d<f32>;
@group(1) @binding(3) var normal_map: texture_2d<f32>;
@group(1) @binding(4) var smooth_sampler: sampler;
@group(1) @binding(5) var images: texture_2d_array<f32>;

// Z_e where nothing is seen.
const NOTHING = 3e38;
// Least weight of a fragment, the smallest normal 16-bit float: what is covered has a colour.
const LEAST = 0.00006103515625;

struct Depth {
    @builtin(position) clip: vec4<f32>,
    @location(0) depth: f32,
}

@vertex
fn depth_vertex(@location(0) position: vec3<f32>) -> Depth {
    let p = vec4<f32>(position, 1.0);
    return Depth(frame.clip * p, dot(frame.depth, p));
}

@fragment
fn depth_fragment(in: Depth) -> @location(0) vec4<f32> {
    return vec4<f32>(in.depth, 0.0, 0.0, 0.0);
}

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // Times w, and w: the reference camera cast its picture on the triangle, so within it coordinates are ratios.
    @location(2) ratios: vec3<f32>,
    @location(3) quality: f32,
    @location(4) depth: f32,
}

@vertex
fn color_vertex(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) quality: f32,
) -> Fragment {
    let p = vec4<f32>(position, 1.0);
    let ratios = vec3<f32>(uv, 1.0) * dot(reference.texel, p);
    return Fragment(frame.clip * p, position, normal, ratios, quality, dot(frame.depth, p));
}

@fragment
fn color_fragment(in: Fragment, @builtin(front_facing) facing: bool) -> @location(0) vec4<f32> {
    // The level whose texels are as large as the pixel's longer side.
    let size = vec2<f32>(textureDimensions(picture));
    let uv = in.ratios.xy / in.ratios.z;
    let dx = dpdx(uv) * size;
    let dy = dpdy(uv) * size;
    let level = 0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1.0));
    let base = textureSampleLevel(picture, smooth_sampler, uv, level).rgb;
    let mapped = textureSampleLevel(normal_map, smooth_sampler, uv, level).xyz * 2.0 - 1.0;
    let bent = select(in.normal, mapped, reference.mapped > 0.0 && dot(mapped, mapped) > 0.0);
    let normal = normalize(select(-bent, bent, facing));
    let quality = mix(1.0, in.quality, reference.quality);
    let offset = reference.slack + reference.spread * in.ratios.z;
    if in.depth > textureLoad(front, vec2<i32>(in.clip.xy), 0).x + offset {
        discard;
    }
    return vec4<f32>(shade(base, normal, in.position), max(reference.weight * quality, LEAST));
}

fn shade(base: vec3<f32>, normal: vec3<f32>, position: vec3<f32>) -> vec3<f32> {
    switch frame.shading {
        case 1u: {
            return lit(base, normal, position);
        }
        case 2u: {
            return base * noise(position);
        }
        default: {
            return base;
        }
    }
}

// A sun without shadows, a sky that is brighter above, and the highlight of Blinn's model.
fn lit(base: vec3<f32>, normal: vec3<f32>, position: vec3<f32>) -> vec3<f32> {
    let sun = max(dot(normal, frame.to_sun.xyz), 0.0);
    let ambient = mix(frame.ground.rgb, frame.sky.rgb, 0.5 + 0.5 * normal.y);
    var color = base * (frame.sun.rgb * sun + ambient);
    if frame.sun.w > 0.0 && sun > 0.0 {
        let to_eye = normalize(frame.eye.xyz - position * frame.eye.w);
        let h = normalize(frame.to_sun.xyz + to_eye);
        color += frame.sun.rgb * (frame.sun.w * pow(max(dot(normal, h), 0.0), frame.to_sun.w) * sun);
    }
    return color;
}

// Value noise in two octaves, the twin of src/raster/noise.rs.
fn noise(position: vec3<f32>) -> f32 {
    let q = position / frame.period;
    return 0.05 + 0.6 * octave(q, 0u) + 0.3 * octave(q * 4.0, 1u);
}

fn octave(p: vec3<f32>, seed: u32) -> f32 {
    let cell = floor(p);
    var t = p - cell;
    t = t * t * (3.0 - 2.0 * t);
    let first = bitcast<vec3<u32>>(vec3<i32>(cell));
    var sum = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let bits = vec3<u32>(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let side = mix(1.0 - t, t, vec3<f32>(bits));
        sum += side.x * side.y * side.z * hash(first + bits, seed);
    }
    return sum;
}

fn hash(p: vec3<u32>, seed: u32) -> f32 {
    var h = seed;
    for (var k = 0u; k < 3u; k++) {
        h = (h ^ p[k]) * 0x85ebca6bu;
        h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
        h ^= h >> 16u;
    }
    return f32(h >> 8u) / 16777216.0;
}

@vertex
fn screen_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(vec2<u32>(index & 1u, index >> 1u));
    return vec4<f32>(corner * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn combine_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let n = i32(frame.samples);
    let first = vec2<i32>(at.xy) * n;
    var sum = vec3<f32>(0.0);
    for (var i = 0; i < n * n; i++) {
        let sample = first + vec2<i32>(i % n, i / n);
        // I = Σ C_i, divided by its alpha.
        var color = vec3<f32>(0.0);
        var alpha = 0.0;
        for (var k = 0u; k < frame.layers; k++) {
            let c = textureLoad(images, sample, k, 0);
            color += c.rgb * c.a;
            alpha += c.a;
        }
        if alpha > 0.0 {
            sum += color / alpha;
        } else {
            sum += frame.background.rgb;
        }
    }
    return vec4<f32>(sum / f32(n * n), 1.0);
}
