//! The shaders' text: what a renderer pastes into its own, and the complete modules that the library compiles.

use crate::view::Projection;

const PARABOLOID: &str = include_str!("../shaders/paraboloid.wgsl");
const CASTERS: &str = include_str!("../shaders/casters.wgsl");
const VIEW: &str = include_str!("../shaders/view.wgsl");
const REST: &str = include_str!("../shaders/rest.wgsl");
const DEFORMED: &str = include_str!("../shaders/deformed.wgsl");
const TRANSFORM: &str = include_str!("../shaders/transform.wgsl");
const MASK: &str = include_str!("../shaders/mask.wgsl");
const MASK_COPY: &str = include_str!("../shaders/mask_copy.wgsl");
const HEMISPHERE: &str = include_str!("../shaders/hemisphere.wgsl");
/// The projection of the maps, with what it takes from the mapping.
pub(crate) const PARABOLOIDS: &str =
    concat!(include_str!("../shaders/paraboloid.wgsl"), include_str!("../shaders/projection.wgsl"));
const TRIANGLE: &str = include_str!("../shaders/triangle.wgsl");
const TILES: &str = include_str!("../shaders/tiles.wgsl");
const CHUNK: &str = include_str!("../shaders/chunk.wgsl");
const ASSIGN: &str = include_str!("../shaders/assign.wgsl");
const NUMBER: &str = include_str!("../shaders/number.wgsl");
const CULL: &str = include_str!("../shaders/cull.wgsl");
const RESOLVE: &str = include_str!("../shaders/resolve.wgsl");
const BIN: &str = include_str!("../shaders/bin.wgsl");
const RASTERISE: &str = include_str!("../shaders/rasterise.wgsl");
const LOOKUP: &str = include_str!("../shaders/lookup.wgsl");
#[cfg(feature = "compare")]
const WALK: &str = include_str!("../shaders/walk.wgsl");
const FILTER: &str = include_str!("../shaders/filter.wgsl");

/// WGSL to put before or after a renderer's own, for `dp_shadow(light, position, normal) -> f32` and the filters.
/// `group` is the number under which the renderer sets
/// [`PointShadows::bind_group`](crate::PointShadows::bind_group). Everything it declares begins with `dp_` or `Dp`, and
/// it declares no other binding.
///
/// All filters have the arguments `(light, position, normal, noise)`, of which `noise` in [0, 1] turns the spiral of
/// those that take taps along one:
///
/// | | |
/// | --- | --- |
/// | `dp_shadow_filtered` | the light's own [`Filter`](crate::Filter) |
/// | `dp_shadow_hard`, `dp_shadow_pcf3`, `dp_shadow_pcf5` | a filter whatever the light's own |
/// | `dp_shadow_disc`, `dp_shadow_soft` | the same with the light's own settings; `dp_shadow` if they are of another filter |
/// | `dp_shadow_with` | has a last argument of the type `DpFilter(kind, size, taps)`, of the kind `DP_HARD`, `DP_BILINEAR`, `DP_PCF3`, `DP_PCF5`, `DP_DISC` or `DP_SOFT` |
///
/// All may be called anywhere: in loops over lights, in branches, in compute shaders.
#[must_use]
pub fn lookup(group: u32) -> String {
    [PARABOLOID, &LOOKUP.replace("DP_GROUP", &group.to_string()), FILTER].concat()
}

/// The lookup with `dp_walk_shadow(light, position, normal)`, which asks the triangles where texels disagree.
#[cfg(feature = "compare")]
#[must_use]
pub(crate) fn walk(group: u32) -> String {
    let walk = WALK.replace("DP_GROUP", &group.to_string());
    [lookup(group).as_str(), &walk].concat()
}

/// WGSL to put before or after a vertex shader that draws casters of its own, for
/// `dp_caster_position(world_position) -> vec4<f32>`: the clip position in the hemisphere that is being drawn. `group` is
/// the number for [`CasterPass::bind`](crate::CasterPass::bind). Everything it declares begins with `dp_` or `Dp`, and it
/// declares no other binding.
#[must_use]
pub fn caster(group: u32) -> String {
    [PARABOLOID, &HEMISPHERE.replace("DP_GROUP", &group.to_string())].concat()
}

/// WGSL of the mapping alone: the functions of [`paraboloid`](crate::paraboloid) with the prefix `dp_`.
#[must_use]
pub fn paraboloid() -> &'static str {
    PARABOLOID
}

pub(crate) fn transform() -> String {
    [CASTERS, TRANSFORM, REST].concat()
}

pub(crate) fn transform_deformed() -> String {
    [CASTERS, TRANSFORM, MASK, DEFORMED].concat()
}

pub(crate) fn cull(projection: Projection) -> String {
    [projection.text, CASTERS, VIEW, TRIANGLE, CHUNK, CULL].concat()
}

pub(crate) fn resolve(projection: Projection) -> String {
    [projection.text, CASTERS, VIEW, TRIANGLE, CHUNK, MASK, RESOLVE].concat()
}

pub(crate) fn assign(projection: Projection) -> String {
    [projection.text, CASTERS, VIEW, TRIANGLE, TILES, NUMBER, BIN, ASSIGN].concat()
}

/// Each thread takes `pairs` pairs of a tile's texels.
pub(crate) fn rasterise(projection: Projection, pairs: u32) -> String {
    [projection.text, VIEW, TILES, &format!("const PAIRS: u32 = {pairs}u;\n"), RASTERISE].concat()
}

pub(crate) fn mask_copy() -> String {
    MASK_COPY.to_owned()
}

/// Name and text of every complete module that the library compiles, and of the lookup under group 0; for checking
/// them with other compilers.
#[must_use]
pub fn modules() -> Vec<(&'static str, String)> {
    let mut modules = vec![
        ("transform", transform()),
        ("transform_deformed", transform_deformed()),
        ("caster", caster(0)),
        ("mask_copy", mask_copy()),
        ("lookup", lookup(0)),
        #[cfg(feature = "compare")]
        ("walk", walk(0)),
    ];
    modules.extend(maps(Projection::PARABOLOIDS));
    modules
}

/// Those that make the maps.
pub(crate) fn maps(projection: Projection) -> [(&'static str, String); 5] {
    [
        ("cull", cull(projection)),
        ("resolve", resolve(projection)),
        ("assign", assign(projection)),
        ("rasterise", rasterise(projection, 1)),
        ("rasterise_software", rasterise(projection, 16)),
    ]
}
