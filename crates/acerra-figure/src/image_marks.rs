//! Marks on an image: track, targets, ghosts and surveyed points.

use super::colour::Colour;
use super::drawing::{Item, Stroke, Text, line};
use super::frame::Frame;
use super::legend::{DARK, Entry, Marker, Sample, mark};
use super::placement::Placement;
use super::polyline::thin;

/// A target to be marked and numbered.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetMark {
    /// East or along-track coordinate in metres.
    pub x_m: f64,
    /// North or across-track coordinate in metres.
    pub y_m: f64,
    /// Label next to the mark, usually the target's number in the table of targets.
    pub label: String,
}

/// A left–right ghost to be marked.
#[derive(Clone, Debug, PartialEq)]
pub struct GhostMark {
    /// East or along-track coordinate in metres.
    pub x_m: f64,
    /// North or across-track coordinate in metres.
    pub y_m: f64,
    /// Label next to the mark; may be empty.
    pub label: String,
}

/// A point whose place is known from a survey.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyMark {
    /// East or along-track coordinate in metres.
    pub x_m: f64,
    /// North or across-track coordinate in metres.
    pub y_m: f64,
    /// Name.
    pub label: String,
    /// Distance to its target, in metres; none where it has no target.
    pub target_distance_m: Option<f64>,
}

impl SurveyMark {
    fn text(&self) -> String {
        match self.target_distance_m {
            Some(distance_m) if distance_m.is_finite() => {
                format!("{} {distance_m:.2} m", self.label)
                    .trim()
                    .to_owned()
            }
            _ => self.label.clone(),
        }
    }
}

/// Everything that is marked on one image.
#[derive(Clone, Copy)]
pub(super) struct Marks<'a> {
    pub track_m: &'a [[f64; 2]],
    pub targets: &'a [TargetMark],
    pub ghosts: &'a [GhostMark],
    pub survey: &'a [SurveyMark],
    /// Extent of the image in metres along x and y: marks outside are neither drawn nor named.
    pub x_range: [f64; 2],
    pub y_range: [f64; 2],
}

/// One mark as drawn.
struct Drawn {
    x: f32,
    y: f32,
    radius: f32,
    marker: Marker,
    labels: Vec<String>,
}

const RADIUS: f32 = 10.0;
const LEAST_RADIUS: f32 = 4.5;
const LABEL_SIZE: f32 = 13.0;
/// Names written out where several marks fall onto one place.
const MOST_NAMES: usize = 4;

