//! Ultra-wideband radar logs: readers, zero-timing, background removal, gating, spectra.
