//! What positioning errors do to the campaign's images: the true trajectory against carrier phase
//! with and without fixed ambiguities, and what theory says of either.

use std::fmt::Write as _;
use std::path::Path;

use acerra::demo::{Flown, fly};
use acerra_chain::Journal;
use acerra_chain::campaign::Campaign;
use acerra_imaging::metrics::{Field, ImageView, InterpolatedImage, climb_to_peak};
use acerra_imaging::psf::PointSpread;
use acerra_imaging::sensitivity::{ErrorModel, predict};
use acerra_products::Outcome;
use acerra_products::display::Shown;
use acerra_products::pictures;
use acerra_simulate::radar::{Echo, RadarScene, Scattering};

use crate::flights::{Flight, flights};
use crate::page::Page;

/// One way to have positions.
struct Case {
    name: String,
    /// Standard deviation of the errors about their mean, and that mean (m).
    spread_m: [f64; 3],
    mean_m: [f64; 3],
    /// Time over which the errors forget themselves (s).
    correlation_s: f64,
    /// For each reflector: loss (dB) and shift (m) against the image of the true trajectory.
    measured: Vec<(f64, [f64; 2])>,
    /// The same by Eq. (5) with the errors of this flight.
    predicted: Vec<(f64, [f64; 2])>,
    /// Loss at the peak that errors of this size lead one to expect (dB).
    expected: Vec<Option<f64>>,
    /// Share of the image's energy that is not that of the true trajectory's image.
    difference: f64,
}

#[test]
#[ignore = "eight images at full size; cargo xtask validate, as CI does"]
fn validation_book_positions() {
    let mut page = Page::open("positions.md");
    let here = tempfile::tempdir().unwrap();
    let mut errors = String::from(
        "| | mean error, x / y / z (cm) | spread about it (cm) | memory (s) | image's energy that is not the \
         true one's |\n| --- | --- | --- | --- | --- |\n",
    );
    let mut images = String::from(
        "| | reflector | loss (dB): measured | predicted from its errors | expected of errors of \
         their size | shift along / across (cm): measured | predicted |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for flight in flights() {
        let track = flight.track.name.replace("track-", "Track ");
        let unfixed = unfixed(here.path());
        let float = |campaign: &mut Campaign| {
            finely(campaign);
            unfixed(campaign);
        };
        let truth = true_image(flight);
        let case = |how: &str, outcome: &Outcome| {
            Case::of(format!("{track}, {how}"), flight, outcome, &truth)
        };
        let fixed = case("fixed", &flight.processed(finely));
        let float_case = case("float", &flight.processed(float));
        drop(truth);
        let short = short_start(flight, here.path());
        let hurried_outcome = short.processed(float);
        let hurried = Case::of(
            format!("{track}, float, {SHORT_START_S} s on the ground"),
            &short,
            &hurried_outcome,
            &true_image(&short),
        );
        for case in [&fixed, &float_case, &hurried] {
            case.write(&mut errors, &mut images);
        }
        println!("{errors}\n{images}");
        let mean = |losses: Vec<f64>| losses.iter().sum::<f64>() / losses.len() as f64;
        let lost = mean(fixed.measured.iter().map(|(loss, _)| *loss).collect());
        let expected = mean(fixed.expected.iter().map(|loss| loss.unwrap()).collect());
        assert!((lost - expected).abs() < 1.0, "{lost} and {expected} dB");
        fixed.check(0.3, 0.01);
        float_case.check(0.6, 0.02);
        // Fixed positions move nothing that matters, unfixed ones do.
        let along = |case: &Case| {
            let shifts = case.measured.iter().map(|(_, shift)| shift[0].abs());
            shifts.fold(0.0, f64::max)
        };
        assert!(along(&fixed) < 0.02 && along(&float_case) > 0.05);
        assert!(hurried.difference > 0.9 && hurried.difference > fixed.difference);
        let image = pictures::image(&hurried_outcome, &Shown::of(&hurried_outcome)).unwrap();
        page.speckled_picture(&format!("{}-float", flight.track.name), &image.png, 3);
    }
    page.block("errors", &errors);
    page.block("images", &images);
    page.close();
}

