//! A device to measure and test on, and what comes back from it.

use crate::{Casters, LightId, PointShadows};
use bytemuck::Pod;
use glam::Vec3;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Device and queue without a window.
#[derive(Debug)]
pub struct Gpu {
    /// The device, with the adapter's own limits.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name and driver, for reports.
    pub info: wgpu::AdapterInfo,
}

/// No device to draw with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No Vulkan, Metal or DirectX 12 adapter.
    #[error("no graphics adapter: install a driver; in software, Debian's libvulkan1 and mesa-vulkan-drivers do")]
    NoAdapter,
    /// An adapter that gives no device.
    #[error("the adapter {name} gives no device: {reason}")]
    NoDevice {
        /// The adapter's name.
        name: String,
        /// What it said.
        reason: String,
    },
}

impl Gpu {
    /// The best adapter there is: a discrete GPU before an integrated one, and a software driver last. `features`
    /// are requested as far as the adapter has them.
    ///
    /// # Errors
    /// [`GpuError`] if there is none.
    pub fn new(features: wgpu::Features) -> Result<Self, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        descriptor.flags = wgpu::InstanceFlags::from_build_config().with_env();
        let instance = wgpu::Instance::new(descriptor);
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        let rank = |adapter: &wgpu::Adapter| match adapter.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        };
        let adapter = adapters.into_iter().min_by_key(rank).ok_or(GpuError::NoAdapter)?;
        let info = adapter.get_info();
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("dual_paraboloid::compare"),
            required_features: features & adapter.features(),
            required_limits: adapter.limits(),
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request)
            .map_err(|error| GpuError::NoDevice { name: info.name.clone(), reason: error.to_string() })?;
        Ok(Self { device, queue, info })
    }

    /// Name of the device and its driver.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} ({} {})", self.info.name, self.info.driver, self.info.driver_info).replace(" )", ")")
    }

    /// Encodes and submits, and returns what the encoding did.
    pub fn submit<T>(&self, encode: impl FnOnce(&mut wgpu::CommandEncoder) -> T) -> T {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let result = encode(&mut encoder);
        self.queue.submit([encoder.finish()]);
        result
    }

    /// Does something that may ask for more than the device has, and returns the device's first complaint, if any.
    ///
    /// # Errors
    /// What the device said; what was made is then of no use.
    pub fn attempt<T>(&self, attempt: impl FnOnce() -> T) -> Result<T, wgpu::Error> {
        let filters = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let made = attempt();
        self.wait();
        // The last one pushed goes first: a lack of memory is the cause of other complaints.
        let complaints: Vec<_> = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
        complaints.into_iter().next().map_or(Ok(made), Err)
    }

    /// Waits until the device has done everything submitted.
    pub fn wait(&self) {
        // A device that is lost has nothing left to wait for.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
    }

    /// The contents of a buffer that may be copied from.
    ///
    /// # Panics
    /// If the device is lost.
    #[must_use]
    pub fn read<T: Pod>(&self, buffer: &wgpu::Buffer) -> Vec<T> {
        let staging = self.staging(buffer.size());
        self.submit(|encoder| encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size()));
        self.mapped(&staging, bytemuck::pod_collect_to_vec)
    }

    /// One layer of a texture, row by row.
    ///
    /// # Panics
    /// If the device is lost.
    #[must_use]
    pub fn read_texture<T: Pod>(&self, texture: &wgpu::Texture, layer: u32) -> Vec<T> {
        let (width, height) = (texture.width(), texture.height());
        let texel = texture.format().block_copy_size(None).unwrap_or(4);
        let row = (texel * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = self.staging(u64::from(row) * u64::from(height));
        self.submit(|encoder| {
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
                    aspect: wgpu::TextureAspect::All,
                },
                wgpu::TexelCopyBufferInfo {
                    buffer: &staging,
                    layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
                },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
        });
        self.mapped(&staging, |bytes| {
            let rows = bytes.chunks_exact(row as usize).map(|line| &line[..(texel * width) as usize]);
            rows.flat_map(bytemuck::pod_collect_to_vec::<u8, T>).collect()
        })
    }

    fn staging(&self, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("dual_paraboloid::compare::staging"),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        })
    }

    fn mapped<R>(&self, staging: &wgpu::Buffer, use_bytes: impl FnOnce(&[u8]) -> R) -> R {
        staging.map_async(wgpu::MapMode::Read, .., |result| {
            if let Err(error) = result {
                eprintln!("reading back failed: {error}");
            }
        });
        self.wait();
        let view = staging.get_mapped_range(..).expect("the device is lost");
        use_bytes(&view)
    }

    /// A light's maps, 2R texels a row: the front hemisphere in the left half, the back one in the right.
    #[must_use]
    pub fn read_map(&self, shadows: &PointShadows, light: LightId) -> Vec<f32> {
        self.read_texture(shadows.maps(), light.index())
    }

    /// What `dp_shadow` says of each receiver, given by position and geometric normal, at the point alone.
    #[must_use]
    pub fn shadow_values(
        &self,
        shadows: &PointShadows,
        casters: &Casters,
        light: LightId,
        receivers: &[(Vec3, Vec3)],
    ) -> Vec<f32> {
        self.lookup_values(
            shadows,
            casters,
            &format!("dp_shadow({}u, position, normal, view)", light.index()),
            receivers,
        )
    }

    /// What `dp_shadow` of the lookup without triangles says of each receiver.
    #[must_use]
    pub fn vote_values(&self, shadows: &PointShadows, light: LightId, receivers: &[(Vec3, Vec3)]) -> Vec<f32> {
        let call = format!("dp_shadow({}u, position, normal, view)", light.index());
        let text = [crate::wgsl::lookup_votes(0), evaluation(&call)].concat();
        self.evaluate(&text, &[(shadows.bind_group(), shadows.bind_group_layout())], receivers)
    }

    /// What `dp_shadow_filtered` says of each receiver, by the light's filter, at the point alone and without noise.
    #[must_use]
    pub fn filtered_values(
        &self,
        shadows: &PointShadows,
        casters: &Casters,
        light: LightId,
        receivers: &[(Vec3, Vec3)],
    ) -> Vec<f32> {
        let call = format!("dp_shadow_filtered({}u, position, normal, view, 0.0)", light.index());
        self.lookup_values(shadows, casters, &call, receivers)
    }

    /// What a WGSL expression over `position`, `normal` and `view` gives, with the text of the library's lookup.
    #[must_use]
    pub fn lookup_values(
        &self,
        shadows: &PointShadows,
        casters: &Casters,
        expression: &str,
        receivers: &[(Vec3, Vec3)],
    ) -> Vec<f32> {
        let text = [crate::wgsl::lookup(0, 1), evaluation(expression)].concat();
        let groups =
            [(shadows.bind_group(), shadows.bind_group_layout()), (casters.bind_group(), casters.bind_group_layout())];
        self.evaluate(&text, &groups, receivers)
    }

    /// Number of receivers that one evaluation takes at most.
    #[must_use]
    pub fn most_receivers(&self) -> u64 {
        self.device.limits().max_storage_buffer_binding_size / size_of::<[Vec3; 2]>() as u64
    }

    /// Runs the entry point `evaluate` of a module made with [`evaluation`], one thread a receiver. The groups are
    /// bound from 0 on.
    #[must_use]
    pub fn evaluate(
        &self,
        text: &str,
        groups: &[(&wgpu::BindGroup, &wgpu::BindGroupLayout)],
        receivers: &[(Vec3, Vec3)],
    ) -> Vec<f32> {
        let (groups, layouts): (Vec<_>, Vec<_>) = groups.iter().map(|&(group, layout)| (Some(group), layout)).unzip();
        self.evaluator(text, &layouts, receivers).values(self, &groups)
    }

    /// [`Self::evaluate`] for several groups of the same layouts, one after the other.
    #[must_use]
    pub fn evaluator(&self, text: &str, layouts: &[&wgpu::BindGroupLayout], receivers: &[(Vec3, Vec3)]) -> Evaluator {
        let device = &self.device;
        let input: Vec<[f32; 3]> = receivers.iter().flat_map(|(p, n)| [p.to_array(), n.to_array()]).collect();
        let input = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("dual_paraboloid::compare::receivers"),
            contents: bytemuck::cast_slice(&input),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let output = crate::gpu::buffer(device, "compare::values", 4 * receivers.len() as u64, usage);
        let staging = self.staging(output.size());
        let own_layout = crate::gpu::layout(
            device,
            "compare::evaluate",
            wgpu::ShaderStages::COMPUTE,
            &[crate::gpu::Binding::Read, crate::gpu::Binding::Write],
        );
        let resources = [input.as_entire_binding(), output.as_entire_binding()];
        let mut layouts: Vec<Option<&wgpu::BindGroupLayout>> = layouts.iter().copied().map(Some).collect();
        layouts.resize(EVALUATION_GROUP, None);
        layouts.push(Some(&own_layout));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("dual_paraboloid::compare::evaluate"),
            bind_group_layouts: &layouts,
            ..Default::default()
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("dual_paraboloid::compare::evaluate"),
            layout: Some(&layout),
            module: &crate::gpu::shader(device, "compare::evaluate", text.to_owned()),
            entry_point: Some("evaluate"),
            compilation_options: Default::default(),
            cache: None,
        });
        let own = crate::gpu::bind_group(device, "compare::evaluate", &own_layout, &resources);
        Evaluator { pipeline, own, output, staging, workgroups: (receivers.len() as u32).div_ceil(64).clamp(1, 65_535) }
    }
}

