//! Paths in written text, with U+FFFD in place of bytes that are not UTF-8.

use std::path::{Path, PathBuf};

use serde::Serializer;

/// Serialises a path, whatever bytes it has.
pub fn path<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// `path_text` for a path that may be absent.
pub fn optional<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    match path {
        Some(found) => serializer.serialize_some(&found.to_string_lossy()),
        None => serializer.serialize_none(),
    }
}

/// `path_text` for several paths.
pub fn list<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStringExt;

    #[derive(serde::Serialize)]
    struct Paths {
        #[serde(serialize_with = "path")]
        one: PathBuf,
        #[serde(serialize_with = "optional")]
        other: Option<PathBuf>,
        #[serde(serialize_with = "list")]
        more: Vec<PathBuf>,
    }

    #[test]
    fn bytes_that_are_no_text_are_written_all_the_same() {
        let odd = PathBuf::from(std::ffi::OsString::from_vec(b"caf\xe9".to_vec()));
        let text = toml::to_string(&Paths {
            one: odd.clone(),
            other: Some(odd.clone()),
            more: vec![odd],
        });
        let expected = "one = \"caf\u{fffd}\"\nother = \"caf\u{fffd}\"\nmore = [\"caf\u{fffd}\"]\n";
        assert_eq!(text.unwrap(), expected);
    }
}
