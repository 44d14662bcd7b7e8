//! Shorthands for what every stage creates, with the labels of the crate.

use crate::Error;
use crate::batch::MOST_ITEMS;
use crate::view::SLOT;

/// Label of an object of the library.
fn label(what: &str) -> String {
    format!("dual_paraboloid::{what}")
}

pub(crate) fn shader(device: &wgpu::Device, what: &str, text: String) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(&label(what)),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    })
}

pub(crate) fn buffer(device: &wgpu::Device, what: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: Some(&label(what)), size, usage, mapped_at_creation: false })
}

/// Bindings 0, 1, ... of a group.
pub(crate) fn bind_group(
    device: &wgpu::Device,
    what: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry> = resources
        .iter()
        .enumerate()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(&label(what)), layout, entries: &entries })
}

/// A binding of `size` bytes whose offset is given when the group is set.
pub(crate) fn dynamic(buffer: &wgpu::Buffer, size: u64) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size: wgpu::BufferSize::new(size) })
}

/// How a buffer is bound.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Binding {
    /// Uniform with an offset given when the group is set.
    Uniform,
    /// Storage, written by the shader, with an offset given when the group is set.
    #[cfg(feature = "compare")]
    Counters,
    /// Storage that the shader reads.
    Read,
    /// Storage that the shader writes.
    Write,
}

impl Binding {
    fn has_offset(self) -> bool {
        match self {
            Self::Uniform => true,
            #[cfg(feature = "compare")]
            Self::Counters => true,
            Self::Read | Self::Write => false,
        }
    }
}

/// Layout with buffers as bindings 0, 1, ... all for the stages `visibility`.
pub(crate) fn layout(
    device: &wgpu::Device,
    what: &str,
    visibility: wgpu::ShaderStages,
    bindings: &[Binding],
) -> wgpu::BindGroupLayout {
    let types: Vec<wgpu::BindingType> = bindings
        .iter()
        .map(|kind| wgpu::BindingType::Buffer {
            ty: match kind {
                Binding::Uniform => wgpu::BufferBindingType::Uniform,
                Binding::Read => wgpu::BufferBindingType::Storage { read_only: true },
                _ => wgpu::BufferBindingType::Storage { read_only: false },
            },
            has_dynamic_offset: kind.has_offset(),
            min_binding_size: None,
        })
        .collect();
    layout_of(device, what, visibility, &types)
}

/// Layout with bindings 0, 1, ... of any type, all for the stages `visibility`.
pub(crate) fn layout_of(
    device: &wgpu::Device,
    what: &str,
    visibility: wgpu::ShaderStages,
    types: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0..)
        .zip(types)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label(what)), entries: &entries })
}

/// Group of a batch's views, and of buffers after them.
pub(crate) fn bind_after_views(
    device: &wgpu::Device,
    what: &str,
    layout: &wgpu::BindGroupLayout,
    views: &wgpu::Buffer,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let mut resources = vec![dynamic(views, u64::from(MOST_ITEMS) * SLOT)];
    resources.extend(buffers.iter().map(|buffer| buffer.as_entire_binding()));
    bind_group(device, what, layout, &resources)
}

pub(crate) fn pipeline_layout(
    device: &wgpu::Device,
    what: &str,
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::PipelineLayout {
    let groups: Vec<Option<&wgpu::BindGroupLayout>> = groups.iter().map(|group| Some(*group)).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&label(what)),
        bind_group_layouts: &groups,
        ..Default::default()
    })
}

/// Pipeline of the entry point `what` of a module, with the layouts of its groups or, without any, those of the shader.
pub(crate) fn compute_pipeline(
    device: &wgpu::Device,
    what: &str,
    module: &wgpu::ShaderModule,
    groups: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let layout = (!groups.is_empty()).then(|| pipeline_layout(device, what, groups));
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(&label(what)),
        layout: layout.as_ref(),
        module,
        entry_point: Some(what),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            // Every stage writes what it reads of its own memory.
            zero_initialize_workgroup_memory: false,
        },
        cache: None,
    })
}

