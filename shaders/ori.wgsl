// Relief impostors (Andújar et al., Omni-directional Relief Impostors, 2007): an object as a few height fields seen from all sides. The twin
// of src/relief and src/runtime/ori. Everything is in linear light; colour and emissive textures and the target are bound with sRGB formats.
//
// One instanced draw call for all instances of an impostor: 36 vertices without buffers, front faces culled (counter-clockwise is the front),
// depth test on. What is drawn is the back of each instance's bounding box, so that no pixel is shaded twice and an eye inside the box is no
// exception. A fragment follows its ray through the maps of its instance and writes the depth of what it meets, which is nearer than the box's back:
// shadows and other geometry fit. Fragments that meet nothing are discarded.
//
// An instance is moved, turned and scaled alike in all directions. Which maps it needs depends on the direction from its middle to the eye: take
// those of the nearest direction of ori.json, sorted by how near their own directions are.
//
//   group 0 binding 0  Frame
//   group 0 binding 1  Impostor
//   group 0 binding 2  maps            Map for each layer of the textures
//   group 0 binding 3  instances       Instance for each instance
//   group 0 binding 4  ranges          the maps' pyramids, see Map.first; not read by the linear search
//   group 0 binding 5  depth_codes     R8 or R16 unsigned normalised (or 32-bit floats of the same values), one level; read texel by texel
//   group 0 binding 6  color           an sRGB format, with mip levels
//   group 0 binding 7  normals         two components, linear, with mip levels
//   group 0 binding 8  emissive        an sRGB format, with mip levels; any array of one texel where Impostor.emits is 0
//   group 0 binding 9  smooth_sampler  linear, clamped, between mip levels too
//
// In the GLSL files binding b of group g is the uniform _group_g_binding_b_vs or _fs, a texture is a sampler2DArray with its sampler, and clip
// space is that of `clip` as it is given.
//
// Impostor space is the object's own, metres, with its origin in the middle of the object's bounding box. Texel units of a map are u to the right, v
// down, w away from its camera, in sides of a texel from the top left corner of the map on its near plane.

struct Frame {
    // World to clip space. The depth buffer may run either way.
    clip: mat4x4<f32>,
    // Planar depth of a world point: dot(depth, (x, y, z, 1)); its first three are the unit direction of view.
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
    // Planar depths between which surfaces are drawn, metres.
    near: f32,
    far: f32,
    // What a sample measures, metres: at planar depth 1 in perspective, everywhere in orthographic views.
    sample_size: f32,
    // 0 unlit, 1 lit.
    shading: u32,
}

struct Impostor {
    // From impostor space to the object's own: the middle of its bounding box.
    centre: vec4<f32>,
    // Half the box, with two texels more on each side, since surfaces reach beyond the object.
    extent: vec4<f32>,
    // Texels along a map's side.
    side: u32,
    // Squares along a side of a pyramid's level 0: the least power of two that is not below `side`.
    squares: u32,
    // Depths that codes can tell apart, and codes.
    depths: u32,
    codes: u32,
    // Mip levels of colour, normals and emissive.
    levels: u32,
    // 1: emissive is there.
    emits: u32,
    // 1 plane, 2 depth, 3 direction, 4 normal, 5 biased depth: section 3.3.
    strategy: u32,
    // Steps of the linear search; 0: search by pyramids.
    steps: u32,
    // Of the linear search.
    halvings: u32,
    // Depths of neighbouring texels that differ by more are a wall, texel sides.
    wall: f32,
}

struct Map {
    // From impostor space to texel units: u = dot(rows[0], (p, 1)), v, w.
    rows: array<vec4<f32>, 3>,
    // Least u and v, greatest u and v that surfaces have.
    window: vec4<f32>,
    // Greatest w.
    deep: f32,
    // From one code to the next, in w.
    step: f32,
    // Side of a texel, metres.
    texel: f32,
    // Number in `ranges` of its pyramid's first element. Level by level, each with half as many squares along a side as the one before, row by row:
    // least and greatest w of the surfaces in a square of cells; without surface the first is the greater. Cell (i, j) lies between the centres
    // of texels (i, j) and (i + 1, j + 1).
    first: u32,
}

