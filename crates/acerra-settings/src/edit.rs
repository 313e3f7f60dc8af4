//! Changing values of a settings file that a person wrote: comments, order and layout stay.

use std::fmt;

use thiserror::Error;
use toml_edit::{Array, DocumentMut, Item, Table, TomlError};

/// A value to put into a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// A word.
    Word(String),
}

/// One step on the path from the root of a file to a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// The table of this name; made where it is missing.
    Table(String),
    /// The table with this number, from 0, in a list of tables.
    Number(usize),
}

/// A key of a table, and its new value.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// The way to the table.
    pub table: Vec<Step>,
    /// The key.
    pub key: String,
    /// The value.
    pub value: Value,
}

impl Assignment {
    /// A key of a table at the root.
    #[must_use]
    pub fn new(table: &str, key: &str, value: Value) -> Self {
        Self {
            table: vec![Step::Table(table.to_owned())],
            key: key.to_owned(),
            value,
        }
    }

    /// This path below a step taken first.
    #[must_use]
    pub fn below(mut self, mut way: Vec<Step>) -> Self {
        way.append(&mut self.table);
        self.table = way;
        self
    }
}

impl fmt::Display for Assignment {
    /// As messages name keys: `[radar] delay_ns = 10.2`, `[[track]] 2 [radar] delay_ns = 10.2`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut steps = self.table.iter().peekable();
        while let Some(step) = steps.next() {
            match (step, steps.peek()) {
                (Step::Table(name), Some(Step::Number(_))) => write!(f, "[[{name}]] ")?,
                (Step::Table(name), _) => write!(f, "[{name}] ")?,
                (Step::Number(number), _) => write!(f, "{} ", number + 1)?,
            }
        }
        write!(f, "{} = {}", self.key, toml_value(&self.value))
    }
}

/// Reason why a file cannot be changed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EditError {
    /// The text is not TOML.
    #[error(transparent)]
    Syntax(#[from] TomlError),
    /// A value in place of a table, or a list without the entry.
    #[error("{path}: expected a table, found {found}")]
    NotATable {
        /// Where.
        path: String,
        /// Kind of value found there.
        found: &'static str,
    },
}

/// Puts values into the text of a settings file; the remaining text is unchanged.
///
/// # Errors
/// Text that is not TOML, or has something else where a table should be.
///
/// ```
/// use acerra_settings::{Assignment, Value, assign};
/// let text = "[radar] # the P440\nfile = 'a.mrm'\ndelay_ns = 9 # guessed\n";
/// let keys = [
///     Assignment::new("radar", "delay_ns", Value::Number(10.2)),
///     Assignment::new("trajectory", "time_offset_s", Value::Number(0.5)),
/// ];
/// assert_eq!(
///     assign(text, &keys)?,
///     "[radar] # the P440\nfile = 'a.mrm'\ndelay_ns = 10.2 # guessed\n\n\
///      [trajectory]\ntime_offset_s = 0.5\n"
/// );
/// # Ok::<(), acerra_settings::EditError>(())
/// ```
pub fn assign(text: &str, assignments: &[Assignment]) -> Result<String, EditError> {
    let mut document: DocumentMut = text.parse()?;
    for assignment in assignments {
        let mut item = document.as_item_mut();
        let mut path = String::new();
        for step in &assignment.table {
            item = follow(item, step, &mut path)?;
        }
        put(item, assignment, &path)?;
    }
    Ok(document.to_string())
}

fn follow<'a>(
    item: &'a mut Item,
    step: &Step,
    path: &mut String,
) -> Result<&'a mut Item, EditError> {
    match step {
        Step::Table(name) => {
            if !path.is_empty() {
                path.push('.');
            }
            path.push_str(name);
            let found = item.type_name();
            let table = item
                .as_table_like_mut()
                .ok_or_else(|| not_a_table(path, found))?;
            Ok(table
                .entry(name)
                .or_insert_with(|| Item::Table(Table::new())))
        }
        Step::Number(number) => {
            path.push_str(&format!("[{number}]"));
            let found = item.type_name();
            item.get_mut(*number)
                .ok_or_else(|| not_a_table(path, found))
        }
    }
}

/// Replaces a value, with the comments about it, or adds it.
fn put(item: &mut Item, assignment: &Assignment, path: &str) -> Result<(), EditError> {
    let found = item.type_name();
    let table = item
        .as_table_like_mut()
        .ok_or_else(|| not_a_table(path, found))?;
    let mut value = toml_value(&assignment.value);
    if let Some(old) = table.get(&assignment.key).and_then(Item::as_value) {
        *value.decor_mut() = old.decor().clone();
    }
    match table.get_mut(&assignment.key) {
        Some(old) => *old = Item::Value(value),
        None => {
            table.insert(&assignment.key, Item::Value(value));
        }
    }
    Ok(())
}

fn toml_value(value: &Value) -> toml_edit::Value {
    match value {
        Value::Number(number) => (*number).into(),
        Value::Numbers(numbers) => numbers.iter().copied().collect::<Array>().into(),
        Value::Word(word) => word.as_str().into(),
    }
}

fn not_a_table(path: &str, found: &'static str) -> EditError {
    EditError::NotATable {
        path: path.to_owned(),
        found,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_tables_and_inline_tables_are_changed_in_place() {
        let text = "# two flights\n[[track]]\nradar = { file = 'a.mrm' } # west\n\n\
                    [[track]]\n[track.radar]\n  file = 'b.mrm'\n";
        let delay = || Assignment::new("radar", "delay_ns", Value::Number(3.5));
        let below = |k| delay().below(vec![Step::Table("track".to_owned()), Step::Number(k)]);
        assert_eq!(
            assign(text, &[below(0), below(1)]).unwrap(),
            "# two flights\n[[track]]\nradar = { file = 'a.mrm' , delay_ns = 3.5 } # west\n\n\
             [[track]]\n[track.radar]\n  file = 'b.mrm'\ndelay_ns = 3.5\n"
        );
        assert_eq!(below(1).to_string(), "[[track]] 2 [radar] delay_ns = 3.5");
        let missing = assign(text, &[below(2)]).unwrap_err().to_string();
        assert!(
            missing.starts_with("track[2]: expected a table"),
            "{missing}"
        );
    }

    #[test]
    fn what_is_no_table_is_not_overwritten() {
        let arm = Assignment::new("radar", "arm", Value::Numbers(vec![0.1, -0.2]));
        let error = assign("radar = 3\n", std::slice::from_ref(&arm)).unwrap_err();
        assert_eq!(error.to_string(), "radar: expected a table, found integer");
        assert!(assign("radar = [\n", &[arm]).is_err());
    }
}
