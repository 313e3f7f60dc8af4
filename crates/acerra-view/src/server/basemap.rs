//! Map tiles under the image: from a server that the user names, or from a directory.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::{RequestError, ViewError};

/// Map tiles under the image.
#[derive(Clone, Debug, Serialize)]
pub struct Basemap {
    /// Address of a tile with `{z}`, `{x}` and `{y}`.
    template: String,
    #[serde(skip)]
    source: Source,
}

/// Source of tiles.
#[derive(Clone, Debug)]
enum Source {
    /// Another server: its scheme and host, as a content security policy names them.
    Web(String),
    /// A directory with files `z/x/y.png` and the like.
    Directory(PathBuf),
}

/// Endings of tiles in a directory, and their types.
const KINDS: [(&str, &str); 4] = [
    ("png", "image/png"),
    ("jpg", "image/jpeg"),
    ("jpeg", "image/jpeg"),
    ("webp", "image/webp"),
];

impl Basemap {
    /// Map tiles at an address of the web, or in a directory.
    ///
    /// # Errors
    /// An address that lacks a part, or a directory that is not there.
    pub fn find(given: &str) -> Result<Self, ViewError> {
        let refused = || ViewError::Basemap {
            found: given.to_owned(),
        };
        if Path::new(given).is_dir() {
            return Ok(Self {
                template: "map/{z}/{x}/{y}".to_owned(),
                source: Source::Directory(PathBuf::from(given)),
            });
        }
        let is_plain = |text: &str| {
            let allowed = |c: char| c.is_ascii_alphanumeric() || "-.:_[]".contains(c);
            !text.is_empty() && text.chars().all(allowed)
        };
        let (scheme, rest) = given.split_once("://").ok_or_else(refused)?;
        let (host, path) = rest.split_once('/').ok_or_else(refused)?;
        let has_all = ["{z}", "{x}", "{y}"].iter().all(|part| path.contains(part));
        if !["http", "https"].contains(&scheme) || !is_plain(host) || !has_all {
            return Err(refused());
        }
        Ok(Self {
            template: given.to_owned(),
            source: Source::Web(format!("{scheme}://{host}")),
        })
    }

    /// The other server, as a content security policy names it.
    pub fn origin(&self) -> Option<&str> {
        match &self.source {
            Source::Web(origin) => Some(origin),
            Source::Directory(_) => None,
        }
    }

    /// A tile of a directory: its type and its bytes.
    ///
    /// # Errors
    /// No such tile, or an unreadable one.
    pub fn tile(&self, [z, x, y]: [u32; 3]) -> Result<(&'static str, Vec<u8>), RequestError> {
        let absent = RequestError::Absent { what: "map tile" };
        let Source::Directory(folder) = &self.source else {
            return Err(absent);
        };
        let column = folder.join(z.to_string()).join(x.to_string());
        for (ending, kind) in KINDS {
            let name = format!("{y}.{ending}");
            match std::fs::read(column.join(&name)) {
                Ok(picture) => return Ok((kind, picture)),
                Err(cause) if cause.kind() == ErrorKind::NotFound => {}
                Err(cause) => {
                    let name = format!("{z}/{x}/{name}");
                    return Err(RequestError::File { name, cause });
                }
            }
        }
        Err(absent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_that_lack_a_part_and_absent_directories_are_refused() {
        for wrong in [
            "ftp://tiles.example/{z}/{x}/{y}",
            "https://tiles.example/{z}/{x}",
            "https:///{z}/{x}/{y}",
            "https://a; script-src */{z}/{x}/{y}",
            "tiles/{z}/{x}/{y}",
            "/nowhere/at/all",
        ] {
            assert!(Basemap::find(wrong).is_err(), "{wrong}");
        }
        let folder = tempfile::tempdir().unwrap();
        let map = Basemap::find(folder.path().to_str().unwrap()).unwrap();
        assert_eq!(
            (map.origin(), map.template.as_str()),
            (None, "map/{z}/{x}/{y}")
        );
    }
}
