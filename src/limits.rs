//! What a device has to have.

use crate::Error;

/// What the library needs of a device, and the least of it.
macro_rules! needed {
    ($($limit:ident: $least:expr,)*) => {
        /// The limits to request a device with at least. All that the library doesn't need are those of
        /// [`wgpu::Limits::downlevel_webgl2_defaults`], so take the better of these and your own:
        /// [`wgpu::Limits::or_better_values_from`]. WebGPU's defaults ([`wgpu::Limits::default`]) are enough.
        ///
        /// With larger `max_storage_buffer_binding_size` and `max_buffer_size` there may be more casters, with a larger
        /// `max_texture_dimension_2d` and more `max_texture_array_layers` larger maps and more lights. What reads maps in a
        /// renderer's own stages counts there too, four storage buffers among it.
        ///
        /// ```
        /// let own = wgpu::Limits { max_vertex_buffers: 12, ..Default::default() };
        /// let limits = dual_paraboloid::required_limits().or_better_values_from(&own);
        /// assert!(limits.max_vertex_buffers == 12 && limits.max_storage_buffers_per_shader_stage >= 8);
        /// ```
        #[must_use]
        pub fn required_limits() -> wgpu::Limits {
            wgpu::Limits { $($limit: $least,)* ..wgpu::Limits::downlevel_webgl2_defaults() }
        }

        /// Names the first of a device's limits that is too low.
        pub(crate) fn check(limits: &wgpu::Limits) -> Result<(), Error> {
            let required = required_limits();
            $(if limits.$limit < required.$limit {
                let (value, needed) = (u64::from(limits.$limit), u64::from(required.$limit));
                return Err(Error::LimitTooLow { limit: stringify!($limit), value, needed });
            })*
            Ok(())
        }

        /// A device's limits, one each of those that are needed lowered by one, with its name.
        #[cfg(feature = "compare")]
        #[doc(hidden)]
        #[must_use]
        pub fn limits_one_too_low() -> Vec<(&'static str, wgpu::Limits)> {
            vec![$((stringify!($limit), wgpu::Limits { $limit: required_limits().$limit - 1, ..required_limits() }),)*]
        }
    };
}

needed! {
    max_bind_groups: 2,
    max_dynamic_uniform_buffers_per_pipeline_layout: 1,
    max_sampled_textures_per_shader_stage: 3,
    max_storage_buffers_per_shader_stage: 8,
    max_storage_textures_per_shader_stage: 2,
    max_uniform_buffers_per_shader_stage: 1,
    max_uniform_buffer_binding_size: 2048,
    // The depths of the widest maps.
    max_storage_buffer_binding_size: 128 << 20,
    max_buffer_size: 128 << 20,
    max_compute_workgroup_storage_size: 16_384,
    max_compute_invocations_per_workgroup: 256,
    max_compute_workgroup_size_x: 256,
    max_compute_workgroup_size_y: 8,
    max_compute_workgroup_size_z: 1,
    max_compute_workgroups_per_dimension: 65_535,
}

/// The optional features to request a device with: none.
#[must_use]
pub const fn required_features() -> wgpu::Features {
    wgpu::Features::empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_webgpu_gives_without_asking_is_enough() {
        assert_eq!(check(&wgpu::Limits::default()), Ok(()));
        assert_eq!(check(&required_limits()), Ok(()));
    }

    #[test]
    fn lower_limits_are_named() {
        let downlevel = check(&wgpu::Limits::downlevel_defaults()).unwrap_err();
        let expected = Error::LimitTooLow { limit: "max_storage_buffers_per_shader_stage", value: 4, needed: 8 };
        assert_eq!(downlevel, expected);
        assert!(downlevel.to_string().contains("max_storage_buffers_per_shader_stage is 4"), "{downlevel}");
        assert!(check(&wgpu::Limits::downlevel_webgl2_defaults()).is_err());
    }
}
