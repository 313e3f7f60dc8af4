//! Writing archives of arrays that NumPy's `load` reads.

use std::io::{self, Seek, SeekFrom, Write};
use std::marker::PhantomData;

use num_complex::{Complex32, Complex64};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Arrays larger than this (bytes) are written as ZIP64 members.
const LARGEST_PLAIN_MEMBER: u64 = 1 << 31;

/// Bytes of an array that are written together.
const BLOCK_BYTES: usize = 1 << 16;

/// A number that arrays can be written of.
pub trait NpyValue: Copy {
    /// NumPy's name of the type, little-endian.
    const DESCR: &'static str;
    /// Bytes of one value.
    const BYTES: u64;
    /// Writes the value's bytes to the start of `out`, which holds as many at least.
    fn write(self, out: &mut [u8]);
}

macro_rules! npy_value {
    ($type:ty, $descr:literal, $bytes:literal, $($part:tt)+) => {
        impl NpyValue for $type {
            const DESCR: &'static str = $descr;
            const BYTES: u64 = $bytes;
            fn write(self, out: &mut [u8]) {
                npy_value!(@ self out $bytes $($part)+);
            }
        }
    };
    (@ $self:ident $out:ident $bytes:literal itself) => {
        $out[..$bytes].copy_from_slice(&$self.to_le_bytes())
    };
    (@ $self:ident $out:ident $bytes:literal complex) => {{
        $out[..$bytes / 2].copy_from_slice(&$self.re.to_le_bytes());
        $out[$bytes / 2..$bytes].copy_from_slice(&$self.im.to_le_bytes());
    }};
}

npy_value!(f32, "<f4", 4, itself);
npy_value!(f64, "<f8", 8, itself);
npy_value!(Complex32, "<c8", 8, complex);
npy_value!(Complex64, "<c16", 16, complex);

/// Writes arrays into an archive that NumPy's `load` reads. Equal arrays make equal files,
/// whenever they are written.
///
/// ```
/// use acerra_npz::{NpzReader, NpzWriter};
/// let mut npz = NpzWriter::stored(std::io::Cursor::new(Vec::new()));
/// npz.array("z_m", &[2, 1], [0.5, -1.0])?;
/// let mut npz = NpzReader::new(npz.finish()?)?;
/// assert_eq!(npz.values("z_m", 100)?, (vec![2, 1], vec![(0.5, 0.0), (-1.0, 0.0)]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct NpzWriter<W: Write + Seek> {
    zip: ZipWriter<UntilError<W>>,
    options: SimpleFileOptions,
}

/// A writer that only counts after its first error: an archive dropped after an error ends without a second one, which
/// `zip` would print.
struct UntilError<W> {
    writer: W,
    place: u64,
    has_failed: bool,
}

impl<W> UntilError<W> {
    fn noted<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        self.has_failed |= matches!(&result, Err(e) if e.kind() != io::ErrorKind::Interrupted);
        result
    }
}

impl<W: Write> Write for UntilError<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match self.has_failed {
            true => Ok(bytes.len()),
            false => self.writer.write(bytes),
        };
        let written = self.noted(written)?;
        self.place += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = match self.has_failed {
            true => Ok(()),
            false => self.writer.flush(),
        };
        self.noted(flushed)
    }
}

impl<W: Seek> Seek for UntilError<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let place = match (self.has_failed, to) {
            (false, _) => self.writer.seek(to),
            (true, SeekFrom::Start(place)) => Ok(place),
            (true, SeekFrom::Current(by) | SeekFrom::End(by)) => {
                Ok(self.place.saturating_add_signed(by))
            }
        };
        self.place = self.noted(place)?;
        Ok(self.place)
    }
}

impl<W: Write + Seek> NpzWriter<W> {
    /// An archive of uncompressed arrays.
    #[must_use]
    pub fn stored(writer: W) -> Self {
        Self::with_method(writer, CompressionMethod::Stored)
    }

    /// An archive of compressed arrays.
    #[must_use]
    pub fn deflated(writer: W) -> Self {
        Self::with_method(writer, CompressionMethod::Deflated)
    }

    fn with_method(writer: W, method: CompressionMethod) -> Self {
        Self {
            zip: ZipWriter::new(UntilError {
                writer,
                place: 0,
                has_failed: false,
            }),
            options: SimpleFileOptions::default()
                .compression_method(method)
                .last_modified_time(zip::DateTime::default()),
        }
    }

    /// Writes an array, row-major.
    ///
    /// # Errors
    /// If `values` are not as many as `shape` says, or errors of the writer.
    pub fn array<T: NpyValue>(
        &mut self,
        name: &str,
        shape: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        let mut array = self.begin::<T>(name, shape)?;
        array.extend(values)?;
        array.finish()
    }

    /// Begins an array that is written piece by piece, row-major.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn begin<T: NpyValue>(
        &mut self,
        name: &str,
        shape: &[u64],
    ) -> io::Result<ArrayWriter<'_, W, T>> {
        let state = self.start(name, shape)?;
        Ok(ArrayWriter {
            zip: &mut self.zip,
            state,
        })
    }

    /// Begins an array that is written piece by piece, row-major, by an owner that keeps the archive
    /// between the pieces.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn into_array<T: NpyValue>(
        mut self,
        name: &str,
        shape: &[u64],
    ) -> io::Result<OwnedArrayWriter<W, T>> {
        let state = self.start(name, shape)?;
        Ok(OwnedArrayWriter { npz: self, state })
    }

    fn start<T: NpyValue>(&mut self, name: &str, shape: &[u64]) -> io::Result<ArrayState<T>> {
        let count: u64 = shape.iter().product();
        let large = count.saturating_mul(T::BYTES) > LARGEST_PLAIN_MEMBER;
        let options = self.options.large_file(large);
        self.zip.start_file(format!("{name}.npy"), options)?;
        Ok(ArrayState {
            bytes: header(T::DESCR, shape),
            missing: count,
            value: PhantomData,
        })
    }

    /// Writes the archive's directory.
    ///
    /// # Errors
    /// Errors of the writer, also those of an array before.
    pub fn finish(self) -> io::Result<W> {
        let written = self.zip.finish()?;
        if written.has_failed {
            return Err(io::Error::other(
                "the archive is incomplete: an array could not be written",
            ));
        }
        Ok(written.writer)
    }
}

