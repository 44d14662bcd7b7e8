//! From a glTF document to a [`Scene`].

use std::{collections::HashMap, io::Cursor, ops::Range, path::Path};

use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, Vec3};
use gltf::json::{
    self,
    accessor::Type,
    extensions::scene::khr_lights_punctual,
    material::AlphaMode,
    mesh::{Mode, Semantic},
    texture::WrappingMode,
    validation::Checked,
};

use super::{
    Alpha, Material, Scene, SceneError, SceneInstance, SceneLight, SceneMesh, accessor::Reader, document::Document,
};

/// More than any test scene has; nodes times primitives of a hostile file could be anything.
const MAX_INSTANCES: usize = 1 << 22;

/// Of textures without a sampler.
const DEFAULT_MODES: [wgpu::AddressMode; 2] = [wgpu::AddressMode::Repeat; 2];

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

pub(super) fn load(path: &Path) -> Result<Scene, SceneError> {
    let document = Document::read(path)?;
    let mut loader = Loader {
        reader: Reader::new(&document),
        document: &document,
        scene: Scene { name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), ..Scene::default() },
        meshes: HashMap::new(),
        materials: HashMap::new(),
        images: HashMap::new(),
    };
    loader.walk()?;
    if loader.scene.triangle_count() == 0 {
        return Err(SceneError::NoTriangles { path: path.to_owned() });
    }
    if !loader.scene.drawn_points().all(Vec3::is_finite) {
        return Err(document.invalid("in world space a position passes the range of f32"));
    }
    Ok(loader.scene)
}

/// The scene as far as it is built, and where each of the file's objects went; only what is drawn is read.
struct Loader<'a> {
    document: &'a Document,
    reader: Reader<'a>,
    scene: Scene,
    /// A glTF mesh is one of ours per primitive.
    meshes: HashMap<usize, Range<usize>>,
    /// `None` is glTF's default material.
    materials: HashMap<Option<usize>, usize>,
    images: HashMap<usize, usize>,
}

