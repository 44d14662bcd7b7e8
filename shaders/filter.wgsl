// Filters: shadows with softer edges than those of `dp_shadow`. Goes with lookup.wgsl, which declares what is read.
//
// All have one signature: `dp_shadow`'s arguments, and a `noise` from 0 to 1 that turns the spiral of those that take
// taps along one; 0 gives the same taps everywhere, a number that changes with pixel and frame suits temporal
// antialiasing. They may be called wherever `dp_shadow` may.

// Twins of the kinds in src/filter.rs.
const DP_SHARP: u32 = 0u;
const DP_HARD: u32 = 1u;
const DP_PCF3: u32 = 2u;
const DP_PCF5: u32 = 3u;
const DP_DISC: u32 = 4u;
const DP_SOFT: u32 = 5u;

// Widest kernel, as the angle between its middle and its rim at the light: 20 degrees.
const DP_WIDEST: f32 = 0.34906585;
// Four times the variance of bilinear weights along an axis, in texels: that of a disc is a quarter of its radius squared.
const DP_TENT: f32 = 0.6666667;
// Share of light that doesn't count at the dark middle of a penumbra that would be twice as wide as the widest kernel: a few
// taps at the kernel's rim, far beside the receiver, past which something else is likely to be in the way.
const DP_FAINT: f32 = 0.125;
// Between neighbours of a spiral: the golden angle.
const DP_GOLDEN_ANGLE: f32 = 2.3999632;
const DP_TURN: f32 = 6.2831853;

// By the light's own filter.
fn dp_shadow_filtered(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>, noise: f32) -> f32 {
    return dp_shadow_with(light, position, normal, view, noise, dp_lights[light].filtering);
}

// `dp_shadow` decided for light or darkness: the sharpest edge that the maps give.
fn dp_shadow_hard(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>, noise: f32) -> f32 {
    return dp_shadow_with(light, position, normal, view, noise, DpFilter(DP_HARD, 0.0, 0u));
}

// The mean over 3 x 3 texels around the receiver.
fn dp_shadow_pcf3(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>, noise: f32) -> f32 {
    return dp_shadow_with(light, position, normal, view, noise, DpFilter(DP_PCF3, 0.0, 0u));
}

// The mean over 5 x 5 texels around the receiver.
fn dp_shadow_pcf5(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>, noise: f32) -> f32 {
    return dp_shadow_with(light, position, normal, view, noise, DpFilter(DP_PCF5, 0.0, 0u));
}

// The mean over a disc of directions as wide as the light's `Filter::Disc` has it; else `dp_shadow`.
fn dp_shadow_disc(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>, noise: f32) -> f32 {
    return dp_shadow_with(light, position, normal, view, noise, dp_own_filter(light, DP_DISC));
}

// The share of a sphere of the radius that the light's `Filter::Soft` has; else `dp_shadow`.
fn dp_shadow_soft(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>, noise: f32) -> f32 {
    return dp_shadow_with(light, position, normal, view, noise, dp_own_filter(light, DP_SOFT));
}

// The light's settings of a kind of filter, of no size if it has another kind.
fn dp_own_filter(light: u32, kind: u32) -> DpFilter {
    let own = dp_lights[light].filtering;
    return DpFilter(kind, select(0.0, own.size, own.kind == kind), own.taps);
}

// By any filter, whatever the light's own.
fn dp_shadow_with(
    light: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    view: vec4<f32>,
    noise: f32,
    filtering: DpFilter,
) -> f32 {
    let receiver = dp_locate(light, position, normal);
    if dp_is_known(light, receiver) {
        return dp_known(light, receiver);
    }
    if filtering.kind == DP_PCF3 || filtering.kind == DP_PCF5 {
        return dp_sample_across(light, receiver, select(3u, 2u, filtering.kind == DP_PCF3));
    }
    let at = select(view, vec4<f32>(0.0), filtering.kind == DP_HARD);
    let sharp = dp_sample_sharp(light, position, normal, at, receiver);
    switch filtering.kind {
        case DP_HARD: {
            return step(0.5, sharp);
        }
        case DP_DISC: {
            return dp_sample_disc(light, receiver, sharp, noise, filtering);
        }
        case DP_SOFT: {
            return dp_sample_soft(light, receiver, sharp, noise, filtering);
        }
        default: {
            return sharp;
        }
    }
}

