// Lookup: is a point lit? To be pasted into a renderer's shader, together with paraboloid.wgsl.

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
    // Largest bend of a chord, in texels.
    tolerance: f32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(DP_GROUP) @binding(0) var dp_maps: texture_depth_2d_array;
@group(DP_GROUP) @binding(1) var dp_sampler: sampler;
@group(DP_GROUP) @binding(2) var<storage, read> dp_lights: array<DpLight>;

// How far the reference is moved toward the light, in texel footprints along the ray. It covers what the
// receiver's plane doesn't: curvature finer than a texel and the rasteriser's snapping. Less shows acne on curved
// surfaces, more lets light in under contacts. On top comes the tolerance along the receiver's normal, by which
// the depth that the hardware interpolates over a chord may be off.
const DP_BIAS: f32 = 0.2;
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
    let distance_squared = dot(receiver.position, receiver.position);
    let hemisphere = select(1u, 2u, receiver.back);
    if distance_squared > dp_lights[light].range * dp_lights[light].range {
        return 1.0;
    }
    if (dp_lights[light].hemispheres & hemisphere) == 0u {
        return 0.0;
    }
    return dp_sample_bilinear(light, receiver);
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

// The depth above which the map's content at map coordinates `p` hides the receiver: the receiver's own plane
// there, moved toward the light by the bias.
fn dp_reference(light: u32, receiver: DpReceiver, p: vec2<f32>) -> f32 {
    let here = dot(receiver.normal, dp_unproject_scaled(receiver.map));
    let there = dot(receiver.normal, dp_unproject_scaled(p));
    // Without a plane (no normal, or the light in it) the receiver's own depth has to do.
    let slope = select(1.0, clamp(there / here, DP_SLOPE_LOW, DP_SLOPE_HIGH), abs(here) > 0.0);
    let incidence = abs(here) / (length(receiver.normal) * length(dp_unproject_scaled(receiver.map)));
    let footprints = DP_BIAS + dp_lights[light].tolerance / max(incidence, 1e-3);
    let bias = footprints * dp_texel_angle(receiver.map, 1.0 / dp_lights[light].texels);
    return dp_depth(receiver.position, dp_lights[light].near) * slope / (1.0 - min(bias, 0.5));
}

// Four texels, each compared with the receiver's plane at its own centre, weighted bilinearly.
fn dp_sample_bilinear(light: u32, receiver: DpReceiver) -> f32 {
    let size = vec2<f32>(textureDimensions(dp_maps));
    let resolution = size.y;
    let texels = dp_lights[light].texels;
    let at = 0.5 * resolution + receiver.map * vec2<f32>(texels, -texels) - 0.5;
    let base = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(max(resolution - 2.0, 0.0)));
    let f = clamp(at - base, vec2<f32>(0.0), vec2<f32>(1.0));
    let left = select(0.0, resolution, receiver.back);
    let stored = textureGather(dp_maps, dp_sampler, (base + vec2<f32>(left, 0.0) + 1.0) / size, light);
    let low = (base + 0.5 - 0.5 * resolution) * vec2<f32>(1.0, -1.0) / texels;
    let high = low + vec2<f32>(1.0, -1.0) / texels;
    // The order in which textureGather gives the texels: row below, then row above, counter-clockwise.
    let reference = vec4<f32>(
        dp_reference(light, receiver, vec2<f32>(low.x, high.y)),
        dp_reference(light, receiver, high),
        dp_reference(light, receiver, vec2<f32>(high.x, low.y)),
        dp_reference(light, receiver, low),
    );
    let weights = vec4<f32>((1.0 - f.x) * f.y, f.x * f.y, f.x * (1.0 - f.y), (1.0 - f.x) * (1.0 - f.y));
    return dot(weights, select(vec4<f32>(1.0), vec4<f32>(0.0), stored > reference));
}
