// Exact edges: where the texels around a receiver disagree, their triangles are asked. Twin of src/compare/walk/twins.rs.
//
// From the triangle under a texel's centre the walk crosses edge after edge of its mesh towards the receiver's direction,
// until a triangle has the ray inside it or the surface ends. A triangle that has it and stands before the receiver
// shadows it for certain; the receiver's own surface, and nothing else, says that it is lit. What walks can't tell the
// votes decide. None of this depends on the projection of the maps; sharp.wgsl has what is the pair's.

// Triangles beyond the first that a walk looks at.
const DP_WALK_STEPS: u32 = 16u;
// How far in front of the receiver a triangle has to stand to be in the way for certain, in footprints, and once more times
// the grazing factor.
const DP_WALK_OVER: f32 = 0.003;
const DP_WALK_OVER_GRAZING: f32 = 1e-4;
// What single precision loses: by so much of its coordinates a point may be off, and a third of what the arithmetic loses
// of its distance.
const DP_WALK_ROUNDING: f32 = 1.2e-7;
// Up to so many footprints times the grazing factor before or behind the receiver's plane a texel holds the receiver's own
// surface for certain. The votes' bias would let light in under contacts.
const DP_WALK_FLAT: f32 = 0.02;
// How far behind the receiver a triangle may lie to be of its own surface, in footprints, and once more times the grazing
// factor.
const DP_WALK_OWN: f32 = 0.02;
const DP_WALK_OWN_GRAZING: f32 = 0.05;
// Points of a pixel that are asked, in its steps, on a hexagon: every other one, which no edge through the pixel's middle
// goes past, and the rest where those differ.
const DP_PIXEL_POINTS: array<vec2<f32>, 6> = array<vec2<f32>, 6>(
    vec2<f32>(0.406, 0.109), vec2<f32>(-0.297, 0.297), vec2<f32>(-0.109, -0.406),
    vec2<f32>(-0.406, -0.109), vec2<f32>(0.297, -0.297), vec2<f32>(0.109, 0.406),
);

const DP_NO_TRIANGLE: u32 = 0xffffffffu;
// Beyond an edge: the surface's end. See src/neighbours.rs.
const DP_NOTHING: u32 = 3u;
// Bit of a chunk's kind: its mesh has holes.
const DP_MASKED: u32 = 2u;

// `ChunkBounds` of shaders/casters.wgsl, of which lookups read the last part.
struct DpChunk {
    bounds: array<vec4<f32>, 5>,
    // Its first vertex, the first of its triangles among the mesh records, the number of the casters' update that moved it, 0
    // if it is gone, and its kind.
    place: vec4<u32>,
}

@group(DP_CASTERS_GROUP) @binding(0) var<storage, read> dp_chunks: array<DpChunk>;
// Of triangles the corners as places among the chunk's vertices (bits 0-7, 8-15, 16-23) and what lies beyond the edge from
// each corner to the next one: bits 0-1 the edge's number in the neighbour, bit 2 whether the neighbour is wound the other
// way, bits 3-10 its place in its chunk, bits 11-31 its chunk less the triangle's own. Of masks see mask.wgsl.
@group(DP_CASTERS_GROUP) @binding(1) var<storage, read> dp_meshes: array<vec4<u32>>;
// Positions in world space, and a word more.
@group(DP_CASTERS_GROUP) @binding(2) var<storage, read> dp_vertices: array<vec4<f32>>;

// All that is read of them. A test counts the indices that are out of range here.
fn dp_chunk(chunk: u32) -> vec4<u32> {
    return dp_chunks[chunk].place;
}

fn dp_mesh_record(place: u32) -> vec4<u32> {
    return dp_meshes[place];
}

fn dp_vertex(vertex: u32) -> vec4<f32> {
    return dp_vertices[vertex];
}

