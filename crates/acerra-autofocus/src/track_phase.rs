//! Initial values of the phase offsets between tracks.
//!
//! Phases have no prior value, and steps of an estimate lead to the nearest maximum. All points agree on the
//! phase between the sums of two tracks' echoes.

use crate::fit::{Problem, Seen, Stage};
use crate::globals::Effect;
use crate::model::Model;

impl Problem<'_> {
    /// Start of a stage: track phases are initialised from the points' echoes where this explains more of the
    /// data.
    pub fn begin(&self, model: Model, stage: Stage, guides: &[bool]) -> (Model, Seen) {
        let seen = self.seen(&model);
        if stage == Stage::Envelope || model.places.is_empty() {
            return (model, seen);
        }
        let aligned = self.with_turns(&model, &seen, guides);
        if aligned.globals == model.globals {
            return (model, seen);
        }
        let aligned_seen = self.seen(&aligned);
        let noise = seen.histories.noise;
        let score = |model: &Model, seen: &Seen| self.objective(model, seen, stage, noise);
        if score(&aligned, &aligned_seen) < score(&model, &seen) {
            (aligned, aligned_seen)
        } else {
            (model, seen)
        }
    }

    /// Aligns the phase parameter of each track to the pulses without a phase parameter, or to the first track
    /// where every track has a phase parameter.
    fn with_turns(&self, model: &Model, seen: &Seen, guides: &[bool]) -> Model {
        let own = self.globals.iter().enumerate();
        let phases: Vec<_> = own
            .filter_map(|(j, global)| match &global.effect {
                Effect::Phase(range) => Some((j, range)),
                _ => None,
            })
            .collect();
        let pulses = self.nominal_m.len();
        let mut is_reference = vec![true; pulses];
        for (_, range) in &phases {
            is_reference[(*range).clone()].fill(false);
        }
        let mut turning = phases.as_slice();
        if let (false, Some(((_, first), others))) =
            (is_reference.contains(&true), phases.split_first())
        {
            is_reference[(*first).clone()].fill(true);
            turning = others;
        }
        let mut turned = model.clone();
        for (j, range) in turning {
            let is_own: Vec<bool> = (0..pulses).map(|m| range.contains(&m)).collect();
            let histories = &seen.histories;
            if let Some(turn) = histories.turn_between(&is_own, &is_reference, guides) {
                let value = turned.globals[*j] + turn;
                turned.globals[*j] = value.sin().atan2(value.cos());
            }
        }
        turned
    }
}
