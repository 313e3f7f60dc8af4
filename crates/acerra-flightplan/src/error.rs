//! Reasons for the absence of a plan.

/// Reason why a plan file gives no plan. The caller adds the file's path.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// Not TOML, an unknown key, or a value of the wrong form.
    #[error(transparent)]
    Syntax(#[from] acerra_settings::SyntaxError),
    /// A value outside its possible range.
    #[error("[{table}] {key}: expected {expected}, found {found}")]
    Value {
        /// Table of the key.
        table: &'static str,
        /// The key.
        key: &'static str,
        /// Possible values.
        expected: &'static str,
        /// Statement of the file.
        found: String,
    },
    /// A raster of heights that cannot be read.
    #[error("[area] terrain: {}: {cause}", path.display())]
    Terrain {
        /// The file.
        path: std::path::PathBuf,
        /// Fault of the input.
        cause: String,
    },
    /// A mission that cannot be written.
    #[error("mission: {0}")]
    Write(String),
    /// Each value is possible, but their combination is not.
    #[error("{0}")]
    Impossible(String),
}
