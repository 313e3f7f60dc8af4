//! Whether a radio's settings suit the flight that is planned.

use acerra_radar::two_way_delay_s;

use super::settings::{FlightSection, RadioSection};
use crate::driver::{SAMPLE_QUANTUM, window_samples};

/// Time that a P440 takes for 96 samples and one pulse (s): 21.573 ms for 1152 samples at PII 11, as
/// fast as possible, in the flight of 2019.
const QUANTUM_PULSE_S: f64 = 21.573e-3 / (12.0 * 2048.0);
/// Delay of range zero in the radio and its cables where it is unknown (ns).
const USUAL_DELAY_NS: [f64; 2] = [0.0, 30.0];
/// Highest frequency of the band (Hz).
const HIGHEST_HZ: f64 = 4.8e9;

/// Faults of settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Doubt {
    /// Whether the recording would be of no use.
    pub is_fatal: bool,
    /// What, and which key.
    pub text: String,
}

/// Shortest interval between scans that the radio can hold, estimated (s).
#[must_use]
pub fn shortest_interval_s(radio: &RadioSection) -> f64 {
    let quanta = window_samples(&radio.setup().config) / SAMPLE_QUANTUM;
    f64::from(quanta) * f64::from(1_u32 << radio.integration_index.min(15)) * QUANTUM_PULSE_S
}

/// Least and largest fast time at which range is zero (ns).
pub(super) fn delay_range_ns(flight: &FlightSection) -> [f64; 2] {
    flight.delay_ns.map_or(USUAL_DELAY_NS, |delay| [delay; 2])
}

/// Fast time of an echo from `range_m` (ns).
pub(super) fn echo_ns(range_m: f64, delay_ns: f64) -> f64 {
    delay_ns + 1e9 * two_way_delay_s(range_m)
}

/// Doubts about the settings for the planned flight; quantities that the plan does not state are not judged.
#[must_use]
pub fn doubts(radio: &RadioSection, flight: &FlightSection) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    let mut doubt = |is_fatal, text| doubts.push(Doubt { is_fatal, text });
    let window_ns = radio.window_ps.map(|ps| 1e-3 * f64::from(ps));
    let [least_ns, most_ns] = delay_range_ns(flight);
    if let Some(height_m) = flight.height_m {
        let [first, last] = [least_ns, most_ns].map(|delay| echo_ns(height_m, delay));
        if last < window_ns[0] || first > window_ns[1] {
            doubt(
                true,
                format!(
                    "[radio] window_ps: the ground {height_m} m below answers at {first:.1} to {last:.1} ns, and the \
                     window is {:.1} to {:.1} ns",
                    window_ns[0], window_ns[1]
                ),
            );
        } else if first < window_ns[0] || last > window_ns[1] {
            doubt(
                false,
                format!(
                    "[radio] window_ps: the ground {height_m} m below may answer outside the window, at {first:.1} \
                     to {last:.1} ns (state [flight] delay_ns to decide)"
                ),
            );
        }
    }
    if let Some(range_m) = flight.far_range_m {
        let last = echo_ns(range_m, most_ns);
        if last > window_ns[1] {
            doubt(
                false,
                format!(
                    "[radio] window_ps: a target at {range_m} m answers at up to {last:.1} ns, behind the window's \
                     end at {:.1} ns",
                    window_ns[1]
                ),
            );
        }
    }
    let shortest_s = shortest_interval_s(radio);
    let asked_s = 1e-3 * radio.scan_interval_ms;
    if asked_s > 0.0 && asked_s < shortest_s {
        doubt(
            false,
            format!(
                "[radio] scan_interval_ms: {} ms stated, and the window takes about {:.1} ms at integration \
                 index {}",
                radio.scan_interval_ms,
                1e3 * shortest_s,
                radio.integration_index
            ),
        );
    }
    if let Some(speed_m_s) = flight.speed_m_s {
        let step_m = speed_m_s * asked_s.max(shortest_s);
        let largest_m = acerra_radar::SPEED_OF_LIGHT_M_S / HIGHEST_HZ / 4.0;
        if step_m > largest_m {
            doubt(
                false,
                format!(
                    "[radio] integration_index, scan_interval_ms: {:.1} mm between scans at {speed_m_s} m/s; more \
                     than {:.1} mm, a quarter of the shortest wavelength, images echoes from the side twice",
                    1e3 * step_m,
                    1e3 * largest_m
                ),
            );
        }
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The settings of the flight of 2019, flown at 2 m.
    fn flown() -> (RadioSection, FlightSection) {
        let radio = RadioSection {
            window_ps: [16_670, 86_982],
            ..RadioSection::default()
        };
        let flight = FlightSection {
            height_m: Some(2.0),
            speed_m_s: Some(0.5),
            delay_ns: Some(10.0),
            ..FlightSection::default()
        };
        (radio, flight)
    }

    #[test]
    fn a_flight_that_was_flown_is_not_doubted() {
        let (radio, flight) = flown();
        assert_eq!(doubts(&radio, &flight), []);
        assert!((shortest_interval_s(&radio) - 21.573e-3).abs() < 1e-9);
    }

    #[test]
    fn each_contradiction_is_named_by_its_key() {
        let (radio, flight) = flown();
        let high = FlightSection {
            height_m: Some(100.0),
            ..flight.clone()
        };
        let found = doubts(&radio, &high);
        assert!(
            found[0].is_fatal && found[0].text.contains("answers at 677.1"),
            "{found:?}"
        );
        let far = FlightSection {
            far_range_m: Some(30.0),
            ..flight.clone()
        };
        assert!(
            doubts(&radio, &far)[0]
                .text
                .contains("behind the window's end")
        );
        let fast = FlightSection {
            speed_m_s: Some(5.0),
            ..flight.clone()
        };
        assert!(
            doubts(&radio, &fast)[0]
                .text
                .contains("107.9 mm between scans")
        );
        let hasty = RadioSection {
            scan_interval_ms: 10.0,
            ..radio
        };
        assert!(doubts(&hasty, &flight)[0].text.contains("about 21.6 ms"));
    }
}
