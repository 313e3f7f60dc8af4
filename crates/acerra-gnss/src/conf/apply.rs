//! What each key means.

use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};

use super::error::ConfError;
use super::requested::{NotFollowed, NotFollowedReason, RtklibConf};
use super::setting::Setting;
use crate::pos::{PosFrame, PosTime, PosTimeScale};
use crate::{
    AmbiguityMode, BasePosition, BaselineLength, Cn0Mask, Dynamics, FREQUENCY_SLOTS,
    FilterDirection, GlonassAmbiguity, PartialAmbiguity, PositioningMode, RuleSet, SatelliteId,
    System, SystemSet,
};

/// Standard deviation (m) of a baseline's length that is stated without one: no tape is better.
const LEAST_LENGTH_SIGMA_M: f64 = 1e-3;

/// Whether only demo5 and RTKLIB-EX have this key.
pub(super) fn is_demo5_key(key: &str) -> bool {
    matches!(
        key,
        "pos2-arfilter"
            | "pos2-arthresmin"
            | "pos2-arthresmax"
            | "pos2-varholdamb"
            | "pos2-gainholdamb"
            | "pos2-minfixsats"
            | "pos2-minholdsats"
            | "pos2-mindropsats"
            | "pos2-rejcode"
            | "pos2-dopthres"
            | "stats-errsnr"
            | "stats-snrmax"
            | "stats-errrcv"
    )
}

/// Values that stand together and are put together at the end.
struct Pending {
    dynamics: bool,
    noise: [f64; 2],
    masks: [[f64; 9]; FREQUENCY_SLOTS],
    masked: [bool; 2],
    base_kind: u32,
    base_values: [f64; 3],
    base_line: u64,
    partial: PartialAmbiguity,
    ratio_range: [Option<f64>; 2],
    /// Length of the baseline and its standard deviation.
    baseline_m: [f64; 2],
}

/// Applies all settings; of a key given twice the last counts.
pub(super) fn apply(settings: &[Setting], conf: &mut RtklibConf) -> Result<(), ConfError> {
    let noise = conf
        .options
        .dynamics
        .map_or([0.1, 0.01], |d| [d.horizontal_noise, d.vertical_noise]);
    let mut pending = Pending {
        dynamics: conf.options.dynamics.is_some(),
        noise,
        masks: [[0.0; 9]; FREQUENCY_SLOTS],
        masked: [false; 2],
        base_kind: 0,
        base_values: [0.0; 3],
        base_line: 0,
        partial: conf.options.partial_ambiguity.unwrap_or(PartialAmbiguity {
            filter_new_satellites: false,
            min_satellites_to_fix: 3,
            min_pairs_to_hold: 3,
            min_pairs_to_drop: usize::MAX,
        }),
        ratio_range: [None; 2],
        baseline_m: [0.0; 2],
    };
    for setting in settings {
        let outcome = match setting
            .key
            .split_once('-')
            .map_or("", |(section, _)| section)
        {
            "pos1" => first_page(setting, conf, &mut pending)?,
            "pos2" => second_page(setting, conf, &mut pending)?,
            "out" => output(setting, conf)?,
            "stats" => statistics(setting, conf, &mut pending)?,
            "ant1" | "ant2" => antenna(setting, conf, &mut pending)?,
            "misc" => miscellaneous(setting, conf)?,
            "file" => file(setting, conf)?,
            section
                if section.starts_with("inpstr")
                    || section.starts_with("outstr")
                    || section.starts_with("logstr")
                    || section == "console" =>
            {
                Some(NotFollowedReason::NotForPostProcessing)
            }
            _ => Some(NotFollowedReason::UnknownKey),
        };
        if let Some(reason) = outcome {
            conf.not_followed.push(NotFollowed {
                line: setting.line,
                key: setting.key.clone(),
                value: setting.value.clone(),
                reason,
            });
        }
    }
    finish(conf, &pending)
}

