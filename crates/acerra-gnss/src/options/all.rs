//! All settings of the engine, and a `with_` method for each.

use super::choices::{
    AmbiguityMode, BasePosition, BaselineLength, Cn0Mask, Dynamics, FilterDirection,
    GlonassAmbiguity, PartialAmbiguity, PositioningMode, RuleSet,
};
use crate::antex::AntennaCalibration;
use crate::observations::satellite::{SatelliteId, SystemSet};
use crate::observations::signal::FREQUENCY_SLOTS;
use acerra_geo::time::GpsTime;
use std::sync::Arc;

/// All settings of the engine.
///
/// Build from a preset and change settings; every field has a `with_` method:
/// ```
/// use acerra_gnss::{FilterDirection, PpkOptions, SystemSet};
/// let options = PpkOptions::rtklib()
///     .with_direction(FilterDirection::Combined)
///     .with_systems(SystemSet::GPS)
///     .with_ratio_threshold(2.5);
/// assert_eq!(options.ratio_threshold, 2.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PpkOptions {
    /// Positioning mode.
    pub mode: PositioningMode,
    /// Forward, backward or combined.
    pub direction: FilterDirection,
    /// Number of frequency slots used, 1 (L1), 2 (L1+L2) or 3 (L1+L2+L5).
    pub frequencies: usize,
    /// The rover's epochs before this time tag are not used, to within 25 ms. Slips flagged at these epochs
    /// count at the first epoch used.
    pub start: Option<GpsTime>,
    /// The rover's epochs after this time tag are not used, to within 25 ms.
    pub end: Option<GpsTime>,
    /// Systems used.
    pub systems: SystemSet,
    /// Satellites never used.
    pub excluded_satellites: Vec<SatelliteId>,
    /// Elevation mask (rad).
    pub elevation_mask_rad: f64,
    /// C/N₀ mask, if any.
    pub cn0_mask: Option<Cn0Mask>,
    /// Motion model; `None` re-initialises the position at every epoch.
    pub dynamics: Option<Dynamics>,
    /// Ambiguity resolution.
    pub ambiguity: AmbiguityMode,
    /// GLONASS ambiguities.
    pub glonass_ambiguity: GlonassAmbiguity,
    /// Whether BeiDou ambiguities are resolved.
    pub beidou_ambiguity: bool,
    /// Least ratio of second-best to best sum of squares for a fix.
    pub ratio_threshold: f64,
    /// Bounds of the threshold when it depends on the number of pairs; both equal to
    /// `ratio_threshold` (the default) make it constant.
    pub ratio_threshold_range: [f64; 2],
    /// Largest mean variance of the float position (m²) at which a fix is tried
    /// ([`RuleSet::Demo5`]).
    pub position_variance_gate_m2: f64,
    /// Epochs a satellite must be locked before its ambiguity is resolved.
    pub min_lock_epochs: i32,
    /// Consecutive fixes before the integers are held.
    pub min_fixes_to_hold: u32,
    /// Epochs without data after which a satellite's ambiguity is forgotten.
    pub max_outage_epochs: u32,
    /// Elevation mask for ambiguity resolution (rad).
    pub ambiguity_elevation_mask_rad: f64,
    /// Elevation mask for the hold (rad).
    pub hold_elevation_mask_rad: f64,
    /// Variance of held ambiguities (cycle²).
    pub hold_variance_cycles2: f64,
    /// Share of a GLONASS inter-channel fraction taken up at each hold.
    pub hold_gain: f64,
    /// Keep integers outside the filter, so that integers can be withdrawn, instead of feeding them back into
    /// the filter ([`RuleSet::Rtklib`]).
    pub revisable_hold: bool,
    /// Where fixing is poor, try other settings and use the fixes on which the passes agree better: a hold
    /// within the filter, and a C/N₀ mask where none is set.
    pub try_alternatives: bool,
    /// Partial ambiguity resolution, if any.
    pub partial_ambiguity: Option<PartialAmbiguity>,
    /// Largest age of the base's data (s).
    pub max_age_s: f64,
    /// Interpolate the base's data to the rover's tags.
    pub interpolate_base: bool,
    /// Geometry-free slip threshold (m), two or more frequencies.
    pub slip_threshold_m: f64,
    /// Doppler slip threshold (cycles/s), 0 = off ([`RuleSet::Demo5`]).
    pub doppler_slip_threshold_cycles_s: f64,
    /// Largest phase innovation (m).
    pub max_phase_innovation_m: f64,
    /// Largest code innovation (m).
    pub max_code_innovation_m: f64,
    /// Largest phase residual in units of its standard deviation: satellites with larger residuals are left
    /// out of the epoch, and of a fix; `None` disables the check.
    pub max_phase_residual_sigma: Option<f64>,
    /// Largest code residual in units of its standard deviation: satellites with larger residuals are left
    /// out of the epoch, and a new satellite begins at a later epoch; `None` disables the check.
    pub max_code_residual_sigma: Option<f64>,
    /// Least probability, from the covariance of the float ambiguities, that integers which pass the ratio
    /// test are the right ones; `None` uses the ratio test alone, which a wrong set passes easily while few
    /// data contradict the set.
    pub min_success_rate: Option<f64>,
    /// Weight codes by their noise and its correlation in time, measured from code minus phase, instead of by
    /// [`code_phase_ratio`](Self::code_phase_ratio) alone.
    pub measure_code_noise: bool,
    /// Largest GDOP of a single-point position.
    pub max_gdop: f64,
    /// Measurement updates per epoch.
    pub iterations: usize,
    /// Code standard deviation over phase standard deviation, per frequency slot.
    pub code_phase_ratio: [f64; FREQUENCY_SLOTS],
    /// Phase error, constant part (m).
    pub phase_error_m: f64,
    /// Phase error, part divided by the sine of elevation (m).
    pub phase_error_elevation_m: f64,
    /// Phase error per 10 km of baseline (m).
    pub phase_error_baseline_m: f64,
    /// Phase error of a signal of [`CN0_REFERENCE_DB_HZ`](Self::CN0_REFERENCE_DB_HZ); a weaker one's variance
    /// is ten times larger for every 10 dB (m). 0 ignores signal strength.
    pub phase_error_cn0_m: f64,
    /// Drop (dB) below a signal's usual strength from which its weight is reduced, since obstacles may block
    /// or bend the signal: the standard deviation grows tenfold for every further 10 dB. `None` disables
    /// this. Undisturbed signals keep their weight.
    pub weak_signal_drop_db: Option<f64>,
    /// Weight weak signals by their C/N₀ where it implies more noise than their elevation does; signals of
    /// usual strength keep their weight.
    pub weigh_weak_signals: bool,
    /// Doppler error (Hz).
    pub doppler_error_hz: f64,
    /// Initial standard deviation of a phase bias (cycles).
    pub initial_bias_cycles: f64,
    /// Standard deviation with which a kinematic filter without dynamics takes its position from the
    /// single-point solution at every epoch (m). RTKLIB's 30 m, treated as independent at each epoch, are 0.9
    /// m after 1,200 epochs, and the error of single-point positions, metres for hours and mostly in height,
    /// biases float positions by decimetres.
    pub single_point_sigma_m: f64,
    /// Process noise of phase biases (cycles/√s).
    pub bias_noise_cycles: f64,
    /// Receiver clock stability (s/s).
    pub clock_stability: f64,
    /// Position of the base; not used with a moving base.
    pub base_position: BasePosition,
    /// Distance between the two antennas, where it is known ([`PositioningMode::MovingBase`]).
    pub baseline_length: Option<BaselineLength>,
    /// Rover antenna's phase centre from its marker: east, north, up (m).
    pub rover_antenna_m: [f64; 3],
    /// Base antenna's phase centre from its marker: east, north, up (m).
    pub base_antenna_m: [f64; 3],
    /// Phase centres of the rover's antenna, from its reference point; `None` takes it for a
    /// point.
    pub rover_calibration: Option<Arc<AntennaCalibration>>,
    /// Phase centres of the base's antenna.
    pub base_calibration: Option<Arc<AntennaCalibration>>,
    /// Leave out satellites one by one when a single-point position fails its validation.
    pub raim: bool,
    /// Let the rover's tropospheric delay change with its estimated height. RTKLIB keeps the delay at the
    /// single-point height, which is metres off: 5 m bias the estimated height by 5 to 10 mm.
    pub troposphere_follows_height: bool,
    /// Threads used; 0 means as many as the processor has. The answer does not depend on it.
    pub threads: usize,
    /// Report a single-point position where no better one exists.
    pub output_single: bool,
    /// Program whose rules are followed where RTKLIB and demo5 differ.
    pub rules: RuleSet,
    /// Reproduce RTKLIB 2.4.3 b34 where it is wrong; for comparisons only.
    pub reproduce_defects: bool,
}