// The ray from the light to a receiver as the third of three axes (Duff et al., "Building an Orthonormal Basis, Revisited",
// JCGT 2017). Seen along it a walk is one in the plane, with the receiver at the origin; what rounding loses is 1e-7 rad,
// however small a triangle is.
struct DpWalkFrame {
    light: vec3<f32>,
    ray: vec3<f32>,
    s: f32,
    a: f32,
}

fn dp_walk_frame(light: vec3<f32>, ray: vec3<f32>) -> DpWalkFrame {
    let s = select(-1.0, 1.0, ray.z >= 0.0);
    return DpWalkFrame(light, ray, s, -1.0 / (s + ray.z));
}

// A vertex by these axes.
fn dp_walk_see(frame: DpWalkFrame, vertex: u32) -> vec3<f32> {
    let p = dp_vertex(vertex).xyz - frame.light;
    let h = dot(p.xy, frame.ray.xy);
    let k = frame.a * h - p.z;
    return vec3<f32>(p.x + frame.s * frame.ray.x * k, frame.s * p.y + frame.ray.y * k, h + frame.ray.z * p.z);
}

// On which side of the plane through the light and the edge from `a` to `b` the ray runs: (a x b).ray.
fn dp_walk_side(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// How far beside the edge the ray runs.
fn dp_walk_beside(side: f32, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let ab = b.xy - a.xy;
    return side * inverseSqrt(max(dot(ab, ab), 1e-30));
}

// How a walk ends: the distance from the light at which a triangle crosses the ray, or one of these. The surface ends before
// the ray, or has a hole there.
const DP_WALK_OFF: f32 = 0.0;
// There is no answer.
const DP_WALK_LOST: f32 = -1.0;

// A triangle as a walk reads it: its record, and its chunk's first vertex and kind.
struct DpWalked {
    record: vec4<u32>,
    vertex: u32,
    kind: u32,
}

fn dp_walk_triangle(place: vec4<u32>, triangle: u32) -> DpWalked {
    return DpWalked(dp_mesh_record(place.y + (triangle & 0xffu)), place.x, place.w);
}

// Number of a triangle's vertex at corner `k`, from 0 to 2.
fn dp_walk_vertex(triangle: DpWalked, k: u32) -> u32 {
    return triangle.vertex + ((triangle.record.x >> (8u * k)) & 0xffu);
}

// What lies beyond the edge `k`.
fn dp_walk_beyond(triangle: DpWalked, k: u32) -> u32 {
    return select(select(triangle.record.w, triangle.record.z, k == 1u), triangle.record.y, k == 0u);
}

// `k + by` among the numbers 0, 1 and 2.
fn dp_walk_turn(k: u32, by: u32) -> u32 {
    let sum = k + by;
    return select(sum, sum - 3u, sum >= 3u);
}

// In the triangle that the ray is inside of: by its volume with the light, its vertices, and the sides of the edges opposite
// to them.
fn dp_walk_end(kind: u32, volume: f32, vertices: vec3<u32>, sides: vec3<f32>) -> f32 {
    let sum = sides.x + sides.y + sides.z;
    if !(volume > 0.0 && sum > 0.0) {
        return DP_WALK_OFF;
    }
    if (kind & DP_MASKED) != 0u {
        let a = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.x).w));
        let b = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.y).w));
        let c = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.z).w));
        if dp_is_hole(a, b, c, sides * (1.0 / sum)) {
            return DP_WALK_OFF;
        }
    }
    return volume / sum;
}

