//! Holes in the reference's triangles: the alpha test of `shaders/mask.wgsl`, in double precision.

use glam::{DVec2, DVec3};

use crate::Mask;

/// Where a texture lets light through; a twin of `Mask` in the shader.
#[derive(Clone, Debug)]
pub struct AlphaMask {
    width: u32,
    alphas: Vec<u8>,
    /// In 255ths, as the shader has it.
    cutoff: f32,
    address_modes: [wgpu::AddressMode; 2],
}

impl AlphaMask {
    /// Reads the alpha of an image. The other values are those of [`Mask`].
    #[must_use]
    pub fn new(image: &image::RgbaImage, cutoff: f32, address_modes: [wgpu::AddressMode; 2]) -> Self {
        let alphas = image.pixels().map(|pixel| pixel.0[3]).collect();
        Self { width: image.width(), alphas, cutoff: Mask::byte_cutoff(cutoff), address_modes }
    }

    /// Whether nothing casts at texture coordinates.
    #[must_use]
    pub fn is_hole(&self, coordinates: DVec2) -> bool {
        let size = [self.width, self.alphas.len() as u32 / self.width];
        let [columns, rows] = [0, 1].map(|axis| {
            let at = coordinates[axis] * f64::from(size[axis]) - 0.5;
            let place = |k: f64| texel_place(at.floor() + k, size[axis], self.address_modes[axis]);
            (place(0.0), place(1.0), at - at.floor())
        });
        let alpha = |column: u32, row: u32| f64::from(self.alphas[(row * self.width + column) as usize]);
        let across = |row| between(alpha(columns.0, row), alpha(columns.1, row), columns.2);
        between(across(rows.0), across(rows.1), rows.2) < f64::from(self.cutoff)
    }
}

fn between(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}

/// The texel that a place on the line of texels shows, as the specification of WebGPU has it for samplers.
fn texel_place(place: f64, size: u32, mode: wgpu::AddressMode) -> u32 {
    let size = f64::from(size);
    let place = match mode {
        wgpu::AddressMode::Repeat => place.rem_euclid(size),
        wgpu::AddressMode::MirrorRepeat => {
            let turn = place.rem_euclid(2.0 * size);
            if turn < size { turn } else { 2.0 * size - 1.0 - turn }
        }
        wgpu::AddressMode::ClampToEdge | wgpu::AddressMode::ClampToBorder => place.clamp(0.0, size - 1.0),
    };
    place as u32
}

/// The masks of a scene, and which triangles have which.
#[derive(Clone, Debug, Default)]
pub struct CutOuts {
    /// The masks.
    pub masks: Vec<AlphaMask>,
    /// One for each triangle, or none at all: the mask of one that may have holes, and its corners' texture
    /// coordinates.
    pub triangles: Vec<Option<(u32, [DVec2; 3])>>,
}

impl CutOuts {
    /// Whether the ray from the origin along `direction` goes through a hole where it meets a triangle, given by its
    /// corners too.
    pub(super) fn is_hole(&self, triangle: u32, corners: &[DVec3; 3], direction: DVec3) -> bool {
        let Some(Some((mask, [u, v, w]))) = self.triangles.get(triangle as usize) else { return false };
        let [a, b, c] = *corners;
        let weights = DVec3::new(b.cross(c).dot(direction), c.cross(a).dot(direction), a.cross(b).dot(direction));
        let weights = weights / weights.element_sum();
        self.masks[*mask as usize].is_hole(*u * weights.x + *v * weights.y + *w * weights.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(alphas: [u8; 4], mode: wgpu::AddressMode) -> AlphaMask {
        let image = image::RgbaImage::from_fn(4, 1, |column, _| image::Rgba([0, 0, 0, alphas[column as usize]]));
        AlphaMask::new(&image, 0.5, [mode; 2])
    }

    /// Texels' middles along a line, from two textures before the texture on.
    fn holes(mode: wgpu::AddressMode) -> String {
        let mask = row([255, 0, 255, 255], mode);
        let at = |place: i32| DVec2::new((f64::from(place) + 0.5) / 4.0, 7.3);
        (-8..8).map(|place| if mask.is_hole(at(place)) { '.' } else { '#' }).collect()
    }

    #[test]
    fn textures_go_on_past_their_edges() {
        assert_eq!(holes(wgpu::AddressMode::Repeat), "#.###.###.###.##");
        assert_eq!(holes(wgpu::AddressMode::MirrorRepeat), "#.####.##.####.#");
        assert_eq!(holes(wgpu::AddressMode::ClampToEdge), "#########.######");
    }

    #[test]
    fn alpha_is_filtered_and_an_even_one_is_not_below_itself() {
        let mask = row([255, 0, 0, 255], wgpu::AddressMode::Repeat);
        let at = |texels: f64| mask.is_hole(DVec2::new(texels / 4.0, 0.0));
        assert!(!at(0.99) && at(1.01) && at(2.99) && !at(3.01));
        for byte in [1, 51, 128, 255] {
            let image = image::RgbaImage::from_pixel(3, 2, image::Rgba([0, 0, 0, byte]));
            let mask = |cutoff| AlphaMask::new(&image, cutoff, [wgpu::AddressMode::Repeat; 2]);
            let cutoff = f32::from(byte) / 255.0;
            for place in 0..100 {
                let at = DVec2::new(0.123, 0.457) * f64::from(place);
                assert!(!mask(cutoff).is_hole(at) && mask((cutoff + 0.01).min(1.01)).is_hole(at));
            }
        }
    }

    #[test]
    fn a_ray_finds_its_place_in_the_triangle() {
        let corners = [DVec3::new(-1.0, -1.0, -2.0), DVec3::new(3.0, -1.0, -5.0), DVec3::new(-1.0, 2.0, -3.0)];
        let coordinates = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let masks = vec![row([255, 0, 0, 255], wgpu::AddressMode::Repeat)];
        let cut_outs = CutOuts { masks, triangles: vec![Some((0, coordinates))] };
        for share in [0.05, 0.2, 0.3, 0.45, 0.55, 0.7, 0.8, 0.9] {
            let along = corners[0].lerp(corners[1], share);
            let point = along.lerp(corners[2], 0.05 * (1.0 - share));
            let weight = share * (1.0 - 0.05 * (1.0 - share));
            let hole = (0.25..0.75).contains(&weight);
            assert_eq!(cut_outs.is_hole(0, &corners, point.normalize()), hole, "{share}");
        }
    }
}
