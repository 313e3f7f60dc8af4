//! A gallery for the eye, with everything that the figures can show.

use super::*;

const TRACES: usize = 331;

/// Height at a trace.
fn height_m(trace: usize) -> f64 {
    10.0 + 0.4 * (trace as f64 * 0.03).sin()
}

/// A track that wanders to both sides.
fn track_m() -> Vec<[f64; 2]> {
    (0..330)
        .map(|i| f64::from(i) * 0.05)
        .map(|x| [x, 0.3 * (0.4 * x).sin()])
        .collect()
}

#[test]
fn an_image_with_targets_ghosts_and_track() {
    let n = 600;
    let psf = |x: f64, y: f64, x0: f64, y0: f64| {
        let (u, v) = ((x - x0) * 40.0, (y - y0) * 9.0);
        let s = |t: f64| if t.abs() < 1e-9 { 1.0 } else { t.sin() / t };
        s(u) * s(v)
    };
    let image: Vec<Complex32> = (0..n * n)
        .map(|i| {
            let (x, y) = ((i % n) as f64 * 0.03, (i / n) as f64 * 0.03 - 9.0);
            let ghost = 0.4 * psf(x, y, 4.0, -2.1) + 0.35 * psf(x, y, 14.0, -2.3);
            let v = psf(x, y, 4.0, 2.0) + 0.8 * psf(x, y, 14.0, 2.0) + ghost;
            Complex32::new(
                v as f32 + 0.004 * ((i * 7919 % 1000) as f32 / 1000.0 - 0.5),
                0.0,
            )
        })
        .collect();
    let track = track_m();
    let mut figure = ImageDb::new(
        "Track 2: focused image, 18 × 18 m at 3 cm",
        PixelValues::Complex(&image),
        n,
        n,
    )
    .at(0.0, -9.0, 0.03);
    figure.track_m = &track;
    for (label, x_m, y_m) in [("1", 4.0, 2.0), ("2", 14.0, 2.0)] {
        figure.targets.push(TargetMark {
            x_m,
            y_m,
            label: label.to_owned(),
        });
        figure.ghosts.push(GhostMark {
            x_m,
            y_m: -2.2,
            label: format!("ghost of {label}"),
        });
    }
    Picture::of("gallery-image", &figure.draw().unwrap());
}

#[test]
fn radargrams_with_surface_and_gate() {
    let (traces, per_trace) = (TRACES, 1600);
    let samples: Vec<f32> = (0..traces * per_trace)
        .map(|i| {
            let (trace, fast) = (i / per_trace, (i % per_trace) as f64 * 0.061 - 5.0);
            let echo = |at: f64, a: f64| {
                let t = fast - at;
                a * (-t * t * 2.5).exp() * (t * 24.8).cos()
            };
            let surface = height_m(trace) / 0.15;
            let range =
                (height_m(trace).powi(2) + (trace as f64 * 0.1 - 15.0).powi(2) + 4.0).sqrt();
            let noise = ((i * 7919 % 2003) as f64 / 2003.0 - 0.5) * 60.0;
            (echo(0.0, 20000.0) + echo(surface, 3000.0) + echo(range / 0.15, 900.0) + noise) as f32
        })
        .collect();
    let time: Vec<f64> = (0..traces).map(|t| t as f64 * 0.07).collect();
    let surface: Vec<f64> = (0..traces).map(|t| height_m(t) / 0.15).collect();
    let curve = |label: &str, shift: f64, dashed| FastTimeCurve {
        label: label.to_owned(),
        fast_time_ns: surface.iter().map(|s| s + shift).collect(),
        dashed,
    };
    let mut radargram =
        Radargram::new("Raw radargram", &samples, traces, per_trace).fast_time(-5.0, 0.061);
    radargram.top = &time;
    radargram.curves = vec![
        curve("2h/c", 0.0, false),
        curve("gate", -6.0, true),
        curve("gate", 24.0, true),
    ];
    radargram.colours = RadargramColours::Signed {
        limit: Some(3000.0),
    };
    Picture::of("gallery-radargram", &radargram.draw().unwrap());
    radargram.colours = RadargramColours::Decibel { floor_db: -60.0 };
    radargram.title = "Radargram in decibels".to_owned();
    Picture::of("gallery-radargram-db", &radargram.draw().unwrap());
}

