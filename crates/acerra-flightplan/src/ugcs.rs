//! The waypoints of a flight as CSV for UgCS (Import route from CSV).

use std::fmt::Write as _;

use super::route::{Route, place};
use super::{Flight, FlightPlan, PlanError};

/// The waypoints of one flight, a row each.
///
/// The columns have UgCS's names. On level ground the heights are above UgCS's terrain (`AltitudeAGL`); over
/// the plan's terrain they are above the sea (`AltitudeAMSL`). Transfers to a line have the line's speed:
/// whether UgCS takes a speed for the leg to a waypoint or for the leg after it, lines are flown as planned.
///
/// # Errors
/// A place where the terrain has no height.
pub fn to_ugcs(plan: &FlightPlan, flight: &Flight) -> Result<String, PlanError> {
    let route = Route::of(plan, flight)?;
    let (column, add_m) = match &plan.ground {
        Some(ground) => ("AltitudeAMSL", ground.home_m()),
        None => ("AltitudeAGL", 0.0),
    };
    let mut text = format!("WP,Latitude,Longitude,{column},Speed\n");
    for (i, stop) in route.stops.iter().enumerate() {
        let at = place(plan, stop);
        let _ = writeln!(
            text,
            "{},{:.9},{:.9},{:.3},{:.3}",
            i + 1,
            at.latitude_deg(),
            at.longitude_deg(),
            at.height_m + add_m,
            plan.summary.speed_m_s
        );
    }
    Ok(text)
}