// `dp_sample_square`, blended with that of the other hemisphere within a texel of the seam, where one map's texels give
// way to the other's.
fn dp_sample_across(light: u32, receiver: DpReceiver, quads: u32) -> f32 {
    let own = dp_sample_square(light, receiver, quads);
    let inside = (1.0 - length(receiver.map)) * dp_lights[light].texels;
    if inside >= 1.0 || !dp_has_hemisphere(light, !receiver.back) {
        return own;
    }
    return mix(dp_sample_square(light, dp_turned(receiver), quads), own, 0.5 + 0.5 * max(inside, 0.0));
}

// The votes of `2 quads` x `2 quads` texels around the receiver, weighted as if a square of one texel less each way
// were cut out of them around it.
fn dp_sample_square(light: u32, receiver: DpReceiver, quads: u32) -> f32 {
    let at = dp_texel_position(light, receiver.map);
    let base = floor(at);
    let f = at - base;
    let last = quads - 1u;
    let footprint = dp_footprint(light, receiver.map);
    let plane = dp_plane(light, receiver);
    let judge = dp_judge(light, receiver);
    // Past the guard band there is nothing to be read.
    let end = 0.5 * dp_lights[light].resolution / dp_lights[light].texels;
    let bounds = dp_bounds(judge, footprint);
    var all_lit = length(receiver.map) + 1.5 * f32(quads) / dp_lights[light].texels < end;
    var all_dark = all_lit;
    for (var y = 0u; y < quads; y++) {
        for (var x = 0u; x < quads; x++) {
            let corner = base - f32(last) + 2.0 * vec2<f32>(f32(x), f32(y));
            let texels = dp_gather(light, receiver.back, corner);
            let depths = dp_plane_depths(plane, texels.u, texels.v);
            all_lit &= all(texels.stored <= bounds.lit * depths);
            all_dark &= all(texels.stored >= bounds.dark * depths);
        }
    }
    if all_lit || all_dark {
        return select(0.0, 1.0, all_lit);
    }
    var lit = 0.0;
    var dark = 0.0;
    for (var y = 0u; y < quads; y++) {
        for (var x = 0u; x < quads; x++) {
            let corner = base - f32(last) + 2.0 * vec2<f32>(f32(x), f32(y));
            let texels = dp_gather(light, receiver.back, corner);
            let depths = dp_plane_depths(plane, texels.u, texels.v);
            let votes = dp_votes(judge, dp_margins(texels.stored, depths, footprint));
            let columns = vec2<f32>(select(1.0, 1.0 - f.x, x == 0u), select(1.0, f.x, x == last));
            let rows = vec2<f32>(select(1.0, 1.0 - f.y, y == 0u), select(1.0, f.y, y == last));
            let held = texels.u * texels.u + texels.v * texels.v <= vec4<f32>(end * end);
            let weights = select(vec4<f32>(0.0), columns.xyyx * rows.yyxx, held);
            lit += dot(weights, votes.lit);
            dark += dot(weights, votes.dark);
        }
    }
    let side = f32(quads + last);
    return dp_count(lit / (side * side), dark / (side * side));
}

// Directions around a receiver's: its own, and two at right angles to it and to each other, in its hemisphere's space.
struct DpFrame {
    ahead: vec3<f32>,
    across: vec3<f32>,
    up: vec3<f32>,
}

// Frisvad, "Building an Orthonormal Basis from a 3D Unit Vector Without Normalization" (2012), whose one singularity is
// the axis behind. The back's frame is turned so that both agree at the seam, and spirals stay as they are across it.
fn dp_frame(receiver: DpReceiver) -> DpFrame {
    let d = normalize(receiver.position);
    let s = 1.0 / (1.0 + d.z);
    let across = vec3<f32>(1.0 - d.x * d.x * s, -d.x * d.y * s, -d.x);
    let up = vec3<f32>(-d.x * d.y * s, 1.0 - d.y * d.y * s, -d.y);
    let around = dot(d.xy, d.xy);
    if !receiver.back || around < 1e-20 {
        return DpFrame(d, across, up);
    }
    // Twice the angle around the axis.
    let turn = vec2<f32>(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y) / around;
    return DpFrame(d, turn.x * across + turn.y * up, turn.x * up - turn.y * across);
}

