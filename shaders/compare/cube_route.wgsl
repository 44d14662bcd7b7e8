// Cube route: which triangles each face of a cube map has to draw; shaders/route.wgsl for six flat views. One
// workgroup takes one chunk after the other; a vertex is projected once for all its triangles.

// Twin of `RouteView` in src/compare/baselines/cube_routed.rs.
struct CubeView {
    // Rows of the rotation from world to light space.
    right: vec3<f32>,
    near: f32,
    up: vec3<f32>,
    range: f32,
    forward: vec3<f32>,
    // Half a face's width at distance 1 along its axis.
    half_width: f32,
    position: vec3<f32>,
    // Texels across a face.
    resolution: f32,
    first_chunk: u32,
    end_chunk: u32,
    // Triangles that a face's part of the lists has room for.
    list_capacity: u32,
    padding: u32,
}

// Arguments of a face's indirect draw, and its counter.
struct DrawIndexed {
    index_count: atomic<u32>,
    instance_count: u32,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
}

@group(0) @binding(0) var<uniform> view: CubeView;
@group(0) @binding(1) var<storage, read_write> arguments: array<DrawIndexed, 6>;
@group(0) @binding(2) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(3) var<storage, read> chunk_bounds: array<ChunkBounds>;
@group(0) @binding(4) var<storage, read> triangles: array<u32>;
@group(0) @binding(5) var<storage, read> vertices: array<CasterVertex>;
// A part for each face.
@group(0) @binding(6) var<storage, read_write> lists: array<u32>;

const THREADS: u32 = 128u;
const TRIANGLES_PER_THREAD: u32 = 2u;

const DROP: u32 = 0u;
const DRAW: u32 = 1u;

// Bits of an outcode: beyond a border of the face, and nearer than the near plane.
const OUT_RIGHT: u32 = 1u;
const OUT_LEFT: u32 = 2u;
const OUT_TOP: u32 = 4u;
const OUT_BOTTOM: u32 = 8u;
const OUT_NEAR: u32 = 16u;
// All triangles around the vertex face away.
const ALL_AWAY: u32 = 256u;

// A vertex in a face's texels, and its outcode.
var<workgroup> corners: array<vec2<f32>, 256>;
var<workgroup> outcodes: array<u32, 256>;
var<workgroup> draw_count: atomic<u32>;
var<workgroup> draw_base: u32;

@compute @workgroup_size(128)
fn cube_route(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var chunk = view.first_chunk + group.x; chunk < view.end_chunk; chunk += groups.x) {
        let dropped = culling_rule(chunk) != 0u && faces_away(chunk_bounds[chunk], view.position);
        let faces = select(faces_of(chunk), 0u, dropped);
        for (var face = 0u; face < 6u; face += 1u) {
            if (faces & (1u << face)) != 0u {
                route_chunk(chunk, face, thread);
            }
        }
    }
}

// A vector of world space in light space.
fn to_light(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(view.right, v), dot(view.up, v), dot(view.forward, v));
}

// Half the extent in light space of a box with half the extent `v` in the world.
fn extent_to_light(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(abs(view.right), v), dot(abs(view.up), v), dot(abs(view.forward), v));
}

// A vector of light space by a face's axes: right, up, forward.
fn to_face(v: vec3<f32>, face: u32) -> vec3<f32> {
    let s = select(1.0, -1.0, (face & 1u) != 0u);
    if face < 2u {
        return vec3<f32>(-s * v.z, v.y, s * v.x);
    }
    if face < 4u {
        return vec3<f32>(v.x, -s * v.z, s * v.y);
    }
    return vec3<f32>(s * v.x, v.y, s * v.z);
}

// The faces whose frustum the chunk may touch, as bits; none if it is unused or out of range.
fn faces_of(chunk: u32) -> u32 {
    if triangle_count(chunk_sources[chunk]) == 0u {
        return 0u;
    }
    let low = chunk_bounds[chunk].min - view.position;
    let high = chunk_bounds[chunk].max - view.position;
    let nearest = max(max(low, -high), vec3<f32>(0.0));
    if dot(nearest, nearest) > view.range * view.range {
        return 0u;
    }
    let box_centre = to_light(0.5 * (low + high));
    let box_extent = extent_to_light(0.5 * (high - low));
    let slack = 1e-5 * (length(box_centre) + length(box_extent));
    var faces = 0u;
    for (var face = 0u; face < 6u; face += 1u) {
        let centre = to_face(box_centre, face);
        let extent = abs(to_face(box_extent, face));
        // How far the box reaches, and how far a border is from the axis at that depth at most.
        let depth = centre.z + extent.z + slack;
        let aside = abs(centre.xy) - extent.xy - slack;
        let seen = depth >= view.near && max(aside.x, aside.y) <= view.half_width * depth;
        faces |= select(0u, 1u << face, seen);
    }
    return faces;
}

// What is done with triangles that face away: CULL_CLOSED, CULL_ALWAYS or 0.
fn culling_rule(chunk: u32) -> u32 {
    let rule = culling(chunk_sources[chunk]);
    if rule != CULL_CLOSED {
        return rule;
    }
    // Outside by more than near, nothing of a closed piece is clipped, so a front face hides every back face.
    let outside = any(view.position < chunk_bounds[chunk].pieces_min - view.near)
        || any(view.position > chunk_bounds[chunk].pieces_max + view.near);
    return select(0u, CULL_CLOSED, outside);
}