/// `None`: followed; else why not.
type Outcome = Result<Option<NotFollowedReason>, ConfError>;

const FOLLOWED: Outcome = Ok(None);
const UNSUPPORTED: Outcome = Ok(Some(NotFollowedReason::Unsupported));
const UNKNOWN: Outcome = Ok(Some(NotFollowedReason::UnknownKey));

/// Followed if the value is one of those that change nothing here.
fn only(setting: &Setting, harmless: &[&str]) -> Outcome {
    if harmless.contains(&setting.value.as_str()) {
        FOLLOWED
    } else {
        UNSUPPORTED
    }
}

fn first_page(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
    let options = &mut conf.options;
    match s.key.as_str() {
        "pos1-posmode" => {
            options.mode = match (s.value.as_str(), options.rules) {
                ("movingbase", _) => PositioningMode::MovingBase,
                // RTKLIB-EX numbers a static start before it.
                ("5", RuleSet::Demo5) => PositioningMode::MovingBase,
                ("4", RuleSet::Demo5) => return Err(s.unsupported()),
                _ => s
                    .named(PositioningMode::ALL)
                    .ok_or_else(|| s.unsupported())?,
            };
        }
        "pos1-frequency" => {
            let count = match s.value.parse::<usize>() {
                Ok(n) => n,
                Err(_) if s.value.starts_with('l') => 1 + s.value.matches('+').count(),
                Err(_) => 0,
            };
            if !(1..=5).contains(&count) {
                return Err(s.wrong("l1, l1+l2 or l1+l2+l5"));
            }
            options.frequencies = count.min(FREQUENCY_SLOTS);
            if count > FREQUENCY_SLOTS {
                return UNSUPPORTED;
            }
        }
        "pos1-soltype" => {
            // RTKLIB's own name of the fourth.
            options.direction = match s.value.as_str() {
                "combined-nophasereset" => FilterDirection::CombinedWithoutReset,
                _ => s
                    .named(FilterDirection::ALL)
                    .ok_or_else(|| s.wrong("forward, backward, combined, combined-nophasereset"))?,
            };
        }
        "pos1-elmask" => options.elevation_mask_rad = s.degrees()?,
        "pos1-snrmask_r" => pending.masked[0] = s.switch()?,
        "pos1-snrmask_b" => pending.masked[1] = s.switch()?,
        "pos1-snrmask" => pending.masked = [s.switch()?; 2],
        "pos1-snrmask_L1" => pending.masks[0] = s.nine()?,
        "pos1-snrmask_L2" => pending.masks[1] = s.nine()?,
        "pos1-snrmask_L5" => pending.masks[2] = s.nine()?,
        "pos1-dynamics" => pending.dynamics = s.switch()?,
        "pos1-exclsats" => {
            for name in s.value.split_whitespace() {
                let Ok(satellite) = name.parse::<SatelliteId>() else {
                    // "+G05" includes a satellite whatever its health.
                    return if name.starts_with('+') {
                        UNSUPPORTED
                    } else {
                        Err(s.wrong("satellites such as G05"))
                    };
                };
                options.excluded_satellites.push(satellite);
            }
        }
        "pos1-navsys" => {
            let bits = s.unsigned()?;
            let systems = [
                System::Gps,
                System::Sbas,
                System::Glonass,
                System::Galileo,
                System::Qzss,
                System::Beidou,
                System::Navic,
            ];
            options.systems = systems
                .into_iter()
                .enumerate()
                .filter(|(i, _)| bits >> i & 1 == 1)
                .map(|(_, system)| system)
                .collect::<SystemSet>();
            if options.systems.is_empty() {
                return Err(s.wrong("a sum of 1 (GPS) to 64 (NavIC)"));
            }
        }
        // Both ends of a short baseline see one ionosphere: off and broadcast are alike. Only
        // estimating would differ.
        "pos1-ionoopt" => return only(s, &["off", "0", "brdc", "1", "sbas", "2", ""]),
        "pos1-tropopt" => return only(s, &["off", "0", "saas", "1", "sbas", "2", ""]),
        "pos1-tidecorr" => return only(s, &["off", "0", ""]),
        "pos1-sateph" => {
            conf.inputs.precise_orbits = match s.choice(&["brdc", "precise"]) {
                Some(i) => i == 1,
                None => return Err(s.unsupported()),
            };
        }
        "pos1-posopt5" => options.raim = s.switch()?,
        "pos1-posopt1" | "pos1-posopt2" | "pos1-posopt3" | "pos1-posopt4" | "pos1-posopt6" => {
            return only(s, &["off", "0", ""]);
        }
        _ => return UNKNOWN,
    }
    FOLLOWED
}

