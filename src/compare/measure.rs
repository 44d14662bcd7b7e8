//! Figures of one scene, light and method, for people and for machines.

mod bias;
mod judge;
mod pixels;
mod subject;

pub use judge::{Answers, Judge, Judged};
pub use pixels::{PixelError, PixelErrors, Pixels};
pub use subject::{LightChoice, PROCEDURAL, SCENES_IN_CODE};
pub use subject::{choose_camera, choose_light, find_scene, is_made_in_code, select_scenes};

use super::error_figures::truth;
use super::error_figures::{CreaseError, MapError, Receiver, ShadowError, ShadowReport};
use super::error_figures::{
    crease_error, energy_ppm, lit_creases, map_error, near_boundary, per_million, sample_receivers, shadow_error,
};
use super::fill;
use super::gpu::Gpu;
use super::ideal::{BIAS, IdealMap, Lookup, MapGeometry, NORMAL_BIAS, ideal_map};
use super::reference::{self, Reference, View};
use super::scene::Scene;
use super::votes_v1::VotesV1;
use crate::{Casters, Error, LightId, PointLight, PointShadows, PointShadowsDescriptor, Sides};
use glam::{DVec3, Quat, Vec3};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// The truth of a scene and a light: what every method and resolution is judged by.
pub struct Truth {
    /// The light in double precision.
    pub view: View,
    /// The scene's triangles, for rays.
    pub reference: Arc<Reference>,
    /// Where shadows are asked for: on surfaces that a renderer lights, but for the insides of closed pieces that the
    /// light is outside of, which no one sees; grazing ones among them ([`sample_receivers`] has the definition).
    /// The figures are of those that count ([`Receiver::counts`]), unless they say otherwise.
    pub receivers: Vec<Receiver>,
    /// Whether the light reaches each receiver.
    pub lit: Vec<bool>,
    /// Whether each receiver counts: asked for every method, orientation and bias.
    counts: Vec<bool>,
    /// Which sides cast.
    sides: reference::Sides,
    /// What [`Self::lit_creases`] found.
    creases: OnceLock<Vec<usize>>,
}

impl Truth {
    /// Casts the rays: receivers drawn with `seed`, until `samples` of them count. Both sides of all triangles cast.
    #[must_use]
    pub fn new(scene: &Scene, light: &PointLight, samples: usize, seed: u64) -> Self {
        Self::with_sides(scene, light, Sides::Auto, samples, seed)
    }

    /// [`Self::new`] with a rule for the sides of all meshes that cast. It says nothing about receivers: with
    /// [`Sides::Front`] the back of a double-sided triangle casts nothing and is a receiver all the same.
    #[must_use]
    pub fn with_sides(scene: &Scene, light: &PointLight, sides: Sides, samples: usize, seed: u64) -> Self {
        let view = View {
            position: light.position.as_dvec3(),
            orientation: light.orientation.as_dquat(),
            near: f64::from(light.near),
            range: f64::from(light.range),
        };
        let sides = match sides {
            Sides::Auto | Sides::Both => reference::Sides::Both,
            Sides::Front => reference::Sides::Front,
        };
        let reference = Arc::new(reference(scene, view.position, sides));
        let receivers = sample_receivers(&reference, &view, samples, seed);
        let lit = truth(&receivers, &reference, &view);
        let counts = receivers.par_iter().map(|receiver| receiver.counts(view.position)).collect();
        Self { view, reference, receivers, lit, counts, sides, creases: OnceLock::new() }
    }

    /// The same receivers and the same answers, for maps of the light turned to another orientation.
    ///
    /// What a light reaches doesn't hang on how its maps are turned, with one exception: maps leave out what is nearer
    /// than the clip distance, which is half of `near` on their axes and `near` at the seam. Receivers are farther than
    /// `near`, so maps hold them in every orientation. Where a *caster* is between half of `near` and `near`, the
    /// answers stay those of the orientation that the truth was made for; [`light_for`] keeps `near` so small that
    /// none is.
    #[must_use]
    pub fn turned(&self, orientation: Quat) -> Self {
        Self {
            view: View { orientation: orientation.as_dquat(), ..self.view },
            reference: Arc::clone(&self.reference),
            receivers: self.receivers.clone(),
            lit: self.lit.clone(),
            counts: self.counts.clone(),
            sides: self.sides,
            creases: OnceLock::new(),
        }
    }