impl Marks<'_> {
    fn inside(&self, x: f64, y: f64) -> bool {
        let within = |v: f64, [low, high]: [f64; 2]| v >= low && v <= high;
        within(x, self.x_range) && within(y, self.y_range)
    }

    /// The stretches of the track that are not broken by NaN.
    fn track_parts(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        self.track_m
            .split(|p| !p[0].is_finite() || !p[1].is_finite())
            .filter(|part| !part.is_empty())
    }

    /// Names of the visible marks.
    pub fn legend(&self) -> Vec<Entry> {
        let on_image = |label: &str, sample| Entry {
            label: label.to_owned(),
            sample,
            ground: Some(Colour::Rgb(0x3A, 0x2A, 0x50)),
        };
        let mut entries = Vec::new();
        if self.track_m.iter().any(|p| self.inside(p[0], p[1])) {
            entries.push(on_image(
                "radar track",
                Sample::Line(Stroke::new(TRACK, 1.6)),
            ));
            let begins = |part: &[[f64; 2]]| self.inside(part[0][0], part[0][1]);
            let name = if self.track_parts().any(begins) {
                "its beginning"
            } else {
                "where it enters the image"
            };
            entries.push(on_image(name, Sample::Mark(Marker::Triangle, START)));
        }
        if self.targets.iter().any(|t| self.inside(t.x_m, t.y_m)) {
            entries.push(on_image("target", Sample::Mark(Marker::Ring, TARGET)));
        }
        if self.ghosts.iter().any(|g| self.inside(g.x_m, g.y_m)) {
            entries.push(on_image(
                "its left–right ghost",
                Sample::Mark(Marker::DashedRing, GHOST),
            ));
        }
        let surveyed = self.survey.iter().filter(|s| self.inside(s.x_m, s.y_m));
        let mut with_distance = surveyed.clone().map(|s| s.target_distance_m.is_some());
        if surveyed.clone().next().is_some() {
            let name = if with_distance.any(|known| known) {
                "surveyed point, with its distance to the target"
            } else {
                "surveyed point"
            };
            entries.push(on_image(name, Sample::Mark(Marker::Cross, SURVEY)));
        }
        entries
    }

    /// The marks as shapes that stay within the plot.
    pub fn items(&self, frame: &Frame) -> Vec<Item> {
        let mut items = self.track_lines(frame);
        let mut placement = Placement::new(frame.plot);
        for part in self.track_parts() {
            // A track that begins outside is marked where it comes in.
            let start = part.iter().find(|p| self.inside(p[0], p[1]));
            if let Some((x, y)) = start.and_then(|p| frame.at(p[0], p[1])) {
                items.extend(mark(Marker::Triangle, x, y, 6.0, START));
                placement.take(x, y, 8.0);
            }
        }
        let drawn = self.drawn(frame);
        for one in &drawn {
            items.extend(mark(one.marker, one.x, one.y, one.radius, one.colour()));
            placement.take(one.x, one.y, one.radius);
        }
        let mut texts = Vec::new();
        for one in &drawn {
            let text = one.text();
            if text.is_empty() {
                continue;
            }
            let at = (one.x, one.y);
            let Some(place) = placement.label(at, one.radius, &text, LABEL_SIZE) else {
                continue;
            };
            if let Some(leader) = place.leader {
                items.push(line(leader.to_vec(), Stroke::new(DARK, 2.6).faint(0.5)));
                items.push(line(leader.to_vec(), Stroke::new(one.colour(), 1.0)));
            }
            let text = Text::new(place.x, place.y, LABEL_SIZE, text);
            texts.push(Item::Text(text.colour(one.colour()).halo(DARK)));
        }
        // Above all lines, which they may cross.
        items.extend(texts);
        items
    }

    fn track_lines(&self, frame: &Frame) -> Vec<Item> {
        let mut items = Vec::new();
        for part in self.track_parts() {
            let points: Vec<_> = part.iter().filter_map(|p| frame.at(p[0], p[1])).collect();
            let points = thin(points);
            if points.len() > 1 {
                items.push(line(points.clone(), Stroke::new(DARK, 3.6).faint(0.55)));
                items.push(line(points, Stroke::new(TRACK, 1.6)));
            }
        }
        items
    }

    /// Targets first, as they matter most, then surveyed points and ghosts; marks of one kind that
    /// would lie on each other become one with all their names, and radii shrink until neighbours
    /// do not touch.
    fn drawn(&self, frame: &Frame) -> Vec<Drawn> {
        let targets = self
            .targets
            .iter()
            .map(|t| (t.x_m, t.y_m, t.label.clone(), Marker::Ring));
        let survey = self
            .survey
            .iter()
            .map(|s| (s.x_m, s.y_m, s.text(), Marker::Cross));
        let ghosts = self
            .ghosts
            .iter()
            .map(|g| (g.x_m, g.y_m, g.label.clone(), Marker::DashedRing));
        let mut drawn: Vec<Drawn> = Vec::new();
        for (x_m, y_m, label, marker) in targets.chain(survey).chain(ghosts) {
            let Some((x, y)) = frame.at(x_m, y_m).filter(|_| self.inside(x_m, y_m)) else {
                continue;
            };
            let near = |one: &&mut Drawn| {
                one.marker == marker && (one.x - x).hypot(one.y - y) < 2.0 * LEAST_RADIUS
            };
            match drawn.iter_mut().find(near) {
                Some(one) => one.labels.push(label),
                None => drawn.push(Drawn {
                    x,
                    y,
                    radius: RADIUS,
                    marker,
                    labels: vec![label],
                }),
            }
        }
        let centres: Vec<(f32, f32)> = drawn.iter().map(|one| (one.x, one.y)).collect();
        for (i, one) in drawn.iter_mut().enumerate() {
            let others = centres.iter().enumerate().filter(|(k, _)| *k != i);
            let nearest = others
                .map(|(_, (x, y))| (one.x - x).hypot(one.y - y))
                .fold(f32::INFINITY, f32::min);
            one.radius = (0.5 * nearest - 1.0).clamp(LEAST_RADIUS, RADIUS);
        }
        drawn
    }
}

impl Drawn {
    fn colour(&self) -> Colour {
        match self.marker {
            Marker::Ring => TARGET,
            Marker::Cross => SURVEY,
            _ => GHOST,
        }
    }

    fn text(&self) -> String {
        let mut names = self.labels.iter().filter(|label| !label.is_empty());
        let written: Vec<&str> = names
            .by_ref()
            .take(MOST_NAMES)
            .map(String::as_str)
            .collect();
        let more = names.count();
        let text = written.join(", ");
        if more > 0 {
            format!("{text} +{more}")
        } else {
            text
        }
    }
}

const TRACK: Colour = Colour::Rgb(0xFF, 0xFF, 0xFF);
const START: Colour = Colour::Rgb(0x4A, 0xDE, 0x80);
const TARGET: Colour = Colour::Rgb(0x6E, 0xE7, 0xFF);
const GHOST: Colour = Colour::Rgb(0xD6, 0xDC, 0xE4);
const SURVEY: Colour = Colour::Rgb(0xB9, 0xFF, 0x66);
