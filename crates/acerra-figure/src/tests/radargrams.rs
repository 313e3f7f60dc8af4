//! What radargrams show.

use super::*;

#[test]
fn a_radargram_runs_downwards_and_keeps_signs() {
    let (traces, per_trace) = (40, 100);
    let mut samples = vec![0.0_f32; traces * per_trace];
    for trace in 0..traces {
        samples[trace * per_trace + 20] = 100.0;
        samples[trace * per_trace + 80] = -100.0;
    }
    let mut radargram = Radargram::new("", &samples, traces, per_trace).fast_time(0.0, 0.5);
    radargram.colours = RadargramColours::Signed { limit: Some(100.0) };
    let drawing = radargram.draw().unwrap();
    let picture = Picture::of("radargram-signs", &drawing);
    let plot = plot_of(&drawing);
    let at = |sample: f32| {
        picture.at(
            plot.x + plot.width / 2.0,
            plot.y + plot.height * (sample + 0.5) / 100.0,
        )
    };
    assert!(
        near(at(20.0), Palette::BlueRed.at(1.0), 2),
        "positive is red"
    );
    assert!(
        near(at(80.0), Palette::BlueRed.at(0.0), 2),
        "negative is blue"
    );
    assert!(near(at(50.0), Palette::BlueRed.at(0.5), 2));
    assert!(at(20.0)[0] > at(20.0)[2] && at(80.0)[2] > at(80.0)[0]);
}

#[test]
fn a_radargram_survives_nan_constants_and_single_samples() {
    for value in [0.0, f32::NAN, 7.0, f32::NEG_INFINITY] {
        let samples = vec![value; 6];
        for colours in [
            RadargramColours::Signed { limit: None },
            RadargramColours::Decibel { floor_db: -60.0 },
        ] {
            for (traces, per_trace) in [(6, 1), (1, 6), (2, 3)] {
                let mut radargram = Radargram::new("odd", &samples, traces, per_trace);
                radargram.colours = colours;
                assert!(radargram.draw().unwrap().to_png().is_ok());
            }
        }
    }
    assert!(Radargram::new("", &[], 0, 0).draw().is_err());
    let mut wrong = Radargram::new("", &[1.0, 2.0], 2, 1);
    wrong.curves.push(FastTimeCurve {
        label: "2h/c".to_owned(),
        fast_time_ns: vec![0.0; 3],
        dashed: false,
    });
    assert!(matches!(
        wrong.draw(),
        Err(FigureError::ShapeMismatch {
            expected: 2,
            found: 3,
            ..
        })
    ));
}
