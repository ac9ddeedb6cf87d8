// All surfaces of every pixel of a band: round 0 counts them, round 1 writes the triangles' numbers, in any order, from where
// each pixel's list begins. The twin of src/raster/fragments.rs.

@group(0) @binding(3) var<storage, read_write> count: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> list: array<u32>;

fn visit(t: u32, sample: vec2<i32>) {
    let at = atomicAdd(&count[pixel_of(sample)], 1u);
    if frame.round == 1u {
        list[at] = frame.base + t;
    }
}
