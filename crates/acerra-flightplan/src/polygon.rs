//! The area as a polygon in metres.

use super::PlanError;

/// A point, east and north or along and across (m).
pub(super) type Point = [f64; 2];

/// A simple polygon (m), closed by itself.
#[derive(Clone, Debug)]
pub(super) struct Polygon(Vec<Point>);

fn cross(o: Point, a: Point, b: Point) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

impl Polygon {
    /// A polygon that encloses something and does not cross itself.
    pub fn new(corners: Vec<Point>) -> Result<Self, PlanError> {
        let n = corners.len();
        let polygon = Self(corners);
        let (low, high) = polygon.bounds();
        if high[0] - low[0] > 20e3 || high[1] - low[1] > 20e3 {
            return Err(PlanError::Impossible(format!(
                "the area measures {:.0} m × {:.0} m; a plan covers up to 20 km",
                high[0] - low[0],
                high[1] - low[1]
            )));
        }
        let edges: Vec<(Point, Point)> = polygon.edges().collect();
        for i in 0..n {
            for j in i + 2..n {
                if i == 0 && j == n - 1 {
                    continue; // Neighbours.
                }
                let ((a, b), (c, d)) = (edges[i], edges[j]);
                if cross(a, b, c) * cross(a, b, d) < 0.0 && cross(c, d, a) * cross(c, d, b) < 0.0 {
                    return Err(PlanError::Impossible(format!(
                        "the sides of the area that follow corners {} and {} cross",
                        i + 1,
                        j + 1
                    )));
                }
            }
        }
        if polygon.area_m2() < 1.0 {
            return Err(PlanError::Impossible(format!(
                "the corners enclose {:.2} m²; an area of 1 m² or more is expected",
                polygon.area_m2()
            )));
        }
        Ok(polygon)
    }

    pub fn corners(&self) -> &[Point] {
        &self.0
    }

    pub fn edges(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let next = self.0.iter().cycle().skip(1);
        self.0.iter().zip(next).map(|(a, b)| (*a, *b))
    }

    pub fn area_m2(&self) -> f64 {
        0.5 * self
            .edges()
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
            .sum::<f64>()
            .abs()
    }

    pub fn bounds(&self) -> (Point, Point) {
        let first = self.0[0];
        self.0.iter().fold((first, first), |(low, high), p| {
            (
                [low[0].min(p[0]), low[1].min(p[1])],
                [high[0].max(p[0]), high[1].max(p[1])],
            )
        })
    }

    pub fn map(&self, f: impl Fn(Point) -> Point) -> Self {
        Self(self.0.iter().map(|p| f(*p)).collect())
    }

    pub fn contains(&self, [x, y]: Point) -> bool {
        let mut inside = false;
        for (a, b) in self.edges() {
            if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                inside = !inside;
            }
        }
        inside
    }

    /// Least and greatest abscissa of the part with ordinates from `low` to `high`; none when
    /// there is none.
    pub fn extent_between(&self, low: f64, high: f64) -> Option<(f64, f64)> {
        let mut extent: Option<(f64, f64)> = None;
        let mut take = |x: f64| {
            extent = Some(extent.map_or((x, x), |(a, b)| (a.min(x), b.max(x))));
        };
        for (a, b) in self.edges() {
            if (low..=high).contains(&a[1]) {
                take(a[0]);
            }
            for level in [low, high] {
                if (a[1] - level) * (b[1] - level) < 0.0 {
                    take(a[0] + (level - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
                }
            }
        }
        extent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn l_shape() -> Polygon {
        Polygon::new(vec![
            [0.0, 0.0],
            [10.0, 0.0],
            [10.0, 2.0],
            [3.0, 2.0],
            [3.0, 6.0],
            [0.0, 6.0],
        ])
        .expect("simple")
    }

    #[test]
    fn inside_extent_and_area() {
        let l = l_shape();
        assert_eq!(l.area_m2(), 32.0);
        assert!(l.contains([9.0, 1.0]) && l.contains([1.0, 5.0]) && !l.contains([9.0, 3.0]));
        assert_eq!(l.extent_between(0.5, 1.5), Some((0.0, 10.0)));
        assert_eq!(l.extent_between(3.0, 5.0), Some((0.0, 3.0)));
        assert_eq!(l.extent_between(7.0, 8.0), None);
    }

    #[test]
    fn what_is_no_area() {
        let bow = vec![[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]];
        let error = Polygon::new(bow).expect_err("crosses").to_string();
        assert_eq!(
            error,
            "the sides of the area that follow corners 1 and 3 cross"
        );
        let thin = vec![[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]];
        assert!(Polygon::new(thin).is_err());
        assert!(Polygon::new(vec![[0.0, 0.0], [3e4, 0.0], [3e4, 9.0]]).is_err());
    }
}
