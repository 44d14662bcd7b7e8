// Lookup: is a point lit? To be pasted into a renderer's shader, together with paraboloid.wgsl, filter.wgsl, and mask.wgsl,
// exact.wgsl and sharp.wgsl, or votes.wgsl.

// How a light is filtered (filter.wgsl); twin of `FilterRecord` in src/filter.rs.
struct DpFilter {
    // One of DP_SHARP, DP_HARD, ...
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
    // Upper left texel of the light's maps, texels across each, and the layer.
    origin: vec2<f32>,
    resolution: f32,
    layer: u32,
    // Bias along a surface's normal, in texel footprints.
    normal_bias: f32,
    // How far receivers may lie from the casters' surface, along their normal, in world units.
    receiver_offset: f32,
    // Number of the casters' update that the maps show; 0 for none.
    made: u32,
    filtering: DpFilter,
}

@group(DP_GROUP) @binding(0) var dp_maps: texture_2d_array<f32>;
@group(DP_GROUP) @binding(1) var dp_sampler: sampler;
@group(DP_GROUP) @binding(2) var<storage, read> dp_lights: array<DpLight>;

// What a texel says about a receiver depends on its margin: how far its content stands before the receiver's plane,
// along the ray, in texel footprints. Content in the plane is the receiver's own surface, which the light reaches there:
// a vote for light. Content before it is in the way: a vote against. Content behind it says next to nothing: the
// receiver's surface ends before that texel, as it does all around the dark side of an object.

// Margin up to which content may be the receiver's own surface, for curvature finer than a texel. On top comes the light's
// bias along the receiver's normal. Less shows acne, more lets light in under contacts.
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
    // |position|, and the w and the map coordinates that it is projected to.
    distance: f32,
    w: f32,
    map: vec2<f32>,
}

// Share of the light that reaches `position`, from 0 (dark) to 1 (lit), over the pixel in which it is seen. Points out of the
// light's range are lit: the light's falloff is what ends them. `normal` is the triangle's own (not a shading normal), of
// any length and either sign; world space both. `view` has the camera's position, and in w the angle that a pixel spans, of
// a perspective camera 2 tan(fov / 2) over the picture's height in pixels: edges are as wide as a pixel. An angle of 0 asks for
// the point alone. May be called anywhere, in loops over lights too.
fn dp_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>) -> f32 {
    let receiver = dp_locate(light, position, normal);
    if dp_is_known(light, receiver) {
        return dp_known(light, receiver);
    }
    return dp_sample_sharp(light, position, normal, view, receiver);
}

// The steps from one pixel to the next on a surface that a camera sees.
fn dp_pixel(view: vec4<f32>, position: vec3<f32>, normal: vec3<f32>) -> mat2x3<f32> {
    let to = position - view.xyz;
    let ray = normalize(to);
    // Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
    let s = select(-1.0, 1.0, ray.z >= 0.0);
    let a = -1.0 / (s + ray.z);
    let across = vec3<f32>(1.0 + s * ray.x * ray.x * a, s * ray.x * ray.y * a, -s * ray.x);
    let down = vec3<f32>(ray.x * ray.y * a, s + ray.y * ray.y * a, -ray.y);
    // Seen edge-on, a pixel would reach for ever.
    let along = dot(normal, ray);
    let least = 0.05 * length(normal);
    let over = select(min(along, -least), max(along, least), along > 0.0);
    let size = view.w * length(to);
    return mat2x3<f32>(
        (across - ray * (dot(normal, across) / over)) * size,
        (down - ray * (dot(normal, down) / over)) * size,
    );
}

// Whether the maps needn't be asked: there is no such light, or none of its maps reaches the receiver.
fn dp_is_known(light: u32, receiver: DpReceiver) -> bool {
    return receiver.distance > dp_lights[light].range || !dp_has_hemisphere(light, receiver.back);
}

// The answer then.
fn dp_known(light: u32, receiver: DpReceiver) -> f32 {
    let is_lit = dp_lights[light].hemispheres != 0u && receiver.distance > dp_lights[light].range;
    return select(0.0, 1.0, is_lit);
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
    let own = dp_to_hemisphere(x, back);
    let distance = length(own);
    // `dp_homogeneous_w` before the seam.
    let w = distance + own.z;
    let map = select(vec2<f32>(1e18, 0.0), own.xy * (1.0 / w), w > 0.0);
    return DpReceiver(own, dp_to_hemisphere(n, back), back, distance, w, map);
}

// The receiver's plane as the maps have it: its depth at map coordinates p is a quadratic, axis + slope.p + bend |p|^2.
struct DpPlane {
    slope: vec2<f32>,
    bend: f32,
    axis: f32,
    // The receiver's own depth.
    own: f32,
}

fn dp_plane(light: u32, receiver: DpReceiver) -> DpPlane {
    let own = dp_lights[light].near / receiver.w;
    let along = dot(receiver.normal, receiver.position);
    // Without a plane (no normal, or the light in it) the receiver's own depth has to do.
    if abs(along) <= 1e-36 * dp_lights[light].near {
        return DpPlane(vec2<f32>(0.0), 0.0, own, own);
    }
    let n = dp_lights[light].near / along * receiver.normal;
    return DpPlane(n.xy, -0.5 * n.z, 0.5 * n.z, own);
}

// Depths of the plane at four map coordinates.
fn dp_plane_depths(plane: DpPlane, u: vec4<f32>, v: vec4<f32>) -> vec4<f32> {
    let depths = (plane.axis + u * (plane.slope.x + plane.bend * u)) + v * (plane.slope.y + plane.bend * v);
    return clamp(depths, vec4<f32>(DP_SLOPE_LOW * plane.own), vec4<f32>(DP_SLOPE_HIGH * plane.own));
}