// Walks from a triangle over its neighbours towards the ray. Casters that have changed since the map was made aren't those it
// shows.
fn dp_walk_from(number: u32, made: u32, frame: DpWalkFrame) -> f32 {
    var chunk = number >> 8u;
    if chunk >= arrayLength(&dp_chunks) {
        return DP_WALK_LOST;
    }
    var place = dp_chunk(chunk);
    if place.z == 0u || place.z > made {
        return DP_WALK_LOST;
    }
    var triangle = dp_walk_triangle(place, number);
    let vertices = vec3<u32>(dp_walk_vertex(triangle, 0u), dp_walk_vertex(triangle, 1u), dp_walk_vertex(triangle, 2u));
    let a = dp_walk_see(frame, vertices.x);
    let b = dp_walk_see(frame, vertices.y);
    let c = dp_walk_see(frame, vertices.z);
    var sides = vec3<f32>(dp_walk_side(a, b), dp_walk_side(b, c), dp_walk_side(c, a));
    let start_volume = a.z * sides.y + b.z * sides.z + c.z * sides.x;
    // Walks go as if the triangle's front faced away from the light.
    var turned = start_volume < 0.0;
    sides = select(sides, -sides, turned);
    if min(sides.x, min(sides.y, sides.z)) >= 0.0 {
        return dp_walk_end(triangle.kind, abs(start_volume), vertices, sides.yzx);
    }
    let beside = vec3<f32>(
        dp_walk_beside(sides.x, a, b),
        dp_walk_beside(sides.y, b, c),
        dp_walk_beside(sides.z, c, a),
    );
    // The edge from p to q is crossed: the ray runs so far on its other side.
    var edge = 0u;
    var p = a;
    var q = b;
    var p_vertex = vertices.x;
    var q_vertex = vertices.y;
    var crossed = -sides.x;
    if beside.y < beside.x {
        edge = 1u;
        p = b;
        q = c;
        p_vertex = vertices.y;
        q_vertex = vertices.z;
        crossed = -sides.y;
    }
    if beside.z < min(beside.x, beside.y) {
        edge = 2u;
        p = c;
        q = a;
        p_vertex = vertices.z;
        q_vertex = vertices.x;
        crossed = -sides.z;
    }
    if turned {
        let end = q;
        q = p;
        p = end;
        let end_vertex = q_vertex;
        q_vertex = p_vertex;
        p_vertex = end_vertex;
    }
    var beyond = dp_walk_beyond(triangle, edge);
    for (var step = 0u; step < DP_WALK_STEPS; step++) {
        if (beyond & 3u) == 3u {
            break;
        }
        let chunks = bitcast<i32>(beyond) >> 11u;
        if chunks != 0 {
            chunk = u32(i32(chunk) + chunks);
            place = dp_chunk(chunk);
        }
        triangle = dp_walk_triangle(place, beyond >> 3u);
        let entered = beyond & 3u;
        turned = turned != ((beyond & 4u) != 0u);
        let one = dp_walk_vertex(triangle, entered);
        let other = dp_walk_vertex(triangle, dp_walk_turn(entered, 1u));
        let p_here = select(other, one, turned);
        let q_here = select(one, other, turned);
        // Another chunk's, or where a deforming mesh may have come apart.
        if p_here != p_vertex || q_here != q_vertex {
            p_vertex = p_here;
            q_vertex = q_here;
            p = dp_walk_see(frame, p_here);
            q = dp_walk_see(frame, q_here);
            crossed = dp_walk_side(q, p);
        }
        let n_vertex = dp_walk_vertex(triangle, dp_walk_turn(entered, 2u));
        let n = dp_walk_see(frame, n_vertex);
        let pn = dp_walk_side(p, n);
        let nq = dp_walk_side(n, q);
        let volume = q.z * pn + p.z * nq + n.z * crossed;
        // It faces the other way: what is behind it the first texel didn't see.
        if volume < 0.0 {
            return DP_WALK_OFF;
        }
        if min(pn, nq) >= 0.0 {
            if crossed < 0.0 {
                return DP_WALK_OFF;
            }
            return dp_walk_end(triangle.kind, volume, vec3<u32>(q_vertex, p_vertex, n_vertex), vec3<f32>(pn, nq, crossed));
        }
        let over_pn = dp_walk_beside(pn, p, n) < dp_walk_beside(nq, n, q);
        beyond = dp_walk_beyond(triangle, dp_walk_turn(entered, select(1u, 2u, over_pn == turned)));
        if over_pn {
            q = n;
            q_vertex = n_vertex;
            crossed = -pn;
        } else {
            p = n;
            p_vertex = n_vertex;
            crossed = -nq;
        }
    }
    return select(DP_WALK_LOST, DP_WALK_OFF, beyond == DP_NOTHING);
}

