//! Forward, backward and trial pass of an attempt, and their confirmation of each other's fixes.

use crate::confirm::agreement::{Witness, confirm_by, contradictions};
use crate::filter::epoch_result::EpochResult;
use crate::options::{FilterDirection, PpkOptions};
use crate::passes::combine::combine;
use crate::passes::float_errors::FloatErrors;
use crate::passes::overlay::overlay;
use crate::passes::precision::scale_covariances;

/// The passes of an attempt before any fix is confirmed.
pub(crate) struct Passes {
    pub forward: Vec<EpochResult>,
    backward: Vec<EpochResult>,
    /// The trial pass, in order of processing: with its different noise it may have fixes where the other
    /// passes have none.
    trial: Vec<EpochResult>,
    /// Fixes of each pass as evidence.
    pub witnesses: [Witness; 2],
    float_errors: FloatErrors,
}

impl Passes {
    pub(crate) fn new(
        forward: Vec<EpochResult>,
        backward: Vec<EpochResult>,
        trial: Vec<EpochResult>,
        float_errors: FloatErrors,
    ) -> Self {
        let witnesses = [Witness::of(&forward), Witness::of(&backward)];
        Self {
            forward,
            backward,
            trial,
            witnesses,
            float_errors,
        }
    }

    /// The results for `options`, confirmed by forward and backward witnesses, and the number of epochs at
    /// which the witnesses agree with these passes.
    pub(crate) fn concluded(
        &self,
        options: &PpkOptions,
        needed: f64,
        [of_forward, of_backward]: [&[&Witness]; 2],
    ) -> (Vec<EpochResult>, usize) {
        let (mut forward, mut backward) = (self.forward.clone(), self.backward.clone());
        let is_backward = options.direction == FilterDirection::Backward;
        let of_trial = Witness::of(&self.trial);
        // The trial pass ran in the requested direction, so that its fixes can confirm the other pass.
        let others = if is_backward { of_backward } else { of_forward };
        let with_trial: Vec<&Witness> = others.iter().copied().chain([&of_trial]).collect();
        let of_pass = if is_backward {
            [of_forward, &with_trial[..]]
        } else {
            [&with_trial[..], of_backward]
        };
        let against_trial = if is_backward { of_forward } else { of_backward };
        let all: Vec<(&Witness, &[&Witness])> = of_forward
            .iter()
            .map(|w| (*w, of_backward))
            .chain(of_backward.iter().map(|w| (*w, of_forward)))
            .chain([(&of_trial, against_trial)])
            .collect();
        let contradicted = contradictions(&all);
        // These passes are the first of each direction.
        let [forward_witness, backward_witness] = &self.witnesses;
        let single = !options.direction.is_combined();
        let other = single.then_some(backward_witness);
        let agreeing = confirm_by(&mut forward, needed, of_pass[1], &contradicted[0], other);
        let of_backward_pass = &contradicted[of_forward.len()];
        let other = single.then_some(forward_witness);
        confirm_by(&mut backward, needed, of_pass[0], of_backward_pass, other);
        let mut trial = self.trial.clone();
        confirm_by(
            &mut trial,
            needed,
            against_trial,
            &contradicted[all.len() - 1],
            Some(if is_backward {
                forward_witness
            } else {
                backward_witness
            }),
        );
        scale_covariances(&mut trial);
        if is_backward {
            trial.reverse();
        }
        for pass in [&mut forward, &mut backward] {
            scale_covariances(pass);
            self.float_errors.scale(pass);
        }
        let mut results = match options.direction {
            FilterDirection::Forward => forward,
            FilterDirection::Backward => {
                backward.reverse();
                backward
            }
            _ => combine(forward, backward, options, &self.float_errors),
        };
        overlay(&mut results, trial);
        (results, agreeing)
    }
}
