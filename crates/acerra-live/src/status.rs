//! Status of the live image, shown next to the picture.

use acerra_geo::trajectory::SolutionStatus;
use acerra_record::driver::LinkCounts;
use acerra_record::session::Silence;
use serde::Serialize;

use crate::latency::LatencyFigures;

/// Counts of the pulses by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PulseCounts {
    /// Whole scans that came.
    pub came: u64,
    /// Pulses in the image.
    pub imaged: u64,
    /// Pulses that wait for the clock, for the position after them, or for enough pulses to begin with.
    pub waiting: u64,
    /// Pulses without a position: before the first position, in a gap, or given up waiting.
    pub without_position: u64,
    /// Pulses given up before the platform moved enough to show the heading by which the lever arm turns.
    pub without_heading: u64,
    /// Pulses below the least height above the image plane: before take-off, in the climb and after the descent.
    pub too_low: u64,
    /// Pulses that cleaning gave up.
    pub not_cleaned: u64,
    /// Pulses dropped because imaging was too slow.
    pub too_many: u64,
    /// Pulses of a discarded picture, which was started again after a better clock had moved the pulses' times.
    pub begun_anew: u64,
    /// Records of the recording that the imaging missed.
    pub missed_records: u64,
}

/// Imaged pulses by the solution status of their positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ByKind {
    /// Carrier phase with integer ambiguities.
    pub fixed: u64,
    /// Carrier phase with real ambiguities.
    pub float: u64,
    /// Anything less.
    pub other: u64,
}

impl ByKind {
    /// Counts a pulse.
    pub fn count(&mut self, status: SolutionStatus) {
        match status {
            status if status.is_fixed() => self.fixed += 1,
            SolutionStatus::Float => self.float += 1,
            _ => self.other += 1,
        }
    }
}

/// Reason why the picture was started again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BegunAnew {
    /// Earlier source of the times.
    pub before: &'static str,
    /// Offset of the times by the better clock (ms).
    pub change_ms: f64,
    /// Largest movement of pulses along the path by that offset (m).
    pub moved_m: f64,
}

/// The state of a live image.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Status {
    /// Counts of the pulses by outcome.
    pub pulses: PulseCounts,
    /// Counts of the imaged pulses by solution status.
    pub by_kind: ByKind,
    /// Kind of the latest position; none without any.
    pub position: Option<&'static str>,
    /// Largest standard deviation of the latest position (m), where the receiver states it.
    pub sigma_m: Option<f64>,
    /// A quarter of the wavelength (m), which positions must be better than.
    pub quarter_wavelength_m: f64,
    /// Positions so far.
    pub positions: u64,
    /// Standard deviation of the scans' times by the stamps alone (s).
    pub clock_sigma_s: Option<f64>,
    /// Source of those times; none before it is known.
    pub clock: Option<&'static str>,
    /// Reason why the hardware signals of the session are not used.
    pub clock_doubt: Option<String>,
    /// Reason why the picture was started again, where it was.
    pub begun_anew: Option<BegunAnew>,
    /// Height above the image plane below which pulses are not imaged (m).
    pub least_height_m: f64,
    /// Reason for which imaging waits.
    pub waits_for: Option<String>,
    /// Fast time added, once range zero is known (ns).
    pub shift_ns: Option<f64>,
    /// From a scan's last message to the picture here.
    pub latency: Option<LatencyFigures>,
    /// Part of that until its imaging began.
    pub waiting: Option<LatencyFigures>,
    /// From a scan's last message until a page reported it as drawn.
    pub drawn: Option<LatencyFigures>,
    /// The radio's link.
    pub link: LinkCounts,
    /// Instruments that are silent.
    pub silent: Vec<Silence>,
    /// Doubts about the image.
    pub doubts: Vec<String>,
}

/// Doubts about an image of pulses at such positions.
#[must_use]
pub fn doubts(status: &Status, is_height_stated: bool) -> Vec<String> {
    let mut doubts = Vec::new();
    let quarter_mm = 1e3 * status.quarter_wavelength_m;
    let ByKind {
        fixed,
        float,
        other,
    } = status.by_kind;
    let imaged = fixed + float + other;
    if other > 0 {
        doubts.push(format!(
            "{other} of {imaged} pulses have positions without carrier phase: these pulses cannot focus, \
             and the image shows their echoes at wrong places"
        ));
    }
    if float > 0 {
        doubts.push(format!(
            "{float} of {imaged} pulses have float positions: echoes may be displaced and blurred"
        ));
    }
    match status.sigma_m {
        Some(sigma_m) if sigma_m > status.quarter_wavelength_m => doubts.push(format!(
            "the latest position is known to {:.0} mm; a quarter of the wavelength is {quarter_mm:.0} mm",
            1e3 * sigma_m
        )),
        None if status.position.is_some() => doubts.push(format!(
            "the receiver states no accuracy of its position; {quarter_mm:.0} mm are needed"
        )),
        _ => {}
    }
    if let Some(trouble) = &status.clock_doubt {
        doubts.push(format!(
            "times rest on times of arrival, which latencies that nobody measured shift along the track: {trouble}"
        ));
    }
    if let Some(again) = status.begun_anew {
        doubts.push(format!(
            "the picture was started again without its first {} pulses: the better clock moved their times \
             (by {} before) by {:.1} ms, up to {:.0} mm along the path",
            status.pulses.begun_anew,
            again.before,
            again.change_ms,
            1e3 * again.moved_m
        ));
    }
    if !is_height_stated && imaged > 0 {
        doubts.push(
            "the height of the ground is assumed to be that of the first position ([live] z_m, or \
             [campaign.trajectory] origin_deg_m)"
                .to_owned(),
        );
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_that_cannot_focus_are_told() {
        let mut status = Status {
            position: Some("fixed"),
            sigma_m: Some(0.011),
            quarter_wavelength_m: 0.019,
            ..Status::default()
        };
        status.by_kind.fixed = 100;
        assert!(doubts(&status, true).is_empty());
        assert_eq!(doubts(&status, false).len(), 1);
        status.by_kind.count(SolutionStatus::Single);
        status.by_kind.count(SolutionStatus::Float);
        status.sigma_m = Some(1.4);
        let remarks = doubts(&status, true);
        assert!(remarks[0].starts_with("1 of 102 pulses have positions without carrier phase"));
        assert!(remarks[1].starts_with("1 of 102 pulses have float"));
        assert!(remarks[2].contains("1400 mm") && remarks[2].contains("19 mm"));
        status.sigma_m = None;
        assert!(doubts(&status, true)[2].contains("states no accuracy"));
    }
}