// What is known of a receiver whose texels disagree.
struct DpWalkQuad {
    // DP_NO_TRIANGLE where there is nothing to ask: no triangle, or the receiver's own surface.
    triangles: vec4<u32>,
    // The one to begin with: that of the texel in which most stands before the receiver.
    lead: u32,
    // A bit a texel: votes against, and votes that would do for a surface that is the receiver's own.
    dark: u32,
    level: u32,
    // Whether a texel holds the receiver's own surface.
    own_seen: bool,
    // Whether a texel that votes against has no triangle to ask.
    lost: bool,
    // Bounds of (receiver's distance / surface's distance - 1).
    over: f32,
    own: f32,
    // What is nearer than this to the light isn't in the map.
    nearest: f32,
    // Number of the casters' update that the map shows.
    made: u32,
    votes: f32,
}

// What four texels decide, or what it takes to go on.
struct DpWalkFirst {
    mixed: bool,
    value: f32,
    grazing: f32,
    quad: DpWalkQuad,
}

fn dp_walk_bits(which: vec4<bool>) -> u32 {
    return dot(select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), which), vec4<u32>(1u));
}

// What margins a receiver has, over its distance where nothing else is said.
struct DpWalkMargins {
    footprint: f32,
    grazing: f32,
    // What single precision loses, and how far the receiver may lie off the casters' surface, along the ray.
    rounding: f32,
    // Up to so far before or behind the receiver's plane a texel holds its own surface for certain.
    flat_bound: f32,
}

fn dp_walk_margins(light: u32, position: vec3<f32>, receiver: DpReceiver, footprint: f32) -> DpWalkMargins {
    let grazing = dp_grazing(receiver);
    let coordinates = max(abs(position), abs(dp_lights[light].position));
    let farthest = max(coordinates.x, max(coordinates.y, coordinates.z));
    let rounding =
        DP_WALK_ROUNDING * grazing * (3.0 + farthest / receiver.distance) + dp_offset(light, receiver, grazing);
    return DpWalkMargins(footprint, grazing, rounding, DP_WALK_FLAT * grazing * footprint + rounding);
}

// What is known of a receiver by four texels, whose plane has these depths there.
fn dp_walk_quad(
    light: u32,
    receiver: DpReceiver,
    stored: vec4<f32>,
    depths: vec4<f32>,
    weights: vec4<f32>,
    triangles: vec4<u32>,
    judge: DpJudge,
    margins_at: DpWalkMargins,
) -> DpWalkQuad {
    var quad: DpWalkQuad;
    let margins = dp_margins(stored, depths, margins_at.footprint);
    let votes = dp_votes(judge, margins);
    let most = max(max(margins.x, margins.y), max(margins.z, margins.w));
    let low = select(triangles.x, triangles.y, margins.y == most);
    let dark = margins > vec4<f32>(judge.bias);
    let level = !dark & (abs(margins) < vec4<f32>(DP_WALK_OWN_GRAZING * margins_at.grazing));
    let own = abs(margins) <= vec4<f32>(margins_at.flat_bound / margins_at.footprint);
    // Of the caller's own casters.
    let unnumbered = (triangles == vec4<u32>(DP_NO_TRIANGLE)) & (stored > vec4<f32>(0.0));
    quad.lead = select(select(low, triangles.z, margins.z == most), triangles.w, margins.w == most);
    quad.dark = dp_walk_bits(dark);
    quad.level = dp_walk_bits(level);
    quad.own_seen = any(own | (unnumbered & level));
    quad.lost = any(unnumbered & dark);
    quad.triangles = select(triangles, vec4<u32>(DP_NO_TRIANGLE), own);
    quad.over = (DP_WALK_OVER + DP_WALK_OVER_GRAZING * margins_at.grazing) * margins_at.footprint + margins_at.rounding;
    quad.own = -(DP_WALK_OWN + DP_WALK_OWN_GRAZING * margins_at.grazing) * margins_at.footprint
        - dp_offset(light, receiver, margins_at.grazing);
    quad.nearest = dp_lights[light].near * receiver.distance / receiver.w;
    quad.made = dp_lights[light].made;
    quad.votes = dp_count(dot(weights, votes.lit), dot(weights, votes.dark));
    return quad;
}

