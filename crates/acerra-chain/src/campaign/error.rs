//! Errors of a campaign file.

/// A campaign file that cannot be used. The caller adds the file's path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CampaignError {
    /// Not TOML, an unknown key, or a value of the wrong form.
    #[error(transparent)]
    Syntax(#[from] acerra_settings::SyntaxError),
    /// A value outside its possible range.
    #[error(transparent)]
    Value(#[from] acerra_settings::ValueError),
    /// Two keys that exclude each other.
    #[error("{first} and {second} exclude each other: {reason}")]
    Conflict {
        /// One of them.
        first: &'static str,
        /// The other.
        second: &'static str,
        /// Why.
        reason: &'static str,
    },
}

/// Refuses two keys or tables that exclude each other, where `both` are there.
pub(super) fn exclude_if(
    both: bool,
    [first, second]: [&'static str; 2],
    reason: &'static str,
) -> Result<(), CampaignError> {
    if both {
        return Err(CampaignError::Conflict {
            first,
            second,
            reason,
        });
    }
    Ok(())
}
