//! The scene as the camera's pass draws it: vertices, instances, materials.

use anyhow::ensure;
use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::scene::{Alpha, Material, Scene, SceneMesh};
use glam::{Affine3A, Vec3};
use std::collections::BTreeMap;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Twin of `Vertex` in `shading.wgsl`. Triangles don't share vertices: each has the triangle's own normal.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    geometric_normal: [f32; 3],
    tex_coords: [f32; 2],
}

/// Rows of a matrix; twin of `Instance` in `shading.wgsl`.
type Instance = [[f32; 4]; 3];

/// Twin of `Material` in `shading.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct MaterialRecord {
    base_color: [f32; 4],
    emissive: [f32; 3],
    cutoff: f32,
}

/// Vertex buffers of the camera's pass.
pub const VERTEX_LAYOUTS: [Option<wgpu::VertexBufferLayout>; 2] = [
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x2],
    }),
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Instance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![4 => Float32x4, 5 => Float32x4, 6 => Float32x4],
    }),
];

/// Which faces a batch leaves out.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Culling {
    /// None: both sides are surfaces.
    None,
    /// Those that are clockwise as seen.
    Clockwise,
    /// Those that are counter-clockwise: the instance is mirrored.
    CounterClockwise,
}

/// The instances of a mesh that are drawn in one call.
pub struct Batch {
    pub culling: Culling,
    mesh: usize,
    material: usize,
    instances: std::ops::Range<u32>,
}

/// A scene on the GPU.
pub struct Model {
    pub material_layout: wgpu::BindGroupLayout,
    pub batches: Vec<Batch>,
    /// Vertices of the meshes and their number, by the scene's index.
    meshes: BTreeMap<usize, (wgpu::Buffer, u32)>,
    instances: wgpu::Buffer,
    materials: Vec<wgpu::BindGroup>,
}

impl Model {
    /// Uploads what some instance uses.
    pub fn new(gpu: &Gpu, scene: &Scene) -> anyhow::Result<Self> {
        let mut grouped: BTreeMap<(usize, Culling), Vec<Instance>> = BTreeMap::new();
        for instance in &scene.instances {
            let material = &scene.materials[scene.meshes[instance.mesh].material];
            let culling = match (material.double_sided, instance.transform.matrix3.determinant() < 0.0) {
                (true, _) => Culling::None,
                (false, false) => Culling::Clockwise,
                (false, true) => Culling::CounterClockwise,
            };
            let group = grouped.entry((instance.mesh, culling)).or_default();
            group.push(rows(&instance.transform));
        }
        let mut batches = Vec::with_capacity(grouped.len());
        let mut meshes = BTreeMap::new();
        let mut instances: Vec<Instance> = Vec::with_capacity(scene.instances.len());
        for ((mesh, culling), group) in grouped {
            if let std::collections::btree_map::Entry::Vacant(place) = meshes.entry(mesh) {
                place.insert(upload_mesh(gpu, &scene.meshes[mesh])?);
            }
            let first = instances.len() as u32;
            instances.extend(group);
            batches.push(Batch {
                culling,
                mesh,
                material: scene.meshes[mesh].material,
                instances: first..instances.len() as u32,
            });
        }
        let instances = upload(gpu, "instances", cast_slice(&instances), wgpu::BufferUsages::VERTEX)?;
        let material_layout = material_layout(&gpu.device);
        let materials = upload_materials(gpu, scene, &material_layout)?;
        Ok(Self { material_layout, batches, meshes, instances, materials })
    }

    /// Draws a batch; its material is bound to group 2.
    pub fn draw(&self, pass: &mut wgpu::RenderPass, batch: &Batch) {
        let (vertices, count) = &self.meshes[&batch.mesh];
        pass.set_bind_group(2, &self.materials[batch.material], &[]);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_vertex_buffer(1, self.instances.slice(..));
        pass.draw(0..*count, batch.instances.clone());
    }
}

fn rows(transform: &Affine3A) -> Instance {
    let (m, t) = (transform.matrix3, transform.translation);
    [0, 1, 2].map(|row| [m.x_axis[row], m.y_axis[row], m.z_axis[row], t[row]])
}

