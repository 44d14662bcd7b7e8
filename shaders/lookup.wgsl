// Lookup: is a point lit? To be pasted into a renderer's shader, together with paraboloid.wgsl.

// How a light is filtered (filter.wgsl); twin of `FilterRecord` in src/filter.rs.
struct DpFilter {
    // One of DP_BILINEAR, DP_HARD, ...
    kind: u32,
    // Radius: of a disc in radians, of a soft light in world units.
    size: f32,
    taps: u32,
}

// A light as `PointShadows` describes it; twin of `LightRecord` in src/lookup.rs.
struct DpLight {
    // Rows of the rotation from world to light space.
    right: vec3<f32>,
    near: f32,
    up: vec3<f32>,
    range: f32,
    forward: vec3<f32>,
    // Texels per unit of map coordinates.
    texels: f32,
    position: vec3<f32>,
    // Bit 0 the front hemisphere, bit 1 the back; 0 for no light.
    hemispheres: u32,
    // How far depth may be off along a surface's normal, in texel footprints.
    tolerance: f32,
    filtering: DpFilter,
}

@group(DP_GROUP) @binding(0) var dp_maps: texture_depth_2d_array;
@group(DP_GROUP) @binding(1) var dp_sampler: sampler;
@group(DP_GROUP) @binding(2) var<storage, read> dp_lights: array<DpLight>;

// What a texel says about a receiver depends on its margin: how far its content stands before the receiver's plane,
// along the ray, in texel footprints. Content in the plane is the receiver's own surface, which the light reaches there:
// a vote for light. Content before it is in the way: a vote against. Content behind it says next to nothing: the
// receiver's surface ends before that texel, as it does all around the dark side of an object.

// Margin up to which content may be the receiver's own surface, for curvature finer than a texel and for the
// rasteriser's snapping. On top comes the tolerance along the receiver's normal, by which the depth that the hardware
// interpolates over a chord may be off. Less shows acne, more lets light in under contacts.
const DP_BIAS: f32 = 0.05;
// Margin beyond the bias with which content is in the way for certain. Less may as well be the other face of a crease.
const DP_RAMP: f32 = 0.5;
// Margin behind the plane that halves a vote for light.
const DP_FADE: f32 = 0.1;
// Votes that it takes: with fewer in all, darkness counts for less.
const DP_QUORUM: f32 = 0.02;
// Bounds of the plane's depth at a texel against the depth at the receiver: a plane seen nearly edge-on would
// otherwise reach from the light to infinity within a texel.
const DP_SLOPE_LOW: f32 = 0.25;
const DP_SLOPE_HIGH: f32 = 4.0;

// Where a receiver lies in a light's maps.
struct DpReceiver {
    // Hemisphere space, relative to the light.
    position: vec3<f32>,
    normal: vec3<f32>,
    back: bool,
    map: vec2<f32>,
}

// Share of the light that reaches `position`, from 0 (dark) to 1 (lit). Points out of the light's range are
// lit: the light's falloff is what ends them. `normal` is the triangle's own (not a shading normal), of any
// length and either sign; world space both. May be called anywhere, in loops over lights too.
fn dp_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let receiver = dp_locate(light, position, normal);
    if dp_is_out_of_range(light, receiver) {
        return 1.0;
    }
    if !dp_has_hemisphere(light, receiver.back) {
        return 0.0;
    }
    return dp_sample_bilinear(light, receiver);
}

fn dp_is_out_of_range(light: u32, receiver: DpReceiver) -> bool {
    return dot(receiver.position, receiver.position) > dp_lights[light].range * dp_lights[light].range;
}

fn dp_has_hemisphere(light: u32, back: bool) -> bool {
    return (dp_lights[light].hemispheres & select(1u, 2u, back)) != 0u;
}

// Which hemisphere, and where in it.
fn dp_locate(light: u32, position: vec3<f32>, normal: vec3<f32>) -> DpReceiver {
    let relative = position - dp_lights[light].position;
    let x = vec3<f32>(
        dot(dp_lights[light].right, relative),
        dot(dp_lights[light].up, relative),
        dot(dp_lights[light].forward, relative),
    );
    let n = vec3<f32>(
        dot(dp_lights[light].right, normal),
        dot(dp_lights[light].up, normal),
        dot(dp_lights[light].forward, normal),
    );
    let back = dp_is_back(x);
    let in_hemisphere = dp_to_hemisphere(x, back);
    return DpReceiver(in_hemisphere, dp_to_hemisphere(n, back), back, dp_project(in_hemisphere));
}

// Cosine between the receiver's normal and its ray, from 0 (edge-on) to 1.
fn dp_incidence(receiver: DpReceiver) -> f32 {
    let along = abs(dot(receiver.normal, dp_unproject_scaled(receiver.map)));
    // The ray is (1 + r^2)/2 long.
    return along / max(length(receiver.normal) * (0.5 + 0.5 * dot(receiver.map, receiver.map)), 1e-30);
}

// Depths of the receiver's plane at four map coordinates.
fn dp_receiver_depth(light: u32, receiver: DpReceiver, u: vec4<f32>, v: vec4<f32>) -> vec4<f32> {
    let n = receiver.normal;
    let here = dot(n, dp_unproject_scaled(receiver.map));
    let there = n.x * u + n.y * v + n.z * (0.5 - 0.5 * (u * u + v * v));
    let slope = clamp(there / here, vec4<f32>(DP_SLOPE_LOW), vec4<f32>(DP_SLOPE_HIGH));
    // Without a plane (no normal, or the light in it) the receiver's own depth has to do.
    return dp_depth(receiver.position, dp_lights[light].near) * select(vec4<f32>(1.0), slope, abs(here) > 0.0);
}

