//! All figures of one scene, and this library held against another method in it.

use serde::{Deserialize, Serialize};

use super::{BreakEven, Bytes, Cost, Curve, ErrorPair, OwnErrors, Point, Ratio, Reading, Rule, Timed, shown_error};
use crate::compare::baselines::{Budget, Lookup, Method};

/// Where a scene comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// A file: a real scene.
    File,
    /// Made in code.
    Code,
}

impl Origin {
    /// What a scene of this name counts as in means over scenes: the `dense` scenes made in code are one scene of several
    /// sizes, and count once.
    #[must_use]
    pub fn family(self, scene: &str) -> &str {
        if self == Self::Code && scene.starts_with("dense-") { "dense" } else { scene }
    }
}

/// A method with one of its lookups.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub struct Contestant {
    /// What makes the map.
    pub method: Method,
    /// What reads it.
    pub lookup: Lookup,
}

impl Contestant {
    /// This library.
    pub const OWN: Self = Self { method: Method::Paraboloid, lookup: Lookup::Paraboloid };

    /// The name for reports.
    #[must_use]
    pub fn name(self) -> String {
        if self == Self::OWN {
            return "this library".to_owned();
        }
        let (method, lookup) = (self.method.name(), self.lookup.name());
        if method == lookup { method.to_owned() } else { format!("{method}: {lookup}") }
    }
}

/// All figures of one scene under one rule.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct SceneCosts {
    /// The scene's name.
    pub scene: String,
    /// Where it comes from.
    pub origin: Origin,
    /// Its triangles, instances counted.
    pub triangles: usize,
    /// Which sides cast.
    pub rule: Rule,
    /// Of all methods and resolutions.
    pub costs: Vec<Cost>,
    /// This library's errors by all definitions, at the resolutions where they were looked into; none under
    /// [`Rule::Culled`].
    pub own: Vec<OwnErrors>,
    /// What the device can't do, each with the reason.
    pub left_out: Vec<String>,
}

impl SceneCosts {
    /// What the scene counts as in means over scenes, see [`Origin::family`].
    #[must_use]
    pub fn family(&self) -> &str {
        self.origin.family(&self.scene)
    }

    /// All methods with all their lookups, in the order in which they were measured.
    #[must_use]
    pub fn contestants(&self) -> Vec<Contestant> {
        let mut found = Vec::new();
        for cost in &self.costs {
            let lookups = cost.lookups.iter().map(|of| Contestant { method: cost.method, lookup: of.lookup });
            let new: Vec<Contestant> = lookups.filter(|of| !found.contains(of)).collect();
            found.extend(new);
        }
        found
    }

    /// A method's figures at one size. The budget matters for cubes alone.
    #[must_use]
    pub fn find(&self, method: Method, budget: Budget, pair: u32) -> Option<&Cost> {
        let fits =
            |cost: &&Cost| cost.method == method && cost.pair == pair && (cost.budget == budget || !method.is_cube());
        self.costs.iter().find(fits)
    }

    /// Time in milliseconds against shown error, over the ladder at equal texels, the smallest map first.
    #[must_use]
    pub fn time_points(&self, of: Contestant, timed: Timed) -> Vec<Point> {
        self.points(of, |cost| cost.time(of.lookup, timed))
    }

    /// Bytes for each light against shown error, over the ladder at equal texels, the smallest map first.
    #[must_use]
    pub fn byte_points(&self, of: Contestant) -> Vec<Point> {
        self.points(of, |cost| Some(cost.bytes.per_light as f64))
    }

    fn points(&self, of: Contestant, value: impl Fn(&Cost) -> Option<f64>) -> Vec<Point> {
        let on_ladder = |cost: &&Cost| cost.method == of.method && cost.budget == Budget::EqualTexels;
        let mut costs: Vec<&Cost> = self.costs.iter().filter(on_ladder).collect();
        costs.sort_by_key(|cost| cost.side);
        let point = |cost: &Cost| Some(Point { cost: value(cost)?, error: error(cost, of.lookup)? });
        costs.into_iter().filter_map(point).collect()
    }

    /// This library's time over another's at equal texels.
    #[must_use]
    pub fn at_equal_size(&self, method: Method, budget: Budget, pair: u32) -> Option<Ratio> {
        let own = self.find(Method::Paraboloid, budget, pair)?;
        Some(Ratio::Exact(own.milliseconds() / self.find(method, budget, pair)?.milliseconds()))
    }

