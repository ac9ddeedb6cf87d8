// Which of some points of texture space lie inside the first depth sprite: one bit each.

@group(0) @binding(2) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> inside: array<atomic<u32>>;

@compute @workgroup_size(64)
fn classify(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < arrayLength(&points) && sprite_contains(0u, points[i].xyz) {
        atomicOr(&inside[i / 32u], 1u << (i % 32u));
    }
}
