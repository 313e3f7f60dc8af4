//! One receiver: tracking, noise, cycles.

use super::clock::{self, Tick};
use super::link::{Satellite, Sky};
use super::model::ReceiverModel;
use super::setting::Setting;
use crate::flight::{Wander, normal};
use acerra_geo::time::GpsTime;
use acerra_gnss::{FREQUENCY_L1_HZ, LossOfLock, SPEED_OF_LIGHT_M_S, SatelliteId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Numbers of the receivers, which keep their random streams apart.
pub(super) const ROVER: u64 = 1;
pub(super) const BASE: u64 = 2;

/// Measurement of one satellite at one epoch, on L1 C/A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    /// The satellite.
    pub satellite: SatelliteId,
    /// Pseudorange (m).
    pub pseudorange_m: f64,
    /// Carrier phase (cycles), growing with range.
    pub phase_cycles: f64,
    /// Doppler shift (Hz), positive when approaching.
    pub doppler_hz: f64,
    /// Carrier-to-noise density (dB-Hz).
    pub cn0_db_hz: u8,
    /// Bits 0 (slip since the last epoch) and 1 (half cycle not resolved).
    pub loss_of_lock: LossOfLock,
}

/// Measurements at one epoch.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedEpoch {
    /// Reading of the receiver's clock.
    pub tag: GpsTime,
    /// The GPS time that it was (the truth).
    pub true_time: GpsTime,
    /// The satellites in ascending order.
    pub observed: Vec<Observed>,
}

/// The log of one receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverLog {
    /// Epochs in order; epochs without a satellite are left out.
    pub epochs: Vec<ObservedEpoch>,
    /// Position at the start (ECEF, m): exact for the base, where it is the known point.
    pub position_ecef_m: [f64; 3],
    /// Time between epochs (s).
    pub interval_s: f64,
}

/// The random numbers of one process of one receiver, independent of all others.
fn stream(seed: u64, receiver: u64, satellite: u64, process: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(receiver << 32 | satellite << 16 | process << 1);
    rng
}

/// Logs the whole setting with one receiver.
pub(super) fn log(
    sky: &Sky<'_>,
    setting: &Setting<'_>,
    model: &ReceiverModel,
    position_m: &dyn Fn(f64) -> [f64; 3],
    receiver: u64,
) -> ReceiverLog {
    let mut clock_rng = stream(setting.seed, receiver, 0, 0);
    let ticks = clock::ticks(model, setting.start, setting.duration_s, &mut clock_rng);
    let mut epochs: Vec<ObservedEpoch> = ticks
        .iter()
        .map(|tick| ObservedEpoch {
            tag: tick.tag,
            true_time: tick.tag - tick.offset_s,
            observed: Vec::new(),
        })
        .collect();
    let antenna = |t: GpsTime| {
        setting
            .frame
            .ecef_from_enu(position_m(t.seconds_since(setting.start)))
    };
    for satellite in sky.satellites {
        let mut channel = Channel::new(model, setting, satellite, receiver);
        for (tick, epoch) in ticks.iter().zip(&mut epochs) {
            epoch
                .observed
                .extend(channel.observe(sky, tick, epoch.true_time, &antenna));
        }
    }
    epochs.retain(|epoch| !epoch.observed.is_empty());
    ReceiverLog {
        epochs,
        position_ecef_m: antenna(setting.start),
        interval_s: model.interval_s,
    }
}

/// The cycles between the phase that is counted and the range.
struct Lock {
    ambiguity: f64,
    /// Seconds from the start until which the half cycle is not resolved.
    half_until_s: f64,
    /// 0 or ½, until it is.
    half: f64,
}

/// The tracking of one satellite by one receiver.
struct Channel<'a> {
    model: &'a ReceiverModel,
    satellite: &'a Satellite,
    start: GpsTime,
    lock: Option<Lock>,
    begun: bool,
    blocked_until_s: f64,
    code_multipath: Wander,
    phase_multipath: Wander,
    fading: Wander,
    multipath_rng: ChaCha8Rng,
    code_rng: ChaCha8Rng,
    phase_rng: ChaCha8Rng,
    doppler_rng: ChaCha8Rng,
    tracking_rng: ChaCha8Rng,
}

impl<'a> Channel<'a> {
    fn new(
        model: &'a ReceiverModel,
        setting: &Setting<'_>,
        satellite: &'a Satellite,
        receiver: u64,
    ) -> Self {
        let number = u64::from(satellite.id.number());
        let rng = |process| stream(setting.seed, receiver, number, process);
        let mut multipath_rng = rng(1);
        let mut wander =
            |time_s: f64| Wander::new(1.0, time_s, model.interval_s, &mut multipath_rng);
        Self {
            model,
            satellite,
            start: setting.start,
            lock: None,
            begun: false,
            blocked_until_s: f64::NEG_INFINITY,
            code_multipath: wander(model.multipath_time_s),
            phase_multipath: wander(model.multipath_time_s),
            fading: wander(4.0 * model.multipath_time_s),
            multipath_rng,
            code_rng: rng(2),
            phase_rng: rng(3),
            doppler_rng: rng(4),
            tracking_rng: rng(5),
        }
    }