#[test]
fn lines_with_bands_spans_and_references() {
    let time: Vec<f64> = (0..TRACES).map(|t| t as f64 * 0.07).collect();
    let heights: Vec<f64> = (0..TRACES).map(height_m).collect();
    let sigma: Vec<f64> = (0..TRACES)
        .map(|t| 0.02 + 0.05 * (t as f64 / 331.0))
        .collect();
    let other: Vec<f64> = heights.iter().map(|h| h + 0.05).collect();
    let plot = LinePlot::new(
        "Height above the image plane",
        Axis::new("time", "s"),
        Axis::new("height", "m"),
    )
    .with(Series::line("PPK ±1σ", &time, &heights).band(&sigma))
    .with(Series::dots("picked surface", &time, &other))
    .with(Series::line("planned", &[0.0, 23.0], &[10.0, 10.0]).dashed())
    .span(Span {
        x: [3.0, 6.0],
        colour: Colour::Series(1),
        label: "float".to_owned(),
    })
    .reference(ReferenceLine {
        at_x: true,
        value: 12.0,
        label: "turn".to_owned(),
    });
    Picture::of("gallery-lines", &plot.draw().unwrap());
}

#[test]
fn cuts_in_decibels() {
    let distance: Vec<f64> = (-200..=200).map(|i| f64::from(i) * 0.01).collect();
    let level = |k: f64| -> Vec<f64> {
        distance
            .iter()
            .map(|d| 20.0 * ((k * d).sin() / (k * d)).abs().log10())
            .collect()
    };
    let (along, across) = (level(40.0), level(7.0));
    let cuts = [
        ("along track", &distance[..], &along[..]),
        ("across track", &distance[..], &across[..]),
    ];
    Picture::of(
        "gallery-cuts",
        &cut_plot("Cuts through target 1", &cuts, -40.0)
            .draw()
            .unwrap(),
    );
}

#[test]
fn a_map_with_contours() {
    let (columns, rows) = (121, 76);
    let across: Vec<f64> = (0..columns * rows)
        .map(|i| {
            let (d, h) = (
                0.05 * (i % columns) as f64,
                2.0 + (i / columns) as f64 * 0.24,
            );
            let dr = 0.0882;
            ((((h * h + d * d).sqrt() + dr).powi(2) - h * h).sqrt() - d).min(3.0)
        })
        .collect();
    let mut map = Map::new(
        "Across-track resolution",
        Axis::new("offset", "m"),
        Axis::new("height", "m"),
        &across,
        columns,
        rows,
    )
    .grid([0.0, 0.05], [2.0, 0.24])
    .contours(&[0.15, 0.2, 0.3, 0.5, 0.8, 1.2])
    .values_are("across-track resolution (m)");
    map.log_colours = true;
    Picture::of("gallery-map", &map.draw().unwrap());
}

#[test]
fn logarithmic_axes() {
    let frequency: Vec<f64> = (1..400).map(|i| f64::from(i) * 25.0).collect();
    let power: Vec<f64> = frequency
        .iter()
        .map(|f| 1e3 / (1.0 + (f / 300.0).powi(4)))
        .collect();
    let log = LinePlot::new(
        "Logarithmic",
        Axis::new("frequency", "Hz").log(),
        Axis::new("power", "W").log(),
    )
    .with(Series::line("", &frequency, &power));
    Picture::of("gallery-log", &log.draw().unwrap());
}

#[test]
fn a_plan_with_equal_axes() {
    let (x, y): (Vec<f64>, Vec<f64>) = track_m().iter().map(|p| (p[0], p[1])).unzip();
    let plan = LinePlot::new("Plan", Axis::new("east", "m"), Axis::new("north", "m"))
        .with(Series::line("track", &x, &y))
        .equal()
        .height(400.0);
    Picture::of("gallery-plan", &plan.draw().unwrap());
}
