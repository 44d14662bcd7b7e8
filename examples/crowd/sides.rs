//! The two sides of the comparison: this library and the culled cube, each with all lights, and how to time them.

use crate::cloth::Cloth;
use crate::plaza::Plaza;
use anyhow::Context;
use dual_paraboloid::compare::baselines::{Budget, Cube, CubeDepth, Culling, Method, SceneBuffers};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::{
    Casters, InstanceId, LightId, PointShadows, PointShadowsDescriptor, RecordOptions, Sides, Stage,
};

/// What is timed in each frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Moving the casters, without any light.
    Casters,
    /// That and the culling.
    Cull,
    /// That and the binning.
    Bin,
    /// All of it.
    All,
    /// All of it, over maps of the static casters that are kept.
    Kept,
    /// All of it, with nothing changed.
    Still,
    /// A cube of as many texels for each light.
    Cube,
}

impl Way {
    pub const ALL: [Self; 7] = [Self::Casters, Self::Cull, Self::Bin, Self::All, Self::Kept, Self::Still, Self::Cube];
}

/// Casters and maps of both sides.
pub struct BothSides {
    casters: Casters,
    instances: Vec<InstanceId>,
    cloth: Cloth,
    /// Without and with maps of the static casters.
    shadows: [PointShadows; 2],
    buffers: SceneBuffers,
    cubes: Vec<Cube>,
}

/// This library's casters and lights, for a plaza.
pub fn set_up(
    gpu: &Gpu,
    plaza: &Plaza,
    casters: &mut Casters,
    resolution: u32,
    keep_static: bool,
) -> anyhow::Result<(PointShadows, Vec<LightId>)> {
    let capacity = plaza.lights.len() as u32;
    let descriptor = PointShadowsDescriptor { capacity, resolution, keep_static, ..Default::default() };
    let mut shadows = PointShadows::new(&gpu.device, &descriptor)?;
    let ids = plaza.lights.iter().map(|light| shadows.add(*light)).collect::<Result<_, _>>()?;
    // Twice, so that there is room for all pieces.
    for _ in 0..2 {
        gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, casters))?;
        gpu.wait();
    }
    Ok((shadows, ids))
}

impl BothSides {
    pub fn new(gpu: &Gpu, plaza: &Plaza, resolution: u32) -> anyhow::Result<Self> {
        let mut casters = Casters::new(&gpu.device)?;
        let instances = dual_paraboloid::compare::fill(&mut casters, gpu, &plaza.scene, Sides::Auto)?;
        // The one that deforms is in the place of the stiff one.
        casters.remove_instance(instances[plaza.cloth])?;
        let cloth = Cloth::new(gpu, &mut casters, plaza.cloth_mesh(), &plaza.scene.instances[plaza.cloth])?;
        for moving in plaza.walking().map(|walking| instances[walking]).chain([cloth.caster]) {
            casters.set_moving(moving, true)?;
        }
        let shadows = [
            set_up(gpu, plaza, &mut casters, resolution, false)?.0,
            set_up(gpu, plaza, &mut casters, resolution, true)?.0,
        ];
        let buffers = SceneBuffers::new(&gpu.device, &plaza.scene, false)?;
        let side = Method::Cube.side(resolution, Budget::EqualTexels);
        let cubes =
            plaza.lights.iter().map(|_| Cube::new(&gpu.device, side, Culling::Frustum, CubeDepth::Float32)).collect();
        Ok(Self { casters, instances, cloth, shadows, buffers, cubes })
    }

    pub fn triangles(&self) -> u64 {
        self.casters.triangle_count()
    }

    /// Bytes on the GPU: casters, maps without and with those of the static casters.
    pub fn memory(&self) -> [u64; 3] {
        [self.casters.memory(), self.shadows[0].memory(), self.shadows[1].memory()]
    }

    /// Moves what walks or waves to where the plaza has it, for one way. Where nothing is to be stale, sees to it that
    /// nothing is.
    pub fn move_for(&mut self, gpu: &Gpu, plaza: &Plaza, way: Way) -> anyhow::Result<()> {
        match way {
            Way::Still => gpu.submit(|encoder| self.record(gpu, plaza, encoder, Way::All))?,
            Way::Cube => {
                let transforms: Vec<_> = plaza.scene.instances.iter().map(|instance| instance.transform).collect();
                self.buffers.set_transforms(&gpu.queue, &transforms);
            }
            _ => {
                for walking in plaza.walking() {
                    self.casters.set_transform(self.instances[walking], plaza.scene.instances[walking].transform)?;
                }
                self.cloth.deform(gpu, &mut self.casters, plaza.cloth_mesh())?;
            }
        }
        Ok(())
    }

    /// Records one way.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        plaza: &Plaza,
        encoder: &mut wgpu::CommandEncoder,
        way: Way,
    ) -> anyhow::Result<()> {
        let Gpu { device, queue, .. } = gpu;
        if way == Way::Cube {
            for (cube, light) in self.cubes.iter_mut().zip(&plaza.lights) {
                cube.record(device, queue, encoder, &self.buffers, light);
            }
            return Ok(());
        }
        let shadows = &mut self.shadows[usize::from(way == Way::Kept)];
        shadows.stop_after(
            device,
            queue,
            match way {
                Way::Cull => Stage::Cull,
                Way::Bin => Stage::Bin,
                _ => Stage::Rasterise,
            },
        );
        let most = (way == Way::Casters).then_some(0);
        let options = RecordOptions { most, ..Default::default() };
        shadows.record_with(device, queue, encoder, &mut self.casters, options).context("recording the maps")?;
        Ok(())
    }
}