/// Has an encoder write to a buffer, from its start on. `Queue::write_buffer` would come before all of the encoder's commands
/// and those of others that wait, and happen even if the encoder is thrown away.
pub(crate) fn write(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, buffer: &wgpu::Buffer, bytes: &[u8]) {
    let size = bytes.len() as u64;
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&label("staging")),
        size,
        usage: wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    });
    // Fails only where the device has been lost a moment ago, and then it doesn't matter.
    if let Ok(mut range) = staging.get_mapped_range_mut(..) {
        range.copy_from_slice(bytes);
    }
    staging.unmap();
    encoder.copy_buffer_to_buffer(&staging, 0, buffer, 0, size);
}

/// Reversed depth in the format of the maps: nearer to the light wins.
pub(crate) fn depth_state() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: wgpu::TextureFormat::Depth32Float,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Says if the device is lost.
///
/// There is no asking it, and its callback for that is the caller's. But what a lost device makes can't be mapped, and
/// that is no error of validation, which would be the end of most programs.
pub(crate) fn check(device: &wgpu::Device) -> Result<(), Error> {
    let probe = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&label("probe")),
        size: wgpu::COPY_BUFFER_ALIGNMENT,
        usage: wgpu::BufferUsages::MAP_WRITE,
        mapped_at_creation: true,
    });
    probe.get_mapped_range(..).map(|_| ()).map_err(|_| Error::DeviceLost)
}

/// How the stages share their work out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Workgroups {
    /// A thread for each triangle of a chunk and each pair of a tile's texels.
    Gpu,
    /// Few threads with much to do, for devices in software: there a barrier costs a microsecond for every eight threads.
    Software,
}

impl Workgroups {
    /// Those that suit a device.
    #[must_use]
    pub fn of(device: &wgpu::Device) -> Self {
        match device.adapter_info().device_type {
            wgpu::DeviceType::Cpu => Self::Software,
            _ => Self::Gpu,
        }
    }

    fn choose(self, gpu: u32, software: u32) -> u32 {
        if self == Self::Gpu { gpu } else { software }
    }

    /// Threads of a workgroup that goes through a chunk.
    pub(crate) fn chunk_threads(self) -> u32 {
        self.choose(256, 8)
    }

    /// Workgroups that parts are shared out among: on a GPU about twice as many as run at a time. In software so many that none
    /// takes more than some dozen: llvmpipe ends the loops of an invocation after 65,535 rounds in all.
    pub(crate) fn part_groups(self) -> u32 {
        self.choose(2048, 1024)
    }

    /// Workgroups that share a part at most.
    pub(crate) fn most_split(self) -> u32 {
        self.choose(4, 1)
    }

    /// Workgroups that what is drawn late is shared out among; in software many, for the same reason.
    pub(crate) fn late_groups(self) -> u32 {
        self.choose(1024, 8192)
    }

    /// Rows of what is drawn late that a workgroup takes at a time, about: each does what comes before the rows anew.
    pub(crate) fn rows_of_band(self) -> u32 {
        self.choose(64, 256)
    }

    /// Threads that share a row of what is drawn late.
    pub(crate) fn row_lanes(self) -> u32 {
        self.choose(8, 1)
    }

    /// Fewer winners than this are shared out among several threads each, as they leave most of a GPU idle.
    pub(crate) fn few_winners(self) -> u32 {
        self.choose(32_768, 0)
    }

    /// Workgroups that lists are shared out among.
    pub(crate) fn list_groups(self) -> u32 {
        self.choose(1024, 64)
    }

    /// Pairs of a tile's texels that a thread takes.
    pub(crate) fn pairs(self) -> u32 {
        self.choose(1, 16)
    }

    pub(crate) fn has_cheap_barriers(self) -> bool {
        self == Self::Gpu
    }
}
