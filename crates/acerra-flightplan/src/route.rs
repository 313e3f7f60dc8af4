//! The path of one flight, as input of every mission format.

use acerra_geo::geodesy::Geodetic;

use super::{Flight, FlightPlan, PlanError};

/// A waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Metres east and north of home.
    pub place_m: [f64; 2],
    /// Height above home (m).
    pub above_home_m: f64,
    /// Speed of the leg that ends here (m/s).
    pub speed_m_s: f64,
    /// Whether a line goes on here: the drone passes without a stop.
    pub is_passed: bool,
}

/// Waypoints of a flight, in order: from home, after take-off to the height of the lines, to home.
///
/// On level ground the waypoints are the corners of the lines. Over a terrain, further waypoints keep the
/// height above the ground on the lines, between them and on the way back, to within `[drone] stray_m`.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// Height of the drone above home after take-off (m).
    pub take_off_m: f64,
    /// The waypoints.
    pub stops: Vec<Stop>,
}

impl Route {
    /// The way of a flight.
    ///
    /// # Errors
    /// A place where the terrain has no height.
    pub fn of(plan: &FlightPlan, flight: &Flight) -> Result<Self, PlanError> {
        let transit_m_s = plan.file.drone.max_speed_m_s;
        let mut route = Self {
            take_off_m: plan.summary.height_m,
            stops: Vec::new(),
        };
        let mut at_m = [0.0; 2];
        for line in &plan.lines.lines[flight.first_line..=flight.last_line] {
            for (i, place_m) in line.waypoints_m.iter().enumerate() {
                let is_on_line = i > 0;
                let speed_m_s = if is_on_line {
                    plan.summary.speed_m_s
                } else {
                    transit_m_s
                };
                let is_passed = is_on_line && i + 1 < line.waypoints_m.len();
                route.go(plan, at_m, *place_m, speed_m_s, is_on_line, is_passed)?;
                at_m = *place_m;
            }
        }
        if plan.ground.is_some() {
            route.go(plan, at_m, [0.0; 2], transit_m_s, false, false)?;
        }
        Ok(route)
    }

    fn go(
        &mut self,
        plan: &FlightPlan,
        from_m: [f64; 2],
        to_m: [f64; 2],
        speed_m_s: f64,
        is_on_line: bool,
        is_passed: bool,
    ) -> Result<(), PlanError> {
        let between = match &plan.ground {
            Some(ground) => ground.between(from_m, to_m)?,
            None => Vec::new(),
        };
        let inner = between.into_iter().map(|place_m| (place_m, is_on_line));
        for (place_m, is_passed) in inner.chain([(to_m, is_passed)]) {
            let ground_m = match &plan.ground {
                Some(ground) => ground.height_m(place_m)?,
                None => 0.0,
            };
            self.stops.push(Stop {
                place_m,
                above_home_m: plan.summary.height_m + ground_m,
                speed_m_s,
                is_passed,
            });
        }
        Ok(())
    }

    /// Greatest distance from home (m).
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        let distance = |stop: &Stop| stop.place_m[0].hypot(stop.place_m[1]);
        self.stops.iter().map(distance).fold(0.0, f64::max)
    }
}

/// A waypoint on the Earth, its height above home.
pub(super) fn place(plan: &FlightPlan, stop: &Stop) -> Geodetic {
    plan.place(stop.place_m, stop.above_home_m)
}

/// Where the drone starts and lands: latitude and longitude (degrees).
pub(super) fn home_deg(plan: &FlightPlan) -> [f64; 2] {
    let area = &plan.file.area;
    area.home_deg.unwrap_or(area.corners_deg[0])
}
