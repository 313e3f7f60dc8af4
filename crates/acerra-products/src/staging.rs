//! A product directory that is complete or absent: everything is written aside, then renamed.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;

/// Files being written beside their final directory. Dropping it without [`Staging::publish`]
/// removes them.
#[derive(Debug)]
pub struct Staging {
    aside: tempfile::TempDir,
    target: PathBuf,
}

impl Staging {
    /// Makes the place aside. `target` may exist; its own files are then replaced one by one on
    /// publication, and others in it are left alone.
    ///
    /// # Errors
    /// `target` is a file, or its parent cannot be written.
    pub fn new(target: &Path) -> anyhow::Result<Self> {
        if target.exists() && !target.is_dir() {
            anyhow::bail!("{}: expected a directory, found a file", target.display());
        }
        let parent = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        fs::create_dir_all(parent)
            .with_context(|| format!("{}: cannot make the directory", parent.display()))?;
        let aside = tempfile::Builder::new()
            .prefix(".acerra-")
            .tempdir_in(parent)
            .with_context(|| format!("{}: cannot write here", parent.display()))?;
        Ok(Self {
            aside,
            target: target.to_owned(),
        })
    }

    /// Where files are written until they are published.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.aside.path()
    }

    /// Where to write the file that will be called `name`.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.aside.path().join(name)
    }

    /// Writes a whole file.
    ///
    /// # Errors
    /// The disk is full or not writable.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
        fs::write(self.path(name), bytes)
            .with_context(|| format!("{}: cannot write", self.target.join(name).display()))
    }

    /// Moves the files to their directory.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn publish(self) -> anyhow::Result<()> {
        let failed = |path: &Path| format!("{}: cannot put the products in place", path.display());
        if self.target.exists() {
            for entry in fs::read_dir(self.aside.path()).with_context(|| failed(&self.target))? {
                let entry = entry?;
                let place = self.target.join(entry.file_name());
                fs::rename(entry.path(), &place).with_context(|| failed(&place))?;
            }
        } else {
            fs::rename(self.aside.path(), &self.target).with_context(|| failed(&self.target))?;
            open_to_others(&self.target).with_context(|| failed(&self.target))?;
        }
        Ok(())
    }
}

/// Gives a directory that was made private (as temporary ones are) the usual permissions.
#[cfg(unix)]
fn open_to_others(directory: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(directory, fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn open_to_others(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_of_a_failed_run() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("products");
        let staging = Staging::new(&target).unwrap();
        staging.write("image.npz", b"half").unwrap();
        drop(staging);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn publishing_replaces_its_own_files_and_leaves_others() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("deep/products");
        for text in ["first", "second"] {
            let staging = Staging::new(&target).unwrap();
            staging.write("run.json", text).unwrap();
            staging.publish().unwrap();
            fs::write(target.join("notes.txt"), "mine").unwrap();
        }
        assert_eq!(
            fs::read_to_string(target.join("run.json")).unwrap(),
            "second"
        );
        assert_eq!(
            fs::read_to_string(target.join("notes.txt")).unwrap(),
            "mine"
        );
        assert_eq!(fs::read_dir(target.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_in_the_way_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("taken");
        fs::write(&target, "").unwrap();
        let message = Staging::new(&target).unwrap_err().to_string();
        assert!(message.contains("taken: expected a directory"), "{message}");
    }
}
