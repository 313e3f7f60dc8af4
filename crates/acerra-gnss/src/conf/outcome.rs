//! Outcome of a setting.

use super::error::ConfError;
use super::requested::NotFollowedReason;
use super::setting::Setting;

/// `None` for a setting that is followed, otherwise the reason why it is not.
pub(super) type Outcome = Result<Option<NotFollowedReason>, ConfError>;

/// The setting is followed.
pub(super) const FOLLOWED: Outcome = Ok(None);
/// The value requires a feature that is not supported.
pub(super) const UNSUPPORTED: Outcome = Ok(Some(NotFollowedReason::Unsupported));
/// The key does not exist.
pub(super) const UNKNOWN: Outcome = Ok(Some(NotFollowedReason::UnknownKey));

/// `Followed` if the value is in `harmless`, the values without effect in this program.
pub(super) fn only(setting: &Setting, harmless: &[&str]) -> Outcome {
    if harmless.contains(&setting.value.as_str()) {
        FOLLOWED
    } else {
        UNSUPPORTED
    }
}
