//! Masks: the textures that cut holes into casters, as bytes of alpha on the GPU (`shaders/mask.wgsl`).
//!
//! All masks lie in one buffer, the mesh records, so that one pipeline handles any number of them.

use crate::Error;
use crate::chunks::Vertex;
use crate::gpu::{self, Binding};
use crate::mesh_records::{MeshRecords, RECORD_WORDS};
use std::collections::HashMap;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Where a mesh has holes, as foliage and grilles do: glTF's `alphaMode` MASK. A point of a triangle casts where the
/// texture's alpha, filtered bilinearly at its finest level, isn't below the cutoff. Back faces are seen through the
/// holes, so with [`Sides::Auto`](crate::Sides::Auto) both sides of every triangle cast.
#[derive(Debug, Clone, Copy)]
pub struct Mask<'a> {
    /// One for each position; finite. (0, 0) is the outer corner of the texture's first texel, (1, 1) that of its last.
    pub texture_coordinates: &'a [[f32; 2]],
    /// Two-dimensional, of one layer and one sample, with the usage `TEXTURE_BINDING` and a format of four channels
    /// that a shader reads as floats, block-compressed ones among them. Its alpha is copied, to 8 bits, by the first
    /// [`PointShadows::record`](crate::PointShadows::record) after, until whose work is done it mustn't be destroyed. Meshes with the
    /// same texture share the copy, and while there are any, the texture is kept.
    pub texture: &'a wgpu::Texture,
    /// Smallest alpha that casts, in [0, 1].
    pub cutoff: f32,
    /// How the texture goes on past its edges, across and down. `ClampToBorder` isn't supported.
    pub address_modes: [wgpu::AddressMode; 2],
}

impl Mask<'_> {
    /// What is wrong with a mask for a mesh of so many positions.
    pub(crate) fn validate(&self, positions: usize) -> Result<(), Error> {
        let coordinates = self.texture_coordinates;
        if coordinates.len() != positions {
            return Err(Error::TextureCoordinateCount { coordinates: coordinates.len(), positions });
        }
        if let Some(vertex) = coordinates.iter().position(|pair| !pair.iter().all(|x| x.is_finite())) {
            return Err(Error::TextureCoordinateNotFinite { vertex, value: coordinates[vertex] });
        }
        let check = |ok: bool, what, value: String, remedy| {
            if ok { Ok(()) } else { Err(Error::InvalidMask { what, value, remedy }) }
        };
        let cutoff = (0.0..=1.0).contains(&self.cutoff);
        check(cutoff, "cutoff", self.cutoff.to_string(), "it must be an alpha from 0 to 1")?;
        for mode in self.address_modes {
            let known = mode != wgpu::AddressMode::ClampToBorder;
            check(known, "address mode", format!("{mode:?}"), "give ClampToEdge, Repeat or MirrorRepeat")?;
        }
        let texture = self.texture;
        let flat = texture.dimension() == wgpu::TextureDimension::D2 && texture.depth_or_array_layers() == 1;
        let shape = format!("{:?} with {} layers", texture.dimension(), texture.depth_or_array_layers());
        check(flat, "texture", shape, "give a two-dimensional one of one layer")?;
        let samples = texture.sample_count();
        check(samples == 1, "texture", format!("of {samples} samples a texel"), "give one of one sample")?;
        let format = texture.format();
        let float = matches!(format.sample_type(None, None), Some(wgpu::TextureSampleType::Float { .. }));
        let remedy = "give one with an alpha channel that is read as floats, such as Rgba8Unorm";
        check(float && format.components() == 4, "texture's format", format!("{format:?}"), remedy)?;
        let bindable = texture.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING);
        check(bindable, "texture's usage", format!("{:?}", texture.usage()), "create it with TEXTURE_BINDING too")
    }

    /// The cutoff in 255ths. One that is the value of a byte comes out as that byte, whichever way it was rounded.
    pub(crate) fn byte_cutoff(cutoff: f32) -> f32 {
        let scaled = 255.0 * cutoff;
        if (scaled - scaled.round()).abs() < 1e-4 { scaled.round() } else { scaled }
    }
}

/// What a vertex of a masked mesh has beside its position, a mesh record; twin of `DpMaskVertex`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct MaskVertex {
    coordinates: [f32; 2],
    /// Record of its mask.
    mask: u32,
    /// Of deforming meshes the vertex's place among the positions that the caller writes.
    source: u32,
}

/// A mask on the GPU, a mesh record; twin of `DpMask`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct MaskRecord {
    /// First word of its alphas, in the buffer of the records.
    first: u32,
    /// Width in bits 0-15, height in bits 16-31.
    size: u32,
    /// In 255ths.
    cutoff: f32,
    /// Across in bits 0-1, down in bits 2-3.
    address_modes: u32,
}

/// What the masks keep of a mesh.
#[derive(Debug)]
pub(crate) struct MaskedMesh {
    record: u32,
    vertices: std::ops::Range<u32>,
    texture: wgpu::Texture,
}

/// A texture's alphas.
#[derive(Debug)]
struct AlphaCopy {
    /// First record.
    first: u32,
    meshes: usize,
}

/// The masks of all meshes.
#[derive(Debug, Default)]
pub(crate) struct Masks {
    copies: HashMap<wgpu::Texture, AlphaCopy>,
    /// Textures that aren't copied yet.
    waiting: Vec<wgpu::Texture>,
    pipeline: Option<wgpu::ComputePipeline>,
}

