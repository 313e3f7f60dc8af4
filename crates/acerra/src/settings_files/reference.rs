//! The reference of all keys as a page of the guide.

use std::fmt::Write as _;

use super::SettingsFile;
use super::keys::{Key, Table};
use super::template::toml_of;

/// The page, in Markdown.
#[must_use]
pub fn page() -> String {
    let mut text = String::from(
        "# Reference of every key\n\n\
         This page is generated from the types that read the files (`acerra schema` prints the same \
         as JSON Schema); a test keeps it in step. Unknown keys are refused. Paths are relative to \
         the file. A key without a default is either required or has no value unless it is given.\n",
    );
    for file in SettingsFile::ALL {
        let (title, command) = match file {
            SettingsFile::Campaign => ("Campaign", "acerra focus CAMPAIGN.toml"),
            SettingsFile::Scene => ("Scene", "acerra simulate SCENE.toml -o DIR"),
            SettingsFile::Plan => ("Flight plan", "acerra plan PLAN.toml"),
        };
        let _ = writeln!(text, "\n## {title}: `{command}`");
        for table in file.tables() {
            write_table(&mut text, &table);
        }
    }
    text
}

fn write_table(text: &mut String, table: &Table) {
    let heading = match (table.path.as_str(), table.repeats) {
        ("", _) => "Before the first table".to_owned(),
        (path, true) => format!("`[[{path}]]`"),
        (path, false) => format!("`[{path}]`"),
    };
    let _ = writeln!(text, "\n### {heading}\n");
    if !table.description.is_empty() {
        let _ = writeln!(text, "{}\n", one_line(&table.description));
    }
    if table.keys.is_empty() {
        return;
    }
    text.push_str("| key | value | unit | default | meaning |\n| --- | --- | --- | --- | --- |\n");
    for key in &table.keys {
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} |",
            key.name,
            forms(key),
            key.unit().unwrap_or("–"),
            default(key),
            cell(&meaning(key))
        );
    }
}

fn forms(key: &Key) -> String {
    let forms: Vec<String> = key
        .forms
        .iter()
        .map(|form| format!("`{}`", form.text))
        .collect();
    cell(&forms.join(" or "))
}

fn default(key: &Key) -> String {
    match (&key.default, key.required) {
        (Some(value), _) => cell(&format!("`{}`", toml_of(value))),
        (None, true) => "required".to_owned(),
        (None, false) => "–".to_owned(),
    }
}

fn meaning(key: &Key) -> String {
    let mut text = one_line(&key.description);
    for form in key.forms.iter().filter(|form| !form.meaning.is_empty()) {
        let _ = write!(text, "<br>`{}`: {}", form.text, one_line(&form.meaning));
    }
    text
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A text that does not end its cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
