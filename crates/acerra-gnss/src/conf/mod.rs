//! RTKLIB configuration files (`.conf`): `key =value # comment` lines.

mod antenna;
mod apply;
mod error;
pub(crate) mod names;
mod outcome;
mod output;
mod pending;
mod positioning;
mod requested;
mod setting;
mod values;
mod write;

pub use error::ConfError;
pub use requested::{
    ConfInputs, ConfOutputs, NamedFile, NotFollowed, NotFollowedReason, RtklibConf,
};
pub use write::write_conf;

use crate::input::{Limits, LineSource, Lines};
use crate::options::{PpkOptions, RuleSet};
use crate::pos::PosFormat;

/// RTKLIB's defaults for keys without an entry, as listed in its manual.
///
/// They differ from [`PpkOptions::rtklib`], which are the settings usual for short baselines.
#[must_use]
pub fn rtklib_defaults(rules: RuleSet) -> PpkOptions {
    use crate::options::{
        AmbiguityMode, BasePosition, Dynamics, GlonassAmbiguity, PositioningMode,
    };
    let common = (match rules {
        RuleSet::Rtklib => PpkOptions::rtklib(),
        // demo5's defaults, meant for walking pace.
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
/// of processing that are not offered (PPP, streams as base position).
pub fn read_conf(reader: impl std::io::BufRead, rules: RuleSet) -> Result<RtklibConf, ConfError> {
    let limits = Limits {
        max_bytes: 1 << 20,
        ..Limits::default()
    };
    let mut lines = Lines::new(reader, limits);
    let mut settings = Vec::new();
    while lines.advance()? {
        if let Some(setting) = setting::parse(lines.line(), lines.number())? {
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
