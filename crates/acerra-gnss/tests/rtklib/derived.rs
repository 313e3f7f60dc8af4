//! Logs derived from the static sets by what receivers, places and settings vary in: windows, intervals,
//! systems, satellites, masks, exchanged receivers, gaps, biased codes, bases told wrongly.

use super::enu;
use super::sets::{Logs, Set};
use super::trust::{default_options, truth_of};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_gnss::{
    AmbiguityMode, BasePosition, FilterDirection, LossOfLock, ObservationData, PositioningMode,
    PpkOptions, PpkSolution, Quality, SatelliteId, System, SystemSet,
};

/// Fixes further than this from the truth are wrong (m).
const WRONG_M: f64 = 0.1;
/// Squared standard deviations beyond which an error is not covered.
const LARGEST_SQUARED_SIGMA: f64 = 25.0;

/// A static set with both places known (ECEF, m).
pub struct Known {
    pub set: &'static Set,
    pub logs: Logs,
    pub base_ecef_m: [f64; 3],
    pub rover_ecef_m: [f64; 3],
}

impl Known {
    pub fn read(set: &'static Set) -> Option<Self> {
        let logs = set.read()?;
        let BasePosition::Ecef(base_ecef_m) = default_options(set).base_position else {
            return None;
        };
        let rover_ecef_m = EnuFrame::from_ecef(base_ecef_m).ecef_from_enu(truth_of(set)?);
        Some(Self {
            set,
            logs,
            base_ecef_m,
            rover_ecef_m,
        })
    }

    /// The same with rover and base exchanged.
    pub fn exchanged(self) -> Self {
        Self {
            logs: Logs {
                rover: self.logs.base,
                base: self.logs.rover,
                navigation: self.logs.navigation,
            },
            base_ecef_m: self.rover_ecef_m,
            rover_ecef_m: self.base_ecef_m,
            set: self.set,
        }
    }

    /// The defaults, with the base where it stands.
    pub fn options(&self) -> PpkOptions {
        default_options(self.set).with_base_position(BasePosition::Ecef(self.base_ecef_m))
    }

    /// Fixes of a solution and the wrong ones; the base may have been told wrongly, the vector from it
    /// is what counts.
    pub fn judge(&self, solution: &PpkSolution) -> Judged {
        let told_ecef_m = solution.base_position_ecef_m.unwrap();
        let truth = enu(self.base_ecef_m, self.rover_ecef_m);
        let frame = EnuFrame::from_ecef(told_ecef_m);
        let mut judged = Judged::default();
        for e in &solution.epochs {
            if e.quality != Quality::Fixed {
                continue;
            }
            judged.fixed += 1;
            let found = frame.enu_from_ecef(e.position_ecef_m);
            let [x, y, z] = std::array::from_fn(|k| found[k] - truth[k]);
            if x.hypot(y).hypot(z) > WRONG_M {
                judged.wrong += 1;
                let q = frame.enu_covariance_from_ecef(&e.covariance_ecef_m2);
                let determinant = q[0][0] * q[1][1] - q[0][1] * q[1][0];
                let level = q[1][1] * x * x - 2.0 * q[0][1] * x * y + q[0][0] * y * y;
                let beyond = level / determinant > LARGEST_SQUARED_SIGMA
                    || z * z / q[2][2] > LARGEST_SQUARED_SIGMA;
                judged.wrong_and_certain += usize::from(beyond);
            }
        }
        judged
    }
}

/// What fixes of a solution are worth.
#[derive(Clone, Copy, Default, Debug)]
pub struct Judged {
    pub fixed: usize,
    pub wrong: usize,
    /// Of the wrong ones, those whose error is beyond five of the stated standard deviations.
    pub wrong_and_certain: usize,
}

