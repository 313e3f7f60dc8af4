//! Output files of `acerra ppk` other than the solution file.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use acerra_geo::geoid::GeoidGrid;
use acerra_gnss::PpkSolution;
use acerra_gnss::conf::ConfOutputs;
use acerra_gnss::output::{
    position_images, within_sigma, write_attitudes, write_images, write_nmea, write_residuals,
};
use acerra_products::staging::StagedFile;
use anyhow::Context;

use super::args::Args;

/// Inputs of the other outputs, read before the positions are computed.
pub(super) struct Extras {
    pub(super) geoid: Option<Arc<GeoidGrid>>,
    images: Vec<String>,
    max_sigma_m: Option<f64>,
    residuals: Option<PathBuf>,
}

impl Extras {
    /// Reads the geoid and the names of the images.
    pub(super) fn new(args: &Args, outputs: &ConfOutputs) -> anyhow::Result<Self> {
        let heights = outputs.nmea
            || outputs.geodetic_heights
            || args.nmea.is_some()
            || args.image_positions.is_some();
        let conf = outputs.geoid_file.as_ref().map(|f| Path::new(&f.name));
        let geoid = match args.geoid.as_deref().or(conf.filter(|_| heights)) {
            Some(path) => Some(Arc::new(GeoidGrid::read(path)?)),
            None => None,
        };
        let images = match &args.images {
            Some(path) => image_names(path).with_context(|| path.display().to_string())?,
            None => Vec::new(),
        };
        Ok(Self {
            geoid,
            images,
            max_sigma_m: args.max_sigma.or(outputs.max_sigma_m),
            residuals: args
                .residuals
                .clone()
                .or_else(|| residuals_path(args, outputs)),
        })
    }

    /// The part of a solution that is written.
    pub(super) fn wanted<'a>(
        &self,
        solution: &'a PpkSolution,
    ) -> (Cow<'a, PpkSolution>, Option<String>) {
        let Some(max_m) = self.max_sigma_m else {
            return (Cow::Borrowed(solution), None);
        };
        let (kept, dropped) = within_sigma(solution, max_m);
        let remark = (dropped > 0).then(|| {
            format!("{dropped} positions with a standard deviation above {max_m} m are not written")
        });
        (Cow::Owned(kept), remark)
    }

    /// Remark on heights without a geoid.
    pub(super) fn remarks(&self, args: &Args, outputs: &ConfOutputs) -> Vec<String> {
        let nmea = outputs.nmea || args.nmea.is_some();
        let wanted = [
            (
                nmea,
                "no geoid grid: the altitudes of NMEA sentences are heights above the ellipsoid, \
                 with a geoid separation of 0",
            ),
            (
                outputs.geodetic_heights,
                "no geoid grid (--geoid or file-geoidfile): the heights are above the ellipsoid, \
                 not geodetic as the configuration asks",
            ),
        ];
        let missing = wanted.iter().filter(|(is, _)| *is && self.geoid.is_none());
        missing.map(|(_, text)| (*text).to_owned()).collect()
    }

    /// The geoid that the solution file's heights count from: one given on the command line, or
    /// one of the configuration where that asks for such heights.
    pub(super) fn solution_geoid(
        &self,
        args: &Args,
        outputs: &ConfOutputs,
    ) -> Option<Arc<GeoidGrid>> {
        let wanted = args.geoid.is_some() || outputs.geodetic_heights;
        self.geoid.clone().filter(|_| wanted)
    }

    /// Writes NMEA, residuals and image positions through staging files next to their places.
    pub(super) fn write(
        &self,
        args: &Args,
        solution: &PpkSolution,
    ) -> anyhow::Result<Vec<StagedFile>> {
        let mut written = Vec::new();
        let geoid = self.geoid.as_deref();
        if let Some(path) = &args.nmea {
            written.push(StagedFile::write(path, |to| {
                Ok(write_nmea(to, solution, geoid)?)
            })?);
        }
        if let Some(path) = &self.residuals {
            written.push(StagedFile::write(path, |to| {
                Ok(write_residuals(to, solution)?)
            })?);
        }
        if let Some(path) = &args.attitudes {
            written.push(StagedFile::write(path, |to| {
                Ok(write_attitudes(to, solution)?)
            })?);
        }
        if let (Some(path), Some(list)) = (&args.image_positions, &args.images) {
            let images = position_images(&self.images, solution)
                .with_context(|| list.display().to_string())?;
            written.push(StagedFile::write(path, |to| {
                Ok(write_images(to, &images, geoid)?)
            })?);
        }
        Ok(written)
    }
}

/// Path of a configuration file's residuals: next to the solution file.
fn residuals_path(args: &Args, outputs: &ConfOutputs) -> Option<PathBuf> {
    let output = args
        .output
        .as_deref()
        .filter(|path| *path != Path::new("-"))?;
    let mut name = output.as_os_str().to_owned();
    name.push(".residuals.csv");
    outputs.residuals.then(|| name.into())
}

/// The images in a folder by name, or the lines of a text file.
fn image_names(path: &Path) -> anyhow::Result<Vec<String>> {
    const SUFFIXES: [&str; 9] = [
        "jpg", "jpeg", "tif", "tiff", "png", "dng", "arw", "raw", "cr2",
    ];
    if !path.is_dir() {
        let text = fs::read_to_string(path)?;
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        return Ok(lines.map(str::to_owned).collect());
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(path)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let suffix = Path::new(&name).extension().map(|s| s.to_ascii_lowercase());
        if suffix.is_some_and(|s| SUFFIXES.iter().any(|known| s == *known)) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}
