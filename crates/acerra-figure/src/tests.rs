//! What the figures show, read back from their pixels.

use super::frame::{Frame, FrameSpec, Size};
use super::*;
use num_complex::Complex32;

struct Picture {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
    scale: u32,
}

impl Picture {
    fn of(name: &str, drawing: &Drawing) -> Self {
        // For looking at: ACERRA_FIGURES=/some/dir cargo test -p acerra figure
        if let Ok(dir) = std::env::var("ACERRA_FIGURES") {
            std::fs::write(format!("{dir}/{name}.png"), drawing.to_png().unwrap()).unwrap();
            std::fs::write(format!("{dir}/{name}.svg"), drawing.to_svg()).unwrap();
        }
        let (width, height, rgb) = drawing.to_rgb().unwrap();
        assert_eq!(
            (width, height),
            (
                drawing.width_px * drawing.scale,
                drawing.height_px * drawing.scale
            )
        );
        Self {
            width,
            height,
            rgb,
            scale: drawing.scale,
        }
    }

    /// The colour at CSS pixel (x, y).
    fn at(&self, x: f32, y: f32) -> [u8; 3] {
        let (x, y) = (
            (x * self.scale as f32) as usize,
            (y * self.scale as f32) as usize,
        );
        let i = 3 * (y * self.width as usize + x);
        [self.rgb[i], self.rgb[i + 1], self.rgb[i + 2]]
    }

    /// The CSS pixels (mean place) whose colour `wanted` accepts, and their number.
    fn find(&self, wanted: impl Fn([u8; 3]) -> bool) -> (f32, f32, usize) {
        let (mut x, mut y, mut n) = (0.0, 0.0, 0usize);
        for row in 0..self.height as usize {
            for column in 0..self.width as usize {
                let i = 3 * (row * self.width as usize + column);
                if wanted([self.rgb[i], self.rgb[i + 1], self.rgb[i + 2]]) {
                    x += column as f64 + 0.5;
                    y += row as f64 + 0.5;
                    n += 1;
                }
            }
        }
        let unit = n as f64 * f64::from(self.scale);
        ((x / unit) as f32, (y / unit) as f32, n)
    }
}

fn near(a: [u8; 3], b: [u8; 3], tolerance: u8) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= tolerance)
}

/// The plot rectangle of an image without title, legend and marks, found from its raster.
fn plot_of(drawing: &Drawing) -> drawing::Rect {
    drawing
        .items
        .iter()
        .find_map(|item| match item {
            drawing::Item::Raster { rect, .. } => Some(*rect),
            _ => None,
        })
        .expect("the image's raster comes first")
}

#[test]
fn a_single_bright_pixel_survives_a_large_image_at_its_place() {
    let (nx, ny) = (3000, 2400);
    let mut amplitude = vec![1e-3_f32; nx * ny];
    let (column, row) = (700, 2000);
    amplitude[row * nx + column] = 1.0;
    let drawing = ImageDb::new("", PixelValues::Amplitude(&amplitude), nx, ny)
        .at(-10.0, 5.0, 0.01)
        .draw()
        .unwrap();
    let picture = Picture::of("bright-pixel", &drawing);
    let plot = plot_of(&drawing);
    let top = Palette::Inferno.at(1.0);
    // The colour bar holds the colour too, beyond the plot.
    let inside = |x: f32| x < plot.right();
    let (_, _, all) = picture.find(|c| near(c, top, 3));
    assert!(all >= 1);
    let mut found = Vec::new();
    for y in 0..picture.height {
        for x in 0..picture.width {
            let at = (x as f32 / 2.0 + 0.1, y as f32 / 2.0 + 0.1);
            if inside(at.0) && near(picture.at(at.0, at.1), top, 3) {
                found.push(at);
            }
        }
    }
    assert_eq!(found.len(), 1, "one device pixel: {found:?}");
    let want_x = plot.x + plot.width * (column as f32 + 0.5) / nx as f32;
    let want_y = plot.bottom() - plot.height * (row as f32 + 0.5) / ny as f32;
    assert!((found[0].0 - want_x).abs() <= 1.0 && (found[0].1 - want_y).abs() <= 1.0);
}

