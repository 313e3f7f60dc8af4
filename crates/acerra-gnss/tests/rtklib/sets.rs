//! The real data sets and how RTKLIB was told to process them.

use super::{data, navigation, observations};
use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
use acerra_gnss::{
    BasePosition, GlonassAmbiguity, Navigation, ObservationData, PpkOptions, System,
};

pub struct Set {
    pub name: &'static str,
    pub folder: &'static str,
    rover: &'static str,
    base: &'static str,
    navigation: &'static [&'static str],
    /// Base position as given to RTKLIB.
    base_position: fn() -> BasePosition,
    systems: &'static [System],
    glonass: GlonassAmbiguity,
}

/// The logs of a set.
pub struct Logs {
    pub rover: ObservationData,
    pub base: ObservationData,
    pub navigation: Navigation,
}

impl Set {
    /// The logs, or `None` where the data are absent.
    pub fn read(&self) -> Option<Logs> {
        let folder = data(self.folder)?;
        let files: Vec<_> = self.navigation.iter().map(|n| folder.join(n)).collect();
        Some(Logs {
            rover: observations(folder.join(self.rover)),
            base: observations(folder.join(self.base)),
            navigation: navigation(&files),
        })
    }

    /// File names, rover and base first.
    pub fn files(&self) -> Vec<&'static str> {
        [self.rover, self.base]
            .into_iter()
            .chain(self.navigation.iter().copied())
            .collect()
    }

    /// `options` with the systems and the base position of RTKLIB's configuration.
    pub fn adapt(&self, options: PpkOptions) -> PpkOptions {
        options
            .with_base_position((self.base_position)())
            .with_systems(self.systems.iter().copied().collect())
            .with_glonass_ambiguity(self.glonass)
    }
}

pub const WETTZELL: Set = Set {
    name: "Wettzell (IGS, 1.6 m, 30 s)",
    folder: "gnss-wettzell",
    rover: "rover_WTZZ.rnx",
    base: "base_WTZR.rnx",
    navigation: &["nav.rnx"],
    base_position: || BasePosition::Ecef([4_075_580.311_1, 931_854.054_3, 4_801_568.280_8]),
    systems: &[System::Gps],
    glonass: GlonassAmbiguity::Off,
};

pub const GEONET: Set = Set {
    name: "GEONET (3.3 km, 30 s)",
    folder: "gnss-geonet",
    rover: "rover_0759.05o",
    base: "base_3040.05o",
    navigation: &["nav.05n"],
    base_position: || BasePosition::Ecef([-3_978_241.958, 3_382_840.234, 3_649_900.853]),
    systems: &[System::Gps],
    glonass: GlonassAmbiguity::Off,
};

pub const STATIC_1HZ: Set = Set {
    name: "mosaic-X5 (five systems, 1 m, 1 Hz)",
    folder: "gnss-static-1hz",
    rover: "rover.obs",
    base: "base.obs",
    navigation: &["base.nav"],
    base_position: || {
        let place = Geodetic::from_degrees(35.134_707_705, 136.977_577_939, 104.853);
        BasePosition::Ecef(ecef_from_geodetic(&place))
    },
    systems: &[
        System::Gps,
        System::Glonass,
        System::Galileo,
        System::Qzss,
        System::Beidou,
    ],
    glonass: GlonassAmbiguity::Off,
};

/// Where the rover of [`STATIC_M8P`] stood, east, north, up from its base (m): median of the fixed
/// epochs by RTKLIB's rules, both ways, with GLONASS resolved and the troposphere of the height
/// found (by that of the single-point height the median is 7 mm lower).
pub const M8P_ROVER_ENU_M: [f64; 3] = [-0.237_3, 0.227_7, 0.002_5];

pub const STATIC_M8P: Set = Set {
    name: "still (NEO-M8P, GPS + GLONASS, 1 Hz)",
    folder: "gnss-static-m8p",
    rover: "rover.obs.gz",
    base: "base.obs.gz",
    navigation: &["base.nav.gz", "rover.nav.gz"],
    base_position: || BasePosition::Ecef([3_774_093.713_5, -601_662.553_8, 5_089_328.137_0]),
    systems: &[System::Gps, System::Glonass],
    glonass: GlonassAmbiguity::On,
};

pub const LG69T: Set = Set {
    name: "walk (LG69T, five systems, 1 Hz)",
    folder: "gnss-walk-lg69t",
    rover: "rover.obs.gz",
    base: "base.obs.gz",
    navigation: &["rover.nav.gz"],
    base_position: || BasePosition::Ecef([-2_845_676.411_0, 4_661_619.402_2, 3_283_215.324_1]),
    systems: &[System::Gps, System::Galileo, System::Beidou],
    glonass: GlonassAmbiguity::Off,
};

pub const WALK: Set = Set {
    name: "walk (NEO-M8P, GPS + GLONASS, 1 Hz)",
    folder: "gnss-walk-m8p",
    rover: "rover.obs",
    base: "base.obs",
    navigation: &["base.nav", "rover.nav"],
    base_position: || BasePosition::Header,
    systems: &[System::Gps, System::Glonass],
    glonass: GlonassAmbiguity::On,
};
