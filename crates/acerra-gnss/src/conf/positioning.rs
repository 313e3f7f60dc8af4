//! Settings of the positioning.

use super::outcome::{FOLLOWED, Outcome, UNKNOWN, UNSUPPORTED, only};
use super::pending::Pending;
use super::requested::{NotFollowedReason, RtklibConf};
use super::setting::Setting;
use crate::observations::satellite::{SatelliteId, System, SystemSet};
use crate::observations::signal::FREQUENCY_SLOTS;
use crate::options::{AmbiguityMode, FilterDirection, GlonassAmbiguity, PositioningMode, RuleSet};

/// Keys that begin with `pos1-`.
pub(super) fn first_page(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
    let options = &mut conf.options;
    match s.key.as_str() {
        "pos1-posmode" => {
            options.mode = match (s.value.as_str(), options.rules) {
                ("movingbase", _) => PositioningMode::MovingBase,
                // RTKLIB-EX numbers a static start before this mode.
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
        // Both ends of a short baseline have the same ionospheric delay: off and broadcast are equivalent,
        // only estimation would differ.
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

/// Keys that begin with `pos2-`.
pub(super) fn second_page(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
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

/// Keys that begin with `stats-`.
pub(super) fn statistics(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
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
        // These keys concern states that are not estimated.
        "stats-stdiono" | "stats-stdtrop" | "stats-prniono" | "stats-prntrop" | "stats-prnpos" => {}
        "stats-clkstab" => options.clock_stability = s.number()?,
        _ => return UNKNOWN,
    }
    FOLLOWED
}
