//! HDF5: outputs of gprMax, and named arrays (MATLAB 7.3 among them).

mod gprmax;
mod values;

use hdf5_pure::{File, Group};

use self::gprmax::gprmax;
use self::values::{broken, number, read};
use crate::error::FormatError;
use crate::limits::Limits;
use crate::named::{Array, Arrays, traces};
use crate::recording::{Format, Recording};

/// Whether a file is HDF5: its signature is at the beginning, or behind 512 bytes of a MATLAB header.
#[must_use]
pub fn is_hdf5(head: &[u8]) -> bool {
    const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
    [0, 512, 1024, 2048]
        .iter()
        .any(|at| head.get(*at..).is_some_and(|h| h.starts_with(SIGNATURE)))
}

/// Reads HDF5: an output of gprMax, single or merged, or named arrays.
///
/// # Errors
/// A file that is broken, of neither kind, or larger than `limits` admit.
pub fn read_hdf5(bytes: Vec<u8>, limits: &Limits) -> Result<Recording, FormatError> {
    let limits = &limits.justified_by(bytes.len() as u64);
    let file = File::from_bytes(bytes).map_err(|e| broken("the file", e))?;
    let root = file.root();
    let groups = root.groups().map_err(|e| broken("/", e))?;
    let is_gprmax = groups.iter().any(|g| g == "rxs")
        && number(&root.attrs().map_err(|e| broken("/", e))?, "dt").is_some();
    if is_gprmax {
        return gprmax(&root, limits);
    }
    let names = root.datasets().map_err(|e| broken("/", e))?;
    let mut file = Root { root, names };
    traces(&mut file, Format::Hdf5, limits)
}

/// The datasets of the root group.
struct Root {
    root: Group,
    names: Vec<String>,
}

impl Arrays for Root {
    fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    fn array(&mut self, name: &str, limits: &Limits) -> Result<Array, FormatError> {
        let dataset = self.root.dataset(name).map_err(|e| broken(name, e))?;
        let attributes = dataset.attrs().map_err(|e| broken(name, e))?;
        Ok(Array {
            is_column_major: attributes.contains_key("MATLAB_class"),
            ..read(&dataset, name, limits)?
        })
    }
}