struct Instance {
    // Position of the object's origin in the world, metres; scale.
    place: vec4<f32>,
    // Unit quaternion, x y z w.
    rotation: vec4<f32>,
    // Up to eight maps, the nearest direction first, two in each number: first the low 16 bits. 0xffff ends the list.
    maps: vec4<u32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> impostor: Impostor;
@group(0) @binding(2) var<storage, read> maps: array<Map>;
@group(0) @binding(3) var<storage, read> instances: array<Instance>;
@group(0) @binding(4) var<storage, read> ranges: array<vec2<f32>>;
@group(0) @binding(5) var depth_codes: texture_2d_array<f32>;
@group(0) @binding(6) var color: texture_2d_array<f32>;
@group(0) @binding(7) var normals: texture_2d_array<f32>;
@group(0) @binding(8) var emissive: texture_2d_array<f32>;
@group(0) @binding(9) var smooth_sampler: sampler;

// Stands for infinity, and from where on numbers do.
const NOTHING = 3e38;
const FINITE = 1e38;
// Maps of an instance.
const MAPS = 8u;
const NO_MAP = 0xffffu;
// Edge value of a texel with a surface; codes of texels without one.
const INSIDE = 0.5;
const REACHES = 16.0;
// How far beyond its cell a meeting still counts, and how far into the next one a ray is moved to leave it, texel sides.
const SLACK = 2e-3;
const NUDGE = 5e-4;
// Rays that are steeper than this, across over along, are moved less.
const STEEP = 0.05;
// Strategy 5.
const BIAS = 0.03125;

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

// v turned by a unit quaternion, and back.
fn turned(v: vec3<f32>, q: vec4<f32>) -> vec3<f32> {
    return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

fn turned_back(v: vec3<f32>, q: vec4<f32>) -> vec3<f32> {
    return v + 2.0 * cross(q.xyz, cross(q.xyz, v) - q.w * v);
}

struct Proxy {
    @builtin(position) clip: vec4<f32>,
    // Impostor space.
    @location(0) position: vec3<f32>,
    @location(1) @interpolate(flat) instance: u32,
}

@vertex
fn box_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) number: u32) -> Proxy {
    // Two triangles of a square, then the square's axis and side of the box.
    let face = index / 6u;
    let corner = index % 6u;
    let across = vec2<u32>(u32(corner == 1u || corner == 2u || corner == 4u), u32(corner == 2u || corner >= 4u));
    let axis = face >> 1u;
    let side = face & 1u;
    let along = select(across.yx, across, side == 1u);
    var bits = vec3<u32>(0u);
    bits[axis] = side;
    bits[(axis + 1u) % 3u] = along.x;
    bits[(axis + 2u) % 3u] = along.y;
    let position = (vec3<f32>(bits) * 2.0 - 1.0) * impostor.extent.xyz;
    let instance = instances[number];
    let world = instance.place.xyz + turned(position + impostor.centre.xyz, instance.rotation) * instance.place.w;
    var clip = frame.clip * vec4<f32>(world, 1.0);
    // Fragments have a depth of their own, so the box is cut by no plane but the eye's.
    clip.z = 0.5 * clip.w;
    return Proxy(clip, position, number);
}

// Depth in texel sides and edge value of a texel.
fn texel(map: u32, at: vec2<i32>) -> vec2<f32> {
    if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(i32(impostor.side))) {
        return vec2<f32>(NOTHING, -INSIDE);
    }
    let last = f32(impostor.codes - 1u);
    let code = floor(textureLoad(depth_codes, at, map, 0).x * last + 0.5);
    if code < f32(impostor.depths) {
        return vec2<f32>(code * maps[map].step, INSIDE);
    }
    let reach = (last - code + 0.5) / REACHES;
    return vec2<f32>(NOTHING, -INSIDE * (1.0 - reach) / reach);
}

// Straight on from one texel's centre to another's, through the texel on the other side of the first where that belongs to the surface.
fn straight_on(map: u32, a: vec2<i32>, depth: f32, k: vec2<i32>) -> f32 {
    let before = texel(map, 2 * a - k).x;
    return select(depth, 2.0 * depth - before, abs(before - depth) <= impostor.wall);
}

fn corner_of(first: vec2<i32>, k: u32) -> vec2<i32> {
    return first + vec2<i32>(vec2<u32>(k & 1u, k >> 1u));
}

