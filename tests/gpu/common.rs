//! The shared device, and shorthands over it.

use dual_paraboloid::compare::fill;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::procedural::shapes;
use dual_paraboloid::compare::scene::{Scene, SceneMesh};
use dual_paraboloid::{
    CasterMesh, Casters, Indices, InstanceId, LightId, MeshId, PointLight, PointShadows, PointShadowsDescriptor, Sides,
    Tuning, Workgroups,
};
use glam::{Affine3A, Vec2, Vec3};
use std::sync::OnceLock;

/// The device of all tests.
pub fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::new(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}")))
}

/// Triangles without shared vertices, as casters.
pub fn soup(triangles: &[[Vec3; 3]], sides: Sides) -> Casters {
    let mut casters = Casters::new(&gpu().device).unwrap();
    if !triangles.is_empty() {
        let positions: Vec<[f32; 3]> = triangles.iter().flatten().map(|p| p.to_array()).collect();
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        let mesh = CasterMesh { positions: &positions, indices: Indices::U32(&indices), sides, ..Default::default() };
        let mesh = casters.add_mesh(&mesh).unwrap();
        casters.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    casters
}

/// A scene's casters.
pub fn filled(scene: &Scene) -> Casters {
    let mut casters = Casters::new(&gpu().device).unwrap();
    fill(&mut casters, gpu(), scene, Sides::Auto).unwrap();
    casters
}

/// Triangles without shared vertices, as a mesh of a scene.
pub fn mesh_of(triangles: &[[Vec3; 3]]) -> SceneMesh {
    let positions: Vec<[f32; 3]> = triangles.as_flattened().iter().map(|p| p.to_array()).collect();
    SceneMesh { indices: (0..positions.len() as u32).collect(), positions, ..SceneMesh::default() }
}

/// So many spheres of 320 triangles in rows.
pub fn add_spheres(casters: &mut Casters, count: usize) -> (MeshId, Vec<InstanceId>) {
    let sphere = shapes::icosphere(0.3, 2);
    let mesh = CasterMesh {
        positions: &sphere.positions,
        indices: Indices::U32(&sphere.indices),
        sides: Sides::Both,
        ..Default::default()
    };
    let mesh = casters.add_mesh(&mesh).unwrap();
    let place = |k: usize| Vec3::new((k % 100) as f32, (k / 100) as f32, 2.0);
    let add = |k| casters.add_instance(mesh, Affine3A::from_translation(place(k))).unwrap();
    (mesh, (0..count).map(add).collect())
}

/// Shadows for one light.
pub fn descriptor(resolution: u32) -> PointShadowsDescriptor {
    PointShadowsDescriptor { resolution, capacity: 1, ..Default::default() }
}

/// Shadows with one light, recorded.
pub fn record(mut shadows: PointShadows, casters: &mut Casters, light: PointLight) -> (PointShadows, LightId) {
    let id = shadows.add(light).unwrap();
    let made = gpu().submit(|encoder| shadows.record(&gpu().device, &gpu().queue, encoder, casters)).unwrap();
    gpu().wait();
    assert_eq!(made, 1);
    (shadows, id)
}

/// A light's map from the library as users have it.
pub fn map(casters: &mut Casters, light: PointLight, resolution: u32) -> Map {
    let shadows = PointShadows::new(&gpu().device, &descriptor(resolution)).unwrap();
    let (shadows, id) = record(shadows, casters, light);
    Map::read(&shadows, id)
}

/// A light's map that no triangle of closed pieces is left out of.
pub fn unculled_map(casters: &mut Casters, light: PointLight, resolution: u32) -> Map {
    let tuning = Tuning { reject: false, ..Tuning::of(&gpu().device) };
    let shadows = PointShadows::tuned(&gpu().device, &descriptor(resolution), &tuning).unwrap();
    let (shadows, id) = record(shadows, casters, light);
    Map::read(&shadows, id)
}

/// Makes one map after another, with the stages set to work in some way.
pub struct Rasteriser {
    pub name: &'static str,
    pub shadows: PointShadows,
}

impl Rasteriser {
    pub fn new((name, tuning): (&'static str, Tuning), resolution: u32) -> Self {
        let shadows = PointShadows::tuned(&gpu().device, &descriptor(resolution), &tuning).unwrap();
        Self { name, shadows }
    }

    /// One for each tuning.
    pub fn all(tunings: Vec<(&'static str, Tuning)>, resolution: u32) -> Vec<Self> {
        tunings.into_iter().map(|tuning| Self::new(tuning, resolution)).collect()
    }

    pub fn map(&mut self, casters: &mut Casters, light: PointLight) -> Map {
        let Self { shadows, .. } = self;
        let id = shadows.add(light).unwrap();
        let made = gpu().submit(|encoder| shadows.record(&gpu().device, &gpu().queue, encoder, casters)).unwrap();
        assert_eq!(made, 1);
        let map = Map::read(shadows, id);
        shadows.remove(id).unwrap();
        map
    }
}

/// As it is best for the device.
pub fn tuning() -> Tuning {
    Tuning::of(&gpu().device)
}

/// All ways to share triangles out between what is drawn at once and what the tiles draw, and without room for them.
pub fn tunings() -> Vec<(&'static str, Tuning)> {
    let gpu = Tuning { workgroups: Workgroups::Gpu, ..tuning() };
    let software = Tuning { workgroups: Workgroups::Software, ..tuning() };
    let (all_small, all_large) = (Some(100_000), Some(0));
    vec![
        ("GPU's", gpu),
        ("GPU's, all small", Tuning { small: all_small, ..gpu }),
        ("GPU's, all large", Tuning { small: all_large, ..gpu }),
        ("GPU's, small to 5 texels", Tuning { small: Some(5), ..gpu }),
        ("GPU's, one record", Tuning { small: all_large, records: Some(1), ..gpu }),
        ("GPU's, one entry a tile", Tuning { small: all_large, room: 1, ..gpu }),
        ("software's", software),
        ("software's, all small", Tuning { small: all_small, ..software }),
        ("software's, all large", Tuning { small: all_large, ..software }),
        ("software's, small to 20 texels", Tuning { small: Some(20), ..software }),
        ("software's, one record", Tuning { small: all_large, records: Some(1), ..software }),
        ("software's, one entry a tile", Tuning { small: all_large, room: 1, ..software }),
    ]
}

/// A pair of maps, read back.
pub struct Map {
    pub depth: Vec<f32>,
    pub numbers: Vec<u32>,
    pub resolution: u32,
    pub half_width: f32,
}

/// A texel of a pair of maps.
#[derive(Debug, Clone, Copy)]
pub struct Texel {
    pub back: bool,
    /// Its centre in map coordinates.
    pub p: Vec2,
    pub depth: f32,
    /// Of its triangle, or [`NO_NUMBER`](dual_paraboloid::compare::numbered::NO_NUMBER).
    pub number: u32,
}

impl Map {
    pub fn read(shadows: &PointShadows, light: LightId) -> Self {
        let resolution = shadows.maps().height();
        let numbers = gpu().read_texture(shadows.numbers(), light.index());
        Self { depth: gpu().read_map(shadows, light), numbers, resolution, half_width: shadows.half_width() }
    }

    /// Width of a texel in map coordinates.
    pub fn texel(&self) -> f32 {
        2.0 * self.half_width / self.resolution as f32
    }

    /// The texels whose centres are within `radius` of the middle of their map.
    pub fn within(&self, radius: f32) -> impl Iterator<Item = Texel> {
        self.texels().filter(move |texel| texel.p.length() <= radius)
    }

    /// All texels, row by row.
    pub fn texels(&self) -> impl Iterator<Item = Texel> {
        let size = self.resolution;
        (0..2 * size * size).map(move |index| {
            let (column, j) = (index % (2 * size), index / (2 * size));
            self.texel_at(column >= size, column % size, j)
        })
    }

    /// The texel in a column and a row of a hemisphere's map.
    pub fn texel_at(&self, back: bool, i: u32, j: u32) -> Texel {
        let half = 0.5 * self.resolution as f32;
        let p = Vec2::new(i as f32 + 0.5 - half, half - j as f32 - 0.5) * self.texel();
        let index = ((2 * j + u32::from(back)) * self.resolution + i) as usize;
        Texel { back, p, depth: self.depth[index], number: self.numbers[index] }
    }

    /// Both discs with their guard bands, less one texel.
    pub fn discs(&self) -> impl Iterator<Item = Texel> {
        self.within((self.half_width - self.texel()).max(1e-3))
    }

    /// Texels within the discs, guard band included, in which two maps differ in any bit.
    pub fn differences(&self, other: &Self) -> Vec<(Texel, f32)> {
        let pairs = self.within(self.half_width).zip(other.within(self.half_width));
        pairs.filter(|(a, b)| a.depth.to_bits() != b.depth.to_bits()).map(|(a, b)| (a, b.depth)).collect()
    }
}

/// The eight corners' quads of a box, two triangles each, seen from inside.
pub fn box_inside(low: Vec3, high: Vec3) -> Vec<[Vec3; 3]> {
    let corner = |k: usize| {
        Vec3::new(
            if k & 1 == 0 { low.x } else { high.x },
            if k & 2 == 0 { low.y } else { high.y },
            if k & 4 == 0 { low.z } else { high.z },
        )
    };
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let quad = |f: [usize; 4]| {
        let [a, b, c, d] = f.map(corner);
        [[a, b, c], [a, c, d]]
    };
    faces.into_iter().flat_map(quad).collect()
}
