//! Settings of the live image in a session file: `[live]`, completed from `[campaign]` and `[flight]`.

use acerra_chain::campaign::{
    Gate, Heights, ImageSection, PreprocessSection, TrajectorySection, ZeroTiming,
};
use acerra_chain::choices::Delay;
use acerra_chain::clean::frequencies_hz;
use acerra_geo::geodesy::Geodetic;
use acerra_imaging::PlaneGrid;
use acerra_record::session::Session;
use acerra_record::timing::Latency;
use serde::de::DeserializeOwned;

use crate::error::LiveError;
use crate::hardware_clock::Wiring;

/// Side of an image that no setting states (m).
const DEFAULT_SIDE_M: f64 = 20.0;
/// Pixel where none is stated (m).
const DEFAULT_PIXEL_M: f64 = 0.02;
const FINEST_PIXEL_M: f64 = 0.01;
/// Height above the image plane from which pulses are imaged, where neither it nor a planned height is stated (m).
const LEAST_HEIGHT_M: f64 = 0.5;
/// Share of the planned height from which pulses are imaged: pulses of the climb see surface and targets at
/// other angles and ranges from one place, and draw rings about that place.
const PLANNED_SHARE: f64 = 0.75;

/// Source of the fast time at which range is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zero {
    /// Fast time is shifted by this number of seconds (s).
    Shift(f64),
    /// By the surface echo of the first traces, near a delay where one is known (s).
    Surface(Option<f64>),
}

/// Settings of the live image in a session file.
#[derive(Clone, Debug)]
pub struct LiveSettings {
    /// Origin of the local frame; the first position without one.
    pub origin: Option<Geodetic>,
    /// Radar phase centre from the receiver's antenna: forward, left, up (m).
    pub lever_arm_m: [f64; 3],
    /// Extent of the pixels to the east (m), where stated.
    pub x_m: Option<[f64; 2]>,
    /// Extent of the pixels to the north (m), where stated.
    pub y_m: Option<[f64; 2]>,
    /// Distance of pixel centres (m), where it is stated.
    pub pixel_m: Option<f64>,
    /// Most pixels.
    pub max_pixels: u32,
    /// Height of the image plane (m).
    pub z_m: f64,
    /// Whether that height was stated, rather than assumed to be the origin's.
    pub is_height_stated: bool,
    /// Relative error allowed against Eq. (3).
    pub accuracy: f64,
    /// Frequencies of the spectra (Hz).
    pub frequency_hz: Vec<f64>,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
    /// Source of the fast time at which range is zero.
    pub zero: Zero,
    /// Interval of each trace that is kept about 2h/c (s); all of it without.
    pub gate_s: Option<[f64; 2]>,
    /// Traces over which the background is averaged.
    pub background_traces: u32,
    /// Traces that are waited for before the first is imaged.
    pub first_traces: usize,
    /// Height above the image plane from which pulses are imaged (m).
    pub least_height_m: f64,
    /// Latency common to all messages of the radio, and to all epochs of the receiver.
    pub latency: [Latency; 2],
    /// Hardware signals of the session.
    pub wiring: Wiring,
    /// The height planned, which `least_height_m` is a share of (m); `None` where that is stated or none is planned.
    pub planned_height_m: Option<f64>,
}

