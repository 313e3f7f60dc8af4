//! The full-wave scenes of `docs/validation/ground`: their truth, and the campaigns that image them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use acerra_chain::campaign::Campaign;
use acerra_chain::{Control, Journal, MemorySink};
use acerra_imaging::metrics::Target;
use acerra_products::{NamedCampaign, Outcome, RunError, process};
use serde::Deserialize;

/// Fast time of the maximum of the transmitted pulse (√2 / 1.3 GHz), at which range is zero.
const DELAY_NS: f64 = 1.088;
/// Largest lateral distance of a target from the axis of its cylinder (m).
pub const LATERAL_M: f64 = 0.02;
/// Largest deviation of a target's depth from that of the cylinder's near side, as a share of the depth of the axis.
pub const DEPTH_SHARE: f64 = 0.1;

/// The truth of a scene, as its file states it.
#[derive(Clone, Deserialize)]
pub struct Scene {
    #[serde(skip)]
    pub name: String,
    pub soil: Vec<Soil>,
    #[serde(rename = "targets")]
    pub cylinders: Vec<Cylinder>,
    #[serde(default)]
    surface_x_m: Vec<f64>,
    #[serde(default)]
    surface_z_m: Vec<f64>,
}

/// A layer of soil; the last has no thickness.
#[derive(Clone, Deserialize)]
pub struct Soil {
    pub thickness_m: Option<f64>,
    pub relative_permittivity: f64,
    pub conductivity_s_m: f64,
}

/// A buried cylinder across the flight.
#[derive(Clone, Deserialize)]
pub struct Cylinder {
    x_m: f64,
    z_m: f64,
    radius_m: f64,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/validation/ground")
}

impl Scene {
    /// The scene of a name.
    pub fn read(name: &str) -> Self {
        let text = std::fs::read_to_string(folder().join(format!("{name}.json"))).unwrap();
        let scene: Self = serde_json::from_str(&text).unwrap();
        Self {
            name: name.to_owned(),
            ..scene
        }
    }

    /// All scenes, by name.
    pub fn all() -> Vec<Self> {
        let entries = std::fs::read_dir(folder()).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        let mut names: Vec<String> = paths
            .filter(|path| path.extension().is_some_and(|e| e == "json"))
            .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names.iter().map(|name| Self::read(name)).collect()
    }

    fn surface_m(&self, x_m: f64) -> f64 {
        let (xs, zs) = (&self.surface_x_m, &self.surface_z_m);
        if xs.is_empty() {
            return 0.0;
        }
        let after = xs.partition_point(|x| *x <= x_m).clamp(1, xs.len() - 1);
        let share = (x_m - xs[after - 1]) / (xs[after] - xs[after - 1]);
        zs[after - 1] + share * (zs[after] - zs[after - 1])
    }

    /// Permittivities from the top, with the thickness of layers.
    pub fn permittivities(&self) -> String {
        let soils = self.soil.iter().map(|soil| {
            let thickness = soil
                .thickness_m
                .map_or_else(String::new, |m| format!(" ({m:.2} m)"));
            format!("{:.2}{thickness}", soil.relative_permittivity)
        });
        let soils: Vec<String> = soils.collect();
        soils.join(" over ")
    }

    /// The targets of an image compared with the cylinders.
    pub fn compared(&self, outcome: &Outcome) -> Compared {
        let targets = outcome.measured.targets.iter();
        let mut left: Vec<(&Target, bool)> = targets
            .zip(outcome.exceeds_clutter.iter().copied())
            .collect();
        let found = self.cylinders.iter().map(|cylinder| {
            let surface_m = self.surface_m(cylinder.x_m);
            let fits = (left.iter().enumerate())
                .map(|(k, (target, _))| (k, cylinder.compared(target)))
                .filter(|(_, off)| off.is_within(surface_m - cylinder.z_m));
            let (k, off) = fits.min_by(|a, b| a.1.distance_m().total_cmp(&b.1.distance_m()))?;
            let (_, exceeds_clutter) = left.remove(k);
            Some((off, exceeds_clutter))
        });
        let found: Vec<Option<(Off, bool)>> = found.collect();
        Compared {
            found,
            others: left.into_iter().map(|(_, exceeds)| exceeds).collect(),
        }
    }
}

impl Cylinder {
    /// Displacement of a target from the near side, where the wave is reflected first.
    fn compared(&self, target: &Target) -> Off {
        Off {
            lateral_m: target.x_m - self.x_m,
            depth_m: self.z_m + self.radius_m - target.z_m,
        }
    }
}

/// Displacement of a target from the near side of its cylinder (m).
#[derive(Clone, Copy)]
pub struct Off {
    pub lateral_m: f64,
    pub depth_m: f64,
}

impl Off {
    fn distance_m(&self) -> f64 {
        self.lateral_m.hypot(self.depth_m)
    }

    fn is_within(&self, depth_m: f64) -> bool {
        self.lateral_m.abs() <= LATERAL_M && self.depth_m.abs() <= DEPTH_SHARE * depth_m
    }
}

