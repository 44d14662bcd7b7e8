// Split: cuts triangles whose edges bend too much in the map into pieces that may be drawn with straight ones. A
// workgroup works on a stack of pieces in its own memory; an edge is cut where the bisector of its angle at the light
// meets it.
//
// Whether a part of one of the triangle's own edges is cut depends on its two ends alone, so that the neighbour agrees.
// Cuts inside of the triangle are nobody else's business. There the chord's place doesn't matter, since both sides show
// the same plane, but depth does: interpolated, it is off by the bend times the slant of the plane.
//
// Twice: the first time (COARSE) over the route's triangles, where parts of big ones are handed on once they are
// middling, so that the second time all workgroups have a share of a wall that fills the view.

@group(0) @binding(0) var<uniform> views: array<View, MOST_JOBS>;
@group(0) @binding(1) var<storage, read_write> arguments: array<Arguments, MOST_JOBS>;
@group(0) @binding(2) var<storage, read_write> lists: array<u32>;
@group(0) @binding(3) var<storage, read> vertices: array<CasterVertex>;
// Three corners a piece, relative to the light, each with a shift of its 1/w; in masked jobs the second corner has the
// triangle's number in the lists in place of it, and the others' shifts are the same. A part for each job and hemisphere.
@group(0) @binding(4) var<storage, read_write> pieces: array<vec4<f32>>;
// Middling parts of big triangles, as on the stack; a part for each job and hemisphere.
@group(0) @binding(5) var<storage, read_write> parts: array<Stacked>;

// The workgroup's job and its number in the batch.
var<private> view: View;
var<private> job: u32;

override COARSE: bool = true;

override THREADS: u32 = 64u;
const STACK: u32 = 252u;
// Cuts from a triangle to its smallest piece. Each halves the angle of an edge, so 8 would do; the rest is for edges
// that come out of a cut longer than they would need.
const MOST_LEVELS: u32 = 15u;
// Room to finish one piece at a time, depth first, when the stack is nearly full.
const RESERVE: u32 = 3u * MOST_LEVELS;
// A piece is big if an edge has more than this many times the tolerable bend: it makes some dozens of pieces or more.
const BIG: f32 = 64.0;
// Chords inside of a triangle must not cross its outline, which is cut finely: near a corner they stay inside if they bend by
// less than this share of the sine of the angle there, times the length of the outline's chords.
const SHAPE: f32 = 0.15;
// A piece isn't shifted if its height in the map is less than its bend, and wholly if it is so many times the bend more:
// what the shift of a thinner one is computed from lies outside of it. Away from the light that hardly matters, toward it
// that would be acne.
const THICK_AWAY: f32 = 2.0;
const THICK_TOWARD: f32 = 30.0;
// Bend that no edge comes near: a limit for those that aren't cut any more.
const NEVER: f32 = 1e9;
// Share of its limit that the bend of a cut may have which is never cut itself: less than one, so that it isn't on the other
// side either, however that rounds.
const SHORT_SHARE: f32 = 0.99;
// Parts that a hemisphere has room for; what finds none is cut where it is.
const PART_CAPACITY: u32 = 16384u;

// A triangle, or a quadrilateral of which two opposite sides may have to be cut, and the other two are short enough.
struct Piece {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    // Of a triangle the same as c.
    d: vec3<f32>,
    // How far the edges from a, from b, from c and from d on may bend, in texels; 0 for parts of the triangle's own edges.
    limits: vec4<f32>,
    // Of the triangle's plane N.X = D in hemisphere space, |N.z| and N.z / D.
    slant: f32,
    lean: f32,
    // Bits 0-21 the place in the list, 22-23 the cull flags, 24 whether it is a quadrilateral, 27-30 the level, 31 whether
    // it is part of a big piece.
    info: u32,
}

// A piece as sixteen words: three corners; of a triangle its three limits, of a quadrilateral its fourth corner; the limits
// of a quadrilateral's long sides, as halves; slant, lean and info.
alias Stacked = array<u32, 16>;

const QUAD_FLAG: u32 = 0x1000000u;
const LEVEL_SHIFT: u32 = 27u;
const PART_FLAG: u32 = 0x80000000u;

var<workgroup> stack: array<Stacked, STACK>;
var<workgroup> stack_size: atomic<u32>;
var<workgroup> size: u32;
var<workgroup> leaf_count: atomic<u32>;
var<workgroup> leaf_base: u32;