fn second_page(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
    let options = &mut conf.options;
    match s.key.as_str() {
        "pos2-armode" => match s.named(AmbiguityMode::ALL) {
            Some(mode) => options.ambiguity = mode,
            None => return UNSUPPORTED,
        },
        "pos2-gloarmode" => {
            // RTKLIB's own name of the third.
            options.glonass_ambiguity = match s.value.as_str() {
                "autocal" => GlonassAmbiguity::Auto,
                _ => match s.named(GlonassAmbiguity::ALL) {
                    Some(mode) => mode,
                    None => return UNSUPPORTED,
                },
            };
        }
        "pos2-bdsarmode" => options.beidou_ambiguity = s.switch()?,
        "pos2-arfilter" => pending.partial.filter_new_satellites = s.switch()?,
        "pos2-arthres" => {
            options.ratio_threshold = s.number()?;
            options.ratio_threshold_range = [options.ratio_threshold; 2];
        }
        "pos2-arthresmin" => pending.ratio_range[0] = Some(s.number()?),
        "pos2-arthresmax" => pending.ratio_range[1] = Some(s.number()?),
        "pos2-arthres1" => options.position_variance_gate_m2 = s.number()?,
        // Inter-channel calibration and wide-lane tests of PPP.
        "pos2-arthres2" | "pos2-arthres3" | "pos2-arthres4" => {}
        "pos2-varholdamb" => options.hold_variance_cycles2 = s.number()?,
        "pos2-gainholdamb" => options.hold_gain = s.number()?,
        "pos2-arlockcnt" => options.min_lock_epochs = s.signed()?,
        "pos2-minfixsats" => pending.partial.min_satellites_to_fix = s.count()?,
        "pos2-minholdsats" => pending.partial.min_pairs_to_hold = s.count()?,
        "pos2-mindropsats" => pending.partial.min_pairs_to_drop = s.count()?,
        "pos2-arelmask" => options.ambiguity_elevation_mask_rad = s.degrees()?,
        "pos2-arminfix" => options.min_fixes_to_hold = s.unsigned()?,
        "pos2-armaxiter" => return only(s, &["1", ""]),
        "pos2-elmaskhold" => options.hold_elevation_mask_rad = s.degrees()?,
        "pos2-aroutcnt" => options.max_outage_epochs = s.unsigned()?,
        "pos2-maxage" => options.max_age_s = s.number()?,
        "pos2-syncsol" => return Ok(Some(NotFollowedReason::NotForPostProcessing)),
        "pos2-slipthres" => options.slip_threshold_m = s.number()?,
        "pos2-dopthres" => options.doppler_slip_threshold_cycles_s = s.number()?,
        "pos2-rejionno" => {
            let limit = s.number()?;
            options.max_phase_innovation_m = limit;
            if matches!(options.rules, RuleSet::Rtklib) {
                options.max_code_innovation_m = limit;
            }
        }
        "pos2-rejcode" => options.max_code_innovation_m = s.number()?,
        "pos2-rejgdop" => options.max_gdop = s.number()?,
        "pos2-niter" => options.iterations = s.count()?,
        "pos2-baselen" => pending.baseline_m[0] = s.number()?,
        "pos2-basesig" => pending.baseline_m[1] = s.number()?,
        _ => return UNKNOWN,
    }
    FOLLOWED
}

