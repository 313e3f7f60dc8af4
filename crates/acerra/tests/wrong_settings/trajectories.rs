//! Trajectory files with a wrong unit, axis or clock.

use std::fmt::Write as _;
use std::path::Path;

/// What is wrong with a trajectory file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// Nothing.
    None,
    /// Positions multiplied by a factor: another unit of length.
    Length(f64),
    /// Times multiplied by a factor: another unit of time.
    Time(f64),
    /// Axes in another order: where x, y and z come from.
    Axes([usize; 3]),
    /// One axis with the wrong sign.
    Mirrored(usize),
    /// Heights above something else (m).
    Raised(f64),
}

/// Every file that the table asks for.
pub const DISTORTIONS: [Distortion; 16] = [
    Distortion::None,
    Distortion::Length(1e3),
    Distortion::Length(1e2),
    Distortion::Length(3.280_84),
    Distortion::Time(1e3),
    Distortion::Time(1e-3),
    Distortion::Time(60.0),
    Distortion::Axes([0, 2, 1]),
    Distortion::Axes([1, 0, 2]),
    Distortion::Axes([2, 1, 0]),
    Distortion::Mirrored(0),
    Distortion::Mirrored(1),
    Distortion::Mirrored(2),
    Distortion::Raised(0.5),
    Distortion::Raised(2.0),
    Distortion::Raised(47.0),
];

impl Distortion {
    /// Name of its file.
    pub fn file_name(self) -> String {
        let at = DISTORTIONS.iter().position(|other| *other == self);
        format!("distorted-{}.csv", at.unwrap())
    }

    /// Writes every distorted copy of `truth-trajectory.csv` into its folder.
    pub fn write_all(folder: &Path) {
        let truth = std::fs::read_to_string(folder.join("truth-trajectory.csv")).unwrap();
        for distortion in DISTORTIONS {
            let file = folder.join(distortion.file_name());
            std::fs::write(file, distortion.of(&truth)).unwrap();
        }
    }

    /// The trajectory distorted; attitudes are left out, as most trajectories are without.
    fn of(self, truth: &str) -> String {
        let mut text = String::from("time_s,x_m,y_m,z_m\n");
        for line in truth.lines().skip(1) {
            let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            let (mut time_s, mut place) = (values[0], [values[1], values[2], values[3]]);
            match self {
                Self::None => {}
                Self::Length(factor) => place = place.map(|v| v * factor),
                Self::Time(factor) => time_s *= factor,
                Self::Axes(from) => place = from.map(|axis| place[axis]),
                Self::Mirrored(axis) => place[axis] = -place[axis],
                Self::Raised(by_m) => place[2] += by_m,
            }
            let [x, y, z] = place;
            let _ = writeln!(text, "{time_s:.6},{x:.5},{y:.5},{z:.5}");
        }
        text
    }
}
