//! The lights' maps: one layer a light of depths and of triangles' numbers, and a second one for its static casters where
//! those are kept.

/// Format of the depths, `near / w`.
pub(crate) const DEPTHS: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
/// Format of the numbers of triangles.
pub(crate) const NUMBERS: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// Textures with a layer for each light.
#[derive(Debug)]
pub(crate) struct Maps {
    live: Layers,
    /// What static casters alone make of each map.
    kept: Option<Layers>,
}

/// Which of a light's maps is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Target {
    /// The one that is looked up.
    Live,
    /// That of its static casters.
    Static,
}

#[derive(Debug)]
struct Layers {
    textures: [wgpu::Texture; 2],
    views: [wgpu::TextureView; 2],
}

impl Maps {
    /// Of so many texels across and down, and so many layers.
    pub(crate) fn new(device: &wgpu::Device, size: [u32; 3], keep_static: bool) -> Self {
        let layers = |what| Layers::new(device, what, size);
        Self { live: layers("maps"), kept: keep_static.then(|| layers("static maps")) }
    }

    /// The depths that are looked up.
    pub(crate) fn depths(&self) -> &wgpu::Texture {
        &self.live.textures[0]
    }

    /// The numbers of the triangles whose depths they are.
    #[cfg(feature = "compare")]
    pub(crate) fn numbers(&self) -> &wgpu::Texture {
        &self.live.textures[1]
    }

    /// Whether static casters have maps of their own.
    pub(crate) fn keep_static(&self) -> bool {
        self.kept.is_some()
    }

    /// Depths and numbers of all layers.
    pub(crate) fn views(&self, target: Target) -> [&wgpu::TextureView; 2] {
        match (target, &self.kept) {
            (Target::Static, Some(kept)) => kept.views.each_ref(),
            _ => self.live.views.each_ref(),
        }
    }

    /// Bytes of all layers.
    pub(crate) fn memory(&self) -> u64 {
        let layers = [Some(&self.live), self.kept.as_ref()];
        layers.into_iter().flatten().flat_map(|layers| &layers.textures).map(bytes).sum()
    }
}

impl Layers {
    fn new(device: &wgpu::Device, what: &str, size: [u32; 3]) -> Self {
        use wgpu::TextureUsages as Usage;
        let usage = Usage::TEXTURE_BINDING | Usage::STORAGE_BINDING | Usage::COPY_SRC;
        let textures = [DEPTHS, NUMBERS].map(|format| texture(device, what, size, format, usage));
        Self { views: textures.each_ref().map(array_view), textures }
    }
}

/// A texture of width, height and layers.
pub(crate) fn texture(
    device: &wgpu::Device,
    what: &str,
    [width, height, depth_or_array_layers]: [u32; 3],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&format!("dual_paraboloid::{what}")),
        size: wgpu::Extent3d { width, height, depth_or_array_layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// All layers of a texture.
pub(crate) fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        label: Some("dual_paraboloid::maps::layers"),
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

/// Bytes of a texture of four bytes a texel.
pub(crate) fn bytes(texture: &wgpu::Texture) -> u64 {
    4 * u64::from(texture.width()) * u64::from(texture.height()) * u64::from(texture.depth_or_array_layers())
}
