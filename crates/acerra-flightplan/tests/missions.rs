//! Missions of every format: their structure, and the same waypoints in all of them.
#![allow(clippy::expect_used, clippy::unwrap_used)]

use std::io::Read as _;
use std::path::Path;

use acerra_flightplan::{
    FlightPlan, PlanFile, Route, to_qgroundcontrol, to_ugcs, to_waypoints, to_wpml,
};
use roxmltree::{Document, Node};

const AREA: &str = "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2005], [40.9002, 14.2005], \
                    [40.9002, 14.2]]\nhome_height_m = 30\n";
const WANT: &str = "[want]\nalong_m = 0.06\nacross_m = 0.5\nrcs_dbsm = 10\n";

fn plan(area: &str, folder: &Path) -> FlightPlan {
    let text = format!("{AREA}{area}{WANT}");
    let file = PlanFile::parse(&text).expect("a file").resolved_in(folder);
    FlightPlan::make(file).expect("a plan")
}

fn level() -> FlightPlan {
    plan("", Path::new(""))
}

/// Height of the raster (m): a slope with a wave of 6 m over 30 m.
fn height_m(latitude_deg: f64, longitude_deg: f64) -> f64 {
    let (north, east) = (latitude_deg - 40.9, longitude_deg - 14.2);
    120.0 + 2e4 * east + 3.0 * (north * 2.3e4).sin() + 3.0 * (east * 1.7e4).sin()
}

/// A grid of 1e-5°, about a metre, over the area and some 30 m around it.
fn raster(folder: &Path) {
    let (columns, rows, cell, west, south) = (140, 100, 1e-5, 14.1995, 40.8995);
    let mut text = format!(
        "ncols {columns}\nnrows {rows}\nxllcorner {west}\nyllcorner {south}\ncellsize {cell}\n"
    );
    for row in (0..rows).rev() {
        for column in 0..columns {
            let latitude = south + (f64::from(row) + 0.5) * cell;
            let longitude = west + (f64::from(column) + 0.5) * cell;
            text += &format!("{:.4} ", height_m(latitude, longitude));
        }
        text.push('\n');
    }
    std::fs::write(folder.join("dem.asc"), text).expect("written");
}

const TERRAIN: &str = "terrain = \"dem.asc\"\nterrain_crs = \"EPSG:4326\"\n";

fn entry(kmz: &[u8], name: &str) -> String {
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(kmz)).expect("a ZIP file");
    let mut text = String::new();
    zip.by_name(name)
        .expect("an entry")
        .read_to_string(&mut text)
        .expect("text");
    text
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Node<'a, 'a> {
    node.children()
        .find(|n| n.has_tag_name(name))
        .unwrap_or_else(|| panic!("no {name}"))
}

fn text<'a>(node: Node<'a, 'a>, name: &str) -> &'a str {
    child(node, name).text().unwrap_or_default()
}

fn value(node: Node<'_, '_>, name: &str) -> f64 {
    node.children()
        .find(|n| n.has_tag_name(name))
        .and_then(|n| n.text()?.parse().ok())
        .unwrap_or_else(|| panic!("no number {name}"))
}

/// Latitude, longitude and height of the waypoints of a wayline.
fn wayline(plan: &FlightPlan) -> Vec<[f64; 3]> {
    let kmz = to_wpml(plan, &plan.flights[0]).expect("a mission");
    let waylines = entry(&kmz, "wpmz/waylines.wpml");
    let document = Document::parse(&waylines).expect("XML");
    let placemarks = document
        .descendants()
        .filter(|n| n.has_tag_name("Placemark"));
    placemarks
        .map(|p| {
            let place = text(child(p, "Point"), "coordinates");
            let (longitude, latitude) = place.split_once(',').expect("two numbers");
            [
                latitude.parse().expect("a latitude"),
                longitude.parse().expect("a longitude"),
                value(p, "executeHeight"),
            ]
        })
        .collect()
}

