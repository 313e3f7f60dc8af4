//! Antenna calibrations for rover and base, by the names of their antennas.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::sync::Arc;

use acerra_gnss::antex::{AntennaCalibration, AntexFile, read_antex};
use acerra_gnss::conf::ConfInputs;
use acerra_gnss::input::{Limits, Lines};
use acerra_gnss::{ObservationData, PpkOptions};

use super::PositioningError;

/// Source of antenna calibrations.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AntennaInput {
    /// An ANTEX file; without a file antennas count as points.
    pub file: Option<PathBuf>,
    /// The rover's antenna.
    pub rover: AntennaName,
    /// The base's antenna.
    pub base: AntennaName,
}

/// Antenna of a receiver.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AntennaName {
    /// The antenna named in the log's header.
    #[default]
    Header,
    /// The antenna of the given name.
    Given(String),
    /// No correction.
    None,
}

impl From<&ConfInputs> for AntennaInput {
    /// Meaning of names as in RTKLIB's settings: an empty name is no antenna, `*` the antenna of the log.
    fn from(conf: &ConfInputs) -> Self {
        let named = |name: &str| match name {
            "" => AntennaName::None,
            "*" => AntennaName::Header,
            name => AntennaName::Given(name.to_owned()),
        };
        Self {
            file: conf.antenna_file.as_ref().map(|f| PathBuf::from(&f.name)),
            rover: named(&conf.rover_antenna),
            base: named(&conf.base_antenna),
        }
    }
}

impl AntennaInput {
    /// This input, without the file where neither antenna is corrected.
    #[must_use]
    pub fn if_any(self) -> Self {
        match self.rover == AntennaName::None && self.base == AntennaName::None {
            true => Self::default(),
            false => self,
        }
    }

    /// The options with the calibrations of rover and base, and a warning about each missing calibration.
    ///
    /// # Errors
    /// A file that cannot be read; an antenna given by name that the file lacks.
    pub(super) fn apply(
        &self,
        options: &PpkOptions,
        logs: [&ObservationData; 2],
        warnings: &mut Vec<String>,
    ) -> Result<PpkOptions, PositioningError> {
        let Some(path) = &self.file else {
            return Ok(options.clone());
        };
        let place = || path.display().to_string();
        let file = File::open(path).map_err(|cause| PositioningError::Open {
            path: path.clone(),
            cause,
        })?;
        let mut lines = Lines::new(BufReader::new(file), Limits::default());
        let (antex, report) =
            read_antex(&mut lines).map_err(|cause| PositioningError::Content {
                path: path.clone(),
                cause,
            })?;
        warnings.extend(
            report
                .dropped
                .iter()
                .map(|d| format!("{}: dropped for {}: {}", place(), d.reason, d.count)),
        );
        let mut find = |wanted: &AntennaName, log: &ObservationData, whose: &'static str| {
            let found = find(&antex, wanted, &log.station.antenna).map_err(|name| {
                PositioningError::Antenna {
                    path: path.clone(),
                    receiver: whose,
                    found: name,
                }
            })?;
            warnings.extend(
                found
                    .1
                    .map(|remark| format!("{}: the {whose}'s {remark}", place())),
            );
            Ok(found.0.map(Arc::new))
        };
        let rover = find(&self.rover, logs[0], "rover")?;
        let base = find(&self.base, logs[1], "base")?;
        Ok(options
            .clone()
            .with_rover_calibration(rover)
            .with_base_calibration(base))
    }
}

/// A calibration, and the remarks on it.
type Found = (Option<AntennaCalibration>, Option<String>);

/// The calibration of the antenna; the given name where the file lacks the antenna.
fn find(antex: &AntexFile, wanted: &AntennaName, header: &str) -> Result<Found, String> {
    let name = match wanted {
        AntennaName::None => return Ok((None, None)),
        AntennaName::Given(name) => name.as_str(),
        AntennaName::Header if header.trim().is_empty() => {
            let remark = "log names no antenna: the antenna counts as a point";
            return Ok((None, Some(remark.to_owned())));
        }
        AntennaName::Header => header,
    };
    let words = |text: &str| {
        text.split_whitespace()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    match antex.find(name) {
        Some(found) => {
            let same = words(&found.antenna).starts_with(&words(name));
            let remark = format!("antenna {name:?} is calibrated as {:?} only", found.antenna);
            Ok((Some(found.clone()), (!same).then_some(remark)))
        }
        None if matches!(wanted, AntennaName::Given(_)) => Err(name.to_owned()),
        None => {
            let remark =
                format!("antenna {name:?} is not calibrated there: the antenna counts as a point");
            Ok((None, Some(remark)))
        }
    }
}
