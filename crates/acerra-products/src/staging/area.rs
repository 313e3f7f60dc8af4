//! Directories in which files are written aside.
//!
//! An area is locked as long as its process lives. A process that ends in order removes its areas; the area
//! of a killed process is no longer locked and is removed by the next process that makes an area in the same
//! directory.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

/// Prefix of the name of an area.
const PREFIX: &str = ".acerra-";
/// The file in an area that its process holds locked.
const LOCK: &str = "lock";
/// The directory in an area that holds the files.
const FILES: &str = "files";
/// The directory in an area with the files that publication replaces.
const REPLACED: &str = "replaced";
/// A process makes and locks an area well within this time.
const TIME_TO_LOCK: Duration = Duration::from_secs(60);
/// Number of attempts to make an area that another process removes as a leftover.
const ATTEMPTS: usize = 8;

/// The areas of this process that are not removed yet.
static AREAS: Mutex<Areas> = Mutex::new(Areas {
    unfinished: Vec::new(),
    ended: false,
});

/// The areas of a process.
#[derive(Debug)]
pub(super) struct Areas {
    unfinished: Vec<Unfinished>,
    ended: bool,
}

/// An area in use.
#[derive(Debug)]
struct Unfinished {
    folder: PathBuf,
    /// Directories made on the way to it, the deepest first.
    made: Vec<PathBuf>,
}

impl Areas {
    /// Exclusive access: while it is held, [`discard_unfinished`] waits.
    ///
    /// # Errors
    /// The process is about to end.
    pub(super) fn hold() -> io::Result<MutexGuard<'static, Self>> {
        let areas = AREAS.lock().unwrap_or_else(PoisonError::into_inner);
        if areas.ended {
            return Err(io::Error::new(
                io::ErrorKind::Interrupted,
                "the run was interrupted",
            ));
        }
        Ok(areas)
    }
}

/// Removes the unpublished files of this process and prevents further publication: for a process that is
/// about to end. A publication in progress is waited for.
pub fn discard_unfinished() {
    let mut areas = AREAS.lock().unwrap_or_else(PoisonError::into_inner);
    areas.ended = true;
    for Unfinished { folder, made } in areas.unfinished.drain(..) {
        // Threads still at work find no path to write to under the other name.
        let ended = folder.with_extension("ended");
        let folder = match fs::rename(&folder, &ended) {
            Ok(()) => ended,
            Err(_) => folder,
        };
        // Files that cannot be removed are left to the next run.
        let _ = fs::remove_dir_all(folder);
        remove_empty(&made);
    }
}

/// Removes directories that are empty, in the order given.
pub(super) fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        // Fails on those that are not.
        let _ = fs::remove_dir(folder);
    }
}

/// A locked directory with a place for files; removed when dropped.
#[derive(Debug)]
pub(super) struct Area {
    folder: PathBuf,
    /// Open, and locked where the file system has locks.
    _lock: File,
}

impl Area {
    /// Makes an area in `parent` after removing the leftovers of killed processes there. `made` are
    /// the directories made on the way to it, the deepest first: they go with it when the process is
    /// interrupted.
    ///
    /// # Errors
    /// `parent` cannot be written, or the process is about to end.
    pub(super) fn new(parent: &Path, made: &[PathBuf]) -> io::Result<Self> {
        remove_leftovers(parent);
        let mut areas = Areas::hold()?;
        for _ in 0..ATTEMPTS {
            if let Some(area) = Self::attempt(parent)? {
                areas.unfinished.push(Unfinished {
                    folder: area.folder.clone(),
                    made: made.to_owned(),
                });
                return Ok(area);
            }
        }
        Err(io::Error::other(
            "other processes remove the files written there",
        ))
    }

    /// `None` where another process was faster to take the new directory for a leftover.
    fn attempt(parent: &Path) -> io::Result<Option<Self>> {
        let folder = tempfile::Builder::new()
            .prefix(PREFIX)
            .tempdir_in(parent)?
            .keep();
        let locked = File::create(folder.join(LOCK)).and_then(|lock| match lock.try_lock() {
            Err(TryLockError::WouldBlock) => Err(io::ErrorKind::WouldBlock.into()),
            // File systems without locks: leftovers cannot be recognised there, and are not removed.
            Ok(()) | Err(TryLockError::Error(_)) => fs::create_dir(folder.join(FILES))
                .and_then(|()| fs::create_dir(folder.join(REPLACED)))
                .map(|()| lock),
        });
        match locked {
            Ok(lock) => Ok(Some(Self {
                folder,
                _lock: lock,
            })),
            Err(error) => {
                let gone = !folder.exists() || error.kind() == io::ErrorKind::WouldBlock;
                let _ = fs::remove_dir_all(&folder);
                if gone { Ok(None) } else { Err(error) }
            }
        }
    }

    /// Directory in which files are written.
    pub(super) fn files(&self) -> PathBuf {
        self.folder.join(FILES)
    }

    /// Directory in which publication keeps the replaced files.
    pub(super) fn replaced(&self) -> PathBuf {
        self.folder.join(REPLACED)
    }
}

impl Drop for Area {
    fn drop(&mut self) {
        let mut areas = AREAS.lock().unwrap_or_else(PoisonError::into_inner);
        areas.unfinished.retain(|one| one.folder != self.folder);
        // Files that cannot be removed are left to the next run.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Removes the areas in `parent` whose processes are gone. Areas that cannot be read or removed stay.
pub(super) fn remove_leftovers(parent: &Path) {
    let Ok(entries) = fs::read_dir(parent) else {
        return;
    };
    for entry in entries.flatten() {
        let named = entry
            .file_name()
            .as_encoded_bytes()
            .starts_with(PREFIX.as_bytes());
        if named && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            remove_if_left_over(&entry.path());
        }
    }
}

fn remove_if_left_over(folder: &Path) {
    match File::open(folder.join(LOCK)) {
        Ok(lock) => {
            // The lock is held until all is removed, so that nobody else begins to.
            if lock.try_lock().is_ok() {
                let _ = fs::remove_dir_all(folder);
            }
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let age = fs::metadata(folder)
                .and_then(|m| m.modified())
                .ok()
                .and_then(|made| SystemTime::now().duration_since(made).ok());
            if age.is_some_and(|age| age > TIME_TO_LOCK) {
                // Succeeds on an empty directory alone.
                let _ = fs::remove_dir(folder);
            }
        }
        Err(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_of_the_living_stay_and_those_of_the_dead_go() {
        let parent = tempfile::tempdir().unwrap();
        let living = Area::new(parent.path(), &[]).unwrap();
        let dead = parent.path().join(".acerra-dead");
        fs::create_dir_all(dead.join(FILES)).unwrap();
        fs::write(dead.join(LOCK), "").unwrap();
        fs::write(dead.join(FILES).join("image.npz"), "half").unwrap();
        let foreign = parent.path().join(".acerra-foreign");
        fs::create_dir(&foreign).unwrap();
        fs::write(foreign.join("notes"), "mine").unwrap();
        let second = Area::new(parent.path(), &[]).unwrap();
        assert!(living.files().is_dir() && second.files().is_dir());
        assert!(!dead.exists() && foreign.join("notes").is_file());
        drop((living, second));
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 1);
    }
}
