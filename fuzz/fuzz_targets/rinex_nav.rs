//! Any bytes as RINEX navigation data: an answer or an error, and numbers that can be orbits.
#![no_main]

use acerra_gnss::input::Limits;
use acerra_gnss::{Ephemeris, read_navigation};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok((navigation, _)) = read_navigation(bytes, Limits::default()) else { return };
    for ephemeris in &navigation.ephemerides {
        assert!(ephemeris.accuracy_m() > 0.0 || ephemeris.satellite().system().letter() == 'E');
        match ephemeris {
            Ephemeris::Kepler(e) => {
                assert!((0.0..1.0).contains(&e.eccentricity));
                assert!(e.sqrt_semi_major_axis >= 1000.0);
                assert!((e.toe - e.toc).abs() <= 302_400.0);
            }
            Ephemeris::Glonass(e) => assert!(e.position_ecef_m.iter().all(|x| x.is_finite())),
            Ephemeris::Sbas(e) => assert!(e.position_ecef_m.iter().all(|x| x.is_finite())),
        }
    }
});
