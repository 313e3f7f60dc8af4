//! GeoJSON (RFC 7946): longitude before latitude on WGS84, heights above the ellipsoid.

use acerra_geo::geodesy::Geodetic;
use serde_json::{Map, Value, json};

/// Points and lines with properties, in the order in which they are added.
///
/// ```
/// use acerra_geo::geodesy::Geodetic;
/// use acerra_maps::geojson::FeatureCollection;
/// use serde_json::json;
/// let mut features = FeatureCollection::default();
/// let properties = json!({"name": "reflector"});
/// features.point(&Geodetic::from_degrees(40.9596, 14.3696, 75.0), properties);
/// assert!(features.to_text().contains("[14.3696, 40.9596, 75.0]"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct FeatureCollection {
    features: Vec<Value>,
    members: Map<String, Value>,
}

impl FeatureCollection {
    /// Adds a point.
    pub fn point(&mut self, place: &Geodetic, properties: Value) {
        self.add("Point", position(place), properties);
    }

    /// Adds a line.
    pub fn line(&mut self, places: &[Geodetic], properties: Value) {
        let line: Vec<Value> = places.iter().map(position).collect();
        self.add("LineString", Value::Array(line), properties);
    }

    /// Adds a closed outline as a line, so that it is in one layer with others; the first place is not repeated in
    /// `corners`.
    pub fn outline(&mut self, corners: &[Geodetic], properties: Value) {
        let closed: Vec<Geodetic> = corners.iter().chain(corners.first()).copied().collect();
        self.line(&closed, properties);
    }

    /// Adds a member to the collection itself (RFC 7946, section 6.1).
    pub fn member(&mut self, name: &str, value: Value) {
        self.members.insert(name.to_owned(), value);
    }

    /// The text of the file, a feature a line.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = "{\"type\": \"FeatureCollection\",\n".to_owned();
        for (name, value) in &self.members {
            text.push_str(&format!("{}: {},\n", json!(name), spaced(value)));
        }
        let features: Vec<String> = self.features.iter().map(spaced).collect();
        text.push_str("\"features\": [\n");
        text.push_str(&features.join(",\n"));
        text.push_str("\n]}\n");
        text
    }

    /// Properties that are null are left out: programs that read columns take one of nulls alone for text.
    fn add(&mut self, kind: &str, coordinates: Value, mut properties: Value) {
        if let Value::Object(members) = &mut properties {
            members.retain(|_, value| !value.is_null());
        }
        self.features.push(json!({
            "type": "Feature",
            "geometry": {"type": kind, "coordinates": coordinates},
            "properties": properties,
        }));
    }
}

/// Longitude and latitude to a tenth of a millimetre, height to a millimetre.
fn position(place: &Geodetic) -> Value {
    let rounded = |value: f64, per_unit: f64| (value * per_unit).round() / per_unit;
    json!([
        rounded(place.longitude_deg(), 1e9),
        rounded(place.latitude_deg(), 1e9),
        rounded(place.height_m, 1e3)
    ])
}

/// Compact, with a space behind commas and colons.
fn spaced(value: &Value) -> String {
    match value {
        Value::Object(members) => {
            let members: Vec<String> = members
                .iter()
                .map(|(name, value)| format!("{}: {}", json!(name), spaced(value)))
                .collect();
            format!("{{{}}}", members.join(", "))
        }
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(spaced).collect();
            format!("[{}]", values.join(", "))
        }
        other => other.to_string(),
    }
}
