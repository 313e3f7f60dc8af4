//! The names of products, which distinguish an older run's files from a user's.

use std::path::Path;

use serde_json::Value;

/// Every file that a run may write into its directory; `data.zarr` is a directory.
pub const PRODUCTS: [&str; 33] = [
    "autofocus.png",
    "data.h5",
    "data.zarr",
    "flight.geojson",
    "image-absolute-db.tfw",
    "image-absolute-db.tif",
    "image-complex.tfw",
    "image-complex.tif",
    "image-db.qml",
    "image-db.tfw",
    "image-db.tif",
    "image-power.tfw",
    "image-power.tif",
    "image-uncorrected.png",
    "image.kmz",
    "image.npz",
    "image.png",
    "image.vti",
    "looks.npz",
    "multilook.png",
    "radargram-raw.png",
    "radargram.png",
    "report.html",
    "run.json",
    "spectra.cphd",
    "targets.geojson",
    "targets.json",
    "trajectory-uncorrected.csv",
    "trajectory.csv",
    "volume-front.png",
    "volume-side.png",
    "volume.npz",
    "volume.vti",
];

/// The products of an older run that may be in `directory`; none unless its `run.json` is there and names
/// Acerra as its writer.
#[must_use]
pub fn of_older_run(directory: &Path) -> Vec<String> {
    let run: Option<Value> = std::fs::read(directory.join("run.json"))
        .ok()
        .and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let ours = run.is_some_and(|run| {
        ["version", "configuration", "stages"]
            .iter()
            .all(|key| run.get(key).is_some())
    });
    if ours {
        PRODUCTS.map(str::to_owned).to_vec()
    } else {
        Vec::new()
    }
}

/// Whether a product is at this place: a file, or the directory of a Zarr group.
#[must_use]
pub(crate) fn is_product(place: &Path) -> bool {
    place.is_file() || place.join("zarr.json").is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_known_by_their_run_json_alone() {
        let folder = tempfile::tempdir().unwrap();
        assert!(of_older_run(folder.path()).is_empty());
        let write = |text: &str| std::fs::write(folder.path().join("run.json"), text).unwrap();
        write("{\"name\": \"another tool's\"}");
        assert!(of_older_run(folder.path()).is_empty());
        write("{\"version\": \"0.1.0\", \"configuration\": {}, \"stages\": []}");
        assert!(of_older_run(folder.path()).contains(&"looks.npz".to_owned()));
    }
}