/// Time that the hurried flight stands on the ground before take-off and after landing (s).
const SHORT_START_S: f64 = 10.0;

/// The same flight, with less time on the ground for the ambiguities to settle.
fn short_start(flight: &Flight, here: &Path) -> Flight {
    let mut scene = flight.track.on_track().unwrap();
    scene.flight.as_mut().unwrap().ground_time_s = SHORT_START_S;
    let folder = here.join(flight.track.name);
    let flown = fly(scene, &folder, &mut Journal::default()).unwrap();
    Flight {
        track: flight.track,
        flown,
        folder,
    }
}

/// Has the ambiguities stay real numbers, as a user does: by RTKLIB's configuration file.
pub fn unfixed(here: &Path) -> impl Fn(&mut Campaign) + use<> {
    let conf = here.join("float.conf");
    std::fs::write(
        &conf,
        "pos1-posmode=kinematic\npos1-frequency=l1\npos1-soltype=combined\npos2-armode=off\n\
         stats-eratio1=300\n",
    )
    .unwrap();
    move |campaign| campaign.gnss.as_mut().unwrap().config = Some(conf.clone())
}

/// Accuracy of the images: a reflector under the track has a lobe that falls by less than 1e-3 over centimetres across
/// it, and what an image is off by would decide where its top is found.
const ACCURACY: f64 = 1e-4;

fn finely(campaign: &mut Campaign) {
    campaign.image.accuracy = ACCURACY;
}

/// The image of the true trajectory.
fn true_image(flight: &Flight) -> Outcome {
    flight.processed(|campaign| {
        finely(campaign);
        campaign.gnss = None;
        campaign.trajectory.file = Some(flight.folder.join("truth-trajectory.csv"));
    })
}

impl Case {
    fn of(name: String, flight: &Flight, outcome: &Outcome, truth: &Outcome) -> Self {
        let truth_m = &flight.flown.truth_m;
        let error_m: Vec<[f64; 3]> = outcome
            .prepared
            .aligned
            .position_m
            .iter()
            .zip(truth_m)
            .map(|(found, truth)| [0, 1, 2].map(|i| found[i] - truth[i]))
            .collect();
        let count = error_m.len() as f64;
        let mean_m = [0, 1, 2].map(|i| error_m.iter().map(|e| e[i]).sum::<f64>() / count);
        let spread_m = [0, 1, 2].map(|i| {
            let squares = error_m.iter().map(|e| (e[i] - mean_m[i]).powi(2));
            (squares.sum::<f64>() / count).sqrt()
        });

        let centred: Vec<[f64; 3]> = error_m
            .iter()
            .map(|e| [0, 1, 2].map(|i| e[i] - mean_m[i]))
            .collect();
        let correlation_s = correlation_s(&centred, &outcome.prepared.aligned.time_s);

        let (mut measured, mut predicted, mut expected) = (vec![], vec![], vec![]);
        for (k, corner) in flight.flown.scene.corner.iter().enumerate() {
            let at_m = corner.position_m;
            measured.push(against(peak_of(outcome, at_m), peak_of(truth, at_m)));
            let image = |outcome: &Outcome| Predicted::of(flight, outcome, k).peak();
            predicted.push(against(image(outcome), image(truth)));
            expected.push(expected_loss_db(flight, spread_m, correlation_s, k));
        }
        Self {
            name,
            spread_m,
            mean_m,
            correlation_s,
            measured,
            predicted,
            expected,
            difference: difference(outcome, truth),
        }
    }

    fn write(&self, errors: &mut String, images: &mut String) {
        let centimetres = |v: [f64; 3]| v.map(|v| format!("{:.1}", 1e2 * v)).join(" / ");
        let _ = writeln!(
            errors,
            "| {} | {} | {} | {:.1} | {:.2} |",
            self.name,
            centimetres(self.mean_m),
            centimetres(self.spread_m),
            self.correlation_s,
            self.difference
        );
        for (k, ((measured, predicted), expected)) in self
            .measured
            .iter()
            .zip(&self.predicted)
            .zip(&self.expected)
            .enumerate()
        {
            let shift =
                |[along, across]: [f64; 2]| format!("{:.1} / {:.0}", 1e2 * along, 1e2 * across);
            let _ = writeln!(
                images,
                "| {} | {} | {:.1} | {:.1} | {} | {} | {} |",
                self.name,
                k + 1,
                measured.0,
                predicted.0,
                expected.map_or("no peak".to_owned(), |v| format!("{v:.1}")),
                shift(measured.1),
                shift(predicted.1)
            );
        }
    }

