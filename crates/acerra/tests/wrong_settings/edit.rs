//! Edits of a campaign: one wrong setting each.

use toml::{Table, Value};

use crate::trajectories::Distortion;

/// One change of a campaign file.
#[derive(Clone, Debug)]
pub enum Edit {
    /// The key gets this value, as TOML writes it.
    Set(&'static str, String),
    /// So much is added to a component of the key's right value.
    Add(&'static str, usize, f64),
    /// All of the key's right value is multiplied.
    Scale(&'static str, f64),
    /// The key is left out.
    Remove(&'static str),
    /// The positions come from a trajectory file with a wrong unit, axis or clock.
    Trajectory(Distortion),
}

/// A campaign as a table, and the right values of keys that it leaves to their defaults.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The right campaign.
    pub campaign: Table,
    /// Right values beside those that the campaign states.
    pub known: Table,
}

impl Settings {
    /// The campaign with the edits; none where an edit has nothing to change in it.
    pub fn edited(&self, edits: &[Edit]) -> Option<Table> {
        let mut campaign = self.campaign.clone();
        for edit in edits {
            match edit {
                Edit::Set(key, value) => {
                    let file = format!("value = {value}").parse::<Table>().unwrap();
                    put(&mut campaign, key, file["value"].clone())?;
                }
                Edit::Add(key, component, amount) => {
                    let right = self.right(&campaign, key)?;
                    put(&mut campaign, key, added(&right, *component, *amount)?)?;
                }
                Edit::Scale(key, factor) => {
                    let right = self.right(&campaign, key)?;
                    put(&mut campaign, key, scaled(&right, *factor)?)?;
                }
                Edit::Remove(key) => {
                    let (section, key) = key.split_once('.')?;
                    campaign.get_mut(section)?.as_table_mut()?.remove(key)?;
                }
                Edit::Trajectory(distortion) => {
                    campaign.remove("gnss")?;
                    let file = Value::String(distortion.file_name());
                    put(&mut campaign, "trajectory.file", file)?;
                }
            }
        }
        Some(campaign)
    }

    /// The value of a key as edited so far, or as it is right where the campaign leaves it out.
    fn right(&self, campaign: &Table, key: &str) -> Option<Value> {
        let (section, key) = key.split_once('.')?;
        [campaign, &self.known]
            .into_iter()
            .find_map(|table| table.get(section)?.as_table()?.get(key))
            .cloned()
    }
}

/// Sets `section.key`, in a section that the campaign has (or may always have).
fn put(campaign: &mut Table, key: &str, value: Value) -> Option<()> {
    let (section, key) = key.split_once('.')?;
    if section != "gnss" && !campaign.contains_key(section) {
        campaign.insert(section.to_owned(), Value::Table(Table::new()));
    }
    let section = campaign.get_mut(section)?.as_table_mut()?;
    section.insert(key.to_owned(), value);
    Some(())
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| {
        #[expect(clippy::cast_precision_loss, reason = "settings are small numbers")]
        value.as_integer().map(|n| n as f64)
    })
}

fn added(value: &Value, component: usize, amount: f64) -> Option<Value> {
    match value {
        Value::Array(parts) => {
            let mut parts = parts.clone();
            parts[component] = Value::Float(number(&parts[component])? + amount);
            Some(Value::Array(parts))
        }
        one => Some(Value::Float(number(one)? + amount)),
    }
}

fn scaled(value: &Value, factor: f64) -> Option<Value> {
    match value {
        Value::Array(parts) => {
            let parts: Option<Vec<Value>> = parts.iter().map(|p| scaled(p, factor)).collect();
            parts.map(Value::Array)
        }
        one => Some(Value::Float(number(one)? * factor)),
    }
}
