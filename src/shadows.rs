//! The lights' maps: which are stale, and the order in which their stages are recorded.

use crate::Error;
use crate::assign::Assign;
use crate::batch::{FROM_CUSTOM, FROM_STATIC, Item, MASKED, MOST_ITEMS, MOVING, STATIC, Share};
use crate::casters::Casters;
use crate::cull::Cull;
use crate::custom::{CasterPass, Custom};
use crate::gpu::{self, Workgroups};
use crate::light::PointLight;
use crate::limits;
use crate::lookup::Lookup;
use crate::maps::{Maps, Target};
use crate::rasterise::Rasterise;
use crate::recordings::Recording;
use crate::resolve::Resolve;
use crate::schedule::{self, Due, Light, Stale};
use crate::slots::{Handle, Slots};
use crate::view::{MapShape, SLOT, View};
use crate::workspace::{Most, Workspace};
use std::ops::Range;

/// How [`PointShadows`] are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointShadowsDescriptor {
    /// Most lights at a time: layers of the maps' textures.
    pub capacity: u32,
    /// Texels across one hemisphere's map. A light takes `2 * resolution * resolution` texels of eight bytes. At most 4096.
    /// For the texel count of a cube with faces of C texels across, take `sqrt(3) C`.
    pub resolution: u32,
    /// Width of the guard band around each hemisphere, in texels: lookups near the seam find all their texels in
    /// their own map. In [1, 16]; a sixteenth of the resolution at most is used.
    pub guard: f32,
    /// Keeps a second map of each light's static casters, from which the map starts that the
    /// [moving](crate::Casters::set_moving) ones are drawn to. The maps are the same to the bit and take twice the memory;
    /// it pays where little moves among much that doesn't.
    pub keep_static: bool,
}

impl Default for PointShadowsDescriptor {
    /// Four lights of 512 texels across, with a guard band of four texels, and one map each.
    fn default() -> Self {
        Self { capacity: 4, resolution: 512, guard: 4.0, keep_static: false }
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

/// Bias of the lookup along a surface's normal, in texel footprints: for curvature finer than a texel.
pub(crate) const NORMAL_BIAS: f32 = 0.025;

/// Widest map: its tiles are numbered by bytes, and its texels' buffer has 128 MiB.
const MOST_RESOLUTION: u32 = 4096;

/// Entries of a tile's list of large triangles; fewer on the widest maps, where the lists fill a binding.
const ROOM: u32 = 512;

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
    cull: Cull,
    resolve: Resolve,
    assign: Assign,
    rasterise: Rasterise,
    custom: Custom,
    workspace: Workspace,
    views: wgpu::Buffer,
    groups: Option<Groups>,
    /// Recordings that may be lost, by the casters' count, and the layers whose maps each made.
    unconfirmed: Vec<(Recording, Vec<u32>)>,
    /// Items of the last recording that made a map.
    recorded: usize,
    /// The last stage that is recorded.
    until: Stage,
}

/// A stage of [`PointShadows::record`] on the GPU; each needs those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(not(feature = "compare"), expect(dead_code, reason = "only measurements stop before the last stage"))]
pub enum Stage {
    /// Leaving out, drawing what is small, recording what is large.
    Cull,
    /// Drawing what was put off, and numbering texels.
    Number,
    /// Which tiles large triangles touch.
    Bin,
    /// From tiles to maps.
    #[default]
    Rasterise,
}

/// How a test has the stages work.
#[derive(Debug, Clone, Copy)]
pub struct Tuning {
    /// Leaves out triangles that face away in closed pieces.
    pub reject: bool,
    /// How the work is shared out.
    pub workgroups: Workgroups,
    /// Texels along a side of the largest box of a triangle that is drawn at once.
    pub small: Option<u32>,
    /// Entries of a tile's list of large triangles.
    pub room: u32,
    /// Records of large triangles at most; without a number, enough for nearly all scenes.
    pub records: Option<u32>,
    /// Jobs of the binning at most.
    pub jobs: Option<u32>,
}

impl Tuning {
    /// As it is best for a device.
    #[must_use]
    pub fn of(device: &wgpu::Device) -> Self {
        Self { reject: true, workgroups: Workgroups::of(device), small: None, room: ROOM, records: None, jobs: None }
    }
}

/// What [`PointShadows::record_with`] may do beside what [`PointShadows::record`] does.
#[derive(Default)]
pub struct RecordOptions<'a> {
    /// Maps that are made anew at most. What is left out stays as it is, old light and all, and goes first another time:
    /// by [priority](PointShadows::set_priority) times the recordings it has waited for. Lights without any map, which
    /// until then light nothing, go before all others. No limit without a number.
    pub most: Option<u32>,
    /// Draws casters of the caller's own into each map that is made anew, see [`CasterPass`]. To be given at every recording:
    /// a map that is made without it lacks them. [`Casters::touch`] says that they have changed.
    pub draw: Option<&'a mut dyn FnMut(&mut CasterPass)>,
}