#[test]
fn a_small_image_is_enlarged_crisply_with_row_0_at_the_bottom() {
    // Levels 0, −10, −20 and −30 dB; −30 lies at the top right.
    let values = [0.0_f32, -10.0, -20.0, -30.0];
    let drawing = ImageDb::new("", PixelValues::Decibel(&values), 2, 2)
        .at(0.5, 0.5, 1.0)
        .draw()
        .unwrap();
    let picture = Picture::of("two-by-two", &drawing);
    let plot = plot_of(&drawing);
    assert_eq!(plot.width, plot.height, "equal aspect");
    for (i, level) in values.iter().enumerate() {
        let want = Palette::Inferno.at(1.0 + f64::from(*level) / 40.0);
        for (dx, dy) in [(0.04, 0.04), (0.46, 0.46), (0.25, 0.25)] {
            let x = plot.x + plot.width * (0.5 * (i % 2) as f32 + dx);
            let y = plot.bottom() - plot.height * (0.5 * (i / 2) as f32 + dy);
            assert!(near(picture.at(x, y), want, 2), "cell {i} at {dx}, {dy}");
        }
    }
}

#[test]
fn targets_and_track_stand_at_their_coordinates() {
    let n = 180;
    let values = vec![Complex32::new(1e-6, 0.0); n * n];
    let values = {
        let mut values = values;
        values[0] = Complex32::new(0.0, 2.0);
        values
    };
    let track: Vec<[f64; 2]> = (0..=180).map(|i| [f64::from(i) * 0.1, 3.0]).collect();
    let mut image = ImageDb::new("", PixelValues::Complex(&values), n, n).at(0.0, -9.0, 0.1);
    image.track_m = &track;
    image.targets.push(TargetMark {
        x_m: 9.0,
        y_m: -4.0,
        label: "1".to_owned(),
    });
    image.ghosts.push(GhostMark {
        x_m: 9.0,
        y_m: 5.0,
        label: String::new(),
    });
    let drawing = image.draw().unwrap();
    let picture = Picture::of("marks", &drawing);
    let plot = plot_of(&drawing);
    let place = |x: f32, y: f32| {
        (
            plot.x + plot.width * (x + 0.05) / 18.0,
            plot.bottom() - plot.height * (y + 9.05) / 18.0,
        )
    };
    let (x, y) = place(12.0, 3.0);
    assert!(
        near(picture.at(x, y), [255, 255, 255], 12),
        "the track is white"
    );
    let (x, y) = place(9.0, -4.0);
    for (dx, dy) in [(10.0, 0.0), (-10.0, 0.0), (0.0, 10.0), (0.0, -10.0)] {
        let colour = picture.at(x + dx, y + dy);
        assert!(
            colour[2] > 180 && colour[1] > 150,
            "ring at {dx}, {dy}: {colour:?}"
        );
    }
    assert!(
        near(picture.at(x, y), Palette::Inferno.at(0.0), 4),
        "the ring is hollow"
    );
}

#[test]
fn odd_images_are_blank_or_refused_but_never_panic() {
    for values in [
        vec![0.0_f32; 12],
        vec![f32::NAN; 12],
        vec![5.0; 12],
        vec![f32::INFINITY; 12],
    ] {
        for (nx, ny) in [(12, 1), (1, 12), (4, 3)] {
            let drawing = ImageDb::new("odd", PixelValues::Amplitude(&values), nx, ny)
                .draw()
                .unwrap();
            assert!(drawing.to_png().unwrap().len() > 500);
            assert!(drawing.to_svg().contains("<image"));
        }
    }
    let zero = ImageDb::new("", PixelValues::Amplitude(&[0.0]), 1, 1)
        .draw()
        .unwrap();
    let plot = plot_of(&zero);
    let picture = Picture::of("zero", &zero);
    let colour = picture.at(plot.x + 9.0, plot.y + 9.0);
    assert!(
        near(colour, Palette::Inferno.at(0.0), 2),
        "zero is at the floor"
    );

    let refused = |image: ImageDb<'_>| image.draw().unwrap_err();
    assert!(matches!(
        refused(ImageDb::new("", PixelValues::Amplitude(&[]), 0, 0)),
        FigureError::NothingToDraw { .. }
    ));
    assert!(matches!(
        refused(ImageDb::new("", PixelValues::Amplitude(&[1.0]), 2, 2)),
        FigureError::ShapeMismatch {
            expected: 4,
            found: 1,
            ..
        }
    ));
    let nan = ImageDb::new("", PixelValues::Amplitude(&[1.0]), 1, 1).at(f64::NAN, 0.0, 0.1);
    assert!(matches!(refused(nan), FigureError::NothingToDraw { .. }));
}

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

