//! Outputs of gprMax, single or merged (versions 3 and 4).

use hdf5_pure::{AttrValue, Group};

use super::values::{Attributes, MAX_MEMBERS, broken, number, numbers, place, read};
use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::named::{Array, Numbers};
use crate::recording::{Axis, Channel, Format, Positions, Recording, Values};

/// Places of an antenna in all runs, m.
type Places = Vec<[f64; 3]>;

/// Places of the antennas, in the coordinates of the model.
struct Antennas<'a> {
    root: &'a Group,
    /// Distance of the source from one run to the next, and that of the receivers, m.
    steps_m: Option<[[f64; 3]; 2]>,
    /// Of the first source in the first run, m.
    source_m: Option<[f64; 3]>,
    /// Whether the model is one cell deep in z, so that its y is up.
    is_flat: bool,
}

/// Every receiver and component of a model's output; the strongest electric component first.
///
/// Positions are the model's, z up; a model of one cell along z has y up, and is turned.
pub(super) fn gprmax(root: &Group, limits: &Limits) -> Result<Recording, FormatError> {
    let attributes = root.attrs().map_err(|e| broken("/", e))?;
    let mut recording = Recording::new(Format::GprMax);
    let step_s = number(&attributes, "dt").unwrap_or(0.0);
    for name in ["Title", "gprMax"] {
        if let Some(AttrValue::String(text)) = attributes.get(name) {
            recording.fact(name, text);
        }
    }
    for name in ["Iterations", "nrx", "nsrc"] {
        if let Some(value) = number(&attributes, name) {
            recording.fact(name, value);
        }
    }
    let antennas = Antennas::of(root, &attributes)?;
    let receivers = root.group("rxs").map_err(|e| broken("/rxs", e))?;
    let mut names = receivers.groups().map_err(|e| broken("/rxs", e))?;
    names.truncate(MAX_MEMBERS);
    let mut strengths: Vec<f32> = Vec::new();
    for receiver in names {
        let at = format!("/rxs/{receiver}");
        let group = receivers.group(&receiver).map_err(|e| broken(&at, e))?;
        let own = group.attrs().map_err(|e| broken(&at, e))?;
        let receiver_m = place(&own, "Position");
        let components = group.datasets().map_err(|e| broken(&at, e))?;
        for component in components.into_iter().take(MAX_MEMBERS) {
            let at = format!("{at}/{component}");
            let dataset = group.dataset(&component).map_err(|e| broken(&at, e))?;
            let array = read(&dataset, &at, limits)?;
            let (traces, values) = turned(array, &at, limits)?;
            let peak = values.iter().fold(0.0f32, |m, x| m.max(x.abs()));
            let is_electric = component.starts_with('E');
            strengths.push(if is_electric { peak } else { -1.0 });
            let own = dataset.attrs().map_err(|e| broken(&at, e))?;
            let axis = Axis::FastTime {
                // Magnetic components are known between the times of the electric ones.
                start_s: number(&own, "TimeSampleOffset").unwrap_or(0.0),
                step_s,
                samples: values.len() / traces.max(1),
            };
            let name = format!("{receiver}/{component}");
            let mut channel = Channel::new(name, traces, axis, Values::Real(values));
            antennas.place(&mut channel, (&receiver, receiver_m), limits)?;
            recording.channels.push(channel);
        }
    }
    let held: usize = recording.channels.iter().map(|c| c.values.len()).sum();
    limits.check_samples(Place::field("/rxs"), held as u64)?;
    // The component with the strongest signal is used.
    if let Some(best) = (0..strengths.len()).max_by(|&a, &b| strengths[a].total_cmp(&strengths[b]))
    {
        let first = recording.channels.remove(best);
        recording.channels.insert(0, first);
    }
    if recording.channels.iter().any(|c| c.positions.is_none()) {
        recording.remarks.push(
            "no positions of source and receiver: outputs merged by versions before 4 keep only the distance between \
             traces"
                .to_owned(),
        );
    }
    if antennas.is_flat {
        let remark = "the model is one cell deep in z: its y is up";
        recording.remarks.push(remark.to_owned());
    }
    recording.checked()
}

/// Traces of a component, and its samples `[traces, samples]` from `[samples, traces]`.
fn turned(array: Array, at: &str, limits: &Limits) -> Result<(usize, Vec<f32>), FormatError> {
    let (samples, traces) = match array.shape[..] {
        [samples] => (samples, 1),
        [samples, traces] => (samples, traces),
        _ => {
            return Err(FormatError::content(
                Place::field(at),
                "[samples] or [samples, traces]",
                format!("{:?}", array.shape),
            ));
        }
    };
    limits.check_trace(Place::field(at), samples as u64)?;
    let Numbers::Real(values) = array.values else {
        return Err(FormatError::content(
            Place::field(at),
            "real numbers",
            "complex ones",
        ));
    };
    if samples.checked_mul(traces) != Some(values.len()) {
        return Err(FormatError::content(
            Place::field(at),
            format!("{samples} × {traces} values"),
            values.len(),
        ));
    }
    let turned = (0..samples * traces)
        .map(|i| values[i % samples * traces + i / samples] as f32)
        .collect();
    Ok((traces, turned))
}

