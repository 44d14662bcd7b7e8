//! The lights' maps: one layer a light, and a second one for its static casters where those are kept.

/// Depth textures with a layer for each light.
#[derive(Debug)]
pub(crate) struct Maps {
    live: Layers,
    /// What static casters alone make of each map.
    kept: Option<Layers>,
}

/// Which of a light's maps is drawn to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Target {
    /// The one that is looked up.
    Live,
    /// That of its static casters.
    Static,
}

#[derive(Debug)]
struct Layers {
    texture: wgpu::Texture,
    views: Vec<wgpu::TextureView>,
}

impl Maps {
    pub(crate) fn new(device: &wgpu::Device, capacity: u32, resolution: u32, keep_static: bool) -> Self {
        let live_usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let live_usage = if keep_static { live_usage | wgpu::TextureUsages::COPY_DST } else { live_usage };
        let kept = || Layers::new(device, "static maps", capacity, resolution, wgpu::TextureUsages::COPY_SRC);
        Self { live: Layers::new(device, "maps", capacity, resolution, live_usage), kept: keep_static.then(kept) }
    }

    /// The texture that is looked up.
    pub(crate) fn live(&self) -> &wgpu::Texture {
        &self.live.texture
    }

    /// Whether static casters have maps of their own.
    pub(crate) fn keep_static(&self) -> bool {
        self.kept.is_some()
    }

    pub(crate) fn layer(&self, target: Target, layer: u32) -> &wgpu::TextureView {
        let layers = match (target, &self.kept) {
            (Target::Static, Some(kept)) => kept,
            _ => &self.live,
        };
        &layers.views[layer as usize]
    }

    /// Makes a light's map that of its static casters.
    pub(crate) fn copy_static(&self, encoder: &mut wgpu::CommandEncoder, layer: u32) {
        let Some(kept) = &self.kept else { return };
        let at = |texture| wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
            aspect: wgpu::TextureAspect::All,
        };
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..kept.texture.size() };
        encoder.copy_texture_to_texture(at(&kept.texture), at(&self.live.texture), size);
    }

    /// Bytes of all layers.
    pub(crate) fn memory(&self) -> u64 {
        [Some(&self.live), self.kept.as_ref()].into_iter().flatten().map(Layers::memory).sum()
    }
}

impl Layers {
    fn new(device: &wgpu::Device, what: &str, count: u32, resolution: u32, usage: wgpu::TextureUsages) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&format!("dual_paraboloid::{what}")),
            size: wgpu::Extent3d { width: 2 * resolution, height: resolution, depth_or_array_layers: count },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Depth32Float,
            usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let view = |layer| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some("dual_paraboloid::depth::layer"),
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let views = (0..count).map(view).collect();
        Self { texture, views }
    }

    fn memory(&self) -> u64 {
        let size = self.texture.size();
        4 * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
    }
}