// Depths of a sheet at the corners of a cell. Bit k of `bits`: texel k belongs to it; corners that do not continue those that do.
fn corners_of(map: u32, first: vec2<i32>, texels: array<vec2<f32>, 4>, bits: u32) -> vec4<f32> {
    var depths = vec4<f32>(texels[0].x, texels[1].x, texels[2].x, texels[3].x);
    if bits == 15u {
        return depths;
    }
    var out = depths;
    for (var k = 0u; k < 4u; k++) {
        if ((bits >> k) & 1u) == 1u {
            continue;
        }
        // The corners beside it and the one across.
        let a = k ^ 1u;
        let b = k ^ 2u;
        let c = k ^ 3u;
        let has = vec3<bool>(((bits >> a) & 1u) == 1u, ((bits >> b) & 1u) == 1u, ((bits >> c) & 1u) == 1u);
        if all(has) {
            out[k] = depths[a] + depths[b] - depths[c];
            continue;
        }
        let at = corner_of(first, k);
        var sum = 0.0;
        if has.x {
            sum = straight_on(map, corner_of(first, a), depths[a], at);
        }
        if has.y {
            let other = straight_on(map, corner_of(first, b), depths[b], at);
            sum = select(other, (sum + other) * 0.5, has.x);
        }
        out[k] = select(depths[c], sum, has.x || has.y);
    }
    return out;
}

// The root of e + f·t + g·t² at which it rises; for roots of a quadratic that is −2e / (f + √(f² − 4eg)).
fn rising_root(e: f32, f: f32, g: f32) -> f32 {
    let under = f * f - 4.0 * e * g;
    if !(under > 0.0) {
        return NOTHING;
    }
    let root = sqrt(under);
    // Where f is negative the first form cancels.
    if f >= 0.0 {
        return -2.0 * e / (f + root);
    }
    if g == 0.0 {
        return NOTHING;
    }
    return (root - f) / (2.0 * g);
}

// The first t of [start, end] at which the ray goes from in front of a surface of the cell to behind it.
fn meet(map: u32, first: vec2<i32>, ray: Ray, start: f32, end: f32) -> f32 {
    var texels = array<vec2<f32>, 4>(
        texel(map, first),
        texel(map, first + vec2<i32>(1, 0)),
        texel(map, first + vec2<i32>(0, 1)),
        texel(map, first + vec2<i32>(1, 1)),
    );
    let begin = ray.origin + ray.direction * start;
    let d = ray.direction;
    let corner = begin.xy - (vec2<f32>(first) + 0.5);
    var taken = 0u;
    var nearest = NOTHING;
    for (var k = 0u; k < 4u; k++) {
        if ((taken >> k) & 1u) == 1u || texels[k].x > FINITE {
            continue;
        }
        // Texels whose depths are less than a wall apart are one sheet.
        var bits = 0u;
        for (var l = 0u; l < 4u; l++) {
            if ((taken >> l) & 1u) == 0u && abs(texels[l].x - texels[k].x) <= impostor.wall {
                bits |= 1u << l;
            }
        }
        taken |= bits;
        // Depth of the sheet: h.x + b·x + c·y + g·x·y with x, y from the corner; the ray's depth less that is e + f·t + h·t².
        let h = corners_of(map, first, texels, bits);
        let b = h.y - h.x;
        let c = h.z - h.x;
        let g = h.x - h.y - h.z + h.w;
        let e = begin.z - (h.x + b * corner.x + c * corner.y + g * corner.x * corner.y);
        let f = d.z - (b * d.x + c * d.y + g * (corner.x * d.y + corner.y * d.x));
        let t = rising_root(e, f, -g * d.x * d.y);
        if t >= 0.0 && start + t <= end && start + t < nearest && shows(texels, bits, corner + d.xy * t) {
            nearest = start + t;
        }
    }
    return nearest;
}

// Whether the sheet is there at a point from the corner of its cell.
fn shows(texels: array<vec2<f32>, 4>, bits: u32, at: vec2<f32>) -> bool {
    var all_texels = texels;
    let p = clamp(at, vec2<f32>(0.0), vec2<f32>(1.0));
    var weights = vec4<f32>((1.0 - p.x) * (1.0 - p.y), p.x * (1.0 - p.y), (1.0 - p.x) * p.y, p.x * p.y);
    var edge = 0.0;
    var own = 0u;
    var most = -1.0;
    for (var k = 0u; k < 4u; k++) {
        edge += weights[k] * all_texels[k].y;
        if all_texels[k].x < FINITE && weights[k] > most {
            own = k;
            most = weights[k];
        }
    }
    return edge > 0.0 && ((bits >> own) & 1u) == 1u;
}

