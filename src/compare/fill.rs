//! From a scene to casters.

use super::gpu::Gpu;
use super::scene::Scene;
use crate::{CasterMesh, Casters, Error, Indices, InstanceId, Mask, Sides};
use wgpu::util::{DeviceExt, TextureDataOrder};

/// Adds every mesh and instance of a scene, all with the same rule for sides, masked ones with their holes. Returns the
/// instances' handles in the scene's order.
///
/// # Errors
/// Whatever [`Casters::add_mesh`] and [`Casters::add_instance`] return.
pub fn fill(casters: &mut Casters, gpu: &Gpu, scene: &Scene, sides: Sides) -> Result<Vec<InstanceId>, Error> {
    let mut textures: Vec<Option<wgpu::Texture>> = vec![None; scene.images.len()];
    let mut meshes = Vec::with_capacity(scene.meshes.len());
    for mesh in &scene.meshes {
        let indices = Indices::U32(&mesh.indices);
        let mask = scene.mask(mesh);
        if let Some(mask) = &mask {
            textures[mask.image].get_or_insert_with(|| upload(gpu, &scene.images[mask.image]));
        }
        let mask = mask.and_then(|mask| {
            let texture = textures[mask.image].as_ref()?;
            let (cutoff, address_modes) = (mask.cutoff, mask.address_modes);
            Some(Mask { texture_coordinates: mask.tex_coords, texture, cutoff, address_modes })
        });
        meshes.push(casters.add_mesh(&CasterMesh {
            positions: &mesh.positions,
            indices,
            sides,
            mask,
            deforms: false,
        })?);
    }
    scene.instances.iter().map(|instance| casters.add_instance(meshes[instance.mesh], instance.transform)).collect()
}

fn upload(gpu: &Gpu, image: &image::RgbaImage) -> wgpu::Texture {
    let descriptor = wgpu::TextureDescriptor {
        label: Some("dual_paraboloid::compare::mask"),
        size: wgpu::Extent3d { width: image.width(), height: image.height(), depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, image.as_raw())
}
