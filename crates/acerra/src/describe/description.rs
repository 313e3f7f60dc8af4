//! The description of a file: its kind, named facts and notes.

use serde::Serialize;
use serde_json::Value;

/// What was found in a file.
#[derive(Clone, Debug, Serialize)]
pub struct Description {
    /// Kind of file, in words.
    pub kind: String,
    /// Named facts; names carry their units.
    pub facts: serde_json::Map<String, Value>,
    /// Missing or damaged data, and remarks.
    pub notes: Vec<String>,
}

impl Description {
    /// A description without facts and notes.
    pub(super) fn new(kind: impl Into<String>) -> Self {
        Self {
            kind: kind.into(),
            facts: serde_json::Map::new(),
            notes: Vec::new(),
        }
    }

    /// Adds a fact.
    pub(super) fn fact(&mut self, name: &str, value: impl Into<Value>) {
        self.facts.insert(name.to_owned(), value.into());
    }
}
