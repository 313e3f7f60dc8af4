//! Preparation that all attempts share: satellites, single-point positions, the base's place and data.

use super::diagnose::{base_gaps, missing_navigation, phases_and_copies};
use crate::control::watch::Watch;
use crate::control::workers::{join, threads};
use crate::measurements::base_zeros::{BaseStates, BaseZeros};
use crate::measurements::constellation::{Constellation, SatelliteState, Unusable};
use crate::measurements::measurement::{Epoch, epochs};
use crate::measurements::plausible::reject_implausible;
use crate::noise::calibration::Calibration;
use crate::noise::code_noise::MeasuredNoise;
use crate::observations::observation::{EPOCH_TOLERANCE_S, ObservationData};
use crate::options::{PositioningMode, PpkOptions};
use crate::orbits::navigation::{Klobuchar, Navigation};
use crate::single::SingleContext;
use crate::solution::{PpkError, PpkWarning, TimeSpan};
use crate::stations::base_position::{BasePlace, base_position};
use crate::stations::epoch_input::RoverEpoch;
use crate::stations::moving_base::BaseTrack;
use acerra_geo::time::GpsTime;
use std::sync::{Arc, OnceLock};

/// Rover, base and auxiliary data.
pub(crate) struct Inputs<'a> {
    pub rover: &'a ObservationData,
    pub base: &'a ObservationData,
    pub navigation: &'a Navigation,
    /// First and last rover epoch of the time window.
    pub rover_span: TimeSpan,
}

/// The logs prepared for the filter, by the relevant options: systems, frequencies, masks and the base's
/// position, but not the resolution of ambiguities.
pub(crate) struct Preparation {
    pub constellation: Constellation,
    pub klobuchar: Klobuchar,
    pub options: PpkOptions,
    pub rover: Vec<RoverEpoch>,
    pub base: Arc<[Epoch]>,
    pub base_zeros: BaseZeros,
    pub base_states: Arc<BaseStates>,
    pub base_place: BasePlace,
    /// Position of a moving base at each of the base's epochs.
    pub base_track: Option<Arc<BaseTrack>>,
    /// Noise measured from code minus phase.
    pub noise: MeasuredNoise,
    pub warnings: Vec<PpkWarning>,
}

impl Preparation {
    /// Prepares the logs.
    ///
    /// # Errors
    /// No satellites, no navigation data, or no place of the base.
    pub(crate) fn new(
        inputs: &Inputs<'_>,
        options: &PpkOptions,
        watch: &Watch<'_>,
    ) -> Result<Self, PpkError> {
        Self::with_known(inputs, options, None, watch)
    }

    /// The logs prepared for options that differ from this preparation's at most in the C/N₀ mask: data
    /// independent of the mask are reused.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
    pub(crate) fn masked(
        &self,
        inputs: &Inputs<'_>,
        options: &PpkOptions,
        watch: &Watch<'_>,
    ) -> Result<Self, PpkError> {
        Self::with_known(inputs, options, Some(self), watch)
    }

    fn with_known(
        inputs: &Inputs<'_>,
        options: &PpkOptions,
        known: Option<&Self>,
        watch: &Watch<'_>,
    ) -> Result<Self, PpkError> {
        let &Inputs {
            rover,
            base,
            navigation,
            rover_span,
        } = inputs;
        let relative = options.mode != PositioningMode::Single;
        let mut warnings = Vec::new();
        let constellation =
            Constellation::new(rover, relative.then_some(base), navigation, options);
        if constellation.len() == 0 {
            return Err(PpkError::NoSatellites);
        }
        let klobuchar = navigation.klobuchar.filter(|k| !k.is_zero());
        if klobuchar.is_none() {
            warnings.push(PpkWarning::DefaultIonosphere);
        }
        let klobuchar = klobuchar.unwrap_or(Klobuchar::FALLBACK);
        let context = |is_base: bool| SingleContext {
            constellation: &constellation,
            klobuchar: &klobuchar,
            options,
            base: is_base,
        };
        let rover_measured: Vec<Received> = match known {
            Some(known) => known.rover.iter().map(Received::from).collect(),
            None => {
                let mut measured = epochs(rover, &constellation);
                measured.retain(|e| is_wanted(options, e.tag));
                measured.into_iter().map(Received::from).collect()
            }
        };
        let rover_epochs = rover_epochs(&context(false), rover_measured, options, watch)?;
        let any_state = rover_epochs
            .iter()
            .any(|e| e.states.iter().any(Result::is_ok));
        if !any_state {
            let times = || {
                navigation
                    .ephemerides
                    .iter()
                    .map(crate::orbits::navigation::Ephemeris::toe)
            };
            return Err(PpkError::NoNavigation {
                observations: rover_span,
                navigation: times().min().zip(times().max()),
            });
        }
        missing_navigation(&constellation, &rover_epochs, &mut warnings);

        let mut base_track = None;
        let (base_epochs, base_place) = if relative {
            phases_and_copies(rover, base, options, &mut warnings);
            let base_epochs = match known {
                Some(known) => Arc::clone(&known.base),
                None => epochs(base, &constellation).into(),
            };
            base_gaps(&base_epochs, &rover_epochs, options, &mut warnings);
            let context = context(true);
            let place = if options.mode == PositioningMode::MovingBase {
                // Alternative masks must not move the base between attempts.
                let track = match known.and_then(|known| known.base_track.as_ref()) {
                    Some(track) => Arc::clone(track),
                    None => Arc::new(BaseTrack::of(&context, &base_epochs)),
                };
                let first = track.first_ecef_m().ok_or(PpkError::BasePositionMissing {
                    own_single_ecef_m: None,
                })?;
                base_track = Some(track);
                BasePlace {
                    position_ecef_m: first,
                    from_single_m: None,
                }
            } else {
                base_position(&context, base, &base_epochs, options, &mut warnings)?
            };
            (base_epochs, place)
        } else {
            (Arc::default(), BasePlace::default())
        };
        let noise = if options.measure_code_noise && relative {
            MeasuredNoise::measure(&constellation, options, &rover_epochs, &base_epochs)
                .calibrated(Calibration::prior())
        } else {
            MeasuredNoise::model()
        };
        Ok(Self {
            base_zeros: BaseZeros::new(rover_epochs.len()),
            base_states: known.map_or_else(
                || Arc::new(BaseStates::new(rover_epochs.len())),
                |known| Arc::clone(&known.base_states),
            ),
            klobuchar,
            options: options.clone(),
            rover: rover_epochs,
            base: base_epochs,
            base_place,
            base_track,
            noise,
            warnings,
            constellation,
        })
    }
}

