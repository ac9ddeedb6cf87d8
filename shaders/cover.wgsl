// Which samples a snapped triangle covers, and how near it is there: the twin of src/raster/cover.rs, in whole numbers,
// so that every adapter finds the same samples and the same order.
//
// Numbers of 64 bits are vec2<u32>(low, high), two's complement.

struct Triangle {
    // 1/256 px, y down; positive area.
    corners: array<vec2<i32>, 3>,
    // The sample to which c belongs: the first within the triangle's bounds and the view.
    first: vec2<i32>,
    // Change of the depth function from sample to sample in x and in y, and its value at `first`, times 2^exponent.
    a: vec2<u32>,
    b: vec2<u32>,
    c: vec2<u32>,
    // Least and greatest value of the function on the triangle, as `nearness` orders them.
    low: u32,
    high: u32,
    exponent: i32,
    padding: u32,
}

// Some triangles in some tiles of a band of rows.
struct Frame {
    // The view, pixels.
    width: u32,
    height: u32,
    // The band's first row.
    first_row: u32,
    // Tiles: how many stand side by side, and their side in pixels.
    columns: u32,
    side: u32,
    // How many items there are.
    items: u32,
    // Number of the first triangle of the batch.
    base: u32,
    // 1 where the depth function is 1/depth and grows towards the eye, 0 where it is depth.
    perspective: u32,
    // Which pass this is; each shader says what it means.
    round: u32,
}

// A triangle in a tile.
struct Item {
    triangle: u32,
    tile: u32,
}

struct Rect {
    low: vec2<i32>,
    high: vec2<i32>,
}