#[test]
fn a_line_passes_through_its_points() {
    let x = [0.0, 10.0];
    let y = [0.0, 0.0];
    let plot = LinePlot::new(
        "",
        Axis::new("x", "m"),
        Axis::new("y", "m").range(-1.0, 1.0),
    )
    .with(Series::line("", &x, &y));
    let picture = Picture::of("line", &plot.draw().unwrap());
    let blue = Colour::Series(0).rgb();
    let (_, y, n) = picture.find(|c| near(c, blue, 30));
    assert!(n > 1000, "{n} pixels of the line");
    // The plot is 280 pixels high and the line in its middle.
    let top = 18.0; // padding above a plot without title
    assert!((y - (top + 140.0)).abs() < 3.0, "line at {y}");
}

#[test]
fn line_plots_without_finite_points_are_empty_frames() {
    let nan = [f64::NAN, f64::INFINITY];
    for axis in [Axis::new("y", "m"), Axis::new("y", "m").log()] {
        let plot = LinePlot::new("empty", Axis::new("x", "m"), axis)
            .with(Series::line("a", &nan, &nan).band(&nan))
            .with(Series::dots("b", &[], &[]))
            .span(Span {
                x: [f64::NAN, 1.0],
                colour: Colour::Series(1),
                label: "s".to_owned(),
            })
            .reference(ReferenceLine {
                at_x: true,
                value: f64::NAN,
                label: "n".to_owned(),
            });
        assert!(plot.draw().unwrap().to_png().is_ok());
    }
    let short = LinePlot::new("", Axis::new("", ""), Axis::new("", "")).with(Series::line(
        "",
        &nan,
        &[1.0],
    ));
    assert!(matches!(
        short.draw(),
        Err(FigureError::ShapeMismatch { .. })
    ));
}

#[test]
fn a_million_points_make_a_small_drawing_that_keeps_the_spike() {
    let n = 1_000_000;
    let x: Vec<f64> = (0..n).map(f64::from).collect();
    let mut y = vec![0.0; n as usize];
    y[123_456] = 9.0;
    let plot = LinePlot::new(
        "",
        Axis::new("x", ""),
        Axis::new("y", "").range(-10.0, 10.0),
    )
    .with(Series::line("", &x, &y));
    let svg = plot.draw().unwrap().to_svg();
    assert!(svg.len() < 100_000, "{} bytes", svg.len());
    let axes = [&Axis::new("x", ""), &Axis::new("y", "")];
    let size = Size::Free {
        width: 860.0,
        plot_height: 280.0,
    };
    let x_range = [0.0, f64::from(n - 1)];
    let frame = Frame::new(&FrameSpec::new(axes, x_range, [-10.0, 10.0], size));
    let (_, spike) = frame.at(0.0, 9.0).unwrap();
    assert!(
        svg.contains(&format!(",{}", (spike * 100.0).round() / 100.0)),
        "spike at {spike}"
    );
}

#[test]
fn log_axes_place_decades_evenly() {
    let axis = Axis::new("f", "Hz").log();
    assert_eq!(axis.scale, AxisScale::Log);
    let axes = [&axis, &Axis::new("", "")];
    let size = Size::Free {
        width: 600.0,
        plot_height: 100.0,
    };
    let frame = Frame::new(&FrameSpec::new(axes, [1.0, 1e4], [0.0, 1.0], size));
    let x = |v: f64| frame.at(v, 0.5).unwrap().0;
    assert!(((x(100.0) - x(1.0)) - (x(1e4) - x(100.0))).abs() < 0.01);
    assert!(frame.at(-1.0, 0.5).is_none(), "no place for negatives");
}

#[test]
fn maps_place_values_and_contours() {
    let (columns, rows) = (60, 40);
    let values: Vec<f64> = (0..columns * rows).map(|i| (i % columns) as f64).collect();
    let map = Map::new(
        "",
        Axis::new("a", "m"),
        Axis::new("b", "m"),
        &values,
        columns,
        rows,
    )
    .contours(&[30.0])
    .values_are("a (m)");
    let drawing = map.draw().unwrap();
    let picture = Picture::of("map", &drawing);
    let plot = plot_of(&drawing);
    let at = |share: f32| picture.at(plot.x + plot.width * share, plot.y + 20.0);
    assert!(near(at(0.005), Palette::Viridis.at(0.0), 3));
    assert!(near(at(0.995), Palette::Viridis.at(1.0), 3));
    assert!(
        near(at(30.5 / 60.0), [255, 255, 255], 20),
        "the contour is white"
    );
    let nan = vec![f64::NAN; 4];
    let blank = Map::new("", Axis::new("", ""), Axis::new("", ""), &nan, 2, 2).contours(&[1.0]);
    assert!(blank.draw().unwrap().to_png().is_ok());
}