// What four texels say by their margins.
struct DpVotes {
    lit: vec4<f32>,
    dark: vec4<f32>,
}

// Reciprocal of the cosine between the receiver's normal and its ray, from 1 to 1000 (edge-on).
fn dp_grazing(receiver: DpReceiver) -> f32 {
    return 1.0 / max(dp_incidence(receiver), 1e-3);
}

// Margin up to which content counts as the receiver's own surface.
fn dp_bias(light: u32, grazing: f32) -> f32 {
    return DP_BIAS + dp_lights[light].tolerance * grazing;
}

// Depths over those of the receiver's plane up to which content votes for light or for nothing, and from which on it votes
// against in full. Most receivers are lit or dark altogether, which these tell without counting.
struct DpBounds {
    lit: f32,
    dark: f32,
}

fn dp_bounds(light: u32, receiver: DpReceiver, footprint: f32) -> DpBounds {
    let grazing = dp_grazing(receiver);
    let bias = dp_bias(light, grazing);
    return DpBounds(1.0 + bias * footprint, 1.0 + (bias + DP_RAMP * (1.0 + grazing)) * footprint);
}

fn dp_votes(light: u32, receiver: DpReceiver, margin: vec4<f32>) -> DpVotes {
    let grazing = dp_grazing(receiver);
    let bias = dp_bias(light, grazing);
    // Half along the ray and half along the normal.
    let spread = 1.0 + grazing;
    let before = max(1.0 - margin / bias, vec4<f32>(0.0));
    let behind = 1.0 / (1.0 - min(margin, vec4<f32>(0.0)) / (DP_FADE * spread));
    let dark = clamp((margin - bias) / (DP_RAMP * spread), vec4<f32>(0.0), vec4<f32>(1.0));
    return DpVotes(select(before, behind, margin < vec4<f32>(0.0)), dark);
}

// Four texels of a map, in the order in which textureGather gives them: the row below, then the row above,
// counter-clockwise.
struct DpTexels {
    stored: vec4<f32>,
    // Map coordinates of their centres.
    u: vec4<f32>,
    v: vec4<f32>,
}

// Map coordinates in texels: integers are the centres of texels, from the upper left one on.
fn dp_texel_position(light: u32, map: vec2<f32>) -> vec2<f32> {
    let texels = dp_lights[light].texels;
    return 0.5 * f32(textureDimensions(dp_maps).y) + map * vec2<f32>(texels, -texels) - 0.5;
}

// The texel `base` of a hemisphere's map, and those to its right and below.
fn dp_gather(light: u32, back: bool, base: vec2<f32>) -> DpTexels {
    let size = vec2<f32>(textureDimensions(dp_maps));
    let left = select(0.0, size.y, back);
    let stored = textureGather(dp_maps, dp_sampler, (base + vec2<f32>(left, 0.0) + 1.0) / size, light);
    let texel = vec2<f32>(1.0, -1.0) / dp_lights[light].texels;
    let low = (base + 0.5 - 0.5 * size.y) * texel;
    let high = low + texel;
    return DpTexels(
        stored,
        vec4<f32>(low.x, high.x, high.x, low.x),
        vec4<f32>(high.y, high.y, low.y, low.y),
    );
}

// The four texels whose centres are around a place in a map, and their bilinear weights.
struct DpNeighbours {
    texels: DpTexels,
    weights: vec4<f32>,
}

fn dp_neighbours(light: u32, back: bool, map: vec2<f32>) -> DpNeighbours {
    let last = f32(textureDimensions(dp_maps).y) - 2.0;
    let at = dp_texel_position(light, map);
    let base = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(max(last, 0.0)));
    let f = clamp(at - base, vec2<f32>(0.0), vec2<f32>(1.0));
    let weights = vec4<f32>((1.0 - f.x) * f.y, f.x * f.y, f.x * (1.0 - f.y), (1.0 - f.x) * (1.0 - f.y));
    return DpNeighbours(dp_gather(light, back, base), weights);
}

// Margins of four texels that span `footprint` radians each. The receiver is in the hemisphere of the texels.
fn dp_margins(light: u32, receiver: DpReceiver, texels: DpTexels, footprint: f32) -> vec4<f32> {
    return (texels.stored / dp_receiver_depth(light, receiver, texels.u, texels.v) - 1.0) / footprint;
}

// Angle that a texel spans at a place in a map.
fn dp_footprint(light: u32, map: vec2<f32>) -> f32 {
    return dp_texel_angle(map, 1.0 / dp_lights[light].texels);
}

// Share of the light by sums of votes.
fn dp_count(lit: f32, dark: f32) -> f32 {
    // Division may be rounded up.
    return max(1.0 - dark / max(lit + dark, DP_QUORUM), 0.0);
}

// The votes of the four texels around the receiver, weighted bilinearly.
fn dp_sample_bilinear(light: u32, receiver: DpReceiver) -> f32 {
    let around = dp_neighbours(light, receiver.back, receiver.map);
    let footprint = dp_footprint(light, receiver.map);
    let plane = dp_receiver_depth(light, receiver, around.texels.u, around.texels.v);
    let bounds = dp_bounds(light, receiver, footprint);
    if all(around.texels.stored <= bounds.lit * plane) {
        return 1.0;
    }
    if all(around.texels.stored >= bounds.dark * plane) {
        return 0.0;
    }
    let votes = dp_votes(light, receiver, dp_margins(light, receiver, around.texels, footprint));
    return dp_count(dot(around.weights, votes.lit), dot(around.weights, votes.dark));
}
