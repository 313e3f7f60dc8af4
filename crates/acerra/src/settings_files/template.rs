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

    /// A key that keeps its default, with a remark.
    #[must_use]
    pub fn remark(path: &str, found: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            value: None,
            found: vec![found.into()],
        }
    }

    /// This key with a remark.
    #[must_use]
    pub fn because(mut self, found: impl Into<String>) -> Self {
        self.found.push(found.into());
        self
    }
}

/// Examples of keys without a default.
const SAMPLES: &[(&str, &str)] = &[
    ("antenna_offset_m", "[0.3, 0.0, 0.0]"),
    ("attitude_file", "\"flight.bin\""),
    ("attitude_source", "\"ATT\""),
    ("band_pass_ghz", "[0.5, 2.5]"),
    ("base", "\"base.ubx\""),
    ("base_deg_m", "[40.9596, 14.3696, 75.0]"),
    ("base_ecef_m", "[4672340.0, 1196830.0, 4159200.0]"),
    ("channel", "\"first\""),
    ("clean_threshold_db", "-30.0"),
    ("clock_offset_sigma_s", "0.01"),
    ("config", "\"rtklib.conf\""),
    ("correlation_s", "5.0"),
    ("damping", "0.05"),
    ("delay_ns", "10.0"),
    ("delay_sigma_ns", "0.5"),
    ("dewow_ns", "2.0"),
    ("end_m", "[1.05, 0.15, 0.01]"),
    ("epsg", "25833"),
    ("file", "\"flight.mrm\""),
    ("files", "\"line-*.rd3\""),
    ("formats", "[\"geotiff\", \"geojson\"]"),
    ("from_m", "[2.0, 0.0, 0.0]"),
    ("geoid", "\"egm2008-1.pgm\""),
    ("ghost", "0.5"),
    ("gimbal_source", "\"MNT[0]\""),
    ("ground_z_m", "0.0"),
    ("heading_deg", "90.0"),
    ("height_datum", "\"sea\""),
    ("home_deg", "[40.9596, 14.3696]"),
    ("line_end_m", "[1.05, 0.15, 0.01]"),
    ("line_start_m", "[0.15, 0.15, 0.01]"),
    ("line_step_m", "[0.0, 0.025, 0.0]"),
    ("looks", "4"),
    ("max_gap_s", "1.0"),
    ("max_incidence_deg", "45.0"),
    ("max_iterations", "60"),
    ("max_points", "24"),
    ("memory_gb", "4.0"),
    ("name", "\"first\""),
    ("navigation", "\"brdc.nav\""),
    ("on_track_s", "[10.0, 30.0]"),
    ("origin_deg_m", "[40.9596, 14.3696, 75.0]"),
    ("pixel_z_m", "0.1"),
    ("position_m", "[4.0, 0.0, 0.0]"),
    ("relative_permittivity", "4.0"),
    ("rigid_body", "\"drone\""),
    ("rover", "\"rover.ubx\""),
    ("scatterers", "20"),
    ("sigma_m", "[0.02, 0.02, 0.04]"),
    ("source", "\"GPS[1]\""),
    ("sparsity", "0.05"),
    ("speed_m_s", "0.6"),
    ("start_m", "[0.15, 0.15, 0.01]"),
    ("survey", "\"points.csv\""),
    ("target_m", "[4.0, 0.0, 0.0]"),
    ("terrain", "\"dem.tif\""),
    ("terrain_crs", "\"EPSG:32633\""),
    ("thickness_m", "0.15"),
    ("to_m", "[6.0, 0.0, 0.0]"),
    ("trajectory.file", "\"flight.pos\""),
    ("track_delay_sigma_ns", "0.2"),
    ("track_shift_sigma_m", "[0.05, 0.05, 0.1]"),
    ("x_m", "[0.0, 18.0]"),
    ("y_m", "[-9.0, 9.0]"),
    ("z_m", "0.0"),
    ("zero_timing", "\"first-trace\""),
];

/// Columns of a line of comment.
const WIDTH: usize = 96;