struct Edge {
    e: i32,
    dx: i32,
    dy: i32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(2) var<storage, read> items: array<Item>;

fn product(a: u32, b: u32) -> vec2<u32> {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let low = a0 * b0;
    let middle = a1 * b0 + (low >> 16u);
    let other = a0 * b1 + (middle & 0xffffu);
    return vec2<u32>((other << 16u) | (low & 0xffffu), a1 * b1 + (middle >> 16u) + (other >> 16u));
}

fn sum(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn negated(a: vec2<u32>) -> vec2<u32> {
    return sum(~a, vec2<u32>(1u, 0u));
}

fn signed_product(a: i32, b: i32) -> vec2<u32> {
    let p = product(u32(abs(a)), u32(abs(b)));
    return select(p, negated(p), (a ^ b) < 0);
}

// `a` times a count.
fn times(a: vec2<u32>, n: u32) -> vec2<u32> {
    let low = product(a.x, n);
    return vec2<u32>(low.x, low.y + a.y * n);
}

fn samples_within(t: u32) -> Rect {
    let a = triangles[t].corners[0];
    let b = triangles[t].corners[1];
    let c = triangles[t].corners[2];
    // An arithmetic shift rounds down.
    let shift = vec2<u32>(8u, 8u);
    return Rect((min(min(a, b), c) + 127) >> shift, (max(max(a, b), c) - 128) >> shift);
}

// The samples of a triangle's bounds in a tile of the view.
fn rect_in_tile(item: Item) -> Rect {
    let tile = vec2<i32>(i32(item.tile % frame.columns), i32(item.tile / frame.columns)) * i32(frame.side);
    let last = min(tile + i32(frame.side), vec2<i32>(i32(frame.width), i32(frame.height))) - 1;
    let all = samples_within(item.triangle);
    return Rect(max(all.low, tile), min(all.high, last));
}

// floor(E/256) at a sample and its change to the next: within a tile it is at most 2^30 away from its first value.
fn edge(a: vec2<i32>, b: vec2<i32>, sample: vec2<i32>) -> Edge {
    let d = b - a;
    let top_left = (d.y < 0) || ((d.y == 0) && (d.x > 0));
    let p = sample * 256 + 128 - a;
    var e = sum(signed_product(d.x, p.y), negated(signed_product(d.y, p.x)));
    if !top_left {
        e = sum(e, vec2<u32>(0xffffffffu, 0xffffffffu));
    }
    let low = (e.x >> 8u) | (e.y << 24u);
    let high = i32(e.y) >> 8u;
    if (high == 0 && low < 0x40000000u) || (high == -1 && low >= 0xc0000000u) {
        return Edge(i32(low), -d.y, d.x);
    }
    // The same side all over the tile.
    return Edge(select(0, -1, high < 0), 0, 0);
}

// The bits of the float nearest to a positive number times 2^-exponent; 0 and infinity where it has none.
fn float_bits(value: vec2<u32>, exponent: i32) -> u32 {
    var v = value;
    var zeros = countLeadingZeros(v.y);
    if v.y == 0u {
        zeros = 32u + countLeadingZeros(v.x);
        v = vec2<u32>(0u, v.x);
        if v.y == 0u {
            return 0u;
        }
    }
    let shift = zeros % 32u;
    if shift > 0u {
        v = vec2<u32>(v.x << shift, (v.y << shift) | (v.x >> (32u - shift)));
    }
    var mantissa = v.y >> 8u;
    let rest = v.y & 0xffu;
    if rest > 0x80u || (rest == 0x80u && (v.x != 0u || (mantissa & 1u) == 1u)) {
        mantissa += 1u;
    }
    // A carry into bit 24 makes the mantissa zero and the exponent one more, as the addition below does by itself.
    let biased = 63 - i32(zeros) - exponent + 127;
    if biased <= 0 {
        return 0u;
    }
    if biased >= 255 {
        return 0x7f800000u;
    }
    return (u32(biased - 1) << 23u) + mantissa;
}

// The depth function at a sample as a number that sorts like it, kept within the triangle's own; the nearer the greater, and
// never 0.
fn nearness(t: u32, sample: vec2<i32>) -> u32 {
    let d = vec2<u32>(sample - triangles[t].first);
    let along = sum(times(triangles[t].a, d.x), times(triangles[t].b, d.y));
    let q = sum(triangles[t].c, along);
    let negative = i32(q.y) < 0;
    let bits = float_bits(select(q, negated(q), negative), triangles[t].exponent);
    // As whole numbers: floats with a sign run the other way and come first.
    let ordered = select(bits | 0x80000000u, ~(bits | 0x80000000u), negative);
    let kept = clamp(ordered, triangles[t].low, triangles[t].high);
    return select(~kept, kept, frame.perspective == 1u);
}

// Place of a sample in the band's pixels.
fn pixel_of(sample: vec2<i32>) -> u32 {
    return (u32(sample.y) - frame.first_row) * frame.width + u32(sample.x);
}

fn cover_row(item: Item, rect: Rect, y: i32) {
    let start = vec2<i32>(rect.low.x, rect.low.y);
    let t = item.triangle;
    let down = y - rect.low.y;
    let a = edge(triangles[t].corners[0], triangles[t].corners[1], start);
    let b = edge(triangles[t].corners[1], triangles[t].corners[2], start);
    let c = edge(triangles[t].corners[2], triangles[t].corners[0], start);
    var e = vec3<i32>(a.e + a.dy * down, b.e + b.dy * down, c.e + c.dy * down);
    let step = vec3<i32>(a.dx, b.dx, c.dx);
    for (var x = rect.low.x; x <= rect.high.x; x++) {
        if all(e >= vec3<i32>(0)) {
            visit(t, vec2<i32>(x, y));
        }
        e += step;
    }
}

// Of a small triangle, all rows by one thread.
@compute @workgroup_size(64)
fn small(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= frame.items {
        return;
    }
    let rect = rect_in_tile(items[i]);
    for (var y = rect.low.y; y <= rect.high.y; y++) {
        cover_row(items[i], rect, y);
    }
}

// Of a large triangle, each row of a tile by a thread of its own.
@compute @workgroup_size(64)
fn large(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) row: u32,
) {
    let i = group.y * groups.x + group.x;
    if i >= frame.items {
        return;
    }
    let rect = rect_in_tile(items[i]);
    let y = rect.low.y + i32(row);
    if y <= rect.high.y {
        cover_row(items[i], rect, y);
    }
}