fn output(s: &Setting, conf: &mut RtklibConf) -> Outcome {
    let format = &mut conf.format;
    match s.key.as_str() {
        "out-solformat" if matches!(s.value.as_str(), "nmea" | "3") => conf.outputs.nmea = true,
        "out-solformat" => {
            conf.outputs.nmea = false;
            format.frame = match s.named(PosFrame::ALL) {
                Some(frame) => frame,
                None => return UNSUPPORTED,
            };
        }
        "out-outhead" => format.header = s.switch()?,
        // The options are part of the header here.
        "out-outopt" => {
            s.switch()?;
        }
        "out-timesys" => {
            format.scale = s
                .named(PosTimeScale::ALL)
                .ok_or_else(|| s.wrong("gpst, utc or jst"))?;
        }
        "out-timeform" => {
            format.time = match s.choice(&["tow", "hms"]) {
                Some(0) => PosTime::WeekTow,
                Some(1) => PosTime::Calendar,
                _ => return Err(s.wrong("tow or hms")),
            };
        }
        "out-timendec" => format.decimals = s.count()?.min(9),
        "out-degform" => return only(s, &["deg", "0", ""]),
        "out-fieldsep" => return only(s, &[""]),
        "out-outsingle" => conf.options.output_single = s.switch()?,
        "out-outvel" => format.velocity = s.switch()?,
        "out-maxsolstd" if s.value.is_empty() => {}
        "out-maxsolstd" => {
            conf.outputs.max_sigma_m = Some(s.number()?).filter(|&largest_m| largest_m > 0.0);
        }
        "out-height" => match s.choice(&["ellipsoidal", "geodetic"]) {
            Some(kind) => conf.outputs.geodetic_heights = kind == 1,
            None => return only(s, &[""]),
        },
        // Which grid the geoid file is shows in its content; none is built in.
        "out-geoid" => {}
        "out-solstatic" => return only(s, &["all", "0", ""]),
        "out-nmeaintv1" | "out-nmeaintv2" => {}
        "out-outstat" => match s.choice(&["off", "state", "residual"]) {
            Some(1) => return UNSUPPORTED,
            Some(kind) => conf.outputs.residuals = kind == 2,
            None => return only(s, &[""]),
        },
        _ => return UNKNOWN,
    }
    FOLLOWED
}

fn statistics(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
    let options = &mut conf.options;
    match s.key.as_str() {
        "stats-eratio1" => options.code_phase_ratio[0] = s.number()?,
        "stats-eratio2" => options.code_phase_ratio[1] = s.number()?,
        "stats-eratio3" | "stats-eratio5" => options.code_phase_ratio[2] = s.number()?,
        "stats-errphase" => options.phase_error_m = s.number()?,
        "stats-errphaseel" => options.phase_error_elevation_m = s.number()?,
        "stats-errphasebl" => options.phase_error_baseline_m = s.number()?,
        "stats-errdoppler" => options.doppler_error_hz = s.number()?,
        "stats-errsnr" => options.phase_error_cn0_m = s.number()?,
        "stats-errrcv" => return only(s, &["0", "0.0", ""]),
        // The strength that `stats-errsnr` refers to is fixed here.
        "stats-snrmax" => return only(s, &["52", "52.0", ""]),
        "stats-stdbias" => options.initial_bias_cycles = s.number()?,
        "stats-prnaccelh" => pending.noise[0] = s.number()?,
        "stats-prnaccelv" => pending.noise[1] = s.number()?,
        "stats-prnbias" => options.bias_noise_cycles = s.number()?,
        // Of states that are not estimated.
        "stats-stdiono" | "stats-stdtrop" | "stats-prniono" | "stats-prntrop" | "stats-prnpos" => {}
        "stats-clkstab" => options.clock_stability = s.number()?,
        _ => return UNKNOWN,
    }
    FOLLOWED
}

