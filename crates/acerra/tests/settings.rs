//! Settings files: schema, reader, examples and reference say the same.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra::settings_files::keys::{Key, Table};
use acerra::settings_files::template::{Filled, sample, toml_of, write};
use acerra::settings_files::{SettingsFile, reference};
use acerra_chain::campaign::Campaign;
use acerra_flightplan::PlanFile;
use acerra_simulate::scene::Scene;
use serde_json::Value;

/// Reads a file for its keys and forms alone, without asking whether the values fit one another.
fn read(file: SettingsFile, text: &str) -> Result<(), acerra_settings::SyntaxError> {
    match file {
        SettingsFile::Campaign => acerra_settings::parse::<Campaign>(text).map(drop),
        SettingsFile::Scene => acerra_settings::parse::<Scene>(text).map(drop),
        SettingsFile::Plan => acerra_settings::parse::<PlanFile>(text).map(drop),
    }
}

/// Reads a file as its command does.
fn read_and_check(file: SettingsFile, text: &str) -> Result<(), String> {
    match file {
        SettingsFile::Campaign => Campaign::parse(text).map(drop).map_err(|e| e.to_string()),
        SettingsFile::Scene => Scene::parse(text).map(drop).map_err(|e| e.to_string()),
        SettingsFile::Plan => PlanFile::parse(text).map(drop).map_err(|e| e.to_string()),
    }
}

/// Whether a schema accepts a value: of JSON Schema what the schemas here use.
fn accepts(root: &Value, schema: &Value, value: &Value) -> bool {
    if let Some(path) = schema["$ref"].as_str() {
        let found = root.pointer(path.strip_prefix('#').unwrap()).unwrap();
        return accepts(root, found, value);
    }
    if schema == &Value::Bool(true) {
        return true;
    }
    for key in ["anyOf", "oneOf"] {
        if let Some(list) = schema[key].as_array() {
            return list.iter().any(|one| accepts(root, one, value));
        }
    }
    if let Some(constant) = schema.get("const") {
        return constant == value;
    }
    if let Some(list) = schema["enum"].as_array() {
        return list.contains(value);
    }
    let kinds = match &schema["type"] {
        Value::Array(kinds) => kinds.clone(),
        kind => vec![kind.clone()],
    };
    kinds.iter().any(|kind| match kind.as_str().unwrap() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => {
            let least = schema["minimum"].as_f64().unwrap_or(f64::NEG_INFINITY);
            value.is_i64() && value.as_f64().unwrap() >= least
        }
        "array" => value.as_array().is_some_and(|list| {
            let length = list.len() as u64;
            length >= schema["minItems"].as_u64().unwrap_or(0)
                && length <= schema["maxItems"].as_u64().unwrap_or(u64::MAX)
                && list.iter().all(|one| accepts(root, &schema["items"], one))
        }),
        "object" => value.as_object().is_some_and(|fields| {
            let required = schema["required"].as_array();
            let known = |name: &String| {
                let property = schema["properties"].get(name);
                property.map_or(schema["additionalProperties"] != false, |property| {
                    accepts(root, property, &fields[name])
                })
            };
            required.is_none_or(|r| {
                r.iter()
                    .all(|name| fields.contains_key(name.as_str().unwrap()))
            }) && fields.keys().all(known)
        }),
        other => panic!("{other}"),
    })
}

fn path_of(table: &Table, key: &Key) -> String {
    if table.path.is_empty() {
        key.name.clone()
    } else {
        format!("{}.{}", table.path, key.name)
    }
}

/// Whether a file with `table` has `other`: above it, or required wherever what is above is there.
fn is_needed(tables: &[Table], other: &Table, table: &Table) -> bool {
    let above = |path: &str| table.path == path || table.path.starts_with(&format!("{path}."));
    let outer = match other.path.rsplit_once('.') {
        Some((outer, _)) => tables.iter().find(|t| t.path == outer),
        None => None,
    };
    above(&other.path)
        || other.required && outer.is_none_or(|outer| is_needed(tables, outer, table))
}

/// A file with every key that its tables must have, and `key` beside them.
fn with_key(tables: &[Table], table: &Table, key: &Key, value: &str) -> String {
    let needed = tables.iter().filter(|t| is_needed(tables, t, table));
    let mut filled: Vec<Filled> = needed
        .flat_map(|t| {
            t.keys
                .iter()
                .filter(|k| k.required)
                .map(|k| (path_of(t, k), sample(t, k)))
        })
        .map(|(path, value)| Filled::new(&path, value))
        .collect();
    filled.retain(|one| one.path != path_of(table, key));
    filled.push(Filled::new(&path_of(table, key), value));
    write("", tables, &filled)
}

