//! Other ways to make a point light's shadow map, to measure this library against.
//!
//! All make reversed depth, cleared to 0 and of four bytes but for [`Method::Cube16`], from the same casters, and record
//! everything from scratch each time. Those that draw as engines do take meshes in their own space and a transform for each instance.

mod cube;
mod cube_array;
mod cube_compute;
mod cube_lookup;
mod cube_map;
mod cube_routed;
mod culling;
mod depth_view;
mod instanced;
mod lookup;
mod method;
mod own_maps;
mod scene_buffers;
mod vertex_warp;

pub use cube::{Cube, CubeMultiview, Culling};
pub(super) use cube_array::{CubeArray, text as cube_array_text};
pub use cube_compute::CubeCompute;
pub(super) use cube_compute::shape as cube_shape;
pub use cube_map::CubeDepth;
pub use cube_routed::CubeRouted;
pub use depth_view::DepthView;
pub use lookup::{Bias, Lookup};
pub use method::{Budget, Method, UnknownMethod};
pub use scene_buffers::SceneBuffers;
pub use vertex_warp::VertexWarp;

use super::fill;
use super::gpu::{Evaluator, Gpu, evaluation, evaluation_over};
use super::scene::Scene;
use crate::{Casters, Error, PointLight, PointShadows, Sides, Stage};
use glam::Vec3;
use instanced::PassKind;
use method::NO_MULTIVIEW;
use own_maps::OwnMaps;

/// A scene's casters in both forms that the methods draw from.
#[derive(Debug)]
pub struct DeviceScene {
    /// In mesh space with instances, as engines have them.
    pub instanced: SceneBuffers,
    /// In world space and chunks, as this library has them.
    pub chunked: Casters,
}

impl DeviceScene {
    /// Uploads a scene in both forms, all meshes with the same rule for sides. [`Sides::Front`] culls back faces in
    /// all methods. Of holes only [`Method::Paraboloid`] knows: to compare methods give [`Scene::without_holes`].
    ///
    /// # Errors
    /// Whatever [`fill`] and [`SceneBuffers::new`] return.
    pub fn new(gpu: &Gpu, scene: &Scene, sides: Sides) -> Result<Self, Error> {
        let mut chunked = Casters::new(&gpu.device)?;
        fill(&mut chunked, gpu, scene, sides)?;
        Ok(Self { instanced: SceneBuffers::new(&gpu.device, scene, sides == Sides::Front)?, chunked })
    }
}

/// Why there is no [`Baseline`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// The device can't do it, or nothing can yet.
    #[error("{method} is left out: {reason}")]
    Unsupported {
        /// What was asked for.
        method: Method,
        /// What is missing.
        reason: &'static str,
    },
    /// The map would be wider than the device's largest texture, or nothing.
    #[error("the resolution of {method} is {resolution}: it must be 1 to {most}")]
    Resolution {
        /// What was asked for.
        method: Method,
        /// Its resolution.
        resolution: u32,
        /// The largest one that the device allows.
        most: u32,
    },
    /// The library's own.
    #[error(transparent)]
    Library(#[from] Error),
}

/// Any of the methods behind one interface, with a map for one light.
#[derive(Debug)]
pub struct Baseline {
    method: Method,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Pair(Box<OwnMaps>),
    VertexWarp(VertexWarp),
    Cube(Cube),
    CubeRouted(CubeRouted),
    CubeMultiview(CubeMultiview),
    CubeCompute(Box<CubeCompute>),
    DepthView(DepthView),
}

impl Baseline {
    /// Creates a method's map with `resolution` texels across each of its squares; see [`Method::side`].
    ///
    /// # Errors
    /// [`BaselineError`], for a resolution or a method that the device doesn't allow.
    pub fn new(device: &wgpu::Device, method: Method, resolution: u32) -> Result<Self, BaselineError> {
        let across = if method.is_cube() { 1 } else { 2 };
        let most = device.limits().max_texture_dimension_2d / across;
        if !(1..=most).contains(&resolution) {
            return Err(BaselineError::Resolution { method, resolution, most });
        }
        Ok(Self { method, kind: Kind::new(device, method, resolution)? })
    }

