//! Where the radar is, by the receiver's own solutions, between one and the next.

use std::collections::VecDeque;

use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::interpolate::{Flag, InterpolationOptions, Interpolator};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::matrix::{add, subtract};
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Fix, Frame, SolutionStatus, TimeOrigin, Trajectory};
use acerra_gnss::ubx::frame::Frame as UbxFrame;

use crate::nmea::NmeaFinder;
use crate::solutions::{Position, Solutions};

/// Positions kept: at 10 Hz the latest 13 s.
const KEPT: usize = 128;
/// Standard deviation of the height up to which a position may be the frame's origin (m).
const ORIGIN_SIGMA_M: f64 = 15.0;
/// A position that far back in time is of a clock that was set (s).
const SET_BACK_S: f64 = 10.0;

/// Where the radar was at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// The position after that time has not come yet.
    Waiting,
    /// Between two positions.
    At(RadarPlace),
    /// Never to be known.
    Nowhere(Missing),
}

/// Where the radar's phase centre was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarPlace {
    /// East, north, up about the origin (m).
    pub position_m: [f64; 3],
    /// Standard deviations (m), where the receiver states them.
    pub sigma_m: Option<[f64; 3]>,
    /// The worse kind of the positions on both sides.
    pub status: SolutionStatus,
}

/// Why a place is never to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// Before the first position.
    BeforeFirst,
    /// Positions were missing about it.
    Gap,
    /// The lever arm has a horizontal part, and no motion has told the heading yet.
    Heading,
}

/// The latest position of the receiver's antenna.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latest {
    /// East, north, up about the origin (m).
    pub position_m: [f64; 3],
    /// Standard deviations (m), where they are stated.
    pub sigma_m: Option<[f64; 3]>,
    /// Its kind.
    pub status: SolutionStatus,
    /// When.
    pub time: GpsTime,
}

/// Collects positions and interpolates between them; nothing is extrapolated.
#[derive(Debug)]
pub struct Positions {
    frame: Option<EnuFrame>,
    start: Option<GpsTime>,
    lever_arm_m: [f64; 3],
    fixes: VecDeque<Fix>,
    solutions: Solutions,
    nmea: NmeaFinder,
    has_ubx: bool,
    /// The lever arm as the latest heading turned it (m).
    arm_in_enu_m: Option<[f64; 3]>,
    radar: Option<Result<Trajectory, Missing>>,
    /// Positions taken, by all means.
    taken: u64,
}

impl Positions {
    /// Positions about `origin`, or about the first of them.
    #[must_use]
    pub fn new(origin: Option<Geodetic>, lever_arm_m: [f64; 3]) -> Self {
        Self {
            frame: origin.map(EnuFrame::new),
            start: None,
            lever_arm_m,
            fixes: VecDeque::new(),
            solutions: Solutions::default(),
            nmea: NmeaFinder::default(),
            has_ubx: false,
            arm_in_enu_m: None,
            radar: None,
            taken: 0,
        }
    }

    /// Takes a UBX message; returns the time of the solution in it.
    pub fn ubx(&mut self, frame: &UbxFrame<'_>) -> Option<GpsTime> {
        let found = self.solutions.take(frame);
        let mut latest = None;
        for position in found.into_iter().flatten() {
            if !std::mem::replace(&mut self.has_ubx, true) {
                self.fixes.clear();
            }
            self.push(&position);
            latest = Some(position.time);
        }
        latest
    }

    /// Takes bytes that may hold NMEA sentences; they count as long as no UBX solution has come. Returns the
    /// time of the latest position in them.
    pub fn nmea(&mut self, bytes: &[u8]) -> Option<GpsTime> {
        let mut found = Vec::new();
        self.nmea.take(bytes, |position| found.push(position));
        if self.has_ubx {
            return None;
        }
        found.iter().for_each(|position| self.push(position));
        found.last().map(|position| position.time)
    }

