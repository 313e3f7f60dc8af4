//! A run's contents as variables over named dimensions (CF 1.11).

use acerra_cubes::{Attribute, Dataset, Values, Variable};
use acerra_geo::time::GpsTime;
use acerra_radar::Samples;
use num_complex::Complex32;

use super::contents::{PulseContents, RadargramContents, RunContents, TargetPlace};
use super::table::Table;

/// Columns of the trajectory: name in the table, name in the cube, unit, standard name, description.
const COLUMNS: [[&str; 5]; 12] = [
    [
        "x_m",
        "antenna_x",
        "m",
        "",
        "east of the antenna's phase centre",
    ],
    [
        "y_m",
        "antenna_y",
        "m",
        "",
        "north of the antenna's phase centre",
    ],
    [
        "z_m",
        "antenna_z",
        "m",
        "",
        "up of the antenna's phase centre",
    ],
    [
        "sd_x_m",
        "antenna_x_sigma",
        "m",
        "",
        "standard deviation of antenna_x",
    ],
    [
        "sd_y_m",
        "antenna_y_sigma",
        "m",
        "",
        "standard deviation of antenna_y",
    ],
    [
        "sd_z_m",
        "antenna_z_sigma",
        "m",
        "",
        "standard deviation of antenna_z",
    ],
    [
        "vx_m_s",
        "antenna_vx",
        "m s-1",
        "",
        "velocity of the antenna to the east",
    ],
    [
        "vy_m_s",
        "antenna_vy",
        "m s-1",
        "",
        "velocity of the antenna to the north",
    ],
    [
        "vz_m_s",
        "antenna_vz",
        "m s-1",
        "",
        "velocity of the antenna upwards",
    ],
    [
        "latitude_deg",
        "latitude",
        "degrees_north",
        "latitude",
        "latitude of the antenna (WGS 84)",
    ],
    [
        "longitude_deg",
        "longitude",
        "degrees_east",
        "longitude",
        "longitude of the antenna (WGS 84)",
    ],
    [
        "height_m",
        "height",
        "m",
        "height_above_reference_ellipsoid",
        "height of the antenna above the ellipsoid (WGS 84)",
    ],
];

/// The variables of a run.
///
/// # Errors
/// A trajectory whose cells are no numbers.
pub(super) fn dataset<'a>(run: &'a RunContents<'_>) -> anyhow::Result<Dataset<'a>> {
    let mut data = Dataset::default();
    data.attribute("Conventions", "CF-1.11");
    data.attribute("title", format!("{}: focused radar image", run.name));
    data.attribute("source", format!("Acerra {}", env!("CARGO_PKG_VERSION")));
    for (name, value) in &run.items {
        data.attribute(name, value.as_str());
    }
    add_image(&mut data, run);
    add_trajectory(&mut data, &run.trajectory)?;
    add_targets(&mut data, &run.targets);
    if let Some(pulses) = &run.pulses {
        add_pulses(&mut data, pulses);
    }
    Ok(data)
}

fn described<'a>(variable: Variable<'a>, unit: &str, meaning: &str) -> Variable<'a> {
    variable.with("long_name", meaning).with("units", unit)
}

fn add_image<'a>(data: &mut Dataset<'a>, run: &'a RunContents<'_>) {
    let image = &run.image;
    data.dimension("y", image.y_m.len());
    data.dimension("x", image.x_m.len());
    let x = Variable::new("x", &["x"], image.x_m.clone().into());
    data.variable(described(x, "m", "east of the pixels").with("axis", "X"));
    let y = Variable::new("y", &["y"], image.y_m.clone().into());
    data.variable(described(y, "m", "north of the pixels").with("axis", "Y"));
    let planes: &[&str] = if image.z_m.len() == 1 {
        &[]
    } else {
        &["y", "x"]
    };
    let z = Variable::new("pixel_z", planes, image.z_m.clone().into());
    data.variable(described(z, "m", "up of the pixels").with("positive", "up"));
    let values = Variable::new("image", &["y", "x"], Values::from(&*image.values));
    let meaning = "complex reflectivity, Eq. (3) of Catapano et al. 2020";
    data.variable(described(values, "1", meaning).with("coordinates", "pixel_z"));
    let level = |z: &Complex32| match z.norm_sqr() {
        power if power > 0.0 => 10.0 * power.log10(),
        _ => f32::NAN,
    };
    let levels: Vec<f32> = image.values.iter().map(level).collect();
    let levels = Variable::new("level", &["y", "x"], levels.into());
    let meaning = "power of the image, 10 log10 |image|^2";
    data.variable(described(levels, "dB", meaning).with("coordinates", "pixel_z"));
}