/// Receivers on the device, and what asks for each.
#[derive(Debug)]
pub struct Evaluator {
    pipeline: wgpu::ComputePipeline,
    own: wgpu::BindGroup,
    output: wgpu::Buffer,
    staging: wgpu::Buffer,
    workgroups: u32,
}

impl Evaluator {
    /// One value for each receiver. The groups are bound from 0 on.
    ///
    /// # Panics
    /// If the device is lost.
    #[must_use]
    pub fn values(&self, gpu: &Gpu, groups: &[Option<&wgpu::BindGroup>]) -> Vec<f32> {
        self.with_values(gpu, groups, <[f32]>::to_vec)
    }

    /// Does something with one value for each receiver, where the device wrote them. The groups are bound from 0 on.
    ///
    /// # Panics
    /// If the device is lost.
    pub fn with_values<R>(
        &self,
        gpu: &Gpu,
        groups: &[Option<&wgpu::BindGroup>],
        use_values: impl FnOnce(&[f32]) -> R,
    ) -> R {
        gpu.submit(|encoder| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            for (number, group) in (0..).zip(groups) {
                pass.set_bind_group(number, *group, &[]);
            }
            pass.set_bind_group(EVALUATION_GROUP as u32, &self.own, &[]);
            pass.dispatch_workgroups(self.workgroups, 1, 1);
            drop(pass);
            encoder.copy_buffer_to_buffer(&self.output, 0, &self.staging, 0, self.output.size());
        });
        let result = gpu.mapped(&self.staging, |bytes| use_values(bytemuck::cast_slice(bytes)));
        self.staging.unmap();
        result
    }
}

