//! VTK image data (`.vti`): a plane or a volume of evenly spaced values.

use std::fmt::Write as _;
use std::io::{Seek, SeekFrom, Write};

use num_complex::Complex32;

use crate::error::CubeError;

/// Points of a plane or a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VtiGrid {
    /// The first point: x, y, z (m).
    pub origin_m: [f64; 3],
    /// Distances of points along x, y and z (m).
    pub spacing_m: [f64; 3],
    /// Points along x, y and z; one along z for a plane.
    pub points: [usize; 3],
    /// Whether every point has a separate height.
    pub has_heights: bool,
}

impl VtiGrid {
    fn slice_points(&self) -> usize {
        self.points[0] * self.points[1]
    }

    fn arrays(&self) -> &'static [&'static str] {
        match self.has_heights {
            true => &["real", "imag", "level_dB", "height_m"],
            false => &["real", "imag", "level_dB"],
        }
    }
}

/// Writes VTK image data slice by slice: real and imaginary part and level 10·log₁₀|σ|² of every point
/// (not a number where the value is zero), and heights where the grid has them; single precision,
/// appended to the XML as they are.
///
/// ```
/// use acerra_cubes::{VtiGrid, VtiWriter};
/// use num_complex::Complex32;
///
/// let grid = VtiGrid {
///     origin_m: [0.0, -1.0, 0.0],
///     spacing_m: [0.5, 0.5, 0.1],
///     points: [3, 2, 2],
///     has_heights: false,
/// };
/// let mut file = std::io::Cursor::new(Vec::new());
/// let mut vti = VtiWriter::new(&mut file, grid, &[("TITLE".to_owned(), "a volume".to_owned())])?;
/// for _ in 0..2 {
///     vti.slice(&[Complex32::new(3.0, 4.0); 6])?;
/// }
/// vti.finish()?;
/// assert!(file.get_ref().starts_with(b"<?xml"));
/// # Ok::<(), acerra_cubes::CubeError>(())
/// ```
#[derive(Debug)]
pub struct VtiWriter<W> {
    out: W,
    grid: VtiGrid,
    /// Offset at which the appended data begin.
    data_at: u64,
    slices: usize,
}

/// Bytes of the field that holds an array's length.
const LENGTH_BYTES: u64 = 8;

impl<W: Write + Seek> VtiWriter<W> {
    /// Begins a file with `items`, names and values, as its field data.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(mut out: W, grid: VtiGrid, items: &[(String, String)]) -> Result<Self, CubeError> {
        let head = head(&grid, items);
        out.write_all(head.as_bytes())?;
        let mut writer = Self {
            out,
            grid,
            data_at: head.len() as u64,
            slices: 0,
        };
        for array in 0..grid.arrays().len() {
            let place = writer.array_at(array) - LENGTH_BYTES;
            writer.out.seek(SeekFrom::Start(place))?;
            let length = writer.array_bytes();
            writer.out.write_all(&length.to_le_bytes())?;
        }
        Ok(writer)
    }

    /// Writes the next slice, row by row.
    ///
    /// # Errors
    /// The number of values differs from that of a slice, there is a slice too many, or the writer fails.
    pub fn slice(&mut self, image: &[Complex32]) -> Result<(), CubeError> {
        self.check_length(image.len())?;
        if self.slices == self.grid.points[2] {
            return Err(self.wrong_count(self.slices + 1));
        }
        self.put(0, image.iter().map(|z| z.re))?;
        self.put(1, image.iter().map(|z| z.im))?;
        let level = |z: &Complex32| match z.norm_sqr() {
            power if power > 0.0 => 10.0 * power.log10(),
            _ => f32::NAN,
        };
        self.put(2, image.iter().map(level))?;
        self.slices += 1;
        Ok(())
    }

    /// Writes the heights of the slice that is next.
    ///
    /// # Errors
    /// The number of values differs from that of a slice, the grid has no heights, or the writer fails.
    pub fn heights_m(&mut self, heights_m: &[f64]) -> Result<(), CubeError> {
        self.check_length(heights_m.len())?;
        if !self.grid.has_heights {
            return Err(CubeError::Dimension {
                variable: "height_m".to_owned(),
                dimension: "a grid without heights".to_owned(),
            });
        }
        self.put(3, heights_m.iter().map(|z| *z as f32))
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Slices that are missing, errors of the writer.
    pub fn finish(mut self) -> Result<(), CubeError> {
        if self.slices != self.grid.points[2] {
            return Err(self.wrong_count(self.slices));
        }
        let end = self.array_at(self.grid.arrays().len()) - LENGTH_BYTES;
        self.out.seek(SeekFrom::Start(end))?;
        self.out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
        Ok(self.out.flush()?)
    }

    /// Writes the values of array number `array` of the slice that is next.
    fn put(&mut self, array: usize, values: impl Iterator<Item = f32>) -> Result<(), CubeError> {
        let slice_bytes = 4 * self.grid.slice_points() as u64;
        let place = self.array_at(array) + self.slices as u64 * slice_bytes;
        self.out.seek(SeekFrom::Start(place))?;
        let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
        Ok(self.out.write_all(&bytes)?)
    }

    /// Offset at which the values of an array begin.
    fn array_at(&self, array: usize) -> u64 {
        self.data_at + array as u64 * (LENGTH_BYTES + self.array_bytes()) + LENGTH_BYTES
    }

    fn array_bytes(&self) -> u64 {
        array_bytes(&self.grid)
    }

    fn check_length(&self, found: usize) -> Result<(), CubeError> {
        let expected = self.grid.slice_points();
        if found == expected {
            return Ok(());
        }
        Err(CubeError::Length {
            variable: "slice".to_owned(),
            expected,
            found,
        })
    }

    fn wrong_count(&self, found: usize) -> CubeError {
        CubeError::Slices {
            variable: "image data".to_owned(),
            expected: self.grid.points[2],
            found,
        }
    }
}

fn array_bytes(grid: &VtiGrid) -> u64 {
    4 * (grid.slice_points() * grid.points[2]) as u64
}

/// Everything up to the appended data.
fn head(grid: &VtiGrid, items: &[(String, String)]) -> String {
    let extent: Vec<String> = grid
        .points
        .iter()
        .map(|n| format!("0 {}", n.saturating_sub(1)))
        .collect();
    let extent = extent.join(" ");
    let three = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
    let mut xml = format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">\n<FieldData>\n",
        three(grid.origin_m),
        three(grid.spacing_m)
    );
    for (name, value) in items {
        // Texts are written as byte values with a terminating zero.
        let bytes = value.bytes().filter(|b| *b != 0).chain([0]);
        let codes: Vec<String> = bytes.map(|b| b.to_string()).collect();
        let _ = writeln!(
            xml,
            "<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}</Array>",
            escaped(name),
            codes.join(" ")
        );
    }
    let _ = write!(
        xml,
        "</FieldData>\n<Piece Extent=\"{extent}\">\n<PointData Scalars=\"level_dB\">\n"
    );
    for (k, name) in grid.arrays().iter().enumerate() {
        let offset = k as u64 * (LENGTH_BYTES + array_bytes(grid));
        let _ = writeln!(
            xml,
            "<DataArray type=\"Float32\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>"
        );
    }
    xml.push_str("</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_");
    xml
}

/// A text as the value of an attribute.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}
