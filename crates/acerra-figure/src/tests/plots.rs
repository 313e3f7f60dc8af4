//! Tests of line plots and maps.

use super::*;

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

#[test]
fn drawings_of_a_sheet_stand_in_rows_and_columns() {
    let values = [0.0_f32, -10.0, -20.0, -30.0];
    let panel = |is_last: bool| {
        let mut image = ImageDb::new("panel", PixelValues::Decibel(&values), 2, 2);
        image.colour_bar = is_last;
        image.plot_height_px = 250.0;
        image.draw().unwrap()
    };
    let (plain, barred) = (panel(false), panel(true));
    let row = || vec![panel(false), panel(true)];
    let drawing = sheet(vec![row(), row(), vec![panel(false)]]);
    Picture::of("sheet", &drawing);
    assert_eq!(drawing.width_px, plain.width_px + barred.width_px);
    let row_px = plain.height_px.max(barred.height_px);
    assert_eq!(drawing.height_px, 2 * row_px + plain.height_px);
    let places: Vec<(f32, f32)> = drawing
        .items
        .iter()
        .filter_map(|item| match item {
            // Colour bars are narrow rasters.
            drawing::Item::Raster { rect, .. } if rect.width > 100.0 => Some((rect.x, rect.y)),
            _ => None,
        })
        .collect();
    let first = plot_of(&plain);
    let second = plot_of(&barred);
    let (right, down) = (plain.width_px as f32, row_px as f32);
    let pair = |row: f32| {
        let y = row * down;
        [(first.x, first.y + y), (right + second.x, second.y + y)]
    };
    let mut expected = [pair(0.0), pair(1.0)].concat();
    expected.push((first.x, first.y + 2.0 * down));
    assert_eq!(places, expected);
    assert_eq!(sheet(Vec::new()).width_px, 0);
}
