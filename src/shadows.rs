//! The lights' maps: which are stale, and the order in which their stages are recorded.

use crate::Error;
use crate::batch::{self, Job, MASKED, MOST_JOBS, MOVING, OPAQUE, STATIC};
use crate::casters::Casters;
use crate::custom::CasterPass;
use crate::demand::Demand;
use crate::depth::{Depth, Sources};
use crate::gpu::{self, Workgroups};
use crate::light::PointLight;
use crate::lookup::Lookup;
use crate::maps::{Maps, Target};
use crate::masked;
use crate::route::Route;
use crate::schedule::{self, Due, Light, Stale};
use crate::slots::{Handle, Slots};
use crate::split::Split;
use crate::view::{Arguments, MapShape, SLOT, View};
use std::ops::Range;

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
    /// Keeps a second map of each light's static casters, over a copy of which the
    /// [moving](crate::Casters::set_moving) ones are drawn. The maps are the same to the bit and take twice the memory;
    /// it pays where little moves among much that doesn't.
    pub keep_static: bool,
}

impl Default for PointShadowsDescriptor {
    /// Four lights of 1024 texels across, to a tenth of a texel, with a guard band of four texels, and one map each.
    fn default() -> Self {
        Self { capacity: 4, resolution: 1024, tolerance: 0.1, guard: 4.0, keep_static: false }
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
    maps: Maps,
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

/// What [`PointShadows::record_with`] may do beside what [`PointShadows::record`] does.
#[derive(Default)]
pub struct RecordOptions<'a> {
    /// Maps that are made anew at most. What is left out stays as it is, old light and all, and goes first another time:
    /// by [priority](PointShadows::set_priority) times the recordings it has waited for. Lights without any map, which
    /// until then light nothing, go before all others. No limit without a number.
    pub most: Option<u32>,
    /// Draws casters of the caller's own over each map that is made anew, see [`CasterPass`]. To be given at every recording:
    /// a map that is made without it lacks them. [`Casters::touch`] says that they have changed.
    pub draw: Option<&'a mut dyn FnMut(&mut CasterPass)>,
}

/// A map that is drawn in one go, or as many as there are stretches of chunks.
struct Pass {
    /// Number of the light among those of the recording.
    number: u32,
    layer: u32,
    light: PointLight,
    target: Target,
    /// Drawn over a copy of the map of the static casters.
    over_static: bool,
    jobs: Range<u32>,
}

/// Bind groups over the casters' buffers, and of which casters, masked ones among them or not.
#[derive(Debug)]
struct Groups {
    key: (u32, u64, bool),
    route: wgpu::BindGroup,
    split: wgpu::BindGroup,
    exact: wgpu::BindGroup,
    /// If there are masked casters.
    masked: Option<masked::Groups>,
}

impl PointShadows {
    /// Creates maps for `descriptor.capacity` lights. Needs no optional feature.
    ///
    /// # Errors
    /// [`Error::InvalidDescriptor`] for a value out of range or more than the device's limits allow, or
    /// [`Error::DeviceLost`].
    pub fn new(device: &wgpu::Device, descriptor: &PointShadowsDescriptor) -> Result<Self, Error> {
        Self::with_stages(device, descriptor, Workgroups::of(device), true)
    }

    /// [`Self::new`] with maps from every triangle, even of those that can't change them: what the tests hold the
    /// route against.
    ///
    /// # Errors
    /// As [`Self::new`].
    #[cfg(feature = "compare")]
    pub fn new_unrouted(device: &wgpu::Device, descriptor: &PointShadowsDescriptor) -> Result<Self, Error> {
        Self::with_stages(device, descriptor, Workgroups::of(device), false)
    }

    /// [`Self::new`] with workgroups of another device's size, so that a test on one device runs both.
    ///
    /// # Errors
    /// As [`Self::new`].
    #[cfg(feature = "compare")]
    pub fn with_workgroups(
        device: &wgpu::Device,
        descriptor: &PointShadowsDescriptor,
        workgroups: Workgroups,
    ) -> Result<Self, Error> {
        Self::with_stages(device, descriptor, workgroups, true)
    }

