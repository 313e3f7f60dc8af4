//! Reasons why terrain cannot be read, or has no height somewhere.

/// Reason why a terrain file was refused, or a height was not found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TerrainError {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// Nothing in it.
    #[error("the file is empty")]
    Empty,
    /// The TIFF structure is damaged, or uses an unsupported feature.
    #[error("{at}: {source}")]
    Tiff {
        /// Part of the file.
        at: String,
        /// Defect found.
        source: tiff::TiffError,
    },
    /// A tag or GeoKey is invalid.
    #[error("{at}: expected {expected}, found {found}")]
    Tag {
        /// Name of the tag or key.
        at: &'static str,
        /// Value expected.
        expected: &'static str,
        /// What it says.
        found: String,
    },
    /// A line violates its format. Lines count from 1.
    #[error("line {line}: expected {expected}, found {found}")]
    Line {
        /// Line number, from 1.
        line: u64,
        /// Value expected.
        expected: &'static str,
        /// Text found.
        found: String,
    },
    /// Points that are no grid.
    #[error("line {line}: the point ({x}, {y}) is on no grid of {step_x} × {step_y}")]
    NoGrid {
        /// The point's line, from 1.
        line: u64,
        /// First coordinate.
        x: f64,
        /// Second.
        y: f64,
        /// Smallest distance of two columns.
        step_x: f64,
        /// Smallest distance of two rows.
        step_y: f64,
    },
    /// More than is taken.
    #[error("{what}: {found} are more than the {limit} that are taken")]
    Limit {
        /// Kind of the excess.
        what: &'static str,
        /// How much.
        found: u128,
        /// How much is allowed.
        limit: u128,
    },
    /// The coordinate reference system is missing, or not supported.
    #[error("coordinates: expected {expected}, found {found}")]
    Crs {
        /// Values that can be used.
        expected: &'static str,
        /// The statement of the file or the caller.
        found: String,
    },
    /// The file next to a raster that names its coordinate reference system.
    #[error("{}: {cause}", path.display())]
    Beside {
        /// That file.
        path: std::path::PathBuf,
        /// Defect found.
        cause: Box<TerrainError>,
    },
    /// A system of the EPSG registry that is unknown or cannot be used.
    #[error("coordinates: {0}")]
    Epsg(#[from] crate::epsg::CrsError),
    /// Terrain on the Earth for positions in a frame of unknown place, or the other way round.
    #[error("the terrain's coordinates are {terrain}, the positions' frame is {frame}: {remedy}")]
    Frame {
        /// The terrain's coordinates.
        terrain: String,
        /// Place of the frame.
        frame: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A place outside the raster.
    #[error(
        "no height at x = {x_m:.2} m, y = {y_m:.2} m: it falls on column {column:.1}, row {row:.1} \
         of a raster of {columns} × {rows}"
    )]
    Outside {
        /// East of the frame's origin, m.
        x_m: f64,
        /// North of the frame's origin, m.
        y_m: f64,
        /// Column it falls on, from 0 at the first centre.
        column: f64,
        /// Row it falls on.
        row: f64,
        /// Columns of the raster.
        columns: usize,
        /// Rows of the raster.
        rows: usize,
    },
    /// A place where the raster holds no data.
    #[error(
        "no height at x = {x_m:.2} m, y = {y_m:.2} m: the raster has no data about column \
         {column:.1}, row {row:.1}"
    )]
    Hole {
        /// East of the frame's origin, m.
        x_m: f64,
        /// North of the frame's origin, m.
        y_m: f64,
        /// Column it falls on, from 0 at the first centre.
        column: f64,
        /// Row it falls on.
        row: f64,
    },
}
