//! Maps by this library's own stages, made anew at every recording.

use super::Bound;
use crate::casters::Casters;
use crate::compare::gpu::Gpu;
use crate::light::PointLight;
use crate::view::MapShape;
use crate::{Error, LightId, PointShadows, PointShadowsDescriptor, Stage, Tuning};

/// A light's maps from [`PointShadows`], without the benefit of not being stale.
#[derive(Debug)]
pub(super) struct OwnMaps {
    shadows: PointShadows,
    light: LightId,
    /// The casters that the map shows.
    casters: Option<wgpu::BindGroup>,
    casters_layout: wgpu::BindGroupLayout,
}

impl OwnMaps {
    /// The library's pair.
    pub(super) fn pair(device: &wgpu::Device, resolution: u32) -> Result<Self, Error> {
        Self::new(device, PointShadows::new(device, &descriptor(resolution))?)
    }

    /// Maps of another shape.
    pub(super) fn shaped(device: &wgpu::Device, shape: MapShape, tuning: &Tuning) -> Result<Self, Error> {
        Self::new(device, PointShadows::with_shape(device, &descriptor(shape.resolution), tuning, shape)?)
    }

    fn new(device: &wgpu::Device, mut shadows: PointShadows) -> Result<Self, Error> {
        let light = shadows.add(PointLight::default())?;
        Ok(Self { shadows, light, casters: None, casters_layout: crate::lookup::surface_layout(device) })
    }

    pub(super) fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &mut Casters,
        light: &PointLight,
    ) -> Result<(), Error> {
        light.validate()?;
        // Another light in between makes the map stale even where nothing has changed.
        let other = PointLight { near: 0.5 * light.near, ..*light };
        self.shadows.set(self.light, other)?;
        self.shadows.set(self.light, *light)?;
        let made = self.shadows.record(device, queue, encoder, casters)?;
        debug_assert_eq!(made, 1, "the map was taken for fresh");
        self.casters = Some(casters.bind_group().clone());
        Ok(())
    }

    /// The maps and the casters, as the library's lookup reads them.
    pub(super) fn bind_groups(&self) -> [Bound<'_>; 2] {
        let maps = (Some(self.shadows.bind_group()), self.shadows.bind_group_layout());
        [maps, (self.casters.as_ref(), &self.casters_layout)]
    }

    pub(super) fn stop_after(&mut self, gpu: &Gpu, stage: Stage) {
        self.shadows.stop_after(&gpu.device, &gpu.queue, stage);
    }

    pub(super) fn shadows(&self) -> &PointShadows {
        &self.shadows
    }
}

fn descriptor(resolution: u32) -> PointShadowsDescriptor {
    PointShadowsDescriptor { capacity: 1, resolution, ..Default::default() }
}
