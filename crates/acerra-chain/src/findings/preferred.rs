//! Settings compared with the values that focusing prefers.

use crate::journal::finding::{Finding, Setting, Verdict};

/// A setting in force, and the value at which the strongest targets are sharpest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PreferredSetting<'a> {
    /// Name of the finding.
    pub name: &'a str,
    /// The value in force.
    pub in_force: f64,
    /// The value preferred.
    pub preferred: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Unit of the three.
    pub unit: &'static str,
    /// The settings that it comes from, as the campaign file calls them.
    pub key: &'a str,
    /// Targets that take part.
    pub targets: usize,
    /// The setting itself.
    pub setting: Setting,
    /// Largest deviation of a value that counts as determined.
    pub largest_sigma: f64,
}

/// Least number of targets that check a setting: another setting or an error of the positions may bend the
/// phases of a single target in the same way.
const LEAST_TARGETS: usize = 2;

/// Text for a single target.
const ALONE: &str = "; one target does not distinguish it from delay_ns or heights";

/// Judges a setting by its distance from the value that focusing prefers.
///
/// Errors of the positions bend the phases of targets as a wrong setting does, and not only as much
/// as they state: it is never more than doubtful.
pub(super) fn preferred_setting(seen: &PreferredSetting<'_>) -> Finding {
    let PreferredSetting {
        in_force,
        preferred,
        sigma,
        unit,
        ..
    } = *seen;
    let finding = Finding::compared(seen.name, in_force, preferred, sigma, unit);
    let is_alone = seen.targets < LEAST_TARGETS;
    Finding {
        checks: (!is_alone && sigma <= seen.largest_sigma).then_some(seen.setting),
        ..finding.at_most(Verdict::Doubtful)
    }
    .because(format!(
        "{} target{} would be sharpest {:+.3} {unit} (± {sigma:.3} {unit}) from the value in force \
         ({}{})",
        seen.targets,
        if is_alone { "" } else { "s" },
        preferred - in_force,
        seen.key,
        if is_alone { ALONE } else { "" },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_a_tenth_of_a_second_off_is_doubtful_where_focusing_knows_it_to_twenty_ms() {
        let judge = |in_force, sigma| {
            preferred_setting(&PreferredSetting {
                name: "clock_offset_focus",
                in_force,
                preferred: 6.0,
                sigma,
                unit: "s",
                key: "[trajectory] time_offset_s",
                targets: 2,
                setting: Setting::ClockOffset,
                largest_sigma: 0.1,
            })
            .verdict
        };
        assert_eq!(judge(6.1, 0.02), Verdict::Doubtful);
        assert_eq!(judge(6.1, 0.05), Verdict::Agrees);
        assert_eq!(judge(9.0, 0.02), Verdict::Doubtful);
    }
}
