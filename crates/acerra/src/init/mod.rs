//! From logs to a commented campaign: the kind of each file, and its contents.
//!
//! ```text
//! files ──look──► Logs ──assign──► radar, positions ──compose──► campaign text
//!                        rover/base by motion, places, times
//! ```

mod answers;
mod compose;
mod gnss;
mod ground;
mod lines;
mod logs;
mod receivers;
mod sounding;

use std::path::{Path, PathBuf};

use anyhow::Context;

pub use compose::compose;
pub use lines::expanded;
pub use logs::Logs;

/// Path of `file` in a campaign in `folder`: relative to the folder where the file lies below it.
///
/// # Errors
/// A path that is not UTF-8, which TOML cannot hold.
fn named_in(folder: &Path, file: &Path) -> anyhow::Result<String> {
    let absolute = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let (folder, file) = (absolute(folder), absolute(file));
    let named: PathBuf = file
        .strip_prefix(&folder)
        .map_or_else(|_| file.clone(), Path::to_owned);
    named.to_str().map(str::to_owned).with_context(|| {
        format!(
            "{}: a campaign cannot name a path that is not UTF-8",
            named.display()
        )
    })
}