    fn push(&mut self, position: &Position) {
        if self.frame.is_none() && position.sigma_m.is_none_or(|s| s[2] <= ORIGIN_SIGMA_M) {
            self.frame = Some(EnuFrame::new(position.place));
        }
        let Some(frame) = self.frame else {
            return;
        };
        let start = *self.start.get_or_insert(position.time);
        let time_s = position.time.seconds_since(start);
        let place_m = frame.enu_from_ecef(ecef_from_geodetic(&position.place));
        let mut fix = Fix::new(time_s, place_m);
        fix.status = position.status;
        fix.covariance_m2 = position.sigma_m.map(|sigma_m| {
            let mut covariance = [[0.0; 3]; 3];
            for (axis, sigma_m) in sigma_m.into_iter().enumerate() {
                covariance[axis][axis] = sigma_m * sigma_m;
            }
            covariance
        });
        if let Some(latest) = self.fixes.back()
            && time_s <= latest.time_s
        {
            if latest.time_s - time_s < SET_BACK_S {
                return;
            }
            self.fixes.clear();
        }
        self.fixes.push_back(fix);
        if self.fixes.len() > KEPT {
            self.fixes.pop_front();
        }
        self.taken += 1;
        self.radar = None;
    }

    /// Where the radar was.
    pub fn at(&mut self, time: GpsTime) -> Placed {
        let (Some(start), Some(latest)) = (self.start, self.fixes.back()) else {
            return Placed::Waiting;
        };
        let time_s = time.seconds_since(start);
        if time_s > latest.time_s || self.fixes.len() < 2 {
            return Placed::Waiting;
        }
        if self.radar.is_none() {
            self.radar = Some(self.radar_trajectory());
        }
        match &self.radar {
            Some(Ok(trajectory)) => {
                let options = InterpolationOptions::default();
                let place = Interpolator::new(trajectory, &options).at(time_s);
                match place.flag {
                    Flag::Ok | Flag::Unfixed => Placed::At(RadarPlace {
                        position_m: place.position_m,
                        sigma_m: place
                            .covariance_m2
                            .map(|c| [0, 1, 2].map(|axis| c[axis][axis].max(0.0).sqrt())),
                        status: place.status,
                    }),
                    Flag::BeforeStart => Placed::Nowhere(Missing::BeforeFirst),
                    Flag::InGap => Placed::Nowhere(Missing::Gap),
                    Flag::AfterEnd => Placed::Waiting,
                }
            }
            Some(Err(missing)) => Placed::Nowhere(*missing),
            None => Placed::Waiting,
        }
    }

    /// The radar's own way: the antenna's with the lever arm. Where the platform stands, the heading before
    /// holds.
    fn radar_trajectory(&mut self) -> Result<Trajectory, Missing> {
        let origin = self.start.map_or(TimeOrigin::Relative, TimeOrigin::Gps);
        let frame = self.frame.map_or(Frame::Local, Frame::Enu);
        let make = |fixes: Vec<Fix>| {
            // Fixes are finite and in order of time: `push` sees to that.
            Trajectory::new(frame, origin, fixes).map_err(|_| Missing::Gap)
        };
        let antenna = make(self.fixes.iter().copied().collect())?;
        if let Ok((radar, _)) =
            apply_lever_arm(&antenna, self.lever_arm_m, &HeadingOptions::default())
        {
            let ends = (radar.fixes().last(), antenna.fixes().last());
            if let (Some(radar), Some(antenna)) = ends {
                self.arm_in_enu_m = Some(subtract(radar.position_m, antenna.position_m));
            }
            return Ok(radar);
        }
        let arm_m = self.arm_in_enu_m.ok_or(Missing::Heading)?;
        let moved = antenna.fixes().iter().map(|fix| Fix {
            position_m: add(fix.position_m, arm_m),
            ..*fix
        });
        make(moved.collect())
    }

    /// The latest position of the antenna.
    #[must_use]
    pub fn latest(&self) -> Option<Latest> {
        let fix = self.fixes.back()?;
        Some(Latest {
            position_m: fix.position_m,
            sigma_m: fix.standard_deviation_m(),
            status: fix.status,
            time: self.start? + fix.time_s,
        })
    }

    /// Positions taken so far.
    #[must_use]
    pub fn taken(&self) -> u64 {
        self.taken
    }

    /// Positions by NMEA that no sentence dates, which are of no use.
    #[must_use]
    pub fn undated(&self) -> u64 {
        self.nmea.undated
    }

    /// Whether the receiver's latest solution had no fix.
    #[must_use]
    pub fn is_without_fix(&self) -> bool {
        self.solutions.is_without_fix
    }