fn route_chunk(chunk: u32, face: u32, thread: u32) {
    let source = chunk_sources[chunk];
    if thread == 0u {
        atomicStore(&draw_count, 0u);
    }
    for (var v = thread; v < vertex_count(source); v += THREADS) {
        let vertex = vertices[source.vertex + v];
        let x = to_face(to_light(vertex.position - view.position), face);
        corners[v] = (x.xy / (view.half_width * x.z) + 1.0) * (0.5 * view.resolution) - 0.5;
        outcodes[v] = outcode(x) | select(0u, ALL_AWAY, all_face_away(vertex, view.position));
    }
    workgroupBarrier();

    let rule = culling_rule(chunk);
    // A face turned to the light is clockwise in the map: its view is mirrored.
    let cull = select(0.0, chunk_bounds[chunk].handedness, rule != 0u);
    var fates: array<u32, TRIANGLES_PER_THREAD>;
    var places: array<u32, TRIANGLES_PER_THREAD>;
    for (var i = 0u; i < TRIANGLES_PER_THREAD; i += 1u) {
        let t = thread + i * THREADS;
        fates[i] = DROP;
        if t < triangle_count(source) {
            fates[i] = fate_of(corners_of(triangles[source.triangle + t]), rule, cull);
        }
        if fates[i] == DRAW {
            places[i] = atomicAdd(&draw_count, 1u);
        }
    }
    workgroupBarrier();

    if thread == 0u {
        draw_base = atomicAdd(&arguments[face].index_count, 3u * atomicLoad(&draw_count));
    }
    workgroupBarrier();

    let part = 3u * view.list_capacity * face + draw_base;
    for (var i = 0u; i < TRIANGLES_PER_THREAD; i += 1u) {
        if fates[i] == DRAW {
            let local = corners_of(triangles[source.triangle + thread + i * THREADS]);
            write_entry(part + 3u * places[i], local + source.vertex);
        }
    }
}

// `x` by a face's axes.
fn outcode(x: vec3<f32>) -> u32 {
    let border = view.half_width * x.z;
    return select(0u, OUT_RIGHT, x.x > border)
        | select(0u, OUT_LEFT, x.x < -border)
        | select(0u, OUT_TOP, x.y > border)
        | select(0u, OUT_BOTTOM, x.y < -border)
        | select(0u, OUT_NEAR, x.z < view.near);
}

// Places of a triangle's corners in its chunk.
fn corners_of(packed: u32) -> vec3<u32> {
    return vec3<u32>(packed, packed >> 8u, packed >> 16u) & vec3<u32>(0xffu);
}

// What becomes of a triangle. `cull` is the sign of the map area of triangles that face away, 0 if that doesn't
// matter.
fn fate_of(local: vec3<u32>, rule: u32, cull: f32) -> u32 {
    let code = vec3<u32>(outcodes[local.x], outcodes[local.y], outcodes[local.z]);
    if (code.x & code.y & code.z & ~ALL_AWAY) != 0u {
        return DROP;
    }
    if ((code.x | code.y | code.z) & OUT_NEAR) != 0u {
        // The near plane cuts it, so where its corners would be drawn says little.
        return DRAW;
    }
    let a = corners[local.x];
    let b = corners[local.y];
    let c = corners[local.z];
    // Where front and back faces meet, the back faces of closed pieces are kept.
    let hidden = rule == CULL_ALWAYS || (code.x & code.y & code.z & ALL_AWAY) != 0u;
    if hidden && is_culled(a, b, c, cull) {
        return DROP;
    }
    return select(DRAW, DROP, is_between_texels(a, b, c));
}

// Room for the rasteriser's snapping to 1/256 texel, for its arithmetic, and for ours, at `farthest` texels from the
// face's corner.
fn raster_margin(farthest: f32) -> f32 {
    return 0.0078125 + max(farthest, view.resolution) * 1e-6;
}

// Whether the drawn triangle covers no texel's centre.
fn is_between_texels(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>) -> bool {
    let low = min(a, min(b, c));
    let high = max(a, max(b, c));
    let farthest = max(abs(low), abs(high));
    let margin = raster_margin(max(farthest.x, farthest.y));
    let first = max(ceil(low - margin), vec2<f32>(0.0));
    let last = min(floor(high + margin), vec2<f32>(view.resolution - 1.0));
    return last.x < first.x || last.y < first.y;
}

// Whether the drawn triangle surely has the culled orientation; `cull` is the area's sign that doesn't cast.
fn is_culled(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, cull: f32) -> bool {
    let e = b - a;
    let f = c - a;
    let g = f - e;
    let area = e.x * f.y - e.y * f.x;
    let longest = sqrt(max(dot(e, e), max(dot(f, f), dot(g, g))));
    let farthest = max(max(abs(a.x), abs(a.y)), max(max(abs(b.x), abs(b.y)), max(abs(c.x), abs(c.y))));
    return area * cull > longest * raster_margin(farthest) * 2.0;
}

fn write_entry(at: u32, entry: vec3<u32>) {
    lists[at] = entry.x;
    lists[at + 1u] = entry.y;
    lists[at + 2u] = entry.z;
}
