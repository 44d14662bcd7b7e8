// Split: cuts triangles whose edges bend too much in the map until no chord's bend is above the tolerance. A
// workgroup works on a stack of pieces in its own memory; an edge is cut where the bisector of its angle at the light
// meets it, and whether it is cut depends on its two ends alone.
//
// Twice: the first time (COARSE) over the route's triangles, where parts of big ones are handed on once they are
// middling, so that the second time all workgroups have a share of a wall that fills the view.

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read_write> arguments: Arguments;
@group(0) @binding(2) var<storage, read_write> lists: array<u32>;
@group(0) @binding(3) var<storage, read> positions: array<f32>;
// Corners relative to the light, nine numbers a piece; a part for each hemisphere.
@group(0) @binding(4) var<storage, read_write> pieces: array<f32>;
// Middling parts of big triangles, their corners and then their info; a part for each hemisphere.
@group(0) @binding(5) var<storage, read_write> parts: array<array<u32, 10>>;

override COARSE: bool = true;

override THREADS: u32 = 64u;
const STACK: u32 = 384u;
// Cuts from a triangle to its smallest piece. Each halves the angle of an edge, so 8 would do; the rest is for edges
// that come out of a cut longer than they would need.
const MOST_LEVELS: u32 = 15u;
// Room to finish one piece at a time, depth first, when the stack is nearly full.
const RESERVE: u32 = 3u * MOST_LEVELS;
// A piece is big if an edge has more than this many times the tolerable bend: it makes some hundred pieces or more.
const BIG: f32 = 64.0;
// Parts that a hemisphere has room for; what finds none is cut where it is.
const PART_CAPACITY: u32 = 16384u;

struct Piece {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    // Bits 0-21 the place in the list, 22-23 the cull flags, 24-26 the edges that are not to be cut, 27-30 the level,
    // 31 whether it is part of a big piece.
    info: u32,
}

const PART_FLAG: u32 = 0x80000000u;

var<workgroup> stack: array<array<f32, 9>, STACK>;
var<workgroup> stack_info: array<u32, STACK>;
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
    let hemisphere = group.y;
    if thread == 0u {
        atomicStore(&stack_size, 0u);
        atomicStore(&leaf_count, 0u);
        if COARSE {
            size = atomicLoad(&arguments.to_split[hemisphere]);
        } else {
            size = min(atomicLoad(&arguments.parts[hemisphere]), PART_CAPACITY);
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
                push(read_part(hemisphere, place));
            }
        }
        work(hemisphere, thread);
    }
}

// Empties the stack. Every cut halves an edge's angle and no piece is cut more than MOST_LEVELS times, so this ends.
fn work(hemisphere: u32, thread: u32) {
    var leaf: Piece;
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
            write_leaf(hemisphere, leaf_base + place, leaf);
            is_leaf = false;
        }
        if on_stack == 0u {
            break;
        }
        // As many as their children surely have room for.
        let room = (STACK - RESERVE - min(on_stack, STACK - RESERVE)) / 3u;
        let taken = min(min(on_stack, THREADS), max(room, 1u));
        if thread < taken {
            leaf = read_stack(on_stack - 1u - thread);
        }
        if thread == 0u {
            atomicStore(&stack_size, on_stack - taken);
        }
        workgroupBarrier();
        if thread < taken && cut(leaf, hemisphere) {
            is_leaf = true;
            place = atomicAdd(&leaf_count, 1u);
        }
    }
}

fn read_stack(at: u32) -> Piece {
    return Piece(
        vec3<f32>(stack[at][0], stack[at][1], stack[at][2]),
        vec3<f32>(stack[at][3], stack[at][4], stack[at][5]),
        vec3<f32>(stack[at][6], stack[at][7], stack[at][8]),
        stack_info[at],
    );
}

fn push(piece: Piece) {
    let at = atomicAdd(&stack_size, 1u);
    stack[at] = corner_list(piece);
    stack_info[at] = piece.info;
}

fn corner_list(p: Piece) -> array<f32, 9> {
    return array<f32, 9>(p.a.x, p.a.y, p.a.z, p.b.x, p.b.y, p.b.z, p.c.x, p.c.y, p.c.z);
}

fn read_part(hemisphere: u32, place: u32) -> Piece {
    let part = parts[PART_CAPACITY * hemisphere + place];
    return Piece(
        bitcast<vec3<f32>>(vec3<u32>(part[0], part[1], part[2])),
        bitcast<vec3<f32>>(vec3<u32>(part[3], part[4], part[5])),
        bitcast<vec3<f32>>(vec3<u32>(part[6], part[7], part[8])),
        part[9],
    );
}

// Hands a piece on to the second time; false if there is no room.
fn hand_on(hemisphere: u32, piece: Piece) -> bool {
    let place = atomicAdd(&arguments.parts[hemisphere], 1u);
    if place >= PART_CAPACITY {
        return false;
    }
    let a = bitcast<vec3<u32>>(piece.a);
    let b = bitcast<vec3<u32>>(piece.b);
    let c = bitcast<vec3<u32>>(piece.c);
    parts[PART_CAPACITY * hemisphere + place] = array<u32, 10>(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, piece.info);
    return true;
}

fn list_place(hemisphere: u32, place: u32) -> u32 {
    return 3u * (view.list_capacity * (hemisphere + 1u) - 1u - place);
}

