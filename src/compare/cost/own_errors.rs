//! This library's errors by all definitions, and what its maps allow.

use serde::{Deserialize, Serialize};

use crate::PointLight;
use crate::compare::baselines::{Baseline, BaselineError, DeviceScene, Lookup, Method};
use crate::compare::error_figures::{CreaseError, MapError, ShadowError, map_error};
use crate::compare::gpu::Gpu;
use crate::compare::ideal::{MapGeometry, ideal_map};
use crate::compare::measure::{PixelErrors, Pixels, Truth};
use crate::compare::walk::{IdealWalks, STEPS};

/// This library's figures at one resolution, in the light's own orientation and with the scene's holes.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct OwnErrors {
    /// Texels across each map of the pair.
    pub resolution: u32,
    /// Of the map's texels.
    pub map: MapError,
    /// Of the frozen lookup [`votes_v1`](Truth::votes_v1) on the ray-cast map.
    pub ideal: ShadowError,
    /// Of the library's own rule in double precision on that map.
    pub rule: ShadowError,
    /// Of each lookup that reads the map; the library's own first.
    pub lookups: Vec<OwnLookup>,
}

/// How wrong a lookup is in the library's map.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct OwnLookup {
    /// The lookup.
    pub lookup: Lookup,
    /// At the receivers.
    pub shadow: ShadowError,
    /// Receivers at which this lookup and the ideal decide differently, in parts per million.
    pub disagree_ppm: f64,
    /// In lit creases; `None` where there are none.
    pub creases: Option<CreaseError>,
    /// At the camera's pixels; `None` where none counts.
    pub pixels: Option<PixelErrors>,
}

impl OwnErrors {
    /// Records the light's map of these casters and judges it and all lookups that read it. `walks` are of the same scene.
    ///
    /// # Errors
    /// [`BaselineError`], for a resolution that the device doesn't allow or a light that isn't valid.
    pub fn find(
        gpu: &Gpu,
        truth: &Truth,
        walks: &IdealWalks,
        pixels: &Pixels,
        casters: &mut DeviceScene,
        light: &PointLight,
        resolution: u32,
    ) -> Result<Self, BaselineError> {
        let mut pair = Baseline::new(&gpu.device, Method::Paraboloid, resolution)?;
        gpu.submit(|encoder| pair.record(&gpu.device, &gpu.queue, encoder, casters, light))?;
        let guard = pair.shadows().map_or(0.0, |shadows| f64::from(shadows.half_width()) - 1.0);
        let map = ideal_map(&truth.reference, &truth.view, MapGeometry { resolution, guard });
        let ideal = truth.votes_v1(&map);
        let rule = truth.judge(&walks.shadows(truth, &map, STEPS));
        let receivers = truth.inputs();
        let of_lookup = |&lookup: &Lookup| {
            let values = pair.shadow_values(gpu, lookup, &receivers)?;
            Some(OwnLookup {
                lookup,
                shadow: truth.judge(&values),
                disagree_ppm: truth.disagree_ppm(&values, &ideal),
                creases: truth.crease_error(&values),
                pixels: pixels.errors(gpu, &pair, lookup),
            })
        };
        let lookups = Method::Paraboloid.lookups().iter().filter_map(of_lookup).collect();
        let stored: Vec<f32> = gpu.read_texture(pair.map(), 0);
        let map = map_error(&stored, &map, &truth.reference, &truth.view);
        Ok(Self { resolution, map, ideal: truth.judge(&ideal), rule, lookups })
    }

    /// The figures of the library's own lookup.
    #[must_use]
    pub fn own(&self) -> Option<&OwnLookup> {
        self.lookups.first()
    }
}