/// Bind groups over the casters' buffers, and of which casters.
#[derive(Debug)]
struct Groups {
    key: (u32, u64),
    cull: wgpu::BindGroup,
    resolve: [wgpu::BindGroup; 2],
    assign: wgpu::BindGroup,
    /// For the maps of static casters, if those are kept.
    rasterise_static: Option<wgpu::BindGroup>,
    rasterise_live: wgpu::BindGroup,
}

impl PointShadows {
    /// Creates maps for `descriptor.capacity` lights. Needs no optional feature.
    ///
    /// # Errors
    /// [`Error::LimitTooLow`] if the device has less than [`required_limits`](crate::required_limits),
    /// [`Error::InvalidDescriptor`] for a value out of range or more than the device's limits allow, or
    /// [`Error::DeviceLost`].
    pub fn new(device: &wgpu::Device, descriptor: &PointShadowsDescriptor) -> Result<Self, Error> {
        Self::with_shape(device, descriptor, &Tuning::of(device), shape_of(descriptor))
    }

    /// [`Self::new`] with the stages set to work otherwise.
    ///
    /// # Errors
    /// As [`Self::new`].
    #[cfg(feature = "compare")]
    pub fn tuned(device: &wgpu::Device, descriptor: &PointShadowsDescriptor, tuning: &Tuning) -> Result<Self, Error> {
        Self::with_shape(device, descriptor, tuning, shape_of(descriptor))
    }

    /// [`Self::tuned`] with maps of another shape than the descriptor's.
    pub(crate) fn with_shape(
        device: &wgpu::Device,
        descriptor: &PointShadowsDescriptor,
        tuning: &Tuning,
        shape: MapShape,
    ) -> Result<Self, Error> {
        limits::check(&device.limits())?;
        validate(descriptor, &device.limits())?;
        gpu::check(device)?;
        let PointShadowsDescriptor { capacity, keep_static, .. } = *descriptor;
        let Tuning { reject, workgroups, small, room, records, jobs } = *tuning;
        let (projection, tiles) = (shape.projection, shape.all_tiles());
        // Jobs and winners have the other half of the binding.
        let room = room.min((device.limits().max_storage_buffer_binding_size / 8 / u64::from(tiles)) as u32).max(1);
        let maps = Maps::new(device, shape.extent(capacity), keep_static);
        let share = Share { tiles, records: 64, jobs: 64, winners: 64, bits: 38, overflows: false };
        Ok(Self {
            shape,
            capacity,
            lights: Slots::new("light", "PointShadows"),
            removed: Vec::new(),
            seen: None,
            lookup: Lookup::new(device, &maps),
            maps,
            cull: Cull::new(device, projection, workgroups, reject, small),
            resolve: Resolve::new(device, projection, workgroups),
            assign: Assign::new(device, projection, workgroups, room),
            rasterise: Rasterise::new(device, &shape, workgroups, room),
            custom: Custom::new(device, capacity),
            workspace: Workspace::new(device, share, room, Most { records, jobs }, 1, MOST_ITEMS),
            views: view_buffer(device, capacity),
            groups: None,
            unconfirmed: Vec::new(),
            recorded: 0,
            until: Stage::default(),
        })
    }