impl Masks {
    /// Records that a mesh of so many vertices takes for this mask.
    pub(crate) fn records(&self, mask: &Mask, vertices: u32) -> u64 {
        let shared = self.copies.contains_key(mask.texture);
        u64::from(vertices) + 1 + if shared { 0 } else { u64::from(alpha_records(mask.texture)) }
    }

    /// Adds a mask with the coordinates of a mesh's vertices, and has each vertex say where its own are.
    pub(crate) fn add(
        &mut self,
        records: &mut MeshRecords,
        mask: &Mask,
        coordinates: &[[f32; 2]],
        vertices: &mut [Vertex],
    ) -> MaskedMesh {
        let texture = mask.texture;
        let copy = self.copies.entry(texture.clone()).or_insert_with(|| {
            self.waiting.push(texture.clone());
            AlphaCopy { first: records.allocate(alpha_records(texture)), meshes: 0 }
        });
        copy.meshes += 1;
        let mode = |mode| match mode {
            wgpu::AddressMode::Repeat => 1,
            wgpu::AddressMode::MirrorRepeat => 2,
            wgpu::AddressMode::ClampToEdge | wgpu::AddressMode::ClampToBorder => 0,
        };
        let record = records.add(&[MaskRecord {
            first: copy.first * RECORD_WORDS,
            size: texture.width() | texture.height() << 16,
            cutoff: Mask::byte_cutoff(mask.cutoff),
            address_modes: mode(mask.address_modes[0]) | mode(mask.address_modes[1]) << 2,
        }]);
        let count = vertices.len() as u32;
        let first = records.allocate(count);
        let numbered = vertices.iter_mut().zip(coordinates).zip(first..);
        let masked: Vec<MaskVertex> = numbered
            .map(|((vertex, &coordinates), place)| {
                let source = std::mem::replace(&mut vertex.data, place);
                MaskVertex { coordinates, mask: record, source }
            })
            .collect();
        records.write(first, &masked);
        MaskedMesh { record, vertices: first..first + count, texture: texture.clone() }
    }

    pub(crate) fn remove(&mut self, records: &mut MeshRecords, mesh: &MaskedMesh) {
        records.release(mesh.record, 1);
        records.release(mesh.vertices.start, mesh.vertices.len() as u32);
        let Some(copy) = self.copies.get_mut(&mesh.texture) else { return };
        copy.meshes -= 1;
        if copy.meshes == 0 {
            records.release(copy.first, alpha_records(&mesh.texture));
            self.copies.remove(&mesh.texture);
        }
    }

    /// Copies the alphas of textures that came, and returns those.
    pub(crate) fn update(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        records: &MeshRecords,
    ) -> Vec<wgpu::Texture> {
        let textures = std::mem::take(&mut self.waiting);
        for texture in &textures {
            let Some(copy) = self.copies.get(texture) else { continue };
            let pipeline = self.pipeline.get_or_insert_with(|| copy_pipeline(device));
            record_copy(device, encoder, pipeline, texture, records.arena().buffer(), copy.first * RECORD_WORDS);
        }
        textures
    }

    /// Has textures copied again by the next update, since they never were.
    pub(crate) fn redo(&mut self, textures: Vec<wgpu::Texture>) {
        self.waiting.extend(textures);
    }
}

/// Layout of what `shaders/mask.wgsl` reads in the stages.
pub(crate) fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    gpu::layout(device, "masks", wgpu::ShaderStages::COMPUTE, &[Binding::Read])
}

/// Records that a texture's alphas take; rows begin with a word of their own.
fn alpha_records(texture: &wgpu::Texture) -> u32 {
    (texture.width().div_ceil(4) * texture.height()).div_ceil(RECORD_WORDS)
}

fn copy_pipeline(device: &wgpu::Device) -> wgpu::ComputePipeline {
    gpu::compute_pipeline(device, "mask_copy", &gpu::shader(device, "mask_copy", crate::wgsl::mask_copy()), &[], &[])
}

fn record_copy(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    texture: &wgpu::Texture,
    alphas: &wgpu::Buffer,
    first: u32,
) {
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        label: Some("dual_paraboloid::mask_copy"),
        mip_level_count: Some(1),
        ..Default::default()
    });
    let first = device.create_buffer_init(&BufferInitDescriptor {
        label: Some("dual_paraboloid::mask_copy::first"),
        contents: bytemuck::bytes_of(&first),
        usage: wgpu::BufferUsages::STORAGE,
    });
    let resources = [wgpu::BindingResource::TextureView(&view), alphas.as_entire_binding(), first.as_entire_binding()];
    let group = gpu::bind_group(device, "mask_copy", &pipeline.get_bind_group_layout(0), &resources);
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some("dual_paraboloid::mask_copy"),
        timestamp_writes: None,
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(texture.width().div_ceil(4).div_ceil(8), texture.height().div_ceil(8), 1);
}

#[cfg(test)]
mod tests {
    use super::Mask;

    #[test]
    fn a_cutoff_that_a_byte_holds_is_that_byte() {
        for byte in 0..=255_u8 {
            let cutoff = f32::from(byte) / 255.0;
            for rounded in [cutoff, cutoff.next_down().max(0.0), cutoff.next_up().min(1.0)] {
                assert_eq!(Mask::byte_cutoff(rounded), f32::from(byte));
            }
        }
        assert_eq!(Mask::byte_cutoff(0.5), 127.5);
    }
}
