// Transform: the chunks of moved instances, from their meshes' space to world space, with their bounds.
// One workgroup a chunk. `local_position` is that of rest.wgsl or of deformed.wgsl.

@group(0) @binding(0) var<storage, read> local_vertices: array<CasterVertex>;
@group(0) @binding(1) var<storage, read_write> vertices: array<CasterVertex>;
@group(0) @binding(2) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(3) var<storage, read_write> chunk_bounds: array<ChunkBounds>;
// Three rows a matrix.
@group(0) @binding(4) var<storage, read> transforms: array<vec4<f32>>;
// The number of the casters' update, then for each job a chunk and the number of its matrix.
@group(0) @binding(5) var<storage, read> jobs: array<vec2<u32>>;

const THREADS: u32 = 64u;
// By how much a cone has to be wider when its axis is rounded to 1/127ths, and its sine too.
const PACKING: f32 = 0.012;

var<workgroup> lowest: array<vec3<f32>, THREADS>;
var<workgroup> highest: array<vec3<f32>, THREADS>;

@compute @workgroup_size(64)
fn transform(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var job = group.x + 1u; job < arrayLength(&jobs); job += groups.x) {
        transform_chunk(jobs[job].x, jobs[job].y, thread);
        workgroupBarrier();
    }
}

fn transform_chunk(chunk: u32, matrix: u32, thread: u32) {
    let source = chunk_sources[chunk];
    let row_x = transforms[3u * matrix];
    let row_y = transforms[3u * matrix + 1u];
    let row_z = transforms[3u * matrix + 2u];
    var low = vec3<f32>(3.4e38);
    var high = vec3<f32>(-3.4e38);
    for (var v = thread; v < vertex_count(source); v += THREADS) {
        let vertex = local_vertices[source.local_vertex + v];
        let local = vec4<f32>(local_position(source, vertex), 1.0);
        let world = vec3<f32>(dot(row_x, local), dot(row_y, local), dot(row_z, local));
        let cone = cone_in_world(vertex.data, row_x.xyz, row_y.xyz, row_z.xyz);
        let packed = pack4x8snorm(cone + vec4<f32>(0.0, 0.0, 0.0, PACKING));
        vertices[source.vertex + v] = CasterVertex(world, select(vertex.data, packed, culling(source) == CULL_CLOSED));
        low = min(low, world);
        high = max(high, world);
    }
    lowest[thread] = low;
    highest[thread] = high;
    workgroupBarrier();
    for (var half = THREADS / 2u; half > 0u; half /= 2u) {
        if thread < half {
            lowest[thread] = min(lowest[thread], lowest[thread + half]);
            highest[thread] = max(highest[thread], highest[thread + half]);
        }
        workgroupBarrier();
    }
    if thread == 0u {
        let centre = vec4<f32>((source.pieces_min + source.pieces_max) * 0.5, 1.0);
        let extent = (source.pieces_max - source.pieces_min) * 0.5;
        let middle = vec3<f32>(dot(row_x, centre), dot(row_y, centre), dot(row_z, centre));
        let reach = vec3<f32>(
            dot(abs(row_x.xyz), extent),
            dot(abs(row_y.xyz), extent),
            dot(abs(row_z.xyz), extent),
        );
        // Wider than exact, since the box of the pieces is transformed and not the pieces.
        let slack = 1e-5 * (abs(middle) + reach);
        let normals = cone_in_world(source.normals, row_x.xyz, row_y.xyz, row_z.xyz);
        chunk_bounds[chunk] = ChunkBounds(
            lowest[0],
            sign(dot(row_x.xyz, cross(row_y.xyz, row_z.xyz))),
            highest[0],
            0u,
            middle - reach - slack,
            0u,
            middle + reach + slack,
            0u,
            normals.xyz,
            normals.w,
            vec4<u32>(source.vertex, source.record, jobs[0].x, kind(source)),
        );
    }
}

// Axis and sine of a cone of normals. None for transforms that change angles, since the cone isn't one then.
fn cone_in_world(normals: u32, row_x: vec3<f32>, row_y: vec3<f32>, row_z: vec3<f32>) -> vec4<f32> {
    let cone = unpack4x8snorm(normals);
    let squares = vec3<f32>(dot(row_x, row_x), dot(row_y, row_y), dot(row_z, row_z));
    let products = abs(vec3<f32>(dot(row_x, row_y), dot(row_y, row_z), dot(row_z, row_x)));
    let unequal = max(abs(squares.x - squares.y), abs(squares.y - squares.z));
    let keeps_angles = max(unequal, max(products.x, max(products.y, products.z))) <= 1e-3 * squares.x;
    let axis = vec3<f32>(dot(row_x, cone.xyz), dot(row_y, cone.xyz), dot(row_z, cone.xyz));
    let size = length(axis);
    let known = keeps_angles && size > 0.0;
    return select(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec4<f32>(axis / size, cone.w), known);
}
