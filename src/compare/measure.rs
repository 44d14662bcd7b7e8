//! Figures of one scene, light and method, for people and for machines.

mod bias;
mod judge;
mod subject;

pub use judge::{Answers, Judge, Judged, pair_of_equal_texels};
pub use subject::{LightChoice, PROCEDURAL, choose_light, find_scene, is_made_in_code, select_scenes};

use super::error_figures::{MapError, ShadowError, ShadowReport, map_error, shadow_error};
use super::error_figures::{Receiver, ideal_shadows, per_million, sample_receivers, truth};
use super::fill;
use super::gpu::Gpu;
use super::ideal::{BIAS, IdealMap, Lookup, MapGeometry, ideal_map};
use super::reference::{self, Reference, View};
use super::scene::Scene;
use crate::{Casters, Error, LightId, PointLight, PointShadows, PointShadowsDescriptor, Sides};
use glam::{DVec3, Vec3};

/// The truth of a scene and a light: what every method and resolution is judged by.
pub struct Truth {
    /// The light in double precision.
    pub view: View,
    /// The scene's triangles, for rays.
    pub reference: Reference,
    /// Where shadows are asked for.
    pub receivers: Vec<Receiver>,
    /// Whether the light reaches each receiver.
    pub lit: Vec<bool>,
}

impl Truth {
    /// Casts the rays: `samples` receivers drawn with `seed`. Both sides of all triangles cast.
    #[must_use]
    pub fn new(scene: &Scene, light: &PointLight, samples: usize, seed: u64) -> Self {
        Self::with_sides(scene, light, Sides::Auto, samples, seed)
    }

    /// [`Self::new`] with a rule for the sides of all meshes. Receivers are drawn over all triangles, casters or not.
    #[must_use]
    pub fn with_sides(scene: &Scene, light: &PointLight, sides: Sides, samples: usize, seed: u64) -> Self {
        let view = View {
            position: light.position.as_dvec3(),
            orientation: light.orientation.as_dquat(),
            near: f64::from(light.near),
            range: f64::from(light.range),
        };
        let reference = match sides {
            Sides::Auto | Sides::Both => both_faces(scene, view.position),
            Sides::Front => front_faces(scene, view.position),
        };
        let receivers = sample_receivers(&reference, &view, samples, seed);
        let lit = truth(&receivers, &reference, &view);
        Self { view, reference, receivers, lit }
    }

    /// Positions and normals of the receivers, as a shader takes them.
    #[must_use]
    pub fn inputs(&self) -> Vec<(Vec3, Vec3)> {
        self.receivers.iter().map(|receiver| (receiver.position, receiver.normal)).collect()
    }

    /// Error figures of answers from a map of this geometry.
    #[must_use]
    pub fn judge(&self, values: &[f32], geometry: &MapGeometry) -> ShadowError {
        shadow_error(&self.receivers, &self.lit, values, &self.reference, &self.view, geometry)
    }

    /// Wrong answers, in parts per million. An answer of 0.5 or more means lit.
    #[must_use]
    pub fn wrong_ppm(&self, values: &[f32]) -> f64 {
        let wrong = values.iter().zip(&self.lit).filter(|&(&value, &lit)| (value >= 0.5) != lit).count();
        per_million(wrong, self.lit.len())
    }

    /// The ray-cast map, and the error figures of the double precision lookup on it, with the bias
    /// of a pair of this tolerance.
    #[must_use]
    pub fn ideal(&self, geometry: MapGeometry, tolerance: f64) -> (IdealMap, ShadowError) {
        let map = ideal_map(&self.reference, &self.view, geometry);
        let lookup = Lookup { view: self.view, geometry, bias: BIAS, tolerance };
        let values = ideal_shadows(&self.receivers, &map, &lookup);
        let error = self.judge(&values, &geometry);
        (map, error)
    }
}

/// A scene's triangles, of which both sides cast.
fn both_faces(scene: &Scene, light: DVec3) -> Reference {
    let all = scene.world_triangles();
    Reference::new(&all.corners, None, light).with_cut_outs(scene.cut_outs(&all))
}

/// A scene's triangles, of which only the fronts cast.
fn front_faces(scene: &Scene, light: DVec3) -> Reference {
    let mut all = scene.world_triangles();
    let mut cut_outs = scene.cut_outs(&all);
    for (number, (corners, instance)) in all.corners.iter_mut().zip(&all.instance).enumerate() {
        // A transform that mirrors turns the winding around.
        if scene.instances[*instance as usize].transform.matrix3.determinant() < 0.0 {
            corners.swap(1, 2);
            if let Some(Some((_, coordinates))) = cut_outs.triangles.get_mut(number) {
                coordinates.swap(1, 2);
            }
        }
    }
    let sides = vec![reference::Sides::Front; all.corners.len()];
    Reference::new(&all.corners, Some(&sides), light).with_cut_outs(cut_outs)
}