// Every cell whose range of depths the ray crosses, found by the pyramid.
fn search_pyramid(map: u32, ray: Ray, t0: f32, t1: f32) -> f32 {
    let o = ray.origin;
    let d = ray.direction;
    // Along the map's own direction, up to rounding, texels bound nothing.
    let pace = max(max(abs(d.x), abs(d.y)), STEEP * abs(d.z));
    let nudge = NUDGE / pace;
    let slack = SLACK / pace;
    let n = impostor.squares;
    let top = firstTrailingBit(n);
    // Cells begin at the centre of the first texel.
    let begin = o.xy - 0.5;
    let still = d.xy == vec2<f32>(0.0);
    let over = 1.0 / select(d.xy, vec2<f32>(1.0), still);
    // 1 where a square is left through its far side.
    let ahead = vec2<i32>(d.xy > vec2<f32>(0.0));
    // Most rays begin near a surface.
    var level = min(2u, top);
    // A ray along the map's direction, up to rounding, ends before it has moved so far.
    var t = min(t0 + nudge, (t0 + t1) * 0.5);
    // A ray crosses fewer than 2n cells; the bound is for what is not a number.
    for (var i = 0u; i < 8u * n && t < t1; i++) {
        let cell = clamp(vec2<i32>(begin + d.xy * t), vec2<i32>(0), vec2<i32>(i32(n) - 1));
        let before = max(t - nudge, t0);
        let enter = o.z + d.z * before;
        // Down to the first square that the ray misses, or to a cell.
        loop {
            let square = cell >> vec2<u32>(level);
            let sides = (vec2<f32>((square + ahead) << vec2<u32>(level)) - begin) * over;
            let ends = select(sides, vec2<f32>(t1), still);
            let end = max(min(min(ends.x, ends.y), t1), t);
            // The levels before this one have 4/3·(n² − m²) squares, m·m being those of this one.
            let m = n >> level;
            let skipped = (n * n - m * m) / 3u * 4u;
            let range = ranges[maps[map].first + skipped + u32(square.y) * m + u32(square.x)];
            let leave = o.z + d.z * end;
            if max(enter, leave) + SLACK < range.x || min(enter, leave) - SLACK > range.y {
                t = end + nudge;
                level = min(level + 1u, top);
                break;
            }
            if level == 0u {
                let met = meet(map, cell, ray, before - slack, end + slack);
                if met < FINITE {
                    return met;
                }
                t = end + nudge;
                level = min(1u, top);
                break;
            }
            level -= 1u;
        }
    }
    return NOTHING;
}

