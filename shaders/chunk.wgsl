// A chunk in a workgroup's memory: each vertex is projected once for all its triangles, and the rows of all triangles are
// shared out among the threads.

// Threads of a workgroup.
override THREADS: u32 = 256u;

// Corners of the chunk's triangles: in the map's space with w, and map coordinates.
var<workgroup> places: array<vec4<f32>, 256>;
var<workgroup> maps: array<vec2<f32>, 256>;
// Triangles whose rows are drawn: the number of the first row in bits 8-31, the place in the chunk in bits 0-7.
var<workgroup> queue: array<u32, 256>;
// Rows in bits 9-31, triangles in bits 0-8.
var<workgroup> queued: atomic<u32>;

// Puts the corners of a chunk where its triangles find them. `position` is that of the thread's vertex.
fn place_corners(view: View, source: ChunkSource, position: vec3<f32>, square: u32, thread: u32) {
    for (var v = thread; v < vertex_count(source); v += THREADS) {
        var own = position;
        if v != thread {
            own = vertices[source.vertex + v].position;
        }
        let corner = corner_of(view, own - view.position, square);
        places[v] = vec4<f32>(corner.place, corner.w);
        maps[v] = corner.map;
    }
}

fn placed(v: u32) -> Corner {
    return Corner(places[v].xyz, places[v].w, maps[v]);
}

fn placed_triangle(view: View, source: ChunkSource, local: vec3<u32>, square: u32) -> Triangle {
    let relative = array<vec3<f32>, 3>(
        vertices[source.vertex + local.x].position - view.position,
        vertices[source.vertex + local.y].position - view.position,
        vertices[source.vertex + local.z].position - view.position,
    );
    return triangle_of(view, square, relative, placed(local.x), placed(local.y), placed(local.z));
}

// Has `count` rows drawn of a chunk's triangle `t`.
fn enqueue(t: u32, count: u32) {
    let before = atomicAdd(&queued, (count << 9u) | 1u);
    queue[before & 0x1ffu] = ((before >> 9u) << 8u) | t;
}

// The queue's last triangle whose rows begin at `row` or before.
fn triangle_of_row(row: u32, count: u32) -> u32 {
    var low = 0u;
    var high = count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if (queue[middle] >> 8u) <= row {
            low = middle;
        } else {
            high = middle;
        }
    }
    return queue[low];
}

// Bits of the depths that the workspace has at four places.
fn stored_depths(at: vec4<u32>) -> vec4<u32> {
    return vec4<u32>(
        atomicLoad(&depths[at.x]),
        atomicLoad(&depths[at.y]),
        atomicLoad(&depths[at.z]),
        atomicLoad(&depths[at.w]),
    );
}