/// The whole file: `head`, then every table. Keys that are `filled` are set, the others are comments with
/// their default. Tables are open where an open table has no effect, so that a key is set by removing its
/// comment sign; other tables without a set key are comments as a whole.
#[must_use]
pub fn write(head: &str, tables: &[Table], filled: &[Filled]) -> String {
    let mut text = String::new();
    head.lines().for_each(|line| comment(&mut text, line));
    text.push_str(
        "# Keys in comments have the value shown, or none where it says \"for example\".\n",
    );
    for table in tables {
        write_table(&mut text, table, filled);
    }
    text
}

/// The file with the important keys first: `head`; then, by table, the keys that are `filled`, keys with a
/// remark, and those of `first`, each with the first sentence of its description; after them all other keys
/// as comments.
#[must_use]
pub fn write_first(head: &str, tables: &[Table], filled: &[Filled], first: &[&str]) -> String {
    let is_first = |table: &Table, key: &Key| {
        let path = path_of(table, key);
        first.contains(&path.as_str()) || filled.iter().any(|one| one.path == path)
    };
    let is_set = |table: &Table| {
        let mut keys = table.keys.iter();
        keys.any(|key| found_of(table, key, filled).is_some_and(|one| one.value.is_some()))
    };
    let parted = |is_wanted: &dyn Fn(&Table, &Key) -> bool| -> Vec<Table> {
        let part = |table: &Table| Table {
            keys: table
                .keys
                .iter()
                .filter(|key| is_wanted(table, key))
                .cloned()
                .collect(),
            ..table.clone()
        };
        tables
            .iter()
            .map(part)
            .filter(|part| !part.keys.is_empty())
            .collect()
    };
    // A table that must be absent unless it has values is left to the remaining keys.
    let opens = |table: &Table| table.may_be_empty || is_set(table);
    let mut text = String::new();
    head.lines().for_each(|line| comment(&mut text, line));
    text.push_str(
        "# Keys behind a # have the value shown, or none where it says \"for example\".\n",
    );
    let foremost = parted(&|table, key| opens(table) && is_first(table, key));
    for table in &foremost {
        let _ = writeln!(text, "\n[{}]", table.path);
        for key in &table.keys {
            let brief = Key {
                description: first_sentence(&key.description),
                forms: Vec::new(),
                ..key.clone()
            };
            write_key(&mut text, table, &brief, found_of(table, key, filled));
        }
    }
    text.push('\n');
    comment(
        &mut text,
        "The other keys. A key of a table above is set by a line in that table; a key of another table by \
         removing its # and the # before the name of its table.",
    );
    for mut table in parted(&|table, key| !(opens(table) && is_first(table, key))) {
        table.may_be_empty &= foremost.iter().all(|above| above.path != table.path);
        write_table(&mut text, &table, &[]);
    }
    text
}

fn first_sentence(text: &str) -> String {
    let paragraph = text.lines().next().unwrap_or_default();
    // A full stop within a number, a name or an abbreviation has no space and capital behind it.
    let ends = paragraph.match_indices(". ").map(|(at, _)| at);
    let mut ends =
        ends.filter(|at| paragraph[at + 2..].starts_with(|c: char| c.is_uppercase() || c == '`'));
    match ends.next() {
        Some(at) => paragraph[..=at].to_owned(),
        None => paragraph.to_owned(),
    }
}

fn path_of(table: &Table, key: &Key) -> String {
    match table.path.as_str() {
        "" => key.name.clone(),
        table => format!("{table}.{}", key.name),
    }
}

fn found_of<'a>(table: &Table, key: &Key, filled: &'a [Filled]) -> Option<&'a Filled> {
    let path = path_of(table, key);
    filled.iter().find(|one| one.path == path)
}

fn write_table(text: &mut String, table: &Table, filled: &[Filled]) {
    let of = |key: &Key| found_of(table, key, filled);
    // A repeated table must begin before its keys.
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
        write_key(text, table, key, of(key));
    }
}

fn write_key(text: &mut String, table: &Table, key: &Key, filled: Option<&Filled>) {
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
        (None, None) => writeln!(
            text,
            "# {} = {}    # for example",
            key.name,
            sample(table, key)
        ),
    };
}

/// A value of the right form for a key without a default.
#[must_use]
pub fn sample(table: &Table, key: &Key) -> String {
    let of = |wanted: &str| SAMPLES.iter().find(|(name, _)| *name == wanted);
    let known = of(&path_of(table, key)).or_else(|| of(&key.name));
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