@compute @workgroup_size(THREADS)
fn split(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    job = group.z;
    view = views[job];
    let hemisphere = group.y;
    if thread == 0u {
        atomicStore(&stack_size, 0u);
        atomicStore(&leaf_count, 0u);
        if COARSE {
            size = atomicLoad(&arguments[job].to_split[hemisphere]);
        } else {
            size = min(atomicLoad(&arguments[job].parts[hemisphere]), PART_CAPACITY);
        }
    }
    let count = workgroupUniformLoad(&size);
    for (var first = group.x; first < count; first += groups.x * THREADS) {
        // Neighbours go to different workgroups, since big ones come together.
        let place = first + thread * groups.x;
        if place < count {
            if COARSE {
                push(whole_triangle(hemisphere, place));
            } else {
                push(from_stacked(parts[parts_start(hemisphere) + place]));
            }
        }
        work(hemisphere, thread);
    }
}

// Empties the stack. Every cut halves an edge's angle and no piece is cut more than MOST_LEVELS times, so this ends.
fn work(hemisphere: u32, thread: u32) {
    var leaf: Piece;
    var shift = vec3<f32>();
    var is_leaf = false;
    var place = 0u;
    loop {
        workgroupBarrier();
        if thread == 0u {
            size = atomicLoad(&stack_size);
            leaf_base = reserve(hemisphere, atomicExchange(&leaf_count, 0u));
        }
        let on_stack = workgroupUniformLoad(&size);
        if is_leaf {
            write_leaf(hemisphere, leaf_base + place, leaf, shift);
            is_leaf = false;
        }
        if on_stack == 0u {
            break;
        }
        // As many as their children surely have room for.
        let room = (STACK - RESERVE - min(on_stack, STACK - RESERVE)) / 3u;
        let taken = min(min(on_stack, THREADS), max(room, 1u));
        if thread < taken {
            leaf = from_stacked(stack[on_stack - 1u - thread]);
        }
        if thread == 0u {
            atomicStore(&stack_size, on_stack - taken);
        }
        workgroupBarrier();
        if thread < taken && cut(leaf, hemisphere, &shift) {
            is_leaf = true;
            place = atomicAdd(&leaf_count, 1u);
        }
    }
}

fn from_stacked(s: Stacked) -> Piece {
    let info = s[15];
    let is_quad = (info & QUAD_FLAG) != 0u;
    let c = bitcast<vec3<f32>>(vec3<u32>(s[6], s[7], s[8]));
    let fourth = bitcast<vec3<f32>>(vec3<u32>(s[9], s[10], s[11]));
    let sides = unpack2x16float(s[12]);
    return Piece(
        bitcast<vec3<f32>>(vec3<u32>(s[0], s[1], s[2])),
        bitcast<vec3<f32>>(vec3<u32>(s[3], s[4], s[5])),
        c,
        select(c, fourth, is_quad),
        select(vec4<f32>(fourth.xy, 0.0, fourth.z), vec4<f32>(sides.x, NEVER, sides.y, NEVER), is_quad),
        bitcast<f32>(s[13]),
        bitcast<f32>(s[14]),
        info,
    );
}

fn to_stacked(p: Piece) -> Stacked {
    let a = bitcast<vec3<u32>>(p.a);
    let b = bitcast<vec3<u32>>(p.b);
    let c = bitcast<vec3<u32>>(p.c);
    let d = bitcast<vec3<u32>>(select(p.limits.xyw, p.d, (p.info & QUAD_FLAG) != 0u));
    let plane = bitcast<vec2<u32>>(vec2<f32>(p.slant, p.lean));
    let sides = pack2x16float(p.limits.xz);
    return Stacked(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z, sides, plane.x, plane.y, p.info);
}

fn push(piece: Piece) {
    stack[atomicAdd(&stack_size, 1u)] = to_stacked(piece);
}

// Hands a piece on to the second time; false if there is no room.
fn hand_on(hemisphere: u32, piece: Piece) -> bool {
    let place = atomicAdd(&arguments[job].parts[hemisphere], 1u);
    if place >= PART_CAPACITY {
        return false;
    }
    parts[parts_start(hemisphere) + place] = to_stacked(piece);
    return true;
}

// Where a hemisphere's parts begin.
fn parts_start(hemisphere: u32) -> u32 {
    return PART_CAPACITY * (2u * job + hemisphere);
}

fn list_place(hemisphere: u32, place: u32) -> u32 {
    return 3u * (list_start(hemisphere) + view.list_capacity - 1u - place);
}