// Depth of the surface at (u, v), infinite where there is none: texels of one surface are interpolated, others end half-way.
fn height(map: u32, at: vec2<f32>) -> f32 {
    let p = at - 0.5;
    let low = floor(p);
    let f = p - low;
    let first = vec2<i32>(low);
    var texels = array<vec2<f32>, 4>(
        texel(map, first),
        texel(map, first + vec2<i32>(1, 0)),
        texel(map, first + vec2<i32>(0, 1)),
        texel(map, first + vec2<i32>(1, 1)),
    );
    var weights = vec4<f32>((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    var edge = 0.0;
    var own = NOTHING;
    var most = -1.0;
    for (var k = 0u; k < 4u; k++) {
        edge += weights[k] * texels[k].y;
        if texels[k].x < FINITE && weights[k] > most {
            own = texels[k].x;
            most = weights[k];
        }
    }
    if !(edge > 0.0) {
        return NOTHING;
    }
    var sum = 0.0;
    var weight = 0.0;
    for (var k = 0u; k < 4u; k++) {
        if abs(texels[k].x - own) <= impostor.wall {
            sum += weights[k] * texels[k].x;
            weight += weights[k];
        }
    }
    return sum / weight;
}

// How far the point at t lies below the surface of its column.
fn below(map: u32, ray: Ray, t: f32) -> f32 {
    let p = ray.origin + ray.direction * t;
    return p.z - height(map, p.xy);
}

// Steps of equal length, then halvings (section 3.3, after Policarpo et al. 2005).
fn search_linear(map: u32, ray: Ray, t0: f32, t1: f32) -> f32 {
    let step = (t1 - t0) / f32(impostor.steps);
    var above = t0;
    var under = NOTHING;
    for (var i = 0u; i <= impostor.steps; i++) {
        let t = t0 + step * f32(i);
        if below(map, ray, t) >= 0.0 {
            under = t;
            break;
        }
        above = t;
    }
    if under > FINITE {
        return NOTHING;
    }
    for (var i = 0u; i < impostor.halvings; i++) {
        let middle = (above + under) * 0.5;
        if below(map, ray, middle) >= 0.0 {
            under = middle;
        } else {
            above = middle;
        }
    }
    let a = ray.origin + ray.direction * above;
    let b = ray.origin + ray.direction * under;
    // A wall lies between them.
    if !(abs(height(map, a.xy) - height(map, b.xy)) <= impostor.wall) {
        return NOTHING;
    }
    return under;
}

// Where the ray meets the surface of a map first, for start ≤ t ≤ end; infinite where it meets a wall first, or nothing.
fn trace(map: u32, ray: Ray, start: f32, end: f32) -> f32 {
    let window = maps[map].window;
    let low = vec3<f32>(window.xy, 0.0);
    let high = vec3<f32>(window.zw, maps[map].deep);
    let still = ray.direction == vec3<f32>(0.0);
    if any(still & ((ray.origin < low) | (ray.origin > high))) {
        return NOTHING;
    }
    let over = 1.0 / select(ray.direction, vec3<f32>(1.0), still);
    let a = select((low - ray.origin) * over, vec3<f32>(start), still);
    let b = select((high - ray.origin) * over, vec3<f32>(end), still);
    let first = min(a, b);
    let last = max(a, b);
    let t0 = max(max(first.x, first.y), max(first.z, start));
    let t1 = min(min(last.x, last.y), min(last.z, end));
    if !(t0 <= t1) {
        return NOTHING;
    }
    if impostor.steps > 0u {
        return search_linear(map, ray, t0, t1);
    }
    return search_pyramid(map, ray, t0, t1);
}

// The slope of the surface along an axis from its heights half a texel before and after a point; at an edge of one side alone.
fn slope(before: f32, at: f32, after: f32) -> f32 {
    let has_before = abs(before - at) <= impostor.wall;
    let has_after = abs(after - at) <= impostor.wall;
    if has_before && has_after {
        return after - before;
    }
    if has_before {
        return 2.0 * (at - before);
    }
    if has_after {
        return 2.0 * (after - at);
    }
    return 0.0;
}

// Cosine of the angle between the map's direction and the surface's normal.
fn squareness(map: u32, p: vec3<f32>) -> f32 {
    let u = vec2<f32>(0.5, 0.0);
    let v = vec2<f32>(0.0, 0.5);
    let x = slope(height(map, p.xy - u), p.z, height(map, p.xy + u));
    let y = slope(height(map, p.xy - v), p.z, height(map, p.xy + v));
    return 1.0 / sqrt(x * x + y * y + 1.0);
}

fn map_ray(map: u32, ray: Ray) -> Ray {
    let r = maps[map].rows;
    let o = vec4<f32>(ray.origin, 1.0);
    return Ray(
        vec3<f32>(dot(r[0], o), dot(r[1], o), dot(r[2], o)),
        vec3<f32>(dot(r[0].xyz, ray.direction), dot(r[1].xyz, ray.direction), dot(r[2].xyz, ray.direction)),
    );
}

// The k-th map of an instance.
fn map_of(instance: u32, k: u32) -> u32 {
    let pair = instances[instance].maps[k >> 1u];
    return select(pair & 0xffffu, pair >> 16u, (k & 1u) == 1u);
}

struct Seen {
    map: u32,
    t: f32,
}

// What a ray sees of an instance: the fragments of its maps, ranked.
fn see(instance: u32, ray: Ray, start: f32, end: f32) -> Seen {
    var found: array<f32, 8>;
    var nearest = NOTHING;
    var best = Seen(NO_MAP, NOTHING);
    var least = NOTHING;
    for (var k = 0u; k < MAPS; k++) {
        found[k] = NOTHING;
        let map = map_of(instance, k);
        if map == NO_MAP {
            continue;
        }
        let r = map_ray(map, ray);
        let t = trace(map, r, start, end);
        if t > FINITE {
            continue;
        }
        found[k] = t;
        nearest = min(nearest, t);
        var rank = t;
        switch impostor.strategy {
            case 1u: {
                rank = select(-r.origin.z / r.direction.z, FINITE, r.direction.z == 0.0);
            }
            case 4u: {
                rank = -squareness(map, r.origin + r.direction * t);
            }
            case 5u: {
                let m = maps[map];
                rank = t - BIAS * (m.deep * m.texel) * squareness(map, r.origin + r.direction * t);
            }
            default: {}
        }
        if rank < least {
            best = Seen(map, t);
            least = rank;
        }
    }
    if impostor.strategy == 3u && best.map != NO_MAP {
        // The first whose surface lies no more than a wall behind the nearest one.
        for (var k = 0u; k < MAPS; k++) {
            let map = map_of(instance, k);
            if found[k] < FINITE && !(found[k] > nearest + impostor.wall * maps[map].texel) {
                return Seen(map, found[k]);
            }
        }
    }
    return best;
}

struct Fragment {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn ori_fragment(in: Proxy) -> Fragment {
    let instance = instances[in.instance];
    let scale = instance.place.w;
    // The ray in impostor space, as long as one unit of planar depth; t is measured from the depth of the object's middle.
    let forward = turned_back(frame.depth.xyz, instance.rotation);
    let eye = turned_back(frame.eye.xyz - instance.place.xyz * frame.eye.w, instance.rotation);
    let from_eye = in.position - (eye / scale - impostor.centre.xyz);
    var direction = select(-eye, from_eye, frame.eye.w > 0.0);
    direction /= dot(forward, direction);
    let ray = Ray(in.position - direction * dot(forward, in.position), direction);
    // Planar depth of the middle, in metres of impostor space.
    let centre = instance.place.xyz + turned(impostor.centre.xyz, instance.rotation) * scale;
    let middle = dot(frame.depth, vec4<f32>(centre, 1.0)) / scale;
    let seen = see(in.instance, ray, frame.near / scale - middle, frame.far / scale - middle);
    if seen.map == NO_MAP {
        discard;
    }
    let local = ray.origin + ray.direction * seen.t + impostor.centre.xyz;
    let position = instance.place.xyz + turned(local, instance.rotation) * scale;
    let clip = frame.clip * vec4<f32>(position, 1.0);
    let depth = (middle + seen.t) * scale;
    return Fragment(vec4<f32>(shade(seen, instance, local - impostor.centre.xyz, position, depth), 1.0), clip.z / clip.w);
}

fn shade(seen: Seen, instance: Instance, local: vec3<f32>, position: vec3<f32>, depth: f32) -> vec3<f32> {
    let map = maps[seen.map];
    let p = vec4<f32>(local, 1.0);
    let uv = vec2<f32>(dot(map.rows[0], p), dot(map.rows[1], p)) / f32(impostor.side);
    // The level whose texels are as large as a sample.
    let sample = frame.sample_size * select(1.0, depth, frame.eye.w > 0.0) / (map.texel * instance.place.w);
    let level = clamp(log2(max(sample, 1.0)), 0.0, f32(impostor.levels - 1u));
    let base = textureSampleLevel(color, smooth_sampler, uv, seen.map, level).rgb;
    if frame.shading == 0u {
        return base;
    }
    let bent = (textureSampleLevel(normals, smooth_sampler, uv, seen.map, level).xy * 255.0 - 127.0) / 127.0;
    let out = sqrt(max(1.0 - dot(bent, bent), 0.0));
    // Rows are the map's right, down and forward.
    let normal = normalize(map.rows[0].xyz * bent.x - map.rows[1].xyz * bent.y - map.rows[2].xyz * out);
    let glow = textureSampleLevel(emissive, smooth_sampler, uv, seen.map, level).rgb * f32(impostor.emits);
    return lit(base, turned(normal, instance.rotation), position) + glow;
}

// A sun without shadows, a sky that is brighter above, and the highlight of Blinn's model.
fn lit(base: vec3<f32>, normal: vec3<f32>, position: vec3<f32>) -> vec3<f32> {
    let sun = max(dot(normal, frame.to_sun.xyz), 0.0);
    let ambient = mix(frame.ground.rgb, frame.sky.rgb, 0.5 + 0.5 * normal.y);
    var out = base * (frame.sun.rgb * sun + ambient);
    if frame.sun.w > 0.0 && sun > 0.0 {
        let to_eye = normalize(frame.eye.xyz - position * frame.eye.w);
        let h = normalize(frame.to_sun.xyz + to_eye);
        out += frame.sun.rgb * (frame.sun.w * pow(max(dot(normal, h), 0.0), frame.to_sun.w) * sun);
    }
    return out;
}