    /// This library's time over another's where both are equally wrong: [`Curve::at_equal_error`] over the ladder.
    #[must_use]
    pub fn at_equal_error(&self, other: Contestant, timed: Timed) -> Option<Ratio> {
        let curve = |of| Curve::new(&self.time_points(of, timed));
        curve(Contestant::OWN).at_equal_error(&curve(other))
    }

    /// This library's time at one size over the other's for the error that it has there: what as good an answer costs
    /// otherwise.
    #[must_use]
    pub fn at_own_error(&self, other: Contestant, timed: Timed, pair: u32) -> Option<Ratio> {
        let own = self.find(Method::Paraboloid, Budget::EqualTexels, pair)?;
        let curve = Curve::new(&self.time_points(other, timed));
        let reading = curve.cost_at(error(own, Contestant::OWN.lookup)?)?;
        Some(Ratio::over(own.time(Contestant::OWN.lookup, timed)?, reading))
    }

    /// This library's bytes for each light at one size over the other's for the error that it has there.
    #[must_use]
    pub fn bytes_at_own_error(&self, other: Contestant, pair: u32) -> Option<Ratio> {
        let own = self.find(Method::Paraboloid, Budget::EqualTexels, pair)?;
        let reading = Curve::new(&self.byte_points(other)).cost_at(error(own, Contestant::OWN.lookup)?)?;
        Some(Ratio::over(own.bytes.per_light as f64, reading))
    }

    /// Both errors at equal texels.
    #[must_use]
    pub fn errors_at_equal_texels(&self, other: Contestant, pair: u32) -> Option<ErrorPair> {
        self.errors_at_texels(pair, other, pair)
    }

    /// The error of this library's map of `own` texels across, and another's at the texels of a pair of `pair`.
    #[must_use]
    pub fn errors_at_texels(&self, own: u32, other: Contestant, pair: u32) -> Option<ErrorPair> {
        let wrong = |of: Contestant, pair| {
            self.find(of.method, Budget::EqualTexels, pair).and_then(|cost| cost.wrong_ppm(of.lookup))
        };
        Some(self.error_pair(wrong(Contestant::OWN, own)?, wrong(other, pair)?))
    }

    /// Both errors where a light takes as many bytes. `None` where the other's curve has no map of so many.
    #[must_use]
    pub fn errors_at_equal_bytes(&self, other: Contestant, pair: u32) -> Option<ErrorPair> {
        let own = self.find(Method::Paraboloid, Budget::EqualTexels, pair)?;
        match Curve::new(&self.byte_points(other)).error_at(own.bytes.per_light as f64)? {
            Reading::Exact(other) => Some(self.error_pair(error(own, Contestant::OWN.lookup)?, other)),
            Reading::AtMost(_) | Reading::AtLeast(_) => None,
        }
    }

    fn error_pair(&self, own_ppm: f64, other_ppm: f64) -> ErrorPair {
        ErrorPair { family: self.family().to_owned(), own_ppm, other_ppm }
    }

    /// For how many lights this library takes no more bytes than another method of as many texels.
    #[must_use]
    pub fn break_even_at_equal_texels(&self, other: Method, pair: u32) -> Option<BreakEven> {
        let bytes = |method| self.find(method, Budget::EqualTexels, pair).map(|cost| cost.bytes);
        Some(bytes(Method::Paraboloid)?.break_even(bytes(other)?))
    }

    /// For how many lights this library takes no more bytes than another method that is as wrong. `None` where the
    /// other's curve doesn't reach that error.
    #[must_use]
    pub fn break_even_at_own_error(&self, other: Contestant, pair: u32) -> Option<BreakEven> {
        let own = self.find(Method::Paraboloid, Budget::EqualTexels, pair)?;
        let others = self.find(other.method, Budget::EqualTexels, pair)?.bytes;
        match Curve::new(&self.byte_points(other)).cost_at(error(own, Contestant::OWN.lookup)?)? {
            Reading::Exact(per_light) => {
                Some(own.bytes.break_even(Bytes { per_light: per_light.round() as u64, ..others }))
            }
            Reading::AtMost(_) | Reading::AtLeast(_) => None,
        }
    }
}

