//! The rule without rounding, on ray-cast maps: what it is right about at best.

use super::{Surface, double};
use crate::compare::ideal::{IdealMap, NO_TRIANGLE, NORMAL_BIAS};
use crate::compare::measure::Truth;
use crate::compare::scene::Scene;
use glam::DVec3;
use rayon::prelude::*;

/// A scene's triangles for walks, and which of the scene's [world triangles](Scene::world_triangles) they are.
pub struct IdealWalks {
    /// The triangles.
    pub surface: Surface,
    /// By world triangle, its number in maps, or [`NO_TRIANGLE`].
    numbers: Vec<u32>,
    /// By number, the world triangle.
    triangles: Vec<u32>,
}

impl IdealWalks {
    /// Cuts the scene's meshes.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let (surface, numbers) = Surface::new(scene);
        let drawn = || numbers.iter().zip(0..).filter(|(number, _)| **number != NO_TRIANGLE);
        let mut triangles = vec![NO_TRIANGLE; drawn().map(|(number, _)| *number as usize + 1).max().unwrap_or(0)];
        for (&number, triangle) in drawn() {
            triangles[number as usize] = triangle;
        }
        Self { surface, numbers, triangles }
    }

    /// The number in maps of each texel's triangle.
    #[must_use]
    pub fn numbers(&self, map: &IdealMap) -> Vec<u32> {
        let number = |&triangle: &u32| self.numbers.get(triangle as usize).copied().unwrap_or(NO_TRIANGLE);
        map.triangles.par_iter().map(number).collect()
    }

    /// Whether a triangle, by its number, has a hole in a unit direction from the light.
    #[must_use]
    pub fn is_hole(&self, truth: &Truth, number: u32, direction: DVec3) -> bool {
        truth.reference.is_hole(self.triangles[number as usize], direction)
    }

    /// What the rule answers at the truth's receivers, from the ray-cast map of the same scene and light, with walks of at
    /// most `steps` triangles beyond the first.
    #[must_use]
    pub fn shadows(&self, truth: &Truth, map: &IdealMap, steps: u32) -> Vec<f32> {
        let exact = double::Exact {
            view: truth.view,
            geometry: map.geometry,
            normal_bias: NORMAL_BIAS,
            receiver_offset: 0.0,
            made: Surface::FIRST,
            depths: &map.depths,
            numbers: &self.numbers(map),
            surface: &self.surface,
            is_hole: &|number, direction| self.is_hole(truth, number, direction),
            steps,
        };
        let shadow = |(position, normal): (DVec3, DVec3)| exact.walk_shadow(position, normal) as f32;
        truth.receivers.par_iter().map(|r| shadow((r.position.as_dvec3(), r.normal.as_dvec3()))).collect()
    }
}
