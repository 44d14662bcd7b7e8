// Walk: where the texels around a receiver disagree, their triangles are asked. To be pasted after paraboloid.wgsl and
// lookup.wgsl; twin of src/compare/walk/twins.rs.
//
// From the triangle under a texel's centre the walk crosses edge after edge of its mesh towards the receiver's direction,
// until a triangle has the ray inside it or the surface ends. A triangle that has it and stands before the receiver
// shadows it for certain; the receiver's own surface, and nothing else, says that it is lit. What walks can't tell the
// votes decide.

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

const DP_NO_TRIANGLE: u32 = 0xffffffffu;
// Beyond an edge: the surface's end. See src/neighbours.rs.
const DP_NOTHING: u32 = 3u;

// Where a chunk has its data: the casters' `ChunkSource`, of which the walk reads two words.
struct DpChunk {
    local_vertex: u32,
    vertex: u32,
    triangle: u32,
    counts: u32,
    pieces: array<vec4<u32>, 2>,
}

// Number of the triangle under each texel's centre: its chunk in bits 8-31, its place there in bits 0-7.
@group(DP_GROUP) @binding(3) var dp_numbers: texture_2d_array<u32>;
@group(DP_GROUP) @binding(4) var<storage, read> dp_chunks: array<DpChunk>;
// Corners as places among the chunk's vertices: bits 0-7, 8-15, 16-23.
@group(DP_GROUP) @binding(5) var<storage, read> dp_triangles: array<u32>;
// Three a triangle, what lies beyond the edge from each corner to the next one: bits 0-1 the edge's number in the
// neighbour, bit 2 whether the neighbour is wound the other way, bits 3-10 its place in its chunk, bits 11-31 its chunk
// less the triangle's own.
@group(DP_GROUP) @binding(6) var<storage, read> dp_beyond: array<u32>;
// Positions in world space, and a word more.
@group(DP_GROUP) @binding(7) var<storage, read> dp_vertices: array<vec4<f32>>;

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

