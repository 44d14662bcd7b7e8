// Assign: which triangle each texel's depth is of, and which tiles each large triangle touches. Neither waits for the other, so
// one dispatch does both: number.wgsl along its first row of workgroups, bin.wgsl along its second.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
@group(0) @binding(3) var<storage, read> vertices: array<CasterVertex>;
@group(0) @binding(4) var<storage, read> depths: array<u32>;
// The greatest number, with one added, of the triangles that have a texel's depth.
@group(0) @binding(5) var<storage, read_write> numbers: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> records: array<vec4<u32>>;
// Jobs, winners and the tiles' lists.
@group(0) @binding(7) var<storage, read_write> lists: array<u32>;
// Counters of items and tiles.
@group(0) @binding(8) var<storage, read_write> state: array<atomic<u32>>;

const THREADS: u32 = 64u;

@compute @workgroup_size(64)
fn assign(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    if group.y == 0u {
        number(view, group.x, groups.x, thread);
    } else {
        bin(view, group.x, groups.x, thread);
    }
}
