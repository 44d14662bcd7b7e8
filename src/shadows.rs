//! The lights' maps: which are stale, and the order in which their stages are recorded.

use crate::Error;
use crate::casters::Casters;
use crate::demand::Demand;
use crate::depth::{Depth, Sources};
use crate::gpu;
use crate::light::PointLight;
use crate::lookup::Lookup;
use crate::route::Route;
use crate::slots::{Handle, Slots};
use crate::split::Split;
use crate::view::{Arguments, Capacities, MapShape, SLOT, View};

/// How [`PointShadows`] are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointShadowsDescriptor {
    /// Most lights at a time: layers of the depth texture.
    pub capacity: u32,
    /// Texels across one hemisphere's map. A light takes `2 * resolution * resolution` texels of four bytes.
    /// For the texel count of a cube with faces of C texels across, take `sqrt(3) C`.
    pub resolution: u32,
    /// How far depth may be off, in texel footprints along a surface's normal: by 4/3 of this at most away from the light,
    /// and by half of this toward it. Edges miss their true place in the map by two fifths of it, in texels. Half of it
    /// means up to twice as many pieces of large triangles. In [0.01, 1]; on maps smaller than 60 texels less is used.
    pub tolerance: f32,
    /// Width of the guard band around each hemisphere, in texels: lookups near the seam find all their texels in
    /// their own map. In [1, 16]; a sixteenth of the resolution at most is used.
    pub guard: f32,
}

impl Default for PointShadowsDescriptor {
    /// Four lights of 1024 texels across, to a tenth of a texel, with a guard band of four texels.
    fn default() -> Self {
        Self { capacity: 4, resolution: 1024, tolerance: 0.1, guard: 4.0 }
    }
}

/// Handle of a light in the [`PointShadows`] that gave it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LightId(Handle);

impl LightId {
    /// The number by which the shader knows the light, from 0 to below the capacity: what `dp_shadow` takes. Free for
    /// another light once this one is removed.
    #[must_use]
    pub fn index(&self) -> u32 {
        self.0.slot
    }
}

#[derive(Debug)]
struct Light {
    light: PointLight,
    /// Whether its map has to be made.
    stale: bool,
    /// Whether only the lookup has to be told.
    refiltered: bool,
}

impl Light {
    fn new(light: PointLight) -> Self {
        Self { light, stale: true, refiltered: false }
    }
}

/// Depth maps of point lights, kept up to date with the casters.
#[derive(Debug)]
pub struct PointShadows {
    shape: MapShape,
    capacity: u32,
    lights: Slots<Light>,
    /// Lights removed since the last recording.
    removed: Vec<u32>,
    /// The casters that the maps show, by owner, and how many of their changes.
    seen: Option<(u32, u64)>,
    maps: wgpu::Texture,
    layers: Vec<wgpu::TextureView>,
    lookup: Lookup,
    route: Route,
    split: Split,
    depth: Depth,
    views: wgpu::Buffer,
    arguments: wgpu::Buffer,
    demand: Demand,
    /// Pieces that a hemisphere wanted at most, as far as it is known.
    wanted: u32,
    /// Jobs of the last recording that made a map.
    jobs: usize,
    groups: Option<Groups>,
    /// The last stage that is recorded.
    until: Stage,
}

/// A stage of [`PointShadows::record`] on the GPU; each needs those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(not(feature = "compare"), expect(dead_code, reason = "only measurements stop before the last stage"))]
pub enum Stage {
    /// Which triangles each hemisphere draws or splits.
    Route,
    /// From triangles that would bend to pieces.
    Split,
    /// The render pass.
    #[default]
    Depth,
}

/// Bind groups over the casters' buffers, and of which casters.
#[derive(Debug)]
struct Groups {
    key: (u32, u64),
    route: wgpu::BindGroup,
    split: wgpu::BindGroup,
    exact: wgpu::BindGroup,
}

impl PointShadows {
    /// Creates maps for `descriptor.capacity` lights. Needs no optional feature.
    ///
    /// # Errors
    /// [`Error::InvalidDescriptor`] for a value out of range or more than the device's limits allow.
    pub fn new(device: &wgpu::Device, descriptor: &PointShadowsDescriptor) -> Result<Self, Error> {
        Self::with_rejection(device, descriptor, true)
    }