// The direction number `tap` of a spiral, at an angle to the receiver's that is given by sine and cosine.
fn dp_spiral(frame: DpFrame, tap: u32, noise: f32, angle: vec2<f32>) -> vec3<f32> {
    let turn = DP_GOLDEN_ANGLE * f32(tap) + DP_TURN * noise;
    return angle.y * frame.ahead + angle.x * (cos(turn) * frame.across + sin(turn) * frame.up);
}

// Sine and cosine of the angle of the tap number `tap` of `taps` that fill a disc of directions evenly (Vogel's spiral),
// by the sine of half the disc's radius: the area of a cap grows with the square of that.
fn dp_disc_angle(tap: u32, taps: u32, rim: f32) -> vec2<f32> {
    let half_sine = rim * sqrt((f32(tap) + 0.5) / f32(taps));
    return vec2<f32>(2.0 * half_sine * sqrt(1.0 - half_sine * half_sine), 1.0 - 2.0 * half_sine * half_sine);
}

// What the four texels around a direction say.
struct DpTap {
    // Their bilinear weights.
    weights: vec4<f32>,
    votes: DpVotes,
    // As in lookup.wgsl.
    margins: vec4<f32>,
    // The receiver's distance from the light over that of what they hold; 0 if that is nothing.
    nearness: vec4<f32>,
}

// What taps need of a receiver.
struct DpProbe {
    back: bool,
    // As the maps of its own hemisphere and of the other one have it.
    plane: DpPlane,
    turned: DpPlane,
    judge: DpJudge,
    // Its distance from the light over the light's near limit.
    distance: f32,
}

fn dp_probe(light: u32, receiver: DpReceiver) -> DpProbe {
    let turned = dp_plane(light, dp_turned(receiver));
    let distance = receiver.distance / dp_lights[light].near;
    return DpProbe(receiver.back, dp_plane(light, receiver), turned, dp_judge(light, receiver), distance);
}

// The four texels around a direction, and what the receiver's plane is there.
struct DpPlace {
    around: DpNeighbours,
    depths: vec4<f32>,
    footprint: f32,
    // There is no such hemisphere, and everything in it counts as dark.
    missing: bool,
}

// The texels around any direction, of length 1, of the receiver's hemisphere space, in the map of the hemisphere that it
// lies in.
fn dp_place(light: u32, probe: DpProbe, direction: vec3<f32>) -> DpPlace {
    let crosses = direction.z < 0.0;
    let back = probe.back != crosses;
    var plane = probe.plane;
    if crosses {
        plane = probe.turned;
    }
    let local = dp_to_hemisphere(direction, crosses);
    let map = local.xy * (1.0 / (1.0 + local.z));
    let around = dp_neighbours(light, back, map);
    let depths = dp_plane_depths(plane, around.texels.u, around.texels.v);
    return DpPlace(around, depths, dp_footprint(light, map), !dp_has_hemisphere(light, back));
}

// Whether nothing at a place votes against.
fn dp_is_clear(probe: DpProbe, place: DpPlace) -> bool {
    let bounds = dp_bounds(probe.judge, place.footprint);
    return !place.missing && all(place.around.texels.stored <= bounds.lit * place.depths);
}

// Whether everything at a place votes against in full.
fn dp_is_blocked(probe: DpProbe, place: DpPlace) -> bool {
    let bounds = dp_bounds(probe.judge, place.footprint);
    return place.missing || all(place.around.texels.stored >= bounds.dark * place.depths);
}

