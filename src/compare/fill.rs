//! From a scene to casters.

use super::scene::Scene;
use crate::{CasterMesh, Casters, Error, Indices, InstanceId, Sides};

/// Adds every mesh and instance of a scene, all with the same rule for sides. Returns the instances' handles in the
/// scene's order.
///
/// # Errors
/// Whatever [`Casters::add_mesh`] and [`Casters::add_instance`] return.
pub fn fill(casters: &mut Casters, scene: &Scene, sides: Sides) -> Result<Vec<InstanceId>, Error> {
    let mut meshes = Vec::with_capacity(scene.meshes.len());
    for mesh in &scene.meshes {
        let indices = Indices::U32(&mesh.indices);
        meshes.push(casters.add_mesh(&CasterMesh { positions: &mesh.positions, indices, sides })?);
    }
    scene.instances.iter().map(|instance| casters.add_instance(meshes[instance.mesh], instance.transform)).collect()
}
