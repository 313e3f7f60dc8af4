//! Single-point positions say where differences are formed, not where the rover is.

use crate::synthetic::{BASE_ECEF_M, L1, Receiver, flight, navigation, observe};
use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{
    AmbiguityMode, BasePosition, ObservationData, PpkOptions, System, SystemSet, process,
};

const EPOCHS: usize = 200;

/// East, north, up (m) of the positions from a base told to be where it is, or `off_up_m` above.
fn vectors(
    rover: &ObservationData,
    base: &ObservationData,
    off_up_m: f64,
    options: &PpkOptions,
) -> Vec<[f64; 3]> {
    let told = EnuFrame::from_ecef(BASE_ECEF_M).ecef_from_enu([0.0, 0.0, off_up_m]);
    let options = options
        .clone()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(told));
    let solution = process(rover, base, &navigation(), &options).unwrap();
    let frame = EnuFrame::from_ecef(told);
    let positions = solution.epochs.iter();
    positions
        .map(|e| frame.enu_from_ecef(e.position_ecef_m))
        .collect()
}

/// A base position that is off by more than the single-point positions are, or an ionosphere that
/// is not the model's: the rover's single-point positions then contradict the base's place by
/// metres at every epoch alike. The vector between the receivers must not know.
#[test]
fn the_vector_does_not_depend_on_single_point_heights() {
    let navigation = navigation();
    let log = |seed, position: &dyn Fn(f64) -> [f64; 3], clock_s: &dyn Fn(f64) -> f64| {
        observe(
            &navigation,
            &Receiver {
                seed,
                epochs: EPOCHS,
                interval_s: 1.0,
                position,
                clock_s,
                noise_m: [0.003, 0.3],
                signals: &L1,
            },
        )
    };
    let base = log(1, &|_| BASE_ECEF_M, &|t| -2.1e-4 + 3e-8 * t);
    let rover = log(2, &flight, &|t| 8.3e-4 + 2e-7 * t);
    let largest_m = |options: &PpkOptions| {
        let exact = vectors(&rover, &base, 0.0, options);
        let off = vectors(&rover, &base, 15.0, options);
        assert_eq!((exact.len(), off.len()), (EPOCHS, EPOCHS));
        let apart = exact.iter().zip(&off);
        apart
            .flat_map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).abs()))
            .fold(0.0, f64::max)
    };
    let fixed = PpkOptions::default();
    let float = fixed.clone().with_ambiguity(AmbiguityMode::Off);
    for options in [&fixed, &float] {
        let off_m = largest_m(options);
        assert!(off_m < 2e-3, "{:?}: {off_m} m", options.ambiguity);
    }
    // RTKLIB keeps the troposphere of the single-point height.
    let off_m = largest_m(&fixed.with_troposphere_follows_height(false));
    assert!((0.01..0.06).contains(&off_m), "{off_m} m");
}
