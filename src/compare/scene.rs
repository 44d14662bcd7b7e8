//! Scenes to measure with: glTF files, or made in code by [`procedural`](super::procedural).
//!
//! A [`Scene`] is plain data on the host: triangle meshes, instances of them, materials, and the point lights that
//! the file names. World space is right-handed with +Y up, as in glTF; lengths are in the file's own unit.

mod accessor;
mod cameras;
mod document;
mod load;
mod suggest;

use std::path::{Path, PathBuf};

use glam::{Affine3A, DAffine3, DVec2, DVec3, Vec3};

use super::{AlphaMask, CutOuts};
use crate::Indices;
use crate::chunks::{ClosedPiece, closed_pieces};

pub use cameras::{STATED_SIZE, stated_camera};

/// A scene: meshes, their instances, materials, images and point lights.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// File stem, or the name of the procedural scene.
    pub name: String,
    /// Triangle meshes, one per drawn glTF primitive.
    pub meshes: Vec<SceneMesh>,
    /// Every drawn placement of a mesh.
    pub instances: Vec<SceneInstance>,
    /// Materials that the meshes refer to.
    pub materials: Vec<Material>,
    /// Decoded base colour images that the materials refer to; 8 bits per channel, sRGB colour with linear alpha.
    pub images: Vec<image::RgbaImage>,
    /// Point lights that the scene itself defines; may be empty.
    pub lights: Vec<SceneLight>,
}

/// One indexed triangle list in object space.
#[derive(Clone, Debug, Default)]
pub struct SceneMesh {
    /// Vertex positions in object space; all finite.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals in object space, one per position. May hold zero or non-finite vectors where the file does.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates of the base colour image, one per position; (0, 0) is the upper left of the image.
    pub tex_coords: Option<Vec<[f32; 2]>>,
    /// Three per triangle, each below the number of positions; front faces are counter-clockwise.
    pub indices: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// One placement of a mesh in the world.
#[derive(Clone, Copy, Debug)]
pub struct SceneInstance {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Object space to world space; may mirror (negative determinant) and scale non-uniformly.
    pub transform: Affine3A,
}

/// What a surface looks like, as far as the shadow examples shade it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Linear RGB and alpha, each in 0..=1; multiplies the image where there is one.
    pub base_color: [f32; 4],
    /// Index into [`Scene::images`].
    pub base_color_image: Option<usize>,
    /// How the image goes on past its edges, across and down.
    pub address_modes: [wgpu::AddressMode; 2],
    /// How alpha is used.
    pub alpha: Alpha,
    /// Whether back faces are drawn too.
    pub double_sided: bool,
    /// Linear RGB of emitted light, not negative.
    pub emissive: [f32; 3],
}

impl Default for Material {
    /// glTF's default material: opaque white, single-sided.
    fn default() -> Self {
        Self {
            base_color: [1.0; 4],
            base_color_image: None,
            address_modes: [wgpu::AddressMode::Repeat; 2],
            alpha: Alpha::Opaque,
            double_sided: false,
            emissive: [0.0; 3],
        }
    }
}

/// How a material uses alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Alpha is ignored.
    Opaque,
    /// A surface is drawn where its alpha is at least `cutoff`, and is a hole elsewhere.
    Mask {
        /// Smallest alpha that is drawn, normally in 0..=1. Compared with the product of image and base colour.
        cutoff: f32,
    },
    /// Alpha is coverage. Casts as if it were opaque.
    Blend,
}

/// Where a mesh has holes.
#[derive(Clone, Copy, Debug)]
pub struct SceneMask<'a> {
    /// Index into [`Scene::images`].
    pub image: usize,
    /// Texture coordinates, one per position.
    pub tex_coords: &'a [[f32; 2]],
    /// Smallest alpha of the image that casts, in 0..=1.
    pub cutoff: f32,
    /// How the image goes on past its edges, across and down.
    pub address_modes: [wgpu::AddressMode; 2],
}

