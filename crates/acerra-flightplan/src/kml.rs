//! The plan as KML 2.2.

use std::fmt::Write;

use acerra_geo::geodesy::Geodetic;

use super::FlightPlan;

fn coordinates(places: impl IntoIterator<Item = Geodetic>) -> String {
    let mut text = String::new();
    for p in places {
        let (lon, lat) = (p.longitude_deg(), p.latitude_deg());
        // Longitude first; blanks between places, none within.
        let _ = write!(text, "{lon:.9},{lat:.9},{:.2} ", p.height_m);
    }
    text.truncate(text.trim_end().len());
    text
}

/// A document with the area, home, and the lines at their height above ground.
#[must_use]
pub fn to_kml(plan: &FlightPlan) -> String {
    let s = &plan.summary;
    let mut outline = plan.area_corners();
    outline.push(outline[0]);
    let mut out = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>Acerra flight plan</name>\n\
         <Style id=\"line\"><LineStyle><color>ff00a5ff</color><width>2</width></LineStyle></Style>\n\
         <Style id=\"area\"><LineStyle><color>ffffffff</color></LineStyle>\
         <PolyStyle><color>40ffffff</color></PolyStyle></Style>\n",
    );
    let _ = writeln!(
        out,
        "<Placemark><name>area</name><styleUrl>#area</styleUrl><Polygon><outerBoundaryIs><LinearRing>\
         <coordinates>{}</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>",
        coordinates(outline)
    );
    let _ = writeln!(
        out,
        "<Placemark><name>home</name><Point><coordinates>{}</coordinates></Point></Placemark>",
        coordinates([plan.place([0.0; 2], 0.0)])
    );
    for (i, line) in plan.lines.lines.iter().enumerate() {
        let places = line.waypoints_m.iter().map(|p| plan.place(*p, s.height_m));
        let _ = writeln!(
            out,
            "<Placemark><name>line {}</name><description>{:.1} m at {:.2} m/s, {:.1} m above \
             ground</description><styleUrl>#line</styleUrl><LineString><tessellate>0</tessellate>\
             <altitudeMode>relativeToGround</altitudeMode><coordinates>{}</coordinates></LineString>\
             </Placemark>",
            i + 1,
            line.length_m(),
            s.speed_m_s,
            s.height_m,
            coordinates(places)
        );
    }
    out.push_str("</Document>\n</kml>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlanFile;

    #[test]
    fn tags_balance_and_places_are_longitude_first() {
        let text = "[area]\ncorners_deg = [[40.9, 14.2], [40.9002, 14.2], [40.9002, 14.2003], \
                    [40.9, 14.2003]]\n[want]\nalong_m = 0.06\nacross_m = 0.5\nrcs_dbsm = 10\n";
        let plan = FlightPlan::make(PlanFile::parse(text).expect("a file")).expect("a plan");
        let kml = to_kml(&plan);
        let mut open: Vec<&str> = Vec::new();
        for tag in kml.split('<').skip(1) {
            let (tag, _) = tag.split_once('>').expect("a tag ends");
            let name = tag.split_whitespace().next().expect("a name");
            if name.starts_with('?') {
                continue;
            }
            match name.strip_prefix('/') {
                Some(name) => assert_eq!(open.pop(), Some(name)),
                None => open.push(name),
            }
        }
        assert!(open.is_empty());
        let lists: Vec<&str> = kml
            .split("<coordinates>")
            .skip(1)
            .filter_map(|rest| rest.split_once('<').map(|(list, _)| list))
            .collect();
        assert_eq!(lists.len(), 2 + plan.lines.lines.len());
        for place in lists.iter().flat_map(|list| list.split(' ')) {
            let n: Vec<f64> = place
                .split(',')
                .map(|n| n.parse().expect("a number"))
                .collect();
            assert!((n[0] - 14.2).abs() < 0.01 && (n[1] - 40.9).abs() < 0.01 && n.len() == 3);
        }
        let ring: Vec<&str> = lists[0].split(' ').collect();
        assert_eq!((ring.len(), ring[0]), (5, ring[4]));
    }
}