fn dp_walk_least(triangles: vec4<u32>) -> u32 {
    return min(min(triangles.x, triangles.y), min(triangles.z, triangles.w));
}

// 1 or 0 for certain, or the votes, at a point that may lie so far off the receiver's surface.
fn dp_walk_decide(light: vec3<f32>, position: vec3<f32>, quad: DpWalkQuad, off: f32) -> f32 {
    let relative = position - light;
    let distance = length(relative);
    let frame = dp_walk_frame(light, relative * (1.0 / distance));
    var own = quad.own_seen;
    var lost = quad.lost;
    // Each triangle once: first the leading one, then in the order of their numbers, of which DP_NO_TRIANGLE is the last.
    var rest = quad.triangles;
    var triangle = select(quad.lead, dp_walk_least(rest), quad.lead == DP_NO_TRIANGLE);
    while triangle != DP_NO_TRIANGLE {
        rest = select(rest, vec4<u32>(DP_NO_TRIANGLE), rest == vec4<u32>(triangle));
        let end = dp_walk_from(triangle, quad.made, frame);
        if end > 0.0 && end >= quad.nearest {
            let margin = distance / end - 1.0;
            if margin > quad.over + off / distance {
                return 0.0;
            }
            own = own || margin > quad.own;
        } else if end < 0.0 {
            let here = dp_walk_bits(quad.triangles == vec4<u32>(triangle));
            lost = lost || (here & quad.dark) != 0u;
            own = own || (here & quad.level) != 0u;
        }
        triangle = dp_walk_least(rest);
    }
    return select(quad.votes, 1.0, own && !lost);
}

// What a receiver's triangles answer over a pixel, of whose points none is asked for farther away than `most`.
fn dp_walk_pixel(
    light: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    pixel: mat2x3<f32>,
    first: DpWalkFirst,
    most: f32,
) -> f32 {
    let centre = dp_lights[light].position;
    if all(pixel[0] == vec3<f32>(0.0)) && all(pixel[1] == vec3<f32>(0.0)) {
        return dp_walk_decide(centre, position, first.quad, 0.0);
    }
    let across = dp_walk_within(normal, pixel[0], most);
    let down = dp_walk_within(normal, pixel[1], most);
    var points = DP_PIXEL_POINTS;
    var sum = 0.0;
    for (var k = 0u; k < 6u; k++) {
        // The first three agree: so will the others.
        if k == 3u && (sum == 0.0 || sum == 3.0) {
            return min(sum, 1.0);
        }
        let aside = across * points[k].x + down * points[k].y;
        // Beyond a crease the receiver's plane runs under the next surface.
        sum += dp_walk_decide(centre, position + aside, first.quad, first.grazing * length(aside));
    }
    return min(sum * (1.0 / 6.0), 1.0);
}

// A step on the receiver's plane of `most` at most.
fn dp_walk_within(normal: vec3<f32>, step: vec3<f32>, most: f32) -> vec3<f32> {
    let along = step - normal * (dot(normal, step) / max(dot(normal, normal), 1e-30));
    return along * min(1.0, most * inverseSqrt(max(dot(along, along), 1e-30)));
}