fn dp_tap(probe: DpProbe, place: DpPlace) -> DpTap {
    let margins = dp_margins(place.around.texels.stored, place.depths, place.footprint);
    var votes = dp_votes(probe.judge, margins);
    if place.missing {
        votes = DpVotes(vec4<f32>(0.0), vec4<f32>(1.0));
    }
    return DpTap(place.around.weights, votes, margins, dp_nearness(probe, place.around.texels));
}

// The receiver as the other hemisphere has it.
fn dp_turned(receiver: DpReceiver) -> DpReceiver {
    let position = dp_to_hemisphere(receiver.position, true);
    let normal = dp_to_hemisphere(receiver.normal, true);
    let w = dp_homogeneous_w(position);
    return DpReceiver(position, normal, !receiver.back, receiver.distance, w, dp_project(position));
}

fn dp_nearness(probe: DpProbe, texels: DpTexels) -> vec4<f32> {
    // The ray that has w = 1 is (1 + r^2)/2 long.
    let lengths = 0.5 + 0.5 * (texels.u * texels.u + texels.v * texels.v);
    return texels.stored * probe.distance / lengths;
}

// Votes for light in a disc of directions; `reach` is the margin of the receiver's own surface at the disc's rim, if that
// curves by as much as the disc is wide. Where the receiver's surface ends within the disc,
// what is behind its plane is seen past it. A receiver that the light's middle reaches (`centre` 1) sees the light
// there too. One that it doesn't may be on the dark side of an object, so there only what is as near the plane as the
// disc is wide counts, which may be the same surface, curved.
fn dp_lit_in_disc(tap: DpTap, reach: f32, centre: f32) -> vec4<f32> {
    let near_plane = clamp(2.0 + tap.margins * (1.0 / reach), vec4<f32>(0.0), vec4<f32>(1.0));
    let past_end = mix(near_plane, vec4<f32>(1.0), centre);
    return select(vec4<f32>(0.0), past_end, tap.votes.dark == vec4<f32>(0.0));
}

// The mean over a disc of directions; `sharp` is what the middle has.
fn dp_sample_disc(light: u32, receiver: DpReceiver, sharp: f32, noise: f32, filtering: DpFilter) -> f32 {
    let radius = filtering.size / dp_footprint(light, receiver.map);
    if radius < 0.5 {
        return sharp;
    }
    let centre = dp_sample_bilinear(light, receiver);
    let probe = dp_probe(light, receiver);
    let frame = dp_frame(receiver);
    let rim = sin(0.5 * min(filtering.size, DP_WIDEST));
    var lit = 0.0;
    var dark = 0.0;
    for (var i = 0u; i < filtering.taps; i++) {
        let angle = dp_disc_angle(i, filtering.taps, rim);
        let place = dp_place(light, probe, dp_spiral(frame, i, noise, angle));
        if centre == 1.0 && dp_is_clear(probe, place) {
            lit += 1.0;
        } else if dp_is_blocked(probe, place) {
            dark += 1.0;
        } else {
            let tap = dp_tap(probe, place);
            lit += dot(tap.weights, dp_lit_in_disc(tap, radius * probe.judge.spread, centre));
            dark += dot(tap.weights, tap.votes.dark);
        }
    }
    return dp_count(lit / f32(filtering.taps), dark / f32(filtering.taps));
}