impl Loader<'_> {
    /// Visits the nodes of the default scene, parents first.
    fn walk(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let root = &document.root;
        let default = root.scene.map_or(0, |scene| scene.value());
        let scene = document.item(&root.scenes, default, || "the default scene".to_owned())?;
        let mut seen = vec![false; root.nodes.len()];
        let top = scene.nodes.iter().rev();
        let mut stack: Vec<_> = top.map(|node| (node.value(), DAffine3::IDENTITY)).collect();
        while let Some((index, parent)) = stack.pop() {
            let node = document.item(&root.nodes, index, || "a node of the scene".to_owned())?;
            if std::mem::replace(&mut seen[index], true) {
                return Err(document.invalid(format!("node {index} is its own ancestor or has two parents")));
            }
            let world = parent * self.local_transform(index, node)?;
            self.visit(index, node, world)?;
            let children = node.children.iter().flatten().rev();
            stack.extend(children.map(|child| (child.value(), world)));
        }
        Ok(())
    }

    fn visit(&mut self, index: usize, node: &json::Node, world: DAffine3) -> Result<(), SceneError> {
        if let Some(extensions) = &node.extensions
            && let Some(light) = &extensions.khr_lights_punctual
        {
            self.add_light(light.light.value(), world)?;
        }
        let Some(mesh) = node.mesh else {
            return Ok(());
        };
        let meshes = self.mesh(mesh.value())?;
        let placements = match node.extensions.as_ref().and_then(|extensions| extensions.others.get(INSTANCING)) {
            Some(extension) => self.placements(index, extension)?,
            None => vec![DAffine3::IDENTITY],
        };
        self.check_instances(placements.len().saturating_mul(meshes.len()))?;
        for placement in placements {
            let transform = self.round(index, world * placement)?;
            self.scene.instances.extend(meshes.clone().map(|mesh| SceneInstance { mesh, transform }));
        }
        Ok(())
    }

    fn check_instances(&self, added: usize) -> Result<(), SceneError> {
        if self.scene.instances.len().saturating_add(added) <= MAX_INSTANCES {
            return Ok(());
        }
        Err(SceneError::TooLarge { path: self.document.path.clone(), what: "instances", limit: MAX_INSTANCES })
    }

    fn local_transform(&self, index: usize, node: &json::Node) -> Result<DAffine3, SceneError> {
        if let Some(matrix) = &node.matrix {
            let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
            return Ok(DAffine3::from_mat4(matrix));
        }
        let translation = node.translation.unwrap_or([0.0; 3]).map(f64::from);
        let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
        let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
        self.compose(index, translation, rotation, scale)
    }

    fn compose(
        &self,
        node: usize,
        translation: [f64; 3],
        rotation: [f64; 4],
        scale: [f64; 3],
    ) -> Result<DAffine3, SceneError> {
        let rotation = DQuat::from_array(rotation);
        // Rounded and normalised-integer quaternions are not quite of length one.
        if !rotation.is_finite() || rotation.length() < 0.5 {
            return Err(self
                .document
                .invalid(format!("node {node} has the rotation {rotation}, which is not of length 1")));
        }
        Ok(DAffine3::from_scale_rotation_translation(scale.into(), rotation.normalize(), translation.into()))
    }

    fn round(&self, node: usize, world: DAffine3) -> Result<Affine3A, SceneError> {
        let column = |column: DVec3| column.as_vec3();
        let axes = world.matrix3;
        let rounded = Affine3A::from_cols(
            column(axes.x_axis).into(),
            column(axes.y_axis).into(),
            column(axes.z_axis).into(),
            column(world.translation).into(),
        );
        if !rounded.is_finite() {
            return Err(self.document.invalid(format!("the world transform of node {node} is not finite")));
        }
        Ok(rounded)
    }

    /// The transforms of `EXT_mesh_gpu_instancing`, relative to the node.
    fn placements(&self, node: usize, extension: &json::Value) -> Result<Vec<DAffine3>, SceneError> {
        let translation = self.instance_attribute::<3>(node, extension, "TRANSLATION", Type::Vec3)?;
        let rotation = self.instance_attribute::<4>(node, extension, "ROTATION", Type::Vec4)?;
        let scale = self.instance_attribute::<3>(node, extension, "SCALE", Type::Vec3)?;
        let counts =
            [translation.as_ref().map(Vec::len), rotation.as_ref().map(Vec::len), scale.as_ref().map(Vec::len)];
        let count = counts.into_iter().flatten().next();
        let count =
            count.ok_or_else(|| self.document.invalid(format!("node {node} is instanced without attributes")))?;
        if counts.into_iter().flatten().any(|other| other != count) {
            return Err(self.document.invalid(format!("the instance attributes of node {node} differ in length")));
        }
        // Before memory is taken for them; an accessor without data can state any count.
        self.check_instances(count)?;
        let placement = |k: usize| {
            let translation = translation.as_ref().map_or([0.0; 3], |all| all[k]);
            let rotation = rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[k]);
            let scale = scale.as_ref().map_or([1.0; 3], |all| all[k]);
            self.compose(node, translation, rotation, scale)
        };
        (0..count).map(placement).collect()
    }

    fn instance_attribute<const N: usize>(
        &self,
        node: usize,
        extension: &json::Value,
        name: &str,
        kind: Type,
    ) -> Result<Option<Vec<[f64; N]>>, SceneError> {
        let Some(value) = extension.get("attributes").and_then(|attributes| attributes.get(name)) else {
            return Ok(None);
        };
        let what = format!("the instance attribute {name} of node {node}");
        let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
        let index = index.ok_or_else(|| self.document.invalid(format!("{what} is {value}, which is no accessor")))?;
        self.reader.read(index, kind, &what).map(Some)
    }

    fn add_light(&mut self, index: usize, world: DAffine3) -> Result<(), SceneError> {
        let extension = self.document.root.extensions.as_ref().and_then(|all| all.khr_lights_punctual.as_ref());
        let lights = extension.map_or(&[][..], |extension| &extension.lights);
        let light = self.document.item(lights, index, || "the light of a node".to_owned())?;
        let position = world.translation.as_vec3();
        if !position.is_finite() {
            return Err(self.document.invalid(format!("the position of light {index} is not finite")));
        }
        if light.type_ == Checked::Valid(khr_lights_punctual::Type::Point) {
            let &khr_lights_punctual::Light { color, intensity, range, .. } = light;
            self.scene.lights.push(SceneLight { position, color, intensity, range });
        }
        Ok(())
    }

    /// Our meshes for a glTF mesh, read on first use.
    fn mesh(&mut self, index: usize) -> Result<Range<usize>, SceneError> {
        if let Some(range) = self.meshes.get(&index) {
            return Ok(range.clone());
        }
        let document = self.document;
        let mesh = document.item(&document.root.meshes, index, || "the mesh of a node".to_owned())?;
        let start = self.scene.meshes.len();
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let name = format!("mesh {index}, primitive {k}");
            if let Some(mesh) = self.primitive(&name, primitive)? {
                self.scene.meshes.push(mesh);
            }
        }
        let range = start..self.scene.meshes.len();
        self.meshes.insert(index, range.clone());
        Ok(range)
    }

    /// `None` for points and lines, which cast no shadow, and for what its material leaves nothing of.
    fn primitive(&mut self, name: &str, primitive: &json::mesh::Primitive) -> Result<Option<SceneMesh>, SceneError> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err(self.document.invalid(format!("{name} has an unknown mode")));
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(None);
        }
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
        let positions =
            attribute(Semantic::Positions).ok_or_else(|| self.document.invalid(format!("{name} has no POSITION")))?;
        let positions = self.vectors(positions, &format!("the positions of {name}"))?;
        if let Some(at) = positions.iter().position(|position| !position.iter().all(|x| x.is_finite())) {
            return Err(self.document.invalid(format!("{name} has a position that is not finite, at vertex {at}")));
        }
        let vertices = positions.len();
        let normals = attribute(Semantic::Normals)
            .map(|index| self.vectors(index, &format!("the normals of {name}")))
            .transpose()?;
        let tex_coords = attribute(Semantic::TexCoords(self.tex_coord_set(primitive.material)))
            .map(|index| self.reader.read::<2>(index, Type::Vec2, &format!("the texture coordinates of {name}")))
            .transpose()?
            .map(|all| all.into_iter().map(|pair| pair.map(|x| x as f32)).collect::<Vec<_>>());
        let lengths = [normals.as_ref().map(Vec::len), tex_coords.as_ref().map(Vec::len)];
        if let Some(length) = lengths.into_iter().flatten().find(|&length| length != vertices) {
            return Err(self
                .document
                .invalid(format!("{name} has {vertices} positions but {length} of another attribute")));
        }
        let corners = self.corners(name, primitive.indices, vertices)?;
        let material = self.material(primitive.material.map(|material| material.value()))?;
        let Material { base_color, alpha, .. } = self.scene.materials[material];
        if matches!(alpha, Alpha::Mask { cutoff } if cutoff > base_color[3]) {
            // Whatever its image, all of it is a hole.
            return Ok(None);
        }
        Ok(Some(SceneMesh { positions, normals, tex_coords, indices: triangle_list(mode, &corners), material }))
    }

    fn vectors(&self, index: usize, what: &str) -> Result<Vec<[f32; 3]>, SceneError> {
        let values = self.reader.read::<3>(index, Type::Vec3, what)?;
        Ok(values.into_iter().map(|value| value.map(|x| x as f32)).collect())
    }

    /// The vertices that a primitive runs through, each known to exist.
    fn corners(
        &self,
        name: &str,
        accessor: Option<json::Index<json::Accessor>>,
        vertices: usize,
    ) -> Result<Vec<u32>, SceneError> {
        let Some(accessor) = accessor else {
            return Ok((0..vertices as u32).collect());
        };
        let corners = self.reader.read::<1>(accessor.value(), Type::Scalar, &format!("the indices of {name}"))?;
        let valid = |&[index]: &[f64; 1]| index >= 0.0 && index < vertices as f64 && index.fract() == 0.0;
        if let Some(bad) = corners.iter().position(|corner| !valid(corner)) {
            return Err(SceneError::Index {
                path: self.document.path.clone(),
                what: format!("index {bad} of {name}"),
                index: corners[bad][0] as u64,
                count: vertices,
            });
        }
        Ok(corners.into_iter().map(|[index]| index as u32).collect())
    }

    /// Which set of texture coordinates the material's base colour image uses.
    fn tex_coord_set(&self, material: Option<json::Index<json::Material>>) -> u32 {
        let material = material.and_then(|material| self.document.root.materials.get(material.value()));
        let texture = material.and_then(|material| material.pbr_metallic_roughness.base_color_texture.as_ref());
        texture.map_or(0, |texture| texture.tex_coord)
    }

    fn material(&mut self, index: Option<usize>) -> Result<usize, SceneError> {
        if let Some(&material) = self.materials.get(&index) {
            return Ok(material);
        }
        let material = match index {
            Some(index) => self.convert_material(index)?,
            None => Material::default(),
        };
        self.scene.materials.push(material);
        self.materials.insert(index, self.scene.materials.len() - 1);
        Ok(self.scene.materials.len() - 1)
    }

    fn convert_material(&mut self, index: usize) -> Result<Material, SceneError> {
        let document = self.document;
        let material = document.item(&document.root.materials, index, || "the material of a primitive".to_owned())?;
        let alpha = match material.alpha_mode {
            Checked::Valid(AlphaMode::Opaque) => Alpha::Opaque,
            Checked::Valid(AlphaMode::Mask) => Alpha::Mask { cutoff: material.alpha_cutoff.unwrap_or_default().0 },
            Checked::Valid(AlphaMode::Blend) => Alpha::Blend,
            Checked::Invalid => {
                return Err(document.invalid(format!("material {index} has an unknown alpha mode")));
            }
        };
        let surface = &material.pbr_metallic_roughness;
        let texture = surface.base_color_texture.as_ref();
        let image = texture.map(|texture| self.texture(texture.index.value())).transpose()?;
        Ok(Material {
            base_color: surface.base_color_factor.0,
            base_color_image: image,
            address_modes: texture.map_or(Ok(DEFAULT_MODES), |texture| self.address_modes(texture.index.value()))?,
            alpha,
            double_sided: material.double_sided,
            emissive: material.emissive_factor.0,
        })
    }

    /// How a texture goes on past its edges.
    fn address_modes(&self, texture: usize) -> Result<[wgpu::AddressMode; 2], SceneError> {
        let document = self.document;
        let texture = document.item(&document.root.textures, texture, || "the texture of a material".to_owned())?;
        let Some(sampler) = texture.sampler else { return Ok(DEFAULT_MODES) };
        let what = || "the sampler of a texture".to_owned();
        let sampler = document.item(&document.root.samplers, sampler.value(), what)?;
        let mode = |mode| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => Ok(wgpu::AddressMode::ClampToEdge),
            Checked::Valid(WrappingMode::MirroredRepeat) => Ok(wgpu::AddressMode::MirrorRepeat),
            Checked::Valid(WrappingMode::Repeat) => Ok(wgpu::AddressMode::Repeat),
            Checked::Invalid => Err(document.invalid("a sampler has an unknown wrapping mode")),
        };
        Ok([mode(sampler.wrap_s)?, mode(sampler.wrap_t)?])
    }

    /// The decoded image behind a texture, as an index into the scene's images.
    fn texture(&mut self, index: usize) -> Result<usize, SceneError> {
        let document = self.document;
        let texture = document.item(&document.root.textures, index, || "the texture of a material".to_owned())?;
        let source = texture.source.value();
        // How the schema crate says "absent", which is so where only an extension names the image.
        if source == u32::MAX as usize {
            return Err(document.invalid(format!("texture {index} has no PNG or JPEG image")));
        }
        if let Some(&image) = self.images.get(&source) {
            return Ok(image);
        }
        let bytes = document.image_bytes(source)?;
        let decoded = image::ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(image::ImageError::from)
            .and_then(image::ImageReader::decode)
            .map_err(|error| document.image_error(source, error))?;
        self.scene.images.push(decoded.into_rgba8());
        self.images.insert(source, self.scene.images.len() - 1);
        Ok(self.scene.images.len() - 1)
    }
}

/// Unrolls strips and fans in the vertex order of the glTF specification, section 3.7.2.1; an incomplete triangle at
/// the end is dropped, as a GPU does.
fn triangle_list(mode: Mode, corners: &[u32]) -> Vec<u32> {
    let triangles = corners.len().saturating_sub(2);
    match mode {
        Mode::TriangleStrip => {
            let triangle = |i: usize| [corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]];
            (0..triangles).flat_map(triangle).collect()
        }
        Mode::TriangleFan => (0..triangles).flat_map(|i| [corners[i + 1], corners[i + 2], corners[0]]).collect(),
        _ => corners[..corners.len() / 3 * 3].to_vec(),
    }
}