/// A point light of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneLight {
    /// World-space position.
    pub position: Vec3,
    /// Linear RGB.
    pub color: [f32; 3],
    /// Candela, as in `KHR_lights_punctual`.
    pub intensity: f32,
    /// World-space distance past which the light adds nothing; `None` for no limit.
    pub range: Option<f32>,
}

/// A perspective view of a scene, with +Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World-space position.
    pub eye: Vec3,
    /// World-space point in the middle of the picture; differs from `eye`.
    pub target: Vec3,
    /// Full vertical angle of view in radians.
    pub fov_y: f32,
}

/// Every drawn triangle of a scene in world space, instances expanded; the three lists run in parallel.
#[derive(Clone, Debug, Default)]
pub struct WorldTriangles {
    /// World-space corners. Each coordinate is a value of `f32`, since that is what a GPU store holds.
    pub corners: Vec<[DVec3; 3]>,
    /// Index into [`Scene::instances`].
    pub instance: Vec<u32>,
    /// Index of the triangle within its mesh.
    pub triangle: Vec<u32>,
}

impl SceneMesh {
    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// Positions that some triangle uses, in order: glTF lets a mesh hold more.
    fn drawn_positions(&self) -> Vec<Vec3> {
        let mut used = vec![false; self.positions.len()];
        for &index in &self.indices {
            used[index as usize] = true;
        }
        let drawn = self.positions.iter().zip(used).filter(|(_, used)| *used);
        drawn.map(|(&position, _)| position.into()).collect()
    }
}

impl SceneInstance {
    /// The order in which a triangle's corners are anticlockwise around the front.
    fn front_order(&self) -> [usize; 3] {
        if self.transform.matrix3.determinant() < 0.0 { [0, 2, 1] } else { [0, 1, 2] }
    }
}

