//! Casters that the caller draws into the maps with pipelines of its own.

use crate::batch::MOST_ITEMS;
use crate::gpu::{self, Binding};
use crate::light::{Coverage, PointLight};
use crate::maps;
use crate::view::{HemisphereView, MapShape, SLOT};

/// A render pass over one hemisphere's map, for the caller to draw casters in: what
/// [`RecordOptions::draw`](crate::RecordOptions::draw) is called with, once for each hemisphere of each map that is made.
///
/// The viewport is set. A pipeline for it has
///
/// - in its vertex shader the text of [`wgsl::caster`](crate::wgsl::caster) and
///   `@invariant @builtin(position) position = dp_caster_position(world_position)`, in its fragment shader nothing, or
///   what discards,
/// - [`PointShadows::caster_bind_group_layout`](crate::PointShadows::caster_bind_group_layout) in the group of that text,
/// - [`CasterPass::depth_state`], and no colour target.
///
/// The hardware draws straight edges, so the caller sees to it that
///
/// - no edge spans more than [`PointShadows::caster_angle_limit`](crate::PointShadows::caster_angle_limit) as seen from
///   the light. Longer ones miss their place, and the depth between their ends is off, in proportion to the square,
/// - triangles that share an edge share its ends to the bit, or there are cracks.
#[derive(Debug)]
pub struct CasterPass<'a> {
    /// What to draw with.
    pub pass: wgpu::RenderPass<'a>,
    /// The light, so that what is out of its range may be left out.
    pub light: PointLight,
    /// Whether this is the hemisphere around the light's -Z.
    pub back: bool,
    pub(crate) hemisphere: &'a wgpu::BindGroup,
    pub(crate) offset: u32,
}

impl CasterPass<'_> {
    /// Binds what the text of [`wgsl::caster`](crate::wgsl::caster) reads, under the same number.
    pub fn bind(&mut self, group: u32) {
        self.pass.set_bind_group(group, self.hemisphere, &[self.offset]);
    }

    /// The depth state of pipelines: `Depth32Float`, reversed.
    #[must_use]
    pub fn depth_state() -> wgpu::DepthStencilState {
        gpu::depth_state()
    }
}

/// What the caller draws to, before the library's own casters are added.
#[derive(Debug)]
pub(crate) struct Custom {
    layout: wgpu::BindGroupLayout,
    views: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// Made when it is first needed.
    depths: Option<Depths>,
}

/// A layer for each item of a batch.
#[derive(Debug)]
struct Depths {
    texture: wgpu::Texture,
    all: wgpu::TextureView,
    layers: Vec<wgpu::TextureView>,
}

impl Custom {
    /// For at most `lights` lights in one recording.
    pub(crate) fn new(device: &wgpu::Device, lights: u32) -> Self {
        let layout = gpu::layout(device, "caster", wgpu::ShaderStages::VERTEX, &[Binding::Uniform]);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let views = gpu::buffer(device, "caster::views", u64::from(lights) * 2 * SLOT, usage);
        let size = size_of::<HemisphereView>() as u64;
        let group = gpu::bind_group(device, "caster", &layout, &[gpu::dynamic(&views, size)]);
        Self { layout, views, group, depths: None }
    }

    /// Layout of a hemisphere's view, with a dynamic offset.
    pub(crate) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// What is drawn to, all layers.
    pub(crate) fn depths(&self) -> Option<&wgpu::TextureView> {
        self.depths.as_ref().map(|depths| &depths.all)
    }

    pub(crate) fn memory(&self) -> u64 {
        self.views.size() + self.depths.as_ref().map_or(0, |depths| maps::bytes(&depths.texture))
    }

    /// Makes room for a batch of `items` items, and writes the views of all lights of a recording. Returns whether there
    /// is another texture.
    pub(crate) fn prepare(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        lights: &[PointLight],
        shape: &MapShape,
        items: u32,
    ) -> bool {
        let mut bytes = vec![0u8; lights.len() * (2 * SLOT) as usize];
        for (i, slot) in bytes.chunks_exact_mut(SLOT as usize).enumerate() {
            let view = HemisphereView::new(&lights[i / 2], shape, i % 2 == 1);
            slot[..size_of_val(&view)].copy_from_slice(bytemuck::bytes_of(&view));
        }
        gpu::write(device, encoder, &self.views, &bytes);
        let fits = |depths: &Depths| depths.layers.len() as u32 >= items;
        if self.depths.as_ref().is_some_and(fits) {
            return false;
        }
        debug_assert!(items <= MOST_ITEMS);
        self.depths = Some(Depths::new(device, shape.resolution, items));
        true
    }

    /// Lets the caller draw for the `number`th light of a recording, to a layer.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        layer: u32,
        shape: &MapShape,
        light: &PointLight,
        number: u32,
        draw: &mut dyn FnMut(&mut CasterPass),
    ) {
        let Some(depths) = &self.depths else { return };
        let size = shape.resolution as f32;
        let hemispheres = match light.coverage {
            Coverage::Full => 0..2,
            Coverage::Hemisphere => 0..1,
        };
        for back in hemispheres {
            // A pass for each, so that nothing that the caller sets outlives it.
            let load = if back == 0 { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("dual_paraboloid::caster"),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depths.layers[layer as usize],
                    depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_viewport(size * back as f32, 0.0, size, size, 0.0, 1.0);
            let offset = (2 * number + back) * SLOT as u32;
            draw(&mut CasterPass { pass, light: *light, back: back == 1, hemisphere: &self.group, offset });
        }
    }
}

impl Depths {
    fn new(device: &wgpu::Device, resolution: u32, layers: u32) -> Self {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let size = [2 * resolution, resolution, layers];
        let texture = maps::texture(device, "caster::depths", size, wgpu::TextureFormat::Depth32Float, usage);
        let layer = |layer| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some("dual_paraboloid::caster::layer"),
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        Self { all: maps::array_view(&texture), layers: (0..layers).map(layer).collect(), texture }
    }
}
