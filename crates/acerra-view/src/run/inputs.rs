//! The files that a run read, and their places now.

use std::path::{Path, PathBuf};

use serde_json::Value;

/// A file that the run read.
#[derive(Clone, Debug)]
pub struct Input {
    /// Place of the file: its original one, or next to products that were moved with it.
    pub path: PathBuf,
    /// SHA-256 in lower-case hexadecimal digits.
    pub sha256: String,
}

/// Resolves inputs that are named relative to another directory, in the list and in the record's
/// configuration. Products are usually near their logs: the directory in which the run was started is
/// searched among those above the products, and used where every relative name is a file. Names that already
/// lead to files, or to none in any directory, are unchanged.
pub(super) fn relocate(inputs: &mut [Input], configuration: &mut Value, products: &Path) {
    // The campaign file may be gone: its settings are in the record.
    let logs = inputs.get(1..).unwrap_or_default();
    let relative: Vec<PathBuf> = logs
        .iter()
        .map(|input| input.path.clone())
        .filter(|path| path.is_relative())
        .collect();
    let are_files = |base: &Path| relative.iter().all(|path| base.join(path).is_file());
    if relative.is_empty() || are_files(Path::new("")) {
        return;
    }
    let Ok(products) = products.canonicalize() else {
        return;
    };
    let Some(base) = products.ancestors().find(|base| are_files(base)) else {
        return;
    };
    for input in inputs.iter_mut().filter(|i| i.path.is_relative()) {
        input.path = base.join(&input.path);
    }
    put_under(base, &relative, configuration);
}

/// The resolution for every text of a configuration that is one of the names.
fn put_under(base: &Path, relative: &[PathBuf], value: &mut Value) {
    match value {
        Value::String(text) => {
            let path = Path::new(text.as_str());
            if relative.iter().any(|name| name == path) {
                *text = base.join(path).to_string_lossy().into_owned();
            }
        }
        Value::Array(values) => values.iter_mut().for_each(|v| put_under(base, relative, v)),
        Value::Object(map) => map.values_mut().for_each(|v| put_under(base, relative, v)),
        Value::Null | Value::Bool(_) | Value::Number(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn input(path: &str) -> Input {
        Input {
            path: PathBuf::from(path),
            sha256: String::new(),
        }
    }

    #[test]
    fn names_relative_to_where_the_run_was_started_lead_to_the_logs() {
        let home = tempfile::tempdir().unwrap();
        let home = home.path().canonicalize().unwrap();
        let products = home.join("flights/one/products");
        std::fs::create_dir_all(&products).unwrap();
        std::fs::write(home.join("flights/one/radar.mrm"), b"log").unwrap();
        let mut inputs = [
            input("flights/one/campaign.toml"),
            input("flights/one/radar.mrm"),
        ];
        let mut configuration = json!({"radar": {"file": "flights/one/radar.mrm", "delay_ns": 10}});
        relocate(&mut inputs, &mut configuration, &products);
        let log = home.join("flights/one/radar.mrm");
        assert_eq!(inputs[1].path, log);
        assert_eq!(configuration["radar"]["file"], json!(log));
        assert_eq!(configuration["radar"]["delay_ns"], json!(10));
    }

    #[test]
    fn names_that_lead_nowhere_stay_as_they_are() {
        let home = tempfile::tempdir().unwrap();
        let mut inputs = [input("campaign.toml"), input("no-such-log.mrm")];
        let mut configuration = json!({"radar": {"file": "no-such-log.mrm"}});
        let before = configuration.clone();
        relocate(&mut inputs, &mut configuration, home.path());
        assert_eq!(inputs[1].path, Path::new("no-such-log.mrm"));
        assert_eq!(configuration, before);
    }
}
