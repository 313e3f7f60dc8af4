//! Settings of a configuration file, and those that are not followed.

use std::path::Path;

use super::error::ConfError;
use crate::options::PpkOptions;
use crate::pos::PosFormat;

/// Settings of a configuration file.
#[derive(Debug, Clone, PartialEq)]
pub struct RtklibConf {
    /// Processing options.
    pub options: PpkOptions,
    /// Layout of the solution file.
    pub format: PosFormat,
    /// Further outputs, and the files to read for them.
    pub outputs: ConfOutputs,
    /// Antennas to calibrate, and whether precise orbits are required.
    pub inputs: ConfInputs,
    /// Settings that are not followed, with the reason, in the order of the file.
    pub not_followed: Vec<NotFollowed>,
}

/// Outputs of a configuration in addition to the solution file's layout.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ConfOutputs {
    /// NMEA sentences instead of a solution file (`out-solformat = nmea`).
    pub nmea: bool,
    /// Residuals (`out-outstat = residual`).
    pub residuals: bool,
    /// Largest standard deviation of a written position (m, `out-maxsolstd`).
    pub max_sigma_m: Option<f64>,
    /// Heights above the geoid in the solution file (`out-height = geodetic`).
    pub geodetic_heights: bool,
    /// A geoid grid (`file-geoidfile`).
    pub geoid_file: Option<NamedFile>,
}

/// Inputs that a configuration names.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct ConfInputs {
    /// Whether precise orbits are used (`pos1-sateph = precise`).
    pub precise_orbits: bool,
    /// Antenna calibrations of receivers (`file-rcvantfile`).
    pub antenna_file: Option<NamedFile>,
    /// The rover's antenna (`ant1-anttype`): empty for none, `*` for the antenna of the log's header.
    pub rover_antenna: String,
    /// The base's antenna (`ant2-anttype`).
    pub base_antenna: String,
}

/// A file that a configuration names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// Line number, from 1.
    pub line: u64,
    /// The key.
    pub key: String,
    /// The name as given, or the path where [`RtklibConf::find_files`] found the file.
    pub name: String,
}

impl NamedFile {
    /// Finds the file in the folder, else in the current one.
    fn find(&mut self, folder: &Path) -> Result<(), ConfError> {
        let in_folder = folder.join(&self.name);
        if in_folder.is_file() {
            self.name = in_folder.to_string_lossy().into_owned();
            return Ok(());
        }
        if Path::new(&self.name).is_file() {
            return Ok(());
        }
        Err(ConfError::MissingFile {
            line: self.line,
            key: self.key.clone(),
            name: self.name.clone(),
            tried: in_folder,
        })
    }
}

impl RtklibConf {
    /// Finds the files that the configuration names: in the configuration's folder, else in the current one.
    /// A missing file that the configuration does not use keeps its name.
    ///
    /// # Errors
    /// [`ConfError::MissingFile`] with line and key.
    pub fn find_files(&mut self, folder: &Path) -> Result<(), ConfError> {
        let antennas = [&self.inputs.rover_antenna, &self.inputs.base_antenna];
        let needs_antennas = antennas.iter().any(|name| !name.is_empty());
        let needs_geoid = self.outputs.nmea || self.outputs.geodetic_heights;
        for (file, is_needed) in [
            (&mut self.inputs.antenna_file, needs_antennas),
            (&mut self.outputs.geoid_file, needs_geoid),
        ] {
            let found = file.as_mut().map_or(Ok(()), |file| file.find(folder));
            if is_needed {
                found?;
            }
        }
        Ok(())
    }
}

/// A setting that has no effect here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotFollowed {
    /// Line number, from 1.
    pub line: u64,
    /// The key.
    pub key: String,
    /// The value as given.
    pub value: String,
    /// Reason.
    pub reason: NotFollowedReason,
}

/// Reason for which a setting has no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum NotFollowedReason {
    /// No program of the RTKLIB family has such a key.
    UnknownKey,
    /// The key is known, but this value is not supported.
    Unsupported,
    /// The key concerns real-time streams or displays.
    NotForPostProcessing,
}

impl std::fmt::Display for NotFollowed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            line,
            key,
            value,
            reason,
        } = self;
        let reason = match reason {
            NotFollowedReason::UnknownKey => "unknown key",
            NotFollowedReason::Unsupported => "not supported",
            NotFollowedReason::NotForPostProcessing => "has no meaning in post-processing",
        };
        write!(f, "line {line}: {key} = {value}: {reason}")
    }
}
