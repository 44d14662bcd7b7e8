//! Times of work on the device and of recording it, for several ways at once.

use super::gpu::Gpu;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::time::{Duration, Instant};

/// What the device's times were taken with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// Timestamps that the device wrote before and after the work.
    Timestamps,
    /// The host's clock, from submitting the work until the device is idle: for devices without timestamps, and for
    /// software drivers, whose timestamps say little.
    Wall,
}

impl fmt::Display for Clock {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Timestamps => "timestamps of the GPU",
            Self::Wall => "wall time from submitting to idle",
        })
    }
}

/// How often to measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rounds {
    /// Rounds that aren't counted.
    pub warm_up: usize,
    /// Rounds that are; at least one is made.
    pub measured: usize,
}

/// The middle and the ends of some durations. Written out in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
pub struct Summary {
    /// The middle one; the upper of two.
    #[serde(rename = "ms_median", with = "as_milliseconds")]
    pub median: Duration,
    /// The shortest.
    #[serde(rename = "ms_min", with = "as_milliseconds")]
    pub min: Duration,
    /// The longest.
    #[serde(rename = "ms_max", with = "as_milliseconds")]
    pub max: Duration,
}

/// A duration in milliseconds.
#[must_use]
pub fn milliseconds(time: Duration) -> f64 {
    1000.0 * time.as_secs_f64()
}

/// Durations written in milliseconds, and read back to the nanosecond.
pub(super) mod as_milliseconds {
    use super::{Deserialize, Deserializer, Duration, Serializer, milliseconds};
    use serde::de::Error;

    pub fn serialize<S: Serializer>(time: &Duration, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(milliseconds(*time))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Duration, D::Error> {
        let seconds = f64::deserialize(deserializer)? / 1000.0;
        Duration::try_from_secs_f64(seconds).map_err(D::Error::custom)
    }
}

impl Summary {
    /// Of all `durations`; zero without any.
    #[must_use]
    pub fn new(mut durations: Vec<Duration>) -> Self {
        durations.sort_unstable();
        let at = |index: usize| durations.get(index).copied().unwrap_or_default();
        Self { median: at(durations.len() / 2), min: at(0), max: at(durations.len().saturating_sub(1)) }
    }
}

/// What one way took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Times {
    /// The device's work.
    pub gpu: Summary,
    /// The host's recording, until the encoder is finished.
    pub cpu: Summary,
}

/// Measures on one device.
#[derive(Debug)]
pub struct Timer<'a> {
    gpu: &'a Gpu,
    queries: Option<Queries>,
}

/// Two timestamps and the way to the host.
#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl<'a> Timer<'a> {
    /// Uses timestamps where the device has [`wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS`] and isn't a software
    /// driver.
    #[must_use]
    pub fn new(gpu: &'a Gpu) -> Self {
        let features = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let real = gpu.info.device_type != wgpu::DeviceType::Cpu && gpu.device.features().contains(features);
        Self { gpu, queries: real.then(|| Queries::new(&gpu.device)) }
    }

    /// What the device's times are taken with.
    #[must_use]
    pub fn clock(&self) -> Clock {
        if self.queries.is_some() { Clock::Timestamps } else { Clock::Wall }
    }

    /// Measures `ways` ways. `record(way, encoder)` records the work of one; each round has all of them, beginning
    /// with another one each time, so that drift hits all alike.
    ///
    /// # Panics
    /// If the device is lost.
    pub fn interleaved(
        &self,
        ways: usize,
        rounds: Rounds,
        mut record: impl FnMut(usize, &mut wgpu::CommandEncoder),
    ) -> Vec<Times> {
        let mut samples = vec![(Vec::new(), Vec::new()); ways];
        for round in 0..rounds.warm_up + rounds.measured.max(1) {
            for turn in 0..ways {
                let way = (round + turn) % ways;
                let (device, host) = self.once(|encoder| record(way, encoder));
                if round >= rounds.warm_up {
                    samples[way].0.push(device);
                    samples[way].1.push(host);
                }
            }
        }
        samples.into_iter().map(|(device, host)| Times { gpu: Summary::new(device), cpu: Summary::new(host) }).collect()
    }

    /// Times of the device and of the host for recording and doing something once.
    ///
    /// # Panics
    /// If the device is lost.
    pub fn once(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> (Duration, Duration) {
        // What is left over from before must not count.
        self.gpu.wait();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let Some(queries) = &self.queries {
            encoder.write_timestamp(&queries.set, 0);
        }
        let started = Instant::now();
        record(&mut encoder);
        let recorded = started.elapsed();
        if let Some(queries) = &self.queries {
            queries.end(&mut encoder);
        }
        let finishing = Instant::now();
        let commands = encoder.finish();
        let host = recorded + finishing.elapsed();
        let submitted = Instant::now();
        self.gpu.queue.submit([commands]);
        self.gpu.wait();
        let wall = submitted.elapsed();
        let device = self.queries.as_ref().map_or(wall, |queries| queries.read(self.gpu));
        (device, host)
    }
}

impl Queries {
    fn new(device: &wgpu::Device) -> Self {
        let set = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("dual_paraboloid::compare::timing"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        Self { set, resolved: crate::gpu::buffer(device, "compare::timing", 16, usage) }
    }

    fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.write_timestamp(&self.set, 1);
        encoder.resolve_query_set(&self.set, 0..2, &self.resolved, 0);
    }

    fn read(&self, gpu: &Gpu) -> Duration {
        let ticks: Vec<u64> = gpu.read(&self.resolved);
        let nanoseconds = ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(gpu.queue.get_timestamp_period());
        Duration::from_nanos(nanoseconds as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries() {
        let of = |times: &[u64]| Summary::new(times.iter().map(|&t| Duration::from_millis(t)).collect());
        assert_eq!(of(&[]), Summary::default());
        let odd = of(&[5, 1, 3]);
        assert_eq!([odd.median, odd.min, odd.max], [3, 1, 5].map(Duration::from_millis));
        assert_eq!(of(&[4, 2]).median, Duration::from_millis(4));
    }
}
