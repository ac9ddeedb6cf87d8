// An octahedral impostor: pictures of an object from a grid of directions, blended on one card that faces the eye. The twin of
// src/runtime/octahedral. Everything is in linear light; the colour and emissive atlases and the target are bound with sRGB formats.
//
// One draw call a view: 3·(corners − 2) vertices without buffers, no culling, depth test on. The card lies before the object, so the depth
// that the fragments write is never nearer than the card's own: renderers with conservative depth may say so.
// octahedral.json holds all numbers of Impostor; its member `convention` says what they mean.
//
//   group 0 binding 0  Frame
//   group 0 binding 1  Impostor
//   group 0 binding 2  color_atlas     an sRGB format, with the mip levels of the bundle
//   group 0 binding 3  normal_atlas    linear; alpha is the height
//   group 0 binding 4  emissive_atlas  an sRGB format; any texture of one texel where Impostor.emits is 0
//   group 0 binding 5  smooth_sampler  linear, clamped, between mip levels too
//
// In the GLSL files binding b of group g is the uniform _group_g_binding_b_vs or _fs, a texture is a sampler2D with its sampler, and clip
// space is that of `clip` as it is given.

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
    // 0 unlit, 1 lit.
    shading: u32,
    // What a sample measures, metres: at planar depth 1 in perspective, everywhere in orthographic views.
    sample_size: f32,
}

