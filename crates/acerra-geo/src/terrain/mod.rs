//! Heights of the ground: GeoTIFF, ESRI ASCII and XYZ rasters, in a local frame.
//!
//! A file is opened for its header alone; [`TerrainFile::in_frame`] then reads the part under an
//! image and answers heights in the frame of the positions.

mod ascii;
mod crs;
mod error;
mod geographic;
mod geotiff;
mod local;
mod prj;
mod raster;
mod summary;
mod xyz;

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::trajectory::Frame;
pub use crs::Crs;
pub use error::TerrainError;
pub(crate) use geographic::GeographicRaster;
pub use local::LocalTerrain;
use raster::{Header, Window};
pub use summary::HeightSummary;

/// Options of reading terrain.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct TerrainOptions {
    /// The coordinate reference system, where the file states none; text grids never do and are
    /// [`Crs::Local`] by default.
    pub crs: Option<Crs>,
    /// Added to the file's heights to have heights above the ellipsoid (m): the geoid's height
    /// there, for heights above the sea. For [`Crs::Local`] simply added.
    pub offset_m: f64,
    /// Most cells that are held, four bytes each; a quarter as many points of an XYZ grid.
    pub max_cells: usize,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        Self {
            crs: None,
            offset_m: 0.0,
            max_cells: 64 << 20,
        }
    }
}

impl TerrainOptions {
    /// With these coordinates.
    #[must_use]
    pub fn with_crs(mut self, crs: Crs) -> Self {
        self.crs = Some(crs);
        self
    }

    /// With this added to every height (m).
    #[must_use]
    pub fn with_offset_m(mut self, offset_m: f64) -> Self {
        self.offset_m = offset_m;
        self
    }
}

/// A terrain file whose header has been read.
pub struct TerrainFile<R: Read + Seek> {
    header: Header,
    format: &'static str,
    options: TerrainOptions,
    content: Content<R>,
}

enum Content<R: Read + Seek> {
    GeoTiff(Box<geotiff::Reader<BufReader<R>>>),
    Whole(Window),
}

/// Whether a file that begins like this is a raster of heights: a TIFF, an ESRI ASCII grid, or lines of three numbers.
///
/// ```
/// use acerra_geo::terrain::is_raster;
/// assert!(is_raster(b"ncols 4\nnrows 3\n"));
/// assert!(is_raster(b"412000.5 5712000.5 31.25\n412001.5 5712000.5 31.31\n"));
/// assert!(!is_raster(b"a letter of three words"));
/// ```
#[must_use]
pub fn is_raster(head: &[u8]) -> bool {
    let is_tiff = matches!(
        head,
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..]
    );
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    is_tiff || ascii::begins(text) || xyz::begins(text)
}

impl TerrainFile<File> {
    /// Opens a file by its path; for a grid in text, well-known text of the same name that ends in `.prj`
    /// names the coordinate reference system.
    ///
    /// # Errors
    /// Errors of [`open`](Self::open), and a `.prj` with an unsupported system.
    pub fn open_path(path: &Path, options: &TerrainOptions) -> Result<Self, TerrainError> {
        let mut terrain = Self::open(File::open(path)?, options)?;
        if terrain.header.crs.is_none() && matches!(terrain.content, Content::Whole(_)) {
            for companion in ["prj", "PRJ"].map(|e| path.with_extension(e)) {
                if companion == path || !companion.is_file() {
                    continue;
                }
                let mut text = Vec::new();
                File::open(&companion)?
                    .take(prj::MAX_BYTES)
                    .read_to_end(&mut text)?;
                let crs = Crs::from_wkt(&String::from_utf8_lossy(&text));
                terrain.header.crs = Some(crs.map_err(|cause| TerrainError::Beside {
                    path: companion.clone(),
                    cause: Box::new(cause),
                })?);
                break;
            }
        }
        Ok(terrain)
    }
}

impl<R: Read + Seek> TerrainFile<R> {
    /// Recognises a file by its content and reads its header; text grids are read whole.
    ///
    /// # Errors
    /// A file of another kind, broken, larger than allowed, or in coordinates that are not known.
    pub fn open(reader: R, options: &TerrainOptions) -> Result<Self, TerrainError> {
        let mut reader = BufReader::new(reader);
        let start = reader.fill_buf()?;
        if start.is_empty() {
            return Err(TerrainError::Empty);
        }
        let tiff = start.starts_with(b"II") || start.starts_with(b"MM");
        let ascii = ascii::begins(start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start));
        reader.seek(SeekFrom::Start(0))?;
        let (format, header, content) = if tiff {
            let (header, tiff) = geotiff::Reader::open(reader)?;
            ("GeoTIFF", header, Content::GeoTiff(Box::new(tiff)))
        } else if ascii {
            let (header, whole) = ascii::read(reader, options.max_cells)?;
            ("ESRI ASCII grid", header, Content::Whole(whole))
        } else {
            let (header, whole) = xyz::read(reader, options.max_cells / 4)?;
            ("XYZ grid", header, Content::Whole(whole))
        };
        Ok(Self {
            header,
            format,
            options: options.clone(),
            content,
        })
    }

    /// What kind of file it is.
    #[must_use]
    pub fn format(&self) -> &'static str {
        self.format
    }

    /// Columns and rows of the raster.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.header.columns, self.header.rows]
    }

    /// The coordinate reference system: as the file states, else as the options state.
    ///
    /// # Errors
    /// Neither says, in a GeoTIFF.
    pub fn crs(&self) -> Result<Crs, TerrainError> {
        let text = matches!(self.content, Content::Whole(_));
        self.header
            .crs
            .or(self.options.crs)
            .or(text.then_some(Crs::Local))
            .ok_or_else(|| TerrainError::Crs {
                expected: "GeoKeys that name them, or their EPSG code from the caller",
                found: "neither".to_owned(),
            })
    }

    /// The file's statement on the surface that its heights count from.
    #[must_use]
    pub fn vertical(&self) -> Option<&str> {
        self.header.vertical.as_deref()
    }

    /// Reads the heights over a rectangle of a frame, `[from, to]` metres east and north.
    ///
    /// # Errors
    /// A rectangle that reaches beyond the raster, a file that breaks off, a frame of unknown place.
    pub fn in_frame(
        mut self,
        frame: &Frame,
        x_m: [f64; 2],
        y_m: [f64; 2],
    ) -> Result<LocalTerrain, TerrainError> {
        let crs = self.crs()?;
        let lattice =
            local::Lattice::new(&self.header, crs, frame, self.options.offset_m, x_m, y_m)?;
        let (columns, rows) = lattice.cells(&self.header)?;
        let window = match &mut self.content {
            Content::GeoTiff(tiff) => tiff.window(columns, rows, self.options.max_cells)?,
            Content::Whole(window) => window.clone(),
        };
        let size = [self.header.columns, self.header.rows];
        Ok(LocalTerrain::new(lattice, window, size))
    }
}

impl<R: Read + Seek> std::fmt::Debug for TerrainFile<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TerrainFile")
            .field("format", &self.format)
            .field("header", &self.header)
            .finish_non_exhaustive()
    }
}
