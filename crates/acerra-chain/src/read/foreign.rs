//! Files of other makers' radars: one channel as radargram or spectra, with the places of its traces.

use std::path::Path;

use acerra_formats::{
    Axis, Channel, Contradiction, FormatError, Limits, Positions, Recording, Values, open,
};
use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::trajectory::{Frame, TimeOrigin};
use acerra_radar::{Radargram, RadargramError, Samples, Spectrum};
use num_complex::Complex64;

use super::antenna_frequency::off_antenna;
use super::trace_positions::TracePositions;

/// Ends of the line along which traces were recorded, x east, y north, z up (m): the first and the last trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Place of the first trace.
    pub start_m: [f64; 3],
    /// Place of the last trace.
    pub end_m: [f64; 3],
}

impl Line {
    /// Length (m).
    #[must_use]
    pub fn length_m(&self) -> f64 {
        let squares = (0..3).map(|k| (self.end_m[k] - self.start_m[k]).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// Places of traces: by the odometer's share of the distance where there is one, else evenly spaced.
    fn places(&self, traces: usize, along_m: Option<&[f64]>) -> Vec<[f64; 3]> {
        let last = traces.saturating_sub(1).max(1) as f64;
        let way = along_m.and_then(|a| Some((*a.first()?, *a.last()?)));
        let share = |i: usize| match (way, along_m) {
            (Some((from, to)), Some(along)) if to != from => (along[i] - from) / (to - from),
            _ => i as f64 / last,
        };
        (0..traces)
            .map(|i| {
                let s = share(i);
                [0, 1, 2].map(|k| self.start_m[k] + s * (self.end_m[k] - self.start_m[k]))
            })
            .collect()
    }
}

/// The traces of a channel.
pub enum Signal {
    /// Over fast time.
    Radargram(Radargram),
    /// Over frequency.
    Spectrum(Spectrum),
}

/// A channel of a file, and the remarks on it.
pub struct Foreign {
    pub signal: Signal,
    pub positions: Option<TracePositions>,
    pub is_untimed: bool,
    pub format: &'static str,
    pub remarks: Vec<String>,
    pub contradictions: Vec<Contradiction>,
}

/// Why such a file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ForeignError {
    /// It cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Its traces make no radargram.
    #[error(transparent)]
    Radargram(#[from] RadargramError),
}

/// Reads a file of another maker's radar.
///
/// # Errors
/// Errors of the reader; a channel that the file lacks.
pub fn read_foreign(
    path: &Path,
    channel: Option<&str>,
    line: Option<Line>,
) -> Result<Foreign, ForeignError> {
    let recording = open(path, &Limits::default())?;
    let chosen = recording.channel(channel)?;
    let mut remarks = remarks(&recording, chosen, channel.is_some());
    let mut contradictions = recording.contradictions.clone();
    let positions = match line {
        Some(line) => {
            contradictions.extend(off_length(chosen, &line));
            Some(along(chosen, &line, &mut remarks))
        }
        None => chosen.positions.clone().map(placed).map(|mut placed| {
            if placed.frame == Frame::Local {
                placed.antennas_m.clone_from(&chosen.antennas_m);
            }
            placed
        }),
    };
    let numbers = || (0..chosen.traces).map(|i| i as f64).collect();
    let time_s = chosen.time_s.clone().unwrap_or_else(numbers);
    let signal = signal(chosen, time_s)?;
    if let (Some(nominal), Signal::Radargram(radargram)) = (&chosen.antenna_frequency, &signal) {
        contradictions.extend(off_antenna(nominal, radargram));
    }
    Ok(Foreign {
        signal,
        positions,
        is_untimed: chosen.time_s.is_none(),
        format: recording.format.name(),
        remarks,
        contradictions,
    })
}

/// Traces along a line. Separate antennas are assumed one behind the other: the distance in the file does not
/// give their direction, which matters little below and to the side of the line.
fn along(channel: &Channel, line: &Line, remarks: &mut Vec<String>) -> TracePositions {
    let places = line.places(channel.traces, channel.along_m.as_deref());
    let mut placed = TracePositions {
        is_by_line_ends: true,
        ..TracePositions::from(places)
    };
    let length_m = line.length_m();
    if let Some(apart_m) = channel.antenna_separation_m
        && length_m > 0.0
    {
        let half = [0, 1, 2].map(|k| (line.end_m[k] - line.start_m[k]) / length_m * apart_m / 2.0);
        let moved = |sign: f64| {
            let places = placed.position_m.iter();
            places
                .map(|p| [0, 1, 2].map(|k| p[k] + sign * half[k]))
                .collect()
        };
        placed.antennas_m = Some([moved(1.0), moved(-1.0)]);
        remarks.push(format!(
            "transmitter and receiver, {apart_m} m apart, are assumed one behind the other along the line, \
             unless [radar] antenna_offset_m states otherwise"
        ));
    }
    placed
}

fn signal(channel: &Channel, time_s: Vec<f64>) -> Result<Signal, RadargramError> {
    match &channel.axis {
        Axis::FastTime {
            start_s, step_s, ..
        } => {
            let samples = match &channel.values {
                Values::Real(v) => Samples::Real(v.clone()),
                Values::Complex(v) => Samples::Complex(v.clone()),
            };
            Radargram::new(time_s, *start_s, *step_s, samples).map(Signal::Radargram)
        }
        Axis::Frequency(hz) => {
            let values = match &channel.values {
                Values::Real(v) => v
                    .iter()
                    .map(|x| Complex64::new(f64::from(*x), 0.0))
                    .collect(),
                Values::Complex(v) => v
                    .iter()
                    .map(|z| Complex64::new(f64::from(z.re), f64::from(z.im)))
                    .collect(),
            };
            Spectrum::new(hz.clone(), values, time_s).map(Signal::Spectrum)
        }
    }
}

/// Places in a local frame; places on the Earth relative to the first.
fn placed(positions: Positions) -> TracePositions {
    let places = match positions {
        Positions::Local(places) => return TracePositions::from(places),
        Positions::Geodetic(places) => places,
    };
    let geodetic = |p: &[f64; 3]| Geodetic::from_degrees(p[0], p[1], p[2]);
    let Some(first) = places.first() else {
        return TracePositions::from(Vec::new());
    };
    let frame = EnuFrame::new(geodetic(first));
    TracePositions {
        position_m: places
            .iter()
            .map(|p| frame.enu_from_ecef(ecef_from_geodetic(&geodetic(p))))
            .collect(),
        antennas_m: None,
        line_starts: Vec::new(),
        is_by_line_ends: false,
        frame: Frame::Enu(frame),
        time_origin: TimeOrigin::Relative,
    }
}

/// Remarks on a file and the channel that was read from the file.
fn remarks(recording: &Recording, chosen: &Channel, is_named: bool) -> Vec<String> {
    let mut remarks = recording.remarks.clone();
    if recording.skipped_bytes > 0 {
        remarks.push(format!(
            "{} bytes belong to no whole trace and were skipped",
            recording.skipped_bytes
        ));
    }
    if recording.channels.len() > 1 && !is_named {
        let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        remarks.push(format!(
            "channels {}; {} is used, [radar] channel names another",
            names.join(", "),
            chosen.name
        ));
    }
    remarks
}

/// The odometer's distance compared with the length of the line that the campaign states.
fn off_length(channel: &Channel, line: &Line) -> Option<Contradiction> {
    /// Share of the length that an odometer may be off.
    const TOLERANCE: f64 = 0.05;
    let along = channel.along_m.as_ref()?;
    let way_m = (along.last()? - along.first()?).abs();
    let length_m = line.length_m();
    ((way_m - length_m).abs() > TOLERANCE * length_m.max(way_m)).then(|| Contradiction {
        about: "length of the line: [radar] line_start_m and line_end_m, distances in the file"
            .to_owned(),
        used: length_m,
        other: way_m,
        unit: "m",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_odometer_places_traces_along_the_line() {
        let line = Line {
            start_m: [1.0, 2.0, 0.5],
            end_m: [1.0, 6.0, 0.5],
        };
        let even = line.places(5, None);
        assert_eq!(even[1], [1.0, 3.0, 0.5]);
        let wheel = line.places(3, Some(&[10.0, 10.5, 12.0]));
        assert_eq!(wheel[1], [1.0, 3.0, 0.5]);
        assert_eq!(wheel[2], line.end_m);
        assert_eq!(line.places(1, None), [line.start_m]);
    }
}