fn add_trajectory(data: &mut Dataset<'_>, table: &Table) -> anyhow::Result<()> {
    if table.is_empty() {
        return Ok(());
    }
    data.dimension("trace", table.len());
    if let Some(time_s) = table.numbers("time_s")? {
        data.variable(time(time_s, table.time_zero()));
    }
    for [column, name, unit, standard_name, meaning] in COLUMNS {
        let Some(values) = table.numbers(column)? else {
            continue;
        };
        let mut variable = described(
            Variable::new(name, &["trace"], values.into()),
            unit,
            meaning,
        );
        if !standard_name.is_empty() {
            variable = variable.with("standard_name", standard_name);
        }
        data.variable(variable);
    }
    for (name, meaning) in [
        ("status", "kind of the position"),
        ("flag", "whether the trace has a position"),
    ] {
        if let Some(words) = table.texts(name) {
            data.variable(flags(&format!("antenna_{name}"), words, meaning));
        }
    }
    Ok(())
}

/// Times of the traces: from a whole second of UTC, where that is known.
fn time(time_s: Vec<f64>, zero: Option<GpsTime>) -> Variable<'static> {
    let first_s = time_s.first().copied().unwrap_or_default();
    let of = |values: Vec<f64>| Variable::new("time", &["trace"], values.into());
    let meaning = "time of the trace";
    let Some(zero) = zero else {
        let meaning = "time of the trace, on the clock of the positions";
        return described(of(time_s), "s", meaning);
    };
    let start = GpsTime::new((zero + first_s).seconds(), 0.0);
    let utc = start.to_utc();
    let unit = format!(
        "seconds since {:04}-{:02}-{:02} {:02}:{:02}:{:02}",
        utc.year,
        utc.month,
        utc.day,
        utc.hour,
        utc.minute,
        utc.second.min(59)
    );
    // Within a leap second the unit names the second before it.
    let ahead_s = f64::from(u8::from(utc.second == 60));
    let offset_s = zero.seconds_since(start) + ahead_s;
    let since = time_s.iter().map(|t| t + offset_s).collect();
    described(of(since), &unit, meaning)
        .with("standard_name", "time")
        .with("calendar", "standard")
}

/// Words as numbers, with their meanings as attributes.
fn flags<'t>(name: &str, words: impl Iterator<Item = &'t str>, meaning: &str) -> Variable<'static> {
    let words: Vec<&str> = words.collect();
    let mut known = words.clone();
    known.sort_unstable();
    known.dedup();
    let number = |word: &&str| known.partition_point(|k| k < word) as i32;
    let values: Vec<i32> = words.iter().map(number).collect();
    let numbers = (0..known.len() as i32).collect();
    Variable::new(name, &["trace"], values.into())
        .with("long_name", meaning)
        .with("flag_values", Attribute::WholeNumbers(numbers))
        .with("flag_meanings", known.join(" "))
}