    /// The chain does to the image what Eq. (5) says of these errors, and no more.
    fn check(&self, loss_db: f64, along_m: f64) {
        for (measured, predicted) in self.measured.iter().zip(&self.predicted) {
            let name = &self.name;
            assert!(
                (measured.0 - predicted.0).abs() < loss_db,
                "{name}: {measured:?} {predicted:?}"
            );
            let off = [0, 1].map(|i| (measured.1[i] - predicted.1[i]).abs());
            assert!(
                off[0] < along_m && off[1] < 0.1,
                "{name}: {measured:?} {predicted:?}"
            );
        }
    }
}

/// Place (m) and amplitude of a peak.
type Peak = ([f64; 2], f64);

/// Loss (dB) and shift (m) of one peak against another.
fn against(peak: Peak, truth: Peak) -> (f64, [f64; 2]) {
    let shift = [0, 1].map(|i| peak.0[i] - truth.0[i]);
    (20.0 * (peak.1 / truth.1).log10(), shift)
}

/// Peaks are looked for this far along and across the track (m).
const WINDOW_M: [f64; 2] = [0.7, 0.9];

fn strongest_near(field: &dyn Field, at_m: [f64; 3]) -> Peak {
    let mut best = ([at_m[0], at_m[1]], 0.0);
    let steps = [70, 30];
    for j in -steps[1]..=steps[1] {
        for i in -steps[0]..=steps[0] {
            let place = [
                at_m[0] + WINDOW_M[0] * f64::from(i) / f64::from(steps[0]),
                at_m[1] + WINDOW_M[1] * f64::from(j) / f64::from(steps[1]),
            ];
            if let Some(level) = field.amplitude(place[0], place[1])
                && level > best.1
            {
                best = (place, level);
            }
        }
    }
    climb_to_peak(field, best.0, 0.01).unwrap()
}

fn peak_of(outcome: &Outcome, at_m: [f64; 3]) -> Peak {
    let view = ImageView::new(&outcome.focused.image, outcome.focused.pixels.grid).unwrap();
    let field = InterpolatedImage::about(view, [at_m[0], at_m[1]]);
    let (place, _) = strongest_near(&field, at_m);
    let field = InterpolatedImage::about(view, place);
    climb_to_peak(&field, place, 0.01).unwrap()
}

/// The image of one reflector by Eq. (5), its echoes taken from where the radar truly was and
/// focused with where it was thought to be.
struct Predicted<'a> {
    believed: PointSpread,
    truth_m: &'a [[f64; 3]],
    at_m: [f64; 3],
    /// What zero-timing takes ranges for too long by (m).
    range_error_m: f64,
}

impl<'a> Predicted<'a> {
    fn of(flight: &'a Flight, outcome: &Outcome, corner: usize) -> Self {
        let Flown { scene, truth_m, .. } = &flight.flown;
        let c = outcome.campaign.image.light_speed_m_s;
        let shift_s = outcome.prepared.cleaned().unwrap().shift_s;
        let believed = PointSpread::new(
            outcome.prepared.aligned.position_m.clone(),
            Some(pattern(&flight.flown, corner)),
            outcome.prepared.spectrum.frequency_hz.clone(),
            c,
        )
        .unwrap();
        Self {
            believed,
            truth_m,
            at_m: scene.corner[corner].position_m,
            range_error_m: 0.5 * c * (shift_s + 1e-9 * scene.radar.delay_ns),
        }
    }

    fn peak(&self) -> Peak {
        strongest_near(self, self.at_m)
    }
}

