// Rest: positions are the mesh's own.

fn local_position(source: ChunkSource, vertex: CasterVertex) -> vec3<f32> {
    return vertex.position;
}
