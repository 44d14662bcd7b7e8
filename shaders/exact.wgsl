// Exact edges: where the texels around a receiver disagree, their triangles are asked. Twin of src/compare/walk/twins.rs.
//
// From the triangle under a texel's centre the walk crosses edge after edge of its mesh towards the receiver's direction,
// until a triangle has the ray inside it or the surface ends. A triangle that has it and stands before the receiver
// shadows it for certain; one that has it and doesn't, be it the receiver's own or behind it, says that it is lit. What
// walks can't tell the votes decide. None of this depends on the projection of the maps; sharp.wgsl has what is the pair's.

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
// Up to so many footprints times the grazing factor before or behind the receiver's plane a texel whose walk is lost speaks for
// light.
const DP_WALK_LEVEL: f32 = 0.05;
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
    // The receiver's distance from the light, and the steps to the next pixels there, square to the ray.
    distance: f32,
    across: vec2<f32>,
    down: vec2<f32>,
}

// A vector by the first two axes.
fn dp_walk_flat(frame: DpWalkFrame, v: vec3<f32>) -> vec2<f32> {
    let k = frame.a * dot(v.xy, frame.ray.xy) - v.z;
    return vec2<f32>(v.x + frame.s * frame.ray.x * k, frame.s * v.y + frame.ray.y * k);
}

fn dp_walk_frame(light: vec3<f32>, ray: vec3<f32>, distance: f32) -> DpWalkFrame {
    let s = select(-1.0, 1.0, ray.z >= 0.0);
    return DpWalkFrame(light, ray, s, -1.0 / (s + ray.z), distance, vec2<f32>(0.0), vec2<f32>(0.0));
}

// The same through the point that lies so many pixels aside.
fn dp_walk_frame_aside(frame: DpWalkFrame, pixels: vec2<f32>) -> DpWalkFrame {
    let flat_aside = frame.across * pixels.x + frame.down * pixels.y;
    // The first two axes.
    let k = frame.a * frame.ray.xy;
    let x = vec3<f32>(1.0 + frame.s * frame.ray.x * k.x, frame.s * frame.ray.x * k.y, -frame.s * frame.ray.x);
    let y = vec3<f32>(frame.ray.y * k.x, frame.s + frame.ray.y * k.y, -frame.ray.y);
    let ray = normalize(frame.ray * frame.distance + x * flat_aside.x + y * flat_aside.y);
    return DpWalkFrame(frame.light, ray, frame.s, -1.0 / (frame.s + ray.z), frame.distance, frame.across, frame.down);
}