impl Scene {
    /// Loads the default scene of a `.glb` or `.gltf` file, with its buffers and base colour images, embedded or
    /// beside it.
    ///
    /// Triangle strips and fans become lists; points and lines are left out. Skinned and morphed meshes are taken in
    /// their rest shape. Node transforms are composed in `f64` and rounded once. `KHR_lights_punctual` point lights,
    /// `EXT_mesh_gpu_instancing` and `KHR_mesh_quantization` are honoured.
    ///
    /// # Errors
    ///
    /// [`SceneError`], for a file that cannot be read, is not glTF 2.0, is broken or inconsistent, needs an extension
    /// that is not honoured, or draws no triangle.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        load::load(path)
    }

    /// Lowest and highest corner in world space over all drawn triangles; `None` if nothing is drawn.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let points = self.drawn_points().map(|point| (point, point));
        points.reduce(|(low, high), (point, _)| (low.min(point), high.max(point)))
    }

    /// World-space positions of all vertices that some drawn triangle uses.
    fn drawn_points(&self) -> impl Iterator<Item = Vec3> {
        let drawn: Vec<_> = self.meshes.iter().map(SceneMesh::drawn_positions).collect();
        self.instances.iter().flat_map(move |instance| {
            let to_world = |&position| instance.transform.transform_point3(position);
            drawn[instance.mesh].iter().map(to_world).collect::<Vec<_>>()
        })
    }

    /// Number of drawn triangles, instances counted.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|instance| self.meshes[instance.mesh].triangle_count()).sum()
    }

    /// All drawn triangles in world space, in the order of the instances and then of the mesh's indices.
    ///
    /// Front faces are anticlockwise: a mirrored instance (negative determinant) turns its triangles round, so their
    /// second and third corners are exchanged. Positions are transformed in `f64` by the `f32` transform and rounded to
    /// `f32`. Takes 80 bytes per triangle.
    #[must_use]
    pub fn world_triangles(&self) -> WorldTriangles {
        let count = self.triangle_count();
        let mut out = WorldTriangles {
            corners: Vec::with_capacity(count),
            instance: Vec::with_capacity(count),
            triangle: Vec::with_capacity(count),
        };
        for (index, instance) in (0_u32..).zip(&self.instances) {
            let mesh = &self.meshes[instance.mesh];
            let world = world_positions(mesh, instance.transform);
            let order = instance.front_order();
            let corners = mesh.indices.chunks_exact(3).map(|corner| order.map(|k| world[corner[k] as usize]));
            out.corners.extend(corners);
            out.instance.resize(out.corners.len(), index);
            out.triangle.extend(0..mesh.triangle_count() as u32);
        }
        out
    }

    /// Where a mesh has holes. `None` for one whose material isn't masked, and for one without an image or without
    /// texture coordinates, which has the same alpha everywhere.
    #[must_use]
    pub fn mask<'a>(&'a self, mesh: &'a SceneMesh) -> Option<SceneMask<'a>> {
        let material = self.materials.get(mesh.material)?;
        let Alpha::Mask { cutoff } = material.alpha else { return None };
        let (image, tex_coords) = (material.base_color_image?, mesh.tex_coords.as_ref()?);
        // Of a material that leaves nothing nothing was loaded.
        let cutoff = if cutoff > 0.0 { (cutoff / material.base_color[3]).clamp(0.0, 1.0) } else { 0.0 };
        Some(SceneMask { image, tex_coords, cutoff, address_modes: material.address_modes })
    }

    /// Whether anything in it has holes.
    #[must_use]
    pub fn has_holes(&self) -> bool {
        self.meshes.iter().any(|mesh| self.mask(mesh).is_some())
    }

    /// The holes of all triangles; empty if there are none.
    #[must_use]
    pub fn cut_outs(&self, triangles: &WorldTriangles) -> CutOuts {
        if !self.has_holes() {
            return CutOuts::default();
        }
        let masks: Vec<_> = self.meshes.iter().map(|mesh| self.mask(mesh)).collect();
        // A place for each mesh, masked or not.
        let nothing = image::RgbaImage::default();
        let alphas = masks.iter().map(|mask| match mask {
            Some(mask) => AlphaMask::new(&self.images[mask.image], mask.cutoff, mask.address_modes),
            None => AlphaMask::new(&nothing, 0.0, [wgpu::AddressMode::Repeat; 2]),
        });
        let of_triangle = |(&instance, &triangle): (&u32, &u32)| {
            let instance = &self.instances[instance as usize];
            let mesh = instance.mesh;
            let corners = &self.meshes[mesh].indices[3 * triangle as usize..][..3];
            let coordinates = masks[mesh]?.tex_coords;
            let pair = |k: usize| DVec2::from(coordinates[corners[k] as usize].map(f64::from));
            Some((mesh as u32, instance.front_order().map(pair)))
        };
        let triangles = triangles.instance.iter().zip(&triangles.triangle).map(of_triangle).collect();
        CutOuts { masks: alphas.collect(), triangles }
    }

    /// Whether a renderer draws and lights both sides of a mesh: what its material says. A mesh whose material isn't in
    /// the scene has the default one, single-sided.
    #[must_use]
    pub fn is_double_sided(&self, mesh: &SceneMesh) -> bool {
        self.materials.get(mesh.material).is_some_and(|material| material.double_sided)
    }

    /// For all triangles in turn, whether a renderer draws and lights both of their sides.
    #[must_use]
    pub fn double_sided(&self, triangles: &WorldTriangles) -> Vec<bool> {
        let meshes: Vec<bool> = self.meshes.iter().map(|mesh| self.is_double_sided(mesh)).collect();
        triangles.instance.iter().map(|&instance| meshes[self.instances[instance as usize].mesh]).collect()
    }

    /// For all triangles in turn, the closed piece of an instance that hides its inside: of a mesh whose both sides are
    /// drawn, so that the outside covers it, and that nothing shows through, neither holes nor blending. Empty if no
    /// mesh is such a one. Pieces are those that the library finds in casters; their triangles are by place in the list.
    pub(super) fn closed_pieces(&self, triangles: &WorldTriangles) -> Vec<Option<ClosedPiece>> {
        let covers = |mesh: &&SceneMesh| self.is_double_sided(mesh) && !self.is_seen_through(mesh);
        if !self.meshes.iter().any(|mesh| covers(&mesh)) {
            return Vec::new();
        }
        let find = |mesh: &SceneMesh| closed_pieces(&mesh.positions, Indices::U32(&mesh.indices));
        let meshes: Vec<_> = self.meshes.iter().map(|mesh| Some(mesh).filter(covers).map(find)).collect();
        let of_triangle = |(place, (&instance, &triangle)): (u32, (&u32, &u32))| {
            let piece = meshes[self.instances[instance as usize].mesh].as_ref()?[triangle as usize]?;
            Some(ClosedPiece { triangle: place - triangle + piece.triangle, ..piece })
        };
        (0..).zip(triangles.instance.iter().zip(&triangles.triangle)).map(of_triangle).collect()
    }

    /// Whether things behind a mesh's surface may be seen through it.
    fn is_seen_through(&self, mesh: &SceneMesh) -> bool {
        let blends = self.materials.get(mesh.material).is_some_and(|material| material.alpha == Alpha::Blend);
        blends || self.mask(mesh).is_some()
    }

    /// The same scene with masked materials made opaque, for methods that know no holes.
    #[must_use]
    pub fn without_holes(&self) -> Self {
        let mut scene = self.clone();
        for material in &mut scene.materials {
            if let Alpha::Mask { .. } = material.alpha {
                material.alpha = Alpha::Opaque;
            }
        }
        scene
    }

    /// A light position for a scene that names none: away from surfaces, in front of them rather than behind, and
    /// with much of the scene around it. The same scene always gives the same position; an empty one gives the
    /// origin.
    ///
    /// Works on a sample of the triangles, so that it takes well under a second however large the scene is.
    #[must_use]
    pub fn suggest_light(&self) -> Vec3 {
        suggest::light(self)
    }

    /// A view that shows the scene lit from `light` (world space): from within the room where the light is enclosed,
    /// else from outside with the scene framed.
    #[must_use]
    pub fn suggest_camera(&self, light: Vec3) -> Camera {
        suggest::camera(self, light)
    }
}

