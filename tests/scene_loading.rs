//! What the scene loader does with files made here: features of glTF one at a time, then broken files.

use std::{f32::consts::FRAC_1_SQRT_2, fs, path::PathBuf};

use dual_paraboloid::compare::scene::{Alpha, Scene, SceneError};
use glam::{Quat, Vec3};
use rand::{Rng, SeedableRng};
use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A glTF document with one buffer.
#[derive(Clone)]
struct Maker {
    json: Value,
    buffer: Vec<u8>,
}

impl Maker {
    fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "accessors": [],
            "bufferViews": [],
        });
        Self { json, buffer: Vec::new() }
    }

    /// A document that draws one triangle, from accessor 0.
    fn triangle() -> Self {
        let mut maker = Self::new();
        let positions = maker.floats(&TRIANGLE);
        maker.json["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": positions } }] }]);
        maker
    }

    /// Adds an accessor over bytes of its own, and returns its index.
    fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }));
        accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() }));
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        views.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, FLOAT, &format!("VEC{N}"), values.len())
    }

    fn shorts<const N: usize>(&mut self, values: &[[i16; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, SHORT, &format!("VEC{N}"), values.len())
    }

    fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, UNSIGNED_SHORT, "SCALAR", values.len())
    }

    /// The document as `.gltf`, the buffer in a data URI.
    fn gltf(&self) -> Vec<u8> {
        let uri = format!("data:application/octet-stream;base64,{}", base64(&self.buffer));
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.buffer.len(), "uri": uri }]);
        json.to_string().into_bytes()
    }

    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.buffer.len() }]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 28 + text.len() + self.buffer.len();
        let mut out = b"glTF".to_vec();
        out.extend([2, total as u32, text.len() as u32].map(u32::to_le_bytes).as_flattened());
        out.extend(b"JSON");
        out.extend(text);
        out.extend((self.buffer.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(&self.buffer);
        out
    }

    fn load(&self, name: &str) -> Result<Scene, SceneError> {
        load(&format!("{name}.gltf"), &self.gltf())
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |group: &[u8]| {
        let bits = (0..3).fold(0, |bits, k| bits << 8 | u32::from(group.get(k).copied().unwrap_or(0)));
        let digit = |k: usize| {
            if k > group.len() { '=' } else { DIGITS[(bits >> (18 - 6 * k) & 63) as usize] as char }
        };
        [0, 1, 2, 3].map(digit)
    };
    bytes.chunks(3).flat_map(group).collect()
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn load(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    let path = path(name);
    fs::write(&path, bytes).expect("the test's folder can be written");
    Scene::load(&path)
}

/// The error as text, known to be one line that names the file.
fn message(name: &str, result: Result<Scene, SceneError>) -> String {
    let text = result.expect_err(name).to_string();
    assert!(!text.contains('\n') && text.contains(name), "{text:?}");
    text
}

#[test]
fn both_containers_give_the_same_scene() {
    let maker = Maker::triangle();
    let text = maker.load("containers").unwrap();
    let binary = load("containers.glb", &maker.glb()).unwrap();
    assert_eq!(text.meshes[0].positions, TRIANGLE);
    assert_eq!(text.meshes[0].indices, [0, 1, 2]);
    assert_eq!(text.world_triangles().corners, binary.world_triangles().corners);
    assert_eq!([text.name, binary.name], ["containers"; 2]);
}

#[test]
fn buffers_beside_the_file_are_found_through_escapes() {
    let maker = Maker::triangle();
    fs::write(path("a buffer.bin"), &maker.buffer).unwrap();
    let mut json = maker.json.clone();
    json["buffers"] = json!([{ "byteLength": maker.buffer.len(), "uri": "a%20buffer.bin" }]);
    assert_eq!(load("beside.gltf", json.to_string().as_bytes()).unwrap().triangle_count(), 1);
    json["buffers"][0]["uri"] = json!("absent.bin");
    assert!(message("absent.bin", load("beside.gltf", json.to_string().as_bytes())).contains("check the path"));
}

#[test]
fn instancing_composes_with_the_node() {
    let mut maker = Maker::triangle();
    let turn = Quat::from_rotation_z(0.5);
    let translation = maker.floats(&[[1.0, 2.0, 3.0], [-4.0, 0.0, 0.5]]);
    let rotation = maker.floats(&[turn.to_array(), [0.0, 0.0, 0.0, 1.0]]);
    let scale = maker.floats(&[[2.0, 2.0, 2.0], [1.0, -3.0, 1.0]]);
    let attributes = json!({ "TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale });
    maker.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    maker.json["nodes"] = json!([
        { "translation": [10.0, 0.0, 0.0], "children": [1] },
        { "mesh": 0, "scale": [2.0, 2.0, 2.0], "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } },
    ]);
    let scene = maker.load("instancing").unwrap();
    assert_eq!(scene.instances.len(), 2);
    let place = |k: usize, point: Vec3| scene.instances[k].transform.transform_point3(point);
    assert!(place(0, Vec3::X).abs_diff_eq(Vec3::new(12.0, 4.0, 6.0) + turn * Vec3::X * 4.0, 1e-5));
    assert!(place(1, Vec3::Y).abs_diff_eq(Vec3::new(2.0, -6.0, 1.0), 1e-5));
    assert!(scene.instances[1].transform.matrix3.determinant() < 0.0);
}

#[test]
fn instance_rotations_may_be_normalised_integers() {
    let mut maker = Maker::triangle();
    let half = (FRAC_1_SQRT_2 * 32767.0).round() as i16;
    let rotation = maker.shorts(&[[0, 0, half, half]]);
    maker.json["accessors"][rotation]["normalized"] = json!(true);
    maker.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "ROTATION": rotation } } });
    let transform = maker.load("integer_rotation").unwrap().instances[0].transform;
    assert!(transform.transform_vector3(Vec3::X).abs_diff_eq(Vec3::Y, 1e-6));
}

#[test]
fn instance_attributes_must_agree() {
    let mut maker = Maker::triangle();
    let translation = maker.floats(&[[0.0; 3]; 2]);
    let scale = maker.floats(&[[1.0; 3]; 3]);
    let mut set = |attributes: Value| {
        maker.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
        message("disagree", maker.load("disagree"))
    };
    assert!(set(json!({ "TRANSLATION": translation, "SCALE": scale })).contains("differ in length"));
    assert!(set(json!({})).contains("without attributes"));
    assert!(set(json!({ "SCALE": "many" })).contains("\"many\""));
    assert!(set(json!({ "SCALE": 99 })).contains("is 99, but there are only 3"));
}

#[test]
fn nodes_compose_in_double_precision() {
    let mut maker = Maker::triangle();
    maker.json["nodes"] = json!([
        { "translation": [16_777_216.0, 0.0, 0.0], "children": [1] },
        { "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.75, 0, 0, 1], "children": [2] },
        { "translation": [-16_777_216.0, 0.0, 0.0], "mesh": 0 },
    ]);
    assert_eq!(maker.load("precision").unwrap().instances[0].transform.translation.x, 0.75);
}

#[test]
fn strips_and_fans_become_lists() {
    let mut maker = Maker::triangle();
    let positions = maker.floats(&[[0.0; 3]; 5]);
    let indices = maker.indices(&[4, 3, 2, 1, 0]);
    let primitive = |mode: u32| json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": mode });
    maker.json["meshes"] =
        json!([{ "primitives": [primitive(0), primitive(1), primitive(4), primitive(5), primitive(6)] }]);
    let scene = maker.load("strips").unwrap();
    let lists: Vec<_> = scene.meshes.iter().map(|mesh| mesh.indices.as_slice()).collect();
    assert_eq!(lists, [&[4, 3, 2][..], &[4, 3, 2, 3, 1, 2, 2, 1, 0], &[3, 2, 4, 2, 1, 4, 1, 0, 4]]);
}

#[test]
fn sparse_accessors_replace_values() {
    let mut maker = Maker::triangle();
    let at = maker.view(&[2]);
    let new: Vec<u8> = [0.0_f32, 7.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let new = maker.view(&new);
    maker.json["accessors"][0]["sparse"] =
        json!({ "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": new } });
    let positions = maker.load("sparse").unwrap().meshes[0].positions.clone();
    assert_eq!(positions, [TRIANGLE[0], TRIANGLE[1], [0.0, 7.0, 0.0]]);
    maker.json["accessors"][0]["count"] = json!(2);
    assert!(message("sparse", maker.load("sparse")).contains("sparse index 2"));
}

#[test]
fn quantised_positions_are_read() {
    let mut maker = Maker::triangle();
    // Padded to four components, as the extension asks for.
    let positions = maker.shorts(&[[0, 0, 0, 0], [32767, 0, 0, 0], [0, -32768, 100, 0]]);
    maker.json["bufferViews"][positions]["byteStride"] = json!(8);
    maker.json["accessors"][positions]["type"] = json!("VEC3");
    maker.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    maker.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_eq!(maker.load("quantised").unwrap().meshes[0].positions[2], [0.0, -32768.0, 100.0]);
    maker.json["accessors"][positions]["normalized"] = json!(true);
    let positions = maker.load("quantised").unwrap().meshes[0].positions.clone();
    assert_eq!(positions[1..], [[1.0, 0.0, 0.0], [0.0, -1.0, 100.0 / 32767.0]]);
}

#[test]
fn materials_and_their_images_are_read() {
    let mut maker = Maker::triangle();
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(3, 2, image::Rgba([10, 20, 30, 40]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let png = png.into_inner();
    let view = maker.view(&png);
    let tex_coords = maker.floats(&[[0.0, 0.0], [0.5, 0.0], [0.0, 0.25]]);
    maker.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(tex_coords);
    maker.json["meshes"][0]["primitives"][0]["material"] = json!(1);
    let texture = json!({ "index": 0, "texCoord": 1 });
    maker.json["materials"] = json!([
        { "pbrMetallicRoughness": { "baseColorTexture": { "index": 77 } } },
        {
            "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true, "emissiveFactor": [0.0, 0.5, 1.0],
            "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "baseColorTexture": texture },
        },
    ]);
    maker.json["textures"] = json!([{ "source": 0 }]);
    maker.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    // The material that nothing uses is not read, and its broken texture does no harm.
    let scene = maker.load("materials").unwrap();
    let [material] = scene.materials[..] else { panic!("{:?}", scene.materials) };
    assert_eq!(material.alpha, Alpha::Mask { cutoff: 0.25 });
    assert_eq!(material.base_color, [0.1, 0.2, 0.3, 0.4]);
    assert_eq!(material.emissive, [0.0, 0.5, 1.0]);
    assert!(material.double_sided);
    let image = &scene.images[material.base_color_image.unwrap()];
    assert_eq!((image.dimensions(), image.get_pixel(2, 1).0), ((3, 2), [10, 20, 30, 40]));
    assert_eq!(scene.meshes[0].tex_coords.as_ref().unwrap()[2], [0.0, 0.25]);
    assert_eq!(material.address_modes, [wgpu::AddressMode::Repeat; 2]);
    let mask = scene.mask(&scene.meshes[0]).unwrap();
    assert_eq!((mask.cutoff, mask.image, mask.tex_coords.len()), (0.25 / 0.4, 0, 3));
    assert!(scene.has_holes() && !scene.without_holes().has_holes());

    maker.json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    maker.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648 }]);
    let modes = [wgpu::AddressMode::ClampToEdge, wgpu::AddressMode::MirrorRepeat];
    assert_eq!(maker.load("materials").unwrap().materials[0].address_modes, modes);
    maker.json["samplers"] = json!([{ "wrapS": 7 }]);
    assert!(message("materials", maker.load("materials")).contains("wrapping mode"));
    maker.json["textures"] = json!([{ "source": 0 }]);
    // Nothing has an alpha of more than the base colour's.
    maker.json["materials"][1]["alphaCutoff"] = json!(0.5);
    assert!(message("materials", maker.load("materials")).contains("draws no triangle"));
    maker.json["materials"][1]["alphaCutoff"] = json!(0.25);

    maker.json["images"] = json!([{ "uri": format!("data:image/png;base64,{}", base64(&png)) }]);
    assert_eq!(maker.load("materials").unwrap().images[0].dimensions(), (3, 2));
    maker.json["images"] = json!([{ "uri": format!("data:image/png;base64,{}", base64(&png[..30])) }]);
    assert!(message("materials", maker.load("materials")).contains("image 0 cannot be used"));
    maker.json["images"] = json!([{ "uri": "lost.png" }]);
    assert!(message("materials", maker.load("materials")).contains("lost.png"));
    maker.json["textures"] = json!([{}]);
    assert!(message("materials", maker.load("materials")).contains("texture 0 has no PNG or JPEG"));
}

#[test]
fn only_point_lights_are_kept() {
    let mut maker = Maker::triangle();
    maker.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional" },
        { "type": "point", "color": [1.0, 0.5, 0.0], "intensity": 7.0, "range": 9.0 },
    ] } });
    let light = |index: u32| json!({ "KHR_lights_punctual": { "light": index } });
    maker.json["nodes"] = json!([
        { "mesh": 0, "translation": [1.0, 0.0, 0.0], "children": [1], "extensions": light(0) },
        { "translation": [0.0, 2.0, 0.0], "extensions": light(1) },
    ]);
    let scene = maker.load("lights").unwrap();
    let [light] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(light.position, Vec3::new(1.0, 2.0, 0.0));
    assert_eq!((light.color, light.intensity, light.range), ([1.0, 0.5, 0.0], 7.0, Some(9.0)));
    maker.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = json!(5);
    assert!(message("lights", maker.load("lights")).contains("the light of a node is 5, but there are only 2"));
}