/// A buffer, if the device can hold it.
fn upload(gpu: &Gpu, what: &str, contents: &[u8], usage: wgpu::BufferUsages) -> anyhow::Result<wgpu::Buffer> {
    let (size, most) = (contents.len() as u64, gpu.device.limits().max_buffer_size);
    ensure!(
        size <= most,
        "the scene's {what} take {size} bytes, but a buffer of this device holds {most}: split the scene's meshes"
    );
    let descriptor = BufferInitDescriptor { label: Some(&format!("render::{what}")), contents, usage };
    Ok(gpu.device.create_buffer_init(&descriptor))
}

fn upload_mesh(gpu: &Gpu, mesh: &SceneMesh) -> anyhow::Result<(wgpu::Buffer, u32)> {
    let mut vertices = Vec::with_capacity(mesh.indices.len());
    for corners in mesh.indices.chunks_exact(3) {
        let corners = [0, 1, 2].map(|k| corners[k] as usize);
        let [a, b, c] = corners.map(|vertex| Vec3::from(mesh.positions[vertex]).as_dvec3());
        let geometric_normal = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
        for vertex in corners {
            let smooth = mesh.normals.as_ref().map(|normals| Vec3::from(normals[vertex]));
            // Files have zero and even infinite normals.
            let usable = smooth.filter(|normal| normal.is_finite() && *normal != Vec3::ZERO);
            vertices.push(Vertex {
                position: mesh.positions[vertex],
                normal: usable.map_or(geometric_normal, |normal| normal.to_array()),
                geometric_normal,
                tex_coords: mesh.tex_coords.as_ref().map_or([0.0; 2], |all| all[vertex]),
            });
        }
    }
    let buffer = upload(gpu, "vertices", cast_slice(&vertices), wgpu::BufferUsages::VERTEX)?;
    Ok((buffer, vertices.len() as u32))
}

fn material_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::FRAGMENT, ty, count: None };
    let record = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let image = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("render::material"),
        entries: &[entry(0, record), entry(1, image), entry(2, sampler)],
    })
}

fn upload_materials(gpu: &Gpu, scene: &Scene, layout: &wgpu::BindGroupLayout) -> anyhow::Result<Vec<wgpu::BindGroup>> {
    let white = upload_image(gpu, image::RgbaImage::from_pixel(1, 1, image::Rgba([255; 4])))?;
    let images = scene.images.iter().map(|image| upload_image(gpu, image.clone()));
    let images = images.collect::<anyhow::Result<Vec<_>>>()?;
    let material = |material: &Material| {
        let record = material_record(material);
        let record = upload(gpu, "material", bytes_of(&record), wgpu::BufferUsages::UNIFORM)?;
        let image = material.base_color_image.map_or(&white, |image| &images[image]);
        let resources = [
            record.as_entire_binding(),
            wgpu::BindingResource::TextureView(image),
            wgpu::BindingResource::Sampler(&sampler(gpu, material.address_modes)),
        ];
        Ok(crate::camera::bind_group(&gpu.device, "material", layout, &resources))
    };
    scene.materials.iter().map(material).collect()
}

fn sampler(gpu: &Gpu, [address_mode_u, address_mode_v]: [wgpu::AddressMode; 2]) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("render::base color"),
        address_mode_u,
        address_mode_v,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}

fn material_record(material: &Material) -> MaterialRecord {
    MaterialRecord {
        base_color: material.base_color,
        emissive: material.emissive,
        cutoff: match material.alpha {
            Alpha::Mask { cutoff } => cutoff,
            Alpha::Opaque | Alpha::Blend => 0.0,
        },
    }
}

/// Uploads an image with all its smaller versions, so that distant surfaces don't flicker.
fn upload_image(gpu: &Gpu, image: image::RgbaImage) -> anyhow::Result<wgpu::TextureView> {
    let (width, height) = image.dimensions();
    let most = gpu.device.limits().max_texture_dimension_2d;
    ensure!(
        width.max(height) <= most,
        "an image of the scene has {width} x {height} texels, but this device takes {most}: scale it down"
    );
    let levels = width.max(height).ilog2() + 1;
    let mut level = image;
    let mut data = Vec::new();
    for number in 0..levels {
        if number > 0 {
            let (width, height) = ((width >> number).max(1), (height >> number).max(1));
            level = image::imageops::resize(&level, width, height, image::imageops::FilterType::Triangle);
        }
        data.extend_from_slice(level.as_raw());
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some("render::base color"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, &data);
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}
