//! Parts of a flight along which points keep their phase.

use std::ops::Range;

use crate::error::AutofocusError;
use crate::globals::check_pulses;

/// Parts of the flight whose images are summed by power: a point has one phase along each part. A single part
/// means one coherent image of all pulses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parts {
    of_pulse: Vec<usize>,
    ranges: Vec<Range<usize>>,
}

impl Parts {
    /// The parts `ranges`, in order; empty for the whole flight.
    pub fn new(ranges: &[Range<usize>], pulses: usize) -> Result<Self, AutofocusError> {
        let whole = [Range {
            start: 0,
            end: pulses,
        }];
        let ranges = if ranges.is_empty() { &whole } else { ranges };
        let mut of_pulse = Vec::with_capacity(pulses);
        for (part, range) in ranges.iter().enumerate() {
            check_pulses(range, pulses)?;
            check_start(part, of_pulse.len(), range.start)?;
            of_pulse.resize(range.end, part);
        }
        check_start(ranges.len(), pulses, of_pulse.len())?;
        Ok(Self {
            of_pulse,
            ranges: ranges.to_vec(),
        })
    }

    /// Number of parts.
    pub fn len(&self) -> usize {
        self.ranges.len()
    }

    /// The part that a pulse belongs to.
    pub fn of(&self, pulse: usize) -> usize {
        self.of_pulse[pulse]
    }

    /// The pulses of the part that a pulse belongs to.
    pub fn about(&self, pulse: usize) -> &Range<usize> {
        &self.ranges[self.of(pulse)]
    }
}

fn check_start(part: usize, expected: usize, found: usize) -> Result<(), AutofocusError> {
    if found == expected {
        return Ok(());
    }
    Err(AutofocusError::Parts {
        part,
        expected,
        found,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_one_another_without_gaps() {
        let whole = Parts::new(&[], 5).unwrap();
        assert_eq!((whole.len(), whole.of(4), whole.about(2)), (1, 0, &(0..5)));
        let two = Parts::new(&[0..2, 2..5], 5).unwrap();
        assert_eq!(
            (two.len(), two.of(1), two.of(2), two.about(3)),
            (2, 0, 1, &(2..5))
        );
        for wrong in [
            vec![0..2, 3..5],
            vec![0..3, 2..5],
            vec![0..1, 1..2],
            vec![0..2, 2..6],
            vec![0..0, 0..5],
        ] {
            assert!(Parts::new(&wrong, 5).is_err(), "{wrong:?}");
        }
    }
}
