// The faces of a cube, in the order of a cube texture's layers and by the axes by which the hardware looks it up.

// Number of the face that a direction lies in.
fn cube_face(v: vec3<f32>) -> u32 {
    let a = abs(v);
    if a.x >= max(a.y, a.z) {
        return select(0u, 1u, v.x < 0.0);
    }
    if a.y >= a.z {
        return select(2u, 3u, v.y < 0.0);
    }
    return select(4u, 5u, v.z < 0.0);
}

// A vector of light space by a face's axes: right, up, forward.
fn cube_to_face(v: vec3<f32>, face: u32) -> vec3<f32> {
    let s = select(1.0, -1.0, (face & 1u) != 0u);
    if face < 2u {
        return vec3<f32>(-s * v.z, v.y, s * v.x);
    }
    if face < 4u {
        return vec3<f32>(v.x, -s * v.z, s * v.y);
    }
    return vec3<f32>(s * v.x, v.y, s * v.z);
}
