//! Omnidirectional shadows for point lights from a dual paraboloid pair.
//!
//! A point light throws shadows in every direction. This crate makes two maps a light on `wgpu`, one for each hemisphere,
//! by a rasteriser in compute shaders that decides each texel by its own ray: edges don't bend. A texel knows its triangle,
//! and where texels disagree the lookup asks the triangles: shadow edges are those of the mesh. The join of the two maps can't
//! be seen, and there is no bias to tune.
//!
//! # Use
//!
//! ```no_run
//! use dual_paraboloid::{CasterMesh, Casters, Indices, PointLight, PointShadows, PointShadowsDescriptor, wgsl};
//! # use glam::{Affine3A, Vec3};
//! # struct Renderer { casters: Casters, shadows: PointShadows, door: dual_paraboloid::InstanceId }
//! # const LIGHTING: &str = "";
//! # fn start(device: &wgpu::Device, positions: &[[f32; 3]], indices: &[u32]) -> Result<(), dual_paraboloid::Error> {
//!
//! // Once: what casts, which lights, and the text and the layout for the lighting pass.
//! let mut casters = Casters::new(device)?;
//! let mesh = CasterMesh { positions, indices: Indices::U32(indices), ..Default::default() };
//! let mesh = casters.add_mesh(&mesh)?;
//! let door = casters.add_instance(mesh, Affine3A::IDENTITY)?;
//! let mut shadows = PointShadows::new(device, &PointShadowsDescriptor { capacity: 8, ..Default::default() })?;
//! let lamp = shadows.add(PointLight { position: Vec3::new(0.0, 3.0, 0.0), range: 25.0, ..Default::default() })?;
//! let text = [LIGHTING, &wgsl::lookup(1, 2)].concat();
//! let layouts_of_groups_1_and_2 = [shadows.bind_group_layout(), casters.bind_group_layout()];
//! # let _ = (lamp.index(), door, text, layouts_of_groups_1_and_2); Ok(())
//! # }
//! # fn frame(
//! #     renderer: &mut Renderer, device: &wgpu::Device, queue: &wgpu::Queue, transform: Affine3A,
//! #     encoder: &mut wgpu::CommandEncoder, descriptor: &wgpu::RenderPassDescriptor,
//! # ) -> Result<(), dual_paraboloid::Error> {
//! # let Renderer { casters, shadows, door } = renderer;
//! # let door = *door;
//!
//! // Every frame: say what has moved, record, and bind.
//! casters.set_transform(door, transform)?;
//! shadows.record(device, queue, encoder, casters)?;
//! let mut pass = encoder.begin_render_pass(descriptor);
//! pass.set_bind_group(1, shadows.bind_group(), &[]);
//! pass.set_bind_group(2, casters.bind_group(), &[]);
//! # Ok(())
//! # }
//! ```
//!
//! In the lighting shader, `dp_shadow(light, position, normal, view)` is the share of a light that arrives: `light` is
//! [`LightId::index`], the normal is the triangle's own, and `view` the camera's position and a pixel's angle. `dp_shadow_filtered` has softer edges, by the light's [`Filter`];
//! [`wgsl::lookup`] lists the others.
//!
//! The device, the queue and the encoder are the caller's, and nothing is submitted. [`PointShadows::record`] makes
//! maps only of the lights that changed or that something moved near.
//!
//! Foliage and grilles have a [`Mask`] that cuts holes. Meshes whose vertices the renderer moves on the GPU, by skinning
//! say, are added as ones that [deform](CasterMesh::deforms), and [`Casters::deform`] says where their positions are.
//!
//! # Conventions
//!
//! | | |
//! | --- | --- |
//! | World space | right-handed, +Y up; lengths in the caller's unit, angles in radians |
//! | Front faces | counter-clockwise as seen; a mirroring transform turns them round |
//! | Light space | world less the light's position, turned by the inverse of its orientation |
//! | Hemisphere space | light space for the front; for the back light space turned half a circle about Y. The axis is +Z in both |
//! | Map coordinates | `p = X.xy / w` with `w = length(X) + X.z`; the hemisphere is the unit disc |
//! | Maps | depths `R32Float` and triangles' numbers `R32Uint`, eight bytes a texel; a layer a light, the front in the left half and the back in the right; y of `p` is up, rows go down |
//! | Depth | `near / w`: 1 near the light, 0 at infinity, greater is nearer, no far plane |
//!
//! [`paraboloid`] has the mapping as functions, `ARCHITECTURE.md` how the crate is built and why.

mod arena;
mod assign;
mod batch;
mod casters;
mod chunks;
#[cfg(feature = "compare")]
pub mod compare;
mod cone;
mod cull;
mod custom;
mod deform;
mod error;
mod filter;
mod gpu;
mod light;
mod limits;
mod lookup;
mod maps;
mod mask;
mod mesh_records;
mod neighbours;
mod outward;
pub mod paraboloid;
mod ranges;
mod rasterise;
mod recordings;
mod resolve;
mod schedule;
mod shadows;
mod slots;
mod transform;
mod view;
pub mod wgsl;
mod workspace;

pub use casters::{CasterMesh, Casters, Indices, InstanceId, MeshId, Sides};
pub use custom::CasterPass;
pub use deform::Deformed;
pub use error::Error;
pub use filter::Filter;
#[cfg(feature = "compare")]
pub use gpu::Workgroups;
pub use light::{Coverage, PointLight};
#[cfg(feature = "compare")]
pub use limits::limits_one_too_low;
pub use limits::{required_features, required_limits};
pub use mask::Mask;
pub use shadows::{LightId, PointShadows, PointShadowsDescriptor, RecordOptions};
#[cfg(feature = "compare")]
pub use shadows::{Stage, Tuning};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn public_types_go_to_other_threads() {
        fn assert<T: Send + Sync>() {}
        assert::<CasterMesh>();
        assert::<CasterPass>();
        assert::<Casters>();
        assert::<Coverage>();
        assert::<Deformed>();
        assert::<Error>();
        assert::<Filter>();
        assert::<Indices>();
        assert::<InstanceId>();
        assert::<LightId>();
        assert::<Mask>();
        assert::<MeshId>();
        assert::<PointLight>();
        assert::<PointShadows>();
        assert::<PointShadowsDescriptor>();
        assert::<Sides>();
        // `RecordOptions` has a closure of the caller's, which may be anything.
    }
}