    /// Records the stages up to this one only from now on, to see what each takes. The maps are right with
    /// [`Stage::Rasterise`] alone. What a recording that stopped early has left behind is cleared at once, by a submission
    /// of its own.
    #[cfg(feature = "compare")]
    pub fn stop_after(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, stage: Stage) {
        if std::mem::replace(&mut self.until, stage) < Stage::Rasterise {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.workspace.clear(&mut encoder);
            queue.submit([encoder.finish()]);
        }
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
    /// and on what has changed.
    ///
    /// Submit encoders in the order in which they were recorded to; several may wait. If one is thrown away, or submitted after
    /// a later one, the next call finds out and records once more all that was recorded from it on. Until its maps are made
    /// again, lights that had theirs made there light nothing. An encoder or command buffer counts as thrown away
    /// once it is dropped, and as submitted even if wgpu refused it for an error of validation.
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
        let recording = casters.update(device, queue, encoder);
        self.forget_lost();
        self.mark_touched(casters);
        let RecordOptions { most, draw } = options;
        let due = schedule::take(&mut self.lights, most);
        // What the hardware draws has straight edges.
        let bias = NORMAL_BIAS.max(if draw.is_some() { MapShape::chord_bias() } else { 0.0 });
        for layer in std::mem::take(&mut self.removed) {
            self.lookup.remove(layer);
        }
        for Due { layer, light, .. } in &due {
            self.lookup.set(*layer, light, &self.shape, bias, casters.updates());
        }
        for (layer, light) in schedule::take_lookup_changes(&mut self.lights) {
            self.lookup.set_reading(layer, &light);
        }
        self.lookup.write(device, encoder);
        self.unconfirmed.push((recording, due.iter().map(|due| due.layer).collect()));
        if !due.is_empty() {
            self.record_lights(device, encoder, casters, &due, draw);
        }
        Ok(due.len() as u32)
    }

    /// Forgets the maps of recordings that never happened, since their encoder was thrown away or another one before.
    fn forget_lost(&mut self) {
        let lost = self.unconfirmed.extract_if(.., |(recording, _)| recording.is_lost());
        for (_, layers) in lost {
            self.lookup.write_again();
            for layer in layers {
                self.lookup.remove(layer);
                if let Some((_, light)) = self.lights.iter_mut().find(|(slot, _)| *slot == layer) {
                    light.forget_map();
                }
            }
        }
        self.unconfirmed.retain(|(recording, _)| !recording.is_confirmed());
    }

    /// Marks the lights that a change of the casters has reached.
    fn mark_touched(&mut self, casters: &Casters) {
        let now = (casters.owner(), casters.change_count());
        let seen = self.seen.replace(now);
        if seen == Some(now) {
            return;
        }
        let remembered = seen.filter(|(owner, _)| *owner == now.0).map(|(_, count)| count);
        if remembered.is_none() {
            self.lookup.forget_casters();
            // Those of other casters that are done are as good as confirmed: all their maps are made anew.
            self.unconfirmed.retain(|(recording, _)| recording.is_open());
        }
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
        encoder: &mut wgpu::CommandEncoder,
        casters: &Casters,
        due: &[Due],
        mut draw: Option<&mut dyn FnMut(&mut CasterPass)>,
    ) {
        let (first_live, items) = self.plan(due, draw.is_some());
        let count = items.len() as u32;
        self.recorded = items.len();
        let share = Share::new(&self.shape, casters);
        let mut replaced = self.workspace.fit(device, share, self.lights.count(), count);
        let in_batch = self.workspace.items();
        if draw.is_some() {
            let lights: Vec<PointLight> = due.iter().map(|due| due.light).collect();
            replaced |= self.custom.prepare(device, encoder, &lights, &self.shape, in_batch);
        }
        let batches = batches(first_live, count, in_batch);
        replaced |= self.write_views(device, encoder, casters, &items, &batches);
        let key = (casters.owner(), casters.generation());
        if replaced || self.groups.as_ref().is_none_or(|groups| groups.key != key) {
            self.groups = Some(self.bind(device, casters, key));
        }
        self.workspace.clear_counters(device, encoder, count);
        for batch in batches {
            if let Some(draw) = draw.as_deref_mut().filter(|_| batch.start >= first_live) {
                for (layer, number) in (0..).zip(batch.clone()) {
                    let light = &items[number as usize].light;
                    self.custom.record(encoder, layer, &self.shape, light, number - first_live, draw);
                }
            }
            let target = if batch.start < first_live { Target::Static } else { Target::Live };
            self.record_batch(encoder, casters, batch, target);
        }
    }