// A vertex by the axes.
fn dp_walk_see(frame: DpWalkFrame, vertex: u32) -> vec3<f32> {
    let p = dp_vertex(vertex).xyz - frame.light;
    return vec3<f32>(dp_walk_flat(frame, p), dot(frame.ray, p));
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
struct DpWalkEnd {
    // Distance from the light at which a triangle crosses the ray, or one of the constants below.
    distance: f32,
    // Of the edge where this ends, nearest to the ray: how far off it is, in pixels, in which direction of pixels that grows,
    // and the edge's distance from the light.
    pixels: f32,
    direction: vec2<f32>,
    depth: f32,
    // The last triangle.
    number: u32,
}

// The surface ends before the ray, or has a hole there.
const DP_WALK_OFF: f32 = 0.0;
// There is no answer.
const DP_WALK_LOST: f32 = -1.0;

// An edge from `a` to `b` as a walk ends at it, by the side that the ray runs on.
fn dp_walk_edge(frame: DpWalkFrame, a: vec3<f32>, b: vec3<f32>, side: f32) -> vec3<f32> {
    // A step along the receiver moves the product with the plane's normal by so much.
    let normal = vec2<f32>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z);
    let change = vec2<f32>(dot(normal, frame.across), dot(normal, frame.down));
    let size = dot(change, change);
    let inverse = inverseSqrt(max(size, 1e-37));
    return vec3<f32>(select(frame.distance * side * inverse, 1e9, size < 1e-37), change * inverse);
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

// Walks from a triangle over its neighbours towards the ray. Casters that have changed since the map was made aren't those it
// shows.
fn dp_walk_from(number: u32, made: u32, frame: DpWalkFrame) -> DpWalkEnd {
    var end = DpWalkEnd(DP_WALK_LOST, 1e9, vec2<f32>(0.0), 0.0, number);
    if (number >> 8u) >= arrayLength(&dp_chunks) {
        return end;
    }
    var place = dp_chunk(number >> 8u);
    if place.z == 0u || place.z > made {
        return end;
    }
    end.distance = DP_WALK_OFF;
    var record = dp_mesh_record(place.y + (number & 0xffu));
    // The edge from p to q is crossed: the ray runs so far on its other side. The triangle's third vertex is n.
    var q_vertex = place.x + dp_walk_corner(record.x, 0u);
    var p_vertex = place.x + dp_walk_corner(record.x, 1u);
    var n_vertex = place.x + dp_walk_corner(record.x, 2u);
    var q = dp_walk_see(frame, q_vertex);
    var p = dp_walk_see(frame, p_vertex);
    var n = dp_walk_see(frame, n_vertex);
    var crossed = dp_walk_side(q, p);
    var pn = dp_walk_side(p, n);
    var nq = dp_walk_side(n, q);
    var volume = q.z * pn + p.z * nq + n.z * crossed;
    // Walks go as if the triangle's front faced away from the light.
    var turned = volume < 0.0;
    if turned {
        crossed = -crossed;
        pn = -pn;
        nq = -nq;
        volume = -volume;
    }
    var inside = min(crossed, min(pn, nq)) >= 0.0;
    if !inside {
        // Over the edge that the ray runs farthest beyond.
        let off = vec3<f32>(dp_walk_beside(crossed, q, p), dp_walk_beside(pn, p, n), dp_walk_beside(nq, n, q));
        var edge = 0u;
        var from_end = q;
        var to_end = p;
        var from_vertex = q_vertex;
        var to_vertex = p_vertex;
        var side = crossed;
        if off.y < off.x {
            edge = 1u;
            from_end = p;
            to_end = n;
            from_vertex = p_vertex;
            to_vertex = n_vertex;
            side = pn;
        }
        if off.z < min(off.x, off.y) {
            edge = 2u;
            from_end = n;
            to_end = q;
            from_vertex = n_vertex;
            to_vertex = q_vertex;
            side = nq;
        }
        p = select(from_end, to_end, turned);
        q = select(to_end, from_end, turned);
        p_vertex = select(from_vertex, to_vertex, turned);
        q_vertex = select(to_vertex, from_vertex, turned);
        crossed = -side;
        var beyond = dp_walk_beyond(record, edge);
        for (var step = 0u; step < DP_WALK_STEPS; step++) {
            if (beyond & 3u) == 3u {
                break;
            }
            let chunks = bitcast<i32>(beyond) >> 11u;
            let chunk = u32(i32(end.number >> 8u) + chunks);
            if chunks != 0 {
                place = dp_chunk(chunk);
            }
            end.number = (chunk << 8u) | ((beyond >> 3u) & 0xffu);
            record = dp_mesh_record(place.y + (end.number & 0xffu));
            let entered = beyond & 3u;
            turned = turned != ((beyond & 4u) != 0u);
            let one = place.x + dp_walk_corner(record.x, entered);
            let other = place.x + dp_walk_corner(record.x, dp_walk_turn(entered, 1u));
            n_vertex = place.x + dp_walk_corner(record.x, dp_walk_turn(entered, 2u));
            let p_here = select(other, one, turned);
            let q_here = select(one, other, turned);
            // Another chunk's, or where a deforming mesh may have come apart.
            if p_here != p_vertex || q_here != q_vertex {
                p = dp_walk_see(frame, p_here);
                q = dp_walk_see(frame, q_here);
                p_vertex = p_here;
                q_vertex = q_here;
                crossed = dp_walk_side(q, p);
            }
            n = dp_walk_see(frame, n_vertex);
            pn = dp_walk_side(p, n);
            nq = dp_walk_side(n, q);
            volume = q.z * pn + p.z * nq + n.z * crossed;
            inside = min(pn, nq) >= 0.0;
            // It faces the other way: what is behind it the first texel didn't see.
            if inside || volume < 0.0 {
                beyond = DP_NOTHING;
                break;
            }
            let first = dp_walk_beside(pn, p, n) < dp_walk_beside(nq, n, q);
            beyond = dp_walk_beyond(record, dp_walk_turn(entered, select(1u, 2u, first == turned)));
            if first {
                q = n;
                q_vertex = n_vertex;
                crossed = -pn;
            } else {
                p = n;
                p_vertex = n_vertex;
                crossed = -nq;
            }
        }
        if beyond != DP_NOTHING {
            end.distance = DP_WALK_LOST;
            return end;
        }
    }
    if inside && end.number == number && turned {
        let swapped = p;
        p = q;
        q = swapped;
        let swapped_vertex = p_vertex;
        p_vertex = q_vertex;
        q_vertex = swapped_vertex;
        let side = pn;
        pn = nq;
        nq = side;
    }
    var edge = dp_walk_edge(frame, q, p, crossed);
    let sum = pn + nq + crossed;
    if inside && volume > 0.0 && crossed >= 0.0 && sum > 0.0 {
        end.distance = volume / sum;
        let edge_pn = dp_walk_edge(frame, p, n, pn);
        let edge_nq = dp_walk_edge(frame, n, q, nq);
        edge = select(edge, edge_pn, edge_pn.x < edge.x);
        edge = select(edge, edge_nq, edge_nq.x < edge.x);
        if (place.w & DP_MASKED) != 0u {
            let sides = vec3<f32>(pn, nq, crossed);
            let mask = dp_walk_mask(frame, vec3<u32>(q_vertex, p_vertex, n_vertex), q, p, n, sides);
            if mask.x < 0.0 {
                end.depth = end.distance;
                end.distance = DP_WALK_OFF;
                edge = -mask;
            } else {
                edge = select(edge, mask, mask.x < edge.x);
            }
        }
    } else {
        let along = q.xy - p.xy;
        let share = saturate(-dot(p.xy, along) / max(dot(along, along), 1e-30));
        end.depth = mix(p.z, q.z, share);
    }
    end.pixels = edge.x;
    end.direction = edge.yz;
    return end;
}

// What lies beyond the edge `k`.
fn dp_walk_beyond(record: vec4<u32>, k: u32) -> u32 {
    return select(select(record.w, record.z, k == 1u), record.y, k == 0u);
}

// Where a masked triangle ends at a hole, or the hole at the triangle, in which it is negative: as `dp_walk_edge`, by the
// triangle's vertices and the sides of the edges opposite to them.
fn dp_walk_mask(
    frame: DpWalkFrame,
    vertices: vec3<u32>,
    q: vec3<f32>,
    p: vec3<f32>,
    n: vec3<f32>,
    sides: vec3<f32>,
) -> vec3<f32> {
    let a = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.x).w));
    let b = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.y).w));
    let c = dp_mask_vertex(bitcast<u32>(dp_vertex(vertices.z).w));
    // Alpha at the ray, and at those through the next pixels.
    var alphas = vec3<f32>(0.0);
    for (var k = 0u; k < 3u; k++) {
        let aside = select(select(frame.down, frame.across, k == 1u), vec2<f32>(0.0), k == 0u) / frame.distance;
        let shares = sides + vec3<f32>(
            dot(aside, vec2<f32>(p.y * n.z - p.z * n.y, p.z * n.x - p.x * n.z)),
            dot(aside, vec2<f32>(n.y * q.z - n.z * q.y, n.z * q.x - n.x * q.z)),
            dot(aside, vec2<f32>(q.y * p.z - q.z * p.y, q.z * p.x - q.x * p.z)),
        );
        let alpha = dp_mask_margin(a, b, c, shares * (1.0 / (shares.x + shares.y + shares.z)));
        alphas = select(alphas, vec3<f32>(alpha), vec3<u32>(0u, 1u, 2u) == vec3<u32>(k));
    }
    let change = alphas.yz - alphas.x;
    let size = dot(change, change);
    let inverse = inverseSqrt(max(size, 1e-30));
    let even = select(1e9, -1e9, alphas.x < 0.0);
    return vec3<f32>(select(alphas.x * inverse, even, size < 1e-30), change * inverse);
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
    // Bound of (receiver's distance / surface's distance - 1).
    over: f32,
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
    let level = !dark & (abs(margins) < vec4<f32>(DP_WALK_LEVEL * margins_at.grazing));
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
    quad.nearest = dp_lights[light].near * receiver.distance / receiver.w;
    quad.made = dp_lights[light].made;
    quad.votes = dp_count(dot(weights, votes.lit), dot(weights, votes.dark));
    return quad;
}

