//! Which recordings were submitted. An encoder may be thrown away, and then nothing of what it holds has happened.
//!
//! wgpu keeps a callback with the encoder and the command buffer, calls it once their work is done, and drops it with
//! them if they are never submitted: its drop tells.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

/// Neither submitted nor thrown away yet, as far as is known.
const OPEN: u8 = 0;
/// Its work is done. It counts only if that of those before it is.
const DONE: u8 = 1;
/// Its work is done, and that of all before it.
const CONFIRMED: u8 = 2;
/// It never happened, in its order, or one before it didn't.
const LOST: u8 = 3;

/// What became of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Recording {
    number: u64,
    state: Arc<AtomicU8>,
}

impl Recording {
    fn is(&self, state: u8) -> bool {
        self.state.load(Ordering::Acquire) == state
    }

    fn leave_open(&self, state: u8) {
        // Whether it was open still makes no difference.
        let _ = self.state.compare_exchange(OPEN, state, Ordering::AcqRel, Ordering::Acquire);
    }

    /// Whether all it did, and all it was built on, is done.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.is(CONFIRMED)
    }

    /// Whether it has to be done again.
    pub(crate) fn is_lost(&self) -> bool {
        self.is(LOST)
    }

    /// Whether it is neither known to be done nor to be lost.
    pub(crate) fn is_open(&self) -> bool {
        self.is(OPEN)
    }
}

/// Goes with an encoder.
#[derive(Debug)]
struct Watch {
    recording: Recording,
    /// The last recording whose work was done.
    newest: Arc<AtomicU64>,
}

impl Watch {
    fn done(self) {
        let newest = self.newest.fetch_max(self.recording.number, Ordering::AcqRel);
        self.recording.leave_open(if newest > self.recording.number { LOST } else { DONE });
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.recording.leave_open(LOST);
    }
}

/// Recordings that build on one another, with what it takes to do each again.
#[derive(Debug)]
pub(crate) struct Recordings<T> {
    count: u64,
    newest: Arc<AtomicU64>,
    unconfirmed: VecDeque<(Recording, T)>,
}

impl<T> Default for Recordings<T> {
    fn default() -> Self {
        Self { count: 0, newest: Arc::default(), unconfirmed: VecDeque::new() }
    }
}

impl<T> Recordings<T> {
    /// Notes a recording. What it takes to do it again is kept until it is confirmed.
    pub(crate) fn begin(&mut self, encoder: &wgpu::CommandEncoder, again: T) -> Recording {
        let watch = self.watch(again);
        let recording = watch.recording.clone();
        encoder.on_submitted_work_done(move || watch.done());
        recording
    }

    fn watch(&mut self, again: T) -> Watch {
        self.count += 1;
        let recording = Recording { number: self.count, state: Arc::default() };
        self.unconfirmed.push_back((recording.clone(), again));
        Watch { recording, newest: self.newest.clone() }
    }

    /// What is kept to be done again.
    pub(crate) fn unconfirmed(&self) -> impl Iterator<Item = &T> {
        self.unconfirmed.iter().map(|(_, again)| again)
    }

    /// Takes what has to be done again, in order: the first recording that is lost, and all that were built on it. Those
    /// count as lost from now on.
    pub(crate) fn take_lost(&mut self) -> Vec<T> {
        while let Some((recording, _)) = self.unconfirmed.front()
            && recording.is(DONE)
        {
            recording.state.store(CONFIRMED, Ordering::Release);
            self.unconfirmed.pop_front();
        }
        let first = self.unconfirmed.iter().position(|(recording, _)| recording.is_lost());
        let lost = self.unconfirmed.split_off(first.unwrap_or(self.unconfirmed.len()));
        let again = lost.into_iter().map(|(recording, again)| {
            recording.state.store(LOST, Ordering::Release);
            again
        });
        again.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three() -> (Recordings<u32>, [Watch; 3]) {
        let mut recordings = Recordings::default();
        let watches = [1, 2, 3].map(|again| recordings.watch(again));
        (recordings, watches)
    }

    #[test]
    fn done_in_order_they_are_confirmed() {
        let (mut recordings, watches) = three();
        let states = watches.each_ref().map(|watch| watch.recording.clone());
        assert!(recordings.take_lost().is_empty());
        assert!(states.iter().all(Recording::is_open));
        watches.into_iter().for_each(Watch::done);
        assert!(recordings.take_lost().is_empty());
        assert!(states.iter().all(Recording::is_confirmed));
        assert!(recordings.unconfirmed.is_empty());
    }

    #[test]
    fn what_is_built_on_a_lost_one_is_lost() {
        let (mut recordings, [first, second, third]) = three();
        let states = [&first, &second, &third].map(|watch| watch.recording.clone());
        first.done();
        third.done();
        assert!(recordings.take_lost().is_empty(), "the second may be submitted yet");
        assert!(states[0].is_confirmed() && !states[2].is_confirmed());
        drop(second);
        assert_eq!(recordings.take_lost(), [2, 3]);
        assert!(states[1].is_lost() && states[2].is_lost());
        assert!(recordings.take_lost().is_empty());
    }

    #[test]
    fn one_that_is_done_after_its_successor_is_lost() {
        let (mut recordings, [first, second, third]) = three();
        first.done();
        third.done();
        second.done();
        assert_eq!(recordings.take_lost(), [2, 3]);
    }
}