struct Impostor {
    // Centre of the windows; half their side.
    window: vec4<f32>,
    // Two corners of the card in each, in radii.
    card: array<vec4<f32>, 4>,
    // 3 to 8.
    corners: u32,
    // Frames along a side of the grid.
    frames: u32,
    // Texels along a frame's side.
    tile: u32,
    // Mip levels of the atlases.
    levels: u32,
    // 1: directions from the horizon upwards only.
    hemi: u32,
    // Steps in which a ray is followed through a frame; 0 for flat pictures.
    steps: u32,
    // 1: emissive_atlas is there.
    emits: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> impostor: Impostor;
@group(0) @binding(2) var color_atlas: texture_2d<f32>;
@group(0) @binding(3) var normal_atlas: texture_2d<f32>;
@group(0) @binding(4) var emissive_atlas: texture_2d<f32>;
@group(0) @binding(5) var smooth_sampler: sampler;

// Height that directions below the horizon get on the upper half.
const HORIZON = 0.001;
// Rays that meet a frame's plane at less than this cosine pass it by.
const GRAZING = 0.05;
// Halvings of the step in which a ray meets a surface.
const BISECTIONS = 5u;
// Texels are covered from this alpha on.
const COVERED = 0.5;
// A ray that is so far below the surface where it enters an outline passes behind it; texels.
const WALL = 3.0;

struct Card {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
}

// The unit vector from the centre to the eye.
fn towards_eye() -> vec3<f32> {
    if frame.eye.w > 0.0 {
        return normalize(frame.eye.xyz - impostor.window.xyz);
    }
    return frame.eye.xyz;
}

// Right of the picture that looks at the object from the side where d points.
fn right_of(d: vec3<f32>) -> vec3<f32> {
    if dot(d.xz, d.xz) < 1e-12 {
        return normalize(cross(vec3<f32>(0.0, 0.0, 1.0), d));
    }
    return normalize(cross(vec3<f32>(0.0, 1.0, 0.0), d));
}

fn sign_of(v: vec2<f32>) -> vec2<f32> {
    return select(vec2<f32>(1.0), vec2<f32>(-1.0), v < vec2<f32>(0.0));
}

// Coordinates in the grid, 0 to frames − 1, of a direction.
fn grid_of(direction: vec3<f32>) -> vec2<f32> {
    let last = f32(impostor.frames - 1u);
    var d = direction;
    if impostor.hemi > 0u {
        d.y = max(d.y, HORIZON);
    }
    let p = d / (abs(d.x) + abs(d.y) + abs(d.z));
    var e = p.xz;
    if impostor.hemi > 0u {
        e = vec2<f32>(p.x + p.z, p.x - p.z);
    } else if p.y < 0.0 {
        e = (1.0 - abs(p.zx)) * sign_of(p.xz);
    }
    return clamp((e * 0.5 + 0.5) * last, vec2<f32>(0.0), vec2<f32>(last));
}

// The direction of a grid point.
fn direction_of(point: vec2<f32>) -> vec3<f32> {
    let e = point / f32(impostor.frames - 1u) * 2.0 - 1.0;
    if impostor.hemi > 0u {
        let p = vec2<f32>(e.x + e.y, e.x - e.y) * 0.5;
        return normalize(vec3<f32>(p.x, max(1.0 - abs(p.x) - abs(p.y), 0.0), p.y));
    }
    let y = 1.0 - abs(e.x) - abs(e.y);
    let p = select(e, (1.0 - abs(e.yx)) * sign_of(e), y < 0.0);
    return normalize(vec3<f32>(p.x, y, p.y));
}

@vertex
fn card_vertex(@builtin(vertex_index) index: u32) -> Card {
    // A fan around the first corner.
    let triangle = index / 3u;
    let k = index % 3u;
    let corner = select(triangle + k, 0u, k == 0u);
    let pair = impostor.card[corner / 2u];
    let at = select(pair.xy, pair.zw, (corner & 1u) == 1u);
    let d = towards_eye();
    let right = right_of(d);
    let offset = d + right * at.x + cross(d, right) * at.y;
    let position = impostor.window.xyz + offset * impostor.window.w;
    return Card(frame.clip * vec4<f32>(position, 1.0), position);
}

// Blended samples, each times its weight.
struct Blend {
    color: vec3<f32>,
    normal: vec3<f32>,
    emissive: vec3<f32>,
    // Along the ray, in its lengths.
    t: f32,
    coverage: f32,
    // Of the frames that decide.
    weight: f32,
}

// A ray as the frame of a grid point sees it; lengths in radii.
struct Camera {
    point: vec2<f32>,
    right: vec3<f32>,
    up: vec3<f32>,
    start: vec3<f32>,
    ray: vec3<f32>,
    // The ray's parameter on the plane through the centre, and the change of height along it.
    middle: f32,
    slope: f32,
    level: f32,
    // Where frames end on that level.
    edge: f32,
}

// A point of a ray beside a frame's surface.
struct Met {
    atlas: vec2<f32>,
    covered: bool,
    // Height over the surface, radii; 0 where nothing is covered.
    gap: f32,
    below: bool,
}

// The point of a ray at a height.
fn look(camera: Camera, height: f32) -> Met {
    let p = camera.start + camera.ray * (camera.middle + height / camera.slope);
    let uv = vec2<f32>(dot(p, camera.right) + 1.0, 1.0 - dot(p, camera.up)) * 0.5;
    let atlas = (camera.point + clamp(uv, vec2<f32>(camera.edge), vec2<f32>(1.0 - camera.edge))) / f32(impostor.frames);
    if any(uv < vec2<f32>(0.0)) || any(uv > vec2<f32>(1.0)) {
        return Met(atlas, false, 0.0, false);
    }
    if textureSampleLevel(color_atlas, smooth_sampler, atlas, camera.level).a < COVERED {
        return Met(atlas, false, 0.0, false);
    }
    let gap = height - (textureSampleLevel(normal_atlas, smooth_sampler, atlas, camera.level).a * 2.0 - 1.0);
    return Met(atlas, true, gap, gap < 0.0);
}

// Adds what a ray meets in the frame of a grid point: the first crossing from above the surface to below it, from the plane nearest to the
// frame's camera to the farthest, found in equal steps of height, then by bisection. Where the ray enters an outline far below the surface
// it is behind it, and that is no crossing. Without steps the frame is a flat picture on the plane through the centre.
// The ray's lengths are planar depths.
fn add(blend: ptr<function, Blend>, point: vec2<f32>, weight: f32, origin: vec3<f32>, ray: vec3<f32>, depth: f32) {
    let d = direction_of(point);
    let slope = dot(ray, d);
    if weight <= 0.0 || slope > -GRAZING * length(ray) {
        return;
    }
    (*blend).weight += weight;
    let right = right_of(d);
    let up = cross(d, right);
    let radius = impostor.window.w;
    let start = origin - impostor.window.xyz;
    let middle = -dot(start, d) / slope;
    // The level whose texels are as large as a sample, and where frames end on it.
    let far = select(1.0, depth + middle, frame.eye.w > 0.0);
    let texels = frame.sample_size * far * f32(impostor.tile) / (2.0 * radius);
    let level = clamp(log2(max(texels, 1.0)), 0.0, f32(impostor.levels - 1u));
    let edge = 0.5 / f32(impostor.tile >> u32(ceil(level)));
    let camera = Camera(point, right, up, start / radius, ray / radius, middle, slope / radius, level, edge);
    var met = look(camera, 0.0);
    if impostor.steps > 0u {
        let wall = WALL * 2.0 * exp2(level) / f32(impostor.tile);
        var hidden = false;
        var found = false;
        var before = look(camera, 1.0);
        for (var i = 1u; i <= impostor.steps && !found; i++) {
            var high = 1.0 - 2.0 * f32(i - 1u) / f32(impostor.steps);
            var low = 1.0 - 2.0 * f32(i) / f32(impostor.steps);
            let here = look(camera, low);
            if here.below && !before.below {
                var above = before.covered;
                met = here;
                for (var k = 0u; k < BISECTIONS; k++) {
                    let half = (high + low) * 0.5;
                    let p = look(camera, half);
                    if p.below {
                        low = half;
                        met = p;
                    } else {
                        high = half;
                        above = p.covered;
                    }
                }
                found = above || -met.gap <= wall;
                hidden = hidden || !found;
            }
            before = here;
        }
        if !found {
            // What another frame sees there decides.
            (*blend).weight -= select(0.0, weight, hidden);
            return;
        }
    } else if !met.covered {
        return;
    }
    let data = textureSampleLevel(normal_atlas, smooth_sampler, met.atlas, level);
    let t = middle + (data.a * 2.0 - 1.0) * radius / slope;
    (*blend).coverage += weight;
    (*blend).t += t * weight;
    (*blend).color += textureSampleLevel(color_atlas, smooth_sampler, met.atlas, level).rgb * weight;
    (*blend).normal += (data.xyz * 2.0 - 1.0) * weight;
    (*blend).emissive += textureSampleLevel(emissive_atlas, smooth_sampler, met.atlas, level).rgb * (weight * f32(impostor.emits));
}

struct Fragment {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn card_fragment(in: Card) -> Fragment {
    let towards = towards_eye();
    // The ray through the card, as long as one unit of planar depth; it begins on the card.
    var ray = in.position - frame.eye.xyz;
    if frame.eye.w == 0.0 {
        ray = -towards;
    }
    ray /= dot(frame.depth.xyz, ray);
    let depth = dot(frame.depth, vec4<f32>(in.position, 1.0));

    let g = grid_of(towards);
    let cell = min(floor(g), vec2<f32>(f32(impostor.frames - 2u)));
    let f = g - cell;
    let across = f.x >= f.y;
    let side = select(vec2<f32>(0.0, 1.0), vec2<f32>(1.0, 0.0), across);
    var blend = Blend(vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), 0.0, 0.0, 0.0);
    add(&blend, cell, 1.0 - max(f.x, f.y), in.position, ray, depth);
    add(&blend, cell + side, abs(f.x - f.y), in.position, ray, depth);
    add(&blend, cell + vec2<f32>(1.0), min(f.x, f.y), in.position, ray, depth);
    if blend.coverage <= 0.0 || blend.coverage < 0.5 * blend.weight {
        discard;
    }
    let share = 1.0 / blend.coverage;
    let position = in.position + ray * (blend.t * share);
    let clip = frame.clip * vec4<f32>(position, 1.0);
    var color = blend.color * share;
    if frame.shading == 1u {
        color = lit(color, normalize(blend.normal), position) + blend.emissive * share;
    }
    return Fragment(vec4<f32>(color, 1.0), clip.z / clip.w);
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