    /// Positions and normals of the receivers, as a shader takes them. Normals are on the side of the light.
    #[must_use]
    pub fn inputs(&self) -> Vec<(Vec3, Vec3)> {
        self.receivers.iter().map(|receiver| (receiver.position, receiver.normal)).collect()
    }

    /// Error figures of a method's answers.
    ///
    /// # Panics
    /// When there are not as many values as receivers.
    #[must_use]
    pub fn judge(&self, values: &[f32]) -> ShadowError {
        shadow_error(&self.receivers, &self.lit, values, &self.reference, &self.view)
    }

    /// Wrong answers at the receivers that count, in parts per million. An answer of 0.5 or more means lit.
    #[must_use]
    pub fn wrong_ppm(&self, values: &[f32]) -> f64 {
        let (wrong, counted) = self.count(|receiver| (values[receiver] >= 0.5) != self.lit[receiver]);
        per_million(wrong, counted)
    }

    /// Wrong answers at all receivers, each weighed by its cosine with the direction to the light, in parts per million
    /// of the weight of all: the share of the light's energy that goes wrong, with no cut-off at grazing.
    #[must_use]
    pub fn wrong_energy_ppm(&self, values: &[f32]) -> f64 {
        energy_ppm(&self.receivers, &self.lit, values, self.view.position)
    }

    /// Receivers that count at which two methods decide differently, in parts per million.
    #[must_use]
    pub fn disagree_ppm(&self, values: &[f32], others: &[f32]) -> f64 {
        let (different, counted) = self.count(|receiver| (values[receiver] >= 0.5) != (others[receiver] >= 0.5));
        per_million(different, counted)
    }

    /// Number of the receivers that count: what errors are parts of.
    #[must_use]
    pub fn counted(&self) -> usize {
        self.count(|_| false).1
    }

    /// Whether each receiver counts ([`Receiver::counts`]).
    #[must_use]
    pub fn counts(&self) -> &[bool] {
        &self.counts
    }

    /// Wrong answers at receivers that count, farther from every true shadow boundary than
    /// [`FAR_TEXELS`](super::error_figures::FAR_TEXELS) of a map of this geometry, in parts per million. For a map's own
    /// tests: published figures are in the same texels for all ([`ShadowError::far_wrong_ppm`]).
    #[must_use]
    pub fn far_ppm(&self, values: &[f32], geometry: &MapGeometry) -> f64 {
        let is_far = |receiver: usize| {
            let (place, lit) = (&self.receivers[receiver], self.lit[receiver]);
            (values[receiver] >= 0.5) != lit && !near_boundary(place, lit, &self.reference, &self.view, geometry)
        };
        let (far, counted) = self.count(is_far);
        per_million(far, counted)
    }

    /// How many of the receivers that count are selected, and how many count.
    fn count(&self, selected: impl Fn(usize) -> bool + Sync) -> (usize, usize) {
        let counted = (0..self.receivers.len()).into_par_iter().filter(|receiver| self.counts[*receiver]);
        let one = counted.map(|receiver| (usize::from(selected(receiver)), 1));
        one.reduce(|| (0, 0), |(some, all), (more, one)| (some + more, all + one))
    }

    /// What a method answers in lit creases; `None` where the receivers are in none.
    #[must_use]
    pub fn crease_error(&self, values: &[f32]) -> Option<CreaseError> {
        let in_creases: Vec<f32> = self.lit_creases().iter().map(|&receiver| values[receiver]).collect();
        crease_error(&in_creases)
    }

    /// The receivers in lit creases ([`lit_creases`]). They are looked for once.
    #[must_use]
    pub fn lit_creases(&self) -> &[usize] {
        self.creases.get_or_init(|| lit_creases(&self.receivers, &self.lit, &self.reference, &self.view))
    }

    /// The ray-cast map, and the error figures of the double precision lookup on it.
    #[must_use]
    pub fn ideal(&self, geometry: MapGeometry) -> (IdealMap, ShadowError) {
        let map = ideal_map(&self.reference, &self.view, geometry);
        let error = self.judge(&self.ideal_values(&map));
        (map, error)
    }

    /// What the double precision lookup answers on a ray-cast map.
    fn ideal_values(&self, map: &IdealMap) -> Vec<f32> {
        let lookup = Lookup { view: self.view, geometry: map.geometry, bias: BIAS, normal_bias: NORMAL_BIAS };
        self.answers(|position, normal| lookup.shadow(|texel| map.depths[texel], position, normal))
    }

