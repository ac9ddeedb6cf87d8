// What the functions of sprite.wgsl say along rays; for tests.

struct Probe {
    // Origin, and half side of the cube of the eight-corner test.
    origin: vec4<f32>,
    // Direction, and which sprite.
    direction: vec4<f32>,
}

@group(0) @binding(2) var<storage, read> probes: array<Probe>;
// Whether the origin lies inside, its zone, and where the ray enters and leaves.
@group(0) @binding(3) var<storage, read_write> found: array<vec4<u32>>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let k = id.y * groups.x * 64u + id.x;
    if k < arrayLength(&probes) {
        let p = probes[k];
        let i = u32(p.direction.w);
        let inside = sprite_contains(i, sprite_texture(i, p.origin.xyz));
        let span = sprite_enter(i, p.origin.xyz, p.direction.xyz);
        found[k] = vec4<u32>(u32(inside), sprite_zone(i, p.origin.xyz, p.origin.w), bitcast<vec2<u32>>(span));
    }
}
