//! Tables and keys of a settings file, read off its JSON Schema.

use serde_json::{Map, Value};

/// A table of a settings file.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its name in the file, such as `gnss.rover`; empty for the keys before the first table.
    pub path: String,
    /// Whether it may be several times: `[[corner]]`.
    pub repeats: bool,
    /// Whether the file must have it.
    pub required: bool,
    /// Whether a file with the table empty is equivalent to one without it.
    pub may_be_empty: bool,
    /// What it holds.
    pub description: String,
    /// Its keys, tables not among them.
    pub keys: Vec<Key>,
}

/// A key of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: String,
    /// What it says.
    pub description: String,
    /// The forms of its value, such as `"all"`, `"moving"` and `[integer, integer]`, each with its meaning,
    /// where given.
    pub forms: Vec<Form>,
    /// The value that holds where the key is absent; none where there is no value then.
    pub default: Option<Value>,
    /// Whether its table must have it.
    pub required: bool,
}

/// One form of a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// How it is written.
    pub text: String,
    /// What it means.
    pub meaning: String,
}

impl Key {
    /// The unit of its value, which its name ends with.
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        const UNITS: [(&str, &str); 24] = [
            ("_per_m2", "1/m²"),
            ("_per_hour", "1/h"),
            ("_deg_m", "°, °, m"),
            ("_m_s2", "m/s²"),
            ("_m_s", "m/s"),
            ("_s_m", "S/m"),
            ("_m2", "m²"),
            ("_ghz", "GHz"),
            ("_hz", "Hz"),
            ("_ns", "ns"),
            ("_ps", "ps"),
            ("_min", "min"),
            ("_ppm", "ppm"),
            ("_deg", "°"),
            ("_dbsm", "dB over 1 m²"),
            ("_dbm", "dBm"),
            ("_dbi", "dBi"),
            ("_db", "dB"),
            ("_counts", "counts"),
            ("_s", "s"),
            ("_m", "m"),
            ("clock_drift", "s/s"),
            ("clock_drift_walk", "1/√s"),
            ("_gpst", "GPS time"),
        ];
        UNITS
            .iter()
            .find_map(|(end, unit)| self.name.ends_with(end).then_some(*unit))
    }
}

/// All tables of a schema, outer before inner, in the order of its properties.
#[must_use]
pub fn tables(schema: &Value) -> Vec<Table> {
    let reader = Reader { root: schema };
    let mut tables = Vec::new();
    let first = Table {
        path: String::new(),
        repeats: false,
        required: true,
        may_be_empty: true,
        description: String::new(),
        keys: Vec::new(),
    };
    reader.read(first, schema, &mut tables);
    tables.retain(|table| !(table.path.is_empty() && table.keys.is_empty()));
    tables
}

struct Reader<'a> {
    root: &'a Value,
}

impl<'a> Reader<'a> {
    /// Reads the properties of `schema` into `table`, and the tables below it after it.
    fn read(&self, mut table: Table, schema: &'a Value, tables: &mut Vec<Table>) {
        let nothing = Map::new();
        let properties = schema["properties"].as_object().unwrap_or(&nothing);
        let is_required = |name: &str| {
            let required = schema["required"].as_array();
            required.is_some_and(|list| list.iter().any(|one| one == name))
        };
        let mut below = Vec::new();
        for (name, property) in properties {
            let required = is_required(name);
            if let Some((inner, repeats)) = self.table(property) {
                let path = match table.path.as_str() {
                    "" => name.clone(),
                    outer => format!("{outer}.{name}"),
                };
                let inner_table = Table {
                    path,
                    repeats,
                    required,
                    may_be_empty: table.may_be_empty && property["default"].is_object(),
                    description: self.description(property, inner),
                    keys: Vec::new(),
                };
                below.push((inner_table, inner));
            } else {
                table.keys.push(Key {
                    name: name.clone(),
                    description: self.description(property, self.resolved(property)),
                    forms: self.forms(property),
                    default: property.get("default").filter(|d| !d.is_null()).cloned(),
                    required,
                });
            }
        }
        tables.push(table);
        for (inner_table, inner) in below {
            self.read(inner_table, inner, tables);
        }
    }

