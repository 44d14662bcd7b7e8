// Exact edges in the six faces of a cube, as sharp.wgsl has them in the pair: the same triangles, walks and votes. Goes with
// lookup.wgsl and exact.wgsl, whose bindings it reads faces by, and cube_face.wgsl. Here `map` of a receiver is its place
// in its face at distance 1 along the axis, and `w` its distance along that.

@group(DP_GROUP) @binding(3) var dp_numbers: texture_2d_array<u32>;

// Whether the light may have an orientation, see cube_lookup.wgsl.
const CUBE_WALK_IS_TURNED: bool = CUBE_TURNED;

// Where a receiver lies in which face.
struct CubeWalkReceiver {
    receiver: DpReceiver,
    face: u32,
}

fn cube_walk_turned(light: u32, v: vec3<f32>) -> vec3<f32> {
    if !CUBE_WALK_IS_TURNED {
        return v;
    }
    let axes = mat3x3<f32>(dp_lights[light].right, dp_lights[light].up, dp_lights[light].forward);
    return v * axes;
}

fn cube_walk_locate(light: u32, position: vec3<f32>, normal: vec3<f32>) -> CubeWalkReceiver {
    let from_light = cube_walk_turned(light, position - dp_lights[light].position);
    let face = cube_face(from_light);
    let x = cube_to_face(from_light, face);
    let n = cube_to_face(cube_walk_turned(light, normal), face);
    return CubeWalkReceiver(DpReceiver(x, n, false, length(x), x.z, x.xy * (1.0 / x.z)), face);
}

// Depths of the receiver's plane at four places of its face: dp_plane_depths, linear here.
fn cube_walk_depths(light: u32, receiver: DpReceiver, u: vec4<f32>, v: vec4<f32>) -> vec4<f32> {
    let own = dp_lights[light].near / receiver.w;
    let along = dot(receiver.normal, receiver.position);
    if abs(along) <= 1e-36 * dp_lights[light].near {
        return vec4<f32>(own);
    }
    let n = dp_lights[light].near / along * receiver.normal;
    return clamp(n.z + n.x * u + n.y * v, vec4<f32>(DP_SLOPE_LOW * own), vec4<f32>(DP_SLOPE_HIGH * own));
}

fn cube_walk_first(light: u32, position: vec3<f32>, at: CubeWalkReceiver) -> DpWalkFirst {
    var first: DpWalkFirst;
    first.value = 1.0;
    let receiver = at.receiver;
    let resolution = dp_lights[light].resolution;
    let texel = 1.0 / dp_lights[light].texels;
    let place = dp_texel_position(light, receiver.map);
    let base = floor(place);
    let f = place - base;
    let gathered = (base + 1.0) / resolution;
    let layer = 6u * dp_lights[light].layer + at.face;
    let stored = textureGather(0, dp_maps, dp_sampler, gathered, layer);
    let low = (base + 0.5 - 0.5 * resolution) * vec2<f32>(texel, -texel);
    let high = low + vec2<f32>(texel, -texel);
    let u = vec4<f32>(low.x, high.x, high.x, low.x);
    let depths = cube_walk_depths(light, receiver, u, vec4<f32>(high.y, high.y, low.y, low.y));
    // As an angle, in its wider direction.
    let footprint = texel * receiver.w / receiver.distance;
    let margins = dp_walk_margins(light, position, receiver, footprint);
    if all(stored <= (1.0 + margins.flat_bound) * depths) {
        return first;
    }
    let offset = dp_offset(light, receiver, margins.grazing) / footprint;
    let judge =
        DpJudge(DP_BIAS + dp_lights[light].normal_bias * margins.grazing + offset, 1.0 + margins.grazing);
    if all(stored >= dp_bounds(judge, footprint).dark * depths) {
        first.value = 0.0;
        return first;
    }
    first.mixed = true;
    first.grazing = margins.grazing;
    let weights = vec4<f32>((1.0 - f.x) * f.y, f.x * f.y, f.x * (1.0 - f.y), (1.0 - f.x) * (1.0 - f.y));
    let triangles = textureGather(0, dp_numbers, dp_sampler, gathered, layer);
    first.quad = dp_walk_quad(light, receiver, stored, depths, weights, triangles, judge, margins);
    return first;
}

// `dp_shadow` in a cube.
fn cube_shadow_walk(light: u32, position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>) -> f32 {
    let at = cube_walk_locate(light, position, normal);
    if at.receiver.distance > dp_lights[light].range {
        return 1.0;
    }
    let first = cube_walk_first(light, position, at);
    if !first.mixed {
        return first.value;
    }
    return dp_walk_pixel(light, position, normal, view, first, at.receiver.w / dp_lights[light].texels);
}

// What `dp_shadow` of lookup.wgsl calls: it reads a pair, and nobody asks it here.
fn dp_sample_sharp(
    light: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    view: vec4<f32>,
    receiver: DpReceiver,
) -> f32 {
    return 1.0;
}