fn world_positions(mesh: &SceneMesh, transform: Affine3A) -> Vec<DVec3> {
    let transform = DAffine3::from_cols(
        transform.matrix3.x_axis.as_dvec3(),
        transform.matrix3.y_axis.as_dvec3(),
        transform.matrix3.z_axis.as_dvec3(),
        transform.translation.as_dvec3(),
    );
    let to_world = |position: &[f32; 3]| transform.transform_point3(Vec3::from(*position).as_dvec3());
    mesh.positions.iter().map(|position| to_world(position).as_vec3().as_dvec3()).collect()
}

/// Why a scene did not load.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file, or one it refers to, cannot be read.
    #[error("cannot read {path}: {source}; check the path and that it is a readable file")]
    Read {
        /// The file that cannot be read.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not glTF 2.0, or cut short.
    #[error("{path} is not a whole glTF 2.0 file: {reason}; fetch or export it again")]
    Format {
        /// The file.
        path: PathBuf,
        /// What was found, and where.
        reason: String,
    },
    /// The file requires an extension that this loader does not honour.
    #[error("{path} requires the glTF extension {extension}, which is not honoured; {remedy}")]
    Extension {
        /// The file.
        path: PathBuf,
        /// The extension's name.
        extension: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// Something in the file refers past the end of a list.
    #[error("{path}: {what} is {index}, but there are only {count}; export the file again")]
    Index {
        /// The file.
        path: PathBuf,
        /// Which reference it is.
        what: String,
        /// The value found.
        index: u64,
        /// The length of the list referred to.
        count: usize,
    },
    /// The file contradicts itself or the glTF specification.
    #[error("{path}: {what}; export the file again")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the value.
        what: String,
    },
    /// The scene is larger than the loader accepts.
    #[error("{path}: {what} pass the limit of {limit}; split the scene")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What there is too much of.
        what: &'static str,
        /// The largest number accepted.
        limit: usize,
    },
    /// A base colour image is missing or broken.
    #[error("{path}: image {image} cannot be used: {reason}; embed it as PNG or JPEG")]
    Image {
        /// The file.
        path: PathBuf,
        /// Index of the image in the file.
        image: usize,
        /// What is wrong.
        reason: String,
    },
    /// Nothing to draw.
    #[error("{path} draws no triangle in its default scene; export one with a mesh placed by a node")]
    NoTriangles {
        /// The file.
        path: PathBuf,
    },
}

