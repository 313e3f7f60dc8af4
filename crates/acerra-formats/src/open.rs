//! Opening a file, whatever its kind.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use crate::analyser_csv::{is_analyser_csv, read_analyser_csv};
use crate::companion::{self, find};
use crate::dt1::{is_dt1, is_hd, read_dt1};
use crate::dzt::{is_dzt, read_dzt};
use crate::error::{FormatError, Place};
use crate::fmcw::{FmcwSettings, is_beat_npz, is_fmcw_settings, read_beat_npz, read_dca1000};
use crate::hdf5::{is_hdf5, read_hdf5};
use crate::limits::Limits;
use crate::mala::{NamedAs, is_rad, read_mala};
use crate::matlab5::{is_matlab5, read_matlab5};
use crate::recording::{Format, Recording};
use crate::segy::{is_segy, read_segy};
use crate::touchstone::{is_touchstone, read_touchstone};

/// Bytes by which a file is recognised.
const HEAD_BYTES: u64 = 1 << 14;

/// The format of a file by its content, and by the header next to it where it has none inside.
///
/// # Errors
/// A file that cannot be read.
pub fn recognise(path: &Path) -> Result<Option<Format>, FormatError> {
    let head = companion::head(path, HEAD_BYTES)?;
    Ok(by_head(path, &head))
}

fn by_head(path: &Path, head: &[u8]) -> Option<Format> {
    if head.starts_with(b"PK\x03\x04") {
        let file = File::open(path).ok()?;
        return is_beat_npz(BufReader::new(file)).then_some(Format::Fmcw);
    }
    if is_hdf5(head) {
        return Some(Format::Hdf5);
    }
    if is_matlab5(head) {
        return Some(Format::Matlab5);
    }
    if is_segy(head) {
        return Some(Format::SegY);
    }
    let is_text = !head.contains(&0);
    if is_text {
        if is_fmcw_settings(head) {
            return Some(Format::Fmcw);
        }
        if is_rad(head) {
            return Some(Format::Mala);
        }
        if is_hd(head) {
            return Some(Format::Dt1);
        }
        if is_touchstone(head) {
            return Some(Format::Touchstone);
        }
        if is_analyser_csv(head) {
            return Some(Format::AnalyserCsv);
        }
    }
    // Samples without an internal header have the format of the header file next to them.
    if is_dt1(head) && find(path, is_hd).is_some() {
        return Some(Format::Dt1);
    }
    if is_dzt(head) {
        return Some(Format::Dzt);
    }
    let is_data = !is_text
        || !head
            .iter()
            .all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace());
    (is_data && find(path, is_rad).is_some() && !is_gpr_extra(path)).then_some(Format::Mala)
}

