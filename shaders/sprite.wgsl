// The parity test on a depth sprite (Trapp and Döllner 2008, figure 13), the twin of src/sprite/packed.rs: bind the data file as
// `sprite_data` and what its manifest says as `sprite`, and ask `sprite_contains`, in any stage.

struct Sprite {
    // x, y, width, height of the texels that are kept.
    region: vec4<u32>,
    // Where the sections of the manifest begin in `sprite_data`, in words of 4 bytes, in their order.
    sections: vec4<u32>,
    // Texels of the whole image.
    size: vec2<u32>,
    // 0 raw, 1 ranges, 2 rows, 3 runs.
    packing: u32,
    depth_complexity: u32,
}

@group(0) @binding(0) var<uniform> sprite: Sprite;
@group(0) @binding(1) var<storage, read> sprite_data: array<u32>;

// Whether a point of texture space (s, t, r), that is `world_to_texture` times a point of the world, lies inside.
fn sprite_contains(point: vec3<f32>) -> bool {
    if !(point.x >= 0.0 && point.x < 1.0 && point.y >= 0.0 && point.y < 1.0) {
        return false;
    }
    let texel = vec2<u32>(point.xy * vec2<f32>(sprite.size));
    if any(texel < sprite.region.xy) {
        return false;
    }
    let p = texel - sprite.region.xy;
    if any(p >= sprite.region.zw) {
        return false;
    }
    switch sprite.packing {
        case 0u: {
            return in_layers(p, point.z);
        }
        case 1u: {
            return in_texture(p, point.z);
        }
        case 2u: {
            return in_rows(p, point.z);
        }
        default: {
            return in_runs(p, point.z);
        }
    }
}

fn in_layers(p: vec2<u32>, z: f32) -> bool {
    let n = sprite.region.z * sprite.region.w;
    let at = sprite.sections.x + p.y * sprite.region.z + p.x;
    for (var k = 0u; k < sprite.depth_complexity; k += 2u) {
        let start = bitcast<f32>(sprite_data[at + k * n]);
        // Ranges are sorted, and 1 stands for none.
        if start > z || start == 1.0 {
            return false;
        }
        if z <= bitcast<f32>(sprite_data[at + (k + 1u) * n]) {
            return true;
        }
    }
    return false;
}

fn in_texture(p: vec2<u32>, z: f32) -> bool {
    let at = sprite.sections.x + 2u * (p.y * sprite.region.z + p.x);
    let first = sprite.sections.x + 2u * sprite_data[at];
    return in_ranges(first, sprite_data[at + 1u], z);
}

fn in_rows(p: vec2<u32>, z: f32) -> bool {
    let before = sprite_data[sprite.sections.x + p.y];
    let texel = p.y * sprite.region.z + p.x;
    let first = before + prefix(texel);
    var end = sprite_data[sprite.sections.x + p.y + 1u];
    if p.x + 1u < sprite.region.z {
        end = before + prefix(texel + 1u);
    }
    return in_ranges(sprite.sections.z + 2u * first, end - first, z);
}

// Two numbers share a word.
fn prefix(texel: u32) -> u32 {
    let word = sprite_data[sprite.sections.y + texel / 2u];
    return (word >> (16u * (texel % 2u))) & 0xffffu;
}

fn in_runs(p: vec2<u32>, z: f32) -> bool {
    var low = sprite_data[sprite.sections.x + p.y];
    let begin = low;
    var high = sprite_data[sprite.sections.x + p.y + 1u];
    // The first run that begins beyond the texel.
    while low < high {
        let middle = (low + high) / 2u;
        if (sprite_data[sprite.sections.y + 3u * middle] & 0xffffu) <= p.x {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low == begin {
        return false;
    }
    let run = sprite.sections.y + 3u * (low - 1u);
    let place = sprite_data[run];
    let along = p.x - (place & 0xffffu);
    if along >= place >> 16u {
        return false;
    }
    let count = sprite_data[run + 1u];
    return in_ranges(sprite.sections.z + 2u * (sprite_data[run + 2u] + along * count), count, z);
}

// Of `count` sorted ranges from a word on.
fn in_ranges(first: u32, count: u32, z: f32) -> bool {
    for (var i = 0u; i < count; i++) {
        let start = bitcast<f32>(sprite_data[first + 2u * i]);
        if start > z {
            return false;
        }
        if z <= bitcast<f32>(sprite_data[first + 2u * i + 1u]) {
            return true;
        }
    }
    return false;
}