impl Field for Predicted<'_> {
    fn amplitude(&self, x_m: f64, y_m: f64) -> Option<f64> {
        let distance =
            |p: &[f64; 3], q: [f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
        let sum: acerra_imaging::Complex64 = self
            .believed
            .position_m()
            .iter()
            .zip(self.truth_m)
            .zip(self.believed.weight())
            .map(|((believed, truth), weight)| {
                let pixel_m = distance(believed, [x_m, y_m, 0.0]);
                let echo_m = distance(truth, self.at_m);
                let kernel = self.believed.kernel(pixel_m - echo_m - self.range_error_m);
                kernel * (weight / (echo_m * pixel_m).powi(2))
            })
            .sum();
        Some(sum.norm())
    }
}

/// Strength of one corner's echo at each trace, spreading apart: the patterns of antennas and
/// corner.
fn pattern(flown: &Flown, corner: usize) -> Vec<f64> {
    let scene = RadarScene {
        corner: vec![flown.scene.corner[corner].clone()],
        ..RadarScene::default()
    };
    let radar = &flown.scene.radar;
    let scattering = Scattering::new(&scene, radar, &[], 0);
    let flight = flown.scene.fly().unwrap();
    let start_s =
        flown.outcome.prepared.first().time_offset_s - flown.scene.start().unwrap().tow_s();
    let mut echoes: Vec<Echo> = Vec::new();
    flown
        .outcome
        .prepared
        .aligned
        .time_s
        .iter()
        .zip(&flown.truth_m)
        .map(|(t, antenna_m)| {
            scattering.echoes(&flight.pose_at(t + start_s), *antenna_m, &mut echoes);
            let range_m = 0.5 * 299_792_458.0 * echoes.first().map_or(0.0, |e| e.delay_s);
            echoes
                .first()
                .map_or(0.0, |e| e.strength * range_m * range_m)
        })
        .collect()
}

/// The time constant of a Gauss–Markov process that, over three traces (about a GNSS epoch),
/// forgets as much as these errors do.
fn correlation_s(error_m: &[[f64; 3]], time_s: &[f64]) -> f64 {
    const LAG: usize = 3;
    let product = |lag: usize| -> f64 {
        let pairs = error_m.iter().zip(&error_m[lag..]);
        let sum: f64 = pairs
            .map(|(a, b)| (0..3).map(|i| a[i] * b[i]).sum::<f64>())
            .sum();
        sum / (error_m.len() - lag) as f64
    };
    -(time_s[LAG] - time_s[0]) / (product(LAG) / product(0)).ln()
}

/// What Gauss–Markov errors of this size and memory lead one to expect at the peak.
fn expected_loss_db(
    flight: &Flight,
    spread_m: [f64; 3],
    correlation_s: f64,
    corner: usize,
) -> Option<f64> {
    let flown = &flight.flown;
    let spread = PointSpread::new(
        flown.truth_m.clone(),
        Some(pattern(flown, corner)),
        flown.outcome.prepared.spectrum.frequency_hz.clone(),
        299_792_458.0,
    )
    .unwrap();
    let pulses = flown.truth_m.len();
    let model = ErrorModel::new(
        vec![[0.0; 3]; pulses],
        vec![spread_m; pulses],
        flown.outcome.prepared.aligned.time_s.clone(),
        correlation_s,
    )
    .unwrap();
    let blur = predict(&spread, flown.scene.corner[corner].position_m, &model).unwrap();
    blur.peak_loss_db
}

/// Energy of the difference of two images over that of the second, the best common factor taken
/// out.
fn difference(image: &Outcome, truth: &Outcome) -> f64 {
    use acerra_imaging::Complex64;
    let wide = |v: &acerra_imaging::Complex32| Complex64::new(f64::from(v.re), f64::from(v.im));
    let (a, b) = (&image.focused.image, &truth.focused.image);
    let dot: Complex64 = a.iter().zip(b).map(|(a, b)| wide(a).conj() * wide(b)).sum();
    let energy =
        |v: &[acerra_imaging::Complex32]| v.iter().map(|v| wide(v).norm_sqr()).sum::<f64>();
    1.0 - dot.norm_sqr() / (energy(a) * energy(b))
}
