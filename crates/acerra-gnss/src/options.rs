//! Processing options, with the presets that reproduce known programs.

use crate::antex::AntennaCalibration;
use crate::satellite::{SatelliteId, System, SystemSet};
use crate::signal::FREQUENCY_SLOTS;
use acerra_geo::time::GpsTime;
use std::sync::Arc;

/// What is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PositioningMode {
    /// Each epoch alone from the rover's pseudoranges; needs no base.
    Single,
    /// Double differences of pseudoranges.
    Dgps,
    /// Carrier phase, moving rover.
    Kinematic,
    /// Carrier phase, rover standing still for the whole file.
    Static,
    /// Carrier phase between two receivers that both move, such as two antennas on one vehicle: the
    /// base is where its own codes say at each epoch, and the vector from it to the rover is
    /// [`Solution::baseline`](crate::Solution::baseline).
    MovingBase,
}

impl PositioningMode {
    /// Whether carrier phases are used.
    #[must_use]
    pub const fn uses_phases(self) -> bool {
        matches!(self, Self::Kinematic | Self::Static | Self::MovingBase)
    }
}

/// What is known of the length of a moving base's baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselineLength {
    /// Distance between the antennas' phase centres (m).
    pub length_m: f64,
    /// Its standard deviation (m).
    pub sigma_m: f64,
}

/// In which direction of time the filter runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FilterDirection {
    /// First epoch to last.
    Forward,
    /// Last epoch to first.
    Backward,
    /// Both, each from a fresh start, then merged.
    Combined,
    /// Both, the backward pass starting from the state the forward pass ended with, then merged.
    CombinedWithoutReset,
}

impl FilterDirection {
    /// Whether two passes are merged.
    #[must_use]
    pub const fn is_combined(self) -> bool {
        matches!(self, Self::Combined | Self::CombinedWithoutReset)
    }
}

/// How carrier ambiguities are resolved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AmbiguityMode {
    /// Not at all: float solution.
    Off,
    /// From the filter's float ambiguities, every epoch.
    Continuous,
    /// From each epoch alone.
    Instantaneous,
    /// As continuous, and after enough consecutive fixes the integers are fed back to the filter.
    FixAndHold,
}

/// Whether GLONASS ambiguities are resolved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GlonassAmbiguity {
    /// GLONASS phases stay float.
    Off,
    /// Treated as integers (like receivers only).
    On,
    /// Treated as integers after an inter-channel bias linear in the channel number, which is
    /// estimated along with them (Wanninger 2012, "Carrier-phase inter-frequency biases of
    /// GLONASS receivers"); left float after all where their phases contradict the other systems'.
    Auto,
    /// Inter-channel biases are learnt during the hold, then GLONASS joins in.
    FixAndHold,
}

/// Where the base antenna's marker is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BasePosition {
    /// Given (ECEF, m).
    Ecef([f64; 3]),
    /// The approximate position of the base's observation header, plus its antenna offset.
    Header,
    /// Mean of the base's single-point positions.
    AverageSingle,
}

/// Mask of carrier-to-noise density over elevation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cn0Mask {
    /// Least C/N₀ (dB-Hz) at elevations 5°, 15°, …, 85° per frequency slot; linear in between.
    pub min_db_hz: [[f64; 9]; FREQUENCY_SLOTS],
    /// Whether it applies to the rover.
    pub rover: bool,
    /// Whether it applies to the base.
    pub base: bool,
}

impl Cn0Mask {
    /// The same least C/N₀ (dB-Hz) at every elevation and frequency, for rover and base.
    #[must_use]
    pub const fn uniform(min_db_hz: f64) -> Self {
        Self {
            min_db_hz: [[min_db_hz; 9]; FREQUENCY_SLOTS],
            rover: true,
            base: true,
        }
    }
}

/// Prediction of the rover's motion from velocity and acceleration states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dynamics {
    /// Horizontal acceleration noise (m/s²/√s).
    pub horizontal_noise: f64,
    /// Vertical acceleration noise (m/s²/√s).
    pub vertical_noise: f64,
}

impl Dynamics {
    /// A multicopter's: it turns and climbs with metres per second squared.
    pub const DRONE: Self = Self {
        horizontal_noise: 3.0,
        vertical_noise: 1.0,
    };
}

/// Which established program's rules are followed where they differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RuleSet {
    /// RTKLIB 2.4.3.
    Rtklib,
    /// The demo5 branch (RTKLIB-EX): made for cheap receivers in motion.
    Demo5,
}

