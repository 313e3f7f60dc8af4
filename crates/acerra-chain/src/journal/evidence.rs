//! The findings of a run.

use serde::Serialize;

use super::finding::{Finding, Verdict};

/// The findings of a run, in the order of its stages.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Evidence {
    findings: Vec<Finding>,
}

impl Evidence {
    /// Adds a finding.
    pub fn add(&mut self, finding: Finding) {
        self.findings.push(finding);
    }

    /// All findings.
    #[must_use]
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The worst verdict; none of an empty list.
    #[must_use]
    pub fn worst(&self) -> Option<Verdict> {
        self.findings.iter().map(|finding| finding.verdict).max()
    }

    /// Findings with this verdict.
    pub fn with(&self, verdict: Verdict) -> impl Iterator<Item = &Finding> {
        self.findings
            .iter()
            .filter(move |finding| finding.verdict == verdict)
    }

    /// One line: the number of findings that agree, and the names of the others.
    ///
    /// ```
    /// use acerra_chain::findings::{Evidence, Finding};
    /// let mut evidence = Evidence::default();
    /// evidence.add(Finding::compared("surface_delay", 0.1, 0.0, 0.2, "ns"));
    /// evidence.add(Finding::compared("coupling_delay", 9.0, 1.0, 1.0, "ns"));
    /// assert_eq!(evidence.summary(), "1 of 2 findings agree; contradicts: coupling_delay");
    /// ```
    #[must_use]
    pub fn summary(&self) -> String {
        let agreeing = self.with(Verdict::Agrees).count();
        let mut line = format!("{agreeing} of {} findings agree", self.findings.len());
        for (verdict, word) in [
            (Verdict::Contradicts, "contradicts"),
            (Verdict::Doubtful, "doubtful"),
        ] {
            let names: Vec<&str> = self.with(verdict).map(|f| f.name.as_str()).collect();
            if !names.is_empty() {
                line.push_str(&format!("; {word}: {}", names.join(", ")));
            }
        }
        line
    }
}