/// Whether an epoch lies in the requested time window.
pub(crate) fn is_wanted(options: &PpkOptions, tag: GpsTime) -> bool {
    let late_s = |t: GpsTime| tag.seconds_since(t);
    options
        .start
        .is_none_or(|t| late_s(t) >= -EPOCH_TOLERANCE_S)
        && options.end.is_none_or(|t| late_s(t) < EPOCH_TOLERANCE_S)
}

type States = Vec<Result<SatelliteState, Unusable>>;

/// An epoch, and the states of its satellites where they are known.
struct Received {
    epoch: Arc<Epoch>,
    states: Option<States>,
}

impl From<Epoch> for Received {
    fn from(epoch: Epoch) -> Self {
        Self {
            epoch: epoch.into(),
            states: None,
        }
    }
}

impl From<&RoverEpoch> for Received {
    fn from(of: &RoverEpoch) -> Self {
        let states = of.all_states.as_ref().unwrap_or(&of.states);
        Self {
            epoch: Arc::clone(&of.epoch),
            states: Some(states.clone()),
        }
    }
}

/// Satellite states and single-point positions of every rover epoch.
fn rover_epochs(
    context: &SingleContext<'_>,
    epochs: Vec<Received>,
    options: &PpkOptions,
    watch: &Watch<'_>,
) -> Result<Vec<RoverEpoch>, PpkError> {
    // Every epoch starts from the first position found, so that no epoch depends on its neighbours.
    let start = epochs
        .iter()
        .find_map(|Received { epoch: e, .. }| {
            let states = context.states(e, e.tag, false);
            context
                .solve(e, &states, [0.0; 3])
                .ok()
                .map(|s| s.position_ecef_m)
        })
        .unwrap_or([0.0; 3]);
    let one = |Received { epoch, states }: Received| {
        watch.one_more()?;
        let mut states = states.unwrap_or_else(|| context.states(&epoch, epoch.tag, true));
        let single = context.solve(&epoch, &states, start);
        let mut all_states = None;
        if let (Ok(single), true) = (&single, options.policy().refuses_implausible()) {
            let all = states.clone();
            let place_ecef_m = single.position_ecef_m;
            if reject_implausible(context.constellation, &epoch, &mut states, place_ecef_m) {
                all_states = Some(all);
            }
        }
        Ok(RoverEpoch {
            epoch,
            states,
            all_states,
            single,
            zero: OnceLock::new(),
            unflagged_slips: Default::default(),
        })
    };
    let threads = threads(options).max(1);
    if threads == 1 || epochs.len() < 2 * threads {
        return epochs.into_iter().map(one).collect();
    }
    let share = epochs.len().div_ceil(threads);
    let mut parts: Vec<Vec<Received>> = Vec::with_capacity(threads);
    let mut rest = epochs;
    while rest.len() > share {
        let tail = rest.split_off(share);
        parts.push(std::mem::replace(&mut rest, tail));
    }
    parts.push(rest);
    std::thread::scope(|scope| {
        let workers: Vec<_> = parts
            .into_iter()
            .map(|part| scope.spawn(move || part.into_iter().map(one).collect()))
            .collect();
        let parts: Result<Vec<Vec<_>>, _> = workers.into_iter().map(join).collect();
        Ok(parts?.into_iter().flatten().collect())
    })
}