#[test]
fn every_format_has_the_same_waypoints() {
    let folder = tempfile::tempdir().expect("a folder");
    raster(folder.path());
    for plan in [level(), plan(TERRAIN, folder.path())] {
        let flight = &plan.flights[0];
        let by_dji = wayline(&plan);
        assert!(by_dji.len() >= 4);

        let mission = to_qgroundcontrol(&plan, flight).expect("a mission");
        let items = mission["mission"]["items"].as_array().expect("items");
        let by_qgroundcontrol: Vec<[f64; 3]> = items
            .iter()
            .filter(|item| item["command"] == 16)
            .map(|item| [4, 5, 6].map(|k| item["params"][k].as_f64().expect("a number")))
            .collect();

        let rows = to_waypoints(&plan, flight).expect("a mission");
        let rows: Vec<Vec<f64>> = rows
            .lines()
            .skip(2)
            .map(|row| {
                row.split('\t')
                    .map(|v| v.parse().expect("a number"))
                    .collect()
            })
            .collect();
        let by_waypoints: Vec<[f64; 3]> = rows
            .iter()
            .filter(|row| row[3] == 16.0)
            .map(|row| [row[8], row[9], row[10]])
            .collect();

        let csv = to_ugcs(&plan, flight).expect("a mission");
        let add_m = plan.ground.as_ref().map_or(0.0, |ground| ground.home_m());
        let by_ugcs: Vec<[f64; 3]> = csv
            .lines()
            .skip(1)
            .map(|row| {
                let row: Vec<f64> = row
                    .split(',')
                    .map(|v| v.parse().expect("a number"))
                    .collect();
                [row[1], row[2], row[3] - add_m]
            })
            .collect();
        for others in [by_qgroundcontrol, by_waypoints, by_ugcs] {
            assert_eq!(others.len(), by_dji.len());
            for (other, one) in others.iter().zip(&by_dji) {
                assert!((other[0] - one[0]).abs() < 2e-9 && (other[1] - one[1]).abs() < 2e-9);
                assert!((other[2] - one[2]).abs() < 2e-3, "{other:?} {one:?}");
            }
        }
    }
}

#[test]
fn missions_over_a_terrain_keep_their_height_above_it() {
    let folder = tempfile::tempdir().expect("a folder");
    raster(folder.path());
    let plan = plan(TERRAIN, folder.path());
    let (above_m, tolerance_m) = (plan.summary.height_m, plan.file.drone.stray_m);
    let home_m = height_m(40.9, 14.2);
    assert!((plan.home_above_sea_m() - home_m).abs() < 0.05);
    let route = Route::of(&plan, &plan.flights[0]).expect("a route");
    let corners: usize = level()
        .lines
        .lines
        .iter()
        .map(|l| l.waypoints_m.len())
        .sum();
    assert!(route.stops.len() > corners + 1, "{}", route.stops.len());
    // From take-off to above home, on every leg.
    let ends = [0.0, 0.0, route.take_off_m];
    let stops = route
        .stops
        .iter()
        .map(|s| [s.place_m[0], s.place_m[1], s.above_home_m]);
    let ends: Vec<[f64; 3]> = [ends].into_iter().chain(stops).collect();
    assert!(ends[ends.len() - 1][0].hypot(ends[ends.len() - 1][1]) < 1e-9);
    for leg in ends.windows(2) {
        for k in 0..=100 {
            let at = [0, 1, 2].map(|a| leg[0][a] + f64::from(k) / 100.0 * (leg[1][a] - leg[0][a]));
            let place = plan.place([at[0], at[1]], 0.0);
            let ground_m = height_m(place.latitude_deg(), place.longitude_deg()) - home_m;
            let off_m = at[2] - ground_m - above_m;
            assert!(off_m.abs() < tolerance_m + 0.1, "{off_m} m at {at:?}");
        }
    }
}

#[test]
fn a_terrain_that_ends_too_early_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    raster(folder.path());
    let wider = AREA.replace("14.2005", "14.2030");
    let file = PlanFile::parse(&format!("{wider}{TERRAIN}{WANT}")).expect("a file");
    let error = FlightPlan::make(file.clone().resolved_in(folder.path()))
        .expect_err("beyond the raster")
        .to_string();
    assert!(
        error.starts_with("[area] terrain") && error.contains("dem.asc"),
        "{error}"
    );
    let error = FlightPlan::make(file.resolved_in(Path::new("nowhere")))
        .expect_err("no such file")
        .to_string();
    assert!(error.contains("nowhere/dem.asc"), "{error}");
    let text = format!("{AREA}terrain_crs = \"EPSG:4326\"\n{WANT}");
    let error = PlanFile::parse(&text).expect_err("no terrain").to_string();
    assert!(
        error.starts_with("[area] terrain: expected a file"),
        "{error}"
    );
}

