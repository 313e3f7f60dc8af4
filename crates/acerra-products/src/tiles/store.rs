//! The tiles of a run on disk: a Zarr group in its directory.

use std::fs;
use std::path::{Path, PathBuf};

use acerra_chain::Pixels;
use acerra_chain::campaign::Campaign;
use acerra_chain::focus::sink::SinkError;
use acerra_chain::focus::tiles::{TilePlan, Tiling};
use acerra_chain::read::inputs::InputFile;
use acerra_cubes::{Attribute, Dataset, TiledArray, Variable, ZarrGroup};
use anyhow::{Context, bail, ensure};
use num_complex::Complex32;
use serde::Deserialize;
use serde_json::{Value, json};

use super::probe::Probe;

/// The group's name in the directory of the products.
const NAME: &str = "tiles.zarr";
/// The attribute that names the run of the tiles.
const RUN: &str = "run";

/// The tiles of one run.
#[derive(Debug)]
pub struct TileStore {
    folder: PathBuf,
    array: TiledArray,
    tiling: Tiling,
}

/// Identity of a run of tiles: the program, the bytes of its inputs, and the additions of the command line.
pub fn identity(campaign: &Campaign, inputs: &[InputFile]) -> String {
    let digests: Vec<&str> = inputs.iter().map(|input| input.sha256.as_str()).collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "autofocus": campaign.autofocus.enabled,
        "inputs": digests,
    })
    .to_string()
}

impl TileStore {
    /// The store in `directory`, made where there is none.
    ///
    /// # Errors
    /// A store of another run, a directory that cannot be written.
    pub fn make(directory: &Path, pixels: &Pixels, identity: String) -> anyhow::Result<Self> {
        let folder = directory.join(NAME);
        if !folder.exists() {
            let failed = || format!("{}: cannot write", folder.display());
            fs::create_dir_all(directory).with_context(failed)?;
            lay_out(directory, &folder, pixels, &identity).with_context(failed)?;
        }
        Self::open(directory, pixels, &identity)
    }

    /// Refuses a directory without tiles of this run.
    ///
    /// # Errors
    /// The file is absent, or another run's.
    pub fn check(directory: &Path, identity: &str) -> anyhow::Result<()> {
        let folder = directory.join(NAME);
        let place = folder.display();
        let path = folder.join("zarr.json");
        ensure!(
            path.is_file(),
            "{place}: expected tiles made by `acerra focus --tiles K/N`, found none"
        );
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let group: Value =
            serde_json::from_str(&text).with_context(|| path.display().to_string())?;
        let found = group["attributes"][RUN].as_str().unwrap_or_default();
        if found != identity {
            bail!(
                "{place}: expected tiles of this campaign, its inputs and this version, found another \
                 run's; remove them, or name another directory with -o"
            );
        }
        Ok(())
    }

    /// The store that is in `directory`.
    ///
    /// # Errors
    /// The file is absent, or another run's.
    pub fn open(directory: &Path, pixels: &Pixels, identity: &str) -> anyhow::Result<Self> {
        Self::check(directory, identity)?;
        let folder = directory.join(NAME);
        let tiling = Tiling::of(pixels);
        Ok(Self {
            array: TiledArray::of(&folder, "image", &shape(pixels), tiling.per_tile),
            folder,
            tiling,
        })
    }

    /// Place.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Division of the image into tiles.
    pub fn tiling(&self) -> Tiling {
        self.tiling
    }

    /// Whether tile `k` is there.
    pub fn holds(&self, k: usize) -> bool {
        self.array.holds(k)
    }

    /// The tiles that are not there.
    pub fn missing(&self) -> impl Iterator<Item = usize> {
        (0..self.tiling.count()).filter(|k| !self.holds(*k))
    }

    /// Refuses to go on without every tile.
    ///
    /// # Errors
    /// Tiles are missing.
    pub fn ensure_complete(&self) -> anyhow::Result<()> {
        if let Some(first) = self.missing().next() {
            bail!(
                "{}: {} of {} tiles are missing, the first is tile {}; run `acerra focus --tiles` of their \
                 shares",
                self.folder.display(),
                self.missing().count(),
                self.tiling.count(),
                first + 1
            );
        }
        Ok(())
    }

