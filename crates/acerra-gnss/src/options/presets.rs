//! The presets that reproduce known programs, and the safeguards beyond them.

use super::all::PpkOptions;
use super::choices::{
    AmbiguityMode, BasePosition, Dynamics, FilterDirection, GlonassAmbiguity, PartialAmbiguity,
    PositioningMode, RuleSet,
};
use crate::observations::satellite::{System, SystemSet};
use crate::observations::signal::FREQUENCY_SLOTS;

/// Least initial standard deviation of a phase bias of guarded runs (cycles): a bias begins at the code's
/// error, and codes further off than the limit of innovations, 30 m, are refused: three standard deviations
/// of about 10 m, 50 cycles of L1.
const LEAST_BIAS_CYCLES: f64 = 50.0;
/// Standard deviation of a single-point position that only serves to form differences (m): 3 m after
/// averaging 100,000 epochs.
const UNINFORMATIVE_SIGMA_M: f64 = 1e3;

impl PpkOptions {
    /// Carrier-to-noise density above which signal strength no longer matters (dB-Hz).
    pub const CN0_REFERENCE_DB_HZ: f64 = 52.0;

    /// RTKLIB 2.4.3: kinematic, forward, GPS L1, fix-and-hold, broadcast models.
    #[must_use]
    pub fn rtklib() -> Self {
        Self {
            mode: PositioningMode::Kinematic,
            direction: FilterDirection::Forward,
            frequencies: 1,
            start: None,
            end: None,
            systems: SystemSet::GPS,
            excluded_satellites: Vec::new(),
            elevation_mask_rad: 15f64.to_radians(),
            cn0_mask: None,
            dynamics: None,
            ambiguity: AmbiguityMode::FixAndHold,
            glonass_ambiguity: GlonassAmbiguity::Off,
            beidou_ambiguity: true,
            ratio_threshold: 3.0,
            ratio_threshold_range: [3.0, 3.0],
            position_variance_gate_m2: 0.25,
            min_lock_epochs: 0,
            min_fixes_to_hold: 10,
            max_outage_epochs: 5,
            ambiguity_elevation_mask_rad: 0.0,
            hold_elevation_mask_rad: 0.0,
            hold_variance_cycles2: 0.001,
            hold_gain: 0.01,
            revisable_hold: false,
            try_alternatives: false,
            partial_ambiguity: None,
            max_age_s: 30.0,
            interpolate_base: false,
            slip_threshold_m: 0.05,
            doppler_slip_threshold_cycles_s: 0.0,
            max_phase_innovation_m: 30.0,
            max_code_innovation_m: 30.0,
            max_phase_residual_sigma: None,
            max_code_residual_sigma: None,
            min_success_rate: None,
            measure_code_noise: false,
            max_gdop: 30.0,
            iterations: 1,
            code_phase_ratio: [100.0; FREQUENCY_SLOTS],
            phase_error_m: 0.003,
            phase_error_elevation_m: 0.003,
            phase_error_baseline_m: 0.0,
            phase_error_cn0_m: 0.0,
            weak_signal_drop_db: None,
            weigh_weak_signals: false,
            doppler_error_hz: 1.0,
            initial_bias_cycles: 30.0,
            single_point_sigma_m: 30.0,
            bias_noise_cycles: 1e-4,
            clock_stability: 5e-12,
            base_position: BasePosition::Header,
            baseline_length: None,
            rover_antenna_m: [0.0; 3],
            base_antenna_m: [0.0; 3],
            rover_calibration: None,
            base_calibration: None,
            raim: false,
            troposphere_follows_height: false,
            threads: 0,
            output_single: false,
            rules: RuleSet::Rtklib,
            reproduce_defects: false,
        }
    }

