//! Draws an image, a radargram and a stack of plots into the current directory (or the one named):
//! `cargo run -p acerra-figure --example figures -- /tmp`.

use acerra_figure::{
    Axis, FastTimeCurve, ImageDb, LevelWindow, LinePlot, Panel, PixelValues, Radargram, Series,
    Stack, SurveyMark, TargetMark,
};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_owned()));

    // A reflector at (3, 1) m in speckle, seen from a track along x.
    let (nx, ny, pixel_m) = (300, 200, 0.02);
    let sinc = |t: f64| if t == 0.0 { 1.0 } else { t.sin() / t };
    let amplitude: Vec<f32> = (0..nx * ny)
        .map(|i| {
            let (x, y) = ((i % nx) as f64 * pixel_m, (i / nx) as f64 * pixel_m - 1.0);
            let speckle = 0.01 + 0.02 * ((i * 7919 % 1009) as f64 / 1009.0);
            (sinc(40.0 * (x - 3.0)) * sinc(12.0 * (y - 1.0)).abs() + speckle) as f32
        })
        .collect();
    let track_m: Vec<[f64; 2]> = (0..61).map(|i| [0.1 * f64::from(i), 0.0]).collect();
    let mut image = ImageDb::new("Image", PixelValues::Amplitude(&amplitude), nx, ny);
    image = image.at(0.0, -1.0, pixel_m);
    image.window = LevelWindow::Percentile { share: 0.25 };
    image.track_m = &track_m;
    image.targets.push(TargetMark {
        x_m: 3.0,
        y_m: 1.0,
        label: "1".to_owned(),
    });
    image.survey.push(SurveyMark {
        x_m: 3.04,
        y_m: 1.02,
        label: "corner".to_owned(),
        target_distance_m: Some(0.045),
    });
    std::fs::write(folder.join("image.png"), image.draw()?.to_png()?)?;

    // Its echo in a radargram, with the range that it should have.
    let (traces, per_trace, step_ns) = (61, 400, 0.061);
    let delay_ns = |trace: usize| 20.0 / 3.0 * (0.1 * trace as f64 - 3.0).hypot(1.4);
    let samples: Vec<f32> = (0..traces * per_trace)
        .map(|i| {
            let t = (i % per_trace) as f64 * step_ns - delay_ns(i / per_trace);
            ((-t * t * 2.5).exp() * (25.0 * t).cos()) as f32
        })
        .collect();
    let mut radargram = Radargram::new("Radargram", &samples, traces, per_trace);
    radargram = radargram.fast_time(0.0, step_ns);
    radargram.curves.push(FastTimeCurve {
        label: "2R/c".to_owned(),
        fast_time_ns: (0..traces).map(delay_ns).collect(),
        dashed: true,
    });
    std::fs::write(folder.join("radargram.png"), radargram.draw()?.to_png()?)?;

    // Two quantities over one time axis, as SVG.
    let time_s: Vec<f64> = (0..200).map(|i| 0.1 * f64::from(i)).collect();
    let height_m: Vec<f64> = time_s.iter().map(|t| 4.0 + 0.1 * t.sin()).collect();
    let speed_m_s: Vec<f64> = time_s.iter().map(|t| 2.0 - (-t).exp()).collect();
    let time = Axis::new("time", "s");
    let plot = |name: &str, unit: &str, values| {
        let plot = LinePlot::new("", time.clone(), Axis::new(name, unit)).height(140.0);
        Panel::Plot(plot.with(Series::line("", &time_s, values)))
    };
    let stack = Stack::new(time.clone())
        .with(plot("height", "m", &height_m))
        .with(plot("speed", "m/s", &speed_m_s));
    std::fs::write(folder.join("flight.svg"), stack.draw()?.to_svg())?;
    Ok(())
}