fn add_targets(data: &mut Dataset<'_>, targets: &[TargetPlace]) {
    if targets.is_empty() {
        return;
    }
    data.dimension("target", targets.len());
    let mut add = |name: &str, unit: &str, meaning: &str, of: &dyn Fn(&TargetPlace) -> f64| {
        let values: Vec<f64> = targets.iter().map(of).collect();
        let variable = Variable::new(name, &["target"], values.into());
        data.variable(described(variable, unit, meaning));
    };
    add("target_x", "m", "east of the target", &|t| t.place_m[0]);
    add("target_y", "m", "north of the target", &|t| t.place_m[1]);
    add("target_z", "m", "up of the target", &|t| t.place_m[2]);
    add("target_level", "dB", "level below the strongest", &|t| {
        t.level_db
    });
    if targets.iter().all(|t| t.place_deg_m.is_some()) {
        let place = |k: usize| move |t: &TargetPlace| t.place_deg_m.map_or(f64::NAN, |p| p[k]);
        add(
            "target_latitude",
            "degrees_north",
            "latitude of the target",
            &place(0),
        );
        add(
            "target_longitude",
            "degrees_east",
            "longitude of the target",
            &place(1),
        );
        add(
            "target_height",
            "m",
            "height of the target above the ellipsoid",
            &place(2),
        );
    }
}

fn add_pulses<'a>(data: &mut Dataset<'a>, pulses: &'a PulseContents<'_>) {
    data.dimension("pulse", pulses.position_m.len());
    data.dimension("frequency", pulses.frequency_hz.len());
    let frequency = Variable::new(
        "frequency",
        &["frequency"],
        pulses.frequency_hz.to_vec().into(),
    );
    let frequency = described(frequency, "Hz", "frequency of the spectra");
    data.variable(frequency.with("standard_name", "radiation_frequency"));
    for (k, (name, meaning)) in [
        ("pulse_x", "east of the antenna's phase centre at the pulse"),
        (
            "pulse_y",
            "north of the antenna's phase centre at the pulse",
        ),
        ("pulse_z", "up of the antenna's phase centre at the pulse"),
    ]
    .into_iter()
    .enumerate()
    {
        let values: Vec<f64> = pulses.position_m.iter().map(|p| p[k]).collect();
        let variable = Variable::new(name, &["pulse"], values.into());
        data.variable(described(variable, "m", meaning));
    }
    for (name, values, meaning) in [
        (
            "pulse_trace",
            &pulses.trace,
            "index of the pulse along the dimension trace",
        ),
        ("pulse_track", &pulses.track, "number of the pulse's track"),
    ] {
        let variable = Variable::new(name, &["pulse"], Values::from(values.clone()));
        data.variable(variable.with("long_name", meaning));
    }
    let spectrum = Values::from(pulses.spectrum.as_slice());
    let spectrum = Variable::new("spectrum", &["pulse", "frequency"], spectrum);
    let meaning = "clean spectra; an echo from range R has phase exp(-j 4 pi f R / c)";
    let places = "pulse_x pulse_y pulse_z";
    data.variable(described(spectrum, "1", meaning).with("coordinates", places));
    for radargram in &pulses.radargrams {
        let is_only = radargram.radargram.traces == pulses.position_m.len();
        add_radargram(data, radargram, is_only);
    }
}

/// The cleaned traces of a track; with several tracks their names include the track's number.
fn add_radargram<'a>(data: &mut Dataset<'a>, of: &RadargramContents<'a>, is_only: bool) {
    let radargram = of.radargram;
    let named = |name: &str| match is_only {
        true => name.to_owned(),
        false => format!("{name}_{}", of.track),
    };
    // Each of several tracks has its own dimension of pulses.
    let pulse = if is_only {
        "pulse".to_owned()
    } else {
        named("pulse_of_track")
    };
    if !is_only {
        data.dimension(&pulse, radargram.traces);
    }
    let fast_time = named("fast_time");
    data.dimension(&fast_time, radargram.samples_per_trace);
    let axis = Variable::new(
        &fast_time,
        &[&fast_time],
        radargram.fast_time_axis_s().into(),
    );
    data.variable(described(axis, "s", "fast time, zero at range zero"));
    let values = match &radargram.samples {
        Samples::Real(v) => Values::from(v.as_slice()),
        Samples::Complex(v) => Values::from(v.as_slice()),
    };
    let variable = Variable::new(named("radargram"), &[&pulse, &fast_time], values);
    let meaning = "traces without background, zero-timed and gated";
    data.variable(described(variable, of.unit, meaning));
}
