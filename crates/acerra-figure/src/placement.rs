//! Placement of labels next to marks without overlap.

use super::drawing::Rect;
use super::font;

/// The places that are taken within a plot.
pub(super) struct Placement {
    plot: Rect,
    taken: Vec<Rect>,
}

/// Where a label goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LabelPlace {
    /// Left end of the baseline.
    pub x: f32,
    /// The baseline.
    pub y: f32,
    /// From the mark's edge to the label, where the label is not adjacent to the mark.
    pub leader: Option<[(f32, f32); 2]>,
}

/// Room kept between labels and everything else.
const GAP: f32 = 2.0;
/// Distances of a label from the edge of its mark, tried in this order.
const DISTANCES: [f32; 5] = [3.0, 12.0, 24.0, 40.0, 60.0];
/// Directions tried at each distance, right first, y downwards.
const DIRECTIONS: [(f32, f32); 8] = [
    (0.92, -0.38),
    (-0.92, -0.38),
    (0.92, 0.38),
    (-0.92, 0.38),
    (0.0, -1.0),
    (0.0, 1.0),
    (0.6, -0.8),
    (-0.6, 0.8),
];

impl Placement {
    /// No place within `plot` is occupied yet.
    pub fn new(plot: Rect) -> Self {
        Self {
            plot,
            taken: Vec::new(),
        }
    }

    /// Keeps labels off a mark.
    pub fn take(&mut self, x: f32, y: f32, radius: f32) {
        self.taken.push(around(x, y, radius));
    }

    /// Takes the first free place for `text` next to a mark of `radius` about (x, y); none where
    /// there is no room inside the plot.
    pub fn label(
        &mut self,
        (x, y): (f32, f32),
        radius: f32,
        text: &str,
        size: f32,
    ) -> Option<LabelPlace> {
        let (width, height) = (font::width(text, size), size);
        let own = around(x, y, radius);
        for distance in DISTANCES {
            for (right, down) in DIRECTIONS {
                let reach = radius + distance;
                let (at_x, at_y) = (x + right * reach, y + down * reach);
                // The label hangs on the side that faces its mark.
                let left = at_x - width * (0.5 - 0.5 * right.clamp(-0.7, 0.7) / 0.7);
                let top = at_y - height * (0.5 - 0.5 * down);
                let rect = Rect {
                    x: left,
                    y: top,
                    width,
                    height,
                };
                let room = rect.grown(GAP);
                let free = self
                    .taken
                    .iter()
                    .all(|other| *other == own || !other.overlaps(&room));
                if self.plot.encloses(&room) && free && !own.overlaps(&rect) {
                    self.taken.push(rect);
                    let edge = (x + right * radius, y + down * radius);
                    return Some(LabelPlace {
                        x: left,
                        y: top + 0.8 * height,
                        leader: (distance > DISTANCES[0]).then_some([edge, (at_x, at_y)]),
                    });
                }
            }
        }
        None
    }
}

fn around(x: f32, y: f32, radius: f32) -> Rect {
    Rect {
        x: x - radius,
        y: y - radius,
        width: 2.0 * radius,
        height: 2.0 * radius,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_neither_overlap_nor_leave_the_plot() {
        let plot = Rect {
            x: 50.0,
            y: 20.0,
            width: 300.0,
            height: 200.0,
        };
        let mut placement = Placement::new(plot);
        let marks: Vec<(f32, f32)> = (0..40u16)
            .map(|i| {
                let (u, v) = (i * 37 % 100, i * 61 % 97);
                (50.0 + 3.0 * f32::from(u), 20.0 + 2.0 * f32::from(v))
            })
            .collect();
        for &(x, y) in &marks {
            placement.take(x, y, 5.0);
        }
        let mut placed: Vec<Rect> = Vec::new();
        for (i, &at) in marks.iter().enumerate() {
            let text = (i + 1).to_string();
            let Some(place) = placement.label(at, 5.0, &text, 13.0) else {
                continue;
            };
            let rect = Rect {
                x: place.x,
                y: place.y - 0.8 * 13.0,
                width: font::width(&text, 13.0),
                height: 13.0,
            };
            assert!(plot.encloses(&rect), "{rect:?}");
            assert!(placed.iter().all(|other| !other.overlaps(&rect)));
            assert!(
                marks
                    .iter()
                    .all(|&(x, y)| !around(x, y, 5.0).overlaps(&rect))
            );
            placed.push(rect);
        }
        assert!(placed.len() >= 36, "{} of 40 have a place", placed.len());
    }
}
