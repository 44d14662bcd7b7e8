// Shading: a Lambert surface under point lights, with the library's shadows.
// The text of `dual_paraboloid::wgsl::lookup(1, 3)` is put after this.

struct Frame {
    // From world space relative to the eye, so that a scene far from the origin doesn't shake.
    clip_from_relative: mat4x4<f32>,
    eye: vec3<f32>,
    view: u32,
    // Of a pixel in the middle of the picture.
    pixel_angle: f32,
}

struct Light {
    position: vec3<f32>,
    range: f32,
    intensity: vec3<f32>,
    // By which the library knows it.
    index: u32,
}

struct Material {
    base_color: vec4<f32>,
    emissive: vec3<f32>,
    // Texels with an alpha below this are holes.
    cutoff: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(2) @binding(0) var<uniform> material: Material;
@group(2) @binding(1) var base_color_image: texture_2d<f32>;
@group(2) @binding(2) var base_color_sampler: sampler;

const VIEW_SHADOW: u32 = 1u;
const VIEW_HEMISPHERE: u32 = 2u;
const VIEW_TEXELS: u32 = 3u;
const VIEW_PENUMBRA: u32 = 4u;
const VIEW_BIAS: u32 = 5u;

// Light from everywhere, after exposure.
const AMBIENT: vec3<f32> = vec3<f32>(0.030, 0.034, 0.042);

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // Of the triangle itself.
    @location(2) geometric_normal: vec3<f32>,
    @location(3) tex_coords: vec2<f32>,
}

// Rows of the matrix from the mesh's space to world space.
struct Instance {
    @location(4) x: vec4<f32>,
    @location(5) y: vec4<f32>,
    @location(6) z: vec4<f32>,
}

struct Surface {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) @interpolate(flat, either) geometric_normal: vec3<f32>,
    @location(3) tex_coords: vec2<f32>,
}

struct Radiance {
    // Reflected light of the lamps, to be exposed; alpha is 1 on surfaces.
    @location(0) lamps: vec4<f32>,
    // What is as bright whatever the exposure.
    @location(1) fixed_level: vec4<f32>,
}

@vertex
fn vertex(in: Vertex, instance: Instance) -> Surface {
    let local = vec4<f32>(in.position, 1.0);
    let position = vec3<f32>(dot(instance.x, local), dot(instance.y, local), dot(instance.z, local));
    // The matrix of cofactors turns normals as the matrix turns planes, whatever it scales.
    let columns = transpose(mat3x3<f32>(instance.x.xyz, instance.y.xyz, instance.z.xyz));
    let cofactors = mat3x3<f32>(
        cross(columns[1], columns[2]),
        cross(columns[2], columns[0]),
        cross(columns[0], columns[1]),
    );
    let relative = vec4<f32>(position - frame.eye, 1.0);
    return Surface(
        frame.clip_from_relative * relative,
        position,
        cofactors * in.normal,
        cofactors * in.geometric_normal,
        in.tex_coords,
    );
}

@fragment
fn shade(in: Surface) -> Radiance {
    let base = material.base_color * textureSample(base_color_image, base_color_sampler, in.tex_coords);
    var albedo = base.rgb;
    let to_eye = normalize(frame.eye - in.position);
    let geometric = turned_toward(normalize(in.geometric_normal), to_eye);
    let normal = turned_toward(normalize(in.normal), geometric);
    if frame.view == VIEW_HEMISPHERE {
        albedo *= hemisphere_tint(in.position);
    } else if frame.view == VIEW_TEXELS {
        albedo *= texel_pattern(in.position);
    }

    var lit = vec3<f32>();
    var shadow = 0.0;
    var first = 0.0;
    let camera = vec4<f32>(frame.eye, frame.pixel_angle);
    let noise = interleaved_gradient_noise(in.clip.xy);
    for (var i = 0u; i < arrayLength(&lights); i += 1u) {
        let visible = dp_shadow_filtered(lights[i].index, in.position, geometric, camera, noise);
        lit += irradiance(lights[i], in.position, normal, geometric) * visible;
        shadow += visible;
        first = select(first, visible, i == 0u);
    }
    let ambient = AMBIENT * (0.5 + 0.5 * max(dot(normal, to_eye), 0.0));
    var radiance = Radiance(vec4<f32>(albedo * lit, 1.0), vec4<f32>(albedo * ambient + material.emissive, 1.0));
    if frame.view == VIEW_SHADOW {
        radiance = figure(vec3<f32>(shadow / f32(arrayLength(&lights))));
    } else if frame.view == VIEW_PENUMBRA {
        radiance = figure(penumbra(first));
    } else if frame.view == VIEW_BIAS {
        radiance = figure(vec3<f32>(bias(in.position, geometric)));
    }
    if base.a < material.cutoff {
        discard;
    }
    return radiance;
}

// What is shown as it is.
fn figure(color: vec3<f32>) -> Radiance {
    return Radiance(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec4<f32>(color, 1.0));
}

// Grey in the light and in the dark, and between the two orange, the more the nearer to half and half.
fn penumbra(visible: f32) -> vec3<f32> {
    return mix(vec3<f32>(0.1 + 0.5 * visible), vec3<f32>(1.0, 0.35, 0.0), sqrt(4.0 * visible * (1.0 - visible)));
}

// The bias of the first light's lookup, in texels' footprints along the ray.
fn bias(position: vec3<f32>, geometric: vec3<f32>) -> f32 {
    let index = lights[0].index;
    return min(dp_judge(index, dp_locate(index, position, geometric)).bias, 1.0);
}

// Jimenez, "Next generation post processing in Call of Duty: Advanced Warfare" (2014).
fn interleaved_gradient_noise(pixel: vec2<f32>) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2<f32>(0.06711056, 0.00583715))));
}

// A surface's two sides look alike: the normal is that of the side that is seen.
fn turned_toward(normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    return select(normal, -normal, dot(normal, direction) < 0.0);
}

fn irradiance(light: Light, position: vec3<f32>, normal: vec3<f32>, geometric: vec3<f32>) -> vec3<f32> {
    let relative = light.position - position;
    let distance_squared = max(dot(relative, relative), 1e-12);
    let direction = relative * inverseSqrt(distance_squared);
    // Light doesn't come through from a triangle's other side, though a smooth normal may lean that way.
    let cosine = select(0.0, max(dot(normal, direction), 0.0), dot(geometric, direction) > 0.0);
    // Falls smoothly to nothing at the range.
    let share = distance_squared / (light.range * light.range);
    let window = max(1.0 - share * share, 0.0);
    return min(light.intensity * (cosine * window * window / distance_squared), vec3<f32>(6e4));
}

fn hemisphere_tint(position: vec3<f32>) -> vec3<f32> {
    let receiver = dp_locate(lights[0].index, position, vec3<f32>());
    return select(vec3<f32>(1.0, 0.6, 0.3), vec3<f32>(0.35, 0.6, 1.0), receiver.back);
}

// Every other texel dark; evenly grey where texels are finer than pixels.
fn texel_pattern(position: vec3<f32>) -> vec3<f32> {
    let index = lights[0].index;
    let receiver = dp_locate(index, position, vec3<f32>());
    let at = 0.5 * f32(textureDimensions(dp_maps).y) + receiver.map * vec2<f32>(1.0, -1.0) * dp_lights[index].texels;
    let change = fwidth(at);
    let fineness = smoothstep(0.3, 0.7, max(change.x, change.y));
    let cell = vec2<i32>(floor(at));
    let checker = f32((cell.x + cell.y) & 1);
    return vec3<f32>(mix(0.35 + 0.65 * checker, 0.675, fineness));
}