/// Group of the receivers and values in [`evaluation`].
const EVALUATION_GROUP: usize = 3;

/// Entry point `evaluate`, which writes the value of a WGSL expression over `position`, `normal` and a `view` without pixels for
/// each receiver.
#[must_use]
pub fn evaluation(expression: &str) -> String {
    evaluation_over("vec4<f32>(0.0)", expression)
}

/// [`evaluation`] with another WGSL expression, over `position` and `normal`, for the `view`.
#[must_use]
pub fn evaluation_over(view: &str, expression: &str) -> String {
    format!(
        "
@group({EVALUATION_GROUP}) @binding(0) var<storage, read> receivers: array<f32>;
@group({EVALUATION_GROUP}) @binding(1) var<storage, read_write> values: array<f32>;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{
    for (var i = id.x; i < arrayLength(&values); i += groups.x * 64u) {{
        let at = 6u * i;
        let position = vec3<f32>(receivers[at], receivers[at + 1u], receivers[at + 2u]);
        let normal = vec3<f32>(receivers[at + 3u], receivers[at + 4u], receivers[at + 5u]);
        let view = {view};
        values[i] = {expression};
    }}
}}
"
    )
}

/// What the last recording counted, over all its lights.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Large triangles that were recorded for the tiles, counted in each hemisphere.
    pub large: u32,
    /// Rows of blocks of tiles that were gone through for them.
    pub jobs: u32,
}

impl Gpu {
    /// Counts of the last recording that made a map.
    #[must_use]
    pub fn statistics(&self, shadows: &PointShadows) -> Statistics {
        let (state, items) = shadows.counters();
        let words: Vec<u32> = self.read(state);
        let mut sum = Statistics::default();
        for item in words.chunks_exact(8).take(items) {
            sum.large += item[0];
            sum.jobs += item[1];
        }
        sum
    }
}