    /// What is made: first the maps of static casters, then, from the number that is returned, those that are looked up.
    fn plan(&self, due: &[Due], draws: bool) -> (u32, Vec<Item>) {
        let item = |due: &Due, kinds, start| Item { light: due.light, layer: due.layer, kinds, start };
        let custom = if draws { FROM_CUSTOM } else { 0 };
        if !self.maps.keep_static() {
            return (0, due.iter().map(|due| item(due, STATIC | MOVING, custom)).collect());
        }
        let all_stale = due.iter().filter(|due| due.stale == Stale::Everything);
        let mut items: Vec<Item> = all_stale.map(|due| item(due, STATIC, 0)).collect();
        let first_live = items.len() as u32;
        items.extend(due.iter().map(|due| item(due, MOVING, FROM_STATIC | custom)));
        (first_live, items)
    }

    fn record_batch(&self, encoder: &mut wgpu::CommandEncoder, casters: &Casters, batch: Range<u32>, target: Target) {
        let Some(groups) = &self.groups else { return };
        let (first, items) = (batch.start, batch.len() as u32);
        let parts = self.shape.projection.squares * casters.chunk_count();
        let share = self.workspace.share();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("dual_paraboloid::maps"),
            timestamp_writes: None,
        });
        let masked = casters.triangles_of(MASKED);
        let puts_off = share.overflows || masked > 0;
        self.cull.record(&mut pass, &groups.cull, first, items, parts, !puts_off);
        if self.until >= Stage::Number {
            // Parts that have something put off, at most.
            let late = if share.overflows { parts } else { parts.min(self.shape.projection.squares * masked as u32) };
            if puts_off {
                self.resolve.record(&mut pass, &groups.resolve, first, items, late, false);
            }
            self.assign.record(&mut pass, &groups.assign, first, items, share, self.until >= Stage::Bin);
            if puts_off {
                self.resolve.record(&mut pass, &groups.resolve, first, items, late, true);
            }
        }
        if self.until >= Stage::Rasterise {
            let group = match target {
                Target::Live => &groups.rasterise_live,
                Target::Static => groups.rasterise_static.as_ref().unwrap_or(&groups.rasterise_live),
            };
            self.rasterise.record(&mut pass, group, first, items, &self.shape);
        }
    }

    /// Writes each item's view; returns whether the buffer was replaced, for more items than ever.
    fn write_views(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        casters: &Casters,
        items: &[Item],
        batches: &[Range<u32>],
    ) -> bool {
        let replaced = (items.len() as u64 + u64::from(MOST_ITEMS)) * SLOT > self.views.size();
        if replaced {
            self.views = view_buffer(device, items.len() as u32);
        }
        let view = |number: u32, first: u32| {
            let item = &items[number as usize];
            View::new(item, &self.shape, &self.workspace, casters.chunk_count(), number, number - first)
        };
        let views: Vec<View> = batches.iter().flat_map(|b| b.clone().map(|number| view(number, b.start))).collect();
        gpu::write(device, encoder, &self.views, bytemuck::cast_slice(&views));
        replaced
    }

    fn bind(&self, device: &wgpu::Device, casters: &Casters, key: (u32, u64)) -> Groups {
        let (views, workspace) = (&self.views, &self.workspace);
        let rasterise =
            |target, custom| self.rasterise.bind_group(device, views, workspace, &self.maps, target, custom);
        Groups {
            key,
            cull: self.cull.bind_group(device, views, casters, workspace),
            resolve: self.resolve.bind_groups(device, views, casters, workspace),
            assign: self.assign.bind_group(device, views, casters, workspace),
            rasterise_static: self.maps.keep_static().then(|| rasterise(Target::Static, None)),
            rasterise_live: rasterise(Target::Live, self.custom.depths()),
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
        self.custom.layout()
    }

    /// The longest edge, as the angle in radians that it spans at the light, that [casters that the caller
    /// draws](CasterPass) may have to miss their place by a tenth of a texel at most: 1.2 degrees at 1024 texels.
    #[must_use]
    pub fn caster_angle_limit(&self) -> f32 {
        self.shape.angle_limit()
    }

    /// The maps and lights, as the text of [`wgsl::lookup`](crate::wgsl::lookup) reads them. Stays the same object for ever.
    #[must_use]
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        self.lookup.bind_group()
    }

    /// The maps' depths, `R32Float`: one layer a light, by [`LightId::index`], the front hemisphere in its left half and
    /// the back one in its right. The depth is `near / w`, see [`paraboloid::depth`](crate::paraboloid::depth).
    #[must_use]
    pub fn maps(&self) -> &wgpu::Texture {
        self.maps.depths()
    }

    /// Half a map's width in map coordinates, `1 + g`: the unit disc and the guard band around it.
    #[must_use]
    pub fn half_width(&self) -> f32 {
        self.shape.half_width
    }

    /// Records and jobs that each item of the last recording wanted room for, and how many items it had.
    #[cfg(feature = "compare")]
    pub(crate) fn counters(&self) -> (&wgpu::Buffer, usize) {
        (&self.workspace.state, self.recorded)
    }

    /// The maps' triangles, `R32Uint`, laid out as [`Self::maps`]: the chunk in bits 8-31 and the place in it in bits 0-7;
    /// all bits set where there is none. Tiles that no lookup reads are never written.
    #[cfg(feature = "compare")]
    #[must_use]
    pub fn numbers(&self) -> &wgpu::Texture {
        self.maps.numbers()
    }

    /// Bytes on the GPU: the maps, twice with [`keep_static`](PointShadowsDescriptor::keep_static), and what the lights
    /// share: the workspace of up to eight of them at a time, and a few KiB for each. The workspace has 128 MiB at most,
    /// unless a single light takes more: 32 MiB at a resolution of 1024, in proportion to its square, there at most 32 MiB
    /// for large and winning triangles, and 152 bytes a chunk.
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.maps.memory() + self.workspace.memory() + self.views.size() + self.custom.memory() + self.lookup.memory()
    }
}