    /// One epoch. Every process advances by one step whether the satellite is seen or not, so that no draw
    /// depends on earlier visibility.
    fn observe(
        &mut self,
        sky: &Sky<'_>,
        tick: &Tick,
        t: GpsTime,
        antenna: &dyn Fn(GpsTime) -> [f64; 3],
    ) -> Option<Observed> {
        let model = self.model;
        let time_s = t.seconds_since(self.start);
        let [code_multipath, phase_multipath, fading] = [
            &mut self.code_multipath,
            &mut self.phase_multipath,
            &mut self.fading,
        ]
        .map(|wander| wander.step(&mut self.multipath_rng));
        let code_noise = normal(&mut self.code_rng);
        let phase_noise = normal(&mut self.phase_rng);
        let doppler_noise = normal(&mut self.doppler_rng);
        let draws: [f64; 6] = std::array::from_fn(|_| self.tracking_rng.random());

        let place = antenna(t);
        let link = sky.link(self.satellite, t, place);
        let visible = self.is_visible(sky, link.elevation_rad, time_s, [draws[0], draws[1]]);
        let first = !std::mem::replace(&mut self.begun, true);
        if !visible {
            self.lock = None;
            return None;
        }
        let (ambiguity, loss_of_lock) =
            self.cycles(time_s, first, [draws[2], draws[3], draws[4], draws[5]]);

        let sine = link.elevation_rad.sin().max(0.05);
        let rough = (0.5 * (1.0 + 1.0 / (sine * sine))).sqrt();
        let low = 0.2 + 0.8 * (-link.elevation_rad.to_degrees() / 25.0).exp();
        let clock_m = SPEED_OF_LIGHT_M_S * tick.offset_s;
        let code_error_m =
            rough * model.code_noise_m * code_noise + low * model.code_multipath_m * code_multipath;
        let phase_error_m = rough * model.phase_noise_m * phase_noise
            + low * model.phase_multipath_m * phase_multipath;
        let pseudorange_m = link.common_m + link.ionosphere_m + clock_m + code_error_m;
        let phase_m = link.common_m - link.ionosphere_m + clock_m + phase_error_m;

        let half_step_s = 5e-3;
        let at = |dt: f64| {
            let link = sky.link(self.satellite, t + dt, antenna(t + dt));
            link.common_m - link.ionosphere_m
        };
        let rate_m_s = (at(half_step_s) - at(-half_step_s)) / (2.0 * half_step_s)
            + SPEED_OF_LIGHT_M_S * tick.drift;
        let cn0 = 33.0 + 15.0 * sine + 1.5 * fading;
        Some(Observed {
            satellite: self.satellite.id,
            pseudorange_m,
            phase_cycles: phase_m / WAVELENGTH_M + ambiguity,
            doppler_hz: -rate_m_s / WAVELENGTH_M + model.doppler_noise_hz * doppler_noise,
            cn0_db_hz: cn0.round().clamp(20.0, 55.0) as u8,
            loss_of_lock,
        })
    }

    /// Whether the satellite is above the mask, not hidden, and the receiver not in an outage.
    fn is_visible(&mut self, sky: &Sky<'_>, elevation: f64, time_s: f64, draws: [f64; 2]) -> bool {
        let model = self.model;
        let chance = model.blockages_per_hour / 3600.0 * model.interval_s;
        if draws[0] < chance {
            // 1 − draw is never zero.
            let duration_s = -model.blockage_time_s * (1.0 - draws[1]).ln();
            self.blocked_until_s = self.blocked_until_s.max(time_s + duration_s);
        }
        let outage = model
            .outages_s
            .iter()
            .any(|[from, to]| (*from..*to).contains(&time_s));
        elevation >= sky.model.elevation_mask_deg.to_radians()
            && time_s >= self.blocked_until_s
            && !outage
    }

    /// The cycles added to the phase, and the loss-of-lock indicator that the receiver reports.
    fn cycles(&mut self, time_s: f64, first: bool, draws: [f64; 4]) -> (f64, LossOfLock) {
        let mut bits = 0;
        let lock = match &mut self.lock {
            Some(lock) => lock,
            none => {
                bits |= LossOfLock::SLIP;
                let [shortest, longest] = self.model.half_cycle_time_s;
                let unresolved_s = shortest + draws[0] * (longest - shortest);
                let half_until_s = if first {
                    f64::NEG_INFINITY
                } else {
                    time_s + unresolved_s
                };
                none.insert(Lock {
                    ambiguity: ((draws[1] - 0.5) * 2e6).round(),
                    half_until_s,
                    half: if !first && draws[2] < 0.5 { 0.5 } else { 0.0 },
                })
            }
        };
        if draws[3] < self.model.slips_per_hour / 3600.0 * self.model.interval_s {
            // Up to fifty cycles either way, never zero.
            let size = 1.0 + (draws[1] * 50.0).floor();
            lock.ambiguity += if draws[2] < 0.5 { size } else { -size };
            bits |= LossOfLock::SLIP;
        }
        if time_s < lock.half_until_s {
            bits |= LossOfLock::HALF_CYCLE;
        } else if lock.half != 0.0 {
            lock.half = 0.0;
            bits |= LossOfLock::SLIP;
        }
        (lock.ambiguity + lock.half, LossOfLock(bits))
    }
}

/// Wavelength of L1 (m).
pub(super) const WAVELENGTH_M: f64 = SPEED_OF_LIGHT_M_S / FREQUENCY_L1_HZ;
