//! What one run of the stages goes through: several lights' jobs at a time, so that a small light costs what is near it
//! and not a round of dispatches that wait for one another.

use crate::light::PointLight;
use std::ops::Range;

/// Jobs of one batch at most; twin of the constant in `shaders/view.wgsl`.
pub(crate) const MOST_JOBS: u32 = 8;

/// Bits of [`Job::kinds`]: bit 0 of a chunk's kind says that its instance is marked as moving.
pub(crate) const STATIC: u32 = 0b0101;
/// The others.
pub(crate) const MOVING: u32 = 0b1010;
/// The same: bit 1 says that its mesh has holes.
pub(crate) const OPAQUE: u32 = 0b0011;
/// See [`OPAQUE`].
pub(crate) const MASKED: u32 = 0b1100;

/// A light, a stretch of the chunks, and which kinds of them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Job {
    pub(crate) light: PointLight,
    pub(crate) chunks: Range<u32>,
    /// Bit k stands for chunks of kind k.
    pub(crate) kinds: u32,
    /// Triangles of these chunks at most.
    pub(crate) triangles: u32,
}

impl Job {
    /// Whether it is of casters with holes.
    pub(crate) fn is_masked(&self) -> bool {
        self.kinds & OPAQUE == 0
    }
}

/// A job's shares of the lists and of the pieces: where they start, and the room that each hemisphere has there, front
/// and then back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shares {
    pub(crate) first_triangle: u32,
    pub(crate) triangles: u32,
    pub(crate) first_piece: u32,
    pub(crate) pieces: u32,
}

/// Packs jobs, in order, into batches of at most `most` jobs whose lists together have room for `triangles` in each
/// hemisphere. A job that alone has more is a batch of its own.
pub(crate) fn pack(jobs: &[Job], most: u32, triangles: u32) -> Vec<Range<u32>> {
    let mut batches: Vec<Range<u32>> = Vec::new();
    let mut listed = 0;
    for (number, job) in (0..).zip(jobs) {
        match batches.last_mut() {
            Some(batch) if batch.len() < most as usize && listed + job.triangles <= triangles => {
                batch.end += 1;
                listed += job.triangles;
            }
            _ => {
                batches.push(number..number + 1);
                listed = job.triangles;
            }
        }
    }
    batches
}

/// The shares of a batch's jobs, each hemisphere of each with room for `pieces`.
pub(crate) fn shares(jobs: &[Job], pieces: u32) -> impl Iterator<Item = Shares> {
    let mut listed = 0;
    (0..).zip(jobs).map(move |(place, job)| {
        let first_triangle = listed;
        listed += 2 * job.triangles;
        Shares { first_triangle, triangles: job.triangles, first_piece: 2 * pieces * place, pieces }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jobs(triangles: &[u32]) -> Vec<Job> {
        let job = |&triangles| Job { light: PointLight::default(), chunks: 0..1, kinds: OPAQUE, triangles };
        triangles.iter().map(job).collect()
    }

    #[test]
    fn batches_have_room() {
        let jobs = jobs(&[4, 4, 4, 10, 1, 1, 1, 1, 1, 20, 3]);
        assert_eq!(pack(&jobs, 3, 10), [0..2, 2..3, 3..4, 4..7, 7..9, 9..10, 10..11]);
        assert_eq!(pack(&[], 3, 10), []);
    }

    #[test]
    fn shares_follow_one_another() {
        let starts: Vec<_> = shares(&jobs(&[5, 7, 2]), 100).map(|s| (s.first_triangle, s.first_piece)).collect();
        assert_eq!(starts, [(0, 0), (10, 200), (24, 400)]);
    }
}