// The share of a sphere around the light that the receiver sees (contact hardening). What a texel holds at the angle t
// from the receiver, `nearness` times as near to the light, stands before the sphere for the receiver if
// sin t <= size (nearness - cos t), with the sphere's radius over the receiver's distance as its size. So a search
// finds how wide a disc of directions has what stands before the sphere, and that disc is filtered. What stands
// elsewhere, as the wall beside a floor does, says nothing about the sphere. Penumbras narrower than a texel are those of
// `sharp`.
fn dp_sample_soft(light: u32, receiver: DpReceiver, sharp: f32, noise: f32, filtering: DpFilter) -> f32 {
    let size = filtering.size / max(receiver.distance, 1e-30);
    let footprint = dp_footprint(light, receiver.map);
    let probe = dp_probe(light, receiver);
    let around = dp_neighbours(light, receiver.back, receiver.map);
    let depths = dp_plane_depths(probe.plane, around.texels.u, around.texels.v);
    let votes = dp_votes(probe.judge, dp_margins(around.texels.stored, depths, footprint));
    let nearness = dp_nearness(probe, around.texels);
    let blurred = dp_blurred(size / footprint, nearness);
    let hidden = around.weights * votes.dark;
    // What of the darkness at the middle is thrown by narrow penumbras: all, where the texels don't know.
    let narrow = 1.0 - dot(hidden, blurred) / max(dot(hidden, vec4<f32>(1.0)), 1e-6);
    let contact = (1.0 - sharp) * narrow;
    let centre = sharp;

    let frame = dp_frame(receiver);
    let hider = dot(hidden, nearness) / max(dot(hidden, vec4<f32>(1.0)), 1e-6);
    let blockers = dp_search(light, probe, frame, noise, size, footprint, hider, filtering.taps);
    let found = dp_found(hidden * blurred, nearness) + blockers.found;
    if found.x < 1e-4 {
        return 1.0 - contact;
    }
    let widest = dp_penumbra(size, 1.0 + found.x / found.y);
    // The four texels of a tap are a tent of their own: its variance is a part of the disc's.
    let disc = sqrt(max(widest * widest - DP_TENT * footprint * footprint, 0.0));
    let rim = sin(0.5 * disc);
    var lit = 0.0;
    var dark = 0.0;
    for (var i = 0u; i < filtering.taps; i++) {
        let angle = dp_disc_angle(i, filtering.taps, rim);
        let place = dp_place(light, probe, dp_spiral(frame, i, noise, angle));
        if centre == 1.0 && dp_is_clear(probe, place) {
            lit += 1.0;
            continue;
        }
        let tap = dp_tap(probe, place);
        let off = dp_off_middle(size, angle, tap.nearness);
        let before = clamp(5.0 - 4.0 * off, vec4<f32>(0.0), vec4<f32>(1.0));
        let blocked = tap.votes.dark * before * dp_blurred(size / footprint, tap.nearness);
        lit += dot(tap.weights, dp_lit_in_disc(tap, widest / footprint * probe.judge.spread, centre));
        dark += dot(tap.weights, blocked);
    }
    let share = dp_count(lit / f32(filtering.taps), dark / f32(filtering.taps));
    let faint = DP_FAINT * clamp(size * found.x / (DP_WIDEST * found.y) - 1.0, 0.0, 1.0) * (1.0 - centre);
    let soft = max(share - faint, 0.0) / (1.0 - faint);
    // Weights and mixtures may be more than 1 by rounding.
    let value = (1.0 - contact) * soft * min(mix(blockers.open, 1.0, centre), 1.0);
    let penumbra = dp_penumbra(size, hider);
    let narrower = clamp(3.0 - 4.0 * penumbra / widest, 0.0, 1.0) * (1.0 - centre);
    if value == 0.0 || narrower == 0.0 {
        return value;
    }
    let past_hider = dp_past_hider(light, probe, frame, noise, size, penumbra, filtering.taps);
    return min(value, mix(1.0, past_hider, narrower));
}

// The share of the sphere past what hides the receiver itself, by the disc that has that before the sphere. Where what else
// shows throws much wider penumbras, a disc that is wide enough for those may well reach past it.
fn dp_past_hider(
    light: u32,
    probe: DpProbe,
    frame: DpFrame,
    noise: f32,
    size: f32,
    penumbra: f32,
    taps: u32,
) -> f32 {
    let count = (taps + 3u) / 4u;
    let rim = sin(0.5 * penumbra);
    var dark = 0.0;
    for (var i = 0u; i < count; i++) {
        let angle = dp_disc_angle(i, count, rim);
        let tap = dp_tap(probe, dp_place(light, probe, dp_spiral(frame, i, noise, angle)));
        // Wider than the sphere, since what hides the receiver isn't all at one distance.
        let before = clamp(3.0 - dp_off_middle(size, angle, tap.nearness), vec4<f32>(0.0), vec4<f32>(1.0));
        dark += dot(tap.weights, tap.votes.dark * before);
    }
    return max(1.0 - dark / f32(count), 0.0);
}