    /// [`Self::new`] with maps from every triangle, even of those that can't change them: what the tests hold the
    /// route against.
    ///
    /// # Errors
    /// As [`Self::new`].
    #[cfg(feature = "compare")]
    pub fn new_unrouted(device: &wgpu::Device, descriptor: &PointShadowsDescriptor) -> Result<Self, Error> {
        Self::with_rejection(device, descriptor, false)
    }

    fn with_rejection(device: &wgpu::Device, descriptor: &PointShadowsDescriptor, reject: bool) -> Result<Self, Error> {
        validate(descriptor, &device.limits())?;
        let PointShadowsDescriptor { capacity, resolution, tolerance, guard } = *descriptor;
        let shape = MapShape::new(resolution, guard, tolerance);
        let maps = create_maps(device, capacity, resolution);
        let layers = (0..capacity).map(|layer| layer_view(&maps, layer)).collect();
        Ok(Self {
            shape,
            capacity,
            lights: Slots::new("light", "PointShadows"),
            removed: Vec::new(),
            seen: None,
            lookup: Lookup::new(device, &maps),
            maps,
            layers,
            route: Route::new(device, reject),
            split: Split::new(device, reject),
            depth: Depth::new(device, capacity),
            views: job_buffer(device, "views", capacity, wgpu::BufferUsages::UNIFORM),
            arguments: argument_buffer(device, capacity),
            demand: Demand::new(device, capacity),
            wanted: 0,
            jobs: 0,
            groups: None,
            until: Stage::default(),
        })
    }

    /// Records the stages up to this one only, to see what each takes. The maps are right with [`Stage::Depth`] alone.
    #[cfg(feature = "compare")]
    pub fn stop_after(&mut self, stage: Stage) {
        self.until = stage;
    }

    /// Adds a light; its map is made at the next [`Self::record`], and until then it has the place's old one.
    ///
    /// # Errors
    /// [`Error::InvalidLight`], or [`Error::CapacityExceeded`].
    pub fn add(&mut self, light: PointLight) -> Result<LightId, Error> {
        light.validate()?;
        if self.lights.count() == self.capacity {
            return Err(Error::CapacityExceeded { capacity: self.capacity });
        }
        Ok(LightId(self.lights.insert(Light::new(light))))
    }

    /// Changes a light. Setting what it is already costs nothing, and another filter alone next to nothing.
    ///
    /// # Errors
    /// [`Error::InvalidLight`] or [`Error::StaleHandle`]; the light stays as it was.
    pub fn set(&mut self, id: LightId, light: PointLight) -> Result<(), Error> {
        light.validate()?;
        let entry = self.lights.get_mut(id.0)?;
        if (PointLight { filter: light.filter, ..entry.light }) != light {
            *entry = Light::new(light);
        } else if entry.light != light {
            entry.light = light;
            entry.refiltered = true;
        }
        Ok(())
    }

    /// Removes a light. From the next [`Self::record`] on its index lights nothing.
    ///
    /// # Errors
    /// [`Error::StaleHandle`].
    pub fn remove(&mut self, id: LightId) -> Result<(), Error> {
        self.lights.remove(id.0)?;
        self.removed.push(id.index());
        Ok(())
    }