    /// Which method it is.
    #[must_use]
    pub fn method(&self) -> Method {
        self.method
    }

    /// Gives a lookup another bias, if it is one of this method's and has any, from the next submission on. The map
    /// stays as it is.
    pub fn set_bias(&mut self, queue: &wgpu::Queue, lookup: Lookup, bias: Bias) {
        match &mut self.kind {
            Kind::VertexWarp(warp) if lookup == Lookup::VertexWarp => warp.set_bias(queue, bias),
            Kind::Cube(cube) => cube.lookup_mut().set_bias(queue, lookup, bias),
            Kind::CubeRouted(cube) => cube.lookup_mut().set_bias(queue, lookup, bias),
            Kind::CubeMultiview(cube) => cube.lookup_mut().set_bias(queue, lookup, bias),
            Kind::CubeCompute(cube) => cube.lookup_mut().set_bias(queue, lookup, bias),
            Kind::Pair(_) | Kind::VertexWarp(_) | Kind::DepthView(_) => {}
        }
    }

    /// Says that no surface is nearer to the light than `nearest`, in world units, from the next recording on:
    /// [`Method::Cube16`] puts its near plane there. The other methods don't need to know.
    pub fn set_nearest(&mut self, nearest: f32) {
        if let Kind::Cube(cube) = &mut self.kind {
            cube.set_nearest(nearest);
        }
    }

