//! Remarks of a run on its results.

/// Warnings and notes of a run, in the order in which they arose. A warning may question the result; a note
/// reports harmless omissions.
#[derive(Clone, Debug, Default)]
pub struct Warnings {
    said: Vec<String>,
    notes: Vec<String>,
}

impl Warnings {
    /// Adds a warning, once.
    pub fn add(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        if !self.said.contains(&warning) {
            self.said.push(warning);
        }
    }

    /// Adds a warning that counts something, if there is anything to count.
    pub fn count(&mut self, count: usize, what: impl std::fmt::Display) {
        if count > 0 {
            self.add(format!("{count} {what}"));
        }
    }

    /// Adds a note, once.
    pub fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Adds all of `others`, each once.
    pub fn extend(&mut self, others: Self) {
        others.notes.into_iter().for_each(|note| self.note(note));
        others
            .said
            .into_iter()
            .for_each(|warning| self.add(warning));
    }

    /// All warnings.
    #[must_use]
    pub fn said(&self) -> &[String] {
        &self.said
    }

    /// All notes.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}
