//! The pulse per second of `acerra emulate`.

use std::path::{Path, PathBuf};

use acerra_geo::time::GpsTime;
use acerra_record::emulate::{EmulatedPps, PpsOptions, World};
use anyhow::Context;

use super::values::{number_in, share};

/// Fastest world whose pulses a recorder still sees one by one: it looks 20 times a second.
const FASTEST: f64 = 10.0;

/// Options of the pulse.
#[derive(Debug, clap::Args)]
pub struct PpsArgs {
    /// Write the receiver's pulse per second to FILE, as a kernel's PPS device shows it.
    #[arg(long, value_name = "FILE")]
    pps: Option<PathBuf>,
    /// Time from each second to the edge that is stamped (ms): the pulse's width for its other edge.
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = edge_ms, requires = "pps")]
    pps_edge_ms: f64,
    /// Share of the pulses that are missed.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share, requires = "pps")]
    pps_loss: f64,
}

fn edge_ms(text: &str) -> Result<f64, String> {
    number_in(text, 0.0..=999.0)
}

/// Parameters of the pulses shared with the other instruments.
pub(super) struct Shared<'a> {
    /// The world.
    pub world: &'a World,
    /// GPS time at its beginning; absent where there is no receiver.
    pub starts_at: Option<GpsTime>,
    /// World times from and to which the receiver has no fix (s).
    pub no_fix_s: &'a [[f64; 2]],
    /// Seed of everything random.
    pub seed: u64,
}

impl PpsArgs {
    /// The file that pulses are written to, wherever the session file lies.
    pub(super) fn path(&self) -> anyhow::Result<Option<PathBuf>> {
        let absolute = |file: &PathBuf| {
            std::path::absolute(file).with_context(|| format!("--pps {}", file.display()))
        };
        self.pps.as_ref().map(absolute).transpose()
    }

    /// Starts the pulses, where requested.
    pub(super) fn start(
        &self,
        path: Option<&Path>,
        shared: &Shared<'_>,
    ) -> anyhow::Result<Option<EmulatedPps>> {
        let Some(path) = path else { return Ok(None) };
        anyhow::ensure!(
            shared.world.speed() <= FASTEST,
            "--pps: expected a --speed of {FASTEST} at most, found {}: a recorder looks for pulses 20 times a second",
            shared.world.speed()
        );
        let starts_at = shared
            .starts_at
            .context("--pps: expected a receiver's log (--gnss), or a scene with receivers")?;
        let options = PpsOptions {
            edge_s: 1e-3 * self.pps_edge_ms,
            loss: self.pps_loss,
            no_fix_s: shared.no_fix_s.to_vec(),
            seed: shared.seed,
            ..PpsOptions::new(shared.world.clone(), starts_at)
        };
        let pps = EmulatedPps::start(path, options)
            .with_context(|| format!("--pps {}", path.display()))?;
        Ok(Some(pps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_that_no_recorder_sees_and_those_of_no_receiver_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("pulses");
        let args = PpsArgs {
            pps: Some(file.clone()),
            pps_edge_ms: 0.0,
            pps_loss: 0.0,
        };
        let checked = |speed, starts_at| {
            let shared = Shared {
                world: &World::new(speed),
                starts_at,
                no_fix_s: &[],
                seed: 1,
            };
            let started = args.start(Some(&file), &shared);
            started.map(drop).map_err(|error| error.to_string())
        };
        let first = Some(GpsTime::from_week_tow(2345, 0.0));
        let fast = checked(11.0, first).unwrap_err();
        assert!(
            fast.contains("expected a --speed of 10 at most, found 11"),
            "{fast}"
        );
        assert!(checked(1.0, None).unwrap_err().contains("--gnss"));
        assert!(!file.exists());
        assert_eq!(checked(10.0, first), Ok(()));
        assert!(file.exists());
    }
}
