//! The plan as QGroundControl's `.plan` file.
//!
//! Format: QGroundControl Developer Guide, "Plan File Format": plan version 1, mission version 2,
//! geofence and rally points version 2; mission items are MAVLink mission items with the numbers of
//! `MAV_CMD` and `MAV_FRAME`.

use serde_json::{Value, json};

use super::mavlink::items;
use super::route::{Route, home_deg};
use super::{Flight, FlightPlan, PlanError};

/// `MAV_FRAME_MISSION`: an item without a place.
const FRAME_MISSION: u8 = 2;
/// `MAV_FRAME_GLOBAL_RELATIVE_ALT`: height above home.
const FRAME_ABOVE_HOME: u8 = 3;
/// `MAV_AUTOPILOT_PX4`.
const PX4: u8 = 12;
/// `MAV_TYPE_QUADROTOR`.
const QUADROTOR: u8 = 2;
/// QGroundControl's altitude mode "relative to launch".
const RELATIVE_ALTITUDE: u8 = 1;

/// The mission of one flight.
///
/// Take-off to the height of the lines, each line at its speed, transfers at the drone's own, then back to
/// launch. The geofence is a circle about home with a margin of 30 m.
///
/// # Errors
/// A place where the terrain has no height.
pub fn to_qgroundcontrol(plan: &FlightPlan, flight: &Flight) -> Result<Value, PlanError> {
    let route = Route::of(plan, flight)?;
    let [home_lat, home_lon] = home_deg(plan);
    let list: Vec<Value> = items(plan, &route)
        .iter()
        .enumerate()
        .map(|(i, item)| {
            let frame = match item.place_deg_m {
                Some(_) => FRAME_ABOVE_HOME,
                None => FRAME_MISSION,
            };
            let place = item.place_deg_m.unwrap_or_default().map(Some);
            let params: Vec<Option<f64>> = item.parameters.into_iter().chain(place).collect();
            let mut object = json!({
                "type": "SimpleItem",
                "autoContinue": true,
                "command": item.command,
                "doJumpId": i + 1,
                "frame": frame,
                "params": params,
            });
            if let (Some([_, _, height_m]), Some(fields)) =
                (item.place_deg_m, object.as_object_mut())
            {
                fields.insert("AMSLAltAboveTerrain".to_owned(), Value::Null);
                fields.insert("Altitude".to_owned(), json!(height_m));
                fields.insert("AltitudeMode".to_owned(), json!(RELATIVE_ALTITUDE));
            }
            object
        })
        .collect();
    Ok(json!({
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": PX4,
            "vehicleType": QUADROTOR,
            "globalPlanAltitudeMode": RELATIVE_ALTITUDE,
            "cruiseSpeed": plan.file.drone.max_speed_m_s,
            "hoverSpeed": plan.summary.speed_m_s,
            "plannedHomePosition": [home_lat, home_lon, plan.home_above_sea_m()],
            "items": list,
        },
        "geoFence": {
            "version": 2,
            "circles": [{
                "version": 1,
                "inclusion": true,
                "circle": {
                    "center": [home_lat, home_lon],
                    "radius": (route.reach_m() + 30.0).ceil(),
                },
            }],
            "polygons": [],
        },
        "rallyPoints": { "version": 2, "points": [] },
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlanFile;

    /// Requirements of QGroundControl on a field for loading the file.
    #[derive(Clone, Copy, Debug)]
    enum Kind {
        Number,
        Whole,
        Bool,
        Text,
        List,
        Object,
        NullOrNumber,
    }

    fn check(object: &Value, fields: &[(&str, Kind)]) {
        let object = object.as_object().expect("an object");
        for (name, kind) in fields {
            let value = object
                .get(*name)
                .unwrap_or_else(|| panic!("no field {name}"));
            let good = match kind {
                Kind::Number => value.is_number(),
                Kind::Whole => value.is_u64(),
                Kind::Bool => value.is_boolean(),
                Kind::Text => value.is_string(),
                Kind::List => value.is_array(),
                Kind::Object => value.is_object(),
                Kind::NullOrNumber => value.is_null() || value.is_number(),
            };
            assert!(good, "{name} is {value}, expected {kind:?}");
        }
        let known: Vec<&str> = fields.iter().map(|f| f.0).collect();
        assert!(
            object.keys().all(|k| known.contains(&k.as_str())),
            "{:?}",
            object.keys()
        );
    }

    #[test]
    fn every_field_and_type_is_the_format_s() {
        use Kind::{Bool, List, NullOrNumber, Number, Object, Text, Whole};
        let text = "[area]\ncorners_deg = [[40.9, 14.2], [40.9002, 14.2], [40.9002, 14.2003], \
                    [40.9, 14.2003]]\nhome_height_m = 30\n\
                    [want]\nalong_m = 0.06\nacross_m = 0.5\nrcs_dbsm = 10\n";
        let plan = FlightPlan::make(PlanFile::parse(text).expect("a file")).expect("a plan");
        let text = to_qgroundcontrol(&plan, &plan.flights[0])
            .expect("a mission")
            .to_string();
        let file: Value = serde_json::from_str(&text).expect("JSON");

        check(
            &file,
            &[
                ("fileType", Text),
                ("version", Whole),
                ("groundStation", Text),
                ("mission", Object),
                ("geoFence", Object),
                ("rallyPoints", Object),
            ],
        );
        assert_eq!(
            (&file["fileType"], &file["version"]),
            (&json!("Plan"), &json!(1))
        );
        let mission = &file["mission"];
        check(
            mission,
            &[
                ("version", Whole),
                ("firmwareType", Whole),
                ("vehicleType", Whole),
                ("globalPlanAltitudeMode", Whole),
                ("cruiseSpeed", Number),
                ("hoverSpeed", Number),
                ("plannedHomePosition", List),
                ("items", List),
            ],
        );
        assert_eq!(mission["version"], 2);
        assert_eq!(mission["plannedHomePosition"], json!([40.9, 14.2, 30.0]));
        check(
            &file["geoFence"],
            &[("version", Whole), ("circles", List), ("polygons", List)],
        );
        let fence = &file["geoFence"]["circles"][0];
        check(
            fence,
            &[("version", Whole), ("inclusion", Bool), ("circle", Object)],
        );
        check(&fence["circle"], &[("center", List), ("radius", Number)]);
        check(
            &file["rallyPoints"],
            &[("version", Whole), ("points", List)],
        );

        let items = mission["items"].as_array().expect("a list");
        let simple = [
            ("type", Text),
            ("autoContinue", Bool),
            ("command", Whole),
            ("doJumpId", Whole),
            ("frame", Whole),
            ("params", List),
        ];
        let placed: Vec<(&str, Kind)> = simple
            .into_iter()
            .chain([
                ("AMSLAltAboveTerrain", NullOrNumber),
                ("Altitude", Number),
                ("AltitudeMode", Whole),
            ])
            .collect();
        for (i, item) in items.iter().enumerate() {
            assert_eq!(item["type"], "SimpleItem");
            assert_eq!(item["doJumpId"], i + 1);
            let params = item["params"].as_array().expect("a list");
            assert_eq!(params.len(), 7);
            assert!(params.iter().all(|p| p.is_number() || p.is_null()));
            if item["frame"] == 3 {
                check(item, &placed);
                assert_eq!(params[6], item["Altitude"]);
                assert!((params[4].as_f64().expect("latitude") - 40.9).abs() < 0.01);
                assert!((params[5].as_f64().expect("longitude") - 14.2).abs() < 0.01);
            } else {
                check(item, &simple);
                assert_eq!(item["frame"], 2);
            }
        }
        let commands: Vec<u64> = items.iter().filter_map(|i| i["command"].as_u64()).collect();
        assert_eq!((commands[0], commands[commands.len() - 1]), (22, 20));
        let waypoints = commands.iter().filter(|c| **c == 16).count();
        let corners: usize = plan.lines.lines.iter().map(|l| l.waypoints_m.len()).sum();
        assert_eq!(waypoints, corners);
        for item in items.iter().filter(|item| item["command"] == 16) {
            let radius_m = item["params"][1].as_f64().expect("an acceptance radius");
            assert!(
                (radius_m - plan.file.drone.stray_m).abs() < 1e-9,
                "{radius_m}"
            );
        }
        // Each line is flown at its own speed: the speed change follows the line's first corner.
        let first = commands.iter().position(|c| *c == 16).expect("a waypoint");
        assert_eq!(commands[first + 1], 178);
        let speed = items[first + 1]["params"][1].as_f64().expect("a speed");
        assert!((speed - plan.summary.speed_m_s).abs() < 1e-3);
    }
}