// How margins are judged at a receiver.
struct DpJudge {
    // Margin up to which content counts as the receiver's own surface.
    bias: f32,
    // Scale of the ramp and of the fade: half along the ray and half along the normal.
    spread: f32,
}

// What four texels say by their margins.
struct DpVotes {
    lit: vec4<f32>,
    dark: vec4<f32>,
}

// Reciprocal of the cosine between the receiver's normal and its ray, from 1 to 1000 (edge-on).
fn dp_grazing(receiver: DpReceiver) -> f32 {
    let along = abs(dot(receiver.normal, receiver.position));
    return select(1e3, clamp(length(receiver.normal) * receiver.distance / along, 1.0, 1e3), along > 0.0);
}

// `dp_lights[light].receiver_offset` along the ray, over the receiver's distance.
fn dp_offset(light: u32, receiver: DpReceiver, grazing: f32) -> f32 {
    return dp_lights[light].receiver_offset * grazing / receiver.distance;
}

fn dp_judge(light: u32, receiver: DpReceiver) -> DpJudge {
    let grazing = dp_grazing(receiver);
    let offset = dp_offset(light, receiver, grazing) / dp_footprint(light, receiver.map);
    return DpJudge(DP_BIAS + dp_lights[light].normal_bias * grazing + offset, 1.0 + grazing);
}

fn dp_votes(judge: DpJudge, margin: vec4<f32>) -> DpVotes {
    let before = max(1.0 - margin * (1.0 / judge.bias), vec4<f32>(0.0));
    let behind = 1.0 / (1.0 - min(margin, vec4<f32>(0.0)) * (1.0 / (DP_FADE * judge.spread)));
    let dark = clamp((margin - judge.bias) * (1.0 / (DP_RAMP * judge.spread)), vec4<f32>(0.0), vec4<f32>(1.0));
    return DpVotes(select(before, behind, margin < vec4<f32>(0.0)), dark);
}

// Depths over those of the receiver's plane up to which no content votes against, and from which on all does in full. Most
// receivers are lit or dark altogether, which these tell without counting.
struct DpBounds {
    lit: f32,
    dark: f32,
}

fn dp_bounds(judge: DpJudge, footprint: f32) -> DpBounds {
    return DpBounds(1.0 + judge.bias * footprint, 1.0 + (judge.bias + DP_RAMP * judge.spread) * footprint);
}

// Four texels of a map, in the order in which textureGather gives them: the row below, then the row above,
// counter-clockwise.
struct DpTexels {
    stored: vec4<f32>,
    // Map coordinates of their centres.
    u: vec4<f32>,
    v: vec4<f32>,
    // Where they were gathered, in texture coordinates.
    at: vec2<f32>,
}

// Map coordinates in texels: integers are the centres of texels, from the upper left one on.
fn dp_texel_position(light: u32, map: vec2<f32>) -> vec2<f32> {
    let texels = dp_lights[light].texels;
    return 0.5 * dp_lights[light].resolution + map * vec2<f32>(texels, -texels) - 0.5;
}

// The texel `base` of a hemisphere's map, and those to its right and below.
fn dp_gather(light: u32, back: bool, base: vec2<f32>) -> DpTexels {
    let resolution = dp_lights[light].resolution;
    let corner = dp_lights[light].origin + vec2<f32>(select(0.0, resolution, back), 0.0);
    let at = (corner + base + 1.0) * (1.0 / vec2<f32>(textureDimensions(dp_maps)));
    let stored = textureGather(0, dp_maps, dp_sampler, at, dp_lights[light].layer);
    let texel = vec2<f32>(1.0, -1.0) * (1.0 / dp_lights[light].texels);
    let low = (base + 0.5 - 0.5 * resolution) * texel;
    let high = low + texel;
    return DpTexels(
        stored,
        vec4<f32>(low.x, high.x, high.x, low.x),
        vec4<f32>(high.y, high.y, low.y, low.y),
        at,
    );
}

// The four texels whose centres are around a place in a map, and their bilinear weights.
struct DpNeighbours {
    texels: DpTexels,
    weights: vec4<f32>,
}

fn dp_neighbours(light: u32, back: bool, map: vec2<f32>) -> DpNeighbours {
    let last = dp_lights[light].resolution - 2.0;
    let at = dp_texel_position(light, map);
    let base = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(max(last, 0.0)));
    let f = clamp(at - base, vec2<f32>(0.0), vec2<f32>(1.0));
    let weights = vec4<f32>((1.0 - f.x) * f.y, f.x * f.y, f.x * (1.0 - f.y), (1.0 - f.x) * (1.0 - f.y));
    return DpNeighbours(dp_gather(light, back, base), weights);
}

// Margins of four texels that span `footprint` radians each, by what they hold and the depths of the receiver's plane there.
fn dp_margins(stored: vec4<f32>, depths: vec4<f32>, footprint: f32) -> vec4<f32> {
    return (stored / depths - 1.0) * (1.0 / footprint);
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
    let plane = dp_plane(light, receiver);
    let judge = dp_judge(light, receiver);
    let depths = dp_plane_depths(plane, around.texels.u, around.texels.v);
    let bounds = dp_bounds(judge, footprint);
    if all(around.texels.stored <= bounds.lit * depths) {
        return 1.0;
    }
    if all(around.texels.stored >= bounds.dark * depths) {
        return 0.0;
    }
    let votes = dp_votes(judge, dp_margins(around.texels.stored, depths, footprint));
    return dp_count(dot(around.weights, votes.lit), dot(around.weights, votes.dark));
}