/// Batches of at most `most` of `count` items, those before `first_live` apart from those after.
fn batches(first_live: u32, count: u32, most: u32) -> Vec<Range<u32>> {
    let pack = |all: Range<u32>| {
        let end = all.end;
        all.step_by(most as usize).map(move |first| first..(first + most).min(end))
    };
    pack(0..first_live).chain(pack(first_live..count)).collect()
}

fn shape_of(descriptor: &PointShadowsDescriptor) -> MapShape {
    MapShape::new(descriptor.resolution, descriptor.guard)
}

fn validate(descriptor: &PointShadowsDescriptor, limits: &wgpu::Limits) -> Result<(), Error> {
    let check = |ok: bool, what, value: String, remedy: String| {
        if ok { Ok(()) } else { Err(Error::InvalidDescriptor { what, value, remedy }) }
    };
    let (widest, layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
    let PointShadowsDescriptor { capacity, resolution, guard, .. } = *descriptor;
    let room = format!("it must be 1 to {layers}, the device's limit of texture layers");
    check((1..=layers).contains(&capacity), "capacity", capacity.to_string(), room)?;
    let most = (widest / 2).min(MOST_RESOLUTION);
    let room = format!("it must be 1 to {most}, half the width of the device's largest texture and 4096 at most");
    check((1..=most).contains(&resolution), "resolution", resolution.to_string(), room)?;
    let room = "it must be 1 to 16 texels".to_owned();
    check((1.0..=16.0).contains(&guard), "guard", guard.to_string(), room)
}

/// A slot for each of so many items, and as many more as are bound behind the last one.
fn view_buffer(device: &wgpu::Device, items: u32) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    gpu::buffer(device, "views", u64::from(items + MOST_ITEMS) * SLOT, usage)
}