    /// The frame, where it is known.
    #[must_use]
    pub fn frame(&self) -> Option<&EnuFrame> {
        self.frame.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORIGIN: [f64; 3] = [40.9, 14.2, 60.0];

    fn origin() -> Geodetic {
        Geodetic::from_degrees(ORIGIN[0], ORIGIN[1], ORIGIN[2])
    }

    fn start() -> GpsTime {
        GpsTime::from_week_tow(2075, 207_000.0)
    }

    /// Flying north at 2 m/s with a sway of a decimetre.
    fn truth_m(time_s: f64) -> [f64; 3] {
        [
            0.1 * (1.5 * time_s).sin(),
            2.0 * time_s,
            10.0 + 0.05 * time_s.cos(),
        ]
    }

    fn position(time_s: f64, status: SolutionStatus) -> Position {
        let frame = EnuFrame::new(origin());
        let ecef_m = frame.ecef_from_enu(truth_m(time_s));
        Position {
            time: start() + time_s,
            place: acerra_geo::geodesy::geodetic_from_ecef(ecef_m),
            sigma_m: Some([0.01, 0.01, 0.02]),
            status,
        }
    }

    fn flown(interval_s: f64, count: i32, arm_m: [f64; 3]) -> Positions {
        let mut positions = Positions::new(Some(origin()), arm_m);
        for k in 0..count {
            positions.push(&position(interval_s * f64::from(k), SolutionStatus::Fixed));
        }
        positions
    }

    #[test]
    fn a_place_is_found_between_positions_and_never_beyond_the_last() {
        let mut positions = flown(0.2, 40, [0.0; 3]);
        for time_s in [0.05, 3.33, 7.79] {
            let Placed::At(place) = positions.at(start() + time_s) else {
                panic!("{time_s}");
            };
            let truth = truth_m(time_s);
            let off_m = (0..3).map(|k| (place.position_m[k] - truth[k]).abs());
            assert!(off_m.fold(0.0, f64::max) < 5e-4, "{time_s}: {place:?}");
            assert!((place.sigma_m.unwrap()[2] - 0.02).abs() < 1e-9);
        }
        assert_eq!(positions.at(start() + 7.81), Placed::Waiting);
        assert_eq!(
            positions.at(start() + -0.1),
            Placed::Nowhere(Missing::BeforeFirst)
        );
    }

    #[test]
    fn what_lies_in_a_gap_is_nowhere() {
        let mut positions = flown(0.2, 10, [0.0; 3]);
        for k in 20..30 {
            positions.push(&position(0.2 * f64::from(k), SolutionStatus::Fixed));
        }
        assert_eq!(positions.at(start() + 3.0), Placed::Nowhere(Missing::Gap));
        assert!(matches!(positions.at(start() + 4.5), Placed::At(_)));
    }

    #[test]
    fn the_lever_arm_turns_with_the_flight_and_waits_for_a_heading() {
        let mut standing = Positions::new(Some(origin()), [0.5, 0.0, -0.2]);
        for k in 0..5 {
            let mut still = position(0.0, SolutionStatus::Fixed);
            still.time = start() + 0.2 * f64::from(k);
            standing.push(&still);
        }
        assert_eq!(
            standing.at(start() + 0.3),
            Placed::Nowhere(Missing::Heading)
        );
        let mut positions = flown(0.2, 40, [0.5, 0.0, -0.2]);
        let Placed::At(place) = positions.at(start() + 4.0) else {
            panic!("no place");
        };
        let truth = truth_m(4.0);
        assert!((place.position_m[1] - truth[1] - 0.5).abs() < 0.01);
        assert!((place.position_m[2] - truth[2] + 0.2).abs() < 1e-3);
        // Hovering for longer than positions are kept: the heading before holds.
        let end = position(7.8, SolutionStatus::Fixed);
        for k in 0..300 {
            let mut still = end;
            still.time = start() + 8.0 + 0.2 * f64::from(k);
            positions.push(&still);
        }
        let Placed::At(place) = positions.at(start() + 60.0) else {
            panic!("no place");
        };
        assert!((place.position_m[1] - truth_m(7.8)[1] - 0.5).abs() < 0.02);
    }

    #[test]
    fn positions_between_kinds_are_called_the_worse() {
        let mut positions = flown(0.2, 10, [0.0; 3]);
        for k in 10..20 {
            positions.push(&position(0.2 * f64::from(k), SolutionStatus::Float));
        }
        let Placed::At(place) = positions.at(start() + 3.0) else {
            panic!("no place");
        };
        assert_eq!(place.status, SolutionStatus::Float);
    }
}
