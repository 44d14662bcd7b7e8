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
    /// Whether its filter has changed since its map was made.
    lookup_changed: bool,
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
        Self { light, stale: Stale::Everything, priority: 1.0, waiting: 0, made: false, lookup_changed: false }
    }

    /// Changes the light; its map is stale unless that changes nothing but what lookups read.
    pub(crate) fn set(&mut self, light: PointLight) {
        let PointLight { filter, receiver_offset, .. } = light;
        let same_map = PointLight { filter, receiver_offset, ..self.light } == light;
        self.lookup_changed |= same_map && self.light != light;
        if !same_map {
            self.stale = Stale::Everything;
        }
        self.light = light;
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

    /// There is no map of it: it was never made, since the encoder was thrown away.
    pub(crate) fn forget_map(&mut self) {
        self.stale = Stale::Everything;
        self.made = false;
    }

    /// Notes what a change of the casters does to the map; one of a moving caster counts apart only where static ones are
    /// kept. Returns whether another change may make the map staler.
    pub(crate) fn touch(&mut self, change: &Change, keep_static: bool) -> bool {
        let PointLight { position, range, .. } = self.light;
        let stale = if keep_static && change.moving { Stale::Moving } else { Stale::Everything };
        if stale > self.stale && change.touches_sphere(position, range * 1.0001) {
            self.stale = stale;
        }
        self.stale < Stale::Everything
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

/// Takes the lights of which nothing has changed but what lookups read. Those whose maps wait get it with them.
pub(crate) fn take_lookup_changes(lights: &mut Slots<Light>) -> Vec<(u32, PointLight)> {
    let changed = lights.iter_mut().filter(|(_, entry)| entry.lookup_changed && entry.stale < Stale::Everything);
    let taken = changed.map(|(layer, entry)| {
        entry.lookup_changed = false;
        (layer, entry.light)
    });
    taken.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lights of these priorities, all with maps.
    fn lights(priorities: &[f32]) -> Slots<Light> {
        let mut lights = Slots::new("light", "PointShadows");
        for &priority in priorities {
            let mut light = Light::new(PointLight::default());
            light.set_priority(priority).unwrap();
            lights.insert(light);
        }
        assert_eq!(take(&mut lights, None).len(), priorities.len());
        lights
    }

    fn outdate(lights: &mut Slots<Light>) {
        lights.iter_mut().for_each(|(_, light)| light.outdate());
    }

    fn layers(due: &[Due]) -> Vec<u32> {
        due.iter().map(|due| due.layer).collect()
    }

    #[test]
    fn none_waits_for_ever() {
        let priorities: Vec<f32> = (0..16).map(|k| if k == 7 { 0.01 } else { 1.0 + k as f32 }).collect();
        let mut lights = lights(&priorities);
        let mut made = [0u32; 16];
        for _ in 0..20_000 {
            outdate(&mut lights);
            let due = take(&mut lights, Some(3));
            assert_eq!(due.len(), 3);
            due.iter().for_each(|due| made[due.layer as usize] += 1);
        }
        assert!((3..9).contains(&made[7]), "{made:?}");
        // All others nearly in proportion.
        let rates: Vec<f32> = (0..16).filter(|k| *k != 7).map(|k| made[k] as f32 / priorities[k]).collect();
        let (least, most) = rates.iter().fold((f32::MAX, 0.0f32), |(a, b), r| (a.min(*r), b.max(*r)));
        assert!(most < 1.4 * least, "{made:?}");
    }

    #[test]
    fn new_ones_first_then_the_longest_waiting_by_priority() {
        let mut lights = lights(&[1.0, 5.0, 2.0]);
        outdate(&mut lights);
        let new = lights.insert(Light::new(PointLight::default())).slot;
        assert!(take(&mut lights, Some(0)).is_empty());
        assert_eq!(layers(&take(&mut lights, Some(2))), [new, 1]);
        outdate(&mut lights);
        // Three recordings at priorities 1 and 2, and the first at 5 and 1.
        assert_eq!(layers(&take(&mut lights, Some(3))), [2, 1, 0]);
        assert_eq!(layers(&take(&mut lights, None)), [new]);
        assert!(take(&mut lights, None).is_empty());
    }

    #[test]
    fn a_map_that_waits_is_read_as_it_was() {
        let mut lights = lights(&[1.0, 1.0]);
        let soft = PointLight { filter: crate::Filter::soft(0.1), ..PointLight::default() };
        lights.iter_mut().for_each(|(_, light)| light.set(soft));
        if let Some((_, light)) = lights.iter_mut().next() {
            light.set(PointLight { range: 5.0, ..soft });
        }
        assert_eq!(take_lookup_changes(&mut lights), [(1, soft)]);
        assert!(take_lookup_changes(&mut lights).is_empty(), "read anew for ever");
        assert_eq!(layers(&take(&mut lights, None)), [0]);
    }

    #[test]
    fn priorities_are_finite_and_above_0() {
        let mut light = Light::new(PointLight::default());
        for wrong in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let error = light.set_priority(wrong).unwrap_err();
            assert!(matches!(error, Error::InvalidLight { what: "priority", .. }), "{error}");
        }
        assert_eq!(light.priority, 1.0);
    }
}
