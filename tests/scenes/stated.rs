//! The numbers of every test scene.

/// What the source of a scene says about it.
pub struct Stated {
    pub file: &'static str,
    /// Drawn triangles, instances counted.
    pub triangles: usize,
    /// One per primitive of each placed mesh.
    pub instances: usize,
    /// Of those, with a negative determinant.
    pub mirrored: usize,
    pub low: [f32; 3],
    pub high: [f32; 3],
    pub point_lights: usize,
    pub images: usize,
    /// Materials with an alpha mask, and with blending.
    pub mask_blend: [usize; 2],
}

impl Stated {
    /// The file's name without its extension.
    pub fn name(&self) -> &'static str {
        self.file.trim_end_matches(".glb")
    }
}

const fn stated(file: &'static str, triangles: usize, instances: usize, low: [f32; 3], high: [f32; 3]) -> Stated {
    Stated { file, triangles, instances, mirrored: 0, low, high, point_lights: 0, images: 0, mask_blend: [0, 0] }
}

pub const SCENES: &[Stated] = &[
    // One mesh of 206 primitives.
    stated("interior_pandora.glb", 60_694, 206, [-36.8, 0.0, -20.8], [36.8, 22.4, 20.8]),
    stated("gallery_vr.glb", 1_930, 1, [-5.058, -0.002, -5.058], [5.058, 5.052, 5.061]),
    stated("fog_arcade_bevy.glb", 360, 1, [-3.16, 0.016, -6.742], [3.16, 6.322, 6.742]),
    Stated { mask_blend: [0, 1], ..stated("cornell_nvpro.glb", 16_732, 10, [-5.05, -5.05, -5.05], [5.05, 5.05, 5.0]) },
    // 20 placed meshes of 60 primitives.
    stated("town_godot.glb", 30_477, 60, [-1024.0, -4.64, -1024.0], [1024.0, 17.756, 1024.0]),
    stated("barn_lamp.glb", 10_203, 3, [-0.105, -0.198, 0.0], [0.086, 0.057, 0.227]),
    stated("carbon_cage.glb", 215_579, 3, [-7.138, -6.365, -6.943], [6.865, 7.29, 6.943]),
    Stated {
        images: 1,
        mask_blend: [1, 0],
        ..stated("dutch_ship.glb", 69_162, 3, [-10.326, -2.0, -3.488], [13.745, 22.657, 3.321])
    },
    Stated {
        images: 1,
        mask_blend: [1, 0],
        ..stated("house_masked.glb", 10_497, 2, [-0.251, -0.002, -0.252], [0.251, 0.185, 0.252])
    },
    Stated { images: 3, mask_blend: [3, 1], ..stated("alpha_modes.glb", 61, 9, [-4.3, -0.1, -0.75], [4.3, 2.3, 0.55]) },
    // 70 placed meshes of 87 primitives, every one mirrored.
    Stated { mirrored: 87, ..stated("mirrored_props.glb", 23_388, 87, [-11.0, -9.714, -11.0], [11.0, 0.486, 11.0]) },
    stated("teapots_expanded.glb", 7_656_770, 1_900, [-339.411, 0.0, -339.411], [339.411, 13.298, 339.411]),
    Stated { mask_blend: [0, 1], ..stated("flight_helmet.glb", 94_722, 6, [-0.204, 0.0, -0.172], [0.163, 0.716, 0.2]) },
    stated("head_lps.glb", 17_684, 1, [-0.221, 0.0, -0.084], [0.232, 0.421, 0.19]),
    Stated {
        point_lights: 3,
        ..stated("lights_level_blenvy.glb", 306, 5, [-46.768, -0.804, -46.768], [46.768, 3.069, 46.768])
    },
];
