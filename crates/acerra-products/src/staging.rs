//! Products that are complete or absent: everything is written aside, then put in place.

mod area;
mod publication;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;

use area::{Area, Areas};
use publication::Publication;

pub use area::discard_unfinished;

/// Files being written for a directory. Dropping it without [`Staging::publish`] removes them.
#[derive(Debug)]
pub struct Staging {
    area: Area,
    target: PathBuf,
    superseded: Vec<String>,
    made: MadeFolders,
}

impl Staging {
    /// Makes the staging area: within `target` where that exists, so that both are on one file system, else
    /// next to `target`. The files of an existing `target` are replaced on publication by those of the same
    /// names; other files in it are unchanged. Areas of killed runs at either place are removed.
    ///
    /// # Errors
    /// `target` is a file, or cannot be written.
    pub fn new(target: &Path) -> anyhow::Result<Self> {
        if target.exists() && !target.is_dir() {
            anyhow::bail!("{}: expected a directory, found a file", target.display());
        }
        let mut made = MadeFolders::default();
        let parent = parent_of(target);
        let place = if target.is_dir() {
            area::remove_leftovers(parent);
            target
        } else {
            made.make(parent)
                .with_context(|| format!("{}: cannot make the directory", parent.display()))?;
            parent
        };
        let area = Area::new(place, &made.0)
            .with_context(|| format!("{}: cannot write here", place.display()))?;
        Ok(Self {
            area,
            target: target.to_owned(),
            superseded: Vec::new(),
            made,
        })
    }

    /// Lets publication remove `names` from the directory unless they are written again: products
    /// of an older run that this one does not make.
    pub fn supersede(&mut self, names: impl IntoIterator<Item = String>) {
        self.superseded.extend(names);
    }

    /// Directory in which files are written until they are published.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        self.area.files()
    }

    /// Path at which to write the file that will be called `name`.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.area.files().join(name)
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
    /// The directory cannot be written; it is then left as it was.
    pub fn publish(mut self) -> anyhow::Result<()> {
        let failed = |path: &Path| format!("{}: cannot put the products in place", path.display());
        let _held = Areas::hold().with_context(|| failed(&self.target))?;
        if !self.target.exists() && fs::rename(self.area.files(), &self.target).is_ok() {
            self.made.keep();
            return Ok(());
        }
        self.made
            .make(&self.target)
            .with_context(|| failed(&self.target))?;
        let publication = Publication::new(&self.target, self.area.replaced());
        publication
            .run(&self.area.files(), &self.superseded)
            .map_err(|(place, error)| anyhow::Error::new(error).context(failed(&place)))?;
        self.made.keep();
        Ok(())
    }
}

/// A single file being written for its place. Dropping it without [`StagedFile::publish`] removes
/// it.
#[derive(Debug)]
pub struct StagedFile(Place);

/// Destination of a single file.
#[derive(Debug)]
enum Place {
    /// A file is written aside.
    Aside(Staging),
    /// A device or a pipe takes the bytes as they are, and is not replaced.
    Stream { path: PathBuf, bytes: Vec<u8> },
}

impl StagedFile {
    /// Writes `content` aside for the file `path`.
    ///
    /// # Errors
    /// The directory of `path` is absent or cannot be written, or `content` fails.
    pub fn write(
        path: &Path,
        content: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>,
    ) -> anyhow::Result<Self> {
        let place = || format!("{}: cannot write", path.display());
        let name = path
            .file_name()
            .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file"))
            .with_context(place)?;
        if fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
            let mut bytes = Vec::new();
            content(&mut bytes).with_context(place)?;
            let path = path.to_owned();
            return Ok(Self(Place::Stream { path, bytes }));
        }
        let folder = parent_of(path);
        if !folder.is_dir() {
            return Err(io::Error::from(io::ErrorKind::NotFound)).with_context(place);
        }
        let staging = Staging::new(folder).with_context(place)?;
        let file = fs::File::create(staging.folder().join(name)).with_context(place)?;
        let mut buffer = BufWriter::new(file);
        content(&mut buffer)
            .and_then(|()| Ok(buffer.flush()?))
            .with_context(place)?;
        Ok(Self(Place::Aside(staging)))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// The place cannot be written; its earlier content is then unchanged.
    pub fn publish(self) -> anyhow::Result<()> {
        match self.0 {
            Place::Aside(staging) => staging.publish(),
            Place::Stream { path, bytes } => fs::OpenOptions::new()
                .write(true)
                .open(&path)
                .and_then(|mut stream| stream.write_all(&bytes))
                .with_context(|| format!("{}: cannot write", path.display())),
        }
    }
}

