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
// Points of a pixel that are asked at most.
const DP_PIXEL_POINTS: u32 = 6u;

const DP_NO_TRIANGLE: u32 = 0xffffffffu;
// Beyond an edge: the surface's end. See src/neighbours.rs.
const DP_NOTHING: u32 = 3u;
// Something, but not known what.
const DP_UNKNOWN: u32 = 7u;
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

// How a step ends: the distance from the light at which a triangle crosses the ray, or one of these. The surface ends before
// the ray, or has a hole there.
const DP_WALK_OFF: f32 = 0.0;
// There is no answer.
const DP_WALK_LOST: f32 = -1.0;
// The walk goes on.
const DP_WALK_ON: f32 = -2.0;

// A walk on its way into the triangle beyond an edge, from p to q as the ray sees it.
struct DpWalk {
    // As mesh records have it, and the chunk that it is relative to with its place.
    beyond: u32,
    chunk: u32,
    place: vec4<u32>,
    // The triangle's front faces the light; walks go as if it faced away.
    turned: bool,
    // Steps that are left.
    left: u32,
    // DP_NO_VERTEX before the first step.
    p_vertex: u32,
    q_vertex: u32,
    p: vec3<f32>,
    q: vec3<f32>,
    // How far the ray runs beyond the edge: (q x p).ray.
    crossed: f32,
}

const DP_NO_VERTEX: u32 = 0xffffffffu;

// A walk from a triangle. Casters that have changed since the map was made aren't those it shows.
fn dp_walk_begin(number: u32, made: u32) -> DpWalk {
    var walk: DpWalk;
    walk.p_vertex = DP_NO_VERTEX;
    walk.left = DP_WALK_STEPS + 1u;
    walk.chunk = number >> 8u;
    walk.beyond = DP_UNKNOWN;
    if walk.chunk < arrayLength(&dp_chunks) {
        walk.place = dp_chunk(walk.chunk);
        if walk.place.z != 0u && walk.place.z <= made {
            walk.beyond = (number & 0xffu) << 3u;
        }
    }
    return walk;
}

// `k + by` among the numbers 0, 1 and 2.
fn dp_walk_turn(k: u32, by: u32) -> u32 {
    let sum = k + by;
    return select(sum, sum - 3u, sum >= 3u);
}

// A triangle's corner `k`, from 0 to 2, among its chunk's vertices.
fn dp_walk_corner(corners: u32, k: u32) -> u32 {
    return (corners >> (8u * k)) & 0xffu;
}

// One triangle on.
fn dp_walk_step(walk: ptr<function, DpWalk>, frame: DpWalkFrame) -> f32 {
    let beyond = (*walk).beyond;
    if (beyond & 3u) == 3u || (*walk).left == 0u {
        return select(DP_WALK_LOST, DP_WALK_OFF, beyond == DP_NOTHING);
    }
    (*walk).left -= 1u;
    let chunks = bitcast<i32>(beyond) >> 11u;
    if chunks != 0 {
        (*walk).chunk = u32(i32((*walk).chunk) + chunks);
        (*walk).place = dp_chunk((*walk).chunk);
    }
    let place = (*walk).place;
    let record = dp_mesh_record(place.y + ((beyond >> 3u) & 0xffu));
    let entered = beyond & 3u;
    let one = place.x + dp_walk_corner(record.x, entered);
    let other = place.x + dp_walk_corner(record.x, dp_walk_turn(entered, 1u));
    let n_vertex = place.x + dp_walk_corner(record.x, dp_walk_turn(entered, 2u));
    var turned = (*walk).turned != ((beyond & 4u) != 0u);
    let begins = (*walk).p_vertex == DP_NO_VERTEX;
    var p_vertex = select(other, one, turned);
    var q_vertex = select(one, other, turned);
    var p = (*walk).p;
    var q = (*walk).q;
    var crossed = (*walk).crossed;
    // The first triangle, another chunk's, or where a deforming mesh may have come apart.
    if p_vertex != (*walk).p_vertex || q_vertex != (*walk).q_vertex {
        p = dp_walk_see(frame, p_vertex);
        q = dp_walk_see(frame, q_vertex);
        crossed = dp_walk_side(q, p);
    }
    let n = dp_walk_see(frame, n_vertex);
    var pn = dp_walk_side(p, n);
    var nq = dp_walk_side(n, q);
    var volume = q.z * pn + p.z * nq + n.z * crossed;
    if begins && volume < 0.0 {
        turned = !turned;
        let end = p;
        p = q;
        q = end;
        let end_vertex = p_vertex;
        p_vertex = q_vertex;
        q_vertex = end_vertex;
        let side = pn;
        pn = -nq;
        nq = -side;
        crossed = -crossed;
        volume = -volume;
    }
    // It faces the other way: what is behind it the first texel didn't see.
    if volume < 0.0 {
        return DP_WALK_OFF;
    }
    if min(pn, nq) >= 0.0 && (crossed >= 0.0 || !begins) {
        let sum = pn + nq + crossed;
        if crossed < 0.0 || volume == 0.0 || sum <= 0.0 {
            return DP_WALK_OFF;
        }
        if (place.w & DP_MASKED) != 0u && dp_walk_is_hole(vec3<u32>(q_vertex, p_vertex, n_vertex), vec3<f32>(pn, nq, crossed)) {
            return DP_WALK_OFF;
        }
        return volume / sum;
    }
    // Over the edge that the ray runs farthest beyond, but never back.
    let over_pn = dp_walk_beside(pn, p, n);
    let over_nq = dp_walk_beside(nq, n, q);
    let back = begins && dp_walk_beside(crossed, q, p) < min(over_pn, over_nq);
    let first = over_pn < over_nq;
    let edge = dp_walk_turn(entered, select(select(1u, 2u, first == turned), 0u, back));
    (*walk).beyond = select(select(record.w, record.z, edge == 1u), record.y, edge == 0u);
    (*walk).turned = turned;
    // From p to n, from n to q, or back from q to p.
    (*walk).p_vertex = select(select(n_vertex, p_vertex, first), q_vertex, back);
    (*walk).q_vertex = select(select(q_vertex, n_vertex, first), p_vertex, back);
    (*walk).p = select(select(n, p, first), q, back);
    (*walk).q = select(select(q, n, first), p, back);
    (*walk).crossed = -select(select(nq, pn, first), crossed, back);
    return DP_WALK_ON;
}