/// Generates a `with_` method for each field.
macro_rules! with_methods {
    ($($field:ident: $type:ty => $method:ident),+ $(,)?) => {
        impl PpkOptions {
            $(
                #[doc = concat!("These options with [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub fn $method(self, $field: $type) -> Self {
                    Self { $field, ..self }
                }
            )+
        }
    };
}

with_methods! {
    mode: PositioningMode => with_mode,
    direction: FilterDirection => with_direction,
    frequencies: usize => with_frequencies,
    start: Option<GpsTime> => with_start,
    end: Option<GpsTime> => with_end,
    systems: SystemSet => with_systems,
    excluded_satellites: Vec<SatelliteId> => with_excluded_satellites,
    elevation_mask_rad: f64 => with_elevation_mask_rad,
    cn0_mask: Option<Cn0Mask> => with_cn0_mask,
    dynamics: Option<Dynamics> => with_dynamics,
    ambiguity: AmbiguityMode => with_ambiguity,
    glonass_ambiguity: GlonassAmbiguity => with_glonass_ambiguity,
    beidou_ambiguity: bool => with_beidou_ambiguity,
    ratio_threshold: f64 => with_ratio_threshold,
    ratio_threshold_range: [f64; 2] => with_ratio_threshold_range,
    position_variance_gate_m2: f64 => with_position_variance_gate_m2,
    min_lock_epochs: i32 => with_min_lock_epochs,
    min_fixes_to_hold: u32 => with_min_fixes_to_hold,
    max_outage_epochs: u32 => with_max_outage_epochs,
    ambiguity_elevation_mask_rad: f64 => with_ambiguity_elevation_mask_rad,
    hold_elevation_mask_rad: f64 => with_hold_elevation_mask_rad,
    hold_variance_cycles2: f64 => with_hold_variance_cycles2,
    hold_gain: f64 => with_hold_gain,
    revisable_hold: bool => with_revisable_hold,
    try_alternatives: bool => with_try_alternatives,
    partial_ambiguity: Option<PartialAmbiguity> => with_partial_ambiguity,
    max_age_s: f64 => with_max_age_s,
    interpolate_base: bool => with_interpolate_base,
    slip_threshold_m: f64 => with_slip_threshold_m,
    doppler_slip_threshold_cycles_s: f64 => with_doppler_slip_threshold_cycles_s,
    max_phase_innovation_m: f64 => with_max_phase_innovation_m,
    max_code_innovation_m: f64 => with_max_code_innovation_m,
    max_phase_residual_sigma: Option<f64> => with_max_phase_residual_sigma,
    max_code_residual_sigma: Option<f64> => with_max_code_residual_sigma,
    min_success_rate: Option<f64> => with_min_success_rate,
    measure_code_noise: bool => with_measure_code_noise,
    max_gdop: f64 => with_max_gdop,
    iterations: usize => with_iterations,
    code_phase_ratio: [f64; FREQUENCY_SLOTS] => with_code_phase_ratio,
    phase_error_m: f64 => with_phase_error_m,
    phase_error_elevation_m: f64 => with_phase_error_elevation_m,
    phase_error_baseline_m: f64 => with_phase_error_baseline_m,
    phase_error_cn0_m: f64 => with_phase_error_cn0_m,
    weak_signal_drop_db: Option<f64> => with_weak_signal_drop_db,
    weigh_weak_signals: bool => with_weigh_weak_signals,
    doppler_error_hz: f64 => with_doppler_error_hz,
    initial_bias_cycles: f64 => with_initial_bias_cycles,
    single_point_sigma_m: f64 => with_single_point_sigma_m,
    bias_noise_cycles: f64 => with_bias_noise_cycles,
    clock_stability: f64 => with_clock_stability,
    base_position: BasePosition => with_base_position,
    baseline_length: Option<BaselineLength> => with_baseline_length,
    rover_antenna_m: [f64; 3] => with_rover_antenna_m,
    base_antenna_m: [f64; 3] => with_base_antenna_m,
    rover_calibration: Option<Arc<AntennaCalibration>> => with_rover_calibration,
    base_calibration: Option<Arc<AntennaCalibration>> => with_base_calibration,
    raim: bool => with_raim,
    troposphere_follows_height: bool => with_troposphere_follows_height,
    threads: usize => with_threads,
    output_single: bool => with_output_single,
    rules: RuleSet => with_rules,
    reproduce_defects: bool => with_reproduce_defects,
}
