//! Causal cleaning: zero-timing by the first traces, the background as a running mean, the gate about 2h/c,
//! spectra.

use acerra_radar::clean::{Gate, SurfaceOptions, ZeroTiming, apply_gate, spectrum_at, zero_timing};
use acerra_radar::{Radargram, Samples, ScanWindow};
use num_complex::Complex64;

use crate::error::LiveError;
use crate::settings::{LiveSettings, Zero};

/// A trace at its place.
#[derive(Clone, Debug)]
pub struct PlacedTrace {
    /// Samples of the trace.
    pub samples: Vec<f32>,
    /// Fast-time window of the trace.
    pub window: ScanWindow,
    /// Position of the radar (m).
    pub position_m: [f64; 3],
    /// Height above the image plane (m).
    pub height_m: f64,
}

/// Clean traces and their spectra.
#[derive(Clone, Debug)]
pub struct Clean {
    /// The clean traces, fast time zero-timed.
    pub traces: Radargram,
    /// Places of the traces (m).
    pub position_m: Vec<[f64; 3]>,
    /// Spectra of the traces, `[traces, frequencies]`.
    pub spectrum: Vec<Complex64>,
}

/// The state of the cleaning.
#[derive(Clone, Debug)]
pub struct Cleaner {
    settings: LiveSettings,
    window: Option<ScanWindow>,
    /// The first traces, which wait for one another.
    first: Vec<PlacedTrace>,
    running: Option<Running>,
    /// Reason why the fast time at which range is zero is not known yet.
    trouble: Option<String>,
}

/// State after the traces so far.
#[derive(Clone, Debug)]
struct Running {
    shift_s: f64,
    mean: Vec<f64>,
    traces: f64,
}

impl Cleaner {
    /// A cleaning that has seen no trace.
    #[must_use]
    pub fn new(settings: &LiveSettings) -> Self {
        Self {
            settings: settings.clone(),
            window: None,
            first: Vec::new(),
            running: None,
            trouble: None,
        }
    }

    /// Added to fast time, once it is known (s).
    #[must_use]
    pub fn shift_s(&self) -> Option<f64> {
        self.running.as_ref().map(|running| running.shift_s)
    }

