//! The shaders' text: what a renderer pastes into its own, and the complete modules that the library compiles.

use crate::view::Projection;

const PARABOLOID: &str = include_str!("../shaders/paraboloid.wgsl");
const CASTERS: &str = include_str!("../shaders/casters.wgsl");
const VIEW: &str = include_str!("../shaders/view.wgsl");
const REST: &str = include_str!("../shaders/rest.wgsl");
const DEFORMED: &str = include_str!("../shaders/deformed.wgsl");
const TRANSFORM: &str = include_str!("../shaders/transform.wgsl");
const MASK: &str = include_str!("../shaders/mask.wgsl");
/// What mask.wgsl reads, in the stages.
const MESHES: &str = "
@group(1) @binding(0) var<storage, read> dp_meshes: array<vec4<u32>>;

fn dp_mesh_record(place: u32) -> vec4<u32> {
    return dp_meshes[place];
}
";
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
const EXACT: &str = include_str!("../shaders/exact.wgsl");
const SHARP: &str = include_str!("../shaders/sharp.wgsl");
const VOTES: &str = include_str!("../shaders/votes.wgsl");
const FILTER: &str = include_str!("../shaders/filter.wgsl");

/// WGSL to put before or after a renderer's own, for `dp_shadow(light, position, normal, view) -> f32` and the filters. `group`
/// is the number under which the renderer sets [`PointShadows::bind_group`](crate::PointShadows::bind_group), `casters` that
/// for [`Casters::bind_group`](crate::Casters::bind_group). Everything it declares begins with `dp_` or `Dp`, and it declares
/// no other binding: two textures, a sampler and four storage buffers.
///
/// | argument | |
/// | --- | --- |
/// | `light: u32` | [`LightId::index`](crate::LightId::index) |
/// | `position: vec3<f32>` | a point of a surface, in world space |
/// | `normal: vec3<f32>` | the normal of its triangle, not a shading normal; any length, either sign. In a fragment shader `cross(dpdx(position), dpdy(position))` |
/// | `view: vec4<f32>` | the camera's position and the angle that a pixel spans, over which edges are smooth: of a perspective camera `2 * tan(fov_y / 2) / height` radians. An angle of 0 for the point alone |
///
/// The answer is the share of the light that arrives, from 0 to 1. All filters have these arguments and `noise`, in [0, 1],
/// which turns the spiral of those that take taps along one:
///
/// | | |
/// | --- | --- |
/// | `dp_shadow_filtered` | the light's own [`Filter`](crate::Filter) |
/// | `dp_shadow_hard`, `dp_shadow_pcf3`, `dp_shadow_pcf5` | a filter whatever the light's own |
/// | `dp_shadow_disc`, `dp_shadow_soft` | the same with the light's own settings; `dp_shadow` if they are of another filter |
/// | `dp_shadow_with` | has a last argument of the type `DpFilter(kind, size, taps)`, of the kind `DP_SHARP`, `DP_HARD`, `DP_PCF3`, `DP_PCF5`, `DP_DISC` or `DP_SOFT` |
///
/// All may be called anywhere: in loops over lights, in branches, in compute shaders.
#[must_use]
pub fn lookup(group: u32, casters: u32) -> String {
    [&lookup_without_maps(group, casters), &SHARP.replace("DP_GROUP", &group.to_string()), FILTER].concat()
}

/// What [`lookup`] has that doesn't depend on the projection of the maps: for maps of other shapes, bound alike.
pub(crate) fn lookup_without_maps(group: u32, casters: u32) -> String {
    [PARABOLOID, &lights(group), MASK, &EXACT.replace("DP_CASTERS_GROUP", &casters.to_string())].concat()
}

/// [`lookup`] without the casters' triangles, for renderers that have a single storage buffer to spare: the same functions,
/// with edges that are a texel wide, uncertain by as much, and dark where lit faces meet.
#[must_use]
pub fn lookup_votes(group: u32) -> String {
    [PARABOLOID, &lights(group), VOTES, FILTER].concat()
}

fn lights(group: u32) -> String {
    LOOKUP.replace("DP_GROUP", &group.to_string())
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
    [CASTERS, TRANSFORM, MESHES, MASK, DEFORMED].concat()
}

pub(crate) fn cull(projection: Projection) -> String {
    [projection.text, CASTERS, VIEW, TRIANGLE, CHUNK, CULL].concat()
}

pub(crate) fn resolve(projection: Projection) -> String {
    [projection.text, CASTERS, VIEW, TRIANGLE, CHUNK, MESHES, MASK, RESOLVE].concat()
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

/// Name and text of every complete module that the library compiles, and of the lookups under groups 0 and 1; for checking
/// them with other compilers.
#[must_use]
pub fn modules() -> Vec<(&'static str, String)> {
    let mut modules = vec![
        ("transform", transform()),
        ("transform_deformed", transform_deformed()),
        ("caster", caster(0)),
        ("mask_copy", mask_copy()),
        ("lookup", lookup(0, 1)),
        ("lookup_votes", lookup_votes(0)),
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