    /// Records what brings the casters and every stale map up to date, and returns the number of maps made anew. A
    /// light is stale if it was added or changed, or if something within its range came, went or moved.
    ///
    /// Its cost on the CPU doesn't depend on how many triangles or instances there are, only on the stale lights
    /// and on what has changed. Submit the encoder before the next call.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &mut Casters,
    ) -> u32 {
        casters.update(device, queue, encoder);
        self.mark_touched(casters);
        self.read_demand();
        for layer in std::mem::take(&mut self.removed) {
            self.lookup.write(queue, layer, None, &self.shape);
        }
        let mut stale = Vec::new();
        for (layer, entry) in self.lights.iter_mut() {
            let refiltered = std::mem::take(&mut entry.refiltered);
            if entry.stale || refiltered {
                self.lookup.write(queue, layer, Some(&entry.light), &self.shape);
            }
            if std::mem::take(&mut entry.stale) {
                stale.push((layer, entry.light));
            }
        }
        if !stale.is_empty() {
            self.record_lights(device, queue, encoder, casters, &stale);
            self.demand.record(encoder, &self.arguments, self.jobs);
        }
        stale.len() as u32
    }

    /// If pieces found no room in an earlier recording, sees to it that they do now.
    fn read_demand(&mut self) {
        let Some(wanted) = self.demand.take() else { return };
        self.wanted = self.wanted.max(wanted);
        if wanted > self.split.capacity() {
            self.lights.iter_mut().for_each(|(_, entry)| entry.stale = true);
        }
    }

    /// Marks the lights that a change of the casters has reached.
    fn mark_touched(&mut self, casters: &Casters) {
        let now = (casters.owner(), casters.change_count());
        let seen = self.seen.replace(now);
        if seen == Some(now) {
            return;
        }
        let remembered = seen.filter(|(owner, _)| *owner == now.0).map(|(_, count)| count);
        for (_, entry) in self.lights.iter_mut() {
            let changes = remembered.and_then(|count| casters.changes_since(count));
            let reach = |bounds| touches(&entry.light, bounds);
            entry.stale = entry.stale
                || changes.is_none_or(|mut all| all.any(|change| reach(&change.before) || reach(&change.after)));
        }
    }

    fn record_lights(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &Casters,
        stale: &[(u32, PointLight)],
    ) {
        let replaced = self.route.fit(device, casters) | self.split.fit(device, &self.shape, self.wanted);
        let ranges = self.route.jobs(casters);
        self.write_jobs(device, queue, stale, &ranges);
        let key = (casters.owner(), casters.generation());
        if replaced || self.groups.as_ref().is_none_or(|groups| groups.key != key) {
            self.groups = Some(self.bind(device, casters, key));
        }
        let Some(groups) = &self.groups else { return };
        let lights: Vec<PointLight> = stale.iter().map(|(_, light)| *light).collect();
        self.depth.write_views(queue, &lights, &self.shape);
        let sources = Sources {
            vertices: casters.vertices.buffer(),
            lists: self.route.lists(),
            pieces: self.split.pieces(),
            arguments: &self.arguments,
            exact: &groups.exact,
        };
        for (number, (layer, light)) in (0..).zip(stale) {
            let target = &self.layers[*layer as usize];
            let draw = |encoder: &mut _, job, clear| {
                self.depth.record(encoder, target, &sources, &self.shape, light.coverage, number, job, clear);
            };
            if ranges.is_empty() {
                draw(encoder, None, true);
            }
            for (part, chunks) in (0..).zip(&ranges) {
                let job = number * ranges.len() as u32 + part;
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("dual_paraboloid::route and split"),
                    timestamp_writes: None,
                });
                self.route.record(&mut pass, &groups.route, job, chunks.len() as u32);
                if self.until >= Stage::Split {
                    self.split.record(&mut pass, &groups.split, job);
                }
                drop(pass);
                if self.until >= Stage::Depth {
                    draw(encoder, Some(job), part == 0);
                }
            }
        }
    }

    /// Writes each job's view and its counters' start, growing the buffers if there are more jobs than ever.
    fn write_jobs(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        stale: &[(u32, PointLight)],
        ranges: &[std::ops::Range<u32>],
    ) {
        let room = Capacities { triangles: self.route.capacity(), pieces: self.split.capacity() };
        let jobs = stale.len() * ranges.len();
        self.jobs = jobs;
        if jobs as u64 * SLOT > self.views.size() {
            self.views = job_buffer(device, "views", jobs as u32, wgpu::BufferUsages::UNIFORM);
            self.arguments = argument_buffer(device, jobs as u32);
            self.demand = Demand::new(device, jobs as u32);
            self.groups = None;
        }
        let mut views = vec![0u8; jobs * SLOT as usize];
        let mut arguments = views.clone();
        let start = Arguments::new(room);
        let all = stale.iter().flat_map(|(_, light)| ranges.iter().map(move |chunks| (light, chunks)));
        let slots = views.chunks_exact_mut(SLOT as usize).zip(arguments.chunks_exact_mut(SLOT as usize));
        for ((light, chunks), (view_slot, argument_slot)) in all.zip(slots) {
            let view = View::new(light, &self.shape, chunks.clone(), room);
            view_slot[..size_of_val(&view)].copy_from_slice(bytemuck::bytes_of(&view));
            argument_slot[..size_of_val(&start)].copy_from_slice(bytemuck::bytes_of(&start));
        }
        queue.write_buffer(&self.views, 0, &views);
        queue.write_buffer(&self.arguments, 0, &arguments);
    }

    fn bind(&self, device: &wgpu::Device, casters: &Casters, key: (u32, u64)) -> Groups {
        let (lists, vertices) = (self.route.lists(), casters.vertices.buffer());
        Groups {
            key,
            route: self.route.bind_group(device, &self.views, &self.arguments, casters),
            split: self.split.bind_group(device, &self.views, &self.arguments, lists, vertices),
            exact: self.depth.exact_group(device, &self.views, lists, vertices),
        }
    }

    /// Layout of [`Self::bind_group`], for the pipeline layouts of passes that look shadows up.
    #[must_use]
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        self.lookup.layout()
    }

    /// What the text of [`wgsl::lookup`](crate::wgsl::lookup) reads. Stays the same object for ever.
    #[must_use]
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        self.lookup.bind_group()
    }

    /// The maps, `Depth32Float`: one layer a light, by [`LightId::index`], the front hemisphere in its left half and
    /// the back one in its right. The depth is `near / w`, see [`paraboloid::depth`](crate::paraboloid::depth).
    #[must_use]
    pub fn maps(&self) -> &wgpu::Texture {
        &self.maps
    }

    /// Half a map's width in map coordinates, `1 + g`: the unit disc and the guard band around it.
    #[must_use]
    pub fn half_width(&self) -> f32 {
        self.shape.half_width
    }

    /// The counters of the last recording that made a map, and for how many jobs there are some.
    #[cfg(feature = "compare")]
    pub(crate) fn counters(&self) -> (&wgpu::Buffer, usize) {
        (&self.arguments, self.jobs)
    }

    /// How far depth may be off along a surface's normal, in texel footprints: half the
    /// [tolerance](PointShadowsDescriptor::tolerance), and a part of the lookup's bias.
    #[must_use]
    pub fn depth_tolerance(&self) -> f32 {
        self.shape.depth_tolerance()
    }

    /// Bytes on the GPU: the maps, and the lists that the lights share.
    #[must_use]
    pub fn memory(&self) -> u64 {
        let texels = u64::from(self.maps.width()) * u64::from(self.maps.height()) * u64::from(self.capacity);
        4 * texels + self.route.lists().size() + self.split.pieces().size() + self.views.size() + self.arguments.size()
    }
}

