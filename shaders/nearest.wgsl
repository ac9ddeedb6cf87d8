// The nearest surface of every pixel of a band: round 0 finds how near it is, round 1 which triangles may be the nearest: the
// least and the greatest of their numbers. Where these differ the CPU decides by exact depths. The twin of src/raster/nearest.rs.
// All buffers begin as zeros, which mean nothing.

@group(0) @binding(3) var<storage, read_write> nearest: array<atomic<u32>>;
// The least number, as its bitwise complement.
@group(0) @binding(4) var<storage, read_write> least: array<atomic<u32>>;
// The greatest number plus one.
@group(0) @binding(5) var<storage, read_write> greatest: array<atomic<u32>>;

// How many floats lie between two depths that rounding here and on the CPU may order either way: each rounds the function's
// value, its inverse and the ends between which it is kept.
const CLOSE: u32 = 16u;

fn visit(t: u32, sample: vec2<i32>) {
    let pixel = pixel_of(sample);
    let near = nearness(t, sample);
    if frame.round == 0u {
        atomicMax(&nearest[pixel], near);
    } else if atomicLoad(&nearest[pixel]) - near <= CLOSE {
        atomicMax(&least[pixel], ~(frame.base + t));
        atomicMax(&greatest[pixel], frame.base + t + 1u);
    }
}
