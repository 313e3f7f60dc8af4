//! Places of points under other models of the flight.

use nalgebra::{Matrix2, Vector2, Vector3};

use crate::fit::Problem;
use crate::ground::PixelPlace;
use crate::model::Model;

/// Gauss–Newton steps to a place.
const STEPS: usize = 8;
/// Regularisation as a share of the squared range gradient: it keeps places from diverging below the track.
const RIDGE: f64 = 1e-3;

impl Problem<'_> {
    /// Places of the points of `model` in an image made with `other`, whose globals may displace them: the
    /// places on the pixels whose ranges by `other` fit the points' ranges by `model` best. Without globals
    /// the places are unchanged.
    pub fn places_in(&self, other: &Model, model: &Model) -> Vec<PixelPlace> {
        if self.globals.is_empty() {
            return model.places.clone();
        }
        let there = other.with_places(model.places.clone());
        self.places_with(&there, &self.ranges_m(model))
    }

    /// The places on the pixels where the points of `model` have the ranges `wanted_m`, `[M][K]`, near their
    /// places in `model`.
    pub fn places_with(&self, model: &Model, wanted_m: &[Vec<f64>]) -> Vec<PixelPlace> {
        let antenna_m = self.positions_m(model);
        let of_point = |k: usize| {
            let wanted: Vec<f64> = wanted_m.iter().map(|ranges| ranges[k]).collect();
            self.place_at(model, &antenna_m, &wanted, model.places[k])
        };
        (0..model.places.len()).map(of_point).collect()
    }

    /// The place on the pixels of a model with the wanted ranges, m, near a first guess.
    fn place_at(
        &self,
        model: &Model,
        antenna_m: &[[f64; 3]],
        wanted_m: &[f64],
        guess: PixelPlace,
    ) -> PixelPlace {
        let ranging = self.ranging(model);
        let mut place = guess;
        for _ in 0..STEPS {
            let point = self.ground.point_m(place);
            let tangents = self.ground.tangents_m(place);
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for (m, (p, wanted)) in antenna_m.iter().zip(wanted_m).enumerate() {
                let from = Vector3::from(*p);
                let sight = (point - from).normalize();
                let slope = Vector2::new(sight.dot(&tangents[0]), sight.dot(&tangents[1]));
                normal += slope * slope.transpose();
                right += slope * (wanted - ranging.range_m(m, &from, &point));
            }
            for (i, tangent) in tangents.iter().enumerate() {
                normal[(i, i)] += RIDGE * antenna_m.len() as f64 * tangent.norm_squared();
            }
            let Some(inverse) = normal.try_inverse() else {
                break;
            };
            let step = inverse * right;
            place = [place[0] + step[0], place[1] + step[1]];
        }
        place
    }
}