/// An array being written.
pub struct ArrayWriter<'a, W: Write + Seek, T> {
    zip: &'a mut ZipWriter<UntilError<W>>,
    state: ArrayState<T>,
}

impl<W: Write + Seek, T: NpyValue> ArrayWriter<'_, W, T> {
    /// Writes the next values.
    ///
    /// # Errors
    /// If they are more than the shape asks for, or errors of the writer.
    pub fn extend(&mut self, values: impl IntoIterator<Item = T>) -> io::Result<()> {
        self.state.extend(self.zip, values)
    }

    /// Ends the array.
    ///
    /// # Errors
    /// If values are missing, or errors of the writer.
    pub fn finish(self) -> io::Result<()> {
        self.state.finish(self.zip)
    }
}

/// An array being written, together with the archive that it becomes part of.
///
/// ```
/// use acerra_npz::NpzWriter;
/// let npz = NpzWriter::stored(std::io::Cursor::new(Vec::new()));
/// let mut array = npz.into_array("z_m", &[2])?;
/// array.extend([0.5])?;
/// array.extend([-1.0])?;
/// array.finish()?.finish()?;
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct OwnedArrayWriter<W: Write + Seek, T> {
    npz: NpzWriter<W>,
    state: ArrayState<T>,
}

impl<W: Write + Seek, T: NpyValue> OwnedArrayWriter<W, T> {
    /// Writes the next values.
    ///
    /// # Errors
    /// If they are more than the shape asks for, or errors of the writer.
    pub fn extend(&mut self, values: impl IntoIterator<Item = T>) -> io::Result<()> {
        self.state.extend(&mut self.npz.zip, values)
    }

    /// Ends the array and gives the archive back.
    ///
    /// # Errors
    /// If values are missing, or errors of the writer.
    pub fn finish(mut self) -> io::Result<NpzWriter<W>> {
        self.state.finish(&mut self.npz.zip)?;
        Ok(self.npz)
    }
}

/// Number of bytes of an array written so far.
struct ArrayState<T> {
    bytes: Vec<u8>,
    missing: u64,
    value: PhantomData<T>,
}

impl<T: NpyValue> ArrayState<T> {
    fn extend(
        &mut self,
        zip: &mut impl Write,
        values: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        let mut values = values.into_iter();
        loop {
            // As many as fill the block, at most the requested number.
            let filled = self.bytes.len();
            let room = (BLOCK_BYTES.saturating_sub(filled) as u64 / T::BYTES).min(self.missing);
            self.bytes.resize(filled + (room * T::BYTES) as usize, 0);
            let mut written = 0;
            let places = self.bytes[filled..].chunks_exact_mut(T::BYTES as usize);
            for (place, value) in places.zip(&mut values) {
                value.write(place);
                written += 1;
            }
            self.missing -= written;
            self.bytes.truncate(filled + (written * T::BYTES) as usize);
            if written < room {
                return Ok(());
            }
            if self.missing == 0 {
                return match values.next() {
                    None => Ok(()),
                    Some(_) => Err(wrong_count(
                        "more values than the shape asks for".to_owned(),
                    )),
                };
            }
            zip.write_all(&self.bytes)?;
            self.bytes.clear();
        }
    }

    fn finish(self, zip: &mut impl Write) -> io::Result<()> {
        if self.missing > 0 {
            let missing = self.missing;
            return Err(wrong_count(format!("{missing} values are missing")));
        }
        zip.write_all(&self.bytes)
    }
}

fn wrong_count(text: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, text)
}

/// Magic, version 1.0 and the dictionary, filled up so that the values start at a multiple of 64.
fn header(descr: &str, shape: &[u64]) -> Vec<u8> {
    let dimensions: Vec<String> = shape.iter().map(u64::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    let mut text = format!(
        "{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}{comma}), }}",
        dimensions.join(", ")
    );
    let unfilled = 10 + text.len() + 1;
    text.push_str(&" ".repeat(unfilled.next_multiple_of(64) - unfilled));
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk that holds so many bytes.
    struct Disk {
        written: io::Cursor<Vec<u8>>,
        most: u64,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.written.position() + bytes.len() as u64 > self.most {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.written.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Disk {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.written.seek(to)
        }
    }

    #[test]
    fn an_archive_on_a_full_disk_fails_once_and_is_never_whole() {
        for most in [0, 40, 1_000, 100_000] {
            let disk = Disk {
                written: io::Cursor::default(),
                most,
            };
            let mut npz = NpzWriter::stored(disk);
            let error = npz
                .array("x", &[1 << 17], vec![0.5f64; 1 << 17])
                .unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{most}");
            // Ends the archive as dropping it does.
            let UntilError {
                has_failed, writer, ..
            } = npz.zip.finish().unwrap();
            assert!(
                has_failed && writer.written.get_ref().len() as u64 <= most,
                "{most}"
            );
        }
        let disk = Disk {
            written: io::Cursor::default(),
            most: 1_000,
        };
        let mut npz = NpzWriter::stored(disk);
        assert!(npz.array("x", &[1 << 17], vec![0.5f64; 1 << 17]).is_err());
        assert!(npz.finish().is_err());
    }
}