    /// The schema that a reference, or an option of one, points to.
    fn resolved(&self, schema: &'a Value) -> &'a Value {
        if let Some(path) = schema["$ref"].as_str() {
            let found = path.strip_prefix('#').and_then(|p| self.root.pointer(p));
            return found.map_or(schema, |found| self.resolved(found));
        }
        match schema["anyOf"].as_array().map(Vec::as_slice) {
            Some([some, none]) if none["type"] == "null" => self.resolved(some),
            _ => schema,
        }
    }

    /// The schema of a table and whether it repeats; none for other values.
    fn table(&self, property: &'a Value) -> Option<(&'a Value, bool)> {
        let schema = self.resolved(property);
        let is_table = |s: &Value| s["properties"].is_object();
        if is_table(schema) {
            return Some((schema, false));
        }
        let items = self.resolved(schema.get("items")?);
        is_table(items).then_some((items, true))
    }

    /// Paragraphs, one a line.
    fn description(&self, property: &Value, resolved: &Value) -> String {
        let own = [property, resolved]
            .into_iter()
            .find_map(|schema| schema["description"].as_str());
        let paragraphs = own.unwrap_or_default().split("\n\n");
        paragraphs.map(joined).collect::<Vec<_>>().join("\n")
    }

    /// The forms of a value: one, or those to choose from with their meanings.
    fn forms(&self, property: &'a Value) -> Vec<Form> {
        let schema = self.resolved(property);
        for key in ["anyOf", "oneOf"] {
            if let Some(list) = schema[key].as_array() {
                return list.iter().flat_map(|one| self.choice(one)).collect();
            }
        }
        if let Some(list) = schema["enum"].as_array() {
            return list.iter().map(|one| form(one.to_string())).collect();
        }
        let text = match schema.get("const") {
            Some(constant) => Some(constant.to_string()),
            None => self.plain(schema),
        };
        text.map(form).into_iter().collect()
    }

    /// One of several forms, with its meaning.
    fn choice(&self, schema: &'a Value) -> Vec<Form> {
        let mut forms = self.forms(schema);
        if let [form] = forms.as_mut_slice() {
            form.meaning = joined(schema["description"].as_str().unwrap_or_default());
        }
        forms
    }

    /// A number, a text, a list or an inline table.
    fn plain(&self, schema: &'a Value) -> Option<String> {
        let kind = match &schema["type"] {
            Value::Array(kinds) => kinds.iter().find(|k| *k != "null")?.as_str()?,
            kind => kind.as_str()?,
        };
        Some(match kind {
            "array" => self.list(schema),
            "object" => {
                let properties = schema["properties"].as_object()?;
                let inner: Vec<String> = properties
                    .iter()
                    .map(|(name, value)| Some(format!("{name} = {}", self.text(value)?)))
                    .collect::<Option<_>>()?;
                format!("{{ {} }}", inner.join(", "))
            }
            "string" => "text".to_owned(),
            "boolean" => "true or false".to_owned(),
            other => other.to_owned(),
        })
    }

    fn list(&self, schema: &'a Value) -> String {
        let each = schema
            .get("items")
            .and_then(|items| self.text(items))
            .unwrap_or_else(|| "value".to_owned());
        match (schema["minItems"].as_u64(), schema["maxItems"].as_u64()) {
            (Some(least), Some(most)) if least == most => {
                let all: Vec<&str> = (0..most).map(|_| each.as_str()).collect();
                format!("[{}]", all.join(", "))
            }
            _ => format!("[{each}, …]"),
        }
    }

    fn text(&self, schema: &'a Value) -> Option<String> {
        let forms: Vec<String> = self.forms(schema).into_iter().map(|f| f.text).collect();
        (!forms.is_empty()).then(|| forms.join(" or "))
    }
}

/// A paragraph on one line.
fn joined(paragraph: &str) -> String {
    paragraph.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn form(text: String) -> Form {
    Form {
        text,
        meaning: String::new(),
    }
}
