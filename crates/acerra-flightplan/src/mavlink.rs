//! Mission items of MAVLink, as QGroundControl's and Mission Planner's files hold them.

use super::route::{Route, place};
use super::{Flight, FlightPlan, PlanError};

/// `MAV_CMD_NAV_WAYPOINT`.
pub(super) const WAYPOINT: u16 = 16;
/// `MAV_CMD_NAV_RETURN_TO_LAUNCH`.
pub(super) const RETURN: u16 = 20;
/// `MAV_CMD_NAV_TAKEOFF`.
pub(super) const TAKE_OFF: u16 = 22;
/// `MAV_CMD_DO_CHANGE_SPEED`.
pub(super) const CHANGE_SPEED: u16 = 178;

/// A mission item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Item {
    /// Number of `MAV_CMD`.
    pub command: u16,
    /// Parameters 1 to 4; none: left to the autopilot.
    pub parameters: [Option<f64>; 4],
    /// Latitude, longitude (degrees) and height above home (m); none for an item without a place.
    pub place_deg_m: Option<[f64; 3]>,
}

/// Rounded to a number of decimals.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale
}

/// Items of a flight: take-off to the height of the lines, each line at its speed, transfers at the drone's
/// own, then back to launch.
pub(super) fn items(plan: &FlightPlan, route: &Route) -> Vec<Item> {
    let acceptance_m = plan.summary.waypoint_acceptance_m;
    let mut items = Vec::new();
    let go = |command: u16, at: acerra_geo::geodesy::Geodetic| {
        // The second parameter of a waypoint is its acceptance radius, the fourth the yaw.
        let acceptance_m = if command == WAYPOINT {
            acceptance_m
        } else {
            0.0
        };
        Item {
            command,
            parameters: [Some(0.0), Some(rounded(acceptance_m, 3)), Some(0.0), None],
            place_deg_m: Some([
                rounded(at.latitude_deg(), 9),
                rounded(at.longitude_deg(), 9),
                rounded(at.height_m, 3),
            ]),
        }
    };
    // Ground speed from here on; throttle unchanged.
    let speed = |speed_m_s: f64| Item {
        command: CHANGE_SPEED,
        parameters: [1.0, rounded(speed_m_s, 3), -1.0, 0.0].map(Some),
        place_deg_m: None,
    };
    items.push(go(TAKE_OFF, plan.place([0.0; 2], route.take_off_m)));
    let mut current_m_s = None;
    for stop in &route.stops {
        if current_m_s != Some(stop.speed_m_s) {
            items.push(speed(stop.speed_m_s));
            current_m_s = Some(stop.speed_m_s);
        }
        items.push(go(WAYPOINT, place(plan, stop)));
    }
    items.push(speed(plan.file.drone.max_speed_m_s));
    items.push(Item {
        command: RETURN,
        parameters: [0.0; 4].map(Some),
        place_deg_m: None,
    });
    items
}

/// The mission of one flight as `.waypoints` (`QGC WPL 110`), for Mission Planner, QGroundControl, MAVProxy
/// and ArduPilot's tools.
///
/// The first item is home, with its height above the sea; the heights of all others count from home.
///
/// # Errors
/// A place where the terrain has no height.
pub fn to_waypoints(plan: &FlightPlan, flight: &Flight) -> Result<String, PlanError> {
    use std::fmt::Write as _;

    let route = Route::of(plan, flight)?;
    let [latitude, longitude] = super::route::home_deg(plan);
    let home_m = plan.home_above_sea_m();
    let mut text = format!(
        "QGC WPL 110\n0\t1\t0\t{WAYPOINT}\t0\t0\t0\t0\t{latitude:.9}\t{longitude:.9}\t{home_m:.3}\t1\n"
    );
    for (i, item) in items(plan, &route).iter().enumerate() {
        let [p1, p2, p3, p4] = item.parameters.map(|p| p.unwrap_or(0.0));
        let [x, y, z] = item.place_deg_m.unwrap_or_default();
        let _ = writeln!(
            text,
            "{}\t0\t3\t{}\t{p1}\t{p2}\t{p3}\t{p4}\t{x:.9}\t{y:.9}\t{z:.3}\t1",
            i + 1,
            item.command
        );
    }
    Ok(text)
}
