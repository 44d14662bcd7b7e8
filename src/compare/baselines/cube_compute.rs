//! A cube map from this library's rasteriser: what would six faces gain over the pair?

use super::Bound;
use super::cube_lookup::CubeLookup;
use super::cube_map::{DepthMapping, FACES, half_width};
use super::own_maps::OwnMaps;
use crate::casters::Casters;
use crate::light::{Coverage, PointLight};
use crate::view::{MapShape, Projection};
use crate::{Error, PointShadows, Tuning};

const PROJECTION: Projection = Projection {
    squares: FACES.len() as u32,
    squares_in_layer: 1,
    text: concat!(
        include_str!("../../../shaders/compare/cube_face.wgsl"),
        include_str!("../../../shaders/compare/cube_projection.wgsl"),
    ),
};

/// A cube's faces as this library's stages make them.
pub(in crate::compare) fn shape(resolution: u32) -> MapShape {
    MapShape { projection: PROJECTION, resolution, half_width: half_width(resolution) }
}

/// The text of [`Lookup::CubeWalk`](super::Lookup::CubeWalk), for the groups of [`CubeCompute::walk_groups`] from `group` on and
/// for lights with an orientation or only without.
pub(super) fn walk_text(group: u32, turned: bool) -> String {
    let faces = [
        include_str!("../../../shaders/compare/cube_face.wgsl"),
        include_str!("../../../shaders/compare/cube_walk.wgsl"),
    ];
    let faces = faces.concat().replace("DP_GROUP", &group.to_string()).replace("CUBE_TURNED", &turned.to_string());
    [crate::wgsl::lookup_without_maps(group, group + 1), faces].concat()
}

/// The complete modules.
pub(super) fn modules() -> impl Iterator<Item = (String, String)> {
    crate::wgsl::maps(PROJECTION).into_iter().map(|(name, text)| (format!("cube_compute_{name}"), text))
}

/// The library's cull, bin and rasterise stages on the six faces of a cube along the light's axes. A texel holds depth and the
/// triangle's number, eight bytes, as the pair's do. Always all directions, whatever the light's coverage.
///
/// The faces are layers of floats, which the hardware can't compare with a reference: [`Lookup::CubeWalk`] and
/// [`Lookup::CubePlane`] read them. Copying them into a depth texture for its sake would cost a rival a pass.
///
/// [`Lookup::CubeWalk`]: super::Lookup::CubeWalk
/// [`Lookup::CubePlane`]: super::Lookup::CubePlane
#[derive(Debug)]
pub struct CubeCompute {
    maps: OwnMaps,
    lookup: CubeLookup,
}

impl CubeCompute {
    /// Creates a cube map of `resolution` texels across a face, at most 4096.
    ///
    /// # Errors
    /// As [`PointShadows::new`].
    pub fn new(device: &wgpu::Device, resolution: u32) -> Result<Self, Error> {
        Self::tuned(device, resolution, &Tuning::of(device))
    }

    /// [`Self::new`] with the stages set to work otherwise.
    ///
    /// # Errors
    /// As [`PointShadows::new`].
    pub fn tuned(device: &wgpu::Device, resolution: u32, tuning: &Tuning) -> Result<Self, Error> {
        let maps = OwnMaps::shaped(device, shape(resolution), tuning)?;
        Ok(Self { lookup: CubeLookup::new(device, maps.shadows().maps()), maps })
    }

    /// Records the whole map anew, after what brings the casters up to date.
    ///
    /// # Errors
    /// [`Error::InvalidLight`] or [`Error::DeviceLost`].
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &mut Casters,
        light: &PointLight,
    ) -> Result<(), Error> {
        let light = PointLight { coverage: Coverage::Full, ..*light };
        self.maps.record(device, queue, encoder, casters, &light)?;
        self.lookup.set_light(queue, &light, DepthMapping::infinite(light.near));
        Ok(())
    }

    /// The faces' depths as layers, `R32Float`.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        self.shadows().maps()
    }

    /// The faces' triangles, laid out as [`Self::map`]; see [`PointShadows::numbers`].
    #[must_use]
    pub fn numbers(&self) -> &wgpu::Texture {
        self.shadows().numbers()
    }

    fn shadows(&self) -> &PointShadows {
        self.maps.shadows()
    }

    pub(super) fn maps_mut(&mut self) -> &mut OwnMaps {
        &mut self.maps
    }

    /// The maps and the casters, as [`Lookup::CubeWalk`](super::Lookup::CubeWalk) reads them.
    pub(super) fn walk_groups(&self) -> [Bound<'_>; 2] {
        self.maps.bind_groups()
    }

    pub(super) fn lookup(&self) -> &CubeLookup {
        &self.lookup
    }

    pub(super) fn lookup_mut(&mut self) -> &mut CubeLookup {
        &mut self.lookup
    }

    /// Bytes on the GPU, the map among them.
    pub(super) fn memory(&self) -> u64 {
        self.shadows().memory() + self.lookup.memory()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_twin_has_as_many_squares() {
        for projection in [PROJECTION, Projection::PARABOLOIDS] {
            assert!(projection.text.contains(&format!("const SQUARES: u32 = {}u;", projection.squares)));
        }
    }
}
