// `dp_shadow` over a square of TEXEL_SIDE x TEXEL_SIDE texels in place of four, each loaded on its own: to see what a
// texel more or less costs. One texel is a hard edge. Goes with shaders/lookup.wgsl.

const TEXEL_SIDE: i32 = TEXELS;

// Weight of the texel number `index` of a row whose first texel is covered but for the share `f`.
fn texel_weight(index: i32, f: f32) -> f32 {
    if TEXEL_SIDE == 1 {
        return 1.0;
    }
    let whole = select(1.0, f, index == TEXEL_SIDE - 1);
    return select(whole, 1.0 - f, index == 0);
}

fn texels_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let receiver = dp_locate(light, position, normal);
    if dot(receiver.position, receiver.position) > dp_lights[light].range * dp_lights[light].range {
        return 1.0;
    }
    let resolution = i32(dp_lights[light].resolution);
    let middle = 0.5 * f32(resolution);
    let texels = dp_lights[light].texels;
    let first = middle + receiver.map * vec2<f32>(texels, -texels) - 0.5 * f32(TEXEL_SIDE - 1);
    let f = fract(first);
    let base = vec2<i32>(floor(first));
    let left = select(0, resolution, receiver.back);
    let footprint = dp_texel_angle(receiver.map, 1.0 / texels);
    let plane = dp_plane(light, receiver);
    let judge = dp_judge(light, receiver);
    var lit = 0.0;
    var dark = 0.0;
    for (var y = 0; y < TEXEL_SIDE; y++) {
        for (var x = 0; x < TEXEL_SIDE; x++) {
            let texel = clamp(base + vec2<i32>(x, y), vec2<i32>(0), vec2<i32>(resolution - 1));
            let p = (vec2<f32>(texel) + 0.5 - middle) * vec2<f32>(1.0, -1.0) / texels;
            let stored = textureLoad(dp_maps, vec2<i32>(dp_lights[light].origin) + texel + vec2<i32>(left, 0), dp_lights[light].layer, 0).x;
            let weight = texel_weight(x, f.x) * texel_weight(y, f.y);
            let depth = dp_plane_depths(plane, p.xxxx, p.yyyy).x;
            let votes = dp_votes(judge, dp_margins(vec4<f32>(stored), vec4<f32>(depth), footprint));
            lit += weight * votes.lit.x;
            dark += weight * votes.dark.x;
        }
    }
    let across = f32(max(TEXEL_SIDE - 1, 1));
    return max(1.0 - dark / max(lit + dark, DP_QUORUM * across * across), 0.0);
}
