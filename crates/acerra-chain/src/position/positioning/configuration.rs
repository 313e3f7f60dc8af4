//! The RTKLIB configuration of a campaign's positioning.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use acerra_gnss::conf::{ConfError, NotFollowed, read_conf};
use acerra_gnss::{PpkOptions, RuleSet};

use super::antennas::AntennaInput;

/// Settings of a configuration file for a campaign's positioning.
#[derive(Clone, Debug)]
pub struct GnssConfiguration {
    /// The options, with the safeguards of `acerra ppk`.
    pub options: PpkOptions,
    /// Whether precise orbits must be among the navigation files.
    pub needs_precise_orbits: bool,
    /// Antenna calibrations; the path of their file is relative to the configuration's folder.
    pub antennas: AntennaInput,
    /// Settings that are not followed.
    pub not_followed: Vec<NotFollowed>,
}

/// Reason for which a configuration cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GnssConfigurationError {
    /// The operating system does not open the file.
    #[error("{}: {cause}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// The content is not a configuration.
    #[error("{}: {cause}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The place in it, what was expected and what was found.
        cause: ConfError,
    },
}

impl GnssConfiguration {
    /// Reads the configuration at `path`.
    ///
    /// # Errors
    /// A file that cannot be opened or is not a configuration; the message contains the file's name.
    pub fn read(path: &Path) -> Result<Self, GnssConfigurationError> {
        let file = File::open(path).map_err(|cause| GnssConfigurationError::Open {
            path: path.to_owned(),
            cause,
        })?;
        let content = |cause| GnssConfigurationError::Content {
            path: path.to_owned(),
            cause,
        };
        let mut conf = read_conf(BufReader::new(file), RuleSet::Rtklib).map_err(content)?;
        conf.find_files(path.parent().unwrap_or(Path::new("")))
            .map_err(content)?;
        let antennas = AntennaInput::from(&conf.inputs).if_any();
        Ok(Self {
            options: conf.options.guarded(),
            needs_precise_orbits: conf.inputs.precise_orbits,
            antennas,
            not_followed: conf.not_followed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::position::positioning::AntennaName;

    #[test]
    fn a_configuration_file_is_followed_as_the_command_does() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rtklib.conf");
        let text = "pos1-posmode=kinematic\npos1-sateph=precise\nant1-anttype=*\nant2-anttype=LEIAX1202\n\
                    file-rcvantfile=igs14.atx\nmisc-colour=red\n";
        std::fs::write(&path, text).unwrap();
        let missing = GnssConfiguration::read(&path).unwrap_err().to_string();
        assert!(
            missing.contains("rtklib.conf: line 5: file-rcvantfile = igs14.atx: no such file"),
            "{missing}"
        );
        std::fs::write(folder.path().join("igs14.atx"), "").unwrap();
        let found = GnssConfiguration::read(&path).unwrap();
        assert_eq!(found.options, found.options.clone().with_safeguards());
        assert!(found.needs_precise_orbits);
        let antennas = found.antennas;
        assert_eq!(antennas.file, Some(folder.path().join("igs14.atx")));
        assert_eq!(antennas.rover, AntennaName::Header);
        assert_eq!(antennas.base, AntennaName::Given("LEIAX1202".to_owned()));
        assert_eq!(found.not_followed.len(), 1);
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rtklib.conf");
        let absent = GnssConfiguration::read(&path).unwrap_err();
        assert!(matches!(absent, GnssConfigurationError::Open { .. }));
        std::fs::write(&path, "pos1-elmask=high\n").unwrap();
        let wrong = GnssConfiguration::read(&path).unwrap_err().to_string();
        assert!(
            wrong.contains("rtklib.conf: line 1: pos1-elmask"),
            "{wrong}"
        );
    }
}
