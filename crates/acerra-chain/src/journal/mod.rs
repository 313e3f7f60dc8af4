//! Record of a run in addition to its results. The caller owns the record, so that remarks of a stage are
//! kept when a later stage fails.

pub mod evidence;
pub mod finding;
pub mod stages;
pub mod warnings;

use self::evidence::Evidence;
use self::stages::Stages;
use self::warnings::Warnings;

/// Cost of the stages, warnings and evidence of a run.
#[derive(Debug, Default)]
pub struct Journal {
    /// Cost of each stage.
    pub stages: Stages,
    /// Warnings of the stages.
    pub warnings: Warnings,
    /// Findings on the settings, judged.
    pub evidence: Evidence,
}

impl Journal {
    /// Runs one stage inside a `tracing` span of its name, and records its cost and warnings whether
    /// it succeeds or not.
    ///
    /// # Errors
    /// Errors of the stage itself.
    pub fn stage<T, E>(
        &mut self,
        name: &'static str,
        stage: impl FnOnce(&mut Warnings) -> Result<T, E>,
    ) -> Result<T, E> {
        let Self {
            stages, warnings, ..
        } = self;
        stages.run(name, || stage(warnings))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_outlive_the_stage_that_failed() {
        let mut journal = Journal::default();
        let failed: Result<(), &str> = journal.stage("read", |warnings| {
            warnings.add("half of the log is missing");
            Err("the file ends here")
        });
        assert!(failed.is_err());
        assert_eq!(journal.warnings.said(), ["half of the log is missing"]);
        // A stage entered twice is one stage.
        let _: Result<(), ()> = journal.stage("read", |_| Ok(()));
        assert_eq!(journal.stages.done().len(), 1);
    }
}
