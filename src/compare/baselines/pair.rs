//! This library's own maps, made anew at every recording.

use crate::casters::Casters;
use crate::compare::gpu::Gpu;
use crate::light::PointLight;
use crate::{Error, LightId, PointShadows, PointShadowsDescriptor, Stage};

/// A light's pair of maps from [`PointShadows`], without the benefit of not being stale.
#[derive(Debug)]
pub(super) struct Pair {
    shadows: PointShadows,
    light: LightId,
}

impl Pair {
    pub(super) fn new(device: &wgpu::Device, resolution: u32) -> Result<Self, Error> {
        let descriptor = PointShadowsDescriptor { capacity: 1, resolution, ..Default::default() };
        let mut shadows = PointShadows::new(device, &descriptor)?;
        let light = shadows.add(PointLight::default())?;
        Ok(Self { shadows, light })
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
        Ok(())
    }

    pub(super) fn stop_after(&mut self, gpu: &Gpu, stage: Stage) {
        self.shadows.stop_after(&gpu.device, &gpu.queue, stage);
    }

    pub(super) fn shadows(&self) -> &PointShadows {
        &self.shadows
    }
}