/// The rules of MAVLink's plain text: tabs, twelve columns, numbers in order, home first.
#[test]
fn waypoints_are_rows_of_twelve_columns() {
    let plan = level();
    let text = to_waypoints(&plan, &plan.flights[0]).expect("a mission");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("QGC WPL 110"));
    let rows: Vec<Vec<f64>> = lines
        .map(|row| {
            row.split('\t')
                .map(|v| v.parse().expect("a number"))
                .collect()
        })
        .collect();
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row.len(), 12);
        assert_eq!(row[0], i as f64);
        assert_eq!(row[1], f64::from(u8::from(i == 0)));
        assert_eq!(row[2], if i == 0 { 0.0 } else { 3.0 });
        assert_eq!(row[11], 1.0);
    }
    assert_eq!(rows[0][8..11], [40.9, 14.2, 30.0]);
    assert_eq!((rows[1][3], rows[rows.len() - 1][3]), (22.0, 20.0));
    // The ground speed is set before each leg whose speed is another one.
    let speeds: Vec<f64> = rows
        .iter()
        .filter(|r| r[3] == 178.0)
        .map(|r| r[5])
        .collect();
    assert_eq!(speeds.len(), 2 * plan.lines.lines.len() + 1);
    for pair in speeds.chunks_exact(2) {
        assert_eq!(pair[0], plan.file.drone.max_speed_m_s);
        assert!((pair[1] - plan.summary.speed_m_s).abs() < 1e-3);
    }
}

/// What DJI's description of WPML 1.0.2 calls required, and its rules on turns.
#[test]
fn wpml_has_every_required_element() {
    let curved = format!("{AREA}{WANT}ghost = 0.5\n[drone]\ndji_model = \"M300 RTK\"\n");
    let plan = FlightPlan::make(PlanFile::parse(&curved).expect("a file")).expect("a plan");
    assert!(plan.curve.is_some());
    let kmz = to_wpml(&plan, &plan.flights[0]).expect("a mission");
    for (name, folder_has, placemark_has) in [
        (
            "wpmz/template.kml",
            &[
                "templateType",
                "templateId",
                "waylineCoordinateSysParam",
                "autoFlightSpeed",
                "globalHeight",
                "gimbalPitchMode",
                "globalWaypointHeadingParam",
                "globalWaypointTurnMode",
                "globalUseStraightLine",
            ][..],
            &[
                "index",
                "ellipsoidHeight",
                "height",
                "useGlobalHeight",
                "useGlobalSpeed",
                "useGlobalHeadingParam",
                "useGlobalTurnParam",
                "useStraightLine",
                "waypointSpeed",
                "waypointTurnParam",
            ][..],
        ),
        (
            "wpmz/waylines.wpml",
            &[
                "templateId",
                "executeHeightMode",
                "waylineId",
                "autoFlightSpeed",
            ],
            &[
                "index",
                "executeHeight",
                "waypointSpeed",
                "waypointHeadingParam",
                "waypointTurnParam",
                "useStraightLine",
            ],
        ),
    ] {
        let xml = entry(&kmz, name);
        let document = Document::parse(&xml).expect("XML");
        let root = child(document.root_element(), "Document");
        let mission = child(root, "missionConfig");
        for element in [
            "flyToWaylineMode",
            "finishAction",
            "exitOnRCLost",
            "executeRCLostAction",
            "takeOffSecurityHeight",
            "globalTransitionalSpeed",
        ] {
            assert!(!text(mission, element).is_empty(), "{name}: {element}");
        }
        assert_eq!(value(child(mission, "droneInfo"), "droneEnumValue"), 60.0);
        let folder = child(root, "Folder");
        for element in folder_has {
            child(folder, element);
        }
        let placemarks: Vec<Node<'_, '_>> = folder
            .children()
            .filter(|n| n.has_tag_name("Placemark"))
            .collect();
        assert_eq!(
            placemarks.len(),
            Route::of(&plan, &plan.flights[0])
                .expect("a route")
                .stops
                .len()
        );
        let mut passed = 0;
        for (i, placemark) in placemarks.iter().enumerate() {
            for element in placemark_has {
                child(*placemark, element);
            }
            assert_eq!(value(*placemark, "index"), i as f64);
            let speed_m_s = value(*placemark, "waypointSpeed");
            assert!(speed_m_s > 0.0 && speed_m_s <= 15.0);
            let turn = child(*placemark, "waypointTurnParam");
            let damping_m = value(turn, "waypointTurnDampingDist");
            match text(turn, "waypointTurnMode") {
                "coordinateTurn" => {
                    // Above 0, and two of them fit into a leg.
                    assert!(damping_m > 0.0 && i > 0 && i + 1 < placemarks.len());
                    assert!((speed_m_s - plan.summary.speed_m_s).abs() < 1e-3);
                    passed += 1;
                }
                "toPointAndStopWithDiscontinuityCurvature" => assert_eq!(damping_m, 0.0),
                other => panic!("{other}"),
            }
        }
        let inner: usize = plan
            .lines
            .lines
            .iter()
            .map(|l| l.waypoints_m.len() - 2)
            .sum();
        assert_eq!(passed, inner);
    }
}
