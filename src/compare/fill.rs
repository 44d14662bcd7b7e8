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
    let textures = upload_masks(gpu, scene)?;
    let mut meshes = Vec::with_capacity(scene.meshes.len());
    for mesh in &scene.meshes {
        let indices = Indices::U32(&mesh.indices);
        let mask = scene.mask(mesh).and_then(|mask| {
            let (texture, cutoff, address_modes) = (textures[mask.image].as_ref()?, mask.cutoff, mask.address_modes);
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

/// Textures of the images that some mask reads.
fn upload_masks(gpu: &Gpu, scene: &Scene) -> Result<Vec<Option<wgpu::Texture>>, Error> {
    let mut textures = vec![None; scene.images.len()];
    for mask in scene.meshes.iter().filter_map(|mesh| scene.mask(mesh)) {
        if textures[mask.image].is_none() {
            textures[mask.image] = Some(upload(gpu, &scene.images[mask.image])?);
        }
    }
    Ok(textures)
}

fn upload(gpu: &Gpu, image: &image::RgbaImage) -> Result<wgpu::Texture, Error> {
    let (width, height) = image.dimensions();
    if width.max(height) > gpu.device.limits().max_texture_dimension_2d {
        let value = format!("{width} x {height} texels large");
        return Err(Error::InvalidMask { what: "image", value, remedy: "scale it down to what the device takes" });
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some("dual_paraboloid::compare::mask"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    Ok(gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, image.as_raw()))
}
