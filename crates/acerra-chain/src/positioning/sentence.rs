//! Remarks of a positioning run as sentences.

use acerra_geo::time::GpsTime;
use acerra_gnss::PpkWarning;

/// A remark of the run as a sentence.
#[must_use]
pub fn ppk_sentence(warning: &PpkWarning) -> String {
    let time = |t: GpsTime| t.format_calendar(0);
    match warning {
        PpkWarning::MissingNavigation(missing) => format!(
            "{} was observed in {} epochs from {} to {} without {}",
            missing.satellite,
            missing.epochs,
            time(missing.span.0),
            time(missing.span.1),
            if missing.channel_missing {
                "its frequency channel"
            } else {
                "a usable ephemeris"
            }
        ),
        PpkWarning::SystemWithoutNavigation(system) => {
            format!("no navigation data of {system} at all: its satellites are not used")
        }
        PpkWarning::BaseGap(gap) => {
            format!(
                "the base's log has a gap from {} to {}",
                time(gap.from),
                time(gap.to)
            )
        }
        PpkWarning::HeaderPositionUsed {
            distance_from_single_m,
        } => {
            let distance = distance_from_single_m.map_or_else(String::new, |d| {
                format!(", {} m from its own single-point position", fixed(d, 1))
            });
            format!("the base position was taken from its file's header{distance}")
        }
        PpkWarning::DefaultIonosphere => {
            "no broadcast ionosphere coefficients: the model's defaults were used".to_owned()
        }
        PpkWarning::NoUsablePhases { base } => format!(
            "the {}'s log has no usable carrier phases: ambiguities cannot be resolved",
            if *base { "base" } else { "rover" }
        ),
        PpkWarning::IdenticalFiles => "rover and base hold the same observations".to_owned(),
        PpkWarning::BaseMoves { speed_m_s } => format!(
            "the base moves at {} m/s by its Doppler shifts: are rover and base swapped?",
            fixed(*speed_m_s, 1)
        ),
        PpkWarning::BasePositionDoubtful { distance_m } => format!(
            "the base position given is {} m from the base's own single-point position",
            fixed(*distance_m, 0)
        ),
        other => format!("{other:?}"),
    }
}

fn fixed(value: f64, digits: usize) -> String {
    format!("{value:.digits$}")
}