// A point of the world by these axes.
fn dp_walk_see(frame: DpWalkFrame, point: vec3<f32>) -> vec3<f32> {
    let p = point - frame.light;
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

// How a walk ends.
struct DpWalk {
    // Distance from the light at which the triangle crosses the ray; DP_WALK_OFF where the surface ends before the ray,
    // DP_WALK_LOST without an answer.
    distance: f32,
    triangle: u32,
}

const DP_WALK_OFF: f32 = 0.0;
const DP_WALK_LOST: f32 = -1.0;

// A triangle as a walk reads it.
struct DpWalked {
    // Number of its first vertex's chunk among all vertices, its corners, and its place among all triangles.
    vertex: u32,
    corners: u32,
    index: u32,
}

fn dp_walk_triangle(number: u32) -> DpWalked {
    let chunk = number >> 8u;
    let index = dp_chunks[chunk].triangle + (number & 0xffu);
    return DpWalked(dp_chunks[chunk].vertex, dp_triangles[index], index);
}

// Number of a triangle's vertex at corner `k`, from 0 to 2.
fn dp_walk_vertex(triangle: DpWalked, k: u32) -> u32 {
    return triangle.vertex + ((triangle.corners >> (8u * k)) & 0xffu);
}

// `k + by` among the numbers 0, 1 and 2.
fn dp_walk_turn(k: u32, by: u32) -> u32 {
    let sum = k + by;
    return select(sum, sum - 3u, sum >= 3u);
}

// By a triangle's volume with the light and the sum of its sides.
fn dp_walk_end(volume: f32, sides: f32, number: u32) -> DpWalk {
    let ends = volume > 0.0 && sides > 0.0;
    return DpWalk(select(DP_WALK_OFF, volume / sides, ends), number);
}

// Walks from a triangle over its neighbours towards the ray.
fn dp_walk_from(start: u32, frame: DpWalkFrame) -> DpWalk {
    var number = start;
    let first = dp_walk_triangle(number);
    let vertices = vec3<u32>(dp_walk_vertex(first, 0u), dp_walk_vertex(first, 1u), dp_walk_vertex(first, 2u));
    let a = dp_walk_see(frame, dp_vertices[vertices.x].xyz);
    let b = dp_walk_see(frame, dp_vertices[vertices.y].xyz);
    let c = dp_walk_see(frame, dp_vertices[vertices.z].xyz);
    var sides = vec3<f32>(dp_walk_side(a, b), dp_walk_side(b, c), dp_walk_side(c, a));
    let start_volume = a.z * sides.y + b.z * sides.z + c.z * sides.x;
    // Walks go as if the triangle's front faced away from the light.
    var turned = start_volume < 0.0;
    sides = select(sides, -sides, turned);
    if min(sides.x, min(sides.y, sides.z)) >= 0.0 {
        return dp_walk_end(abs(start_volume), sides.x + sides.y + sides.z, number);
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
    var beyond = dp_beyond[3u * first.index + edge];
    for (var step = 0u; step < DP_WALK_STEPS; step++) {
        if (beyond & 3u) == 3u {
            break;
        }
        let chunk = u32(i32(number >> 8u) + (bitcast<i32>(beyond) >> 11u));
        number = (chunk << 8u) | ((beyond >> 3u) & 0xffu);
        let entered = beyond & 3u;
        turned = turned != ((beyond & 4u) != 0u);
        let triangle = dp_walk_triangle(number);
        let one = dp_walk_vertex(triangle, entered);
        let other = dp_walk_vertex(triangle, dp_walk_turn(entered, 1u));
        let p_here = select(other, one, turned);
        let q_here = select(one, other, turned);
        // Another chunk's, or where a deforming mesh may have come apart.
        if p_here != p_vertex || q_here != q_vertex {
            p_vertex = p_here;
            q_vertex = q_here;
            p = dp_walk_see(frame, dp_vertices[p_here].xyz);
            q = dp_walk_see(frame, dp_vertices[q_here].xyz);
            crossed = dp_walk_side(q, p);
        }
        let n_vertex = dp_walk_vertex(triangle, dp_walk_turn(entered, 2u));
        let n = dp_walk_see(frame, dp_vertices[n_vertex].xyz);
        let pn = dp_walk_side(p, n);
        let nq = dp_walk_side(n, q);
        let volume = q.z * pn + p.z * nq + n.z * crossed;
        // It faces the other way: what is behind it the first texel didn't see.
        if volume < 0.0 {
            return DpWalk(DP_WALK_OFF, number);
        }
        if min(pn, nq) >= 0.0 {
            if crossed < 0.0 {
                return DpWalk(DP_WALK_OFF, number);
            }
            return dp_walk_end(volume, pn + nq + crossed, number);
        }
        let over_pn = dp_walk_beside(pn, p, n) < dp_walk_beside(nq, n, q);
        beyond = dp_beyond[3u * triangle.index + dp_walk_turn(entered, select(1u, 2u, over_pn == turned))];
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
    return DpWalk(select(DP_WALK_LOST, DP_WALK_OFF, beyond == DP_NOTHING), number);
}

// The triangles of the four texels that `dp_neighbours` has.
fn dp_walk_gather(light: u32, receiver: DpReceiver) -> vec4<u32> {
    let resolution = dp_lights[light].resolution;
    let last = max(resolution - 2.0, 0.0);
    let base = clamp(floor(dp_texel_position(light, receiver.map)), vec2<f32>(0.0), vec2<f32>(last));
    let corner = dp_lights[light].origin + vec2<f32>(select(0.0, resolution, receiver.back), 0.0);
    let at = (corner + base + 1.0) * (1.0 / vec2<f32>(textureDimensions(dp_numbers)));
    return textureGather(0, dp_numbers, dp_sampler, at, dp_lights[light].layer);
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
    votes: f32,
}

// What four texels decide, or what it takes to go on.
struct DpWalkFirst {
    mixed: bool,
    value: f32,
    quad: DpWalkQuad,
}

fn dp_walk_bits(which: vec4<bool>) -> u32 {
    return dot(select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), which), vec4<u32>(1u));
}

fn dp_walk_first(light: u32, position: vec3<f32>, normal: vec3<f32>) -> DpWalkFirst {
    var first: DpWalkFirst;
    first.value = 1.0;
    let receiver = dp_locate(light, position, normal);
    if dp_is_out_of_range(light, receiver) {
        return first;
    }
    if !dp_has_hemisphere(light, receiver.back) {
        first.value = 0.0;
        return first;
    }
    let around = dp_neighbours(light, receiver.back, receiver.map);
    let footprint = dp_footprint(light, receiver.map);
    let plane = dp_plane(light, receiver);
    let judge = dp_judge(light, receiver);
    let depths = dp_plane_depths(plane, around.texels.u, around.texels.v);
    let grazing = dp_grazing(receiver);
    let coordinates = max(abs(position), abs(dp_lights[light].position));
    let farthest = max(coordinates.x, max(coordinates.y, coordinates.z));
    let rounding = DP_WALK_ROUNDING * grazing * (3.0 + farthest / receiver.distance);
    let flat_bound = DP_WALK_FLAT * grazing * footprint + rounding;
    if all(around.texels.stored <= (1.0 + flat_bound) * depths) {
        return first;
    }
    if all(around.texels.stored >= dp_bounds(judge, footprint).dark * depths) {
        first.value = 0.0;
        return first;
    }
    let margins = dp_margins(around.texels.stored, depths, footprint);
    let votes = dp_votes(judge, margins);
    let triangles = dp_walk_gather(light, receiver);
    let most = max(max(margins.x, margins.y), max(margins.z, margins.w));
    let low = select(triangles.x, triangles.y, margins.y == most);
    let dark = margins > vec4<f32>(judge.bias);
    let level = !dark & (abs(margins) < vec4<f32>(DP_WALK_OWN_GRAZING * grazing));
    let own = abs(margins) <= vec4<f32>(flat_bound / footprint);
    // Of the caller's own casters.
    let unnumbered = (triangles == vec4<u32>(DP_NO_TRIANGLE)) & (around.texels.stored > vec4<f32>(0.0));
    first.mixed = true;
    first.quad.lead = select(select(low, triangles.z, margins.z == most), triangles.w, margins.w == most);
    first.quad.dark = dp_walk_bits(dark);
    first.quad.level = dp_walk_bits(level);
    first.quad.own_seen = any(own | (unnumbered & level));
    first.quad.lost = any(unnumbered & dark);
    first.quad.triangles = select(triangles, vec4<u32>(DP_NO_TRIANGLE), own);
    first.quad.over = (DP_WALK_OVER + DP_WALK_OVER_GRAZING * grazing) * footprint + rounding;
    first.quad.own = -(DP_WALK_OWN + DP_WALK_OWN_GRAZING * grazing) * footprint;
    first.quad.nearest = dp_lights[light].near * receiver.distance / receiver.w;
    first.quad.votes = dp_count(dot(around.weights, votes.lit), dot(around.weights, votes.dark));
    return first;
}

fn dp_walk_least(triangles: vec4<u32>) -> u32 {
    return min(min(triangles.x, triangles.y), min(triangles.z, triangles.w));
}

// 1 or 0 for certain, or the votes.
fn dp_walk_decide(light: u32, position: vec3<f32>, quad: DpWalkQuad) -> f32 {
    let relative = position - dp_lights[light].position;
    let distance = length(relative);
    let frame = dp_walk_frame(dp_lights[light].position, relative * (1.0 / distance));
    var own = quad.own_seen;
    var lost = quad.lost;
    // Each triangle once: first the leading one, then in the order of their numbers, of which DP_NO_TRIANGLE is the last.
    var rest = quad.triangles;
    var triangle = select(quad.lead, dp_walk_least(rest), quad.lead == DP_NO_TRIANGLE);
    while triangle != DP_NO_TRIANGLE {
        rest = select(rest, vec4<u32>(DP_NO_TRIANGLE), rest == vec4<u32>(triangle));
        let end = dp_walk_from(triangle, frame);
        if end.distance > 0.0 && end.distance >= quad.nearest {
            let margin = distance / end.distance - 1.0;
            if margin > quad.over {
                return 0.0;
            }
            own = own || margin > quad.own;
        } else if end.distance < 0.0 {
            let here = dp_walk_bits(quad.triangles == vec4<u32>(triangle));
            lost = lost || (here & quad.dark) != 0u;
            own = own || (here & quad.level) != 0u;
        }
        triangle = dp_walk_least(rest);
    }
    return select(quad.votes, 1.0, own && !lost);
}

// Share of the light that reaches `position`, 0 or 1 but where no triangle says; the arguments are those of `dp_shadow`.
fn dp_walk_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let first = dp_walk_first(light, position, normal);
    if !first.mixed {
        return first.value;
    }
    return dp_walk_decide(light, position, first.quad);
}
