//! Place of the radar by the receiver's own solutions, between one and the next.

use std::collections::VecDeque;

use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::interpolate::{Flag, InterpolationOptions, Interpolator};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::matrix::{add, distance, subtract};
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_gnss::ubx::frame::Frame as UbxFrame;

use crate::nmea::NmeaFinder;
use crate::place::{Latest, Missing, Placed, RadarPlace};
use crate::solutions::{Position, Solutions};

/// Positions kept: at 10 Hz the latest 13 s.
const KEPT: usize = 128;
/// Positions kept at most, while pulses wait for them: at 10 Hz 3½ minutes.
const MOST_KEPT: usize = 2048;
/// Positions kept before the first needed one: the curve between positions uses them.
const KEPT_BEFORE: usize = 8;
/// Standard deviation of the height up to which a position may be the frame's origin (m).
const ORIGIN_SIGMA_M: f64 = 15.0;
/// A position that far back in time is of a clock that was set (s).
const SET_BACK_S: f64 = 10.0;

/// Collects positions and interpolates between them.
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
    radar: Option<Way>,
    /// Pulses that wait begin there (s after `start`).
    needed_from_s: Option<f64>,
    /// Positions taken, by all means.
    taken: u64,
}

/// Position of the radar.
#[derive(Debug)]
enum Way {
    /// Path of the radar.
    OfRadar(Trajectory),
    /// Path with the vertical part of the lever arm alone: the heading is unknown before the platform has moved.
    WithoutHeading(Trajectory),
    /// No position source.
    None,
}

impl Positions {
    /// Positions relative to `origin`, or to the first of them.
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
            needed_from_s: None,
            taken: 0,
        }
    }

    /// Processes a UBX message; returns the time of the solution in it.
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
        self.trim();
        self.taken += 1;
        self.radar = None;
    }

    /// Forgets positions that are of no use any more.
    fn trim(&mut self) {
        while self.fixes.len() > KEPT {
            let oldest_s = self.fixes.get(KEPT_BEFORE).map(|fix| fix.time_s);
            let is_needed = self.needed_from_s.zip(oldest_s).is_some_and(|(a, b)| a < b);
            if is_needed && self.fixes.len() <= MOST_KEPT {
                return;
            }
            self.fixes.pop_front();
        }
    }

    /// Keeps positions from that time on, for waiting pulses. None: no pulse waits.
    pub fn need_from(&mut self, time: Option<GpsTime>) {
        let since = |time: GpsTime| Some(time.seconds_since(self.start?));
        self.needed_from_s = time.and_then(since);
    }

    /// Position of the radar.
    pub fn at(&mut self, time: GpsTime) -> Placed {
        let (Some(start), Some(latest)) = (self.start, self.fixes.back()) else {
            return Placed::Waiting;
        };
        let time_s = time.seconds_since(start);
        if time_s > latest.time_s || self.fixes.len() < 2 {
            return Placed::Waiting;
        }
        let (trajectory, has_heading) = match self.way() {
            Way::OfRadar(trajectory) => (trajectory, true),
            Way::WithoutHeading(trajectory) => (trajectory, false),
            Way::None => return Placed::Nowhere(Missing::Gap),
        };
        let place = Interpolator::new(trajectory, &InterpolationOptions::default()).at(time_s);
        match place.flag {
            Flag::Ok | Flag::Unfixed if !has_heading => Placed::WithoutHeading {
                up_m: place.position_m[2],
            },
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

    /// The radar's own path, computed again when positions have arrived.
    fn way(&mut self) -> &Way {
        if self.radar.is_none() {
            self.radar = Some(self.make_way().unwrap_or(Way::None));
        }
        self.radar.as_ref().unwrap_or(&Way::None)
    }

    /// Path of the radar: the antenna's path with the lever arm applied. While the platform is stationary, the
    /// last heading holds; before the first motion, the first heading.
    fn make_way(&mut self) -> Option<Way> {
        let origin = self.start.map_or(TimeOrigin::Relative, TimeOrigin::Gps);
        let frame = self.frame.map_or(Frame::Local, Frame::Enu);
        // Fixes are finite and in order of time: `push` sees to that.
        let make = |fixes: Vec<Fix>| Trajectory::new(frame, origin, fixes).ok();
        let antenna = make(self.fixes.iter().copied().collect())?;
        let moved_by = |arm_m: [f64; 3]| {
            let moved = antenna.fixes().iter().map(|fix| Fix {
                position_m: add(fix.position_m, arm_m),
                ..*fix
            });
            make(moved.collect())
        };
        let heading = HeadingOptions::default();
        if let Ok((radar, _)) = apply_lever_arm(&antenna, self.lever_arm_m, &heading) {
            let ends = (radar.fixes().last(), antenna.fixes().last());
            if let (Some(radar), Some(antenna)) = ends {
                self.arm_in_enu_m = Some(subtract(radar.position_m, antenna.position_m));
            }
            return Some(Way::OfRadar(radar));
        }
        match self.arm_in_enu_m {
            Some(arm_m) => moved_by(arm_m).map(Way::OfRadar),
            None => moved_by([0.0, 0.0, self.lever_arm_m[2]]).map(Way::WithoutHeading),
        }
    }

    /// Whether a horizontal lever arm still waits for the first heading.
    pub fn is_without_heading(&mut self) -> bool {
        self.fixes.len() >= 2 && matches!(self.way(), Way::WithoutHeading(_))
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

    /// Speed of the antenna between the latest two positions (m/s); 0 before there are two.
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        let mut latest = self.fixes.iter().rev();
        let (Some(after), Some(before)) = (latest.next(), latest.next()) else {
            return 0.0;
        };
        let way_m = distance(after.position_m, before.position_m);
        way_m / (after.time_s - before.time_s)
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
mod tests;