    /// Reason why the fast time at which range is zero has not been found yet.
    #[must_use]
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    /// Traces that wait until there are enough to begin with.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.first.len()
    }

    /// Adds traces of one window in order of time and returns those that can be cleaned by now. The first
    /// traces wait for one another; where their surface echo cannot be found, half of them are given up and
    /// further traces are collected. The number of traces given up is returned too.
    ///
    /// # Errors
    /// Samples that are no numbers, frequencies that the sampling does not reach.
    pub fn take(&mut self, traces: Vec<PlacedTrace>) -> Result<(Option<Clean>, u64), LiveError> {
        let Some(window) = traces.first().map(|trace| trace.window) else {
            return Ok((None, 0));
        };
        let mut given_up = 0;
        if self
            .window
            .replace(window)
            .is_some_and(|before| before != window)
        {
            // Another window is another instrument.
            given_up += self.first.len() as u64;
            self.first.clear();
            self.running = None;
        }
        let mut own = traces;
        if self.running.is_none() {
            self.first.append(&mut own);
            if self.first.len() < self.settings.first_traces {
                return Ok((None, given_up));
            }
            match self.begin()? {
                Some(running) => self.running = Some(running),
                None => {
                    let half = self.first.len() / 2;
                    self.first.drain(..half);
                    return Ok((None, given_up + half as u64));
                }
            }
            own = std::mem::take(&mut self.first);
        }
        let Some(running) = &mut self.running else {
            return Ok((None, given_up));
        };
        running.subtract_background(&mut own, self.settings.background_traces);
        let shift_s = running.shift_s;
        Ok((Some(self.spectra(own, shift_s)?), given_up))
    }

    /// Finds where range is zero, and the first background.
    fn begin(&mut self) -> Result<Option<Running>, LiveError> {
        let shift_s = match self.settings.zero {
            Zero::Shift(shift_s) => shift_s,
            Zero::Surface(approximate_delay_s) => {
                let heights_m: Vec<f64> = self.first.iter().map(|t| t.height_m).collect();
                let mut options = SurfaceOptions::default();
                options.approximate_delay_s = approximate_delay_s;
                let raw = radargram(&self.first, 0.0)?;
                match zero_timing(raw, &heights_m, &ZeroTiming::AllTraces(options)) {
                    Ok(found) => found.shift_s,
                    Err(error) => {
                        self.trouble = Some(error.to_string());
                        return Ok(None);
                    }
                }
            }
        };
        self.trouble = None;
        let samples = self.first.first().map_or(0, |trace| trace.samples.len());
        let mut mean = vec![0.0; samples];
        for trace in &self.first {
            for (sum, sample) in mean.iter_mut().zip(&trace.samples) {
                *sum += f64::from(*sample) / self.first.len() as f64;
            }
        }
        Ok(Some(Running {
            shift_s,
            mean,
            // The first traces are counted in again one by one: the mean stays theirs, roughly.
            traces: self.first.len() as f64,
        }))
    }

    fn spectra(&self, traces: Vec<PlacedTrace>, shift_s: f64) -> Result<Clean, LiveError> {
        let heights_m: Vec<f64> = traces.iter().map(|trace| trace.height_m).collect();
        let mut clean = radargram(&traces, shift_s)?;
        if let Some([start_s, end_s]) = self.settings.gate_s {
            let gate = Gate {
                start_s,
                end_s,
                edge_s: Gate::default().edge_s.min(0.5 * (end_s - start_s)),
            };
            clean = apply_gate(clean, &heights_m, &gate)?;
        }
        let spectrum = spectrum_at(&clean, &self.settings.frequency_hz)?;
        Ok(Clean {
            traces: clean,
            position_m: traces.iter().map(|trace| trace.position_m).collect(),
            spectrum: spectrum.values,
        })
    }
}

impl Running {
    /// Counts each trace in, then subtracts the mean so far from it.
    fn subtract_background(&mut self, traces: &mut [PlacedTrace], window: u32) {
        for trace in traces {
            self.traces = (self.traces + 1.0).min(f64::from(window));
            let share = 1.0 / self.traces;
            for (mean, sample) in self.mean.iter_mut().zip(&mut trace.samples) {
                *mean += share * (f64::from(*sample) - *mean);
                *sample = (f64::from(*sample) - *mean) as f32;
            }
        }
    }
}