    /// These options with the rules of this crate beyond RTKLIB enabled: base data interpolated to the
    /// rover's tags, blocked or bent signals noticed by their strength and by their residuals and left out,
    /// single-point positions repaired by leaving out one satellite, the noisiest satellites left out of a
    /// fix that fails with all, a tropospheric delay that follows the height.
    ///
    /// Undisturbed data are processed as without safeguards, except for this delay: the result agrees with
    /// RTKLIB's to a millimetre horizontally, and to a few millimetres in height.
    #[must_use]
    pub fn with_safeguards(self) -> Self {
        Self {
            interpolate_base: true,
            raim: true,
            troposphere_follows_height: true,
            output_single: true,
            max_phase_residual_sigma: Some(5.0),
            max_code_residual_sigma: Some(5.0),
            min_success_rate: Some(0.99),
            measure_code_noise: true,
            initial_bias_cycles: self.initial_bias_cycles.max(LEAST_BIAS_CYCLES),
            single_point_sigma_m: UNINFORMATIVE_SIGMA_M,
            revisable_hold: true,
            try_alternatives: true,
            weak_signal_drop_db: Some(6.0),
            weigh_weak_signals: true,
            partial_ambiguity: Some(PartialAmbiguity {
                filter_new_satellites: true,
                min_satellites_to_fix: 6,
                min_pairs_to_hold: 5,
                min_pairs_to_drop: 10,
            }),
            ..self
        }
    }

    /// The default form of these options, unless RTKLIB's exact answer is required: RTKLIB's rules with the
    /// [safeguards](Self::with_safeguards); demo5's rules have separate safeguards.
    ///
    /// ```
    /// use acerra_gnss::PpkOptions;
    /// assert!(PpkOptions::rtklib().guarded().raim);
    /// assert_eq!(PpkOptions::demo5().guarded(), PpkOptions::demo5());
    /// ```
    #[must_use]
    pub fn guarded(self) -> Self {
        match self.rules {
            RuleSet::Rtklib => self.with_safeguards(),
            RuleSet::Demo5 => self,
        }
    }

    /// These options with every one of the [safeguards](Self::with_safeguards) switched off.
    #[must_use]
    pub fn without_safeguards(self) -> Self {
        Self {
            interpolate_base: false,
            raim: false,
            troposphere_follows_height: false,
            output_single: false,
            max_phase_residual_sigma: None,
            max_code_residual_sigma: None,
            min_success_rate: None,
            measure_code_noise: false,
            single_point_sigma_m: Self::rtklib().single_point_sigma_m,
            revisable_hold: false,
            try_alternatives: false,
            weak_signal_drop_db: None,
            weigh_weak_signals: false,
            partial_ambiguity: None,
            ..self
        }
    }

    /// The demo5 branch (RTKLIB-EX): settings for cheap receivers in motion.
    #[must_use]
    pub fn demo5() -> Self {
        let systems = SystemSet::GPS
            .with(System::Glonass)
            .with(System::Galileo)
            .with(System::Beidou);
        Self {
            systems,
            dynamics: Some(Dynamics::DRONE),
            glonass_ambiguity: GlonassAmbiguity::FixAndHold,
            beidou_ambiguity: false,
            min_fixes_to_hold: 20,
            max_outage_epochs: 20,
            hold_variance_cycles2: 0.1,
            max_phase_innovation_m: 5.0,
            code_phase_ratio: [300.0; FREQUENCY_SLOTS],
            partial_ambiguity: Some(PartialAmbiguity {
                filter_new_satellites: true,
                min_satellites_to_fix: 4,
                min_pairs_to_hold: 5,
                min_pairs_to_drop: 10,
            }),
            rules: RuleSet::Demo5,
            ..Self::rtklib()
        }
    }
}

impl Default for PpkOptions {
    /// Combined kinematic fix-and-hold on every system's L1, with a code/phase ratio that suits
    /// single-frequency receivers and with the [safeguards](Self::with_safeguards).
    fn default() -> Self {
        Self {
            direction: FilterDirection::Combined,
            systems: SystemSet::ALL.without(System::Sbas).without(System::Navic),
            glonass_ambiguity: GlonassAmbiguity::Auto,
            code_phase_ratio: [300.0; FREQUENCY_SLOTS],
            ..Self::rtklib()
        }
        .with_safeguards()
    }
}