#[test]
fn bytes_are_the_same_every_time() {
    let x: Vec<f64> = (0..50).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| (x * 0.3).sin()).collect();
    let plot = || {
        LinePlot::new("Twice", Axis::new("x", "m"), Axis::new("y", "m"))
            .with(Series::line("sine", &x, &y).band(&y))
            .draw()
            .unwrap()
    };
    assert_eq!(plot().to_png().unwrap(), plot().to_png().unwrap());
    assert_eq!(plot().to_svg(), plot().to_svg());
}

#[test]
fn texts_are_escaped_in_svg() {
    let plot = LinePlot::new("<b>&\"", Axis::new("a<b", "m"), Axis::new("y", "m"));
    let svg = plot.draw().unwrap().to_svg();
    assert!(!svg.contains("<b>") && svg.contains("&lt;b&gt;&amp;"));
}

/// A gallery for the eye, with everything that the figures can show.
#[test]
fn gallery_of_everything() {
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
    let track: Vec<[f64; 2]> = (0..330)
        .map(|i| f64::from(i) * 0.05)
        .map(|x| [x, 0.3 * (0.4 * x).sin()])
        .collect();
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

    let (traces, per_trace) = (331, 1600);
    let height = |t: usize| 10.0 + 0.4 * (t as f64 * 0.03).sin();
    let samples: Vec<f32> = (0..traces * per_trace)
        .map(|i| {
            let (trace, fast) = (i / per_trace, (i % per_trace) as f64 * 0.061 - 5.0);
            let echo = |at: f64, a: f64| {
                let t = fast - at;
                a * (-t * t * 2.5).exp() * (t * 24.8).cos()
            };
            let surface = height(trace) / 0.15;
            let range = (height(trace).powi(2) + (trace as f64 * 0.1 - 15.0).powi(2) + 4.0).sqrt();
            let noise = ((i * 7919 % 2003) as f64 / 2003.0 - 0.5) * 60.0;
            (echo(0.0, 20000.0) + echo(surface, 3000.0) + echo(range / 0.15, 900.0) + noise) as f32
        })
        .collect();
    let time: Vec<f64> = (0..traces).map(|t| t as f64 * 0.07).collect();
    let surface: Vec<f64> = (0..traces).map(|t| height(t) / 0.15).collect();
    let curve = |label: &str, shift: f64, dashed| FastTimeCurve {
        label: label.to_owned(),
        fast_time_ns: surface.iter().map(|s| s + shift).collect(),
        dashed,
    };
    let mut radargram =
        Radargram::new("Raw radargram", &samples, traces, per_trace).fast_time(-5.0, 0.061);
    radargram.time_s = &time;
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

    let heights: Vec<f64> = (0..traces).map(height).collect();
    let sigma: Vec<f64> = (0..traces)
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

    let (x, y): (Vec<f64>, Vec<f64>) = track.iter().map(|p| (p[0], p[1])).unzip();
    let plan = LinePlot::new("Plan", Axis::new("east", "m"), Axis::new("north", "m"))
        .with(Series::line("track", &x, &y))
        .equal()
        .height(400.0);
    Picture::of("gallery-plan", &plan.draw().unwrap());
}

#[test]
fn legends_name_only_what_is_inside_the_image() {
    let values = [1.0_f32; 100];
    let outside: Vec<[f64; 2]> = (0..10).map(|i| [f64::from(i), -50.0]).collect();
    let mut image = ImageDb::new("", PixelValues::Amplitude(&values), 10, 10).at(0.0, 0.0, 1.0);
    image.track_m = &outside;
    let target = |x_m: f64| TargetMark {
        x_m,
        y_m: 5.0,
        label: "1".to_owned(),
    };
    let survey = |x_m: f64| SurveyMark {
        x_m,
        y_m: 2.0,
        label: "A".to_owned(),
        target_distance_m: Some(0.314),
    };
    image.targets = vec![target(40.0)];
    image.survey = vec![survey(-3.0)];
    image.ghosts.push(GhostMark {
        x_m: f64::NAN,
        y_m: 0.0,
        label: "ghost".to_owned(),
    });
    let svg = image.draw().unwrap().to_svg();
    for word in ["radar track", "target", "ghost", "surveyed"] {
        assert!(!svg.contains(word), "{word} is named");
    }
    image.targets = vec![target(4.0)];
    image.survey = vec![survey(5.0)];
    let svg = image.draw().unwrap().to_svg();
    assert!(svg.contains(">target<") && svg.contains("surveyed point, with its distance"));
    assert!(svg.contains(">A 0.31 m<"));
}