/// Files that post-processing reads; empty values name none.
fn file(s: &Setting, conf: &mut RtklibConf) -> Outcome {
    let name = Some(s.value.clone()).filter(|name| !name.is_empty());
    match s.key.as_str() {
        "file-rcvantfile" => conf.inputs.antenna_file = name,
        "file-geoidfile" => conf.outputs.geoid_file = name,
        _ if name.is_none() => {}
        _ => return UNSUPPORTED,
    }
    FOLLOWED
}

fn antenna(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
    let options = &mut conf.options;
    match s.key.as_str() {
        "ant1-antdele" => options.rover_antenna_m[0] = s.number()?,
        "ant1-antdeln" => options.rover_antenna_m[1] = s.number()?,
        "ant1-antdelu" => options.rover_antenna_m[2] = s.number()?,
        "ant2-antdele" => options.base_antenna_m[0] = s.number()?,
        "ant2-antdeln" => options.base_antenna_m[1] = s.number()?,
        "ant2-antdelu" => options.base_antenna_m[2] = s.number()?,
        "ant1-anttype" => conf.inputs.rover_antenna.clone_from(&s.value),
        "ant2-anttype" => conf.inputs.base_antenna.clone_from(&s.value),
        "ant2-postype" => {
            let names = [
                "llh",
                "xyz",
                "single",
                "posfile",
                "rinexhead",
                "rtcm",
                "raw",
            ];
            pending.base_kind = match s.choice(&names) {
                Some(kind @ (0 | 1 | 2 | 4)) => kind as u32,
                Some(_) => return Err(s.unsupported()),
                None => return Err(s.wrong("llh, xyz, single or rinexhead")),
            };
            pending.base_line = s.line;
        }
        "ant2-pos1" => pending.base_values[0] = s.number()?,
        "ant2-pos2" => pending.base_values[1] = s.number()?,
        "ant2-pos3" => pending.base_values[2] = s.number()?,
        // The rover's position is what is computed.
        "ant1-postype" | "ant1-pos1" | "ant1-pos2" | "ant1-pos3" => {}
        "ant2-maxaveep" | "ant2-initrst" => {
            return Ok(Some(NotFollowedReason::NotForPostProcessing));
        }
        _ => return UNKNOWN,
    }
    FOLLOWED
}

fn miscellaneous(s: &Setting, conf: &mut RtklibConf) -> Outcome {
    match s.key.as_str() {
        "misc-timeinterp" => conf.options.interpolate_base = s.switch()?,
        "misc-sbasatsel" => return only(s, &["0", "all", ""]),
        "misc-rnxopt1" | "misc-rnxopt2" | "misc-pppopt" => return only(s, &[""]),
        "misc-timeout" | "misc-reconnect" | "misc-nmeacycle" | "misc-buffsize"
        | "misc-navmsgsel" | "misc-proxyaddr" | "misc-fswapmargin" | "misc-svrcycle"
        | "misc-startcmd" | "misc-stopcmd" => {
            return Ok(Some(NotFollowedReason::NotForPostProcessing));
        }
        _ => return UNKNOWN,
    }
    FOLLOWED
}

