//! Time and batteries.

use super::{Drone, Line, PlanError};

/// One flight on one battery.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Flight {
    /// First line, from 0.
    pub first_line: usize,
    /// Last line.
    pub last_line: usize,
    /// Path length without climb and descent (m).
    pub distance_m: f64,
    /// From start to landing (s).
    pub time_s: f64,
    /// Share of the battery, the reserve not counted.
    pub battery: f64,
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Path length (m) and time (s) of flying lines in order from home (east 0, north 0) and back.
fn cost(drone: &Drone, lines: &[Line], height_m: f64, speed_m_s: f64) -> (f64, f64) {
    let ends = |line: &Line| {
        let first = line.waypoints_m.first().copied().unwrap_or_default();
        (first, line.waypoints_m.last().copied().unwrap_or_default())
    };
    let mut at = [0.0; 2];
    let (mut way_m, mut time_s) = (0.0, 2.0 * height_m / drone.climb_m_s);
    for line in lines {
        let (first, last) = ends(line);
        let between_m = distance(at, first);
        let along_m = line.length_m();
        way_m += between_m + along_m;
        time_s += between_m / drone.max_speed_m_s + drone.turn_s + along_m / speed_m_s;
        at = last;
    }
    let home_m = distance(at, [0.0; 2]);
    (way_m + home_m, time_s + home_m / drone.max_speed_m_s)
}

/// As many lines to a flight as a battery takes.
pub(super) fn divide(
    drone: &Drone,
    lines: &[Line],
    height_m: f64,
    speed_m_s: f64,
) -> Result<Vec<Flight>, PlanError> {
    let usable_s = 60.0 * drone.endurance_min * (1.0 - drone.reserve);
    let flight = |first: usize, last: usize| {
        let (distance_m, time_s) = cost(drone, &lines[first..=last], height_m, speed_m_s);
        let battery = time_s / (60.0 * drone.endurance_min);
        Flight {
            first_line: first,
            last_line: last,
            distance_m,
            time_s,
            battery,
        }
    };
    let mut flights: Vec<Flight> = Vec::new();
    for i in 0..lines.len() {
        let longer = flights.last().map(|f| flight(f.first_line, i));
        match (longer, flights.last_mut()) {
            (Some(longer), Some(last)) if longer.time_s <= usable_s => *last = longer,
            _ => {
                let alone = flight(i, i);
                if alone.time_s > usable_s {
                    return Err(PlanError::Impossible(format!(
                        "line {} alone takes {:.1} minutes at {speed_m_s:.2} m/s, a battery gives \
                         {:.1} of {} minutes: divide the area, or allow a higher speed by more \
                         scans a second",
                        i + 1,
                        alone.time_s / 60.0,
                        usable_s / 60.0,
                        drone.endurance_min
                    )));
                }
                flights.push(alone);
            }
        }
    }
    Ok(flights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(north_m: f64) -> Line {
        Line {
            offset_m: north_m,
            start_m: 0.0,
            end_m: 60.0,
            waypoints_m: vec![[0.0, north_m], [60.0, north_m]],
        }
    }

    #[test]
    fn times_add_up_by_hand() {
        let drone = Drone::default();
        let (way_m, time_s) = cost(&drone, &[line(0.0)], 10.0, 0.5);
        // Up and down 20 s, no way to the line, a turn of 4 s, 120 s along it, 12 s home.
        assert!((way_m - 120.0).abs() < 1e-9 && (time_s - 156.0).abs() < 1e-9);
    }

    #[test]
    fn batteries_are_filled_and_not_overdrawn() {
        let drone = Drone::default();
        let lines: Vec<Line> = (0..20).map(|i| line(f64::from(i))).collect();
        let flights = divide(&drone, &lines, 10.0, 0.5).expect("possible");
        assert!(flights.len() > 1);
        let usable = 1.0 - drone.reserve;
        for (i, flight) in flights.iter().enumerate() {
            assert!(flight.battery <= usable + 1e-12);
            if let Some(next) = flights.get(i + 1) {
                assert_eq!(next.first_line, flight.last_line + 1);
                let more = cost(
                    &drone,
                    &lines[flight.first_line..=next.first_line],
                    10.0,
                    0.5,
                );
                assert!(more.1 / (60.0 * drone.endurance_min) > usable);
            }
        }
        assert_eq!(
            (flights[0].first_line, flights[flights.len() - 1].last_line),
            (0, 19)
        );
        let error = divide(&drone, &lines, 10.0, 0.05)
            .expect_err("too slow")
            .to_string();
        assert!(error.starts_with("line 1 alone takes"), "{error}");
    }
}
