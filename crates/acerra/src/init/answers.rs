//! Answers for a campaign from a first look at its flight, and the remaining questions.

use acerra_chain::look::{Determined, FirstLook, SideLook};

use crate::settings_files::template::Filled;

/// Resolution along range of the default band, 1.7 GHz (m): heights and delays that move the image by less need no
/// answer.
const CELL_M: f64 = 0.088;
/// Level of an echo beyond the flight's surroundings above those within from which the image reaches to it
/// (dB).
const BEYOND_DB: f64 = 10.0;
/// Margin of the image beyond that echo (m).
const MARGIN_M: f64 = 1.0;

/// Keys and questions.
#[derive(Debug, Default)]
pub struct Answers {
    /// Keys with their values, or remarks.
    pub filled: Vec<Filled>,
    /// Questions, each with the key that answers it.
    pub questions: Vec<String>,
}

impl Answers {
    /// Those of a look.
    #[must_use]
    pub fn of(look: &FirstLook) -> Self {
        let mut answers = Self::default();
        match (&look.side, look.sees_surface) {
            (Some(side), _) => answers.of_side(side),
            (None, false) => answers.questions.push(
                "[trajectory] time_offset_s: neither the height of the flight nor its motion shows in the echoes; \
                 by how much is the clock of the positions ahead of the radar's (s)?"
                    .to_owned(),
            ),
            (None, true) => {}
        }
        answers
    }

    /// A radar whose echoes do not follow the height.
    fn of_side(&mut self, side: &SideLook) {
        self.filled.push(
            Filled::new("preprocess.gate_ns", "\"none\"")
                .because("no echo follows the height of the flight: the radar looks to the side"),
        );
        self.filled
            .push(Filled::new("image.values", "\"reflectivity\"").because(
            "ranges differ much over the image: equal reflectors are equally bright near and far",
        ));
        self.height(side);
        self.delay(side);
        self.extent(side);
    }

    fn height(&mut self, side: &SideLook) {
        let z_m = &side.height_m;
        let found = format!(
            "the echoes focus best on a plane at {:.2} m ({})",
            z_m.best,
            left(z_m, 1.0, "m")
        );
        if z_m.is_bounded && side.moved_m <= CELL_M {
            let height = Filled::new("image.z_m", format!("{:.2}", z_m.best));
            self.filled.push(height.because(found));
            return;
        }
        self.questions.push(format!(
            "[image] z_m: how high are the targets, in the frame of the positions (m)? {}; measure it, as within \
             these heights the strongest target moves by {:.2} m",
            found, side.moved_m
        ));
        self.filled.push(Filled::remark("image.z_m", found));
    }

    fn delay(&mut self, side: &SideLook) {
        let delay = &side.delay_s;
        let found = format!(
            "the echoes focus best with range zero at {:.1} ns ({})",
            1e9 * delay.best,
            left(delay, 1e9, "ns")
        );
        self.filled
            .push(Filled::new("radar.delay_ns", "\"auto\"").because(&found));
        if !delay.is_bounded {
            self.questions.push(format!(
                "[radar] delay_ns: at which fast time is range zero? {found}; measure it once with a reflector at a \
                 known range (acerra calibrate)"
            ));
        }
    }

    fn extent(&mut self, side: &SideLook) {
        // Without a gate the default image reaches no farther than the flight is high.
        let Some(([x_m, y_m], above_db)) = side.beyond else {
            for (key, [from, to]) in ["image.x_m", "image.y_m"].iter().zip(side.around_m) {
                let extent = Filled::new(key, format!("[{from:.1}, {to:.1}]"));
                self.filled.push(
                    extent.because("the surroundings of the track: choose the area of interest"),
                );
            }
            return;
        };
        let found = format!(
            "beyond the surroundings of the flight an echo focuses at ({x_m:.1}, {y_m:.1}) m, {above_db:.0} dB above \
             those within"
        );
        for (key, axis, at_m) in [("image.x_m", 0, x_m), ("image.y_m", 1, y_m)] {
            let [mut from, mut to] = side.around_m[axis];
            if above_db >= BEYOND_DB {
                from = from.min((at_m - MARGIN_M).floor());
                to = to.max((at_m + MARGIN_M).ceil());
            }
            let extent = Filled::new(key, format!("[{from:.1}, {to:.1}]"));
            self.filled.push(extent.because(&found));
        }
    }
}

/// Interval of a quantity that the echoes leave, in words.
fn left(of: &Determined, per_unit: f64, unit: &str) -> String {
    let [from, to] = of.within.map(|v| v * per_unit);
    if of.is_bounded {
        format!("{from:.2} to {to:.2} {unit} are not excluded")
    } else {
        format!("{from:.2} to {to:.2} {unit} are not excluded, an end of what was tried among them")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(height_m: Determined, moved_m: f64) -> FirstLook {
        let delay_s = Determined {
            best: 12e-9,
            within: [11e-9, 13e-9],
            is_bounded: true,
        };
        FirstLook {
            sees_surface: false,
            time_offset_s: Some(1.0),
            side: Some(SideLook {
                delay_s,
                height_m,
                moved_m,
                place_m: Some([1.0, 2.0]),
                beyond: Some(([9.5, 1.0], 14.0)),
                reach_m: 11.0,
                path_m: [[0.0, 1.0], [0.0, 0.0]],
                around_m: [[-5.0, 6.0], [-5.0, 5.0]],
            }),
        }
    }

    #[test]
    fn a_height_that_the_echoes_tell_is_written_and_another_is_asked_for() {
        let known = Determined {
            best: -0.02,
            within: [-0.1, 0.1],
            is_bounded: true,
        };
        let of = |answers: &Answers, key: &str| {
            let found = answers.filled.iter().find(|f| f.path == key).cloned();
            found.and_then(|f| f.value)
        };
        let answers = Answers::of(&side(known, 0.05));
        assert_eq!(of(&answers, "image.z_m").as_deref(), Some("-0.02"));
        assert!(answers.questions.is_empty());
        assert_eq!(of(&answers, "image.x_m").as_deref(), Some("[-5.0, 11.0]"));
        assert_eq!(of(&answers, "image.y_m").as_deref(), Some("[-5.0, 5.0]"));
        let moves = Answers::of(&side(known, 0.4));
        let open = Determined {
            is_bounded: false,
            ..known
        };
        for asked in [moves, Answers::of(&side(open, 0.05))] {
            assert_eq!(of(&asked, "image.z_m"), None);
            assert!(asked.questions[0].starts_with("[image] z_m"), "{asked:?}");
        }
    }

    #[test]
    fn a_flight_over_its_surface_keeps_the_defaults() {
        let look = FirstLook {
            sees_surface: true,
            time_offset_s: Some(0.0),
            side: None,
        };
        let answers = Answers::of(&look);
        assert!(answers.filled.is_empty() && answers.questions.is_empty());
    }
}
