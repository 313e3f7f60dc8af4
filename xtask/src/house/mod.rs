//! The house: which crate and which file imports which, read from the sources.
//!
//! A crate's level is one of [`LEVELS`]; its dependencies within the workspace must have a lower level. A
//! file imports another where it names an item that the other defines, by a `use` or by a path; a re-export
//! (`pub use`) is no import. Tests are left out: a test may use any item.
//!
//! The rooms of a crate are the folders and files directly under its `src`. Rooms of the crates of
//! [`ORDERED`] import one another in one direction only, so that they have an order.

mod circles;
mod imports;
mod modules;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

use modules::ModuleTree;

/// The crates' levels, from ARCHITECTURE.md.
pub const LEVELS: [(&str, u32); 25] = [
    ("acerra-control", 0),
    ("acerra-geo", 0),
    ("acerra-npz", 0),
    ("acerra-settings", 0),
    ("acerra-figure", 0),
    ("acerra-formats", 1),
    ("acerra-autopilot", 1),
    ("acerra-cphd", 1),
    ("acerra-cubes", 1),
    ("acerra-maps", 1),
    ("acerra-gnss", 1),
    ("acerra-radar", 1),
    ("acerra-imaging", 1),
    ("acerra-autofocus", 2),
    ("acerra-flightplan", 2),
    ("acerra-invert", 2),
    ("acerra-record", 2),
    ("acerra-simulate", 2),
    ("acerra-chain", 3),
    ("acerra-live", 4),
    ("acerra-products", 4),
    ("acerra-view", 5),
    ("acerra-python", 6),
    ("acerra", 6),
    ("xtask", 7),
];

/// Crates whose rooms have an order: no room imports from one above it.
pub const ORDERED: [&str; 2] = ["acerra-chain", "acerra-gnss"];

/// Something wrong with the house.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A crate that [`LEVELS`] does not know.
    UnknownCrate(String),
    /// A crate that depends on one of its own level or above.
    Upwards {
        /// The crate.
        from: String,
        /// What it depends on.
        to: String,
    },
    /// Files that import each other, directly or through others.
    Circle(Vec<PathBuf>),
    /// Rooms of a crate of [`ORDERED`] that import one another, with the imports between them.
    RoomCircle {
        /// The rooms.
        rooms: Vec<PathBuf>,
        /// Pairs of files, importing and imported, of different rooms.
        imports: Vec<(PathBuf, PathBuf)>,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownCrate(name) => write!(f, "{name}: no level is stated for this crate"),
            Self::Upwards { from, to } => {
                write!(f, "{from} depends on {to}, which is not on a lower level")
            }
            Self::Circle(files) => {
                write!(f, "these files import one another:")?;
                files
                    .iter()
                    .try_for_each(|file| write!(f, "\n  {}", file.display()))
            }
            Self::RoomCircle { rooms, imports } => {
                write!(f, "these rooms import one another:")?;
                for room in rooms {
                    write!(f, " {}", room.display())?;
                }
                imports.iter().try_for_each(|(from, to)| {
                    write!(f, "\n  {} imports {}", from.display(), to.display())
                })
            }
        }
    }
}

/// Crates and files with their imports.
#[derive(Clone, Debug, Default)]
pub struct House {
    dependencies: BTreeMap<String, BTreeSet<String>>,
    imports: BTreeMap<PathBuf, BTreeSet<PathBuf>>,
}

impl House {
    /// Reads the workspace at `root`.
    ///
    /// # Errors
    /// A manifest or a source file that cannot be read or parsed.
    pub fn read(root: &Path) -> anyhow::Result<Self> {
        let mut house = Self::default();
        let mut folders: Vec<PathBuf> = fs::read_dir(root.join("crates"))
            .with_context(|| format!("{}: expected a folder crates", root.display()))?
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<Result<_, _>>()?;
        folders.push(root.join("xtask"));
        folders.retain(|folder| folder.join("Cargo.toml").is_file());
        folders.sort();
        for folder in folders {
            house.add_crate(root, &folder)?;
        }
        Ok(house)
    }