    fn with_stages(
        device: &wgpu::Device,
        descriptor: &PointShadowsDescriptor,
        workgroups: Workgroups,
        reject: bool,
    ) -> Result<Self, Error> {
        validate(descriptor, &device.limits())?;
        gpu::check(device)?;
        let PointShadowsDescriptor { capacity, resolution, tolerance, guard, keep_static } = *descriptor;
        let shape = MapShape::new(resolution, guard, tolerance);
        let maps = Maps::new(device, capacity, resolution, keep_static);
        Ok(Self {
            shape,
            capacity,
            lights: Slots::new("light", "PointShadows"),
            removed: Vec::new(),
            seen: None,
            lookup: Lookup::new(device, maps.live()),
            maps,
            route: Route::new(device, workgroups, reject),
            split: Split::new(device, workgroups, reject),
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

    /// Adds a light; its map is made at the next [`Self::record`], and until then it has what its place last had. Where a
    /// [limit](RecordOptions::most) puts it off, it lights nothing in the meantime.
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
        self.lights.get_mut(id.0)?.set(light);
        Ok(())
    }

    /// How much sooner than others a light's map is made anew where [`RecordOptions::most`] doesn't allow all: twice the
    /// priority is as good as having waited for twice as many recordings. While all maps are stale all the time, a light
    /// waits for about as many recordings as the sum of all priorities over its own and over the limit: long for the least,
    /// but not for ever. Finite, above 0; 1 without being set. The light's share of the picture is a good one.
    ///
    /// # Errors
    /// [`Error::InvalidLight`] or [`Error::StaleHandle`].
    pub fn set_priority(&mut self, id: LightId, priority: f32) -> Result<(), Error> {
        self.lights.get_mut(id.0)?.set_priority(priority)
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
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &mut Casters,
    ) -> Result<u32, Error> {
        self.record_with(device, queue, encoder, casters, RecordOptions::default())
    }

    /// [`Self::record`] with more to choose.
    ///
    /// # Errors
    /// As [`Self::record`].
    pub fn record_with(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &mut Casters,
        options: RecordOptions,
    ) -> Result<u32, Error> {
        gpu::check(device)?;
        casters.update(device, queue, encoder);
        self.mark_touched(casters);
        self.read_demand();
        let RecordOptions { most, draw } = options;
        let due = schedule::take(&mut self.lights, most);
        for layer in std::mem::take(&mut self.removed) {
            self.lookup.set(layer, None, &self.shape);
        }
        for Due { layer, light, .. } in &due {
            self.lookup.set(*layer, Some(light), &self.shape);
        }
        for (layer, light) in schedule::take_refiltered(&mut self.lights) {
            self.lookup.set(layer, Some(&light), &self.shape);
        }
        self.lookup.write(queue);
        if !due.is_empty() {
            self.record_lights(device, queue, encoder, casters, &due, draw);
            self.demand.record(encoder, &self.arguments, self.jobs);
        }
        Ok(due.len() as u32)
    }

    /// If pieces found no room in an earlier recording, sees to it that they do now.
    fn read_demand(&mut self) {
        let Some(wanted) = self.demand.take() else { return };
        self.wanted = self.wanted.max(wanted);
        if wanted > self.split.capacity() {
            self.lights.iter_mut().for_each(|(_, entry)| entry.outdate());
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
        let Some(changes) = remembered.and_then(|count| casters.changes_since(count)) else {
            self.lights.iter_mut().for_each(|(_, entry)| entry.outdate());
            return;
        };
        // There may be many times more changes than lights: they are gone through once.
        let mut open: Vec<&mut Light> = self.lights.iter_mut().map(|(_, entry)| entry).collect();
        for change in changes {
            if open.is_empty() {
                break;
            }
            open.retain_mut(|entry| entry.touch(change, self.maps.keep_static()));
        }
    }

    fn record_lights(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &Casters,
        due: &[Due],
        mut draw: Option<&mut dyn FnMut(&mut CasterPass)>,
    ) {
        let (passes, jobs) = self.plan(casters, due);
        let lights = self.lights.count();
        let has_masked = casters.triangles_of(MASKED) > 0;
        let jobs_at_once = if has_masked { 2 * lights } else { lights };
        let replaced =
            self.route.fit(device, casters, lights) | self.split.fit(device, &self.shape, self.wanted, jobs_at_once);
        let batches = batch::pack(&jobs, self.split.jobs(), self.route.capacity());
        self.write_jobs(device, queue, &jobs, &batches);
        let key = (casters.owner(), casters.generation(), has_masked);
        if replaced || self.groups.as_ref().is_none_or(|groups| groups.key != key) {
            self.groups = Some(self.bind(device, casters, key));
        }
        let Some(groups) = &self.groups else { return };
        let lights: Vec<PointLight> = due.iter().map(|due| due.light).collect();
        self.depth.write_views(queue, &lights, &self.shape);
        let mut batches = batches.into_iter();
        let mut chosen = 0;
        for pass in &passes {
            let layer = self.maps.layer(pass.target, pass.layer);
            if pass.over_static && self.until >= Stage::Depth {
                self.maps.copy_static(encoder, pass.layer);
            }
            // In one go, unless its jobs are of several batches.
            let (mut clear, mut next) = (!pass.over_static, pass.jobs.start);
            while clear || next < pass.jobs.end {
                if next == chosen
                    && next < pass.jobs.end
                    && let Some(batch) = batches.next()
                {
                    self.record_batch(encoder, groups, batch.clone(), &jobs);
                    chosen = batch.end;
                }
                let drawn = next..pass.jobs.end.min(chosen);
                if self.until >= Stage::Depth {
                    self.record_draws(encoder, layer, casters, groups, pass.number, drawn.clone(), &jobs, clear);
                }
                (clear, next) = (false, drawn.end);
            }
            if let (Target::Live, Stage::Depth, Some(draw)) = (pass.target, self.until, draw.as_deref_mut()) {
                self.depth.record_custom(encoder, layer, &self.shape, &pass.light, pass.number, draw);
            }
        }
    }

    /// The passes that make the maps, and their jobs.
    fn plan(&self, casters: &Casters, due: &[Due]) -> (Vec<Pass>, Vec<Job>) {
        let (mut passes, mut jobs) = (Vec::new(), Vec::new());
        let mut add = |number, due: &Due, target, kinds, over_static| {
            let Due { layer, light, .. } = *due;
            let first = jobs.len() as u32;
            for kinds in [kinds & OPAQUE, kinds & MASKED] {
                let job = |(chunks, triangles)| Job { light, chunks, kinds, triangles };
                jobs.extend(Route::stretches(casters, kinds).map(job));
            }
            passes.push(Pass { number, layer, light, target, over_static, jobs: first..jobs.len() as u32 });
        };
        for (number, due) in (0..).zip(due) {
            if !self.maps.keep_static() {
                add(number, due, Target::Live, STATIC | MOVING, false);
                continue;
            }
            if due.stale == Stale::Everything {
                add(number, due, Target::Static, STATIC, false);
            }
            add(number, due, Target::Live, MOVING, true);
        }
        (passes, jobs)
    }

    /// Records the route and the split of a batch of jobs.
    fn record_batch(&self, encoder: &mut wgpu::CommandEncoder, groups: &Groups, batch: Range<u32>, jobs: &[Job]) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("dual_paraboloid::route and split"),
            timestamp_writes: None,
        });
        let jobs = &jobs[batch.start as usize..batch.end as usize];
        self.route.record(&mut pass, &groups.route, batch.start, jobs);
        if self.until >= Stage::Split {
            self.split.record(&mut pass, &groups.split, batch.start, jobs.len() as u32);
        }
    }

