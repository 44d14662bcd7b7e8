// Exact edges in the pair: what the walks of exact.wgsl begin with. In place of votes.wgsl.

// Number of the triangle under each texel's centre: its chunk in bits 8-31, its place there in bits 0-7.
@group(DP_GROUP) @binding(3) var dp_numbers: texture_2d_array<u32>;

fn dp_walk_first(light: u32, position: vec3<f32>, receiver: DpReceiver) -> DpWalkFirst {
    var first: DpWalkFirst;
    first.value = 1.0;
    let around = dp_neighbours(light, receiver.back, receiver.map);
    let margins = dp_walk_margins(light, position, receiver, dp_footprint(light, receiver.map));
    let depths = dp_plane_depths(dp_plane(light, receiver), around.texels.u, around.texels.v);
    if all(around.texels.stored <= (1.0 + margins.flat_bound) * depths) {
        return first;
    }
    let judge = dp_judge(light, receiver);
    if all(around.texels.stored >= dp_bounds(judge, margins.footprint).dark * depths) {
        first.value = 0.0;
        return first;
    }
    first.mixed = true;
    first.grazing = margins.grazing;
    let triangles = textureGather(0, dp_numbers, dp_sampler, around.texels.at, dp_lights[light].layer);
    first.quad =
        dp_walk_quad(light, receiver, around.texels.stored, depths, around.weights, triangles, judge, margins);
    return first;
}

// What `dp_shadow` answers where the maps have to be asked. Pixels whose texels agree read nothing but four depths.
fn dp_sample_sharp(
    light: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    view: vec4<f32>,
    receiver: DpReceiver,
) -> f32 {
    let first = dp_walk_first(light, position, receiver);
    if !first.mixed {
        return first.value;
    }
    // A texel: around the pixel's middle its four texels know what is there.
    let most = 2.0 * receiver.distance / dp_lights[light].texels;
    return dp_walk_pixel(light, position, normal, view, first, most);
}
