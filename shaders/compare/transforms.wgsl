// The instances' transforms, as src/compare/baselines/scene_buffers.rs writes them.

// Three rows an instance.
@group(1) @binding(0) var<storage, read> transforms: array<vec4<f32>>;

fn world_position(local: vec3<f32>, instance: u32) -> vec3<f32> {
    let p = vec4<f32>(local, 1.0);
    return vec3<f32>(
        dot(transforms[3u * instance], p),
        dot(transforms[3u * instance + 1u], p),
        dot(transforms[3u * instance + 2u], p),
    );
}