/// Targets of an image and the cylinders of its scene.
pub struct Compared {
    /// Each cylinder's target, where one is within the tolerance, and whether the target exceeds the clutter.
    pub found: Vec<Option<(Off, bool)>>,
    /// Whether the other targets exceed the clutter.
    pub others: Vec<bool>,
}

impl Compared {
    /// Cylinders whose targets exceed the clutter, or do not.
    pub fn cylinders(&self, exceeding: bool) -> usize {
        let found = self.found.iter().flatten();
        found.filter(|(_, exceeds)| *exceeds == exceeding).count()
    }

    /// Other targets that exceed the clutter, or do not.
    pub fn others(&self, exceeding: bool) -> usize {
        self.others.iter().filter(|e| **e == exceeding).count()
    }

    /// The counts as cells of a table.
    pub fn cells(&self) -> String {
        let found = || self.found.iter().flatten();
        let largest_m =
            |off: fn(&Off) -> f64| found().map(|(o, _)| off(o).abs()).fold(0.0, f64::max);
        format!(
            "{} of {} | {} | {} | {} | {:.3}, {:.3} |",
            self.cylinders(true),
            self.found.len(),
            self.cylinders(false),
            self.others(true),
            self.others(false),
            largest_m(|off| off.lateral_m),
            largest_m(|off| off.depth_m),
        )
    }
}

/// What a campaign states of a scene.
#[derive(Clone)]
pub struct Stated {
    pub scene: Scene,
    /// Added to the surface's height (m).
    pub surface_off_m: f64,
    /// `[preprocess] background`, where stated.
    pub background: Option<&'static str>,
    /// Added to the fast time of range zero (ns).
    pub delay_off_ns: f64,
    /// Top of the image (m).
    pub top_m: f64,
}

impl Stated {
    /// Everything as it is.
    pub fn of(scene: &Scene) -> Self {
        Self {
            scene: scene.clone(),
            surface_off_m: 0.0,
            background: None,
            delay_off_ns: 0.0,
            top_m: -0.05,
        }
    }

    /// The campaign file; a terrain is written to `folder`.
    fn campaign(&self, folder: &Path) -> String {
        let Self { scene, .. } = self;
        let file = self::folder().join(format!("{}.npz", scene.name));
        let mut text = format!(
            "[radar]\nfile = '{}'\ndelay_ns = {}\n[preprocess]\nzero_timing = 'none'\ngate_ns = 'none'\n",
            file.display(),
            DELAY_NS + self.delay_off_ns
        );
        if let Some(background) = self.background {
            let _ = writeln!(text, "background = '{background}'");
        }
        let _ = write!(
            text,
            "[measure]\nthreshold_db = -18.0\n[image]\nband_ghz = [0.5, 2.5]\nfrequencies = 101\nx_m = [0.3, 2.1]\n\
             y_m = [0.0, 0.0]\nz_m = [-0.40, {}]\npixel_m = 0.01\npixel_z_m = 0.005\n",
            self.top_m
        );
        if scene.surface_x_m.is_empty() {
            let _ = writeln!(text, "[ground]\nsurface_z_m = {}", self.surface_off_m);
        } else {
            let terrain = self.terrain(folder);
            let _ = write!(
                text,
                "terrain = '{}'\n[ground]\nsurface = 'terrain'\n",
                terrain.display()
            );
        }
        let is_layered = scene.soil.len() > 1;
        for soil in &scene.soil {
            if is_layered {
                let _ = writeln!(text, "[[ground.layer]]");
            }
            if let Some(thickness_m) = soil.thickness_m.filter(|_| is_layered) {
                let _ = writeln!(text, "thickness_m = {thickness_m}");
            }
            let _ = writeln!(
                text,
                "relative_permittivity = {}\nconductivity_s_m = {}",
                soil.relative_permittivity, soil.conductivity_s_m
            );
        }
        text
    }

    /// The surface as an ASCII grid, the same in every row.
    fn terrain(&self, folder: &Path) -> PathBuf {
        const ROWS: usize = 5;
        let (xs, zs) = (&self.scene.surface_x_m, &self.scene.surface_z_m);
        let step_m = xs[1] - xs[0];
        let heights: Vec<String> = (zs.iter())
            .map(|z| format!("{:.5}", z + self.surface_off_m))
            .collect();
        let row = heights.join(" ") + "\n";
        let head = format!(
            "ncols {}\nnrows {ROWS}\nxllcenter {}\nyllcenter {}\ncellsize {step_m}\n",
            xs.len(),
            xs[0],
            -2.0 * step_m
        );
        let path = folder.join(format!("{}.asc", self.scene.name));
        std::fs::write(&path, head + &row.repeat(ROWS)).unwrap();
        path
    }

    /// The run of the campaign.
    pub fn run(&self) -> Result<Outcome, RunError> {
        let folder = tempfile::tempdir().unwrap();
        let campaign = NamedCampaign {
            name: self.scene.name.clone(),
            campaign: Campaign::parse(&self.campaign(folder.path())).unwrap(),
        };
        process(
            campaign,
            &mut MemorySink::default(),
            &mut Journal::default(),
            &Control::default(),
        )
    }
}