    /// Records the whole map anew, whatever it holds already.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        scene: &mut DeviceScene,
        light: &PointLight,
    ) -> Result<(), Error> {
        light.validate()?;
        let instanced = &scene.instanced;
        match &mut self.kind {
            Kind::Pair(pair) => pair.record(device, queue, encoder, &mut scene.chunked, light)?,
            Kind::VertexWarp(warp) => warp.record(device, queue, encoder, instanced, light),
            Kind::Cube(cube) => cube.record(device, queue, encoder, instanced, light),
            Kind::CubeRouted(cube) => cube.record(device, queue, encoder, &mut scene.chunked, light),
            Kind::CubeMultiview(cube) => cube.record(device, queue, encoder, instanced, light),
            Kind::CubeCompute(cube) => cube.record(device, queue, encoder, &mut scene.chunked, light)?,
            Kind::DepthView(view) => view.record(device, queue, encoder, instanced),
        }
        Ok(())
    }

    /// The map: a cube's faces as layers, else two squares side by side.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        match &self.kind {
            Kind::Pair(pair) => pair.shadows().maps(),
            Kind::VertexWarp(warp) => warp.map(),
            Kind::Cube(cube) => cube.map(),
            Kind::CubeRouted(cube) => cube.map(),
            Kind::CubeMultiview(cube) => cube.map(),
            Kind::CubeCompute(cube) => cube.map(),
            Kind::DepthView(view) => view.map(),
        }
    }

    /// Texels of the map.
    #[must_use]
    pub fn texels(&self) -> u64 {
        let map = self.map();
        u64::from(map.width()) * u64::from(map.height()) * u64::from(map.depth_or_array_layers())
    }

    /// Bytes of the maps of one light: what each further light costs.
    #[must_use]
    pub fn bytes_per_light(&self) -> u64 {
        self.method.bytes_per_texel() * self.texels()
    }

    /// Bytes of the scene that only this method needs, however many lights there are: for methods that read [`Casters`]
    /// the casters' copies in world space, their chunks and masks. The meshes and transforms that a renderer has anyway,
    /// [`SceneBuffers`], don't count.
    #[must_use]
    pub fn bytes_scene(&self, scene: &DeviceScene) -> u64 {
        match &self.kind {
            Kind::Pair(_) | Kind::CubeRouted(_) | Kind::CubeCompute(_) => scene.chunked.memory(),
            Kind::VertexWarp(_) | Kind::Cube(_) | Kind::CubeMultiview(_) | Kind::DepthView(_) => 0,
        }
    }

    /// Bytes that lights share by taking turns: what recording takes beside the maps and the scene, such as lists of
    /// visible instances or triangles, and the lookup's description of the light. As large as the recordings so far
    /// made it.
    #[must_use]
    pub fn bytes_workspace(&self) -> u64 {
        match &self.kind {
            Kind::Pair(pair) => pair.shadows().memory() - self.bytes_per_light(),
            Kind::VertexWarp(warp) => warp.working_memory(),
            Kind::Cube(cube) => cube.working_memory(),
            Kind::CubeRouted(cube) => cube.working_memory(),
            Kind::CubeMultiview(cube) => cube.working_memory(),
            Kind::CubeCompute(cube) => cube.memory() - self.bytes_per_light(),
            Kind::DepthView(view) => view.working_memory(),
        }
    }

    /// [`Self::bytes_per_light`] and [`Self::bytes_workspace`].
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.bytes_per_light() + self.bytes_workspace()
    }

    /// The library's own shadows, if this is [`Method::Paraboloid`].
    #[must_use]
    pub fn shadows(&self) -> Option<&PointShadows> {
        match &self.kind {
            Kind::Pair(pair) => Some(pair.shadows()),
            _ => None,
        }
    }

    /// Records the library's stages up to this one only, if this is [`Method::Paraboloid`] or [`Method::CubeCompute`]; else
    /// does nothing.
    pub fn stop_after(&mut self, gpu: &Gpu, stage: Stage) {
        match &mut self.kind {
            Kind::Pair(maps) => maps.stop_after(gpu, stage),
            Kind::CubeCompute(cube) => cube.maps_mut().stop_after(gpu, stage),
            _ => {}
        }
    }

    /// What the [text](Lookup::text) of one of this method's lookups reads: its bind groups with their layouts; none for
    /// [`Method::DepthView`].
    #[must_use]
    pub fn bind_groups(&self, lookup: Lookup) -> Vec<Bound<'_>> {
        let map = |(group, layout)| vec![(Some(group), layout)];
        match &self.kind {
            Kind::Pair(pair) => pair.bind_groups().to_vec(),
            Kind::VertexWarp(warp) => map(warp.bind_group()),
            Kind::Cube(cube) => map(cube.lookup().bind_group()),
            Kind::CubeRouted(cube) => map(cube.lookup().bind_group()),
            Kind::CubeMultiview(cube) => map(cube.lookup().bind_group()),
            Kind::CubeCompute(cube) if lookup == Lookup::CubeWalk => cube.walk_groups().to_vec(),
            Kind::CubeCompute(cube) => map(cube.lookup().bind_group()),
            Kind::DepthView(_) => Vec::new(),
        }
    }

    /// What a lookup says of each receiver, given by position and geometric normal. `None` for a lookup that doesn't
    /// read this method's map.
    #[must_use]
    pub fn shadow_values(&self, gpu: &Gpu, lookup: Lookup, receivers: &[(Vec3, Vec3)]) -> Option<Vec<f32>> {
        self.answers(gpu, lookup, &self.evaluator(gpu, lookup, receivers)?)
    }

    /// [`Self::shadow_values`] at receivers in the pixels of a camera at `eye`, each over its pixel, of `angle` radians, where
    /// the lookup takes that.
    #[must_use]
    pub fn pixel_values(
        &self,
        gpu: &Gpu,
        lookup: Lookup,
        receivers: &[(Vec3, Vec3)],
        eye: Vec3,
        angle: f32,
    ) -> Option<Vec<f32>> {
        if !lookup.takes_pixel() {
            return self.shadow_values(gpu, lookup, receivers);
        }
        let view = format!("vec4<f32>({:?}, {:?}, {:?}, {angle:?})", eye.x, eye.y, eye.z);
        let text = evaluation_over(&view, lookup.expression());
        self.answers(gpu, lookup, &self.evaluator_of(gpu, lookup, &text, receivers)?)
    }

    /// Asks a lookup for each receiver, in this map and in all others that the lookup reads. `None` for a lookup that
    /// doesn't read this method's map.
    #[must_use]
    pub fn evaluator(&self, gpu: &Gpu, lookup: Lookup, receivers: &[(Vec3, Vec3)]) -> Option<Evaluator> {
        self.evaluator_of(gpu, lookup, &evaluation(lookup.expression()), receivers)
    }

    fn evaluator_of(
        &self,
        gpu: &Gpu,
        lookup: Lookup,
        evaluation: &str,
        receivers: &[(Vec3, Vec3)],
    ) -> Option<Evaluator> {
        let layouts: Vec<_> = self.bind_groups(lookup).into_iter().map(|(_, layout)| layout).collect();
        let text = [&lookup.text(0), evaluation].concat();
        self.method.is_read_by(lookup).then(|| gpu.evaluator(&text, &layouts, receivers))
    }

    /// What the evaluator of one of this method's lookups finds in this map; `None` of a map that has none.
    #[must_use]
    pub fn answers(&self, gpu: &Gpu, lookup: Lookup, evaluator: &Evaluator) -> Option<Vec<f32>> {
        self.with_answers(gpu, lookup, evaluator, <[f32]>::to_vec)
    }

    /// Does something with [`Self::answers`], without a copy of them.
    pub fn with_answers<R>(
        &self,
        gpu: &Gpu,
        lookup: Lookup,
        evaluator: &Evaluator,
        use_answers: impl FnOnce(&[f32]) -> R,
    ) -> Option<R> {
        let groups: Vec<_> = self.bind_groups(lookup).into_iter().map(|(group, _)| group).collect();
        (!groups.is_empty()).then(|| evaluator.with_values(gpu, &groups, use_answers))
    }
}

