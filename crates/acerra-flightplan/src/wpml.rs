//! The mission of a flight for DJI Pilot 2 and FlightHub 2: WPML 1.0.2 in a KMZ file.
//!
//! Format: DJI Cloud API, "Waypoint Markup Language": `wpmz/template.kml` is for editing,
//! `wpmz/waylines.wpml` for the aircraft.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::route::{Route, place};
use super::{DjiModel, Flight, FlightPlan, PlanError};

/// Greatest speed of a wayline (m/s).
const MOST_SPEED_M_S: f64 = 15.0;
/// Most waypoints of a wayline.
const MOST_WAYPOINTS: usize = 65_535;
/// Range of the height that the aircraft climbs to before its transfer to the first waypoint (m).
const TAKE_OFF_M: [f64; 2] = [1.2, 1500.0];

/// Number of a model in DJI's list of aircraft.
fn number(model: DjiModel) -> u32 {
    match model {
        DjiModel::M300Rtk => 60,
        DjiModel::M30 => 67,
        DjiModel::Mavic3E => 77,
        DjiModel::M350Rtk => 89,
    }
}

/// The mission of one flight as the bytes of a KMZ file.
///
/// Heights are relative to the place of take-off. Corners within a line are passed on the inside
/// within the waypoints' acceptance radius; the aircraft stops at the ends of lines. After the last
/// waypoint it goes home.
///
/// # Errors
/// A place where the terrain has no height; speeds and numbers of waypoints beyond the format's.
pub fn to_wpml(plan: &FlightPlan, flight: &Flight) -> Result<Vec<u8>, PlanError> {
    let route = Route::of(plan, flight)?;
    if plan.summary.speed_m_s > MOST_SPEED_M_S || route.stops.len() > MOST_WAYPOINTS {
        return Err(PlanError::Write(format!(
            "WPML: expected at most {MOST_SPEED_M_S} m/s and {MOST_WAYPOINTS} waypoints, found {} m/s \
             and {}",
            plan.summary.speed_m_s,
            route.stops.len()
        )));
    }
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
    let failed = |error: String| PlanError::Write(format!("WPML: {error}"));
    for (name, text) in [
        ("wpmz/template.kml", template(plan, &route)),
        ("wpmz/waylines.wpml", waylines(plan, flight, &route)),
    ] {
        zip.start_file(name, options)
            .map_err(|e| failed(e.to_string()))?;
        zip.write_all(text.as_bytes())
            .map_err(|e| failed(e.to_string()))?;
    }
    let cursor = zip.finish().map_err(|e| failed(e.to_string()))?;
    Ok(cursor.into_inner())
}

/// A document with its mission's configuration and one folder.
fn document(plan: &FlightPlan, route: &Route, folder: &str) -> String {
    let transit_m_s = plan.file.drone.max_speed_m_s.clamp(1.0, MOST_SPEED_M_S);
    let [least_m, most_m] = TAKE_OFF_M;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:wpml=\"http://www.dji.com/wpmz/1.0.2\">\n\
         <Document>\n\
         <wpml:missionConfig>\n\
         <wpml:flyToWaylineMode>safely</wpml:flyToWaylineMode>\n\
         <wpml:finishAction>goHome</wpml:finishAction>\n\
         <wpml:exitOnRCLost>executeLostAction</wpml:exitOnRCLost>\n\
         <wpml:executeRCLostAction>goBack</wpml:executeRCLostAction>\n\
         <wpml:takeOffSecurityHeight>{:.1}</wpml:takeOffSecurityHeight>\n\
         <wpml:globalTransitionalSpeed>{transit_m_s:.2}</wpml:globalTransitionalSpeed>\n\
         <wpml:droneInfo>\n\
         <wpml:droneEnumValue>{}</wpml:droneEnumValue>\n\
         <wpml:droneSubEnumValue>0</wpml:droneSubEnumValue>\n\
         </wpml:droneInfo>\n\
         </wpml:missionConfig>\n\
         <Folder>\n{folder}</Folder>\n</Document>\n</kml>\n",
        route.take_off_m.clamp(least_m, most_m),
        number(plan.file.drone.dji_model),
    )
}

