//! Commented settings files: every table and key with its meaning, unit and default.

use std::fmt::Write as _;

use serde_json::Value;

use super::keys::{Key, Table};

/// A key that is set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Filled {
    /// Table and key, such as `radar.file`.
    pub path: String,
    /// Its value in TOML; a comment still where it is only suggested.
    pub value: Option<String>,
    /// Where the value comes from.
    pub found: Vec<String>,
}

impl Filled {
    /// A key with its value in TOML.
    #[must_use]
    pub fn new(path: &str, value: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            value: Some(value.into()),
            found: Vec::new(),
        }
    }

    /// A key that keeps its default, with something to say about it.
    #[must_use]
    pub fn remark(path: &str, found: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            value: None,
            found: vec![found.into()],
        }
    }

    /// The same with something said about it.
    #[must_use]
    pub fn because(mut self, found: impl Into<String>) -> Self {
        self.found.push(found.into());
        self
    }
}

/// What keys without a default may look like.
const SAMPLES: &[(&str, &str)] = &[
    ("antenna_offset_m", "[0.3, 0.0, 0.0]"),
    ("attitude_file", "\"flight.bin\""),
    ("attitude_source", "\"ATT\""),
    ("band_pass_ghz", "[0.5, 2.5]"),
    ("base_deg_m", "[40.9596, 14.3696, 75.0]"),
    ("base_ecef_m", "[4672340.0, 1196830.0, 4159200.0]"),
    ("channel", "\"first\""),
    ("config", "\"rtklib.conf\""),
    ("delay_ns", "10.0"),
    ("dewow_ns", "2.0"),
    ("epsg", "25833"),
    ("formats", "[\"geotiff\", \"geojson\"]"),
    ("ghost", "0.5"),
    ("gimbal_source", "\"MNT[0]\""),
    ("ground_z_m", "0.0"),
    ("heading_deg", "90.0"),
    ("height_datum", "\"sea\""),
    ("home_deg", "[40.9596, 14.3696]"),
    ("line_end_m", "[1.05, 0.15, 0.01]"),
    ("files", "\"line-*.rd3\""),
    ("line_start_m", "[0.15, 0.15, 0.01]"),
    ("line_step_m", "[0.0, 0.025, 0.0]"),
    ("looks", "4"),
    ("max_gap_s", "1.0"),
    ("max_incidence_deg", "45.0"),
    ("name", "\"first\""),
    ("navigation", "\"brdc.nav\""),
    ("on_track_s", "[10.0, 30.0]"),
    ("origin_deg_m", "[40.9596, 14.3696, 75.0]"),
    ("pixel_z_m", "0.1"),
    ("relative_permittivity", "4.0"),
    ("rigid_body", "\"drone\""),
    ("source", "\"GPS[1]\""),
    ("speed_m_s", "0.6"),
    ("survey", "\"points.csv\""),
    ("target_m", "[4.0, 0.0, 0.0]"),
    ("terrain", "\"dem.tif\""),
    ("terrain_crs", "\"EPSG:32633\""),
    ("thickness_m", "0.15"),
    ("z_m", "0.0"),
    ("zero_timing", "\"first-trace\""),
];

/// Columns of a line of comment.
const WIDTH: usize = 96;

/// The whole file: `head`, then every table. Keys that are `filled` are set, the others stand as
/// comments with their default. Tables stand open where that changes nothing, so that a key becomes set
/// by taking its comment sign away; others without a key that is set are comments as a whole.
#[must_use]
pub fn write(head: &str, tables: &[Table], filled: &[Filled]) -> String {
    let mut text = String::new();
    head.lines().for_each(|line| comment(&mut text, line));
    text.push_str(
        "# Keys that stand as comments have the value shown, or none where it says \"for example\".\n",
    );
    for table in tables {
        write_table(&mut text, table, filled);
    }
    text
}

fn write_table(text: &mut String, table: &Table, filled: &[Filled]) {
    let of = |key: &Key| {
        let path = match table.path.as_str() {
            "" => key.name.clone(),
            table => format!("{table}.{}", key.name),
        };
        filled.iter().find(|one| one.path == path)
    };
    // A table that repeats must begin before what lies in it.
    let inside = format!("{}.", table.path);
    let is_set = filled.iter().filter(|one| one.value.is_some()).any(|one| {
        let rest = one.path.strip_prefix(&inside);
        rest.is_some_and(|rest| table.repeats || !rest.contains('.'))
    });
    text.push('\n');
    if !table.path.is_empty() {
        comment(text, &table.description);
        let (open, close) = if table.repeats {
            ("[[", "]]")
        } else {
            ("[", "]")
        };
        let off = if is_set || table.may_be_empty {
            ""
        } else {
            "# "
        };
        let _ = writeln!(text, "{off}{open}{}{close}", table.path);
    }
    for key in &table.keys {
        write_key(text, key, of(key));
    }
}

fn write_key(text: &mut String, key: &Key, filled: Option<&Filled>) {
    let mut description = key.description.clone();
    if let Some(unit) = key.unit().filter(|unit| !description.contains(unit)) {
        let _ = write!(description, " Unit: {unit}.");
    }
    let meanings = key.forms.iter().filter(|form| !form.meaning.is_empty());
    comment(text, &description);
    for form in meanings {
        comment(text, &format!("- {}: {}", form.text, form.meaning));
    }
    for found in filled.iter().flat_map(|one| &one.found) {
        comment(text, &format!("Found: {found}"));
    }
    let _ = match (filled.and_then(|one| one.value.as_ref()), &key.default) {
        (Some(value), _) => writeln!(text, "{} = {value}", key.name),
        (None, Some(default)) => writeln!(text, "# {} = {}", key.name, toml_of(default)),
        (None, None) => writeln!(text, "# {} = {}    # for example", key.name, sample(key)),
    };
}

/// A value of the right form for a key without a default.
#[must_use]
pub fn sample(key: &Key) -> String {
    let known = SAMPLES.iter().find(|(name, _)| *name == key.name);
    match (known, key.forms.first()) {
        (Some((_, value)), _) => (*value).to_owned(),
        (None, Some(form)) => form
            .text
            .replace("integer", "1")
            .replace("number", "1.0")
            .replace("text", "\"…\"")
            .replace("true or false", "true")
            .replace(", …", ""),
        (None, None) => "\"…\"".to_owned(),
    }
}

/// A JSON value in TOML, on one line.
#[must_use]
pub fn toml_of(value: &Value) -> String {
    match value {
        Value::Array(list) => {
            let list: Vec<String> = list.iter().map(toml_of).collect();
            format!("[{}]", list.join(", "))
        }
        Value::Object(fields) => {
            let fields: Vec<String> = fields
                .iter()
                .map(|(name, value)| format!("{name} = {}", toml_of(value)))
                .collect();
            format!("{{ {} }}", fields.join(", "))
        }
        Value::String(text) => quoted(text),
        other => other.to_string(),
    }
}

/// A text as a TOML string.
#[must_use]
pub fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// Lines of comment, broken between words.
fn comment(text: &mut String, words: &str) {
    for paragraph in words.lines().filter(|line| !line.trim().is_empty()) {
        let mut columns = 0;
        for word in paragraph.split_whitespace() {
            let length = word.chars().count();
            if columns == 0 || columns + 1 + length > WIDTH {
                if columns > 0 {
                    text.push('\n');
                }
                text.push('#');
                columns = 1;
            }
            text.push(' ');
            text.push_str(word);
            columns += 1 + length;
        }
        text.push('\n');
    }
}
