//! `run.json`, as far as a viewer needs it.

use std::path::{Path, PathBuf};

use acerra_chain::campaign::{Campaign, TimeOffset};
use anyhow::{Context, ensure};
use serde_json::Value;

use super::inputs::{Input, relocate};
use crate::error::{EngineError, ViewError};

/// Bytes of a record or list of targets, at most.
const MOST_BYTES: u64 = 64 << 20;

/// The record of a run.
#[derive(Debug)]
pub struct Record {
    /// The whole of it.
    pub json: Value,
    /// Latitude and longitude (degrees) and ellipsoidal height (m) of the frame's origin, where it
    /// is on the Earth.
    pub origin_deg_m: Option<[f64; 3]>,
    /// The files that the run read.
    pub inputs: Vec<Input>,
}

impl Record {
    /// Rows of `trajectory.csv` with which a line or a track begins, other than the first.
    #[must_use]
    pub fn line_starts(&self) -> Vec<usize> {
        let starts = &self.json["traces"]["line_starts"];
        serde_json::from_value(starts.clone()).unwrap_or_default()
    }

    /// Reads `run.json`.
    ///
    /// # Errors
    /// A file that is absent, or no record of a run.
    pub fn read(path: &Path) -> Result<Self, ViewError> {
        let mut json = json(path)?;
        if !json["version"].is_string() || !json["configuration"].is_object() {
            return Err(ViewError::Product {
                path: path.to_owned(),
                cause: anyhow::anyhow!(
                    "expected the record of a run (`version`, `configuration`), found neither"
                ),
            });
        }
        let origin_deg_m = serde_json::from_value(json["frame"]["origin_deg_m"].clone()).ok();
        let inputs = json["inputs"].as_array().into_iter().flatten();
        let inputs = inputs.filter_map(|input| {
            Some(Input {
                path: PathBuf::from(input["path"].as_str()?),
                sha256: input["sha256"].as_str()?.to_owned(),
            })
        });
        let mut inputs: Vec<Input> = inputs.collect();
        let products = path.parent().unwrap_or(path);
        relocate(&mut inputs, &mut json["configuration"], products);
        Ok(Self {
            inputs,
            origin_deg_m,
            json,
        })
    }

    /// The campaign of the run with every choice that was left to the data as it was made.
    ///
    /// # Errors
    /// A configuration that this version does not understand.
    pub fn campaign(&self) -> Result<Campaign, EngineError> {
        let refuse = |cause: &dyn std::fmt::Display| EngineError::Configuration(cause.to_string());
        let mut campaign: Campaign = serde_json::from_value(self.json["configuration"].clone())
            .map_err(|cause| refuse(&cause))?;
        let offset = |value: &Value| value["time_offset_s"].as_f64().map(TimeOffset::Seconds);
        if campaign.track.is_empty() {
            let own = &mut campaign.trajectory.time_offset_s;
            *own = offset(&self.json).or(*own);
        }
        let tracks = self.json["tracks"].as_array().into_iter().flatten();
        for (section, track) in campaign.track.iter_mut().zip(tracks) {
            let own = &mut section.trajectory.time_offset_s;
            *own = offset(track).or(*own);
        }
        Ok(campaign)
    }
}

/// Reads a JSON file.
///
/// # Errors
/// A file that is absent, far too large, or no JSON.
pub fn json(path: &Path) -> Result<Value, ViewError> {
    let read = || -> anyhow::Result<Value> {
        let bytes = std::fs::metadata(path)?.len();
        ensure!(
            bytes <= MOST_BYTES,
            "expected at most {MOST_BYTES} bytes, found {bytes}"
        );
        serde_json::from_slice(&std::fs::read(path)?).context("not JSON")
    };
    read().map_err(|cause| ViewError::Product {
        path: path.to_owned(),
        cause,
    })
}
