//! The rasteriser against its twin in double precision, and against itself where its parts meet.

use crate::common::{Map, Rasteriser, descriptor, gpu, record, soup, tuning, tunings};
use crate::culling::random_soup;
use crate::twin::{Judgement, Twin};
use dual_paraboloid::{PointLight, Sides};
use glam::{Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Holds the maps of triangles by every tuning against the twin.
fn assert_exact(name: &str, triangles: &[[Vec3; 3]], light: PointLight, rasterisers: &mut [Rasteriser]) {
    let twin = Twin::of_soup(triangles, &light);
    let mut casters = soup(triangles, Sides::Auto);
    for rasteriser in rasterisers {
        let map = rasteriser.map(&mut casters, light);
        let judgement = twin.judge(&map);
        println!("{name}, {}: {judgement:?}", rasteriser.name);
    }
}

fn turned(rng: &mut Pcg64) -> PointLight {
    let orientation = crate::hard_cases::orientation(rng);
    PointLight { orientation, range: 100.0, ..Default::default() }
}

#[test]
fn random_scenes() {
    let mut rng = Pcg64::seed_from_u64(3);
    for (count, resolution) in [(10, 64), (300, 128), (3000, 256)] {
        let mut rasterisers = Rasteriser::all(tunings(), resolution);
        let light = turned(&mut rng);
        let started = std::time::Instant::now();
        assert_exact(&format!("{count} triangles"), &random_soup(&mut rng, count), light, &mut rasterisers);
        println!("took {:?}", started.elapsed());
    }
}