    /// Writes a tile, its plan's record, and samples of the data used.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn put(
        &self,
        k: usize,
        values: &[Complex32],
        plan: &TilePlan,
        probe: &Probe,
    ) -> anyhow::Result<()> {
        let path = self.plan_path(k);
        let failed = || format!("{}: cannot write", path.display());
        let text = json!({
            "plan": plan.plan,
            "promised_bytes": plan.promised_bytes,
            "checked_error": plan.checked_error,
            "data": probe,
        });
        fs::write(&path, format!("{text:#}\n")).with_context(failed)?;
        self.array
            .write(k, values)
            .with_context(|| format!("{}: tile {}", self.folder.display(), k + 1))
    }

    /// The values of a tile.
    ///
    /// # Errors
    /// A file that cannot be read, or is of another length.
    pub fn tile(&self, k: usize) -> Result<Vec<Complex32>, SinkError> {
        self.array.read(k).map_err(|cause| SinkError {
            place: format!("{}: tile {}", self.folder.display(), k + 1),
            cause: cause.into(),
        })
    }

    /// The records of the plans of all tiles.
    ///
    /// # Errors
    /// A file that cannot be read; a tile that was made of other data than `probe` samples.
    pub fn plans(&self, probe: &Probe) -> anyhow::Result<Vec<TilePlan>> {
        (0..self.tiling.count())
            .map(|k| {
                let path = self.plan_path(k);
                let failed = || path.display().to_string();
                let text = fs::read_to_string(&path).with_context(failed)?;
                let said: Value = serde_json::from_str(&text).with_context(failed)?;
                let made_of = Probe::deserialize(&said["data"]).with_context(failed)?;
                ensure!(
                    made_of.agrees(probe),
                    "{}: tile {} was made of other positions or spectra than this process finds: a search \
                     had another result on another machine; state [trajectory] time_offset_s and [radar] \
                     delay_ns, and make the tiles again",
                    self.folder.display(),
                    k + 1
                );
                Ok(TilePlan {
                    plan: said["plan"].as_str().unwrap_or_default().to_owned(),
                    promised_bytes: said["promised_bytes"].as_u64().unwrap_or(0),
                    checked_error: said["checked_error"].as_f64(),
                })
            })
            .collect()
    }

    fn plan_path(&self, k: usize) -> PathBuf {
        self.folder.join("plans").join(format!("{k}.json"))
    }
}

/// Shape of the image, or of the volume.
fn shape(pixels: &Pixels) -> Vec<usize> {
    let grid = &pixels.grid;
    let slices = pixels.volume.map(|volume| volume.nz);
    slices.into_iter().chain([grid.ny, grid.nx]).collect()
}

/// Makes the group aside and puts it in place, unless another process was first.
fn lay_out(directory: &Path, folder: &Path, pixels: &Pixels, identity: &str) -> anyhow::Result<()> {
    let aside = tempfile::Builder::new()
        .prefix(".tiles-")
        .tempdir_in(directory)?;
    let group_place = aside.path().join(NAME);
    let mut group = ZarrGroup::create(&group_place)?;
    let mut axes = Dataset::default();
    let grid = &pixels.grid;
    let mut axis = |name: &'static str, long_name: &str, values: Vec<f64>| {
        axes.dimension(name, values.len());
        let axis = Variable::new(name, &[name], values.into());
        axes.variable(axis.with("units", "m").with("long_name", long_name));
    };
    if let Some(volume) = pixels.volume {
        let heights = (0..volume.nz).map(|k| volume.slice(k).z_m).collect();
        axis("z", "up", heights);
    }
    axis("y", "north", (0..grid.ny).map(|j| grid.y_m(j)).collect());
    axis("x", "east", (0..grid.nx).map(|i| grid.x_m(i)).collect());
    group.dataset(&axes)?;
    let dimensions: &[&'static str] = match pixels.volume {
        Some(_) => &["z", "y", "x"],
        None => &["y", "x"],
    };
    let image = Variable::new("image", dimensions, Vec::<Complex32>::new().into());
    let per_tile = Tiling::of(pixels).per_tile;
    group.tiled(
        &image.with("long_name", "reflectivity"),
        &shape(pixels),
        per_tile,
    )?;
    group.finish(&[(RUN.to_owned(), Attribute::text(identity))])?;
    fs::create_dir_all(group_place.join("plans"))?;
    match fs::rename(&group_place, folder) {
        Err(_) if folder.join("zarr.json").is_file() => Ok(()),
        moved => Ok(moved?),
    }
}
