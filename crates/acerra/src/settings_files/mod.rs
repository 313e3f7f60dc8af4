//! The settings files (campaign, scene, plan) as their schemas have them: JSON Schema, commented
//! templates, and the reference of all keys.

pub mod keys;
pub mod reference;
pub mod template;

use acerra_chain::campaign::Campaign;
use acerra_flightplan::PlanFile;
use acerra_simulate::scene::Scene;
use schemars::schema_for;
use serde_json::Value;

/// A kind of settings file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SettingsFile {
    /// Input of `acerra focus`.
    Campaign,
    /// Input of `acerra simulate`.
    Scene,
    /// Input of `acerra plan`.
    Plan,
}

impl SettingsFile {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Campaign, Self::Scene, Self::Plan];

    /// Its JSON Schema (draft 2020-12), as the reader has it.
    #[must_use]
    pub fn schema(self) -> Value {
        let (schema, title) = match self {
            Self::Campaign => (schema_for!(Campaign), "Acerra campaign"),
            Self::Scene => (schema_for!(Scene), "Acerra scene"),
            Self::Plan => (schema_for!(PlanFile), "Acerra flight plan"),
        };
        let mut schema = Value::from(schema);
        close_tables(&mut schema);
        schema["title"] = Value::from(title);
        schema
    }

    /// Its tables and keys, in the order in which they are written.
    #[must_use]
    pub fn tables(self) -> Vec<keys::Table> {
        keys::tables(&self.schema())
    }

    /// A complete file with a comment for every key, which its reader accepts.
    #[must_use]
    pub fn example(self) -> String {
        let (head, filled) = match self {
            Self::Campaign => (CAMPAIGN_HEAD, CAMPAIGN_EXAMPLE),
            Self::Scene => (SCENE_HEAD, SCENE_EXAMPLE),
            Self::Plan => (PLAN_HEAD, PLAN_EXAMPLE),
        };
        let filled = filled
            .iter()
            .map(|(path, value)| template::Filled::new(path, *value))
            .collect::<Vec<_>>();
        template::write(head, &self.tables(), &filled)
    }
}

/// Refuses unknown keys in inline tables as well, as their readers do.
fn close_tables(schema: &mut Value) {
    match schema {
        Value::Object(fields) => {
            if fields.get("properties").is_some_and(Value::is_object)
                && fields.get("type").is_some_and(|kind| kind == "object")
            {
                fields
                    .entry("additionalProperties")
                    .or_insert(Value::Bool(false));
            }
            fields.values_mut().for_each(close_tables);
        }
        Value::Array(list) => list.iter_mut().for_each(close_tables),
        _ => {}
    }
}

const CAMPAIGN_HEAD: &str = "A campaign: acerra focus CAMPAIGN.toml";

const CAMPAIGN_EXAMPLE: &[(&str, &str)] = &[
    ("radar.file", "\"flight.mrm\""),
    ("trajectory.file", "\"flight.pos\""),
    ("image.x_m", "[0.0, 18.0]"),
    ("image.y_m", "[-9.0, 9.0]"),
];

const SCENE_HEAD: &str = "A scene: acerra simulate SCENE.toml -o DIR";

/// The paper's second track over one of its reflectors.
const SCENE_EXAMPLE: &[(&str, &str)] = &[
    ("flight.track_start_m", "[0.0, -2.0]"),
    ("flight.track_end_m", "[33.0, -2.0]"),
    ("flight.height_m", "10.0"),
    ("flight.track_duration_s", "21.7"),
    ("radar.lever_arm_m", "[0.05, 0.0, -0.2]"),
    ("radar.samples", "1824"),
    ("ground.reflection", "0.08"),
    ("corner.position_m", "[4.0, 0.0, 0.0]"),
    ("gnss.humidity", "0.5"),
];

const PLAN_HEAD: &str = "A flight to be planned: acerra plan PLAN.toml -o DIR";

const PLAN_EXAMPLE: &[(&str, &str)] = &[
    (
        "area.corners_deg",
        "[[40.9596, 14.3696], [40.9596, 14.3700], [40.9598, 14.3700], [40.9598, 14.3696]]",
    ),
    ("want.along_m", "0.06"),
    ("want.across_m", "0.5"),
    ("want.ghost", "0.5"),
];
