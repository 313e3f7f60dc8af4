//! `targets.geojson`: targets with their uncertainty; `flight.geojson`: the tracks and the outline of the image. A file has
//! one kind of geometry, so that map programs show it as one layer.

use acerra_geo::geodesy::Geodetic;
use acerra_maps::geojson::FeatureCollection;
use serde_json::{Map, Value, json};

use super::frame::OnEarth;
use crate::outcome::Outcome;
use crate::provenance;
use crate::staging::Staging;
use crate::uncertainty::place_sigma;

/// Places of a track at most.
const MOST_PLACES: usize = 2000;

pub(super) fn write(
    outcome: &Outcome,
    earth: OnEarth<'_>,
    staging: &Staging,
) -> anyhow::Result<()> {
    let [mut targets, mut lines] = [(); 2].map(|()| FeatureCollection::default());
    let items = provenance::items(outcome);
    let members: Map<String, Value> = items.into_iter().map(|(k, v)| (k, v.into())).collect();
    targets.member("provenance", Value::Object(members.clone()));
    lines.member("provenance", Value::Object(members));
    for (k, target) in outcome.measured.targets.iter().enumerate() {
        let place_m = [target.x_m, target.y_m, target.z_m];
        let place: Geodetic = earth.frame.geodetic_from_enu(place_m);
        let sigma = place_sigma(&outcome.prepared, target);
        let properties = json!({
            "name": format!("target {}", k + 1),
            "level_db": target.level_db,
            "x_m": target.x_m,
            "y_m": target.y_m,
            "z_m": target.z_m,
            "height_above_geoid_m": outcome.above_sea_m(&place),
            "sigma_along_m": sigma.map(|s| s.along_m),
            "sigma_across_m": sigma.map(|s| s.across_m),
            "rayleigh_along_m": target.along.rayleigh_m,
            "rayleigh_across_m": target.across.rayleigh_m,
            "ghost_level": target.ghost.map(|g| g.level),
        });
        targets.point(&place, properties);
    }
    for track in &outcome.prepared.tracks {
        let name = format!("track {}", track.name);
        for places in earth.lines(outcome, track, MOST_PLACES) {
            if places.len() > 1 {
                lines.line(&places, json!({"name": name.trim()}));
            }
        }
    }
    lines.outline(&earth.corners(), json!({"name": "image"}));
    staging.write("targets.geojson", targets.to_text())?;
    staging.write("flight.geojson", lines.to_text())
}
