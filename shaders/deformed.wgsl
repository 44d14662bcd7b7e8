// Deformed: positions are what the caller has written, in place of the mesh's own.

@group(0) @binding(6) var<storage, read> positions: array<f32>;
// Words before the first position, and from one to the next.
@group(0) @binding(7) var<uniform> spacing: vec2<u32>;

fn local_position(source: ChunkSource, vertex: CasterVertex) -> vec3<f32> {
    var place = vertex.data;
    if (kind(source) & KIND_MASKED) != 0u {
        place = dp_mask_vertex(place).source;
    }
    let at = spacing.x + place * spacing.y;
    return vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]);
}