/// Whether a light's map may show something within the bounds.
fn touches(light: &PointLight, bounds: &Option<crate::chunks::Bounds>) -> bool {
    bounds.is_some_and(|bounds| bounds.touches_sphere(light.position, light.range * 1.0001))
}

fn validate(descriptor: &PointShadowsDescriptor, limits: &wgpu::Limits) -> Result<(), Error> {
    let check = |ok: bool, what, value: String, remedy: String| {
        if ok { Ok(()) } else { Err(Error::InvalidDescriptor { what, value, remedy }) }
    };
    let (widest, layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
    let PointShadowsDescriptor { capacity, resolution, tolerance, guard } = *descriptor;
    let room = format!("it must be 1 to {layers}, the device's limit of texture layers");
    check((1..=layers).contains(&capacity), "capacity", capacity.to_string(), room)?;
    let room = format!("it must be 1 to {}, half the width of the device's largest texture", widest / 2);
    check((1..=widest / 2).contains(&resolution), "resolution", resolution.to_string(), room)?;
    let room = "it must be 0.01 to 1 texel".to_owned();
    check((0.01..=1.0).contains(&tolerance), "tolerance", tolerance.to_string(), room)?;
    let room = "it must be 1 to 16 texels".to_owned();
    check((1.0..=16.0).contains(&guard), "guard", guard.to_string(), room)
}

fn create_maps(device: &wgpu::Device, capacity: u32, resolution: u32) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("dual_paraboloid::maps"),
        size: wgpu::Extent3d { width: 2 * resolution, height: resolution, depth_or_array_layers: capacity },
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

fn layer_view(maps: &wgpu::Texture, layer: u32) -> wgpu::TextureView {
    maps.create_view(&wgpu::TextureViewDescriptor {
        label: Some("dual_paraboloid::depth::layer"),
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

fn job_buffer(device: &wgpu::Device, what: &str, jobs: u32, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu::buffer(device, what, u64::from(jobs) * SLOT, usage | wgpu::BufferUsages::COPY_DST)
}

fn argument_buffer(device: &wgpu::Device, jobs: u32) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_SRC;
    job_buffer(device, "arguments", jobs, usage)
}
