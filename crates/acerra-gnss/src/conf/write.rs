//! Options as an RTKLIB configuration file.

use std::fmt::{Display, Write as _};

use crate::observations::satellite::System;
use crate::options::{BasePosition, FilterDirection, PositioningMode, PpkOptions, RuleSet};

/// The options as the text of an RTKLIB configuration file, which [`read_conf`](super::read_conf) reads back.
/// Options without a key in RTKLIB are written as comments at the end.
///
/// ```
/// use acerra_gnss::conf::{read_conf, write_conf};
/// use acerra_gnss::{PpkOptions, RuleSet};
/// let options = PpkOptions::demo5();
/// let read = read_conf(write_conf(&options).as_bytes(), RuleSet::Demo5)?;
/// assert_eq!(read.options, options);
/// # Ok::<(), acerra_gnss::conf::ConfError>(())
/// ```
#[must_use]
pub fn write_conf(options: &PpkOptions) -> String {
    let mut text = Lines::default();
    first_page(&mut text, options);
    second_page(&mut text, options);
    statistics(&mut text, options);
    antennas(&mut text, options);
    without_keys(&mut text, options);
    text.0
}

/// The text so far.
#[derive(Default)]
struct Lines(String);

impl Lines {
    fn set(&mut self, key: &str, value: impl Display) {
        let _ = writeln!(self.0, "{key:<18} ={value}");
    }

    fn switch(&mut self, key: &str, is_on: bool) {
        self.set(key, if is_on { "on" } else { "off" });
    }

    fn remark(&mut self, text: impl Display) {
        let _ = writeln!(self.0, "# {text}");
    }
}

fn first_page(text: &mut Lines, options: &PpkOptions) {
    text.set(
        "pos1-posmode",
        match options.mode {
            PositioningMode::MovingBase => "movingbase",
            mode => mode.name(),
        },
    );
    let frequencies = ["l1", "l1+l2", "l1+l2+l5"];
    let count = options.frequencies.clamp(1, frequencies.len());
    text.set("pos1-frequency", frequencies[count - 1]);
    text.set(
        "pos1-soltype",
        match options.direction {
            FilterDirection::CombinedWithoutReset => "combined-nophasereset",
            direction => direction.name(),
        },
    );
    text.set("pos1-elmask", degrees(options.elevation_mask_rad));
    if let Some(mask) = &options.cn0_mask {
        text.switch("pos1-snrmask_r", mask.rover);
        text.switch("pos1-snrmask_b", mask.base);
        for (name, values) in ["L1", "L2", "L5"].iter().zip(&mask.min_db_hz) {
            let values: Vec<String> = values.iter().map(ToString::to_string).collect();
            text.set(&format!("pos1-snrmask_{name}"), values.join(","));
        }
    }
    text.switch("pos1-dynamics", options.dynamics.is_some());
    text.switch("pos1-posopt5", options.raim);
    let names: Vec<String> = options
        .excluded_satellites
        .iter()
        .map(ToString::to_string)
        .collect();
    if !names.is_empty() {
        text.set("pos1-exclsats", names.join(" "));
    }
    let bits = [
        System::Gps,
        System::Sbas,
        System::Glonass,
        System::Galileo,
        System::Qzss,
        System::Beidou,
        System::Navic,
    ];
    let wanted = bits
        .iter()
        .enumerate()
        .filter(|(_, system)| options.systems.contains(**system));
    text.set("pos1-navsys", wanted.map(|(bit, _)| 1 << bit).sum::<u32>());
}

fn second_page(text: &mut Lines, options: &PpkOptions) {
    let is_demo5 = options.rules == RuleSet::Demo5;
    text.set("pos2-armode", options.ambiguity);
    text.set(
        "pos2-gloarmode",
        match options.glonass_ambiguity.name() {
            "auto" => "autocal",
            name => name,
        },
    );
    text.switch("pos2-bdsarmode", options.beidou_ambiguity);
    text.set("pos2-arthres", options.ratio_threshold);
    text.set("pos2-arthres1", options.position_variance_gate_m2);
    text.set("pos2-arlockcnt", options.min_lock_epochs);
    text.set(
        "pos2-arelmask",
        degrees(options.ambiguity_elevation_mask_rad),
    );
    text.set("pos2-arminfix", options.min_fixes_to_hold);
    text.set("pos2-elmaskhold", degrees(options.hold_elevation_mask_rad));
    text.set("pos2-aroutcnt", options.max_outage_epochs);
    text.set("pos2-maxage", options.max_age_s);
    text.set("pos2-slipthres", options.slip_threshold_m);
    text.set("pos2-rejionno", options.max_phase_innovation_m);
    text.set("pos2-rejgdop", options.max_gdop);
    text.set("pos2-niter", options.iterations);
    if let Some(length) = &options.baseline_length {
        text.set("pos2-baselen", length.length_m);
        text.set("pos2-basesig", length.sigma_m);
    }
    if !is_demo5 {
        return;
    }
    let [least, most] = options.ratio_threshold_range;
    text.set("pos2-arthresmin", least);
    text.set("pos2-arthresmax", most);
    text.set("pos2-varholdamb", options.hold_variance_cycles2);
    text.set("pos2-gainholdamb", options.hold_gain);
    text.set("pos2-rejcode", options.max_code_innovation_m);
    text.set("pos2-dopthres", options.doppler_slip_threshold_cycles_s);
    if let Some(partial) = &options.partial_ambiguity {
        text.switch("pos2-arfilter", partial.filter_new_satellites);
        text.set("pos2-minfixsats", partial.min_satellites_to_fix);
        text.set("pos2-minholdsats", partial.min_pairs_to_hold);
        text.set("pos2-mindropsats", partial.min_pairs_to_drop);
    }
}