/// A bind group with its layout; none where nothing is recorded yet that it would be of.
pub type Bound<'a> = (Option<&'a wgpu::BindGroup>, &'a wgpu::BindGroupLayout);

impl Kind {
    fn new(device: &wgpu::Device, method: Method, resolution: u32) -> Result<Self, BaselineError> {
        let unsupported = |reason| BaselineError::Unsupported { method, reason };
        let cube = |culling, depth| Self::Cube(Cube::new(device, resolution, culling, depth));
        Ok(match method {
            Method::Paraboloid => Self::Pair(Box::new(OwnMaps::pair(device, resolution)?)),
            Method::VertexWarp => Self::VertexWarp(VertexWarp::new(device, resolution)),
            Method::Cube => cube(Culling::Frustum, CubeDepth::Float32),
            Method::CubeUnculled => cube(Culling::None, CubeDepth::Float32),
            Method::Cube16 => cube(Culling::Frustum, CubeDepth::Unorm16),
            Method::CubeRouted => Self::CubeRouted(CubeRouted::new(device, resolution)),
            Method::CubeMultiview => {
                Self::CubeMultiview(CubeMultiview::new(device, resolution).ok_or(unsupported(NO_MULTIVIEW))?)
            }
            Method::CubeCompute => Self::CubeCompute(Box::new(CubeCompute::new(device, resolution)?)),
            Method::DepthView => Self::DepthView(DepthView::new(device, resolution)),
        })
    }
}

/// Name and text of the complete modules that draw the maps, for checking them with other compilers. Multiview is
/// left out: WebGPU doesn't have it.
#[must_use]
pub fn modules() -> Vec<(String, String)> {
    let [route, faces] = cube_routed::modules();
    let modules = [
        ("instanced", PassKind::OneView.text()),
        ("vertex_warp", PassKind::VertexWarp.text()),
        ("cube_route", route),
        ("cube_routed", faces),
    ];
    let modules = modules.into_iter().map(|(name, text)| (name.to_owned(), text)).chain(cube_compute::modules());
    modules.map(|(name, text)| (format!("compare_{name}"), text)).collect()
}

/// Two squares of depth side by side.
fn wide_map(device: &wgpu::Device, resolution: u32) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("dual_paraboloid::compare::map"),
        size: wgpu::Extent3d { width: 2 * resolution, height: resolution, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