#[test]
fn extensions_that_cannot_be_honoured_are_named() {
    let cases = [
        ("KHR_draco_mesh_compression", "decompress"),
        ("EXT_meshopt_compression", "decompress"),
        ("KHR_texture_transform", "bake"),
        ("KHR_texture_basisu", "PNG"),
        ("ACME_cubes", "export it without"),
    ];
    for (extension, remedy) in cases {
        let mut maker = Maker::triangle();
        maker.json["extensionsRequired"] = json!(["KHR_materials_unlit", extension]);
        let text = message("required", maker.load("required"));
        assert!(text.contains(extension) && text.contains(remedy), "{text}");
    }
}

#[test]
fn broken_files_are_explained() {
    type Change = fn(&mut Value);
    let cases: &[(&str, Change)] = &[
        ("version is \"1.0\"", |json| json["asset"]["version"] = json!("1.0")),
        ("the default scene is 3, but there are only 1", |json| json["scene"] = json!(3)),
        ("a node of the scene is 8, but there are only 1", |json| json["scenes"][0]["nodes"] = json!([8])),
        ("the mesh of a node is 4, but", |json| json["nodes"][0]["mesh"] = json!(4)),
        ("node 0 is its own ancestor", |json| json["nodes"][0]["children"] = json!([0])),
        ("number out of range", |json| json["nodes"][0]["scale"] = json!([1e39, 1.0, 1.0])),
        ("not of length 1", |json| json["nodes"][0]["rotation"] = json!([0, 0, 0, 0])),
        ("is 9, but there are only 1", |json| json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9)),
        ("has no POSITION", |json| json["meshes"][0]["primitives"][0]["attributes"] = json!({})),
        ("unknown mode", |json| json["meshes"][0]["primitives"][0]["mode"] = json!(12)),
        ("not of type Scalar", |json| json["meshes"][0]["primitives"][0]["indices"] = json!(0)),
        ("the material of a primitive is 2", |json| json["meshes"][0]["primitives"][0]["material"] = json!(2)),
        ("draws no triangle", |json| json["meshes"][0]["primitives"][0]["mode"] = json!(1)),
        ("draws no triangle", |json| json["accessors"][0]["count"] = json!(2)),
        ("not of type Vec3", |json| json["accessors"][0]["type"] = json!("VEC4")),
        ("unknown component type", |json| json["accessors"][0]["componentType"] = json!(7)),
        ("takes more bytes", |json| json["accessors"][0]["count"] = json!(4)),
        ("takes more bytes", |json| json["accessors"][0]["byteOffset"] = json!(u64::MAX)),
        ("pass the limit", |json| json["accessors"][0]["count"] = json!(u64::MAX)),
        ("a buffer view is 6", |json| json["accessors"][0]["bufferView"] = json!(6)),
        ("a stride of 5", |json| json["bufferViews"][0]["byteStride"] = json!(5)),
        ("of a buffer of 36", |json| json["bufferViews"][0]["byteLength"] = json!(u64::MAX)),
        ("the buffer of buffer view 0 is 1", |json| json["bufferViews"][0]["buffer"] = json!(1)),
        ("does not parse", |json| json["accessors"] = json!(5)),
    ];
    for (expected, change) in cases {
        let mut maker = Maker::triangle();
        change(&mut maker.json);
        let text = message("broken", maker.load("broken"));
        assert!(text.contains(expected), "{text:?} does not say {expected:?}");
    }
}

