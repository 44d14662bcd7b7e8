// The casters' store as the stages read it; twin of the structs in src/casters.rs.

// A vertex in the mesh's space or the world's.
struct CasterVertex {
    position: vec3<f32>,
    // Of closed pieces the cone of the normals of all triangles around it: axis and sine, as four signed bytes; a sine
    // of 1 for none. Of masked casters the place of what the vertex has for the mask. Of other deforming ones its place
    // among the positions that the caller writes.
    data: u32,
}

// Where a chunk of an instance has its data.
struct ChunkSource {
    local_vertex: u32,
    vertex: u32,
    triangle: u32,
    // Vertices in bits 0-8, triangles in bits 9-17, culling in bits 18-19, kind in bits 20-21.
    counts: u32,
    // Bounds, in the mesh's space, of the closed pieces that the chunk has triangles of.
    pieces_min: vec3<f32>,
    // The first of its triangles among the mesh records.
    record: u32,
    pieces_max: vec3<f32>,
    // Cone of normals in the mesh's space: axis and sine, as four signed bytes; a sine of 1 for none.
    normals: u32,
}

// What the transform finds out about a chunk, in world space.
struct ChunkBounds {
    min: vec3<f32>,
    // -1 where the instance mirrors its mesh, else 1.
    handedness: f32,
    max: vec3<f32>,
    padding_0: u32,
    pieces_min: vec3<f32>,
    padding_1: u32,
    pieces_max: vec3<f32>,
    padding_2: u32,
    // Cone that holds the normals of the chunk's triangles and of their neighbours: its axis, and the sine of its angle;
    // 1 for none.
    normals_axis: vec3<f32>,
    normals_sine: f32,
    // For lookups: its first vertex, the first of its triangles among the mesh records, the number of the casters' update
    // that moved it, and its kind.
    place: vec4<u32>,
}

const CULL_CLOSED: u32 = 1u;
const CULL_ALWAYS: u32 = 2u;

// Bits of a chunk's kind, by which work items leave chunks out.
const KIND_MASKED: u32 = 2u;

// Whether all triangles around a vertex with a cone surely face away from a point.
fn all_face_away(vertex: CasterVertex, point: vec3<f32>) -> bool {
    let to_vertex = vertex.position - point;
    let cone = unpack4x8snorm(vertex.data);
    // The axis is a unit vector within a hundredth.
    return dot(to_vertex, cone.xyz) > 1.01 * cone.w * length(to_vertex);
}

// Whether everything in a chunk, and what shares a vertex with it, surely faces away from a point.
fn faces_away(bounds: ChunkBounds, point: vec3<f32>) -> bool {
    let to_centre = 0.5 * (bounds.min + bounds.max) - point;
    let radius = 0.5 * length(bounds.max - bounds.min);
    return dot(to_centre, bounds.normals_axis) > bounds.normals_sine * length(to_centre) + radius;
}

fn vertex_count(source: ChunkSource) -> u32 {
    return source.counts & 0x1ffu;
}

fn triangle_count(source: ChunkSource) -> u32 {
    return (source.counts >> 9u) & 0x1ffu;
}

fn culling(source: ChunkSource) -> u32 {
    return (source.counts >> 18u) & 3u;
}

fn kind(source: ChunkSource) -> u32 {
    return (source.counts >> 20u) & 3u;
}