/// Marks and positions of MALÅ are next to the data, too.
fn is_gpr_extra(path: &Path) -> bool {
    has_extension(path, "cor") || has_extension(path, "mrk") || has_extension(path, "rad")
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Reads a radar file of any kind, with the files that belong to it.
///
/// # Errors
/// An unreadable file, a file of unknown kind, without its header file, damaged, or larger than `limits`
/// admit.
pub fn open(path: &Path, limits: &Limits) -> Result<Recording, FormatError> {
    let head = companion::head(path, HEAD_BYTES)?;
    if head.is_empty() {
        return Err(FormatError::content(
            Place::Whole,
            "a radar file",
            "nothing: it is empty",
        ));
    }
    let text = || companion::text(path);
    match by_head(path, &head).ok_or_else(|| unknown(&head))? {
        Format::SegY => {
            let (reader, length) = buffered(path)?;
            read_segy(reader, length, limits)
        }
        Format::Dzt => {
            let dzg = beside_text(path, |h| contains(h, "$GSSIS"))?;
            let dzx = beside_text(path, |h| contains(h, "<DZX"))?;
            let (reader, length) = buffered(path)?;
            read_dzt(reader, length, [dzg.as_deref(), dzx.as_deref()], limits)
        }
        Format::Dt1 => dt1(path, &head, limits),
        Format::Mala => mala(path, &head, limits),
        Format::GprMax | Format::Hdf5 => read_hdf5(companion::contents(path, limits)?, limits),
        Format::Matlab5 => read_matlab5(&companion::contents(path, limits)?, limits),
        Format::Touchstone => read_touchstone(&text()?, limits),
        Format::AnalyserCsv => read_analyser_csv(&text()?, limits),
        Format::Fmcw if head.starts_with(b"PK") => read_beat_npz(buffered(path)?.0, limits),
        Format::Fmcw => {
            let settings = FmcwSettings::parse(&text()?)?;
            let folder = path.parent().unwrap_or(Path::new(""));
            let samples = folder.join(&settings.file);
            let of = |e: FormatError| companion::of(&samples, e);
            let read = |(reader, length)| read_dca1000(reader, length, &settings, limits);
            buffered(&samples).and_then(read).map_err(of)
        }
    }
}

/// An unrecognised file: possibly one of a pair of files.
fn unknown(head: &[u8]) -> FormatError {
    if is_dt1(head) {
        return FormatError::NoCompanion {
            expected: "an HD of the same name".to_owned(),
        };
    }
    FormatError::Unrecognised
}

/// A file from its beginning, and its length in bytes.
fn buffered(path: &Path) -> Result<(BufReader<File>, u64), FormatError> {
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    Ok((BufReader::with_capacity(1 << 20, file), length))
}

fn contains(head: &[u8], text: &str) -> bool {
    head.windows(text.len()).any(|w| w == text.as_bytes())
}

fn beside_text(path: &Path, wanted: impl Fn(&[u8]) -> bool) -> Result<Option<String>, FormatError> {
    find(path, wanted)
        .map(|found| companion::text(&found).map_err(|e| companion::of(&found, e)))
        .transpose()
}

/// Data and header, whichever of the two was named.
fn pair(
    path: &Path,
    is_header: bool,
    wanted: impl Fn(&[u8]) -> bool,
    expected: &str,
) -> Result<[PathBuf; 2], FormatError> {
    let other = find(path, wanted).ok_or_else(|| FormatError::NoCompanion {
        expected: expected.to_owned(),
    })?;
    Ok(if is_header {
        [other, path.to_owned()]
    } else {
        [path.to_owned(), other]
    })
}

fn dt1(path: &Path, head: &[u8], limits: &Limits) -> Result<Recording, FormatError> {
    let [data, header] = if is_hd(head) {
        pair(path, true, is_dt1, "a DT1 of the same name")?
    } else {
        pair(path, false, is_hd, "an HD of the same name")?
    };
    let hd = companion::text(&header).map_err(|e| companion::of(&header, e))?;
    let gps = beside_text(path, |h| contains(h, "GGA,") && contains(h, "#"))?;
    let (reader, length) = buffered(&data)?;
    read_dt1(reader, length, &hd, gps.as_deref(), limits)
}

fn mala(path: &Path, head: &[u8], limits: &Limits) -> Result<Recording, FormatError> {
    let [data, header] = if is_rad(head) {
        let samples = companion::beside(path)
            .into_iter()
            .find(|other| has_extension(other, "rd3") || has_extension(other, "rd7"));
        let data = samples.ok_or_else(|| FormatError::NoCompanion {
            expected: "an rd3 or rd7 of the same name".to_owned(),
        })?;
        [data, path.to_owned()]
    } else {
        pair(path, false, is_rad, "a rad of the same name")?
    };
    let rad = companion::text(&header).map_err(|e| companion::of(&header, e))?;
    let cor = companion::beside(path)
        .into_iter()
        .find(|other| has_extension(other, "cor"));
    let cor = cor
        .map(|found| companion::text(&found).map_err(|e| companion::of(&found, e)))
        .transpose()?;
    let named = if has_extension(&data, "rd7") {
        NamedAs::Long
    } else {
        NamedAs::Short
    };
    let (reader, length) = buffered(&data)?;
    read_mala(reader, length, named, &rad, cor.as_deref(), limits)
}