/// The file that a person edits.
fn template(plan: &FlightPlan, route: &Route) -> String {
    let mut folder = format!(
        "<wpml:templateType>waypoint</wpml:templateType>\n\
         <wpml:templateId>0</wpml:templateId>\n\
         <wpml:waylineCoordinateSysParam>\n\
         <wpml:coordinateMode>WGS84</wpml:coordinateMode>\n\
         <wpml:heightMode>relativeToStartPoint</wpml:heightMode>\n\
         </wpml:waylineCoordinateSysParam>\n\
         <wpml:autoFlightSpeed>{:.3}</wpml:autoFlightSpeed>\n\
         <wpml:globalHeight>{:.3}</wpml:globalHeight>\n\
         <wpml:gimbalPitchMode>manual</wpml:gimbalPitchMode>\n\
         <wpml:globalWaypointHeadingParam>\n{HEADING}</wpml:globalWaypointHeadingParam>\n\
         <wpml:globalWaypointTurnMode>{STOP}</wpml:globalWaypointTurnMode>\n\
         <wpml:globalUseStraightLine>1</wpml:globalUseStraightLine>\n",
        plan.summary.speed_m_s, plan.summary.height_m,
    );
    for waypoint in waypoints(plan, route) {
        let _ = write!(
            folder,
            "<Placemark>\n{}\
             <wpml:ellipsoidHeight>{:.3}</wpml:ellipsoidHeight>\n\
             <wpml:height>{:.3}</wpml:height>\n\
             <wpml:useGlobalHeight>0</wpml:useGlobalHeight>\n\
             <wpml:useGlobalSpeed>0</wpml:useGlobalSpeed>\n\
             <wpml:useGlobalHeadingParam>1</wpml:useGlobalHeadingParam>\n\
             <wpml:useGlobalTurnParam>0</wpml:useGlobalTurnParam>\n{}</Placemark>\n",
            waypoint.head, waypoint.height_m, waypoint.height_m, waypoint.motion
        );
    }
    document(plan, route, &folder)
}

/// The file that the aircraft flies.
fn waylines(plan: &FlightPlan, flight: &Flight, route: &Route) -> String {
    let mut folder = format!(
        "<wpml:templateId>0</wpml:templateId>\n\
         <wpml:executeHeightMode>relativeToStartPoint</wpml:executeHeightMode>\n\
         <wpml:waylineId>0</wpml:waylineId>\n\
         <wpml:distance>{:.1}</wpml:distance>\n\
         <wpml:duration>{:.1}</wpml:duration>\n\
         <wpml:autoFlightSpeed>{:.3}</wpml:autoFlightSpeed>\n",
        flight.distance_m, flight.time_s, plan.summary.speed_m_s,
    );
    for waypoint in waypoints(plan, route) {
        let _ = write!(
            folder,
            "<Placemark>\n{}\
             <wpml:executeHeight>{:.3}</wpml:executeHeight>\n\
             <wpml:waypointHeadingParam>\n{HEADING}</wpml:waypointHeadingParam>\n{}</Placemark>\n",
            waypoint.head, waypoint.height_m, waypoint.motion
        );
    }
    document(plan, route, &folder)
}

/// The nose along the way.
const HEADING: &str = "<wpml:waypointHeadingMode>followWayline</wpml:waypointHeadingMode>\n\
                       <wpml:waypointHeadingAngle>0</wpml:waypointHeadingAngle>\n\
                       <wpml:waypointHeadingPathMode>followBadArc</wpml:waypointHeadingPathMode>\n";
/// Straight legs, a stop at the waypoint.
const STOP: &str = "toPointAndStopWithDiscontinuityCurvature";
/// Straight legs, the corner rounded without a stop.
const PASS: &str = "coordinateTurn";

/// The elements of a waypoint that both files hold.
struct Waypoint {
    head: String,
    height_m: f64,
    motion: String,
}

fn waypoints<'a>(
    plan: &'a FlightPlan,
    route: &'a Route,
) -> impl Iterator<Item = Waypoint> + use<'a> {
    route.stops.iter().enumerate().map(move |(i, stop)| {
        let at = place(plan, stop);
        // A waypoint's speed applies to the leg after it.
        let next = route.stops.get(i + 1).unwrap_or(stop);
        // A wayline begins and ends with a stop.
        let is_end = i == 0 || i + 1 == route.stops.len();
        let (turn, damping_m) = if stop.is_passed && !is_end {
            (PASS, plan.summary.waypoint_acceptance_m)
        } else {
            (STOP, 0.0)
        };
        Waypoint {
            head: format!(
                "<Point><coordinates>{:.9},{:.9}</coordinates></Point>\n<wpml:index>{i}</wpml:index>\n",
                at.longitude_deg(),
                at.latitude_deg()
            ),
            height_m: at.height_m,
            motion: format!(
                "<wpml:waypointSpeed>{:.3}</wpml:waypointSpeed>\n\
                 <wpml:waypointTurnParam>\n\
                 <wpml:waypointTurnMode>{turn}</wpml:waypointTurnMode>\n\
                 <wpml:waypointTurnDampingDist>{damping_m:.3}</wpml:waypointTurnDampingDist>\n\
                 </wpml:waypointTurnParam>\n\
                 <wpml:useStraightLine>1</wpml:useStraightLine>\n",
                next.speed_m_s.min(MOST_SPEED_M_S)
            ),
        }
    })
}
