//! The depth stage for casters with holes: the same draws with pipelines that cut them out (`shaders/masked.wgsl`).

use crate::casters::VERTEX_SIZE;
use crate::depth::{self, Pipelines};
use crate::gpu::{self, Binding};
use crate::mask;

#[derive(Debug)]
pub(crate) struct Masked {
    pub(crate) pipelines: Pipelines,
    mask_layout: wgpu::BindGroupLayout,
    piece_layout: wgpu::BindGroupLayout,
}

/// What the pipelines read beside what those of other casters do: groups 1 and 2.
pub(crate) type Groups = [wgpu::BindGroup; 2];

impl Masked {
    /// `layout` is of group 0 of whole triangles and pieces, `exact_layout` of that of triangles drawn exactly.
    pub(crate) fn new(
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        exact_layout: &wgpu::BindGroupLayout,
    ) -> Self {
        let mask_layout = mask::layout(device);
        let piece_layout = gpu::layout(device, "masked", wgpu::ShaderStages::VERTEX, &[Binding::Read; 3]);
        let module = gpu::shader(device, "masked", crate::wgsl::masked());
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32];
        let layouts = [layout, &mask_layout, &piece_layout];
        let pipeline = |entry_point, buffers: &[_]| {
            depth::depth_pipeline(device, &layouts, &module, entry_point, buffers, Some("cut_out"))
        };
        let pipelines = Pipelines {
            whole: pipeline("masked", &[Some(depth::vertex_buffer(VERTEX_SIZE, &attributes))]),
            pieces: pipeline("masked_piece", &[]),
            exact: depth::exact_pipelines(device, &[exact_layout, &mask_layout], "exact_masked_fragment"),
        };
        Self { pipelines, mask_layout, piece_layout }
    }

    /// The masks' buffers are those of `shaders/mask.wgsl`, in order.
    pub(crate) fn groups(
        &self,
        device: &wgpu::Device,
        masks: [&wgpu::Buffer; 3],
        lists: &wgpu::Buffer,
        vertices: &wgpu::Buffer,
        pieces: &wgpu::Buffer,
    ) -> Groups {
        let bind = |what, layout, buffers: [&wgpu::Buffer; 3]| {
            gpu::bind_group(device, what, layout, &buffers.map(wgpu::Buffer::as_entire_binding))
        };
        [bind("masks", &self.mask_layout, masks), bind("masked", &self.piece_layout, [lists, vertices, pieces])]
    }
}