fn finish(conf: &mut RtklibConf, pending: &Pending) -> Result<(), ConfError> {
    let options = &mut conf.options;
    options.dynamics = pending.dynamics.then_some(Dynamics {
        horizontal_noise: pending.noise[0],
        vertical_noise: pending.noise[1],
    });
    if pending.masked.contains(&true) {
        options.cn0_mask = Some(Cn0Mask {
            min_db_hz: pending.masks,
            rover: pending.masked[0],
            base: pending.masked[1],
        });
    }
    for (value, given) in options
        .ratio_threshold_range
        .iter_mut()
        .zip(pending.ratio_range)
    {
        *value = given.unwrap_or(*value);
    }
    if options.partial_ambiguity.is_some() {
        options.partial_ambiguity = Some(pending.partial);
    }
    // RTKLIB has no length for a base that stands, and none that is not positive.
    let [length_m, sigma_m] = pending.baseline_m;
    if options.mode == PositioningMode::MovingBase && length_m > 0.0 {
        options.baseline_length = Some(BaselineLength {
            length_m,
            sigma_m: sigma_m.max(LEAST_LENGTH_SIGMA_M),
        });
    }
    let [a, b, c] = pending.base_values;
    options.base_position = match pending.base_kind {
        1 => BasePosition::Ecef([a, b, c]),
        2 => BasePosition::AverageSingle,
        4 => BasePosition::Header,
        _ => {
            if a.abs() > 90.0 || b.abs() > 360.0 {
                return Err(ConfError::Value {
                    line: pending.base_line,
                    key: "ant2-pos1, ant2-pos2".to_owned(),
                    expected: "latitude and longitude in degrees".to_owned(),
                    found: format!("{a} {b}"),
                });
            }
            BasePosition::Ecef(ecef_from_geodetic(&Geodetic::from_degrees(a, b, c)))
        }
    };
    Ok(())
}

impl Setting {
    fn wrong(&self, expected: &str) -> ConfError {
        ConfError::Value {
            line: self.line,
            key: self.key.clone(),
            expected: expected.to_owned(),
            found: self.value.clone(),
        }
    }

    fn unsupported(&self) -> ConfError {
        ConfError::Unsupported {
            line: self.line,
            key: self.key.clone(),
            value: self.value.clone(),
        }
    }

    /// The index of a value given by name or by number.
    fn choice(&self, names: &[&str]) -> Option<usize> {
        names
            .iter()
            .position(|name| *name == self.value)
            .or_else(|| self.value.parse().ok().filter(|&i: &usize| i < names.len()))
    }

    /// A value given by name, or by its place in RTKLIB's order.
    fn named<T: Copy + std::str::FromStr>(&self, values: &[T]) -> Option<T> {
        let by_number = || values.get(self.value.parse::<usize>().ok()?).copied();
        self.value.parse().ok().or_else(by_number)
    }

    fn switch(&self) -> Result<bool, ConfError> {
        match self.choice(&["off", "on"]) {
            Some(i) => Ok(i == 1),
            None if self.value.is_empty() => Ok(false),
            None => Err(self.wrong("on or off")),
        }
    }

    fn number(&self) -> Result<f64, ConfError> {
        self.value
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| self.wrong("a number"))
    }

    fn degrees(&self) -> Result<f64, ConfError> {
        let degrees = self.number()?;
        if (0.0..90.0).contains(&degrees) {
            Ok(degrees.to_radians())
        } else {
            Err(self.wrong("degrees from 0 to below 90"))
        }
    }

    fn unsigned(&self) -> Result<u32, ConfError> {
        self.value.parse().map_err(|_| self.wrong("a whole number"))
    }

    fn signed(&self) -> Result<i32, ConfError> {
        self.value.parse().map_err(|_| self.wrong("a whole number"))
    }

    fn count(&self) -> Result<usize, ConfError> {
        self.value.parse().map_err(|_| self.wrong("a whole number"))
    }

    fn nine(&self) -> Result<[f64; 9], ConfError> {
        let mut out = [0.0; 9];
        let mut parts = self.value.split(',');
        for value in &mut out {
            let part = parts.next().unwrap_or("0").trim();
            *value = part
                .parse()
                .ok()
                .filter(|v: &f64| v.is_finite())
                .ok_or_else(|| self.wrong("nine numbers with commas"))?;
        }
        Ok(out)
    }
}
