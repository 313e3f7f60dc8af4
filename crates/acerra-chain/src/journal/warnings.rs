//! What a run has to say beside its results.

/// Warnings of a run, in the order in which they arose.
#[derive(Clone, Debug, Default)]
pub struct Warnings {
    said: Vec<String>,
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

    /// Adds all of `others`, each once.
    pub fn extend(&mut self, others: Self) {
        others
            .said
            .into_iter()
            .for_each(|warning| self.add(warning));
    }

    /// All of them.
    #[must_use]
    pub fn said(&self) -> &[String] {
        &self.said
    }
}