fn whole_triangle(hemisphere: u32, place: u32) -> Piece {
    let at = list_place(hemisphere, place);
    let culls = select(0u, 1u, (lists[at + 1u] & CULL_FLAG) != 0u) | select(0u, 2u, (lists[at + 2u] & CULL_FLAG) != 0u);
    let a = relative_position(lists[at] & VERTEX_MASK);
    let b = relative_position(lists[at + 1u] & VERTEX_MASK);
    let c = relative_position(lists[at + 2u] & VERTEX_MASK);
    let e = b - a;
    let f = c - a;
    let normal = cross(e, f);
    let area = length(normal);
    let plane_distance = dot(normal, a);
    let normal_z = hemisphere_space(normal, hemisphere).z;
    // The normal of a sliver is noise.
    let known = area > 1e-3 * length(e) * length(f);
    let slant = select(1.0, abs(normal_z) / area, known);
    let lean = select(0.0, normal_z / plane_distance, known && plane_distance != 0.0);
    return Piece(a, b, c, c, vec4<f32>(), slant, lean, place | (culls << 22u));
}

fn relative_position(vertex: u32) -> vec3<f32> {
    return vertices[vertex].position - view.position;
}

// Pushes the parts of a piece; or returns true if it is to be drawn, with the shifts of its corners.
fn cut(piece: Piece, hemisphere: u32, shift: ptr<function, vec3<f32>>) -> bool {
    let x = hemisphere_space(piece.a, hemisphere);
    let y = hemisphere_space(piece.b, hemisphere);
    let z = hemisphere_space(piece.c, hemisphere);
    let o = hemisphere_space(piece.d, hemisphere);
    let a = project_corner(x);
    let b = project_corner(y);
    let c = project_corner(z);
    let d = project_corner(o);
    // A triangle with a corner in the light itself is seen edge-on and covers nothing.
    let through_light = all(piece.a == vec3<f32>()) || all(piece.b == vec3<f32>()) || all(piece.c == vec3<f32>());
    if through_light || (is_outside(a, b, c) && is_outside(a, c, d)) {
        return false;
    }
    let level = (piece.info >> LEVEL_SHIFT) & 15u;
    let is_quad = (piece.info & QUAD_FLAG) != 0u;
    let excess = vec4<f32>(
        edge_excess(a.xy, b.xy, edge_slant(x, y), piece.limits.x),
        edge_excess(b.xy, c.xy, edge_slant(y, z), piece.limits.y),
        edge_excess(c.xy, d.xy, edge_slant(z, o), piece.limits.z),
        edge_excess(d.xy, a.xy, edge_slant(o, x), piece.limits.w),
    );
    let cuts = select(vec4<u32>(), vec4<u32>(1u, 2u, 4u, 8u), excess > vec4<f32>(1.0));
    let edges = cuts.x | cuts.y | cuts.z | cuts.w;
    if !is_quad && (edges == 0u || level == MOST_LEVELS) {
        let cull = select(0.0, 1.0, (piece.info & (1u << 22u)) != 0u) - select(0.0, 1.0, (piece.info & (2u << 22u)) != 0u);
        // Pieces of masked triangles have room for one shift only.
        let flat = select(sliver_shifts(a, b, c), vec3<f32>(), is_masked_job());
        *shift = select(vec3<f32>(depth_shift(piece, a, b, c)), flat, any(flat != vec3<f32>()));
        return !(is_culled(a.xy, b.xy, c.xy, cull) || (REJECT && is_between_texels(a.xy, b.xy, c.xy)));
    }
    let big = COARSE && max(max(excess.x, excess.y), max(excess.z, excess.w)) > BIG;
    if COARSE && !big && (piece.info & PART_FLAG) != 0u && hand_on(hemisphere, piece) {
        return false;
    }
    var rest = piece;
    rest.info = (piece.info & ~(QUAD_FLAG | PART_FLAG)) | select(0u, PART_FLAG, big);
    if is_quad {
        push_quad_parts(rest, edges == 5u && level < MOST_LEVELS, hemisphere);
    } else {
        push_parts(rest, (edges & 3u) | ((edges >> 1u) & 4u), hemisphere);
    }
    return false;
}