fn statistics(text: &mut Lines, options: &PpkOptions) {
    for (name, ratio) in ["1", "2", "5"].iter().zip(options.code_phase_ratio) {
        text.set(&format!("stats-eratio{name}"), ratio);
    }
    text.set("stats-errphase", options.phase_error_m);
    text.set("stats-errphaseel", options.phase_error_elevation_m);
    text.set("stats-errphasebl", options.phase_error_baseline_m);
    text.set("stats-errdoppler", options.doppler_error_hz);
    if options.rules == RuleSet::Demo5 {
        text.set("stats-errsnr", options.phase_error_cn0_m);
    }
    text.set("stats-stdbias", options.initial_bias_cycles);
    if let Some(dynamics) = &options.dynamics {
        text.set("stats-prnaccelh", dynamics.horizontal_noise);
        text.set("stats-prnaccelv", dynamics.vertical_noise);
    }
    text.set("stats-prnbias", options.bias_noise_cycles);
    text.set("stats-clkstab", options.clock_stability);
}

fn antennas(text: &mut Lines, options: &PpkOptions) {
    let antennas = [
        ("ant1", options.rover_antenna_m),
        ("ant2", options.base_antenna_m),
    ];
    for (antenna, offset_m) in antennas {
        for (axis, value) in ["e", "n", "u"].iter().zip(offset_m) {
            text.set(&format!("{antenna}-antdel{axis}"), value);
        }
    }
    match options.base_position {
        BasePosition::Header => text.set("ant2-postype", "rinexhead"),
        BasePosition::AverageSingle => text.set("ant2-postype", "single"),
        BasePosition::Ecef(ecef_m) => {
            text.set("ant2-postype", "xyz");
            for (k, value) in ecef_m.iter().enumerate() {
                text.set(&format!("ant2-pos{}", k + 1), value);
            }
        }
    }
}

/// Options without a key in RTKLIB.
fn without_keys(text: &mut Lines, options: &PpkOptions) {
    text.remark("Without a key in RTKLIB:");
    text.remark(format!("rules of {}", options.rules));
    for (name, time) in [("start", options.start), ("end", options.end)] {
        if let Some(time) = time {
            text.remark(format!("{name} {time}"));
        }
    }
    for (name, is_on) in [
        ("holds are revisable", options.revisable_hold),
        (
            "alternative sets of integers are tried",
            options.try_alternatives,
        ),
        ("the base's data are interpolated", options.interpolate_base),
        ("the noise of codes is measured", options.measure_code_noise),
        ("weak signals are weighed down", options.weigh_weak_signals),
        (
            "the troposphere follows the height",
            options.troposphere_follows_height,
        ),
        ("single-point positions fill gaps", options.output_single),
    ] {
        text.remark(format!("{name}: {}", if is_on { "yes" } else { "no" }));
    }
    for (name, limit) in [
        (
            "largest phase residual in standard deviations",
            options.max_phase_residual_sigma,
        ),
        (
            "largest code residual in standard deviations",
            options.max_code_residual_sigma,
        ),
        (
            "least success rate of the integers",
            options.min_success_rate,
        ),
        (
            "drop of C/N0 (dB) from which a signal is weak",
            options.weak_signal_drop_db,
        ),
    ] {
        text.remark(format!(
            "{name}: {}",
            limit.map_or_else(|| "none".to_owned(), |v| v.to_string())
        ));
    }
    if options.rules == RuleSet::Rtklib {
        text.remark(format!(
            "largest innovation of codes (m): {}",
            options.max_code_innovation_m
        ));
    }
}

/// Degrees that read back to the same radians.
fn degrees(rad: f64) -> f64 {
    let degrees = rad.to_degrees();
    let rounded = (degrees * 1e9).round() / 1e9;
    if rounded.to_radians() == rad {
        rounded
    } else {
        degrees
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conf::read_conf;
    use crate::observations::satellite::SystemSet;
    use crate::options::{BaselineLength, Cn0Mask, Dynamics, GlonassAmbiguity};

    #[test]
    fn what_is_written_is_read_back() {
        let place = BasePosition::Ecef([4_672_693.301_25, 1_197_089.003, 4_159_080.01]);
        let rtklib = PpkOptions::rtklib().with_base_position(place);
        let demo5 = PpkOptions::demo5()
            .with_base_position(BasePosition::AverageSingle)
            .with_direction(FilterDirection::CombinedWithoutReset)
            .with_cn0_mask(Some(Cn0Mask::uniform(33.0)));
        let odd = PpkOptions::rtklib()
            .with_mode(PositioningMode::MovingBase)
            .with_baseline_length(Some(BaselineLength {
                length_m: 1.25,
                sigma_m: 0.01,
            }))
            .with_systems(SystemSet::GPS.with(System::Beidou))
            .with_elevation_mask_rad(12.5_f64.to_radians())
            .with_dynamics(Some(Dynamics::DRONE))
            .with_glonass_ambiguity(GlonassAmbiguity::Auto);
        for options in [rtklib, demo5, odd] {
            let text = write_conf(&options);
            let read = read_conf(text.as_bytes(), options.rules).unwrap();
            assert_eq!(read.options, options, "{text}");
            assert!(read.not_followed.is_empty(), "{:?}", read.not_followed);
        }
    }
}
