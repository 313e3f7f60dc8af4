//! RTKLIB configuration files (`.conf`): `key =value # comment` lines.

mod apply;

use crate::input::{Limits, LineSource, Lines, ReadError};
use crate::pos::PosFormat;
use crate::{PpkOptions, RuleSet};

/// What a configuration file asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct RtklibConf {
    /// Processing options.
    pub options: PpkOptions,
    /// How the solution file is to be written.
    pub format: PosFormat,
    /// What else is to be written, and which files are to be read for it.
    pub outputs: ConfOutputs,
    /// Which antennas are to be calibrated, and whether precise orbits are wanted.
    pub inputs: ConfInputs,
    /// Settings that are not followed, with the reason, in the order of the file.
    pub not_followed: Vec<NotFollowed>,
}

/// Outputs that a configuration asks for besides the solution file's layout.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ConfOutputs {
    /// NMEA sentences instead of a solution file (`out-solformat = nmea`).
    pub nmea: bool,
    /// Residuals (`out-outstat = residual`).
    pub residuals: bool,
    /// Largest standard deviation of a position that is written (m, `out-maxsolstd`).
    pub max_sigma_m: Option<f64>,
    /// A geoid grid (`file-geoidfile`).
    pub geoid_file: Option<String>,
}

/// Inputs that a configuration names.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct ConfInputs {
    /// Precise orbits are to be used (`pos1-sateph = precise`).
    pub precise_orbits: bool,
    /// Antenna calibrations of receivers (`file-rcvantfile`).
    pub antenna_file: Option<String>,
    /// The rover's antenna (`ant1-anttype`): empty for none, `*` for that of the log's header.
    pub rover_antenna: String,
    /// The base's antenna (`ant2-anttype`).
    pub base_antenna: String,
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
    /// Why.
    pub reason: NotFollowedReason,
}

/// Why a setting has no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum NotFollowedReason {
    /// No program of the RTKLIB family has such a key.
    UnknownKey,
    /// The key is known, this value of it is not supported.
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

/// Why a configuration cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A line is neither empty, a comment, nor `key = value`.
    #[error("line {line}: expected key = value, found {found:?}")]
    Line {
        /// Line number, from 1.
        line: u64,
        /// The line, shortened.
        found: String,
    },
    /// A value cannot be what its key needs.
    #[error("line {line}: {key}: expected {expected}, found {found:?}")]
    Value {
        /// Line number, from 1.
        line: u64,
        /// The key.
        key: String,
        /// What would do.
        expected: String,
        /// The value given.
        found: String,
    },
    /// The file asks for a kind of processing that is not offered.
    #[error("line {line}: {key} = {value} is not supported")]
    Unsupported {
        /// Line number, from 1.
        line: u64,
        /// The key.
        key: String,
        /// The value given.
        value: String,
    },
}

/// What a key without an entry means: RTKLIB's own defaults, as its manual lists them.
///
/// They differ from [`PpkOptions::rtklib`], which are the settings usual for short baselines.
#[must_use]
pub fn rtklib_defaults(rules: RuleSet) -> PpkOptions {
    use crate::{AmbiguityMode, BasePosition, Dynamics, GlonassAmbiguity, PositioningMode};
    let common = (match rules {
        RuleSet::Rtklib => PpkOptions::rtklib(),
        // Its own defaults, meant for walking pace.
        RuleSet::Demo5 => PpkOptions::demo5().with_dynamics(Some(Dynamics {
            horizontal_noise: 0.1,
            vertical_noise: 0.01,
        })),
    })
    .with_frequencies(2)
    .with_base_position(BasePosition::Ecef([6_378_137.0, 0.0, 0.0]));
    match rules {
        RuleSet::Rtklib => common
            .with_mode(PositioningMode::Single)
            .with_ambiguity(AmbiguityMode::Continuous)
            .with_glonass_ambiguity(GlonassAmbiguity::On),
        RuleSet::Demo5 => common,
    }
}

/// Reads a configuration file on top of [`rtklib_defaults`].
///
/// Files that use keys which only demo5 and RTKLIB-EX have (`pos2-arfilter`,
/// `pos2-varholdamb`, …) get their rules and defaults; others those of `rules`.
///
/// ```
/// use acerra_gnss::{PositioningMode, RuleSet, conf::read_conf};
/// let text = "pos1-posmode =kinematic # (0:single,1:dgps,…)\npos1-elmask =10 # (deg)\n\
///             misc-colour =red\n";
/// let conf = read_conf(text.as_bytes(), RuleSet::Rtklib)?;
/// assert_eq!(conf.options.mode, PositioningMode::Kinematic);
/// assert!((conf.options.elevation_mask_rad.to_degrees() - 10.0).abs() < 1e-12);
/// assert_eq!(conf.not_followed[0].key, "misc-colour");
/// # Ok::<(), acerra_gnss::conf::ConfError>(())
/// ```
///
/// # Errors
/// [`ConfError`] with line and key for a line or value that cannot be understood, and for kinds
/// of processing that are not offered (moving base, PPP, streams as base position).
pub fn read_conf(reader: impl std::io::BufRead, rules: RuleSet) -> Result<RtklibConf, ConfError> {
    let limits = Limits {
        max_bytes: 1 << 20,
        ..Limits::default()
    };
    let mut lines = Lines::new(reader, limits);
    let mut settings = Vec::new();
    while lines.advance()? {
        if let Some(setting) = setting(lines.line(), lines.number())? {
            settings.push(setting);
        }
    }
    let is_demo5 = settings.iter().any(|s| apply::is_demo5_key(&s.key));
    let rules = if is_demo5 { RuleSet::Demo5 } else { rules };
    let mut conf = RtklibConf {
        options: rtklib_defaults(rules),
        format: PosFormat::default(),
        outputs: ConfOutputs::default(),
        inputs: ConfInputs::default(),
        not_followed: Vec::new(),
    };
    apply::apply(&settings, &mut conf)?;
    Ok(conf)
}

/// One line of the file.
#[derive(Debug, Clone)]
struct Setting {
    line: u64,
    key: String,
    value: String,
}

fn setting(bytes: &[u8], line: u64) -> Result<Option<Setting>, ConfError> {
    let text = String::from_utf8_lossy(bytes);
    let content = text.split('#').next().unwrap_or("").trim();
    if content.is_empty() || content.starts_with('%') {
        return Ok(None);
    }
    let Some((key, value)) = content.split_once('=') else {
        let found = content.chars().take(60).collect();
        return Err(ConfError::Line { line, found });
    };
    Ok(Some(Setting {
        line,
        key: key.trim().to_owned(),
        value: value.trim().to_owned(),
    }))
}