/// Folder of the test scenes: the environment variable `DP_SCENES`, else `../shared/scenes` beside this crate.
///
/// `None` if that folder does not exist; the scenes are third-party files and not part of this repository.
#[must_use]
pub fn scenes_dir() -> Option<PathBuf> {
    let default = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let dir = std::env::var_os("DP_SCENES").map_or_else(default, PathBuf::from);
    dir.is_dir().then_some(dir)
}

/// The `.glb` and `.gltf` files of a folder, by name.
///
/// # Errors
/// [`SceneError::Read`] if the folder can't be read.
pub fn scene_files(folder: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let entries = std::fs::read_dir(folder).map_err(|source| SceneError::Read { path: folder.to_owned(), source })?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf");
    let mut files: Vec<PathBuf> = paths.filter(is_scene).collect();
    files.sort();
    Ok(files)
}

/// World-space light positions for the test scenes, by file name.
///
/// They are free of geometry and see front faces first. Those of `dutch_ship.glb`, `alpha_modes.glb`,
/// `teapots_expanded.glb`, `flight_helmet.glb` and `head_lps.glb` are ours, rounded results of
/// [`Scene::suggest_light`]. `lights_level_blenvy.glb` has point lights of its own and is not in the list.
pub const LIGHTS: &[(&str, &[[f32; 3]])] = &[
    (
        "interior_pandora.glb",
        &[[-0.24, 2.0, -1.48], [-17.43, 17.2, -8.86], [21.35, 17.2, 8.56], [15.5, 17.2, 7.88], [-15.12, 2.0, 14.09]],
    ),
    ("gallery_vr.glb", &[[2.73, 1.64, -2.15], [-2.72, 1.53, 1.93], [-0.02, 3.29, -0.28]]),
    ("fog_arcade_bevy.glb", &[[0.0, 3.15, 2.74], [0.27, 2.87, 1.12], [-0.05, 2.99, -0.85]]),
    ("cornell_nvpro.glb", &[[-1.19, 1.16, 3.07], [0.0, 3.0, 0.0]]),
    ("town_godot.glb", &[[0.0, 12.0, 0.0]]),
    ("barn_lamp.glb", &[[0.0, -0.25, 0.15]]),
    ("carbon_cage.glb", &[[-0.14, 0.46, 0.0]]),
    ("house_masked.glb", &[[0.1, 0.06, 0.12]]),
    ("mirrored_props.glb", &[[0.0, -2.5, 0.0]]),
    ("dutch_ship.glb", &[[-1.4, 6.1, 5.1]]),
    ("alpha_modes.glb", &[[1.56, 1.43, 1.39]]),
    ("teapots_expanded.glb", &[[-36.0, 76.0, -28.0]]),
    ("flight_helmet.glb", &[[0.19, 0.31, -0.09]]),
    ("head_lps.glb", &[[0.18, 0.23, 0.04]]),
];

/// Light positions of [`LIGHTS`] for a scene, by file name with or without its extension; empty for an unknown one.
#[must_use]
pub fn known_lights(name: &str) -> &'static [[f32; 3]] {
    let stem = name.strip_suffix(".glb").unwrap_or(name);
    let found = LIGHTS.iter().find(|(file, _)| file.strip_suffix(".glb") == Some(stem));
    found.map_or(&[], |(_, lights)| lights)
}
