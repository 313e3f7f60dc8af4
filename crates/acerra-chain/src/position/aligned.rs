//! A position for every trace that enters the image.

use std::ops::Range;

use acerra_geo::interpolate::{Interpolated, path_length_per_trace_m};
use acerra_geo::trajectory::SolutionStatus;

use crate::choices::AntennaAxis;
use crate::position::boresight::Boresights;

/// The traces that enter the image, with their positions. All lists but `all` have one entry for each such
/// trace, track after track.
#[derive(Clone, Debug, Default)]
pub struct Aligned {
    /// Numbers of the traces in their log.
    pub traces: Vec<usize>,
    /// Radar time of the traces (s).
    pub time_s: Vec<f64>,
    /// Place of the phase centre: east, north, up (m).
    pub position_m: Vec<[f64; 3]>,
    /// Vectors from the phase centre to transmitter and receiver (m); empty for monostatic traces.
    pub antennas_from_place_m: Vec<[[f64; 3]; 2]>,
    /// Standard deviations of the places (m); empty where the trajectory states none.
    pub sigma_m: Vec<[f64; 3]>,
    /// Solution status.
    pub status: Vec<SolutionStatus>,
    /// Height of the phase centre above the ground below it (m).
    pub height_m: Vec<f64>,
    /// Boresight of an antenna fixed to the platform: straight down in the recorded attitude's axes.
    pub boresight: Boresights,
    /// Downward axis of the gimbal; empty unless every track has the gimbal's attitude.
    pub gimbal_down: Boresights,
    /// Forward axis of the gimbal; empty unless every track has the gimbal's attitude.
    pub gimbal_forward: Boresights,
    /// First entries of all lines and tracks but the first.
    pub line_starts: Vec<usize>,
    /// Length of path that each trace represents on its line (m).
    pub path_m: Vec<f64>,
    /// The places of all traces of the log, with their sources.
    pub all: Vec<Interpolated>,
    /// Whether a platform is at rest for a tenth of the time or more, so that its traces are weighted by path by
    /// default.
    pub is_often_at_rest: bool,
    /// Heights by the radar, where these replace the positions' heights.
    pub radar_height: Option<HeightsReplaced>,
}

/// Comparison of the heights by the radar with the positions' heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightsReplaced {
    /// Standard deviation of the positions' heights about the radar's heights, without their common level
    /// (m).
    pub positions_off_m: f64,
    /// Median of the stated standard deviations of the positions' heights (m), if any.
    pub stated_m: Option<f64>,
    /// Standard deviation of a height by the radar (m).
    pub sigma_m: f64,
    /// Share of the traces whose echo was used.
    pub picked: f64,
}

impl Aligned {
    /// First and last moving trace of a platform that is at rest for a tenth of the time or more.
    #[must_use]
    pub fn moving(&self) -> Option<[usize; 2]> {
        let [first, last] = [self.traces.first()?, self.traces.last()?];
        self.is_often_at_rest.then_some([*first, *last])
    }

    /// The lines of a part of the traces, each as the range of its entries, counted from the part's first.
    #[must_use]
    pub fn lines(&self, part: Range<usize>) -> Vec<Range<usize>> {
        let starts = self.line_starts.iter().copied();
        let within: Vec<usize> = starts
            .filter(|start| part.start < *start && *start < part.end)
            .map(|start| start - part.start)
            .collect();
        let from = std::iter::once(0).chain(within.iter().copied());
        let to = within.iter().copied().chain([part.len()]);
        from.zip(to).map(|(from, to)| from..to).collect()
    }

    /// Path (m) that each trace represents, along the lines only.
    pub(crate) fn path_along_lines_m(&self, position_m: &[[f64; 3]]) -> Vec<f64> {
        let lines = self.lines(0..position_m.len());
        let path_m = |line: Range<usize>| path_length_per_trace_m(&position_m[line]);
        lines.into_iter().flat_map(path_m).collect()
    }

    /// Separate transmitters and receivers (m); `None` for monostatic traces.
    #[must_use]
    pub fn antennas_m(&self) -> Option<[Vec<[f64; 3]>; 2]> {
        if self.antennas_from_place_m.is_empty() {
            return None;
        }
        let of = |antenna: usize| {
            let places = self.position_m.iter().zip(&self.antennas_from_place_m);
            let place = |(p, offsets): (&[f64; 3], &[[f64; 3]; 2])| {
                std::array::from_fn(|axis| p[axis] + offsets[antenna][axis])
            };
            places.map(place).collect()
        };
        Some([of(0), of(1)])
    }

