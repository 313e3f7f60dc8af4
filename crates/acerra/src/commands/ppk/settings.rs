//! Settings of `acerra ppk`: presets, a configuration file and the command line, in this order.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use acerra_chain::position::positioning::{AntennaInput, AntennaName, PositioningInput};
use acerra_gnss::conf::{ConfInputs, ConfOutputs, read_conf};
use acerra_gnss::pos::{PosFormat, PosFrame};
use acerra_gnss::{
    BaselineLength, Cn0Mask, Dynamics, FilterDirection, PositioningMode, PpkOptions, RuleSet,
};
use anyhow::Context;

use super::args::Args;

/// Settings by the command line and a configuration file.
pub(super) struct Settings {
    pub(super) options: PpkOptions,
    pub(super) format: PosFormat,
    pub(super) inputs: ConfInputs,
    pub(super) outputs: ConfOutputs,
    pub(super) remarks: Vec<String>,
}

impl Args {
    /// The files of the run: those of the command line, then those of a configuration file.
    pub(super) fn input(&self, conf: ConfInputs) -> anyhow::Result<PositioningInput> {
        let stated = AntennaInput::from(&conf);
        let antennas = AntennaInput {
            rover: self.antenna(&self.rover_antenna, stated.rover),
            base: self.antenna(&self.base_antenna, stated.base),
            file: self.antennas.clone().or(stated.file),
        };
        Ok(PositioningInput {
            rover: self.rover.clone(),
            base: self.base.clone(),
            navigation: self.navigation.clone(),
            more_rover: self.more_rover.clone(),
            more_base: self.more_base.clone(),
            date: self.date,
            needs_precise_orbits: conf.precise_orbits,
            antennas: antennas.if_any(),
        })
    }

    /// A receiver's antenna: the command line's; the log's where calibrations are given and no antenna is
    /// named.
    fn antenna(&self, option: &Option<String>, stated: AntennaName) -> AntennaName {
        match option.as_deref() {
            Some("none") => AntennaName::None,
            Some(name) => AntennaName::Given(name.to_owned()),
            None if self.antennas.is_some() && stated == AntennaName::None => AntennaName::Header,
            None => stated,
        }
    }

    /// Options and outputs: preset or configuration file, overridden by the command line.
    pub(super) fn settings(&self) -> anyhow::Result<Settings> {
        let mut remarks = Vec::new();
        let (mut inputs, mut outputs) = (ConfInputs::default(), ConfOutputs::default());
        let (mut options, mut format) = match &self.config {
            Some(path) => {
                let place = || path.display().to_string();
                let file = File::open(path).with_context(place)?;
                let rules = self.rules.unwrap_or(RuleSet::Rtklib);
                let mut conf = read_conf(BufReader::new(file), rules).with_context(place)?;
                conf.find_files(path.parent().unwrap_or(Path::new("")))
                    .with_context(place)?;
                remarks.extend(
                    conf.not_followed
                        .iter()
                        .map(|setting| format!("{}: {setting}", place())),
                );
                (inputs, outputs) = (conf.inputs, conf.outputs);
                let mut options = conf.options;
                if let Some(rules) = self.rules.filter(|r| *r != options.rules) {
                    remarks.push(format!(
                        "{}: its settings are followed by the rules of {rules}, as the command \
                         line says, not of {}",
                        place(),
                        options.rules
                    ));
                    options.rules = rules;
                }
                (options, conf.format)
            }
            None => match self.rules {
                Some(RuleSet::Demo5) => (
                    PpkOptions::demo5().with_direction(FilterDirection::Combined),
                    PosFormat::default(),
                ),
                Some(RuleSet::Rtklib) => (
                    PpkOptions::rtklib()
                        .with_systems(PpkOptions::default().systems)
                        .with_direction(FilterDirection::Combined),
                    PosFormat::default(),
                ),
                None if self.unguarded => {
                    let bias_cycles = PpkOptions::rtklib().initial_bias_cycles;
                    let options = PpkOptions::default().with_initial_bias_cycles(bias_cycles);
                    (options, PosFormat::default())
                }
                None => (PpkOptions::default(), PosFormat::default()),
            },
        };
        options = match self.unguarded {
            true => options.without_safeguards(),
            false => options.guarded(),
        };
        self.override_options(&mut options);
        let moves = options.mode == PositioningMode::MovingBase;
        anyhow::ensure!(
            moves || self.baseline_length.is_none() && self.attitudes.is_none(),
            "--baseline-length and --attitudes: expected --mode moving-base, found {}",
            options.mode
        );
        if moves && self.base_position.is_some() {
            remarks.push("--base-position is not used with a moving base".to_owned());
        }
        if moves && self.config.is_none() {
            format.frame = PosFrame::EnuBaseline;
        }
        format.frame = self.format.unwrap_or(format.frame);
        format.time = self.time_form.unwrap_or(format.time);
        format.scale = self.time_scale.unwrap_or(format.scale);
        format.velocity |= self.velocities;
        Ok(Settings {
            options,
            format,
            inputs,
            outputs,
            remarks,
        })
    }

    fn override_options(&self, options: &mut PpkOptions) {
        options.mode = self.mode.unwrap_or(options.mode);
        options.start = self.start.or(options.start);
        options.end = self.end.or(options.end);
        options.direction = self.direction.unwrap_or(options.direction);
        options.ambiguity = self.ar.unwrap_or(options.ambiguity);
        options.glonass_ambiguity = self.glonass_ar.unwrap_or(options.glonass_ambiguity);
        if let Some(ratio) = self.ratio {
            options.ratio_threshold = ratio;
            options.ratio_threshold_range = [ratio; 2];
        }
        if let Some(ratio) = self.code_phase_ratio {
            options.code_phase_ratio = [ratio; acerra_gnss::FREQUENCY_SLOTS];
        }
        if let Some(length_m) = self.baseline_length {
            options.baseline_length = Some(BaselineLength {
                length_m,
                sigma_m: self.baseline_sigma,
            });
        }
        if let Some(place) = self.base_position {
            options.base_position = place;
        }
        if let Some(systems) = self.systems {
            options.systems = systems;
        }
        options.excluded_satellites.extend(&self.exclude);
        if let Some(frequencies) = self.frequencies {
            options.frequencies = usize::from(frequencies);
        }
        if let Some(mask) = self.elevation_mask {
            options.elevation_mask_rad = mask.to_radians();
        }
        if let Some(age) = self.max_age {
            options.max_age_s = age;
        }
        if let Some(least) = self.cn0_mask {
            options.cn0_mask = Some(Cn0Mask::uniform(least));
        }
        options.interpolate_base |= self.interpolate_base;
        options.output_single |= self.output_single;
        if self.dynamics && options.dynamics.is_none() {
            options.dynamics = Some(Dynamics::DRONE);
        }
    }
}