// How far edges inside of a piece may bend.
fn inner_limit(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, slant: f32) -> f32 {
    // Sines of the angles as seen from the light.
    let ab = normalize(cross(a, b));
    let bc = normalize(cross(b, c));
    let ca = normalize(cross(c, a));
    let sine = min(length(cross(ab, bc)), min(length(cross(bc, ca)), length(cross(ca, ab))));
    let flat = view.tolerance / max(slant, 1e-6);
    let shape = SHAPE * sine * sqrt(view.tolerance * view.texels);
    let limit = max(view.tolerance, min(min(flat, shape), view.longest_bend));
    // As much of it as a half holds, since quadrilaterals keep it in one. (Drivers take packing and unpacking for nothing.)
    return bitcast<f32>(bitcast<u32>(limit) & 0xffffe000u);
}

fn height_of(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>) -> f32 {
    let e = b - a;
    let f = c - b;
    let g = a - c;
    let longest = max(dot(e, e), max(dot(f, f), dot(g, g)));
    return abs(e.x * g.y - e.y * g.x) / sqrt(longest);
}

// How many times the bend that it may have an edge has. How far parts of a triangle's own edges may bend is a function of the
// two ends alone, the same from both sides. As far as they curve, chords miss them by the bend; depth along them is off by
// the bend too, as far as they are across the axis.
fn edge_excess(a: vec2<f32>, b: vec2<f32>, slant: f32, inner: f32) -> f32 {
    let outline = view.tolerance / max(slant, dp_edge_curvature(a, b) / OUTLINE_SHARE);
    return dp_edge_bend(a, b, view.texels) / min(select(inner, outline, inner == 0.0), view.longest_bend);
}

// What is added to 1/w of a piece. Interpolated linearly, 1/w is off by N.z/(2 D) times |p|^2 less its own interpolation,
// which is 0 at the corners and goes as far as the circle through them: all to one side, which the sign of N.z/D says.
// Where that is toward the light, it is taken back, so that it makes no acne. Where it is away, it is moved toward the
// light by half, or by half of what the lookup's bias covers, so that less light leaks.
fn depth_shift(piece: Piece, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let e = b.xy - a.xy;
    let f = c.xy - b.xy;
    let g = a.xy - c.xy;
    let squares = vec3<f32>(dot(e, e), dot(f, f), dot(g, g));
    let longest = max(squares.x, max(squares.y, squares.z));
    let area = e.x * g.y - e.y * g.x;
    // Of an obtuse triangle only a part of the circle is inside: half the longest edge is as far as it goes.
    let circle = squares.x * squares.y * squares.z / (4.0 * area * area);
    let obtuse = 2.0 * longest >= squares.x + squares.y + squares.z;
    let farthest = select(min(circle, longest / 3.0), 0.25 * longest, obtuse);
    let limit = 0.25 / max(abs(a.z), max(abs(b.z), abs(c.z)));
    let thickness = height_of(a.xy, b.xy, c.xy) / (0.125 * longest) - 1.0;
    let thin = clamp(thickness / select(THICK_AWAY, THICK_TOWARD, piece.lean > 0.0), 0.0, 1.0);
    let toward = min(0.5 * farthest, 0.5 * view.tolerance / (view.texels * max(piece.slant, 1e-6)));
    let shift = 0.5 * piece.lean * select(farthest, toward, piece.lean > 0.0) * thin;
    return clamp(shift, -limit, limit);
}

// Pushes the parts of a triangle; bits 0, 1 and 2 of `edges` say which are cut.
fn push_parts(piece: Piece, edges: u32, hemisphere: u32) {
    // Turned so that the first edge is cut, and the second too if two are.
    var a = piece.a;
    var b = piece.b;
    var c = piece.c;
    var outer = piece.limits.xyw;
    if edges == 2u || edges == 6u {
        a = piece.b;
        b = piece.c;
        c = piece.a;
        outer = outer.yzx;
    } else if edges == 4u || edges == 5u {
        a = piece.c;
        b = piece.a;
        c = piece.b;
        outer = outer.zxy;
    }
    let inner = inner_limit(a, b, c, piece.slant);
    let info = piece.info + (1u << LEVEL_SHIFT);
    let ab = dp_bisect(a, b);
    if countOneBits(edges) == 1u {
        push_triangle(piece, info, a, ab, c, vec3<f32>(outer.x, inner, outer.z));
        push_triangle(piece, info, ab, b, c, vec3<f32>(outer.xy, inner));
        return;
    }
    let bc = dp_bisect(b, c);
    push_triangle(piece, info, ab, b, bc, vec3<f32>(outer.xy, inner));
    if countOneBits(edges) == 2u {
        if is_short(ab, bc, inner, hemisphere) {
            push_quad(piece, info, a, ab, bc, c, outer.xy);
        } else {
            push_triangle(piece, info, a, ab, bc, vec3<f32>(outer.x, inner, inner));
            push_triangle(piece, info, a, bc, c, vec3<f32>(inner, outer.yz));
        }
        return;
    }
    let ca = dp_bisect(c, a);
    push_triangle(piece, info, a, ab, ca, vec3<f32>(outer.x, inner, outer.z));
    push_triangle(piece, info, ca, bc, c, vec3<f32>(inner, outer.yz));
    push_triangle(piece, info, ab, bc, ca, vec3<f32>(inner));
}

