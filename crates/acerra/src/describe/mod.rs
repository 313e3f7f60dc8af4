//! Description of a file of any kind.

mod configuration;
mod description;
mod flight_log;
mod foreign;
mod geoid;
mod gnss;
mod image;
mod phase_history;
mod radar;
mod session;
mod terrain;
mod trajectory;

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use anyhow::{Context, bail};

pub use description::Description;

/// Reads a file as a whole and describes it.
///
/// # Errors
/// A file that cannot be read, is of no known kind, or is broken beyond use.
pub fn describe(path: &Path) -> anyhow::Result<Description> {
    let at = || format!("{}", path.display());
    let metadata = std::fs::metadata(path).with_context(at)?;
    if metadata.is_dir() {
        bail!("{}: expected a file, found a directory", path.display());
    }
    let mut file = File::open(path).with_context(at)?;
    let mut head = Vec::new();
    file.by_ref()
        .take(1 << 16)
        .read_to_end(&mut head)
        .with_context(at)?;
    file.rewind().with_context(at)?;
    if head.is_empty() {
        bail!("{}: the file is empty", path.display());
    }
    let reader = BufReader::new(file);
    if image::is_image(&head) {
        return image::describe(reader).with_context(at);
    }
    if session::is_session(&head) {
        return session::describe(reader).with_context(at);
    }
    if acerra_autopilot::sniff(&head).is_some() {
        return flight_log::describe(reader).with_context(at);
    }
    if acerra_cphd::is_cphd(&head) {
        return phase_history::describe(reader).with_context(at);
    }
    let format = acerra_formats::recognise(path).with_context(at)?;
    if format.is_some() && !radar::is_log(&head) {
        return foreign::describe(path).with_context(at);
    }
    if radar::is_radar(&head) && !gnss::is_archive(&head) {
        return radar::describe(reader).with_context(at);
    }
    if configuration::is_configuration(&head) {
        return configuration::describe(reader, path).with_context(at);
    }
    if gnss::is_gnss(&head) {
        return gnss::describe(reader).with_context(at);
    }
    if acerra_geo::read::sniff(&head).is_some() {
        return trajectory::describe(path, reader).with_context(at);
    }
    if acerra_geo::geoid::is_grid(&head, metadata.len()) {
        return geoid::describe(reader).with_context(at);
    }
    if acerra_geo::terrain::is_raster(&head) {
        return terrain::describe(path).with_context(at);
    }
    bail!(
        "{}: not a kind that is known; expected a radar log (MRM capture, MRM-RET text, NPZ, CPHD, \
         SEG-Y, DZT, DT1 with HD, rd3 or rd7 with rad, gprMax, HDF5, MATLAB, Touchstone, FMCW), a \
         trajectory (.pos, CSV, NMEA, Motive export), a flight log (.bin, .ulg, .tlog, MCAP), RINEX, \
         UBX, RTCM 3, SP3, ANTEX, an RTKLIB configuration, a raster of heights (GeoTIFF, ESRI ASCII, XYZ), a geoid \
         grid (.gtx, .pgm, DAC, GRD) or an image.npz",
        path.display()
    )
}