#[test]
fn crowded_marks_keep_their_numbers_apart_and_inside() {
    let n = 100;
    let values = vec![1.0_f32; n * n];
    let mut image = ImageDb::new("", PixelValues::Amplitude(&values), n, n).at(0.0, 0.0, 1.0);
    for k in 0..50 {
        // Half of them within a tenth of the image, some on its very edge.
        let (x_m, y_m) = match k % 4 {
            0 => (f64::from(k * 7 % 100), f64::from(k * 13 % 100)),
            1 => (99.4, f64::from(2 * k)),
            _ => (40.0 + f64::from(k * 3 % 10), 50.0 + f64::from(k * 7 % 10)),
        };
        image.targets.push(TargetMark {
            x_m,
            y_m,
            label: (k + 1).to_string(),
        });
    }
    let drawing = image.draw().unwrap();
    Picture::of("crowded", &drawing);
    let plot = plot_of(&drawing);
    let clipped = drawing.items.iter().find_map(|item| match item {
        drawing::Item::Clip { items, .. } => Some(items),
        _ => None,
    });
    let mut texts: Vec<drawing::Rect> = Vec::new();
    for item in clipped.expect("marks are clipped to the plot") {
        let drawing::Item::Text(text) = item else {
            continue;
        };
        let rect = drawing::Rect {
            x: text.x,
            y: text.y - 0.8 * text.size,
            width: text.width(),
            height: text.size,
        };
        assert!(plot.encloses(&rect), "{} leaves the plot", text.text);
        for other in &texts {
            assert!(!other.overlaps(&rect), "{} overlaps", text.text);
        }
        texts.push(rect);
    }
    assert!(texts.len() > 25, "{} numbers are drawn", texts.len());
}

#[test]
fn a_gain_for_display_lifts_what_lies_far() {
    // Near clutter is 60 dB above a far reflector, which the gain lifts by 60 dB.
    let mut values = vec![1e-6_f32; 64 * 64];
    values[5] = 1.0;
    values[63 * 64 + 40] = 1e-3;
    let mut image = ImageDb::new("", PixelValues::Amplitude(&values), 64, 64).at(0.0, 0.0, 1.0);
    let brightest = |image: &ImageDb<'_>, row: usize| {
        let drawing = image.draw().unwrap();
        let (picture, plot) = (Picture::of("gain", &drawing), plot_of(&drawing));
        let column = if row == 0 { 5.5 } else { 40.5 };
        picture.at(
            plot.x + plot.width * column / 64.0,
            plot.bottom() - plot.height * (row as f32 + 0.5) / 64.0,
        )
    };
    assert!(near(brightest(&image, 63), Palette::Inferno.at(0.0), 2));
    image.gain = Some(DisplayGain::sample(
        "60 dB from top to bottom",
        [-0.5, 63.5],
        [-0.5, 63.5],
        |_, y| 60.0 * y / 63.0,
    ));
    assert!(near(brightest(&image, 63), Palette::Inferno.at(1.0), 12));
    assert!(near(brightest(&image, 0), Palette::Inferno.at(1.0), 12));
    assert!(image.draw().unwrap().to_svg().contains("60 dB from top"));
}

#[test]
fn stacked_plots_share_one_axis() {
    let (a, b) = ([0.0, 10.0], [5.0, 30.0]);
    let y = [1.0, 1e5];
    let time = Axis::new("time", "s");
    let plot = |x, label: &str| {
        let plot = LinePlot::new("", time.clone(), Axis::new(label, "m"));
        Panel::Plot(plot.with(Series::line("", x, &y)).height(100.0))
    };
    let drawing = Stack::new(time.clone())
        .with(plot(&a, "first"))
        .with(plot(&b, "second"))
        .with(Panel::Timeline(Timeline {
            title: String::new(),
            x: time.clone(),
            rows: vec![TimelineRow {
                label: "a rather long name of a state".to_owned(),
                colour: Colour::Series(1),
                stretches: vec![[0.0, 1.0]],
            }],
            width_px: 100.0,
        }))
        .draw()
        .unwrap();
    Picture::of("stack", &drawing);
    let clips: Vec<_> = drawing
        .items
        .iter()
        .filter_map(|item| match item {
            drawing::Item::Clip { rect, .. } => Some(*rect),
            _ => None,
        })
        .collect();
    assert_eq!(clips.len(), 3);
    assert!(
        clips
            .windows(2)
            .all(|w| w[0].x == w[1].x && w[0].width == w[1].width)
    );
    assert!(clips.windows(2).all(|w| w[0].bottom() < w[1].y));
    assert_eq!(drawing.to_svg().matches(">time (s)<").count(), 1);
    assert!(matches!(
        Stack::new(time).draw(),
        Err(FigureError::NothingToDraw { .. })
    ));
}
