// Depth sprites in shaders (Trapp and Döllner 2008): the parity test of figure 13, the eight-corner test of section 3.3, and rays.
// The twin of src/sprite/packed.rs and volume.rs. For any stage, and any number of sprites in one pass: `sprites` holds what each manifest
// says, `sprite_data` all data files one after the other.

struct Sprite {
    // Rows of the matrix of equation (2): (s, t, r) = M·(x, y, z, 1).
    world_to_texture: array<vec4<f32>, 3>,
    // x, y, width, height of the texels that are kept.
    region: vec4<u32>,
    // Where the sections of the manifest begin in `sprite_data`, in words of 4 bytes, in their order.
    sections: vec4<u32>,
    // Texels of the whole image.
    size: vec2<u32>,
    // 0 raw, 1 ranges, 2 rows, 3 runs.
    packing: u32,
    depth_complexity: u32,
    // Of depths of 16 bits: the manifest's base and step. A step of 0 says that depths are floats.
    depth_base: u32,
    depth_step: f32,
}

@group(0) @binding(0) var<storage, read> sprites: array<Sprite>;
@group(0) @binding(1) var<storage, read> sprite_data: array<u32>;

const SPRITE_OUTSIDE = 0u;
const SPRITE_BORDER = 1u;
const SPRITE_INSIDE = 2u;

// A point of the world in the texture space of sprite i.
fn sprite_texture(i: u32, world: vec3<f32>) -> vec3<f32> {
    let p = vec4<f32>(world, 1.0);
    return vec3<f32>(
        dot(sprites[i].world_to_texture[0], p),
        dot(sprites[i].world_to_texture[1], p),
        dot(sprites[i].world_to_texture[2], p),
    );
}

// Whether a point of texture space lies inside sprite i.
fn sprite_contains(i: u32, point: vec3<f32>) -> bool {
    if !(point.x >= 0.0 && point.x < 1.0 && point.y >= 0.0 && point.y < 1.0) {
        return false;
    }
    let texel = vec2<u32>(point.xy * vec2<f32>(sprites[i].size));
    if any(texel < sprites[i].region.xy) {
        return false;
    }
    let p = texel - sprites[i].region.xy;
    if any(p >= sprites[i].region.zw) {
        return false;
    }
    let ranges = sprite_ranges(i, p);
    for (var k = 0u; k < ranges.y; k++) {
        let range = sprite_range(i, ranges.x, k);
        // Ranges are sorted, and 1 stands for none.
        if range.x > point.z || range.x == 1.0 {
            return false;
        }
        if point.z <= range.y {
            return true;
        }
    }
    return false;
}

// Where a point of the world lies as the corners of the cube of half side `half` around it say.
fn sprite_zone(i: u32, world: vec3<f32>, half: f32) -> u32 {
    var count = 0u;
    for (var k = 0u; k < 8u; k++) {
        let corner = vec3<f32>(f32(k & 1u), f32((k >> 1u) & 1u), f32(k >> 2u)) * 2.0 - 1.0;
        count += u32(sprite_contains(i, sprite_texture(i, world + corner * half)));
    }
    if count == 0u {
        return SPRITE_OUTSIDE;
    }
    return select(SPRITE_BORDER, SPRITE_INSIDE, count == 8u);
}

