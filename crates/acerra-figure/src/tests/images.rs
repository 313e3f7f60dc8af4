//! What images show.

use super::*;

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

/// Ends of a text along the direction in which it reads, and the room of the figure there.
fn ends(text: &drawing::Text, figure: &Drawing) -> ([f32; 2], f32) {
    let width = font::width(&text.text, text.size);
    let before = match text.anchor {
        drawing::Anchor::Start => 0.0,
        drawing::Anchor::Middle => 0.5 * width,
        drawing::Anchor::End => width,
    };
    if text.upwards {
        (
            [text.y + before - width, text.y + before],
            figure.height_px as f32,
        )
    } else {
        (
            [text.x - before, text.x - before + width],
            figure.width_px as f32,
        )
    }
}

#[test]
fn captions_of_flat_images_are_whole_on_desks_and_telephones() {
    for (nx, ny) in [(400, 20), (600, 8), (20, 400), (50, 50)] {
        let amplitude = vec![1.0_f32; nx * ny];
        let mut figure = ImageDb::new(
            "Volume from the south: greatest level along the other axis",
            PixelValues::Amplitude(&amplitude),
            nx,
            ny,
        )
        .at(0.0, 0.0, 0.05);
        figure.window = LevelWindow::Percentile { share: 0.5 };
        for width_px in [860.0, 360.0] {
            figure.width_px = width_px;
            let drawing = figure.draw().unwrap();
            Picture::of(&format!("flat-{nx}-{ny}-{width_px}"), &drawing);
            let mut said = 0;
            for item in &drawing.items {
                let drawing::Item::Text(text) = item else {
                    continue;
                };
                let ([from, to], room) = ends(text, &drawing);
                assert!(
                    from >= 0.0 && to <= room + 0.5,
                    "{nx} × {ny}: {text:?}: {to} of {room}"
                );
                said += usize::from(text.text.contains("maximum"));
            }
            assert_eq!(said, 1, "{nx} × {ny}");
        }
    }
}
