//! The table: wrong settings, each at three sizes.

use crate::edit::Edit;
use crate::trajectories::Distortion;

/// One kind of wrong setting.
pub struct Row {
    /// What is wrong.
    pub what: String,
    /// Three sizes of it.
    pub sizes: Vec<Size>,
    /// Words of which a finding that doubts the setting must hold one.
    pub causes: Vec<&'static str>,
}

/// A wrong setting of one size.
pub struct Size {
    /// How wrong.
    pub label: String,
    /// The edits that make the campaign so.
    pub edits: Vec<Edit>,
}

fn row(what: &str, causes: &[&'static str], sizes: [(String, Vec<Edit>); 3]) -> Row {
    let size = |(label, edits)| Size { label, edits };
    Row {
        what: what.to_owned(),
        sizes: sizes.map(size).into(),
        causes: causes.to_vec(),
    }
}

/// The key's own name, by which explanations refer to it.
fn name_of(key: &'static str) -> &'static str {
    key.rsplit('.').next().unwrap_or(key)
}

/// A key with three wrong values.
fn set(key: &'static str, causes: &[&'static str], values: [&str; 3]) -> Row {
    let causes = [&[name_of(key)], causes].concat();
    let sizes = values.map(|v| (v.to_owned(), vec![Edit::Set(key, v.to_owned())]));
    row(&format!("`{}`", name_of(key)), &causes, sizes)
}

/// A key off its right value by three amounts, in one component.
fn add(key: &'static str, component: usize, what: &str, amounts: [f64; 3]) -> Row {
    let sizes = amounts.map(|v| (format!("{v:+}"), vec![Edit::Add(key, component, v)]));
    // What an origin or an arm does to the heights is told as heights.
    let causes: &[&str] = if component == 2 {
        &[name_of(key), "heights"]
    } else {
        &[name_of(key)]
    };
    row(&format!("`{}` {what}", name_of(key)), causes, sizes)
}

/// Wrong logs or trajectory files.
fn files(what: &str, causes: &[&'static str], sizes: [(&str, Vec<Edit>); 3]) -> Row {
    row(what, causes, sizes.map(|(l, e)| (l.to_owned(), e)))
}

fn to(key: &'static str, value: &str) -> Edit {
    Edit::Set(key, value.to_owned())
}

/// Every row.
pub fn rows() -> Vec<Row> {
    [clocks(), delays(), places(), image(), cleaning(), logs()]
        .into_iter()
        .flatten()
        .collect()
}

const OFFSET: &str = "trajectory.time_offset_s";

fn clocks() -> Vec<Row> {
    vec![
        add(OFFSET, 0, "too great", [0.1, 1.0, 18.0]),
        add(OFFSET, 0, "too small", [-0.1, -1.0, -18.0]),
        add(OFFSET, 0, "between", [0.3, 3.7, 3600.0]),
        set(OFFSET, &["position"], ["0.0", "-1.0", "1e9"]),
        // UTC or TAI for GPS time, an hour of daylight saving.
        add(OFFSET, 0, "of another time scale", [-18.0, 19.0, 3600.0]),
    ]
}

fn delays() -> Vec<Row> {
    const DELAY: &str = "radar.delay_ns";
    const HEIGHTS: [&str; 2] = ["heights", "zero_timing"];
    let light = "image.light_speed_m_s";
    vec![
        add(DELAY, 0, "too long", [1.0, 2.0, 20.0]),
        add(DELAY, 0, "too short", [-1.0, -3.0, -20.0]),
        set(DELAY, &HEIGHTS, ["10e-9", "0.0", "10000.0"]),
        set(
            "preprocess.zero_timing",
            &HEIGHTS,
            ["\"none\"", "{ shift_ns = -5.0 }", "{ shift_ns = 20.0 }"],
        ),
        set(light, &["propagation"], ["3.0e8", "2.9e8", "2.0e8"]),
        set(light, &["propagation"], ["3.3e8", "1.5e8", "299792.458"]),
    ]
}

fn places() -> Vec<Row> {
    const ORIGIN: &str = "trajectory.origin_deg_m";
    const BASE: &str = "gnss.base_ecef_m";
    const LEVER: &str = "trajectory.lever_arm_m";
    vec![
        add(ORIGIN, 2, "too high", [0.3, 1.5, 50.0]),
        add(ORIGIN, 2, "too low", [-0.3, -1.5, -50.0]),
        add(ORIGIN, 0, "(latitude)", [0.002, 0.01, 1.0]),
        add(ORIGIN, 1, "(longitude)", [-0.002, -0.01, -28.0]),
        files(
            "no `origin_deg_m`",
            &["origin_deg_m", "z_m", "range_coverage", "aperture_coverage"],
            [
                ("left out", vec![Edit::Remove(ORIGIN)]),
                ("zero", vec![to(ORIGIN, "[0.0, 0.0, 0.0]")]),
                ("swapped", vec![to(ORIGIN, "[14.3696, 40.9596, 75.0]")]),
            ],
        ),
        add(BASE, 0, "(x)", [3.0, 14.0, 100.0]),
        add(BASE, 2, "(z)", [-3.0, -14.0, -1e4]),
        off("base too far east", EAST, [3.0, 14.0, 100.0]),
        // Above sea level for above the ellipsoid.
        off("base too low", UP, [-0.5, -5.0, -47.0]),
        files(
            "`base_ecef_m` in a wrong unit",
            &["base_ecef_m"],
            [
                ("km", vec![Edit::Scale(BASE, 1e-3)]),
                ("mm", vec![Edit::Scale(BASE, 1e3)]),
                ("feet", vec![Edit::Scale(BASE, 3.280_84)]),
            ],
        ),
        add(LEVER, 2, "(up)", [0.2, 0.4, 2.0]),
        add(LEVER, 2, "(down)", [-0.2, -0.8, -4.0]),
        add(LEVER, 0, "(forward)", [0.5, 2.0, 8.0]),
        add(LEVER, 1, "(left)", [0.5, 2.0, 8.0]),
        files(
            "`lever_arm_m` in a wrong unit",
            &["lever_arm_m"],
            [
                ("feet", vec![Edit::Scale(LEVER, 3.280_84)]),
                ("cm", vec![Edit::Scale(LEVER, 1e2)]),
                ("mm", vec![Edit::Scale(LEVER, 1e3)]),
            ],
        ),
    ]
}

/// East and up at the demonstration's base, Earth-centred.
const EAST: [f64; 3] = [-0.248, 0.969, 0.0];
const UP: [f64; 3] = [0.731, 0.187, 0.656];

/// The base off by so much in a direction.
fn off(what: &str, direction: [f64; 3], amounts_m: [f64; 3]) -> Row {
    let moved = |m: f64| {
        let add = |axis: usize| Edit::Add("gnss.base_ecef_m", axis, m * direction[axis]);
        (format!("{m:+} m"), (0..3).map(add).collect())
    };
    // What becomes of the heights is told by the echoes.
    let causes = ["base_ecef_m", "heights", "origin_deg_m"];
    row(what, &causes, amounts_m.map(moved))
}

fn image() -> Vec<Row> {
    const X: &str = "image.x_m";
    const Y: &str = "image.y_m";
    const Z: &str = "image.z_m";
    let along = |y: f64| {
        let value = format!("[{}, {}]", y, y + 18.0);
        (format!("{y:+} m"), vec![Edit::Set(Y, value)])
    };
    let east = |x: f64| {
        let value = format!("[{}, {}]", x, x + 18.0);
        (format!("{x:+} m"), vec![Edit::Set(X, value)])
    };
    vec![
        row("image to the north", &["y_m"], [100.0, 1e3, 1e5].map(along)),
        row(
            "image to the west",
            &["x_m"],
            [-100.0, -1e3, -1e5].map(east),
        ),
        files(
            "image's axes",
            &["x_m"],
            [
                ("north and east", vec![to(X, "[-9, 9]"), to(Y, "[0, 18]")]),
                ("west", vec![to(X, "[-18, 0]")]),
                ("south", vec![to(Y, "[-27, -9]")]),
            ],
        ),
        set(Z, &["heights"], ["0.3", "1.0", "3.0"]),
        set(Z, &["heights"], ["-0.3", "-1.0", "-30.0"]),
        set("image.pixel_m", &[], ["0.3", "1.0", "10.0"]),
        set(
            "image.band_ghz",
            &[],
            ["[0.5, 1.0]", "[1.0, 2.0]", "[2.0, 3.0]"],
        ),
        set(
            "image.band_ghz",
            &[],
            ["[4.6, 5.6]", "[5.5, 6.5]", "[8.0, 9.0]"],
        ),
        set(
            "image.band_ghz",
            &[],
            ["[3.1, 4.0]", "[3.1, 3.4]", "[3.1, 3.2]"],
        ),
        set(
            "image.band_ghz",
            &[],
            ["[3.1e9, 4.8e9]", "[3100, 4800]", "[0.0031, 0.0048]"],
        ),
        set("image.frequencies", &[], ["20", "8", "2"]),
        set("image.accuracy", &[], ["0.1", "0.3", "0.9"]),
        set("image.max_incidence_deg", &[], ["60", "20", "5"]),
        set("image.antenna_cosine_power", &[], ["2", "20", "200"]),
    ]
}

fn cleaning() -> Vec<Row> {
    const GATE: &str = "preprocess.gate_ns";
    const BACKGROUND: &str = "preprocess.background";
    const SELECT: &str = "radar.select";
    vec![
        set(
            GATE,
            &[],
            ["[30.0, 60.0]", "[100.0, 150.0]", "[500.0, 600.0]"],
        ),
        set(
            GATE,
            &[],
            ["[-6.0, 2.0]", "[-6.0, -1.0]", "[-100.0, -90.0]"],
        ),
        set(GATE, &[], ["[-1.0, 1.0]", "[-0.3, 0.3]", "[-0.01, 0.01]"]),
        set(
            GATE,
            &[],
            ["[-6e-9, 24e-9]", "[-6000.0, 24000.0]", "[24.0, 25.0]"],
        ),
        set(
            BACKGROUND,
            &[],
            ["\"none\"", "{ window = 20 }", "{ window = 3 }"],
        ),
        set(
            BACKGROUND,
            &[],
            [
                "{ components = 5 }",
                "{ components = 20 }",
                "{ components = 200 }",
            ],
        ),
        set(SELECT, &["traces"], ["[0, 60]", "[0, 20]", "[0, 5]"]),
        set("image.weight", &[], ["\"trace\"", "\"path\"", "\"path\""]),
    ]
}

fn logs() -> Vec<Row> {
    let trajectory = |label, distortion| (label, vec![Edit::Trajectory(distortion)]);
    let belong = ["logs belong", "trajectory of this flight", "time_offset_s"];
    let heights = ["heights", "origin_deg_m", "z_m"];
    let axes = ["axes", "heights", "origin_deg_m", "z_m"];
    vec![
        files(
            "another flight's logs",
            &belong,
            [
                ("radar", vec![to("radar.file", "\"../other/radar.mrm\"")]),
                ("rover", vec![to("gnss.rover", "\"../other/rover.obs\"")]),
                (
                    "rover and base",
                    vec![
                        to("gnss.rover", "\"../other/rover.obs\""),
                        to("gnss.base", "\"../other/base.obs\""),
                    ],
                ),
            ],
        ),
        files(
            "GNSS logs in the wrong place",
            &["base", "rover"],
            [
                (
                    "swapped",
                    vec![
                        to("gnss.rover", "\"base.obs\""),
                        to("gnss.base", "\"rover.obs\""),
                    ],
                ),
                ("rover twice", vec![to("gnss.base", "\"rover.obs\"")]),
                ("base twice", vec![to("gnss.rover", "\"base.obs\"")]),
            ],
        ),
        files(
            "GNSS logs of another day",
            &belong,
            [
                ("base", vec![to("gnss.base", "\"../day/base.obs\"")]),
                (
                    "navigation",
                    vec![to("gnss.navigation", "\"../day/broadcast.nav\"")],
                ),
                ("rover", vec![to("gnss.rover", "\"../day/rover.obs\"")]),
            ],
        ),
        files(
            "trajectory in another unit of length",
            &heights,
            [
                trajectory("feet", Distortion::Length(3.280_84)),
                trajectory("cm", Distortion::Length(1e2)),
                trajectory("mm", Distortion::Length(1e3)),
            ],
        ),
        files(
            "trajectory in another unit of time",
            &["position", "time_offset_s"],
            [
                trajectory("ms", Distortion::Time(1e3)),
                trajectory("ks", Distortion::Time(1e-3)),
                trajectory("minutes as seconds", Distortion::Time(60.0)),
            ],
        ),
        files(
            "trajectory with other axes",
            &axes,
            [
                trajectory("y up", Distortion::Axes([0, 2, 1])),
                trajectory("north, east, up", Distortion::Axes([1, 0, 2])),
                trajectory("up, north, east", Distortion::Axes([2, 1, 0])),
            ],
        ),
        files(
            "trajectory with a wrong sign",
            &axes,
            [
                trajectory("east", Distortion::Mirrored(0)),
                trajectory("north", Distortion::Mirrored(1)),
                trajectory("up", Distortion::Mirrored(2)),
            ],
        ),
        files(
            "trajectory's heights above something else",
            &heights,
            [
                trajectory("0.5 m", Distortion::Raised(0.5)),
                trajectory("2 m", Distortion::Raised(2.0)),
                trajectory("47 m", Distortion::Raised(47.0)),
            ],
        ),
    ]
}