fn radargram(traces: &[PlacedTrace], shift_s: f64) -> Result<Radargram, LiveError> {
    let window = traces.first().map(|trace| trace.window);
    let (start_s, step_s) = window.map_or((0.0, 0.0), |w| (w.start_s(), w.step_s()));
    let samples = traces
        .iter()
        .flat_map(|trace| trace.samples.iter().copied());
    // Slow time is the traces' order: no step here uses it.
    let time_s = (0..traces.len()).map(|k| k as f64).collect();
    let samples = Samples::Real(samples.collect());
    Ok(Radargram::new(time_s, start_s + shift_s, step_s, samples)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_record::session::Session;

    const STEP_S: f64 = 61e-12;

    fn settings(text: &str) -> LiveSettings {
        let head = "[radio]\naddress = \"127.0.0.1:1\"\n";
        LiveSettings::of(&Session::parse(&(head.to_owned() + text)).unwrap()).unwrap()
    }

    fn pulse(t_s: f64) -> f64 {
        (-(t_s / 0.35e-9).powi(2)).exp() * (std::f64::consts::TAU * 4e9 * t_s).cos()
    }

    /// A trace with coupling that stays put, the ground below, and a target's echo at `echo_ns`.
    fn trace(height_m: f64, echo_ns: f64, delay_ns: f64) -> PlacedTrace {
        let window = ScanWindow {
            start_ps: 0,
            stop_ps: 80_000,
            step_bins: 32,
            samples: 1312,
        };
        let step_s = window.step_s();
        assert!((step_s - STEP_S).abs() < 1e-12);
        let at = |k: usize| {
            let ns = 1e9 * step_s * k as f64 - delay_ns;
            let ground_ns = 2.0 * height_m / 0.299_792_458;
            5000.0 * pulse(1e-9 * (ns - 1.0))
                + 800.0 * pulse(1e-9 * (ns - ground_ns))
                + 60.0 * pulse(1e-9 * (ns - echo_ns))
        };
        PlacedTrace {
            samples: (0..1312).map(|k| at(k) as f32).collect(),
            window,
            position_m: [0.0, 0.0, height_m],
            height_m,
        }
    }

    #[test]
    fn range_zero_is_found_by_the_surface_of_the_first_traces() {
        let mut cleaner = Cleaner::new(&settings("[live]\nfirst_traces = 16\n"));
        let height_m = |k: i32| 5.0 + 0.2 * (0.4 * f64::from(k)).sin();
        let mut given = 0;
        for k in 0..16 {
            let (clean, _) = cleaner.take(vec![trace(height_m(k), 45.0, 9.0)]).unwrap();
            given += clean.map_or(0, |c| c.position_m.len());
        }
        // All of the first are returned together.
        assert_eq!(given, 16);
        let shift_ns = 1e9 * cleaner.shift_s().unwrap();
        assert!((shift_ns + 9.0).abs() < 0.05, "{shift_ns}");
    }

    #[test]
    fn what_stays_put_is_removed_and_what_moves_is_kept() {
        let text =
            "[flight]\ndelay_ns = 9.0\n[live]\ngate_ns = [-30.0, 40.0]\nbackground_traces = 100\n";
        let mut cleaner = Cleaner::new(&settings(text));
        let level_at = |clean: &Clean, row: usize, ns: f64| {
            let place = ((1e-9 * ns - clean.traces.fast_time_start_s) / STEP_S).round() as usize;
            let at = row * clean.traces.samples_per_trace + place;
            (0..8)
                .map(|k| clean.traces.samples.at(at + k - 4).norm())
                .fold(0.0, f64::max)
        };
        let mut last = None;
        for k in 0..200 {
            let echo_ns = 40.0 + 0.1 * f64::from(k);
            let taken = cleaner.take(vec![trace(5.0, echo_ns, 9.0)]).unwrap().0;
            last = taken.or(last);
        }
        let clean = last.unwrap();
        let coupling = level_at(&clean, 0, 1.0);
        let ground = level_at(&clean, 0, 2.0 * 5.0 / 0.299_792_458);
        let target = level_at(&clean, 0, 59.9);
        assert!(coupling < 20.0, "{coupling}");
        assert!(ground < 20.0, "{ground}");
        assert!(target > 50.0, "{target}");
    }

    #[test]
    fn traces_without_a_surface_echo_are_given_up_with_the_reason() {
        let mut cleaner = Cleaner::new(&settings("[live]\nfirst_traces = 8\n"));
        let mut given_up = 0;
        for _ in 0..20 {
            let mut silent = trace(500.0, 45.0, 9.0);
            silent.height_m = 500.0;
            let (clean, lost) = cleaner.take(vec![silent]).unwrap();
            assert!(clean.is_none());
            given_up += lost;
        }
        assert!(given_up >= 12, "{given_up}");
        assert!(cleaner.trouble().is_some());
        assert!(cleaner.waiting() < 8);
    }

    #[test]
    fn another_window_begins_anew() {
        let mut cleaner = Cleaner::new(&settings(
            "[flight]\ndelay_ns = 9.0\n[live]\nfirst_traces = 2\n",
        ));
        let of = |k: f64| trace(5.0, 40.0 + k, 9.0);
        assert!(cleaner.take(vec![of(0.0), of(1.0)]).unwrap().0.is_some());
        let mut other = of(2.0);
        other.window.start_ps = 10_000;
        assert!(cleaner.take(vec![other]).unwrap().0.is_none());
        assert_eq!(cleaner.waiting(), 1);
    }
}