#[test]
fn every_key_of_the_schema_is_read_with_its_default_and_a_sample() {
    for file in SettingsFile::ALL {
        let (schema, tables) = (file.schema(), file.tables());
        let mut keys = 0;
        for table in &tables {
            for key in &table.keys {
                let default = key.default.as_ref().map(toml_of);
                for value in default.into_iter().chain([sample(table, key)]) {
                    let text = with_key(&tables, table, key, &value);
                    let place = format!("{file:?} {} = {value}", path_of(table, key));
                    read(file, &text).unwrap_or_else(|e| panic!("{place}: {e}\n{text}"));
                    let json: Value = toml::from_str(&text).unwrap();
                    assert!(accepts(&schema, &schema, &json), "{place}: {json}");
                    keys += 1;
                }
                assert!(!key.description.is_empty(), "{}", path_of(table, key));
                assert!(!key.forms.is_empty(), "{}", path_of(table, key));
            }
        }
        assert!(keys > 20, "{file:?} has {keys}");
    }
}

#[test]
fn an_unknown_key_is_refused_by_reader_and_schema_in_every_table() {
    for file in SettingsFile::ALL {
        let (schema, tables) = (file.schema(), file.tables());
        for table in tables.iter().filter(|t| !t.keys.is_empty()) {
            let mut unknown = tables.clone();
            let key = Key {
                name: "no_such_key".to_owned(),
                description: String::new(),
                forms: Vec::new(),
                default: None,
                required: false,
            };
            let place = unknown.iter().position(|t| t.path == table.path).unwrap();
            unknown[place].keys.push(key.clone());
            let text = with_key(&unknown, table, &key, "1");
            let error = read(file, &text).unwrap_err().to_string();
            assert!(error.contains("unknown field `no_such_key`"), "{error}");
            let json: Value = toml::from_str(&text).unwrap();
            assert!(!accepts(&schema, &schema, &json), "{file:?} {}", table.path);
        }
    }
}

#[test]
fn wrong_forms_are_refused_by_the_schema_as_by_the_reader() {
    let schema = SettingsFile::Campaign.schema();
    for (key, value) in [
        ("image.pixel_m", "\"fine\""),
        ("image.weight", "\"heavy\""),
        ("radar.select", "[1, 2, 3]"),
        ("radar.select", "\"some\""),
        ("preprocess.background", "{ window = 3, components = 2 }"),
        ("preprocess.zero_timing", "{ shift = 1.0 }"),
        ("trajectory.time_offset_s", "\"automatic\""),
        ("image.frequencies", "3.5"),
    ] {
        let filled = [
            Filled::new("radar.file", "\"a.mrm\""),
            Filled::new("image.x_m", "[0, 1]"),
            Filled::new("image.y_m", "[0, 1]"),
            Filled::new(key, value),
        ];
        let text = write("", &SettingsFile::Campaign.tables(), &filled);
        assert!(
            read(SettingsFile::Campaign, &text).is_err(),
            "{key} = {value}"
        );
        let json: Value = toml::from_str(&text).unwrap();
        assert!(!accepts(&schema, &schema, &json), "{key} = {value}");
    }
}

#[test]
fn examples_are_read() {
    for file in SettingsFile::ALL {
        let text = file.example();
        read_and_check(file, &text).unwrap_or_else(|e| panic!("{file:?}: {e}\n{text}"));
        for key in file.tables().iter().flat_map(|t| &t.keys) {
            assert!(text.contains(&format!("{} = ", key.name)), "{}", key.name);
        }
    }
}

#[test]
fn a_key_of_an_open_table_is_set_by_taking_its_comment_sign_away() {
    for file in SettingsFile::ALL {
        let text = file.example();
        let tables = file.tables();
        let lines: Vec<&str> = text.lines().collect();
        let mut tried = 0;
        for table in tables
            .iter()
            .filter(|t| t.may_be_empty && !t.path.is_empty())
        {
            let header = format!("[{}]", table.path);
            let place = lines.iter().position(|line| *line == header);
            let place = place.unwrap_or_else(|| panic!("{file:?}: no line {header}"));
            let is_header = |line: &str| {
                let open = line.trim_start_matches("# ");
                open.starts_with('[') && open.ends_with(']') && !open.contains(' ')
            };
            let below = lines[place + 1..].iter().position(|line| is_header(line));
            let end = below.map_or(lines.len(), |below| place + 1 + below);
            for key in &table.keys {
                let begin = format!("# {} = ", key.name);
                let at = (place..end).find(|k| lines[*k].starts_with(&begin));
                // Those that the example sets stand without the sign.
                let Some(at) = at else { continue };
                let mut edited = lines.clone();
                edited[at] = &lines[at][2..];
                let edited = edited.join("\n");
                read(file, &edited).unwrap_or_else(|e| panic!("{file:?}: {}: {e}", lines[at]));
                tried += 1;
            }
        }
        assert!(tried > 0 || file == SettingsFile::Plan, "{file:?}");
    }
}

/// `UPDATE_REFERENCE=1 cargo test -p acerra --test settings` writes the page again.
#[test]
fn the_reference_is_up_to_date() {
    let file =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/reference.md");
    let page = reference::page();
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, &page).unwrap();
    }
    let written = std::fs::read_to_string(&file).unwrap();
    assert!(
        written == page,
        "docs/guide/reference.md is not what the schemas say; write it again with \
         UPDATE_REFERENCE=1 cargo test -p acerra --test settings"
    );
}
