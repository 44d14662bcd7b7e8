//! Values by handles that can't be mistaken for one another.

use crate::Error;
use crate::ranges::Ranges;
use std::sync::atomic::{AtomicU32, Ordering};

/// Names one value of one [`Slots`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Handle {
    owner: u32,
    pub(crate) slot: u32,
    generation: u32,
}

/// Values by handle. A generation is never given twice, so a handle can't come alive again.
#[derive(Debug)]
pub(crate) struct Slots<T> {
    what: &'static str,
    owner_name: &'static str,
    owner: u32,
    ranges: Ranges,
    slots: Vec<Option<(u32, T)>>,
    generation: u32,
}

impl<T> Slots<T> {
    /// Names what the values are and which type gives out their handles, for errors.
    pub(crate) fn new(what: &'static str, owner_name: &'static str) -> Self {
        static OWNERS: AtomicU32 = AtomicU32::new(0);
        let owner = OWNERS.fetch_add(1, Ordering::Relaxed);
        Self { what, owner_name, owner, ranges: Ranges::default(), slots: Vec::new(), generation: 0 }
    }

    /// Differs from that of every other [`Slots`].
    pub(crate) fn owner(&self) -> u32 {
        self.owner
    }

    pub(crate) fn insert(&mut self, value: T) -> Handle {
        let slot = self.ranges.allocate(1);
        self.slots.resize_with(self.ranges.end() as usize, || None);
        self.generation = self.generation.wrapping_add(1);
        self.slots[slot as usize] = Some((self.generation, value));
        Handle { owner: self.owner, slot, generation: self.generation }
    }

    pub(crate) fn get(&self, handle: Handle) -> Result<&T, Error> {
        match self.slots.get(handle.slot as usize) {
            Some(Some((generation, value))) if handle.owner == self.owner && *generation == handle.generation => {
                Ok(value)
            }
            _ => Err(stale(handle, self.what, self.owner_name)),
        }
    }

    pub(crate) fn get_mut(&mut self, handle: Handle) -> Result<&mut T, Error> {
        match self.slots.get_mut(handle.slot as usize) {
            Some(Some((generation, value))) if handle.owner == self.owner && *generation == handle.generation => {
                Ok(value)
            }
            _ => Err(stale(handle, self.what, self.owner_name)),
        }
    }

    pub(crate) fn remove(&mut self, handle: Handle) -> Result<(), Error> {
        self.get(handle)?;
        self.slots[handle.slot as usize] = None;
        self.ranges.release(handle.slot, 1);
        self.slots.truncate(self.ranges.end() as usize);
        Ok(())
    }

    /// Number of values.
    pub(crate) fn count(&self) -> u32 {
        self.slots.iter().flatten().count() as u32
    }

    /// The values with their slots.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (u32, &mut T)> {
        self.slots.iter_mut().enumerate().filter_map(|(slot, entry)| entry.as_mut().map(|(_, v)| (slot as u32, v)))
    }
}

fn stale(handle: Handle, what: &'static str, owner: &'static str) -> Error {
    Error::StaleHandle { what, handle: format!("{}v{}", handle.slot, handle.generation), owner }
}
