//! Which maps are stale, and which of them go first when not all may be made at once.

use crate::Error;
use crate::casters::Change;
use crate::light::PointLight;
use crate::slots::Slots;

/// How much of a light's map has to be made anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stale {
    /// None of it.
    Nothing,
    /// What moving casters add to the static ones.
    Moving,
    /// All of it.
    Everything,
}

/// A light, and what is known of its map.
#[derive(Debug)]
pub(crate) struct Light {
    light: PointLight,
    stale: Stale,
    priority: f32,
    /// Recordings since the map became stale.
    waiting: u32,
    /// Whether there is a map of it at all.
    made: bool,
}

/// A light whose map is made now.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Due {
    pub(crate) layer: u32,
    pub(crate) light: PointLight,
    pub(crate) stale: Stale,
}

impl Light {
    pub(crate) fn new(light: PointLight) -> Self {
        Self { light, stale: Stale::Everything, priority: 1.0, waiting: 0, made: false }
    }

    /// Changes the light; its map is stale unless that changes nothing.
    pub(crate) fn set(&mut self, light: PointLight) {
        if self.light != light {
            self.light = light;
            self.stale = Stale::Everything;
        }
    }

    pub(crate) fn set_priority(&mut self, priority: f32) -> Result<(), Error> {
        if !(priority.is_finite() && priority > 0.0) {
            let remedy = "it must be finite and above 0";
            return Err(Error::InvalidLight { what: "priority", value: priority.to_string(), remedy });
        }
        self.priority = priority;
        Ok(())
    }

    pub(crate) fn outdate(&mut self) {
        self.stale = Stale::Everything;
    }

    /// Notes what changes of the casters do to the map; those of moving ones count apart only where static ones are kept.
    pub(crate) fn touch<'a>(&mut self, changes: impl Iterator<Item = &'a Change>, keep_static: bool) {
        for change in changes {
            if self.stale == Stale::Everything {
                return;
            }
            let stale = if keep_static && change.moving { Stale::Moving } else { Stale::Everything };
            if stale > self.stale && self.is_reached_by(change) {
                self.stale = stale;
            }
        }
    }

    /// Whether the map may show something within the bounds.
    fn is_reached_by(&self, change: &Change) -> bool {
        let PointLight { position, range, .. } = self.light;
        [change.before, change.after].iter().flatten().any(|bounds| bounds.touches_sphere(position, range * 1.0001))
    }

    /// What goes first: maps that were never made, then those that have waited the longest, by priority.
    fn urgency(&self) -> (bool, f64) {
        (!self.made, f64::from(self.priority) * f64::from(self.waiting))
    }
}

/// Takes the lights whose maps are made now, `most` at most; the other stale ones go on waiting.
pub(crate) fn take(lights: &mut Slots<Light>, most: Option<u32>) -> Vec<Due> {
    let mut stale: Vec<(u32, &mut Light)> =
        lights.iter_mut().filter(|(_, entry)| entry.stale > Stale::Nothing).collect();
    for (_, entry) in &mut stale {
        entry.waiting = entry.waiting.saturating_add(1);
    }
    if most.is_some_and(|most| stale.len() > most as usize) {
        stale.sort_by(|(_, a), (_, b)| {
            let ((unmade_a, a), (unmade_b, b)) = (a.urgency(), b.urgency());
            unmade_b.cmp(&unmade_a).then(b.total_cmp(&a))
        });
    }
    let taken = stale.into_iter().take(most.map_or(usize::MAX, |most| most as usize));
    let due = taken.map(|(layer, entry)| {
        entry.waiting = 0;
        entry.made = true;
        Due { layer, light: entry.light, stale: std::mem::replace(&mut entry.stale, Stale::Nothing) }
    });
    due.collect()
}
