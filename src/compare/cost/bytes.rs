//! What a method takes on the GPU, by what it is for.

use serde::{Deserialize, Serialize};

use super::super::baselines::{Baseline, DeviceScene};

/// Bytes on the GPU, in three parts that grow with different things.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Bytes {
    /// Of each light: its map and what the lookup reads beside it.
    pub per_light: u64,
    /// Of the scene, and of this method alone: copies in world space, chunks.
    pub scene: u64,
    /// What making maps takes while it lasts, shared by all lights.
    pub workspace: u64,
}

/// For how many lights one method takes no more bytes than another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BreakEven {
    /// From one light on.
    Always,
    /// From so many lights on.
    From(u64),
    /// Up to so many lights.
    UpTo(u64),
    /// For no number of lights.
    Never,
}

impl Bytes {
    /// Of a map that was recorded from these casters.
    #[must_use]
    pub fn of(baseline: &Baseline, casters: &DeviceScene) -> Self {
        Self {
            per_light: baseline.bytes_per_light(),
            scene: baseline.bytes_scene(casters),
            workspace: baseline.bytes_workspace(),
        }
    }

    /// All bytes with `lights` lights.
    #[must_use]
    pub fn total(self, lights: u64) -> u64 {
        self.per_light * lights + self.scene + self.workspace
    }

    /// For how many lights this is no more than `other`.
    #[must_use]
    pub fn break_even(self, other: Self) -> BreakEven {
        let fits_one = self.total(1) <= other.total(1);
        let (own, others) = (self.total(0), other.total(0));
        if self.per_light <= other.per_light {
            let (gain, debt) = (other.per_light - self.per_light, own.saturating_sub(others));
            return match debt.checked_div(gain) {
                _ if fits_one => BreakEven::Always,
                None => BreakEven::Never,
                Some(_) => BreakEven::From(debt.div_ceil(gain)),
            };
        }
        if fits_one { BreakEven::UpTo((others - own) / (self.per_light - other.per_light)) } else { BreakEven::Never }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(per_light: u64, scene: u64, workspace: u64) -> Bytes {
        Bytes { per_light, scene, workspace }
    }

    #[test]
    fn break_even_is_where_the_lines_cross() {
        // 10 n + 100 against 30 n + 5: less from 4.75 lights on.
        assert_eq!(bytes(10, 60, 40).break_even(bytes(30, 0, 5)), BreakEven::From(5));
        assert_eq!(bytes(30, 0, 5).break_even(bytes(10, 60, 40)), BreakEven::UpTo(4));
        // 10 n + 100 against 20 n + 50: equal at 5.
        assert_eq!(bytes(10, 100, 0).break_even(bytes(20, 50, 0)), BreakEven::From(5));
        assert_eq!(bytes(20, 50, 0).break_even(bytes(10, 100, 0)), BreakEven::UpTo(5));
    }

    #[test]
    fn some_methods_never_break_even() {
        assert_eq!(bytes(10, 1, 0).break_even(bytes(10, 0, 0)), BreakEven::Never);
        assert_eq!(bytes(11, 1, 0).break_even(bytes(10, 0, 0)), BreakEven::Never);
        assert_eq!(bytes(11, 0, 0).break_even(bytes(10, 0, 0)), BreakEven::Never);
        assert_eq!(bytes(10, 0, 0).break_even(bytes(10, 0, 0)), BreakEven::Always);
        assert_eq!(bytes(8, 1, 0).break_even(bytes(10, 0, 0)), BreakEven::Always);
    }
}