impl LiveSettings {
    /// The settings of a session.
    ///
    /// # Errors
    /// Tables of `[campaign]` that cannot be.
    ///
    /// ```
    /// use acerra_live::LiveSettings;
    /// use acerra_record::session::Session;
    /// let session = Session::parse(
    ///     "[radio]\naddress = '192.168.1.100:21210'\n[flight]\ndelay_ns = 10.0\n\
    ///      [campaign.image]\nx_m = [0, 18]\ny_m = [-9, 9]\n",
    /// )?;
    /// let settings = LiveSettings::of(&session)?;
    /// let grid = settings.grid([0.0, 0.0])?;
    /// assert_eq!((grid.nx, grid.ny), (1000, 1000));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(session: &Session) -> Result<Self, LiveError> {
        let live = &session.live;
        let image: ImageSection = table(session, "image")?;
        let trajectory: TrajectorySection = table(session, "trajectory")?;
        let preprocess: PreprocessSection = table(session, "preprocess")?;
        let [low, high] = image.band_ghz;
        if !(low > 0.0 && high > low && high.is_finite() && image.frequencies >= 2) {
            return Err(LiveError::Band {
                band_ghz: image.band_ghz,
                frequencies: image.frequencies,
            });
        }
        let stated_z_m = live.z_m.or(match image.z_m {
            Some(Heights::Plane(z_m)) => Some(z_m),
            Some(Heights::Range(_)) => Some(image.ground_z_m()),
            None => trajectory.origin_deg_m.map(|_| 0.0),
        });
        let gate_s = match (live.gate_ns, preprocess.gate_ns) {
            (Some(ns), _) => Some(ns),
            (None, gate) => Gate::about_ns(gate),
        };
        let planned_height_m = session
            .flight
            .height_m
            .filter(|_| live.least_height_m.is_none());
        let least_height_m = live
            .least_height_m
            .or(planned_height_m.map(|height_m| PLANNED_SHARE * height_m))
            .unwrap_or(LEAST_HEIGHT_M);
        Ok(Self {
            origin: trajectory
                .origin_deg_m
                .map(|[latitude, longitude, h]| Geodetic::from_degrees(latitude, longitude, h)),
            lever_arm_m: trajectory.lever_arm_m,
            x_m: live.x_m.or(image.x_m),
            y_m: live.y_m.or(image.y_m),
            pixel_m: live.pixel_m,
            max_pixels: live.max_pixels,
            z_m: stated_z_m.unwrap_or(0.0),
            is_height_stated: stated_z_m.is_some(),
            accuracy: live.accuracy,
            frequency_hz: frequencies_hz(image.band_ghz, image.frequencies),
            light_speed_m_s: image.light_speed_m_s,
            zero: zero(session, preprocess.zero_timing)?,
            gate_s: gate_s.map(|ns| ns.map(|ns| 1e-9 * ns)),
            background_traces: live.background_traces,
            first_traces: live.first_traces as usize,
            least_height_m,
            latency: session.latencies(),
            wiring: Wiring::of(session),
            planned_height_m,
        })
    }

    /// The pixels: where they are stated to be, else about a place east and north (m). They lie further apart
    /// than stated where they would be too many.
    ///
    /// # Errors
    /// Pixels that no image has.
    pub fn grid(&self, about_m: [f64; 2]) -> Result<PlaneGrid, LiveError> {
        let side = |stated: Option<[f64; 2]>, middle_m: f64| {
            stated.unwrap_or([
                middle_m - 0.5 * DEFAULT_SIDE_M,
                middle_m + 0.5 * DEFAULT_SIDE_M,
            ])
        };
        let (x_m, y_m) = (side(self.x_m, about_m[0]), side(self.y_m, about_m[1]));
        let mut pixel_m = self.pixel_m.unwrap_or(DEFAULT_PIXEL_M);
        // As `from_ranges` counts: an end that falls on a pixel is kept.
        let count =
            |[from, to]: [f64; 2], pixel_m: f64| ((to - from) / pixel_m + 1e-5).floor() + 1.0;
        let pixels = |pixel_m| count(x_m, pixel_m) * count(y_m, pixel_m);
        if self.pixel_m.is_none() {
            // As fine as the pixels allow, and no finer than the radar resolves.
            let area_m2 = (x_m[1] - x_m[0]) * (y_m[1] - y_m[0]);
            let finest_m = (area_m2 / f64::from(self.max_pixels)).sqrt();
            pixel_m = finest_m.clamp(FINEST_PIXEL_M, DEFAULT_PIXEL_M);
        }
        while pixels(pixel_m) > f64::from(self.max_pixels) {
            pixel_m *= 1.001;
        }
        PlaneGrid::from_ranges(x_m, y_m, self.z_m, pixel_m).map_err(LiveError::Grid)
    }

    /// A quarter of the wavelength in the middle of the band (m): positions with such an error from pulse to
    /// pulse do not focus.
    #[must_use]
    pub fn quarter_wavelength_m(&self) -> f64 {
        let ends = [self.frequency_hz.first(), self.frequency_hz.last()];
        let middle_hz = 0.5 * ends.into_iter().flatten().sum::<f64>();
        0.25 * self.light_speed_m_s / middle_hz
    }
}

/// A table of the session's campaign, or its defaults.
fn table<T: DeserializeOwned + Default>(
    session: &Session,
    name: &'static str,
) -> Result<T, LiveError> {
    match session.campaign.get(name) {
        None => Ok(T::default()),
        Some(value) => value
            .clone()
            .try_into()
            .map_err(|cause| LiveError::Campaign { table: name, cause }),
    }
}

