//! The campaigns that are run.

use std::path::{Path, PathBuf};

use acerra_simulate::demo::{TRACK_1, TRACK_2};
use acerra_simulate::scene::Scene;
use acerra_simulate::write::simulate_campaign;

use crate::spectra::Spectra;

/// A campaign to run.
pub struct Case {
    /// Its name in the table.
    pub name: &'static str,
    /// Whether it begins with logs, or with spectra at known places.
    pub is_of_logs: bool,
    content: Content,
}

enum Content {
    Simulated(&'static str),
    Spectra { pixels: u32, points: usize },
}

impl Case {
    /// All of them, in the order of the table.
    pub fn all() -> [Self; 4] {
        let logs = |name, scene| Self {
            name,
            is_of_logs: true,
            content: Content::Simulated(scene),
        };
        [
            logs("track-1", TRACK_1),
            logs("track-2", TRACK_2),
            Self::of_spectra("spectra-1000", 1000, 10),
            Self::of_spectra("spectra-1800", 1800, 40),
        ]
    }

    /// Images of growing size, with as many points in proportion.
    pub fn sizes() -> [Self; 4] {
        [
            Self::of_spectra("spectra-1000", 1000, 10),
            Self::of_spectra("spectra-2000", 2000, 40),
            Self::of_spectra("spectra-4000", 4000, 160),
            Self::of_spectra("spectra-8000", 8000, 640),
        ]
    }

    /// Spectra whose image is `pixels` squared.
    const fn of_spectra(name: &'static str, pixels: u32, points: usize) -> Self {
        Self {
            name,
            is_of_logs: false,
            content: Content::Spectra { pixels, points },
        }
    }

    /// Writes logs and campaign into a folder; the campaign's file.
    pub fn write(&self, folder: &Path) -> PathBuf {
        match self.content {
            Content::Simulated(scene) => {
                let scene = Scene::parse(scene).unwrap();
                for file in simulate_campaign(&scene).unwrap().files {
                    std::fs::write(folder.join(&file.name), &file.bytes).unwrap();
                }
                folder.join("campaign.toml")
            }
            Content::Spectra { pixels, points } => Spectra::new(pixels, points).write(folder),
        }
    }
}