#[test]
fn an_index_past_the_vertices_is_an_error() {
    let mut maker = Maker::triangle();
    let indices = maker.indices(&[0, 1, 3]);
    maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let text = message("past", maker.load("past"));
    assert!(text.contains("index 2 of mesh 0, primitive 0 is 3, but there are only 3"), "{text}");
}

#[test]
fn a_position_that_is_not_finite_is_an_error() {
    let mut maker = Maker::triangle();
    maker.buffer[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(message("nan", maker.load("nan")).contains("not finite, at vertex 1"));
}

#[test]
fn a_world_position_past_f32_is_an_error() {
    let mut maker = Maker::triangle();
    maker.buffer[12..16].copy_from_slice(&10.0_f32.to_le_bytes());
    maker.json["nodes"][0]["scale"] = json!([3e38, 1.0, 1.0]);
    assert!(message("range", maker.load("range")).contains("passes the range of f32"));
}

#[test]
fn a_cycle_and_a_shared_child_are_errors() {
    for nodes in [
        json!([{ "children": [1] }, { "children": [2], "mesh": 0 }, { "children": [0] }]),
        json!([{ "children": [1, 2] }, { "children": [3] }, { "children": [3] }, { "mesh": 0 }]),
    ] {
        let mut maker = Maker::triangle();
        maker.json["nodes"] = nodes;
        assert!(message("cycle", maker.load("cycle")).contains("own ancestor or has two parents"));
    }
}

#[test]
fn instances_are_limited() {
    let mut maker = Maker::triangle();
    // Placements out of no data, fewer than the limit until four primitives multiply them.
    let primitive = maker.json["meshes"][0]["primitives"][0].clone();
    maker.json["meshes"][0]["primitives"] = json!([primitive, primitive, primitive, primitive]);
    let placements = json!({ "componentType": FLOAT, "type": "VEC3", "count": 2_000_000 });
    maker.json["accessors"].as_array_mut().unwrap().push(placements);
    maker.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": 1 } } });
    assert!(message("many", maker.load("many")).contains("instances pass the limit"));
    maker.json["accessors"][1]["count"] = json!(50_000_000);
    assert!(message("many", maker.load("many")).contains("instances pass the limit"));
}

#[test]
fn missing_files_and_folders_are_errors() {
    assert!(message("nowhere.glb", Scene::load(&path("nowhere.glb"))).contains("check the path"));
    assert!(Scene::load(&path("")).is_err());
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let whole = Maker::triangle().glb();
    for length in 0..whole.len() {
        message("cut.glb", load("cut.glb", &whole[..length]));
    }
    load("cut.glb", &whole).unwrap();
}

#[test]
fn garbage_and_damage_never_panic() {
    let mut random = rand_pcg::Pcg64::seed_from_u64(7);
    let mut maker = Maker::triangle();
    let attribute = maker.floats(&TRIANGLE);
    maker.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": attribute } } });
    let whole = maker.glb();
    for _ in 0..3000 {
        let mut damaged = whole.clone();
        for _ in 0..random.random_range(1..6) {
            let at = random.random_range(0..damaged.len());
            // Digits make for more files that parse than any byte would.
            damaged[at] = if random.random() { random.random_range(b'0'..=b'9') } else { random.random() };
        }
        if let Ok(scene) = load("damaged.glb", &damaged) {
            assert!(scene.bounds().is_some());
        }
    }
    for length in [0, 1, 4, 11, 12, 19, 20, 64] {
        let garbage: Vec<u8> = (0..length).map(|_| random.random()).collect();
        message("garbage.glb", load("garbage.glb", &garbage));
        message("garbage.glb", load("garbage.glb", &[&b"glTF"[..], &garbage].concat()));
    }
}
