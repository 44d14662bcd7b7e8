//! What can go wrong, each with the value that was wrong and what to do about it.

/// Every error of the library. Whatever returns one has changed nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A mesh without vertices or without triangles.
    #[error("the mesh has {positions} positions and {indices} indices: a caster needs at least one triangle")]
    EmptyMesh {
        /// Number of positions given.
        positions: usize,
        /// Number of indices given.
        indices: usize,
    },
    /// A list of indices that doesn't make whole triangles.
    #[error("{count} indices are no whole number of triangles: give a triangle list, three indices a triangle")]
    IndexCount {
        /// Number of indices given.
        count: usize,
    },
    /// An index that points behind the positions.
    #[error("index {index} at place {place} is out of range: the mesh has {positions} positions")]
    IndexOutOfRange {
        /// The index.
        index: u32,
        /// Where it stands in the list.
        place: usize,
        /// Number of positions given.
        positions: usize,
    },
    /// A position that is NaN or infinite.
    #[error("position {vertex} is {value:?}: every coordinate must be finite")]
    PositionNotFinite {
        /// Number of the vertex.
        vertex: usize,
        /// Its position.
        value: [f32; 3],
    },
    /// Texture coordinates that aren't one for each position.
    #[error("the mask has {coordinates} texture coordinates and the mesh {positions} positions: give one for each")]
    TextureCoordinateCount {
        /// Number of texture coordinates given.
        coordinates: usize,
        /// Number of positions given.
        positions: usize,
    },
    /// A texture coordinate that is NaN or infinite.
    #[error("texture coordinate {vertex} is {value:?}: both must be finite")]
    TextureCoordinateNotFinite {
        /// Number of the vertex.
        vertex: usize,
        /// Its texture coordinates.
        value: [f32; 2],
    },
    /// A mask whose texture can't be read or whose numbers are out of range.
    #[error("the mask's {what} is {value}: {remedy}")]
    InvalidMask {
        /// Which of its properties.
        what: &'static str,
        /// Its value, printed.
        value: String,
        /// What it has to be.
        remedy: &'static str,
    },
    /// Positions of a deforming mesh that can't be read.
    #[error("the deformed positions' {what} is {value}: {remedy}")]
    InvalidDeformed {
        /// Which of their properties.
        what: &'static str,
        /// Its value, printed.
        value: String,
        /// What it has to be.
        remedy: String,
    },
    /// A transform with a NaN or infinite entry, or one that moves the mesh out of the range of `f32`.
    #[error("the transform {value} takes the mesh to coordinates that aren't finite: check its scale and translation")]
    TransformNotFinite {
        /// The transform, printed.
        value: String,
    },
    /// A handle whose mesh, instance or light was removed, or that another object gave out.
    #[error("the {what} handle {handle} is stale: it was removed, or it belongs to another {owner}")]
    StaleHandle {
        /// What the handle is for.
        what: &'static str,
        /// The handle, printed.
        handle: String,
        /// The type that gives such handles out.
        owner: &'static str,
    },
    /// A mesh that instances still use.
    #[error("{instances} instances still use the mesh: remove them first")]
    MeshInUse {
        /// Number of instances.
        instances: usize,
    },
    /// More casters than the device's buffers hold.
    #[error(
        "the casters' {what} would take {needed} bytes, and the device binds at most {limit}: request the device with \
         a larger max_storage_buffer_binding_size and max_buffer_size, or add fewer triangles"
    )]
    CastersTooLarge {
        /// Which buffer.
        what: &'static str,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// A light whose position, orientation, range, near distance or filter makes no sense.
    #[error("the light's {what} is {value}: {remedy}")]
    InvalidLight {
        /// Which field.
        what: &'static str,
        /// Its value, printed.
        value: String,
        /// What it has to be.
        remedy: &'static str,
    },
    /// A descriptor's value that is out of range.
    #[error("{what} is {value}: {remedy}")]
    InvalidDescriptor {
        /// Which field.
        what: &'static str,
        /// Its value, printed.
        value: String,
        /// What it has to be.
        remedy: String,
    },
    /// A box whose corners are the wrong way round or NaN.
    #[error(
        "the box from {min:?} to {max:?} is none: each coordinate of the first corner must be at most the second's"
    )]
    InvalidBox {
        /// The lower corner given.
        min: [f32; 3],
        /// The upper corner given.
        max: [f32; 3],
    },
    /// A device with a limit that is lower than [`required_limits`](crate::required_limits) has it.
    #[error(
        "the device's {limit} is {value} and must be at least {needed}: request it with required_limits(), or better"
    )]
    LimitTooLow {
        /// Which field of [`wgpu::Limits`].
        limit: &'static str,
        /// Its value.
        value: u64,
        /// The least that is enough.
        needed: u64,
    },
    /// More chunks than there are numbers for.
    #[error(
        "the casters would have {needed} chunks, and there are numbers for {limit}: join small meshes, since each instance          has at least one chunk of up to 256 triangles"
    )]
    TooManyChunks {
        /// Chunks needed.
        needed: u64,
        /// Chunks at most.
        limit: u64,
    },
    /// The device is lost, so nothing was recorded.
    #[error("the device is lost: make another one, and all that was made with this one anew")]
    DeviceLost,
    /// No place for another light.
    #[error("all {capacity} places are taken: remove a light, or create the shadows with a larger capacity")]
    CapacityExceeded {
        /// Number of places.
        capacity: u32,
    },
}
