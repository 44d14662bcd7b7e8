// Route: which triangles each hemisphere has to draw, and which have to be split first.
// One workgroup takes one chunk after the other; a vertex is projected once for all its triangles.

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read_write> arguments: Arguments;
@group(0) @binding(2) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(3) var<storage, read> chunk_bounds: array<ChunkBounds>;
@group(0) @binding(4) var<storage, read> triangles: array<u32>;
@group(0) @binding(5) var<storage, read> positions: array<f32>;
// A part for each hemisphere: what to draw from the front on, what to split from the end on.
@group(0) @binding(6) var<storage, read_write> lists: array<u32>;

const THREADS: u32 = 128u;
const TRIANGLES_PER_THREAD: u32 = 2u;

const DROP: u32 = 0u;
const DRAW: u32 = 1u;
const SPLIT: u32 = 2u;

var<workgroup> corners: array<vec3<f32>, 256>;
var<workgroup> draw_count: atomic<u32>;
var<workgroup> split_count: atomic<u32>;
var<workgroup> draw_base: u32;
var<workgroup> split_base: u32;

@compute @workgroup_size(128)
fn route(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var chunk = view.first_chunk + group.x; chunk < view.end_chunk; chunk += groups.x) {
        let hemispheres = hemispheres_of(chunk);
        for (var hemisphere = 0u; hemisphere < 2u; hemisphere += 1u) {
            if (hemispheres & (1u << hemisphere)) != 0u {
                route_chunk(chunk, hemisphere, thread);
            }
        }
    }
}

// The hemispheres that the chunk may be seen in, as bits; none if it is unused or out of range.
fn hemispheres_of(chunk: u32) -> u32 {
    if triangle_count(chunk_sources[chunk]) == 0u {
        return 0u;
    }
    let low = chunk_bounds[chunk].min - view.position;
    let high = chunk_bounds[chunk].max - view.position;
    let nearest = max(max(low, -high), vec3<f32>(0.0));
    if dot(nearest, nearest) > view.range * view.range {
        return 0u;
    }
    if !REJECT {
        return view.hemispheres;
    }
    // Highest and lowest z of light space in the box, and how far that still is inside a hemisphere.
    let centre = dot(view.forward, 0.5 * (low + high));
    let extent = dot(abs(view.forward), 0.5 * (high - low));
    let farthest = length(max(abs(low), abs(high)));
    let slack = (1e-5 - view.behind) * farthest;
    let front = centre + extent + slack >= 0.0;
    let back = extent - centre + slack >= 0.0;
    return (select(0u, 1u, front) | select(0u, 2u, back)) & view.hemispheres;
}

// Sign of the map area of triangles that don't cast, 0 if all do.
fn culled_area(chunk: u32) -> f32 {
    let rule = culling(chunk_sources[chunk]);
    let bounds = chunk_bounds[chunk];
    // Outside by more than near, nothing of a closed piece is clipped, so a front face hides every back face.
    let outside = any(view.position < bounds.pieces_min - view.near)
        || any(view.position > bounds.pieces_max + view.near);
    let culls = rule == CULL_ALWAYS || (REJECT && rule == CULL_CLOSED && outside);
    // A face turned to the light is clockwise in the map: (u, v) is seen from the other side.
    return select(0.0, bounds.handedness, culls);
}

fn route_chunk(chunk: u32, hemisphere: u32, thread: u32) {
    let source = chunk_sources[chunk];
    if thread == 0u {
        atomicStore(&draw_count, 0u);
        atomicStore(&split_count, 0u);
    }
    for (var v = thread; v < vertex_count(source); v += THREADS) {
        let at = 3u * (source.vertex + v);
        let world = vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]);
        corners[v] = project_corner(dp_to_hemisphere(light_space(world - view.position), hemisphere == 1u));
    }
    workgroupBarrier();

    let cull = culled_area(chunk);
    var fates: array<u32, TRIANGLES_PER_THREAD>;
    var places: array<u32, TRIANGLES_PER_THREAD>;
    var entries: array<vec3<u32>, TRIANGLES_PER_THREAD>;
    for (var i = 0u; i < TRIANGLES_PER_THREAD; i += 1u) {
        let t = thread + i * THREADS;
        fates[i] = DROP;
        if t < triangle_count(source) {
            let packed = triangles[source.triangle + t];
            let local = vec3<u32>(packed, packed >> 8u, packed >> 16u) & vec3<u32>(0xffu);
            let a = corners[local.x];
            let b = corners[local.y];
            let c = corners[local.z];
            entries[i] = local + source.vertex;
            if !is_outside(a, b, c) {
                let edges = edges_to_split(a.xy, b.xy, c.xy);
                if edges != 0u {
                    fates[i] = SPLIT;
                    entries[i] |= select(vec3<u32>(), vec3<u32>(EDGE_FLAG), (vec3<u32>(edges) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>());
                    entries[i] |= select(vec3<u32>(), vec3<u32>(CULL_FLAG), vec3<bool>(false, cull > 0.0, cull < 0.0));
                    places[i] = atomicAdd(&split_count, 1u);
                } else if !is_rejected(a.xy, b.xy, c.xy, cull) {
                    fates[i] = DRAW;
                    places[i] = atomicAdd(&draw_count, 1u);
                }
            }
        }
    }
    workgroupBarrier();

    if thread == 0u {
        draw_base = atomicAdd(&arguments.whole[hemisphere].index_count, 3u * atomicLoad(&draw_count));
        split_base = atomicAdd(&arguments.to_split[hemisphere], atomicLoad(&split_count));
    }
    workgroupBarrier();

    let part = 3u * view.list_capacity * hemisphere;
    for (var i = 0u; i < TRIANGLES_PER_THREAD; i += 1u) {
        if fates[i] == DRAW {
            write_entry(part + draw_base + 3u * places[i], entries[i]);
        } else if fates[i] == SPLIT {
            write_entry(part + 3u * (view.list_capacity - 1u - split_base - places[i]), entries[i]);
        }
    }
}

fn is_rejected(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, cull: f32) -> bool {
    return is_culled(a, b, c, cull) || (REJECT && is_between_texels(a, b, c));
}

fn write_entry(at: u32, entry: vec3<u32>) {
    lists[at] = entry.x;
    lists[at + 1u] = entry.y;
    lists[at + 2u] = entry.z;
}
