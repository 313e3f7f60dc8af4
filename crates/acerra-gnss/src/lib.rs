//! Carrier-phase differential GNSS (PPK): readers, positioning, ambiguity resolution.