// Where the ray origin + t·direction, t ≥ 0, enters sprite i first, and where it leaves it again; the first exceeds the second where it never
// does.
fn sprite_enter(i: u32, origin: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    let none = vec2<f32>(1.0, 0.0);
    // In texels from the corner of the region, and in depth.
    let size = vec3<f32>(vec2<f32>(sprites[i].size), 1.0);
    let end = vec3<f32>(vec2<f32>(sprites[i].region.zw), 1.0);
    let o = sprite_texture(i, origin) * size - vec3<f32>(vec2<f32>(sprites[i].region.xy), 0.0);
    let d = (sprite_texture(i, origin + direction) - sprite_texture(i, origin)) * size;
    var t = 0.0;
    var last = 3.4e38;
    for (var k = 0u; k < 3u; k++) {
        if d[k] == 0.0 {
            if !(o[k] >= 0.0 && o[k] < end[k]) {
                return none;
            }
        } else {
            let a = -o[k] / d[k];
            let b = (end[k] - o[k]) / d[k];
            t = max(t, min(a, b));
            last = min(last, max(a, b));
        }
    }
    let limit = vec2<i32>(sprites[i].region.zw);
    var texel = clamp(vec2<i32>(floor(o.xy + d.xy * t)), vec2<i32>(0), limit - 1);
    let step = vec2<i32>(sign(d.xy));
    var found = none;
    while t < last {
        // Where the ray leaves the texel, along each axis.
        let border = vec2<f32>(texel + max(step, vec2<i32>(0)));
        let next = select((border - o.xy) / d.xy, vec2<f32>(3.4e38), step == vec2<i32>(0));
        let until = min(min(next.x, next.y), last);
        if t < until {
            let ranges = sprite_ranges(i, vec2<u32>(texel));
            var touched = false;
            for (var n = 0u; n < ranges.y; n++) {
                let k = select(n, ranges.y - 1u - n, d.z < 0.0);
                let range = sprite_range(i, ranges.x, k);
                var part = vec2<f32>(t, until);
                if d.z == 0.0 {
                    part = select(none, part, range.x <= o.z && o.z <= range.y);
                } else {
                    let at = (range - o.z) / d.z;
                    part = vec2<f32>(max(t, min(at.x, at.y)), min(until, max(at.x, at.y)));
                }
                if range.x == 1.0 || part.x >= part.y {
                    continue;
                }
                if found.x > found.y {
                    found = part;
                } else if part.x <= found.y {
                    found.y = max(found.y, part.y);
                } else {
                    return found;
                }
                touched = found.y >= until;
            }
            if found.x <= found.y && !touched {
                return found;
            }
            t = until;
        }
        let along = u32(next.y < next.x);
        texel[along] += step[along];
        if step[along] == 0 || texel[along] < 0 || texel[along] >= limit[along] {
            break;
        }
    }
    return found;
}

// The first word of the ranges of a texel of the region, and their number.
fn sprite_ranges(i: u32, p: vec2<u32>) -> vec2<u32> {
    let sections = sprites[i].sections;
    let width = sprites[i].region.z;
    let texel = p.y * width + p.x;
    switch sprites[i].packing {
        case 0u: {
            return vec2<u32>(sections.x + texel, sprites[i].depth_complexity / 2u);
        }
        case 1u: {
            let at = sections.x + 2u * texel;
            return vec2<u32>(sections.x + 2u * sprite_data[at], sprite_data[at + 1u]);
        }
        case 2u: {
            let before = sprite_data[sections.x + p.y];
            let first = before + prefix(sections.y, texel);
            var end = sprite_data[sections.x + p.y + 1u];
            if p.x + 1u < width {
                end = before + prefix(sections.y, texel + 1u);
            }
            return vec2<u32>(sections.z + words_of_range(i) * first, end - first);
        }
        default: {
            return in_runs(i, p);
        }
    }
}

// Two numbers share a word.
fn prefix(section: u32, texel: u32) -> u32 {
    return (sprite_data[section + texel / 2u] >> (16u * (texel % 2u))) & 0xffffu;
}

fn words_of_range(i: u32) -> u32 {
    return select(1u, 2u, sprites[i].depth_step == 0.0);
}

fn in_runs(i: u32, p: vec2<u32>) -> vec2<u32> {
    let sections = sprites[i].sections;
    var low = sprite_data[sections.x + p.y];
    let begin = low;
    var high = sprite_data[sections.x + p.y + 1u];
    // The first run that begins beyond the texel.
    while low < high {
        let middle = (low + high) / 2u;
        if (sprite_data[sections.y + 3u * middle] & 0xffffu) <= p.x {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low == begin {
        return vec2<u32>(0u);
    }
    let run = sections.y + 3u * (low - 1u);
    let place = sprite_data[run];
    let along = p.x - (place & 0xffffu);
    if along >= place >> 16u {
        return vec2<u32>(0u);
    }
    let count = sprite_data[run + 1u];
    return vec2<u32>(sections.z + words_of_range(i) * (sprite_data[run + 2u] + along * count), count);
}

// Range k of those that begin at a word; it begins at 1 where there is none.
fn sprite_range(i: u32, first: u32, k: u32) -> vec2<f32> {
    if sprites[i].packing == 0u {
        // A layer after the other.
        let n = sprites[i].region.z * sprites[i].region.w;
        let at = first + 2u * k * n;
        return vec2<f32>(bitcast<f32>(sprite_data[at]), bitcast<f32>(sprite_data[at + n]));
    }
    if sprites[i].packing > 1u && sprites[i].depth_step > 0.0 {
        let word = sprite_data[first + k];
        let steps = vec2<u32>(word & 0xffffu, word >> 16u) + sprites[i].depth_base;
        return vec2<f32>(steps) * sprites[i].depth_step;
    }
    let at = first + 2u * k;
    return vec2<f32>(bitcast<f32>(sprite_data[at]), bitcast<f32>(sprite_data[at + 1u]));
}
