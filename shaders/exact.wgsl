// Exact: triangles whose pieces found no room, drawn without splitting. A triangle seen from the light is a
// cone of three planes and its depth a quadratic, so each texel can be asked directly; slow, and right.

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> lists: array<u32>;
@group(0) @binding(2) var<storage, read> vertices: array<CasterVertex>;

override HEMISPHERE: u32 = 0u;

struct Vertex {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) a: vec3<f32>,
    @location(1) @interpolate(flat, either) b: vec3<f32>,
    @location(2) @interpolate(flat, either) c: vec3<f32>,
    // Where it stands in the lists.
    @location(3) @interpolate(flat, either) place: u32,
}

@vertex
fn exact_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) place: u32) -> Vertex {
    let at = 3u * (list_start(HEMISPHERE) + view.list_capacity - 1u - place);
    var result: Vertex;
    result.place = at;
    result.a = hemisphere_position(lists[at]);
    result.b = hemisphere_position(lists[at + 1u]);
    result.c = hemisphere_position(lists[at + 2u]);
    let corner = vec2<f32>(f32(vertex & 1u), f32(vertex >> 1u));
    let bounds = map_bounds(dp_project(result.a), dp_project(result.b), dp_project(result.c));
    // Nothing for a triangle whose pieces all had room.
    let covers = (lists[at] & OVERFLOW_FLAG) != 0u;
    result.position = select(vec4<f32>(), vec4<f32>(mix(bounds.xy, bounds.zw, corner), 0.5, 1.0), covers);
    return result;
}

// Least and greatest x and y of normalised device coordinates that a triangle may cover.
fn map_bounds(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>) -> vec4<f32> {
    let farthest = max(dot(a, a), max(dot(b, b), dot(c, c)));
    if farthest > 1.4 {
        // It may lie around the axis behind, and cover everything outside of its arcs.
        return vec4<f32>(-1.0, -1.0, 1.0, 1.0);
    }
    // An arc of less than half a circle is within half its chord of it.
    let reach = 0.5 * max(distance(a, b), max(distance(b, c), distance(c, a))) + 2.0 / view.texels;
    let scale = 2.0 * view.texels / view.resolution;
    let low = (min(a, min(b, c)) - reach) * scale;
    let high = (max(a, max(b, c)) + reach) * scale;
    return clamp(vec4<f32>(low, high), vec4<f32>(-1.0), vec4<f32>(1.0));
}

fn hemisphere_position(entry: u32) -> vec3<f32> {
    let relative = vertices[entry & VERTEX_MASK].position - view.position;
    return hemisphere_space(relative, HEMISPHERE);
}

@fragment
fn exact_fragment(vertex: Vertex) -> @builtin(frag_depth) f32 {
    let texel = exact_texel(vertex);
    if !texel.covered {
        discard;
    }
    return texel.depth;
}

@fragment
fn exact_masked_fragment(vertex: Vertex) -> @builtin(frag_depth) f32 {
    let texel = exact_texel(vertex);
    let a = mask_vertices[vertices[lists[vertex.place] & VERTEX_MASK].data];
    let b = mask_vertices[vertices[lists[vertex.place + 1u] & VERTEX_MASK].data];
    let c = mask_vertices[vertices[lists[vertex.place + 2u] & VERTEX_MASK].data];
    let weights = barycentrics(vertex.a, vertex.b, vertex.c, texel.point);
    if !texel.covered || is_hole(masks[a.mask], weighted_coordinates(a, b, c, weights)) {
        discard;
    }
    return texel.depth;
}

// What a triangle is at a texel's centre.
struct ExactTexel {
    covered: bool,
    depth: f32,
    // Of its plane, in hemisphere space.
    point: vec3<f32>,
}

fn exact_texel(vertex: Vertex) -> ExactTexel {
    let centre = vec2<f32>((f32(HEMISPHERE) + 0.5) * view.resolution, 0.5 * view.resolution);
    let p = (vertex.position.xy - centre) * vec2<f32>(1.0, -1.0) / view.texels;
    let q = dp_unproject_scaled(p);
    let normal = plane_normal(vertex.a, vertex.b, vertex.c);
    let plane_distance = dot(normal, vertex.a);
    // Neighbours may be drawn by chords, so the edges reach as far out as a chord may miss. Out there the depth is the plane's
    // or the edge's, whichever is farther: planes seen edge-on would stand before their neighbours.
    let reach = length(q) * dp_texel_angle(p, 1.0 / view.texels) * OUTLINE_SHARE * view.tolerance;
    let turn = sign(plane_distance);
    let ab = turn * edge_normal(vertex.a, vertex.b);
    let bc = turn * edge_normal(vertex.b, vertex.c);
    let ca = turn * edge_normal(vertex.c, vertex.a);
    let inside = dot(ab, q) >= -reach && dot(bc, q) >= -reach && dot(ca, q) >= -reach;
    var within = q - min(dot(ab, q), 0.0) * ab;
    within -= min(dot(bc, within), 0.0) * bc;
    within -= min(dot(ca, within), 0.0) * ca;
    let point = within * (plane_distance / dot(normal, within));
    let depth = min(dp_depth(point, view.near), dp_plane_depth(normal, plane_distance, p, view.near));
    return ExactTexel(inside && depth > 0.0 && depth <= 1.0, depth, point);
}

// Unit normal of the plane through the light and an edge.
fn edge_normal(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return normalize(cross(a, b - a));
}

// Normal of a triangle, as long as twice its area: from its two shorter edges, since the longer ones of a thin triangle are
// parallel but for rounding.
fn plane_normal(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let e = b - a;
    let f = c - b;
    let g = a - c;
    let squares = vec3<f32>(dot(e, e), dot(f, f), dot(g, g));
    if squares.x >= max(squares.y, squares.z) {
        return cross(f, g);
    }
    return cross(e, select(f, -g, squares.y >= squares.z));
}