    /// Records the drawing of jobs of one map.
    #[expect(clippy::too_many_arguments, reason = "one call site; each is a separate thing")]
    fn record_draws(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        layer: &wgpu::TextureView,
        casters: &Casters,
        groups: &Groups,
        light: u32,
        drawn: Range<u32>,
        jobs: &[Job],
        clear: bool,
    ) {
        let sources = Sources {
            vertices: casters.vertices.buffer(),
            lists: self.route.lists(),
            pieces: self.split.pieces(),
            arguments: &self.arguments,
            exact: &groups.exact,
            masked: groups.masked.as_ref(),
        };
        let mut pass = Depth::begin(encoder, layer, clear);
        self.depth.draw(&mut pass, &sources, &self.shape, light, drawn, jobs);
    }

    /// Writes each job's view and its counters' start, growing the buffers if there are more jobs than ever.
    fn write_jobs(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, jobs: &[Job], batches: &[Range<u32>]) {
        self.jobs = jobs.len();
        if jobs.len() as u64 * SLOT > self.demand.size() {
            self.views = job_buffer(device, "views", jobs.len() as u32, wgpu::BufferUsages::UNIFORM);
            self.arguments = argument_buffer(device, jobs.len() as u32);
            self.demand = Demand::new(device, jobs.len() as u32);
            self.groups = None;
        }
        let (mut views, mut arguments) = (Vec::with_capacity(jobs.len()), Vec::with_capacity(jobs.len()));
        for batch in batches {
            let jobs = &jobs[batch.start as usize..batch.end as usize];
            for (job, shares) in jobs.iter().zip(batch::shares(jobs, self.split.capacity())) {
                views.push(View::new(job, &self.shape, &shares));
                arguments.push(Arguments::new(&shares));
            }
        }
        queue.write_buffer(&self.views, 0, bytemuck::cast_slice(&views));
        queue.write_buffer(&self.arguments, 0, bytemuck::cast_slice(&arguments));
    }

