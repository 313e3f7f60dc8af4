//! Identity of the input: size and SHA-256 of every input file.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

/// One input file, as `run.json` records it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InputFile {
    /// Path as the run used it.
    #[serde(serialize_with = "crate::read::path_text::path")]
    pub path: PathBuf,
    /// Size.
    pub bytes: u64,
    /// SHA-256 in lower-case hexadecimal digits.
    pub sha256: String,
    /// Sources used, where the file holds several: the log of an autopilot or a robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sources: Option<String>,
}

impl InputFile {
    /// Reads the file once and records it.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn record(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let mut hasher = Sha256::new();
        let mut buffer = vec![0; 1 << 16];
        let mut bytes = 0;
        loop {
            let read = file.read(&mut buffer)?;
            if read == 0 {
                break;
            }
            hasher.update(&buffer[..read]);
            bytes += read as u64;
        }
        let sha256 = hasher
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        Ok(Self {
            path: path.to_owned(),
            bytes,
            sha256,
            sources: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_standard() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").unwrap();
        let input = InputFile::record(&path).unwrap();
        assert_eq!(input.bytes, 3);
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            input.sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