    /// Transmitter and receiver of trace `k` (m).
    ///
    /// # Panics
    /// No trace `k`.
    #[must_use]
    pub fn antennas_at_m(&self, k: usize) -> [[f64; 3]; 2] {
        let place_m = self.position_m[k];
        match self.antennas_from_place_m.get(k) {
            None => [place_m; 2],
            Some(offsets) => {
                offsets.map(|from| std::array::from_fn(|axis| place_m[axis] + from[axis]))
            }
        }
    }

    /// Boresights of the antenna; `None` where the boresight is assumed to be straight down.
    #[must_use]
    pub const fn boresights(&self, axis: AntennaAxis) -> Option<&Boresights> {
        match axis {
            AntennaAxis::Attitude => Some(&self.boresight),
            AntennaAxis::Vertical => None,
            AntennaAxis::Gimbal => Some(&self.gimbal_down),
            AntennaAxis::GimbalForward => Some(&self.gimbal_forward),
        }
    }

    /// Appends the traces of another track.
    pub(crate) fn append(&mut self, mut other: Self) {
        // Deviations are given for all traces or for none.
        if self.traces.is_empty() || !(self.sigma_m.is_empty() || other.sigma_m.is_empty()) {
            self.sigma_m.append(&mut other.sigma_m);
        } else {
            self.sigma_m.clear();
        }
        let (before, more) = (self.traces.len(), other.traces.len());
        if !(self.antennas_from_place_m.is_empty() && other.antennas_from_place_m.is_empty()) {
            // The other track is monostatic.
            self.antennas_from_place_m.resize(before, [[0.0; 3]; 2]);
            other.antennas_from_place_m.resize(more, [[0.0; 3]; 2]);
            self.antennas_from_place_m
                .append(&mut other.antennas_from_place_m);
        }
        self.boresight
            .append_or_level(before, other.boresight, more);
        self.gimbal_down.append_or_none(before, other.gimbal_down);
        self.gimbal_forward
            .append_or_none(before, other.gimbal_forward);
        self.line_starts
            .extend((before > 0 && more > 0).then_some(before));
        self.line_starts
            .extend(other.line_starts.iter().map(|start| before + start));
        self.traces.append(&mut other.traces);
        self.time_s.append(&mut other.time_s);
        self.position_m.append(&mut other.position_m);
        self.status.append(&mut other.status);
        self.height_m.append(&mut other.height_m);
        self.path_m.append(&mut other.path_m);
        self.all.append(&mut other.all);
        self.is_often_at_rest |= other.is_often_at_rest;
        self.radar_height = self.radar_height.or(other.radar_height);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two lines of three traces 1 m apart, walked to and fro 5 m from one another.
    fn two_lines() -> Aligned {
        let position_m = [0.0, 1.0, 2.0, 2.0, 1.0, 0.0]
            .iter()
            .enumerate()
            .map(|(k, x_m)| [*x_m, if k < 3 { 0.0 } else { 5.0 }, 1.0])
            .collect();
        let mut aligned = Aligned {
            traces: (0..6).collect(),
            line_starts: vec![3],
            position_m,
            ..Aligned::default()
        };
        aligned.path_m = aligned.path_along_lines_m(&aligned.position_m);
        aligned
    }

    #[test]
    fn the_way_between_lines_is_no_path() {
        let mut aligned = two_lines();
        assert_eq!(aligned.path_m, [0.5, 1.0, 0.5, 0.5, 1.0, 0.5]);
        aligned.append(two_lines());
        assert_eq!(aligned.line_starts, [3, 6, 9]);
        assert_eq!(aligned.lines(0..12), [0..3, 3..6, 6..9, 9..12]);
        assert_eq!(aligned.lines(6..12), [0..3, 3..6]);
        assert_eq!(aligned.lines(4..8), [0..2, 2..4]);
        let along_m = aligned.path_along_lines_m(&aligned.position_m);
        assert_eq!(along_m, aligned.path_m);
    }
}