impl<'a> Antennas<'a> {
    fn of(root: &'a Group, attributes: &Attributes) -> Result<Self, FormatError> {
        let cells = attributes.get("nx_ny_nz").map(numbers).unwrap_or_default();
        let steps_m = || -> Option<[[f64; 3]; 2]> {
            let cell_m = place(attributes, "dx_dy_dz")?;
            let of = |name: &str| {
                let cells = place(attributes, name)?;
                Some(std::array::from_fn(|k| cells[k] * cell_m[k]))
            };
            Some([of("srcsteps")?, of("rxsteps")?])
        };
        Ok(Self {
            root,
            steps_m: steps_m(),
            source_m: source_m(root)?,
            is_flat: cells.get(2) == Some(&1.0),
        })
    }

    /// States in `channel` where the source and a receiver were in each run: from the table of a merged output, from
    /// the places in the first run and the steps, or, where only the steps are known, as a distance along the line.
    fn place(
        &self,
        channel: &mut Channel,
        (name, receiver_m): (&str, Option<[f64; 3]>),
        limits: &Limits,
    ) -> Result<(), FormatError> {
        let traces = channel.traces;
        let walk = |from_m: [f64; 3], step_m: [f64; 3]| -> Places {
            (0..traces)
                .map(|i| std::array::from_fn(|k| from_m[k] + step_m[k] * i as f64))
                .collect()
        };
        let listed = match self.listed_m("srcs", "src1", traces, limits)? {
            Some(sources) => {
                (self.listed_m("rxs", name, traces, limits)?).map(|receivers| [sources, receivers])
            }
            None => None,
        };
        let stepped = || match (self.source_m, receiver_m, self.steps_m) {
            (Some(source), Some(receiver), Some([of_source, of_receiver])) => {
                Some([walk(source, of_source), walk(receiver, of_receiver)])
            }
            (Some(source), Some(receiver), None) if traces == 1 => {
                Some([vec![source], vec![receiver]])
            }
            _ => None,
        };
        let Some(places_m) = listed.or_else(stepped) else {
            let step_m = self
                .steps_m
                .map_or(0.0, |[_, [x, y, z]]| x.hypot(y).hypot(z));
            if step_m > 0.0 {
                channel.along_m = Some((0..traces).map(|i| step_m * i as f64).collect());
            }
            return Ok(());
        };
        let up = |p: [f64; 3]| match self.is_flat {
            true => [p[0], -p[2], p[1]],
            false => p,
        };
        let antennas_m = places_m.map(|places| places.into_iter().map(up).collect::<Places>());
        let pairs = || antennas_m[0].iter().zip(&antennas_m[1]);
        let middle = |(t, r): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|k| f64::midpoint(t[k], r[k]));
        channel.positions = Some(Positions::Local(pairs().map(middle).collect()));
        channel.antenna_separation_m = pairs()
            .map(|(t, r)| (0..3).map(|k| (t[k] - r[k]).powi(2)).sum::<f64>().sqrt())
            .next();
        channel.antennas_m = Some(antennas_m);
        Ok(())
    }

    /// The places of a source or receiver in all runs of a merged output (version 4).
    fn listed_m(
        &self,
        kind: &str,
        name: &str,
        traces: usize,
        limits: &Limits,
    ) -> Result<Option<Places>, FormatError> {
        let at = format!("/trace_metadata/{kind}/{name}/Position");
        let group = self
            .root
            .group("trace_metadata")
            .and_then(|g| g.group(kind));
        let Ok(dataset) = group
            .and_then(|g| g.group(name))
            .and_then(|g| g.dataset("Position"))
        else {
            return Ok(None);
        };
        let array = read(&dataset, &at, limits)?;
        match (&array.shape[..], array.values) {
            ([n, 3], Numbers::Real(values)) if *n == traces && values.len() == 3 * traces => {
                Ok(Some(values.as_chunks::<3>().0.to_vec()))
            }
            _ => Err(FormatError::content(
                Place::field(at),
                format!("[{traces}, 3] numbers"),
                format!("{:?}", array.shape),
            )),
        }
    }
}

/// Position of the first source.
fn source_m(root: &Group) -> Result<Option<[f64; 3]>, FormatError> {
    let Ok(sources) = root.group("srcs") else {
        return Ok(None);
    };
    let names = sources.groups().map_err(|e| broken("/srcs", e))?;
    let Some(first) = names.first() else {
        return Ok(None);
    };
    let group = sources.group(first).map_err(|e| broken("/srcs", e))?;
    let attributes = group.attrs().map_err(|e| broken("/srcs", e))?;
    Ok(place(&attributes, "Position"))
}
