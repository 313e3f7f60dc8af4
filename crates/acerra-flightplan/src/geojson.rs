//! The plan as GeoJSON (RFC 7946): longitude before latitude, outlines counter-clockwise.

use acerra_geo::geodesy::Geodetic;
use serde_json::{Value, json};

use super::FlightPlan;

/// Nine decimals of a degree are a tenth of a millimetre.
fn degrees(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

fn position(place: &Geodetic) -> Value {
    json!([
        degrees(place.longitude_deg()),
        degrees(place.latitude_deg()),
        place.height_m
    ])
}

/// A feature collection: the area, home, and every line with its height above ground.
///
/// Heights are above ground, as the property `height_reference` of each feature says.
#[must_use]
pub fn to_geojson(plan: &FlightPlan) -> Value {
    let mut outline = plan.area_corners();
    let corners = plan.area.corners();
    let turning: f64 = plan
        .area
        .edges()
        .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
        .sum();
    if turning < 0.0 {
        outline.reverse();
    }
    debug_assert_eq!(outline.len(), corners.len());
    outline.push(outline[0]);
    let ring: Vec<Value> = outline.iter().map(position).collect();

    let s = &plan.summary;
    let mut features = vec![
        json!({
            "type": "Feature",
            "properties": {
                "name": "area", "area_m2": s.area_m2, "along_m": s.along_m,
                "across_m": plan.file.want.across_m, "height_reference": "ground",
            },
            "geometry": { "type": "Polygon", "coordinates": [ring] },
        }),
        json!({
            "type": "Feature",
            "properties": { "name": "home", "height_reference": "ground" },
            "geometry": { "type": "Point", "coordinates": position(&plan.place([0.0; 2], 0.0)) },
        }),
    ];
    for (i, line) in plan.lines.lines.iter().enumerate() {
        let places = line.waypoints_m.iter().map(|p| plan.place(*p, s.height_m));
        let coordinates: Vec<Value> = places.map(|p| position(&p)).collect();
        let flight = plan
            .flights
            .iter()
            .position(|f| (f.first_line..=f.last_line).contains(&i));
        features.push(json!({
            "type": "Feature",
            "properties": {
                "name": format!("line {}", i + 1), "line": i + 1, "flight": flight.map(|f| f + 1),
                "height_m": s.height_m, "speed_m_s": s.speed_m_s, "length_m": line.length_m(),
                "height_reference": "ground",
            },
            "geometry": { "type": "LineString", "coordinates": coordinates },
        }));
    }
    json!({ "type": "FeatureCollection", "features": features })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlanFile;

    #[test]
    fn rings_close_and_turn_left_lines_have_heights() {
        // Corners clockwise: the outline must be turned round.
        let text = "[area]\ncorners_deg = [[40.9, 14.2], [40.9002, 14.2], [40.9002, 14.2003], \
                    [40.9, 14.2003]]\n[want]\nalong_m = 0.06\nacross_m = 0.5\nrcs_dbsm = 10\n";
        let plan = FlightPlan::make(PlanFile::parse(text).expect("a file")).expect("a plan");
        let json = to_geojson(&plan);
        assert_eq!(json["type"], "FeatureCollection");
        let features = json["features"].as_array().expect("an array");
        assert_eq!(features.len(), 2 + plan.lines.lines.len());
        let number = |v: &Value| v.as_f64().expect("a number");
        let ring = features[0]["geometry"]["coordinates"][0]
            .as_array()
            .expect("a ring");
        assert_eq!((ring.len(), &ring[0]), (5, &ring[4]));
        let turning: f64 = ring
            .windows(2)
            .map(|w| number(&w[0][0]) * number(&w[1][1]) - number(&w[0][1]) * number(&w[1][0]))
            .sum();
        assert!(turning > 0.0);
        assert_eq!((number(&ring[0][0]), number(&ring[0][1])), (14.2003, 40.9));
        for line in &features[2..] {
            assert_eq!(line["geometry"]["type"], "LineString");
            let points = line["geometry"]["coordinates"]
                .as_array()
                .expect("an array");
            assert!(points.len() >= 2);
            for p in points {
                assert!((number(&p[0]) - 14.2).abs() < 0.01 && (number(&p[1]) - 40.9).abs() < 0.01);
                assert_eq!(number(&p[2]), plan.summary.height_m);
            }
        }
    }
}