    fn bind(&mut self, device: &wgpu::Device, casters: &Casters, key: (u32, u64, bool)) -> Groups {
        let (lists, vertices) = (self.route.lists(), casters.vertices.buffer());
        let masked = key.2.then(|| {
            let masked = self.depth.masked(device);
            masked.groups(device, casters.mask_buffers(), lists, vertices, self.split.pieces())
        });
        Groups {
            key,
            route: self.route.bind_group(device, &self.views, &self.arguments, casters),
            split: self.split.bind_group(device, &self.views, &self.arguments, lists, vertices),
            exact: self.depth.exact_group(device, &self.views, lists, vertices),
            masked,
        }
    }

    /// Layout of [`Self::bind_group`], for the pipeline layouts of passes that look shadows up.
    #[must_use]
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        self.lookup.layout()
    }

    /// Layout of the group that the text of [`wgsl::caster`](crate::wgsl::caster) reads, for the pipelines of
    /// [casters that the caller draws](CasterPass).
    #[must_use]
    pub fn caster_bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        self.depth.layout()
    }

    /// The longest edge, as the angle in radians that it spans at the light, that [casters that the caller
    /// draws](CasterPass) may have and be as exact as all others: 1.2 degrees at 1024 texels and a tolerance of a tenth.
    #[must_use]
    pub fn caster_angle_limit(&self) -> f32 {
        self.shape.angle_limit()
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
        self.maps.live()
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

    /// Bytes on the GPU: the maps, twice with [`keep_static`](PointShadowsDescriptor::keep_static), and what the lights
    /// share: what up to eight of them need at a time, by the casters' triangles and the resolution, and a few KiB for each.
    /// That is about 180 MiB at most, unless a single light takes more.
    #[must_use]
    pub fn memory(&self) -> u64 {
        let own = self.views.size() + self.arguments.size();
        let stages = self.route.memory() + self.split.memory() + self.depth.memory();
        self.maps.memory() + own + stages + self.demand.size() + self.lookup.memory()
    }
}

fn validate(descriptor: &PointShadowsDescriptor, limits: &wgpu::Limits) -> Result<(), Error> {
    let check = |ok: bool, what, value: String, remedy: String| {
        if ok { Ok(()) } else { Err(Error::InvalidDescriptor { what, value, remedy }) }
    };
    let (widest, layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
    let PointShadowsDescriptor { capacity, resolution, tolerance, guard, .. } = *descriptor;
    let room = format!("it must be 1 to {layers}, the device's limit of texture layers");
    check((1..=layers).contains(&capacity), "capacity", capacity.to_string(), room)?;
    let room = format!("it must be 1 to {}, half the width of the device's largest texture", widest / 2);
    check((1..=widest / 2).contains(&resolution), "resolution", resolution.to_string(), room)?;
    let room = "it must be 0.01 to 1 texel".to_owned();
    check((0.01..=1.0).contains(&tolerance), "tolerance", tolerance.to_string(), room)?;
    let room = "it must be 1 to 16 texels".to_owned();
    check((1.0..=16.0).contains(&guard), "guard", guard.to_string(), room)
}

/// A slot for each of so many jobs, and as many more as are bound behind the last one.
fn job_buffer(device: &wgpu::Device, what: &str, jobs: u32, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu::buffer(device, what, u64::from(jobs + MOST_JOBS) * SLOT, usage | wgpu::BufferUsages::COPY_DST)
}

fn argument_buffer(device: &wgpu::Device, jobs: u32) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_SRC;
    job_buffer(device, "arguments", jobs, usage)
}