// Whether a masked triangle has a hole where the ray runs, by the sides of the edges opposite to its vertices.
fn dp_walk_is_hole(vertices: vec3<u32>, sides: vec3<f32>) -> bool {
    let a = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.x).w));
    let b = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.y).w));
    let c = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.z).w));
    return dp_is_hole(a, b, c, sides * (1.0 / (sides.x + sides.y + sides.z)));
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

// What a receiver's triangles answer over a pixel, of whose points none is asked for farther away than `most`. At each point
// each triangle is asked once, first the leading one, then in the order of their numbers: any that is in the way makes it
// dark, else the receiver's own surface lit, else the votes decide. One loop goes through points, triangles and steps, so that
// no pixel of a group waits for another's walk to end.
fn dp_walk_pixel(
    light: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    pixel: mat2x3<f32>,
    first: DpWalkFirst,
    most: f32,
) -> f32 {
    let quad = first.quad;
    let lead = select(quad.lead, dp_walk_least(quad.triangles), quad.lead == DP_NO_TRIANGLE);
    if lead == DP_NO_TRIANGLE {
        return select(quad.votes, 1.0, quad.own_seen && !quad.lost);
    }
    let across = dp_walk_within(normal, pixel[0], most);
    let down = dp_walk_within(normal, pixel[1], most);
    let is_point = dot(across, across) + dot(down, down) == 0.0;
    let count = select(DP_PIXEL_POINTS, 1u, is_point);
    let centre = dp_lights[light].position;
    var k = 0u;
    var sum = 0.0;
    var aside = dp_walk_aside(across, down, k);
    var point = dp_walk_point(centre, position + aside);
    var own = quad.own_seen;
    var lost = quad.lost;
    var triangle = lead;
    var rest = quad.triangles;
    var walk = dp_walk_begin(triangle, quad.made);
    loop {
        let end = dp_walk_step(&walk, point.frame);
        if end == DP_WALK_ON {
            continue;
        }
        var answer = -1.0;
        if end > 0.0 && end >= quad.nearest {
            let margin = point.distance / end - 1.0;
            // Beyond a crease the receiver's plane runs under the next surface.
            if margin > quad.over + first.grazing * length(aside) / point.distance {
                answer = 0.0;
            }
            own = own || margin > quad.own;
        } else if end < 0.0 {
            let here = dp_walk_bits(quad.triangles == vec4<u32>(triangle));
            lost = lost || (here & quad.dark) != 0u;
            own = own || (here & quad.level) != 0u;
        }
        rest = select(rest, vec4<u32>(DP_NO_TRIANGLE), rest == vec4<u32>(triangle));
        triangle = dp_walk_least(rest);
        if answer < 0.0 && triangle == DP_NO_TRIANGLE {
            answer = select(quad.votes, 1.0, own && !lost);
        }
        if answer >= 0.0 {
            sum += answer;
            k++;
            // Of the first three, if they agree, so will the others.
            if k == count || (k == 3u && (sum == 0.0 || sum == 3.0)) {
                break;
            }
            aside = dp_walk_aside(across, down, k);
            point = dp_walk_point(centre, position + aside);
            own = quad.own_seen;
            lost = quad.lost;
            triangle = lead;
            rest = quad.triangles;
        }
        walk = dp_walk_begin(triangle, quad.made);
    }
    return min(sum / f32(k), 1.0);
}

// A point of a pixel as walks go there.
struct DpWalkPoint {
    frame: DpWalkFrame,
    distance: f32,
}

fn dp_walk_point(light: vec3<f32>, position: vec3<f32>) -> DpWalkPoint {
    let relative = position - light;
    let distance = length(relative);
    return DpWalkPoint(dp_walk_frame(light, relative * (1.0 / distance)), distance);
}

// Where a point of a pixel lies from its middle: on a hexagon, the first three on a triangle, so that no edge through the
// middle goes past all of them.
fn dp_walk_aside(across: vec3<f32>, down: vec3<f32>, k: u32) -> vec3<f32> {
    let sign = select(1.0, -1.0, k >= 3u);
    let third = select(k, k - 3u, k >= 3u);
    let x = select(select(-0.109, -0.297, third == 1u), 0.406, third == 0u);
    let y = select(select(-0.406, 0.297, third == 1u), 0.109, third == 0u);
    return (across * x + down * y) * sign;
}

// A step on the receiver's plane of `most` at most.
fn dp_walk_within(normal: vec3<f32>, step: vec3<f32>, most: f32) -> vec3<f32> {
    let along = step - normal * (dot(normal, step) / max(dot(normal, normal), 1e-30));
    return along * min(1.0, most * inverseSqrt(max(dot(along, along), 1e-30)));
}