fn dp_walk_least(triangles: vec4<u32>) -> u32 {
    return min(min(triangles.x, triangles.y), min(triangles.z, triangles.w));
}

// What a receiver's triangles answer over a pixel whose steps are no longer than `most`. At its middle each triangle is asked
// once, first the leading one, then in the order of their numbers: any that is in the way makes it dark, else the receiver's
// own surface lit, else the votes decide. Edges of what is in the way are as wide as a pixel: half of that lies in the light,
// where walks have ended at the edge, and half in the dark, where the point half a pixel farther out is asked.
fn dp_walk_pixel(
    light: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    view: vec4<f32>,
    first: DpWalkFirst,
    most: f32,
) -> f32 {
    let quad = first.quad;
    var lead = select(quad.lead, dp_walk_least(quad.triangles), quad.lead == DP_NO_TRIANGLE);
    if lead == DP_NO_TRIANGLE {
        return select(quad.votes, 1.0, quad.own_seen && !quad.lost);
    }
    let relative = position - dp_lights[light].position;
    let distance = length(relative);
    var frame = dp_walk_frame(dp_lights[light].position, relative * (1.0 / distance), distance);
    if view.w != 0.0 {
        let pixel = dp_pixel(view, position, normal);
        frame.across = dp_walk_flat(frame, dp_walk_within(pixel[0], most));
        frame.down = dp_walk_flat(frame, dp_walk_within(pixel[1], most));
    }
    var over = quad.over;
    var middle = 0.5;
    for (var k = 0u; k < 2u; k++) {
        var own = quad.own_seen;
        var lost = quad.lost;
        var lit = 1.0;
        var blocked = false;
        var edge = vec3<f32>(0.0);
        var rest = quad.triangles;
        var triangle = lead;
        while triangle != DP_NO_TRIANGLE {
            rest = select(rest, vec4<u32>(DP_NO_TRIANGLE), rest == vec4<u32>(triangle));
            let end = dp_walk_from(triangle, quad.made, frame);
            if end.distance > 0.0 && end.distance >= quad.nearest {
                let margin = distance / end.distance - 1.0;
                if margin > over {
                    blocked = true;
                    edge = vec3<f32>(end.pixels, end.direction);
                    // What is in the way here is so a little farther, if anything is.
                    lead = end.number;
                    break;
                }
                own = true;
            } else if end.distance < 0.0 {
                let here = dp_walk_bits(quad.triangles == vec4<u32>(triangle));
                lost = lost || (here & quad.dark) != 0u;
                own = own || (here & quad.level) != 0u;
            } else if end.depth >= quad.nearest && distance > end.depth * (1.0 + over) {
                lit = min(lit, saturate(middle + end.pixels));
            }
            triangle = dp_walk_least(rest);
        }
        if !blocked {
            return min(lit, select(quad.votes, 1.0, own && !lost));
        }
        if edge.x >= 0.5 {
            break;
        }
        frame = dp_walk_frame_aside(frame, -0.5 * edge.yz);
        middle = 0.0;
        // Beyond a crease the receiver's plane runs under the next surface.
        over += first.grazing * length(frame.across * edge.y + frame.down * edge.z) / distance;
    }
    return 0.0;
}

// A step, but not longer than `most`.
fn dp_walk_within(step: vec3<f32>, most: f32) -> vec3<f32> {
    return step * min(1.0, most * inverseSqrt(max(dot(step, step), 1e-30)));
}