// Pushes the parts of a quadrilateral, cut across if both long sides are to be cut; else it becomes two triangles.
fn push_quad_parts(piece: Piece, across: bool, hemisphere: u32) {
    let inner = min(
        inner_limit(piece.a, piece.b, piece.c, piece.slant),
        inner_limit(piece.a, piece.c, piece.d, piece.slant),
    );
    let ab = dp_bisect(piece.a, piece.b);
    let cd = dp_bisect(piece.c, piece.d);
    if across && is_short(ab, cd, inner, hemisphere) {
        let info = piece.info + (1u << LEVEL_SHIFT);
        push_quad(piece, info, piece.a, ab, cd, piece.d, piece.limits.xz);
        push_quad(piece, info, ab, piece.b, piece.c, cd, piece.limits.xz);
        return;
    }
    push_triangle(piece, piece.info, piece.a, piece.b, piece.c, vec3<f32>(piece.limits.xy, inner));
    push_triangle(piece, piece.info, piece.a, piece.c, piece.d, vec3<f32>(inner, piece.limits.zw));
}

// Whether a cut between two points is short enough that it is never cut itself.
fn is_short(p: vec3<f32>, q: vec3<f32>, limit: f32, hemisphere: u32) -> bool {
    let bend = dp_edge_bend(
        dp_project(hemisphere_space(p, hemisphere)),
        dp_project(hemisphere_space(q, hemisphere)),
        view.texels,
    );
    return bend < SHORT_SHARE * limit;
}

// Pushes a triangle of the same plane as `whole`.
fn push_triangle(whole: Piece, info: u32, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, limits: vec3<f32>) {
    push(Piece(a, b, c, c, vec4<f32>(limits.xy, 0.0, limits.z), whole.slant, whole.lean, info));
}

// The same for a quadrilateral whose sides from a and from c on have `limits`.
fn push_quad(
    whole: Piece,
    info: u32,
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
    limits: vec2<f32>,
) {
    push(Piece(a, b, c, d, vec4<f32>(limits.x, NEVER, limits.y, NEVER), whole.slant, whole.lean, info | QUAD_FLAG));
}

// Room for `count` pieces: where they go. Pieces from the capacity on have no room.
fn reserve(hemisphere: u32, count: u32) -> u32 {
    if count == 0u {
        return 0u;
    }
    let base = atomicAdd(&arguments[job].pieces_wanted[hemisphere], count);
    atomicMax(&arguments[job].pieces[hemisphere].vertex_count, 3u * min(base + count, view.piece_capacity));
    return base;
}

fn write_leaf(hemisphere: u32, place: u32, piece: Piece, shift: vec3<f32>) {
    if place >= view.piece_capacity {
        mark_overflow(hemisphere, piece.info & 0x3fffffu);
        return;
    }
    let at = 3u * (view.first_piece + view.piece_capacity * hemisphere + place);
    // The triangle's number in the lists is below 2^24, so a float holds it.
    let number = f32(list_place(hemisphere, piece.info & 0x3fffffu) / 3u);
    pieces[at] = vec4<f32>(piece.a, shift.x);
    pieces[at + 1u] = vec4<f32>(piece.b, select(shift.y, number, is_masked_job()));
    pieces[at + 2u] = vec4<f32>(piece.c, shift.z);
}

// The whole triangle is drawn exactly, besides the pieces of it that had room.
fn mark_overflow(hemisphere: u32, place: u32) {
    lists[list_place(hemisphere, place)] |= OVERFLOW_FLAG;
    atomicMax(&arguments[job].exact[hemisphere].vertex_count, 4u);
    atomicMax(&arguments[job].exact[hemisphere].instance_count, place + 1u);
}
