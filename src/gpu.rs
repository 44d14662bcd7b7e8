//! Shorthands for what every stage creates, with the labels of the crate.

use crate::Error;

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
    Counters,
    /// Storage that the shader reads.
    Read,
    /// Storage that the shader writes.
    Write,
}

/// Layout with bindings 0, 1, ... all for the stages `visibility`.
pub(crate) fn layout(
    device: &wgpu::Device,
    what: &str,
    visibility: wgpu::ShaderStages,
    bindings: &[Binding],
) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = bindings
        .iter()
        .enumerate()
        .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility,
            ty: wgpu::BindingType::Buffer {
                ty: match kind {
                    Binding::Uniform => wgpu::BufferBindingType::Uniform,
                    Binding::Read => wgpu::BufferBindingType::Storage { read_only: true },
                    Binding::Counters | Binding::Write => wgpu::BufferBindingType::Storage { read_only: false },
                },
                has_dynamic_offset: matches!(kind, Binding::Uniform | Binding::Counters),
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label(what)), entries: &entries })
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

/// Pipeline of the entry point `what` of a module, with a layout or, without one, that of the shader.
pub(crate) fn compute_pipeline(
    device: &wgpu::Device,
    what: &str,
    module: &wgpu::ShaderModule,
    layout: Option<&wgpu::BindGroupLayout>,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let layout = layout.map(|group| pipeline_layout(device, what, &[group]));
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

/// The sizes of the stages' workgroups and dispatches. Two sets ship, and both make the same maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Workgroups {
    /// For devices that run a workgroup's threads side by side.
    Gpu,
    /// For devices in software, where a barrier costs a microsecond for every eight threads.
    Software,
}

impl Workgroups {
    /// Those that suit the device.
    pub(crate) fn of(device: &wgpu::Device) -> Self {
        match device.adapter_info().device_type {
            wgpu::DeviceType::Cpu => Self::Software,
            _ => Self::Gpu,
        }
    }
}