    /// What [`VotesV1`] answers at the receivers on a ray-cast map.
    #[must_use]
    pub fn votes_v1(&self, map: &IdealMap) -> Vec<f32> {
        let lookup = VotesV1 { view: self.view, geometry: map.geometry };
        self.answers(|position, normal| lookup.shadow(|texel| map.depths[texel], position, normal))
    }

    /// A lookup's answers from positions and normals of the world.
    fn answers(&self, lookup: impl Fn(DVec3, DVec3) -> f64 + Sync) -> Vec<f32> {
        let answer = |receiver: &Receiver| lookup(receiver.position.as_dvec3(), receiver.normal.as_dvec3()) as f32;
        self.receivers.par_iter().map(answer).collect()
    }
}

/// A scene's triangles around a light, all with the same rule for which sides cast.
fn reference(scene: &Scene, light: DVec3, sides: reference::Sides) -> Reference {
    let all = scene.world_triangles();
    let sides = (sides == reference::Sides::Front).then(|| vec![sides; all.corners.len()]);
    Reference::new(&all.corners, sides.as_deref(), light)
        .with_cut_outs(scene.cut_outs(&all))
        .with_double_sided(scene.double_sided(&all))
        .with_closed_pieces(&scene.closed_pieces(&all))
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
        let mut casters = Casters::new(&gpu.device)?;
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
        let ideal = ideal_map(&truth.reference, &truth.view, geometry);
        let ideal_values = truth.ideal_values(&ideal);
        let ideal_error = truth.judge(&ideal_values);
        let stored = gpu.read_map(&self.shadows, self.light);
        let values = gpu.shadow_values(&self.shadows, &self.casters, self.light, &truth.inputs());
        Figures {
            map: map_error(&stored, &ideal, &truth.reference, &truth.view),
            shadow: ShadowReport { error: truth.judge(&values), ideal_wrong_ppm: ideal_error.wrong_ppm },
            ideal: ideal_error,
            far_wrong_ppm: [&values, &ideal_values].map(|values| truth.far_ppm(values, &geometry)),
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
    /// Far answers of the lookup, and of the ray-cast map, in texels of the map itself ([`Truth::far_ppm`]).
    pub far_wrong_ppm: [f64; 2],
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
    use crate::compare::procedural::shapes::{append, cuboid, quad, torus};
    use crate::compare::scene::{Alpha, Material, SceneInstance, SceneMesh};
    use glam::Affine3A;

    /// A floor that faces a lamp above, and a sheet between them, from the lamp's side or from behind.
    fn truth(sheet_faces_the_lamp: bool, double_sided: bool, sides: Sides, mirror: f32) -> Truth {
        let (low, x, z) = (Vec3::new(-0.5, 1.0, -0.5), Vec3::X, Vec3::Z);
        let mut sheet = if sheet_faces_the_lamp { quad(low, z, x) } else { quad(low, x, z) };
        sheet.material = 1;
        let floor = quad(Vec3::new(-2.0, 0.0, -2.0), 4.0 * z, 4.0 * x);
        let transforms = [Affine3A::IDENTITY, Affine3A::from_scale(Vec3::new(mirror, 1.0, 1.0))];
        let instance = |(mesh, transform)| SceneInstance { mesh, transform };
        let instances = transforms.into_iter().enumerate().map(instance).collect();
        let materials = vec![Material::default(), Material { double_sided, ..Material::default() }];
        let scene = Scene { meshes: vec![floor, sheet], instances, materials, ..Scene::default() };
        let light = PointLight { position: 2.0 * Vec3::Y, range: 10.0, ..Default::default() };
        Truth::with_sides(&scene, &light, sides, 2000, 1)
    }

    /// Share of the receivers for which something holds.
    fn share(truth: &Truth, of: impl Fn(usize) -> bool) -> f64 {
        (0..truth.receivers.len()).filter(|receiver| of(*receiver)).count() as f64 / truth.receivers.len() as f64
    }

    #[test]
    fn backs_cast_only_where_both_sides_do() {
        for (mirror, faces, double_sided) in
            [1.0, -1.0].into_iter().flat_map(|m| [(true, false), (false, false), (false, true)].map(|(f, d)| (m, f, d)))
        {
            for sides in [Sides::Auto, Sides::Front] {
                let truth = truth(faces, double_sided, sides, mirror);
                // A mirrored sheet keeps the side that it faces: the file says which, whatever the transform.
                let casts = sides == Sides::Auto || faces;
                let dark = share(&truth, |receiver| !truth.lit[receiver]);
                assert_eq!(dark > 0.1, casts, "{mirror} {faces} {double_sided} {sides:?}: {dark}");
                let on_sheet = share(&truth, |receiver| truth.receivers[receiver].triangle >= 2);
                assert_eq!(on_sheet > 0.1, faces || double_sided, "{mirror} {faces} {double_sided} {sides:?}");
            }
        }
    }

    /// Inside out, by the order of the corners.
    fn turned_over(mesh: &SceneMesh) -> SceneMesh {
        let indices = mesh.indices.chunks_exact(3).flat_map(|corners| [corners[0], corners[2], corners[1]]);
        SceneMesh { indices: indices.collect(), ..mesh.clone() }
    }

    /// The truth of a mesh in a place, in the light of a lamp.
    fn truth_of(mesh: &SceneMesh, transform: Affine3A, material: Material, lamp: Vec3) -> Truth {
        let scene = Scene {
            meshes: vec![SceneMesh { tex_coords: Some(vec![[0.5; 2]; mesh.positions.len()]), ..mesh.clone() }],
            instances: vec![SceneInstance { mesh: 0, transform }],
            materials: vec![material],
            images: vec![image::RgbaImage::from_pixel(1, 1, image::Rgba([255; 4]))],
            ..Scene::default()
        };
        let light = PointLight { position: lamp, range: 100.0, near: 1e-3, ..Default::default() };
        Truth::new(&scene, &light, 1000, 1)
    }

    /// The faces, of two triangles each, that have receivers.
    fn faces_with_receivers(mesh: &SceneMesh, material: Material, lamp: Vec3) -> Vec<u32> {
        let truth = truth_of(mesh, Affine3A::IDENTITY, material, lamp);
        let mut faces: Vec<u32> = truth.receivers.iter().map(|receiver| receiver.triangle / 2).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    fn double_sided() -> Material {
        Material { double_sided: true, ..Material::default() }
    }

    /// Faces of a cuboid: -x, +x, -y, +y, -z, +z.
    #[test]
    fn insides_of_closed_pieces_count_only_around_the_light() {
        let cube = cuboid(Vec3::NEG_ONE, Vec3::ONE);
        let inside_out = turned_over(&cube);
        let (above, aslant, within) = (3.0 * Vec3::Y, Vec3::new(3.0, 3.0, 0.0), 0.5 * Vec3::X);
        for closed in [&cube, &inside_out] {
            assert_eq!(faces_with_receivers(closed, double_sided(), above), [3]);
            assert_eq!(faces_with_receivers(closed, double_sided(), aslant), [1, 3]);
            assert_eq!(faces_with_receivers(closed, double_sided(), within), [0, 1, 2, 3, 4, 5]);
        }
        // Of single-sided ones fronts alone are drawn: through the outside of one that is inside out its inside is seen.
        assert_eq!(faces_with_receivers(&cube, Material::default(), above), [3]);
        assert_eq!(faces_with_receivers(&inside_out, Material::default(), above), [0, 1, 2, 4, 5]);
    }

    #[test]
    fn both_sides_of_what_is_open_or_seen_through_count() {
        let mut open = cuboid(Vec3::NEG_ONE, Vec3::ONE);
        let holes = Material { alpha: Alpha::Mask { cutoff: 0.5 }, base_color_image: Some(0), ..double_sided() };
        let glass = Material { alpha: Alpha::Blend, ..double_sided() };
        for material in [holes, glass] {
            assert_eq!(faces_with_receivers(&open, material, 3.0 * Vec3::Y), [0, 1, 2, 3, 4, 5]);
        }
        // A mask without an image has no holes.
        let solid = Material { base_color_image: None, ..holes };
        assert_eq!(faces_with_receivers(&open, solid, 3.0 * Vec3::Y), [3]);
        // Without +z.
        open.indices.truncate(30);
        assert_eq!(faces_with_receivers(&open, double_sided(), 3.0 * Vec3::Y), [0, 1, 2, 3, 4]);
        let sheet = quad(Vec3::new(-1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X);
        for lamp in [Vec3::Y, Vec3::NEG_Y] {
            assert_eq!(faces_with_receivers(&sheet, double_sided(), lamp), [0]);
        }
    }

    /// The light in one of two boxes of a mesh: of the other one only the face towards it counts.
    #[test]
    fn each_piece_of_a_mesh_is_judged_by_itself() {
        let mut boxes = cuboid(Vec3::NEG_ONE, Vec3::ONE);
        // A triangle of no area before the second box: numbers are those of the file.
        boxes.indices.extend([0, 0, 0, 0, 0, 0]);
        append(&mut boxes, &turned_over(&cuboid(Vec3::NEG_ONE, Vec3::ONE)), Affine3A::from_translation(3.0 * Vec3::X));
        assert_eq!(faces_with_receivers(&boxes, double_sided(), 0.5 * Vec3::Y), [0, 1, 2, 3, 4, 5, 7]);
        assert_eq!(faces_with_receivers(&boxes, double_sided(), 3.0 * Vec3::X), [1, 7, 8, 9, 10, 11, 12]);
    }

    /// In the hole of a ring the light is within its bounds, but not inside. A mirrored ring is the same.
    #[test]
    fn a_light_in_a_ring_s_hole_is_outside_of_the_ring() {
        let ring = torus(2.0, 0.5, 24, 12);
        for (scale, mesh) in [(1.0, ring.clone()), (-1.0, ring.clone()), (1.0, turned_over(&ring))] {
            let mirror = Affine3A::from_scale(Vec3::new(scale, 1.0, 1.0));
            let from_hole = truth_of(&mesh, mirror, double_sided(), Vec3::ZERO);
            let radius = |receiver: &Receiver| receiver.position.with_y(0.0).length();
            assert!(!from_hole.receivers.is_empty());
            assert!(from_hole.receivers.iter().all(|receiver| radius(receiver) < 2.0), "the tube's near side");
            let in_tube = truth_of(&mesh, mirror, double_sided(), 2.0 * Vec3::X);
            assert!(in_tube.receivers.iter().any(|receiver| receiver.position.x > 2.3), "the tube's inside");
        }
    }

    #[test]
    fn wrong_answers_of_those_that_count() {
        let truth = truth(true, false, Sides::Auto, 1.0);
        let right: Vec<f32> = truth.lit.iter().map(|lit| f32::from(u8::from(*lit))).collect();
        let wrong: Vec<f32> = right.iter().map(|value| 1.0 - value).collect();
        assert_eq!((truth.wrong_ppm(&right), truth.wrong_energy_ppm(&right)), (0.0, 0.0));
        assert_eq!((truth.wrong_ppm(&wrong), truth.wrong_energy_ppm(&wrong)), (1e6, 1e6));
        let mut some = right.clone();
        (0..10).for_each(|receiver| some[receiver] = 1.0 - some[receiver]);
        assert_eq!(truth.wrong_ppm(&some), 1e7 / 2000.0);
        assert_eq!((truth.disagree_ppm(&right, &some), truth.disagree_ppm(&some, &some)), (1e7 / 2000.0, 0.0));
    }

    /// Of a sheet that shows the lamp its back, over a floor: what is wrong there alone is not wrong on fronts.
    #[test]
    fn fronts_are_told_from_backs() {
        let truth = truth(false, true, Sides::Auto, 1.0);
        let on_back = |receiver: usize| truth.receivers[receiver].triangle >= 2;
        let backs = share(&truth, |receiver| truth.counts()[receiver] && on_back(receiver));
        let answers = |wrong: &dyn Fn(usize) -> bool| -> Vec<f32> {
            (0..truth.lit.len()).map(|i| f32::from(u8::from(truth.lit[i] != wrong(i)))).collect()
        };
        let error = truth.judge(&answers(&on_back));
        let counted = truth.counted() as f64 / truth.lit.len() as f64;
        assert!(backs > 0.2 && (error.back_fraction - backs / counted).abs() < 1e-9, "{backs} {error:?}");
        assert!(error.wrong_ppm > 2e5 && error.wrong_front_ppm == 0.0, "{error:?}");
        let error = truth.judge(&answers(&|receiver| !on_back(receiver)));
        assert!(error.wrong_ppm < 9e5 && error.wrong_front_ppm == 1e6, "{error:?}");
    }

    #[test]
    fn a_turned_truth_is_the_same_truth() {
        let truth = truth(true, false, Sides::Auto, 1.0);
        let turn = Quat::from_rotation_z(1.0);
        let turned = truth.turned(turn);
        assert_eq!((&turned.receivers, &turned.lit), (&truth.receivers, &truth.lit));
        assert_eq!(turned.view, View { orientation: turn.as_dquat(), ..truth.view });
        let cast = super::truth(&turned.receivers, &turned.reference, &turned.view);
        assert_eq!(cast, truth.lit, "what was cast for the turned view");
    }
}
