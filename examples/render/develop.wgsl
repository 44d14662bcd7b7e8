// Develop: from radiance to the picture. Four samples make a pixel.

struct Development {
    exposure: f32,
    // 1 to map tones, 0 to show the fixed level as it is.
    tone_mapping: f32,
}

@group(0) @binding(0) var lamps: texture_2d<f32>;
@group(0) @binding(1) var fixed_level: texture_2d<f32>;
@group(0) @binding(2) var<uniform> development: Development;

const BACKGROUND: vec3<f32> = vec3<f32>(0.012, 0.014, 0.018);

@vertex
fn whole_picture(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(vec2<f32>(vec2<u32>((vertex << 1u) & 2u, vertex & 2u)) * 2.0 - 1.0, 0.0, 1.0);
}

// Luminance by the lamps, or -1 where there is no surface.
@fragment
fn meter(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let sample = textureLoad(lamps, 2 * vec2<i32>(position.xy), 0);
    return vec4<f32>(select(-1.0, dot(sample.rgb, vec3<f32>(0.2126, 0.7152, 0.0722)), sample.a > 0.5));
}

@fragment
fn develop(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let corner = 2 * vec2<i32>(position.xy);
    var sum = vec3<f32>();
    for (var i = 0; i < 4; i += 1) {
        let at = corner + vec2<i32>(i & 1, i >> 1u);
        let lamp = textureLoad(lamps, at, 0);
        let level = textureLoad(fixed_level, at, 0).rgb;
        let radiance = lamp.rgb * development.exposure + level;
        let shown = mix(clamp(level, vec3<f32>(0.0), vec3<f32>(1.0)), tone_mapped(radiance), development.tone_mapping);
        sum += select(BACKGROUND, shown, lamp.a > 0.5);
    }
    return vec4<f32>(0.25 * sum, 1.0);
}

// Narkowicz's fit of the ACES film curve (2015).
fn tone_mapped(x: vec3<f32>) -> vec3<f32> {
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), vec3<f32>(0.0), vec3<f32>(1.0));
}