/// A light's maps of a scene, made by the library.
pub struct Made {
    /// The casters; both sides cast.
    pub casters: Casters,
    /// The maps, recorded.
    pub shadows: PointShadows,
    /// The light.
    pub light: LightId,
}

impl Made {
    /// Fills the casters and records the light's maps.
    ///
    /// # Errors
    /// Whatever the library returns.
    pub fn new(
        gpu: &Gpu,
        scene: &Scene,
        light: PointLight,
        descriptor: &PointShadowsDescriptor,
    ) -> Result<Self, Error> {
        let mut casters = Casters::new(&gpu.device);
        fill(&mut casters, gpu, scene, Sides::Auto)?;
        let mut shadows = PointShadows::new(&gpu.device, descriptor)?;
        let light = shadows.add(light)?;
        gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, &mut casters))?;
        Ok(Self { casters, shadows, light })
    }

    /// Size of the maps.
    #[must_use]
    pub fn geometry(&self) -> MapGeometry {
        MapGeometry { resolution: self.shadows.maps().height(), guard: f64::from(self.shadows.half_width()) - 1.0 }
    }

    /// The maps' and the lookup's error, and the floor at this resolution.
    #[must_use]
    pub fn figures(&self, gpu: &Gpu, truth: &Truth) -> Figures {
        let geometry = self.geometry();
        let (ideal, ideal_error) = truth.ideal(geometry, f64::from(self.shadows.depth_tolerance()));
        let stored = gpu.read_map(&self.shadows, self.light);
        let values = gpu.shadow_values(&self.shadows, self.light, &truth.inputs());
        Figures {
            map: map_error(&stored, &ideal, &truth.reference, &truth.view),
            shadow: ShadowReport { error: truth.judge(&values, &geometry), ideal_wrong_ppm: ideal_error.wrong_ppm },
            ideal: ideal_error,
        }
    }
}

/// What a method's errors are.
#[derive(Debug, Clone, Copy)]
pub struct Figures {
    /// Of the map's texels.
    pub map: MapError,
    /// Of the lookup's answers.
    pub shadow: ShadowReport,
    /// Of the ray-cast map's answers: all its figures.
    pub ideal: ShadowError,
}

/// A light that suits a scene: its range reaches everything, and near is 1e-5 of that.
#[must_use]
pub fn light_for(scene: &Scene, position: Vec3) -> PointLight {
    let (low, high) = scene.bounds().unwrap_or((Vec3::ZERO, Vec3::ONE));
    let farthest = (low - position).abs().max((high - position).abs()).length();
    let range = 1.01 * farthest.max(1e-6);
    PointLight { position, range, near: range * 1e-5, ..Default::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::procedural::shapes::quad;
    use crate::compare::scene::SceneInstance;
    use glam::Affine3A;

    /// Share of a floor's and a sheet's receivers that a lamp above both lights, with fronts alone or both sides casting.
    fn lit(sheet_faces_the_lamp: bool, sides: Sides, mirror: f32) -> f64 {
        let (low, x, z) = (Vec3::new(-0.5, 1.0, -0.5), Vec3::X, Vec3::Z);
        let sheet = if sheet_faces_the_lamp { quad(low, z, x) } else { quad(low, x, z) };
        let floor = quad(Vec3::new(-2.0, 0.0, -2.0), 4.0 * z, 4.0 * x);
        let transforms = [Affine3A::IDENTITY, Affine3A::from_scale(Vec3::new(mirror, 1.0, 1.0))];
        let instance = |(mesh, transform)| SceneInstance { mesh, transform };
        let instances = transforms.into_iter().enumerate().map(instance).collect();
        let scene = Scene { meshes: vec![floor, sheet], instances, ..Scene::default() };
        let light = PointLight { position: 2.0 * Vec3::Y, range: 10.0, ..Default::default() };
        let truth = Truth::with_sides(&scene, &light, sides, 500, 1);
        assert_eq!(truth.wrong_ppm(&truth.lit.iter().map(|lit| f32::from(u8::from(!lit))).collect::<Vec<_>>()), 1e6);
        truth.lit.iter().filter(|lit| **lit).count() as f64 / truth.lit.len() as f64
    }

    #[test]
    fn backs_cast_only_where_both_sides_do() {
        for mirror in [1.0, -1.0] {
            assert!(lit(true, Sides::Auto, mirror) < 0.9 && lit(false, Sides::Auto, mirror) < 0.9);
            assert!(lit(true, Sides::Front, mirror) < 0.9);
            assert_eq!(lit(false, Sides::Front, mirror), 1.0);
        }
    }
}