    fn add_crate(&mut self, root: &Path, folder: &Path) -> anyhow::Result<()> {
        let manifest = folder.join("Cargo.toml");
        let at = || manifest.display().to_string();
        let text = fs::read_to_string(&manifest).with_context(at)?;
        let table: toml::Table = text.parse().with_context(at)?;
        let name = table
            .get("package")
            .and_then(|package| package.get("name")?.as_str())
            .with_context(at)?;
        let inside = |table: &toml::Table| -> BTreeSet<String> {
            let listed = table.get("dependencies").and_then(toml::Value::as_table);
            let names = listed.into_iter().flat_map(toml::Table::keys);
            names
                .filter(|name| name.starts_with("acerra"))
                .cloned()
                .collect()
        };
        self.dependencies.insert(name.to_owned(), inside(&table));
        for start in ["src/lib.rs", "src/main.rs"] {
            let file = folder.join(start);
            if file.is_file() {
                let tree = ModuleTree::read(&file)?;
                for (from, to) in imports::between_files(&tree) {
                    let short = |path: &Path| path.strip_prefix(root).unwrap_or(path).to_owned();
                    self.imports
                        .entry(short(&from))
                        .or_default()
                        .insert(short(&to));
                }
                for file in tree.files() {
                    let short = file.strip_prefix(root).unwrap_or(file).to_owned();
                    self.imports.entry(short).or_default();
                }
            }
        }
        Ok(())
    }

    /// Source files.
    #[must_use]
    pub fn files(&self) -> usize {
        self.imports.len()
    }

    /// Pairs of files of which one imports the other.
    #[must_use]
    pub fn imports(&self) -> usize {
        self.imports.values().map(BTreeSet::len).sum()
    }

    /// Rooms of each crate of [`ORDERED`] that is at hand, those that import others first.
    #[must_use]
    pub fn folders(&self) -> Vec<(&'static str, Vec<String>)> {
        let name_of = |room: PathBuf| {
            let name = room.file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        };
        let rooms = |name: &str| {
            let order = circles::order(&self.rooms_of(name));
            order.into_iter().map(name_of).collect::<Vec<_>>()
        };
        let named = ORDERED.into_iter().map(|name| (name, rooms(name)));
        named.filter(|(_, rooms)| !rooms.is_empty()).collect()
    }

    /// Which room of a crate imports which.
    fn rooms_of(&self, name: &str) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
        let mut rooms: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
        for (from, imported) in &self.imports {
            let Some(own) = room_of(name, from) else {
                continue;
            };
            let others = imported.iter().filter_map(|to| room_of(name, to));
            let others: Vec<PathBuf> = others.filter(|other| *other != own).collect();
            rooms.entry(own).or_default().extend(others);
        }
        rooms
    }

    /// Circles among the rooms of a crate.
    fn room_circles(&self, name: &str) -> Vec<Fault> {
        let found = circles::circles(&self.rooms_of(name));
        let with_imports = |rooms: Vec<PathBuf>| {
            let within = |file: &Path| room_of(name, file).filter(|room| rooms.contains(room));
            let mut imports = Vec::new();
            for (from, imported) in &self.imports {
                let Some(own) = within(from) else { continue };
                let other = imported
                    .iter()
                    .filter(|to| within(to).is_some_and(|r| r != own));
                imports.extend(other.map(|to| (from.clone(), to.clone())));
            }
            Fault::RoomCircle { rooms, imports }
        };
        found.into_iter().map(with_imports).collect()
    }

    /// Everything that is wrong.
    #[must_use]
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let level = |name: &str| LEVELS.iter().find(|(known, _)| *known == name);
        for (from, to) in &self.dependencies {
            let Some((_, own)) = level(from) else {
                faults.push(Fault::UnknownCrate(from.clone()));
                continue;
            };
            for to in to {
                if level(to).is_none_or(|(_, other)| other >= own) {
                    faults.push(Fault::Upwards {
                        from: from.clone(),
                        to: to.clone(),
                    });
                }
            }
        }
        faults.extend(
            circles::circles(&self.imports)
                .into_iter()
                .map(Fault::Circle),
        );
        faults.extend(ORDERED.iter().flat_map(|name| self.room_circles(name)));
        faults
    }
}

/// The room of a crate that holds `file`: a folder or a file directly under `src`. The crate's root file
/// belongs to no room, as it re-exports names of all rooms.
fn room_of(name: &str, file: &Path) -> Option<PathBuf> {
    let source = Path::new("crates").join(name).join("src");
    let first = file.strip_prefix(&source).ok()?.iter().next()?;
    let room = Path::new(first).with_extension("");
    (room != Path::new("lib")).then(|| source.join(room))
}
