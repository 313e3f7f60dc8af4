//! The rows above the data of a Motive export: which columns belong to which rigid body.
//!
//! Format 1.23 labels its rows (`Type`, `Name`, `ID`). Format 1.22 leaves the labels blank, or the
//! whole rows: then a row of types is one that holds a known type, names follow types, and a body
//! without a name is a run of columns X Y Z W X Y Z (rotation, then position).

use super::ReadError;

/// Types of columns.
const KINDS: [&str; 6] = [
    "Rigid Body",
    "Rigid Body Marker",
    "Marker",
    "Bone",
    "Bone Marker",
    "Skeleton",
];

/// Content of a column.
const PROPERTIES: [&str; 4] = [
    "Rotation",
    "Position",
    "Mean Marker Error",
    "Marker Quality",
];

/// Where the chosen body's numbers are.
pub(super) struct BodyColumns {
    pub time: usize,
    pub position: [usize; 3],
    /// X, Y, Z, W.
    pub rotation: Option<[usize; 4]>,
}

/// The rows above the data.
#[derive(Default)]
pub(super) struct Header {
    pub entries: Vec<(String, String)>,
    kinds: Vec<String>,
    names: Vec<String>,
    properties: Vec<String>,
    identities_seen: bool,
}

impl Header {
    pub fn entry(&self, key: &str) -> Option<&str> {
        let found = self
            .entries
            .iter()
            .find(|(k, _)| k.eq_ignore_ascii_case(key));
        found.map(|(_, v)| v.as_str())
    }

    /// Reads one of the rows between the first line and the row of axes, recognised by its label or, where
    /// that is blank, by its content.
    pub fn add_row(&mut self, cells: &[&str]) {
        let owned = || cells.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>();
        let holds = |words: &[&str]| cells.iter().skip(2).any(|cell| words.contains(cell));
        match cells.get(1).copied().unwrap_or_default() {
            "Type" => self.kinds = owned(),
            "Name" => self.names = owned(),
            "ID" | "Parent" => self.identities_seen = true,
            _ if holds(&PROPERTIES) => self.properties = owned(),
            _ if holds(&KINDS) && self.kinds.is_empty() => self.kinds = owned(),
            _ if cells.iter().all(|cell| cell.is_empty()) => {}
            // Names follow types; identities, which are not used, follow names.
            _ if !self.kinds.is_empty() && self.names.is_empty() && !self.identities_seen => {
                self.names = owned();
            }
            _ => {}
        }
    }

    /// Where no rigid body has a name, names each run of columns that has the axes of one
    /// (X Y Z W X Y Z: rotation, then position) after its columns. Returns the first and last
    /// column, from 1, if there is exactly one.
    pub fn infer_bodies(&mut self, axes: &[&str]) -> Option<[usize; 2]> {
        const AXES: [&str; 7] = ["X", "Y", "Z", "W", "X", "Y", "Z"];
        if !self.names_of("Rigid Body").is_empty() {
            return None;
        }
        for row in [&mut self.kinds, &mut self.names, &mut self.properties] {
            row.resize(axes.len().max(row.len()), String::new());
        }
        let agrees = |cell: &str, wanted: &str| cell.is_empty() || cell == wanted;
        let property = |k: usize| if k < 4 { "Rotation" } else { "Position" };
        let mut found = Vec::new();
        let mut at = 0;
        while at + AXES.len() <= axes.len() {
            let is_body = axes[at..at + AXES.len()] == AXES
                && (0..AXES.len()).all(|k| {
                    agrees(&self.kinds[at + k], "Rigid Body")
                        && agrees(&self.names[at + k], "")
                        && agrees(&self.properties[at + k], property(k))
                });
            if !is_body {
                at += 1;
                continue;
            }
            let columns = [at + 1, at + AXES.len()];
            for k in 0..AXES.len() {
                self.kinds[at + k] = "Rigid Body".to_owned();
                self.names[at + k] = format!("columns {}-{}", columns[0], columns[1]);
                self.properties[at + k] = property(k).to_owned();
            }
            found.push(columns);
            at += AXES.len();
        }
        match found[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    /// Names of columns of a kind, each once, in order.
    fn names_of(&self, kind: &str) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for (k, name) in self.kinds.iter().zip(&self.names) {
            if k == kind && !name.is_empty() && !names.contains(name) {
                names.push(name.clone());
            }
        }
        names
    }

    pub fn choose(&self, wanted: Option<&str>) -> Result<(String, &'static str), ReadError> {
        let bodies = self.names_of("Rigid Body");
        match wanted {
            Some(wanted) => {
                for kind in ["Rigid Body", "Marker"] {
                    if self.names_of(kind).iter().any(|name| name == wanted) {
                        return Ok((wanted.to_owned(), kind));
                    }
                }
                Err(ReadError::NoSuchBody {
                    wanted: wanted.to_owned(),
                    names: bodies,
                })
            }
            None => match <[String; 1]>::try_from(bodies) {
                Ok([only]) => Ok((only, "Rigid Body")),
                Err(names) if names.is_empty() => Err(ReadError::NoSuchBody {
                    wanted: "(any)".to_owned(),
                    names,
                }),
                Err(names) => Err(ReadError::SeveralBodies { names }),
            },
        }
    }

    /// The columns of a body: `axes` is the line that begins with `Frame`.
    pub fn columns(
        &self,
        line: u64,
        axes: &[&str],
        name: &str,
        kind: &str,
    ) -> Result<BodyColumns, ReadError> {
        let time = axes
            .iter()
            .position(|a| a.to_ascii_lowercase().starts_with("time"))
            .ok_or_else(|| ReadError::Header {
                line,
                problem: "no column of time".to_owned(),
            })?;
        let column = |property: &str, axis: &str| {
            (0..axes.len()).find(|&i| {
                let is = |row: &[String], what: &str| row.get(i).is_some_and(|cell| cell == what);
                is(&self.kinds, kind)
                    && is(&self.names, name)
                    && is(&self.properties, property)
                    && axes[i] == axis
            })
        };
        let position = ["X", "Y", "Z"].map(|axis| column("Position", axis));
        let [Some(x), Some(y), Some(z)] = position else {
            let problem = format!("no columns of position X, Y, Z for '{name}'");
            return Err(ReadError::Header { line, problem });
        };
        let rotation = match ["X", "Y", "Z", "W"].map(|axis| column("Rotation", axis)) {
            [Some(x), Some(y), Some(z), Some(w)] => Some([x, y, z, w]),
            _ => None,
        };
        Ok(BodyColumns {
            time,
            position: [x, y, z],
            rotation,
        })
    }
}