/// The zero of range as the campaign would have it.
fn zero(session: &Session, stated: Option<ZeroTiming>) -> Result<Zero, LiveError> {
    let of_radar = session
        .campaign
        .get("radar")
        .and_then(|t| t.get("delay_ns"));
    let of_radar: Option<Delay> = of_radar
        .map(|value| value.clone().try_into())
        .transpose()
        .map_err(|cause| LiveError::Campaign {
            table: "radar",
            cause,
        })?;
    let delay_ns = of_radar
        .and_then(Delay::given_ns)
        .or(session.flight.delay_ns);
    let delay_s = delay_ns.map(|ns| 1e-9 * ns);
    Ok(match (stated, delay_s) {
        (Some(ZeroTiming::DirectWave), _) => return Err(LiveError::DirectWave),
        (Some(ZeroTiming::Shift { shift_ns }), _) => {
            Zero::Shift(1e-9 * shift_ns - delay_s.unwrap_or(0.0))
        }
        (Some(ZeroTiming::None), None) => Zero::Shift(0.0),
        (Some(ZeroTiming::None) | None, Some(delay_s)) => Zero::Shift(-delay_s),
        (Some(ZeroTiming::FirstTrace), _) | (None, None) => Zero::Surface(delay_s),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> LiveSettings {
        let head = "[radio]\naddress = \"127.0.0.1:1\"\n";
        LiveSettings::of(&Session::parse(&(head.to_owned() + text)).unwrap()).unwrap()
    }

    #[test]
    fn pixels_are_as_fine_as_their_number_allows() {
        let settings = of("[campaign.image]\nx_m = [0, 18]\ny_m = [-9, 9]\n");
        let grid = settings.grid([100.0, 100.0]).unwrap();
        assert_eq!([grid.nx, grid.ny], [1000, 1000], "{}", grid.pixel_m);
        let small = of("[live]\nmax_pixels = 10_000\n")
            .grid([3.0, 4.0])
            .unwrap();
        assert!(small.nx * small.ny <= 10_000 && small.nx >= 99);
        assert!((small.x0_m + 7.0).abs() < 1e-9 && (small.y0_m + 6.0).abs() < 1e-9);
    }

    #[test]
    fn range_zero_is_where_the_campaign_has_it() {
        assert_eq!(of("").zero, Zero::Surface(None));
        assert_eq!(of("[flight]\ndelay_ns = 10.0\n").zero, Zero::Shift(-1e-8));
        let of_radar = of("[flight]\ndelay_ns = 10.0\n[campaign.radar]\ndelay_ns = 5.0\n");
        assert_eq!(of_radar.zero, Zero::Shift(-5e-9));
        let surface =
            of("[flight]\ndelay_ns = 10.0\n[campaign.preprocess]\nzero_timing = \"first-trace\"\n");
        assert_eq!(surface.zero, Zero::Surface(Some(1e-8)));
    }

    #[test]
    fn pulses_of_the_climb_are_below_three_quarters_of_the_planned_height() {
        let least_m = |text: &str| of(text).least_height_m;
        assert_eq!(least_m(""), 0.5);
        assert_eq!(least_m("[flight]\nheight_m = 4.0\n"), 3.0);
        assert_eq!(of("[flight]\nheight_m = 4.0\n").planned_height_m, Some(4.0));
        let stated = "[flight]\nheight_m = 4.0\n[live]\nleast_height_m = 1.0\n";
        assert_eq!((least_m(stated), of(stated).planned_height_m), (1.0, None));
    }

    #[test]
    fn a_session_expects_what_it_is_wired_for() {
        let wired = |text: &str| {
            let wiring = of(text).wiring;
            [wiring.has_pulses, wiring.has_marks]
        };
        assert_eq!(wired(""), [false; 2]);
        let gnss = "[gnss]\naddress = \"127.0.0.1:2\"\npps = \"/dev/pps0\"\n";
        assert_eq!(wired(gnss), [true, false]);
        assert_eq!(wired(&format!("mark_delay_ms = 0.5\n{gnss}")), [true; 2]);
    }

    #[test]
    fn tables_that_cannot_be_are_refused() {
        let refused = |text: &str| {
            let session = Session::parse(&format!("[radio]\naddress = \"127.0.0.1:1\"\n{text}"));
            LiveSettings::of(&session.unwrap()).unwrap_err().to_string()
        };
        assert!(refused("[campaign.image]\nband_ghz = [4.8, 3.1]\n").contains("band_ghz"));
        assert!(
            refused("[campaign.trajectory]\nlever_arm = 3\n")
                .starts_with("[campaign.trajectory]: ")
        );
    }
}