/// The directory that a path lies in.
fn parent_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Directories made on the way to a target; removed again unless they are kept.
#[derive(Debug, Default)]
struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    fn make(&mut self, folder: &Path) -> io::Result<()> {
        let absent = folder
            .ancestors()
            .take_while(|f| !f.as_os_str().is_empty() && !f.exists());
        // The deepest first.
        self.0.splice(0..0, absent.map(Path::to_owned));
        fs::create_dir_all(folder)
    }

    fn keep(&mut self) {
        self.0.clear();
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        area::remove_empty(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn nothing_is_left_of_a_failed_run() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("deep/products");
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
        assert_eq!(names(&target), ["notes.txt", "run.json"]);
        assert_eq!(fs::read_dir(target.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn superseded_products_go_unless_they_are_written_anew() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["looks.npz", "image.npz", "notes.txt"] {
            fs::write(folder.path().join(name), "old").unwrap();
        }
        let mut staging = Staging::new(folder.path()).unwrap();
        staging.supersede(["looks.npz", "image.npz", "volume.npz"].map(str::to_owned));
        staging.write("image.npz", "new").unwrap();
        staging.publish().unwrap();
        assert_eq!(names(folder.path()), ["image.npz", "notes.txt"]);
        let image = fs::read_to_string(folder.path().join("image.npz")).unwrap();
        assert_eq!(image, "new");
    }

    #[test]
    fn a_publication_that_fails_leaves_the_older_products() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["image.npz", "looks.npz"] {
            fs::write(folder.path().join(name), "old").unwrap();
        }
        fs::create_dir(folder.path().join("run.json")).unwrap();
        let mut staging = Staging::new(folder.path()).unwrap();
        staging.supersede(["looks.npz".to_owned()]);
        for name in ["image.npz", "new.png", "run.json"] {
            staging.write(name, "new").unwrap();
        }
        let message = format!("{:#}", staging.publish().unwrap_err());
        assert!(message.contains("run.json: cannot put"), "{message}");
        assert_eq!(names(folder.path()), ["image.npz", "looks.npz", "run.json"]);
        for name in ["image.npz", "looks.npz"] {
            let text = fs::read_to_string(folder.path().join(name)).unwrap();
            assert_eq!(text, "old", "{name}");
        }
    }

    #[test]
    fn a_file_in_the_way_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("taken");
        fs::write(&target, "").unwrap();
        let message = Staging::new(&target).unwrap_err().to_string();
        assert!(message.contains("taken: expected a directory"), "{message}");
    }

    #[test]
    fn single_files_are_whole_or_absent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.pos");
        let broken = StagedFile::write(&path, |to| {
            to.write_all(b"half")?;
            anyhow::bail!("no more")
        });
        assert!(broken.is_err() && names(folder.path()).is_empty());
        let whole = StagedFile::write(&path, |to| Ok(to.write_all(b"whole")?)).unwrap();
        whole.publish().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
        assert_eq!(names(folder.path()), ["flight.pos"]);
        #[cfg(unix)]
        {
            use std::os::unix::fs::FileTypeExt;
            let device = Path::new("/dev/null");
            let nothing = StagedFile::write(device, |to| Ok(to.write_all(b"text")?)).unwrap();
            nothing.publish().unwrap();
            assert!(fs::metadata(device).unwrap().file_type().is_char_device());
        }
        let absent = folder.path().join("absent/flight.pos");
        assert!(StagedFile::write(&absent, |_| Ok(())).is_err());
    }
}