/// A linear congruential generator (Knuth, MMIX).
struct Draw(u64);

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }

    /// Between 0 and 1.
    fn share(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from(1 << 20)
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// Keeps the epochs of a window.
pub fn cut(log: &mut ObservationData, start: GpsTime, length_s: f64) {
    log.epochs.retain(|e| {
        let since_s = e.time.seconds_since(start);
        since_s > -0.1 && since_s < length_s + 0.1
    });
}

fn thin(log: &mut ObservationData, interval_s: f64) {
    let first = log.epochs[0].time;
    log.epochs.retain(|e| {
        let since_s = e.time.seconds_since(first);
        (since_s - (since_s / interval_s).round() * interval_s).abs() < 0.05
    });
}

fn satellites(log: &ObservationData) -> Vec<SatelliteId> {
    let of_epochs = log.epochs.iter().flat_map(|e| &e.satellites);
    let mut all: Vec<SatelliteId> = of_epochs.map(|s| s.satellite).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn bias_codes(log: &mut ObservationData, of: impl Fn(SatelliteId) -> bool, bias_m: f64) {
    let all = log.epochs.iter_mut().flat_map(|e| &mut e.satellites);
    for s in all.filter(|s| of(s.satellite)) {
        for signal in s.signals.iter_mut().flatten() {
            signal.pseudorange_m = signal.pseudorange_m.map(|p| p + bias_m);
        }
    }
}

/// A draw of what may vary: logs, options, and both in words.
pub fn variation(known: &Known, seed: u64) -> (Logs, PpkOptions, String) {
    let mut draw = Draw(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ seed);
    let mut words = String::new();
    let mut logs = Logs {
        rover: known.logs.rover.clone(),
        base: known.logs.base.clone(),
        navigation: known.logs.navigation.clone(),
    };
    vary_logs(&mut draw, &mut logs, &mut words);
    let options = vary_options(&mut draw, known, &logs, &mut words);
    (logs, options, words)
}

fn vary_logs(draw: &mut Draw, logs: &mut Logs, words: &mut String) {
    let epochs = &logs.rover.epochs;
    let first = epochs[0].time;
    let length_s = epochs[epochs.len() - 1].time.seconds_since(first);
    let slow = length_s > 10.0 * epochs.len() as f64;
    let window_s = if slow {
        draw.of(&[300.0, 600.0, 1_200.0, 3_600.0])
    } else {
        draw.of(&[60.0, 120.0, 300.0, 300.0, 600.0])
    };
    let start = first + draw.share() * (length_s - window_s).max(0.0);
    cut(&mut logs.rover, start, window_s);
    *words += &format!("{window_s} s from {:.0} s", start.seconds_since(first));
    if draw.once_in(3) {
        let interval_s = draw.of(if slow {
            &[60.0, 90.0]
        } else {
            &[2.0, 5.0, 10.0]
        });
        thin(&mut logs.rover, interval_s);
        *words += &format!(", every {interval_s} s");
    }
    if draw.once_in(4) {
        let kept = draw.of(&[0.5, 0.8]);
        logs.rover.epochs.retain(|_| draw.share() < kept);
        *words += &format!(", {kept} of the epochs");
    }
    if draw.once_in(4) {
        for _ in 0..3 {
            let gap = start + draw.share() * window_s;
            let gap_s = 5.0 + 35.0 * draw.share();
            let outside = |since_s: f64| since_s < 0.0 || since_s > gap_s;
            let epochs = &mut logs.base.epochs;
            epochs.retain(|e| outside(e.time.seconds_since(gap)));
        }
        *words += ", gaps of the base";
    }
    let all = satellites(&logs.rover);
    if draw.once_in(4) && !all.is_empty() {
        let (one, bias_m) = (draw.of(&all), draw.of(&[2.0, 5.0, -5.0, 15.0]));
        let system = draw.once_in(2).then(|| one.system());
        bias_codes(
            &mut logs.rover,
            |s| system.map_or(s == one, |own| s.system() == own),
            bias_m,
        );
        *words += &format!(
            ", codes of {one} (system: {}) + {bias_m} m",
            system.is_some()
        );
    }
}

fn vary_options(draw: &mut Draw, known: &Known, logs: &Logs, words: &mut String) -> PpkOptions {
    let mut options = known.options();
    options.systems = match draw.below(6) {
        0 => SystemSet::GPS,
        1 => SystemSet::GPS.with(System::Glonass),
        2 => options.systems.without(System::Gps),
        _ => options.systems,
    };
    if draw.once_in(2) {
        let share = draw.of(&[0.2, 0.4, 0.6]);
        let mut all = satellites(&logs.rover);
        all.retain(|_| draw.share() < share);
        *words += &format!(", without {} satellites", all.len());
        options.excluded_satellites = all;
    }
    let mask_deg: f64 = draw.of(&[5.0, 15.0, 15.0, 25.0, 35.0]);
    options.elevation_mask_rad = mask_deg.to_radians();
    options.frequencies = draw.of(&[1, 1, 2, 3]);
    options.direction = draw.of(&[
        FilterDirection::Combined,
        FilterDirection::Combined,
        FilterDirection::Forward,
        FilterDirection::Backward,
        FilterDirection::CombinedWithoutReset,
    ]);
    options.ambiguity = draw.of(&[
        AmbiguityMode::FixAndHold,
        AmbiguityMode::FixAndHold,
        AmbiguityMode::Continuous,
        AmbiguityMode::Instantaneous,
    ]);
    if draw.once_in(3) {
        options.mode = PositioningMode::Static;
    }
    if draw.once_in(4) {
        let size_m = draw.of(&[2.0, 10.0, 40.0]);
        let off_enu: [f64; 3] = std::array::from_fn(|_| size_m * (2.0 * draw.share() - 1.0));
        let frame = EnuFrame::from_ecef(known.base_ecef_m);
        options.base_position = BasePosition::Ecef(frame.ecef_from_enu(off_enu));
        *words += &format!(", base told within {size_m} m");
    }
    *words += &format!(
        ", {:?} above {mask_deg}°, {} frequencies, {:?} {:?} {:?}",
        options.systems, options.frequencies, options.mode, options.direction, options.ambiguity
    );
    options
}

/// Four minutes in which about six tenths of the satellites slip at one epoch, with flags, and so many of
/// the others by one cycle without.
pub fn slipping(known: &Known, seed: u64, unflagged: usize) -> Logs {
    let mut draw = Draw(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ !seed);
    let mut rover = known.logs.rover.clone();
    let first = rover.epochs[0].time;
    let length_s = rover.epochs[rover.epochs.len() - 1]
        .time
        .seconds_since(first);
    let window_s = length_s.min(240.0);
    let start = first + draw.share() * (length_s - window_s);
    cut(&mut rover, start, window_s);
    let at = start + window_s * (0.3 + 0.4 * draw.share());
    let (mut flagged, mut others) = (Vec::new(), Vec::new());
    for satellite in satellites(&rover) {
        if draw.share() < 0.6 {
            flagged.push((satellite, draw.below(2_000) as f64));
        } else {
            others.push(satellite);
        }
    }
    let mut silent = Vec::new();
    for _ in 0..unflagged.min(others.len()) {
        let one = others.swap_remove(draw.below(others.len()));
        silent.push((one, draw.of(&[1.0, -1.0])));
    }
    let of = |list: &[(SatelliteId, f64)], satellite| {
        let found = list.iter().find(|(one, _)| *one == satellite);
        found.map(|(_, cycles)| *cycles)
    };
    let mut is_first = true;
    let after = |e: &&mut acerra_gnss::ObservationEpoch| e.time.seconds_since(at) >= 0.0;
    for epoch in rover.epochs.iter_mut().filter(after) {
        for s in &mut epoch.satellites {
            let slip = of(&flagged, s.satellite);
            let cycles = slip.or(of(&silent, s.satellite)).unwrap_or(0.0);
            for signal in s.signals.iter_mut().flatten() {
                signal.phase_cycles = signal.phase_cycles.map(|p| p + cycles);
                if is_first && slip.is_some() {
                    signal.loss_of_lock.0 |= LossOfLock::SLIP;
                }
            }
        }
        is_first = false;
    }
    Logs {
        rover,
        base: known.logs.base.clone(),
        navigation: known.logs.navigation.clone(),
    }
}