/// The error of a lookup as curves show it.
fn error(cost: &Cost, lookup: Lookup) -> Option<f64> {
    cost.of(lookup).map(|of| shown_error(of.wrong_ppm, of.samples))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::cost::{LookupCost, Ratios, ScreenTime};
    use crate::compare::lookup_cost::PassStage;
    use crate::compare::timing::Summary;
    use approx::assert_relative_eq;
    use std::time::Duration;

    const CUBE: Contestant = Contestant { method: Method::Cube, lookup: Lookup::CubePlane };

    fn summary(milliseconds: u64) -> Summary {
        let median = Duration::from_millis(milliseconds);
        Summary { median, min: median, max: median }
    }

    /// A map of some milliseconds and bytes a light, whose lookups are all as wrong among a million answers, and take 1 ms
    /// in compute and 10 ms in a fragment pass.
    fn cost(method: Method, pair: u32, milliseconds: u64, per_light: u64, wrong_ppm: f64) -> Cost {
        let screen = ScreenTime { width: 2, height: 1, compute: summary(1), fragment: summary(10) };
        let lookup = |&lookup: &Lookup| LookupCost {
            lookup,
            wrong_ppm,
            wrong_front_ppm: wrong_ppm,
            wrong_ppm_by_orientation: vec![wrong_ppm],
            samples: 1_000_000,
            bias: None,
            screens: vec![screen],
        };
        Cost {
            method,
            budget: Budget::EqualTexels,
            pair,
            side: method.side(pair, Budget::EqualTexels),
            texels: 0,
            bytes: Bytes { per_light, scene: if method == Method::Paraboloid { 100 } else { 0 }, workspace: 0 },
            gpu: summary(milliseconds),
            cpu: summary(1),
            runs: 1,
            lookups: method.lookups().iter().map(lookup).collect(),
            stages: None,
        }
    }

    fn scene(name: &str, costs: Vec<Cost>) -> SceneCosts {
        SceneCosts {
            scene: name.to_owned(),
            origin: Origin::Code,
            triangles: 1,
            rule: Rule::DoubleSided,
            costs,
            own: Vec::new(),
            left_out: Vec::new(),
        }
    }

    fn two_methods() -> SceneCosts {
        scene(
            "a",
            vec![
                cost(Method::Paraboloid, 64, 3, 10, 400.0),
                cost(Method::Cube, 64, 1, 10, 1600.0),
                cost(Method::Paraboloid, 128, 4, 40, 100.0),
                cost(Method::Cube, 128, 7, 40, 100.0),
            ],
        )
    }

    #[test]
    fn time_is_the_map_and_a_pass() {
        let costs = two_methods();
        let map = costs.find(Method::Paraboloid, Budget::EqualTexels, 128).unwrap();
        let time = |timed| map.time(Lookup::Paraboloid, timed);
        assert_eq!(time(Timed::Map), Some(4.0));
        assert_eq!(time(Timed::HEADLINE), Some(5.0));
        assert_eq!(time(Timed::Lit { screen: 0, stage: PassStage::Fragment }), Some(14.0));
        assert_eq!(time(Timed::Lit { screen: 1, stage: PassStage::Fragment }), None);
        assert_eq!(map.time(Lookup::CubePlane, Timed::HEADLINE), None);
        assert_eq!(Timed::all(1), [Timed::HEADLINE, Timed::Lit { screen: 0, stage: PassStage::Fragment }, Timed::Map]);
    }

    #[test]
    fn at_the_librarys_own_error() {
        let costs = two_methods();
        // At 100 ppm: 5 ms against 8. At 400 ppm, halfway in logarithms between 1600 and 100: 4 ms against sqrt(2 x 8).
        assert_eq!(costs.at_own_error(CUBE, Timed::HEADLINE, 128), Some(Ratio::Exact(5.0 / 8.0)));
        let Some(Ratio::Exact(half)) = costs.at_own_error(CUBE, Timed::HEADLINE, 64) else { panic!("a bound") };
        assert_relative_eq!(half, 1.0, max_relative = 1e-9);
        assert_eq!(costs.at_own_error(CUBE, Timed::Map, 256), None);
        // The same error takes 10 bytes, and 40 to 10 halfway.
        let Some(Ratio::Exact(bytes)) = costs.bytes_at_own_error(CUBE, 64) else { panic!("a bound") };
        assert_relative_eq!(bytes, 0.5, max_relative = 1e-9);
        // A cube that is never right enough, and one that always is.
        let rough = scene("a", vec![costs.costs[2].clone(), cost(Method::Cube, 128, 9, 40, 500.0)]);
        assert_eq!(rough.at_own_error(CUBE, Timed::HEADLINE, 128), Some(Ratio::AtMost(0.5)));
        let right = scene("a", vec![costs.costs[2].clone(), cost(Method::Cube, 128, 9, 40, 0.0)]);
        assert_eq!(right.at_own_error(CUBE, Timed::HEADLINE, 128), Some(Ratio::AtLeast(0.5)));
    }

    #[test]
    fn a_perfect_method_keeps_its_points() {
        let sizes = [64, 128, 256];
        let costs = scene("a", sizes.map(|pair| cost(Method::Cube, pair, u64::from(pair), 1, 0.0)).to_vec());
        let points = costs.time_points(CUBE, Timed::Map);
        assert_eq!(points, sizes.map(|pair| Point { cost: f64::from(pair), error: 3.0 }));
        assert_eq!(Curve::new(&points).cost_at(3.0), Some(Reading::Exact(64.0)));
    }

    #[test]
    fn only_equal_texels_are_on_the_ladder() {
        let mut costs = two_methods();
        let equal_side = Cost { budget: Budget::EqualSide, ..cost(Method::Cube, 128, 1, 1, 1.0) };
        costs.costs.push(equal_side);
        assert_eq!(costs.time_points(CUBE, Timed::Map).len(), 2);
    }

    #[test]
    fn errors_at_equal_texels_and_bytes() {
        let mut costs = two_methods();
        let apart = costs.errors_at_texels(64, CUBE, 128).unwrap();
        assert_eq!((apart.own_ppm, apart.other_ppm), (400.0, 100.0));
        let pair = costs.errors_at_equal_texels(CUBE, 64).unwrap();
        assert_eq!((pair.own_ppm, pair.other_ppm, pair.family.as_str()), (400.0, 1600.0, "a"));
        // Of 20 bytes a cube is halfway, in logarithms, between 10 and 40: 400 ppm.
        costs
            .costs
            .iter_mut()
            .filter(|cost| cost.method == Method::Paraboloid)
            .for_each(|cost| cost.bytes.per_light = 20);
        let pair = costs.errors_at_equal_bytes(CUBE, 64).unwrap();
        assert_relative_eq!(pair.other_ppm, 400.0, max_relative = 1e-9);
        costs
            .costs
            .iter_mut()
            .filter(|cost| cost.method == Method::Paraboloid)
            .for_each(|cost| cost.bytes.per_light = 41);
        assert_eq!(costs.errors_at_equal_bytes(CUBE, 64), None);
    }

    #[test]
    fn bytes_break_even() {
        let mut costs = two_methods();
        assert_eq!(costs.break_even_at_equal_texels(Method::Cube, 64), Some(BreakEven::Never));
        // For 400 ppm the cube takes 20 bytes a light, this library 10 and 100 for the scene.
        assert_eq!(costs.break_even_at_own_error(CUBE, 64), Some(BreakEven::From(10)));
        costs.costs[0] = cost(Method::Paraboloid, 64, 3, 10, 99.0);
        assert_eq!(costs.break_even_at_own_error(CUBE, 64), None);
    }

    #[test]
    fn dense_scenes_are_one_family_and_files_are_none() {
        let dense = scene("dense-4m", Vec::new());
        assert_eq!(dense.family(), "dense");
        assert_eq!(SceneCosts { origin: Origin::File, ..dense }.family(), "dense-4m");
        assert_eq!(scene("hall", Vec::new()).family(), "hall");
    }

    #[test]
    fn scenes_without_a_figure_are_left_out_of_ratios() {
        let scenes = [two_methods(), scene("b", Vec::new())];
        let scenes: Vec<&SceneCosts> = scenes.iter().collect();
        let ratios = Ratios::new(&scenes, |costs| costs.at_equal_size(Method::Cube, Budget::EqualTexels, 64));
        assert_eq!((ratios.scenes.len(), ratios.of("a")), (1, Some(Ratio::Exact(3.0))));
        let names: Vec<String> = scenes[0].contestants().into_iter().map(Contestant::name).collect();
        assert_eq!(names[0], "this library");
        assert!(names.contains(&"cube: cube-plane".to_owned()), "{names:?}");
    }
}
