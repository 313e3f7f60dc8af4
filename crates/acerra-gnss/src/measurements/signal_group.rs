//! Signal groups (one frequency of one system), and those that contradict the others.

use crate::observations::satellite::System;

/// Groups of systems that are differenced among themselves, in order.
pub(crate) const GROUPS: [&[System]; 6] = [
    &[System::Gps, System::Sbas],
    &[System::Glonass],
    &[System::Galileo],
    &[System::Beidou],
    &[System::Qzss],
    &[System::Navic],
];

/// Number of fixes without a group from which the group is left out for good.
const LEAST_FIXES: u32 = 10;
/// Number of fixes without a suspected group for each fix with it.
const LEAST_ODDS: u32 = 10;

/// A frequency slot of a group of systems, by its index in [`GROUPS`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct SignalGroup {
    pub slot: usize,
    pub group: usize,
}

impl SignalGroup {
    /// The first system of the group, which names the group.
    pub(crate) fn system(self) -> System {
        GROUPS[self.group][0]
    }
}

/// Fixes with and without a group.
#[derive(Debug, Clone, Copy)]
struct Record {
    group: SignalGroup,
    with: u32,
    without: u32,
}

/// Number of fixes with and without each group so far, and the groups left out for good.
#[derive(Debug, Clone, Default)]
pub(crate) struct SuspectGroups {
    records: Vec<Record>,
    left_out: Vec<SignalGroup>,
}

impl SuspectGroups {
    /// A record with groups that are known to be left out.
    pub(crate) fn known(left_out: Vec<SignalGroup>) -> Self {
        Self {
            records: Vec::new(),
            left_out,
        }
    }

    pub(crate) fn left_out(&self) -> &[SignalGroup] {
        &self.left_out
    }

    /// Whether a group may cause a contradiction: few fixes were found with the group relative to fixes
    /// without.
    pub(crate) fn may_contradict(&self, group: SignalGroup) -> bool {
        let record = self.records.iter().find(|r| r.group == group);
        record.is_none_or(|r| r.without >= LEAST_ODDS * r.with)
    }

    /// Counts a fix found with some groups and without others.
    pub(crate) fn note(&mut self, with: &[SignalGroup], without: &[SignalGroup]) {
        for group in with {
            self.record(*group).with += 1;
        }
        for group in without {
            let record = self.record(*group);
            record.without += 1;
            let often = record.without >= LEAST_FIXES;
            if often && self.may_contradict(*group) && !self.left_out.contains(group) {
                self.left_out.push(*group);
            }
        }
    }

    fn record(&mut self, group: SignalGroup) -> &mut Record {
        let known = self.records.iter().position(|r| r.group == group);
        let place = known.unwrap_or_else(|| {
            self.records.push(Record {
                group,
                with: 0,
                without: 0,
            });
            self.records.len() - 1
        });
        &mut self.records[place]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_that_fixes_were_found_with_are_not_suspected() {
        let [good, bad] = [0, 3].map(|group| SignalGroup { slot: 1, group });
        let mut suspects = SuspectGroups::default();
        assert!(suspects.may_contradict(good) && suspects.may_contradict(bad));
        for _ in 0..LEAST_FIXES {
            assert!(suspects.left_out().is_empty());
            suspects.note(&[good], &[bad]);
        }
        assert_eq!(suspects.left_out(), [bad]);
        assert!(!suspects.may_contradict(good));
        for _ in 0..LEAST_FIXES {
            suspects.note(&[], &[good]);
        }
        assert_eq!(suspects.left_out(), [bad]);
    }
}
