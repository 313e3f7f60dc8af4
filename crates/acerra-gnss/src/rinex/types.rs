//! Contents of the columns of an observation record.

use crate::observations::satellite::System;
use crate::observations::signal::SignalCode;

/// The physical quantity of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Pseudorange,
    Phase,
    Doppler,
    Strength,
}

impl Quantity {
    fn from_letter(letter: u8) -> Option<Self> {
        Some(match letter {
            b'C' | b'P' => Self::Pseudorange,
            b'L' => Self::Phase,
            b'D' => Self::Doppler,
            b'S' => Self::Strength,
            _ => return None,
        })
    }
}

/// One column of a satellite's record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    /// The type in the header's spelling.
    pub name: String,
    /// Quantity and signals: one signal in RINEX 3 and later; in RINEX 2 a phase belongs to every code of its
    /// band. `None` for pseudo-observations.
    pub meaning: Option<(Quantity, Vec<SignalCode>)>,
    /// Divisor of the stored values (`SYS / SCALE FACTOR`).
    pub scale: f64,
}

/// The column that a RINEX 3 or 4 type such as `C1C` names.
pub(super) fn column_v3(name: &str, system: System, version: u16) -> Column {
    let meaning = match name.as_bytes() {
        // A missing attribute (early RINEX 3) means unknown tracking.
        &[
            letter @ (b'C' | b'L' | b'D' | b'S'),
            band @ b'1'..=b'9',
            ref rest @ ..,
        ] if rest.len() <= 1 => {
            let attribute = rest.first().map_or('X', |&a| char::from(a));
            // RINEX 3.02 alone called BeiDou's B1I band 1.
            let band = match (system, version, band) {
                (System::Beidou, 302, b'1') => 2,
                _ => band - b'0',
            };
            Quantity::from_letter(letter).map(|q| (q, vec![SignalCode::new(band, attribute)]))
        }
        _ => None,
    };
    Column {
        name: name.to_owned(),
        meaning,
        scale: 1.0,
    }
}

/// The columns that the RINEX 2 types of a header mean for one system.
pub(super) fn columns_v2(names: &[String], system: System, version: u16) -> Vec<Column> {
    let code_types: Vec<SignalCode> = names
        .iter()
        .filter(|n| n.starts_with(['C', 'P']))
        .filter_map(|n| signal_v2(n, system, version))
        .collect();
    let column = |name: &String| {
        let meaning = Quantity::from_letter(name.bytes().next().unwrap_or(b' ')).and_then(|q| {
            let own = signal_v2(name, system, version)?;
            let mut signals = vec![own];
            // Up to 2.11, phase, Doppler and strength name a band only.
            if q != Quantity::Pseudorange && version < 212 {
                let of_band: Vec<SignalCode> = code_types
                    .iter()
                    .copied()
                    .filter(|c| c.band == own.band)
                    .collect();
                if !of_band.is_empty() {
                    signals = of_band;
                }
            }
            Some((q, signals))
        });
        Column {
            name: name.clone(),
            meaning,
            scale: 1.0,
        }
    };
    names.iter().map(column).collect()
}

/// The signal of a RINEX 2 type (`C1`, `P2`, `L5`, in 2.12 also `CA` …) in one system.
fn signal_v2(name: &str, system: System, version: u16) -> Option<SignalCode> {
    use System::{Beidou, Galileo, Glonass, Gps, Navic, Qzss, Sbas};
    let &[kind, band] = name.as_bytes() else {
        return None;
    };
    let code = |band, attribute| Some(SignalCode::new(band, attribute));
    match (kind, band, system) {
        (b'P', b'1', Gps) => code(1, 'W'),
        (b'P', b'1', Glonass) => code(1, 'P'),
        (b'P', b'2', Gps) => code(2, 'W'),
        (b'P', b'2', Glonass) => code(2, 'P'),
        (b'P', ..) => None,
        (b'C', b'1', Gps | Glonass | Qzss | Sbas) => code(1, 'C'),
        (b'C', b'2', Gps) if version < 212 => code(2, 'X'),
        (b'C', b'2', Glonass) => code(2, 'C'),
        (_, b'A', Gps | Glonass | Qzss | Sbas) => code(1, 'C'),
        (_, b'B', Gps | Qzss) => code(1, 'X'),
        (_, b'C', Gps | Qzss) => code(2, 'X'),
        (_, b'D', Glonass) => code(2, 'C'),
        (_, b'1', Gps) if version >= 212 => code(1, 'W'),
        (_, b'1', Glonass) if version >= 212 => code(1, 'P'),
        (_, b'1', Gps | Glonass | Qzss | Sbas) => code(1, 'C'),
        (_, b'1', Galileo) => code(1, 'X'),
        (_, b'1' | b'2', Beidou) => code(2, 'X'),
        (_, b'2', Gps) => code(2, 'W'),
        (_, b'2', Glonass) => code(2, 'P'),
        (_, b'2', Qzss) => code(2, 'X'),
        (_, b'5', Gps | Galileo | Qzss | Sbas | Navic) => code(5, 'X'),
        (_, b'6', Galileo | Qzss | Beidou) => code(6, 'X'),
        (_, b'7', Galileo | Beidou) => code(7, 'X'),
        (_, b'8', Galileo) => code(8, 'X'),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &str) -> Vec<String> {
        list.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn phases_of_version_2_belong_to_every_code_of_their_band() {
        let columns = columns_v2(&names("C1 P1 L1 P2 L2 S1 X1"), System::Gps, 211);
        let codes = |i: usize| columns[i].meaning.as_ref().unwrap().1.clone();
        assert_eq!(codes(0), [SignalCode::new(1, 'C')]);
        assert_eq!(codes(1), [SignalCode::new(1, 'W')]);
        assert_eq!(codes(2), [SignalCode::new(1, 'C'), SignalCode::new(1, 'W')]);
        assert_eq!(codes(4), [SignalCode::new(2, 'W')]);
        assert_eq!(columns[6].meaning, None);
        let lone = columns_v2(&names("L1"), System::Gps, 210);
        assert_eq!(
            lone[0].meaning.as_ref().unwrap().1,
            [SignalCode::new(1, 'C')]
        );
    }

    #[test]
    fn version_3_types() {
        let beidou = |v| column_v3("C1I", System::Beidou, v).meaning.unwrap().1[0].band;
        assert_eq!((beidou(302), beidou(303)), (2, 1));
        for pseudo in ["X1", "I1", "", "C", "C1CC", "é1C"] {
            assert_eq!(
                column_v3(pseudo, System::Gps, 304).meaning,
                None,
                "{pseudo}"
            );
        }
        assert_eq!(
            column_v3("S5Q", System::Gps, 304).meaning,
            Some((Quantity::Strength, vec![SignalCode::new(5, 'Q')]))
        );
    }
}