// From 0 to 1 as the penumbra of what is so much nearer to the light than the receiver grows from half a texel to a whole one.
fn dp_blurred(size_in_texels: f32, nearness: vec4<f32>) -> vec4<f32> {
    return clamp(2.0 * size_in_texels * (nearness - 1.0) - 1.0, vec4<f32>(0.0), vec4<f32>(1.0));
}

// How far from the sphere's middle, in its radii, the receiver sees what a tap at an angle (sine and cosine) holds;
// large for what is behind.
fn dp_off_middle(size: f32, angle: vec2<f32>, nearness: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(angle.x) / max(size * (nearness - angle.y), vec4<f32>(1e-6));
}

// Angle of the disc of directions that has what stands before the sphere, so much nearer than the receiver.
fn dp_penumbra(size: f32, nearness: f32) -> f32 {
    // sin t + size cos t = size nearness
    let angle = asin(min(size * nearness * inverseSqrt(1.0 + size * size), 1.0)) - atan(size);
    return clamp(angle, 0.0, DP_WIDEST);
}

// The sum of blockers' weights, and that of the weights over what their penumbras are proportional to: the mean of
// several is nearer to the narrower ones, so that what throws a wide penumbra doesn't light what another keeps dark.
fn dp_found(weights: vec4<f32>, nearness: vec4<f32>) -> vec2<f32> {
    return vec2<f32>(dot(weights, vec4<f32>(1.0)), dot(weights, 1.0 / max(nearness - 1.0, vec4<f32>(1e-6))));
}

// What a search finds around a receiver.
struct DpBlockers {
    // A sum of `dp_found`.
    found: vec2<f32>,
    // Share of the receiver's surface in what shows first beside something that hides the receiver and is near the light. The
    // rest stands before that surface, or nothing shows.
    open: f32,
}

// How much nearer to the receiver than what hides it something must be, to be looked at behind it.
const DP_BEHIND_HIDER: f32 = 0.25;

// Looks for what may stand before the sphere. The taps are as many to each doubling of the angle, since what is far out
// has to be near the light, and large in angle, to matter.
fn dp_search(
    light: u32,
    probe: DpProbe,
    frame: DpFrame,
    noise: f32,
    size: f32,
    footprint: f32,
    hider: f32,
    taps: u32,
) -> DpBlockers {
    var result = DpBlockers(vec2<f32>(0.0), 0.0);
    var undecided = 1.0;
    for (var i = 0u; i < taps; i++) {
        let t = (f32(i) + 0.5) / f32(taps);
        let angle = vec2<f32>(sin(DP_WIDEST * t * t * t), cos(DP_WIDEST * t * t * t));
        let place = dp_place(light, probe, dp_spiral(frame, i, noise, angle));
        // What shows beside the hider matters only where there is one.
        if hider == 0.0 && dp_is_clear(probe, place) {
            continue;
        }
        let tap = dp_tap(probe, place);
        // Wider than what matters, since taps are few; the less it may matter, the less it counts.
        let off = dp_off_middle(size, angle, tap.nearness);
        let relevance = max(1.0 - 0.25 * off, vec4<f32>(0.0));
        let blockers = tap.weights * tap.votes.dark * (relevance * relevance) * (relevance * relevance);
        result.found += dp_found(blockers * dp_blurred(size / footprint, tap.nearness), tap.nearness);
        let is_behind = tap.nearness - 1.0 < vec4<f32>(DP_BEHIND_HIDER * (hider - 1.0));
        let behind = select(vec4<f32>(0.0), tap.weights * undecided, is_behind);
        // What the receiver sees at more than 45 degrees to its ray, as the wall at a crease, is beside it.
        let rises = vec4<f32>(angle.x) > tap.nearness - angle.y;
        let covered = dot(select(behind, vec4<f32>(0.0), rises), tap.votes.dark);
        let open = dot(behind, select(vec4<f32>(0.0), vec4<f32>(1.0), tap.votes.dark == vec4<f32>(0.0)));
        result.open += open;
        undecided -= covered + open;
    }
    return result;
}