/// Partial ambiguity resolution: leaving satellites out when the ratio test fails.
///
/// With [`RuleSet::Rtklib`] the noisiest satellites are left out one after the other within the
/// epoch, until the test passes or too few remain; with [`RuleSet::Demo5`] one satellite per
/// epoch, in turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartialAmbiguity {
    /// Put back satellites that join just when the ratio drops.
    pub filter_new_satellites: bool,
    /// Least number of satellites (pairs + 1) for a fix ([`RuleSet::Rtklib`]: once any is left
    /// out).
    pub min_satellites_to_fix: usize,
    /// Least number of pairs for a hold.
    pub min_pairs_to_hold: usize,
    /// Take satellites out one by one after a failure when at least this many pairs were used.
    pub min_pairs_to_drop: usize,
}

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
    /// What is estimated.
    pub mode: PositioningMode,
    /// Forward, backward or combined.
    pub direction: FilterDirection,
    /// Number of frequency slots used, 1 (L1), 2 (L1+L2) or 3 (L1+L2+L5).
    pub frequencies: usize,
    /// The rover's epochs before this time tag are not used, to within 25 ms. Slips flagged there
    /// count at the first epoch that is.
    pub start: Option<GpsTime>,
    /// Nor are those after this one.
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
    /// Keep integers beside the filter, so that they can be withdrawn, rather than feed them back
    /// into it ([`RuleSet::Rtklib`]).
    pub revisable_hold: bool,
    /// Where fixing is poor, try other settings and take what they agree on better: a hold within
    /// the filter, and a C/N₀ mask where none is set.
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
    /// Largest phase residual in units of its standard deviation: satellites beyond it are left
    /// out of the epoch, and of a fix; `None` checks nothing.
    pub max_phase_residual_sigma: Option<f64>,
    /// Largest code residual in units of its standard deviation: satellites beyond it are left out
    /// of the epoch, and one that begins there begins later; `None` checks nothing.
    pub max_code_residual_sigma: Option<f64>,
    /// Least probability, from the covariance of the float ambiguities, that integers which pass
    /// the ratio test are the right ones; `None` asks the ratio alone, which a wrong set passes
    /// easily while there is little to tell it by.
    pub min_success_rate: Option<f64>,
    /// Weigh codes by their noise and its correlation in time as measured from code minus phase,
    /// instead of by [`code_phase_ratio`](Self::code_phase_ratio) alone.
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
    /// Phase error of a signal of [`CN0_REFERENCE_DB_HZ`](Self::CN0_REFERENCE_DB_HZ); a weaker
    /// one's variance is ten times larger for every 10 dB (m). 0 leaves signal strength out.
    pub phase_error_cn0_m: f64,
    /// Weaken signals that are this much (dB) below their own usual strength, as one blocked or
    /// bent by an obstacle is: the standard deviation grows tenfold for every further 10 dB.
    /// `None` weakens none. Undisturbed signals are weighed as without.
    pub weak_signal_drop_db: Option<f64>,
    /// Weigh weak signals by their C/N₀ where that says more noise than their elevation does; those
    /// of usual strength are weighed as without.
    pub weigh_weak_signals: bool,
    /// Doppler error (Hz).
    pub doppler_error_hz: f64,
    /// Initial standard deviation of a phase bias (cycles).
    pub initial_bias_cycles: f64,
    /// Standard deviation with which a kinematic filter without dynamics takes its position from the
    /// single-point solution at every epoch (m). RTKLIB's 30 m, taken for new each time, are 0.9 m after
    /// 1,200 epochs, and the error of single-point positions, metres for hours and mostly in height, draws
    /// float positions by decimetres.
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
    /// Let the rover's tropospheric delay change with its estimated height. RTKLIB keeps the delay
    /// at the single-point height, which is metres off: 5 m draw the estimated height by 5 to 10 mm.
    pub troposphere_follows_height: bool,
    /// Threads used; 0 means as many as the processor has. The answer does not depend on it.
    pub threads: usize,
    /// Report a single-point position where no better one exists.
    pub output_single: bool,
    /// Whose rules are followed where RTKLIB and demo5 differ.
    pub rules: RuleSet,
    /// Reproduce RTKLIB 2.4.3 b34 where it is wrong; for comparisons only.
    pub reproduce_defects: bool,
}

/// Least initial standard deviation of a phase bias of guarded runs (cycles): a bias begins at the code's
/// error, and codes further off than the limit of innovations, 30 m, are refused: that limit is three
/// deviations of about 10 m, 50 cycles of L1.
const LEAST_BIAS_CYCLES: f64 = 50.0;
/// Deviation of a single-point position that says where differences are formed and nothing else (m): after
/// 100,000 epochs it is still 3 m.
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

    /// These options with what this crate does beyond RTKLIB switched on: base data interpolated
    /// to the rover's tags, blocked or bent signals noticed by their strength and by their
    /// residuals and left out, single-point positions mended by leaving out one satellite, the
    /// noisiest satellites left out of a fix that fails with all, a tropospheric delay that follows
    /// the height.
    ///
    /// Undisturbed data are processed as without, but for that delay: the answer then stays
    /// RTKLIB's to a millimetre horizontally, and to a few in height.
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

    /// These options as they are used unless RTKLIB's very answer is wanted: by RTKLIB's rules with
    /// the [safeguards](Self::with_safeguards); demo5's rules have their own.
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

    /// The demo5 branch (RTKLIB-EX): what cheap receivers in motion need.
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