fn whole_triangle(hemisphere: u32, place: u32) -> Piece {
    let at = list_place(hemisphere, place);
    let a = lists[at];
    let b = lists[at + 1u];
    let c = lists[at + 2u];
    let edges = (a >> 31u) | ((b >> 31u) << 1u) | ((c >> 31u) << 2u);
    let culls = select(0u, 1u, (b & CULL_FLAG) != 0u) | select(0u, 2u, (c & CULL_FLAG) != 0u);
    return Piece(
        relative_position(a & VERTEX_MASK),
        relative_position(b & VERTEX_MASK),
        relative_position(c & VERTEX_MASK),
        place | (culls << 22u) | ((edges ^ 7u) << 24u),
    );
}

fn relative_position(vertex: u32) -> vec3<f32> {
    let at = 3u * vertex;
    return vec3<f32>(positions[at], positions[at + 1u], positions[at + 2u]) - view.position;
}

fn corner(relative: vec3<f32>, hemisphere: u32) -> vec3<f32> {
    return project_corner(dp_to_hemisphere(light_space(relative), hemisphere == 1u));
}

// Pushes the parts of a piece, or returns true if it is to be drawn.
fn cut(piece: Piece, hemisphere: u32) -> bool {
    let a = corner(piece.a, hemisphere);
    let b = corner(piece.b, hemisphere);
    let c = corner(piece.c, hemisphere);
    // A triangle with a corner in the light itself is seen edge-on and covers nothing.
    let through_light = all(piece.a == vec3<f32>()) || all(piece.b == vec3<f32>()) || all(piece.c == vec3<f32>());
    if through_light || is_outside(a, b, c) {
        return false;
    }
    let level = (piece.info >> 27u) & 15u;
    // What the route has decided about the edges of whole triangles stands: another shader may round another way, and
    // the neighbour may not have come here.
    let kept = (piece.info >> 24u) & 7u;
    var edges = kept ^ 7u;
    if level > 0u {
        edges &= edges_to_split(a.xy, b.xy, c.xy);
    }
    if edges == 0u || level == MOST_LEVELS {
        let cull = select(0.0, 1.0, (piece.info & (1u << 22u)) != 0u) - select(0.0, 1.0, (piece.info & (2u << 22u)) != 0u);
        return !(is_culled(a.xy, b.xy, c.xy, cull) || (REJECT && is_between_texels(a.xy, b.xy, c.xy)));
    }
    let big = COARSE && is_big(a.xy, b.xy, c.xy);
    if COARSE && !big && (piece.info & PART_FLAG) != 0u && hand_on(hemisphere, piece) {
        return false;
    }
    push_parts(piece, edges, big);
    return false;
}

fn is_big(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>) -> bool {
    let e = b - a;
    let f = c - b;
    let g = a - c;
    return 0.125 * view.texels * max(dot(e, e), max(dot(f, f), dot(g, g))) > BIG * view.tolerance;
}

fn push_parts(piece: Piece, edges: u32, big: bool) {
    // Turned so that the first edge is cut, and the second too if two are.
    var a = piece.a;
    var b = piece.b;
    var c = piece.c;
    var kept = (piece.info >> 24u) & 7u;
    if edges == 2u || edges == 6u {
        a = piece.b;
        b = piece.c;
        c = piece.a;
        kept = (kept >> 1u) | ((kept & 1u) << 2u);
    } else if edges == 4u || edges == 5u {
        a = piece.c;
        b = piece.a;
        c = piece.b;
        kept = ((kept << 1u) & 7u) | (kept >> 2u);
    }
    let level = ((piece.info >> 27u) & 15u) + 1u;
    let info = (piece.info & 0xffffffu) | (level << 27u) | select(0u, PART_FLAG, big);
    let second = (kept & 2u) << 24u;
    let third = (kept & 4u) << 24u;
    let cuts = countOneBits(edges);
    let ab = dp_bisect(a, b);
    let bc = dp_bisect(b, c);
    let ca = dp_bisect(c, a);
    push(Piece(a, ab, select(select(bc, ca, cuts == 3u), c, cuts == 1u), info | select(0u, third, cuts == 1u)));
    push(Piece(ab, b, select(bc, c, cuts == 1u), info | select(0u, second, cuts == 1u)));
    if cuts >= 2u {
        push(Piece(select(a, ca, cuts == 3u), bc, c, info | select(0u, third, cuts == 2u)));
    }
    if cuts == 3u {
        push(Piece(ab, bc, ca, info));
    }
}

// Room for `count` pieces: where they go. Pieces from the capacity on have no room.
fn reserve(hemisphere: u32, count: u32) -> u32 {
    if count == 0u {
        return 0u;
    }
    let base = atomicAdd(&arguments.pieces_wanted[hemisphere], count);
    atomicMax(&arguments.pieces[hemisphere].vertex_count, 3u * min(base + count, view.piece_capacity));
    return base;
}

fn write_leaf(hemisphere: u32, place: u32, piece: Piece) {
    if place >= view.piece_capacity {
        mark_overflow(hemisphere, piece.info & 0x3fffffu);
        return;
    }
    let at = 9u * (view.piece_capacity * hemisphere + place);
    let values = corner_list(piece);
    for (var i = 0u; i < 9u; i += 1u) {
        pieces[at + i] = values[i];
    }
}

// The whole triangle is drawn exactly, besides the pieces of it that had room.
fn mark_overflow(hemisphere: u32, place: u32) {
    lists[list_place(hemisphere, place)] |= OVERFLOW_FLAG;
    atomicMax(&arguments.exact[hemisphere].vertex_count, 4u);
    atomicMax(&arguments.exact[hemisphere].instance_count, place + 1u);
}
