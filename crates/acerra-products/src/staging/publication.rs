//! Putting staged files in place, all or none.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::names::is_product;

/// A publication in progress, with the data to undo it.
#[derive(Debug)]
pub(super) struct Publication<'a> {
    target: &'a Path,
    /// Directory of the replaced files.
    replaced: PathBuf,
    undo: Vec<Step>,
}

/// One change made in the target.
#[derive(Debug)]
enum Step {
    /// A place that was free is taken.
    Added(OsString),
    /// The file at a place is among the replaced ones.
    Replaced(OsString),
}

/// The place at which something failed, and how.
type Failed = (PathBuf, io::Error);

impl<'a> Publication<'a> {
    /// A publication into `target` that keeps replaced files in `replaced`.
    pub(super) fn new(target: &'a Path, replaced: PathBuf) -> Self {
        Self {
            target,
            replaced,
            undo: Vec::new(),
        }
    }

    /// Moves everything in `files` into the target and `superseded` files out of the target; on failure the
    /// target is unchanged.
    pub(super) fn run(mut self, files: &Path, superseded: &[String]) -> Result<(), Failed> {
        let done = self.attempt(files, superseded);
        if done.is_err() {
            self.roll_back();
        }
        done
    }

    fn attempt(&mut self, files: &Path, superseded: &[String]) -> Result<(), Failed> {
        let list = || -> io::Result<Vec<OsString>> {
            fs::read_dir(files)?
                .map(|entry| Ok(entry?.file_name()))
                .collect()
        };
        let mut names = list().map_err(|error| (self.target.to_owned(), error))?;
        names.sort();
        for name in &names {
            self.place(files, name)
                .map_err(|error| (self.target.join(name), error))?;
        }
        for name in superseded.iter().map(OsString::from) {
            if !names.contains(&name) && is_product(&self.target.join(&name)) {
                self.set_aside(&name)
                    .map_err(|error| (self.target.join(&name), error))?;
            }
        }
        Ok(())
    }

    /// Puts one file or directory in place.
    fn place(&mut self, files: &Path, name: &OsString) -> io::Result<()> {
        let (from, to) = (files.join(name), self.target.join(name));
        match fs::symlink_metadata(&to) {
            Err(_) => self.undo.push(Step::Added(name.clone())),
            Ok(there) if there.is_dir() != from.is_dir() => {
                return Err(if there.is_dir() {
                    io::Error::new(io::ErrorKind::IsADirectory, "a directory is in the way")
                } else {
                    io::Error::new(io::ErrorKind::NotADirectory, "a file is in the way")
                });
            }
            // The older file gets a second name, and the newer file replaces it in one step.
            Ok(there)
                if there.is_file() && fs::hard_link(&to, self.replaced.join(name)).is_ok() =>
            {
                self.undo.push(Step::Replaced(name.clone()));
            }
            Ok(_) => self.set_aside(name)?,
        }
        move_to(&from, &to)
    }

    /// Moves the file at a place to the replaced ones.
    fn set_aside(&mut self, name: &OsString) -> io::Result<()> {
        move_to(&self.target.join(name), &self.replaced.join(name))?;
        self.undo.push(Step::Replaced(name.clone()));
        Ok(())
    }

    fn roll_back(&mut self) {
        for step in self.undo.drain(..).rev() {
            // Whatever else fails now, the rest is put back.
            let _ = match step {
                Step::Added(name) => remove(&self.target.join(name)),
                Step::Replaced(name) => {
                    let place = self.target.join(&name);
                    if place.is_dir() {
                        let _ = fs::remove_dir_all(&place);
                    }
                    move_to(&self.replaced.join(name), &place)
                }
            };
        }
    }
}

fn remove(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        fs::remove_dir_all(path)
    } else {
        fs::remove_file(path)
    }
}

/// Renames, or copies where the two places are on different file systems.
fn move_to(from: &Path, to: &Path) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(error) if error.kind() == io::ErrorKind::CrossesDevices => {
            copy(from, to)?;
            remove(from)
        }
        done => done,
    }
}

/// Copies a file or a directory; files are synchronised before they get their name.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if from.is_dir() {
        fs::create_dir_all(to)?;
        for entry in fs::read_dir(from)? {
            let entry = entry?;
            copy(&entry.path(), &to.join(entry.file_name()))?;
        }
        return Ok(());
    }
    let folder = to.parent().unwrap_or_else(|| Path::new("."));
    let mut aside = tempfile::Builder::new()
        .prefix(".acerra-")
        .tempfile_in(folder)?;
    io::copy(&mut File::open(from)?, aside.as_file_mut())?;
    aside
        .as_file()
        .set_permissions(fs::metadata(from)?.permissions())?;
    aside.as_file().sync_all()?;
    aside.persist(to)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_keeps_content_and_permissions() {
        let folder = tempfile::tempdir().unwrap();
        let (from, to) = (folder.path().join("from"), folder.path().join("to"));
        fs::create_dir_all(from.join("deep")).unwrap();
        fs::write(from.join("deep/file"), "text").unwrap();
        copy(&from, &to).unwrap();
        assert_eq!(fs::read_to_string(to.join("deep/file")).unwrap(), "text");
        let mode = |path: PathBuf| fs::metadata(path).unwrap().permissions();
        assert_eq!(mode(to.join("deep/file")), mode(from.join("deep/file")));
        // No temporary file next to it.
        assert_eq!(fs::read_dir(to.join("deep")).unwrap().count(), 1);
    }
}
