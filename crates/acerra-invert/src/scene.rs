//! The fast operator: forward and adjoint by the engines of `acerra-imaging`, on planes, tilted planes,
//! uneven ground and the slices of a volume.

use crate::error::{InvertError, check_length};
use crate::flight::Flight;
use crate::operator::LinearOperator;
use crate::relief;
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ForwardVolume, ImageGrid, ImagingError,
    ImagingPlan, PlanOptions, PlaneGrid, SurfaceGrid, TiltedGrid, VolumeGrid,
    image_volume_planned_once,
};
use std::sync::OnceLock;

/// Random pixels on which the adjoint of every application checks itself.
const CHECK_PIXELS: usize = 48;
/// Relative errors tried where single precision is insufficient, as factors of the requested one.
const RELAXED: [f64; 3] = [1.0, 10.0, 100.0];
/// No relative error above this is of use to a solver.
const WORST_ACCURACY: f64 = 1e-2;

/// Positions of the pixels of a scene.
#[derive(Debug, Clone, Copy)]
pub enum Ground<'a> {
    /// A plane of any tilt.
    Plane(TiltedGrid),
    /// Uneven ground.
    Surface(&'a SurfaceGrid),
    /// The slices of a volume, one after another.
    Volume(VolumeGrid),
}

impl<'a> Ground<'a> {
    /// The grids that hold the pixels, in their order.
    #[must_use]
    pub fn grids(&self) -> Vec<ImageGrid<'a>> {
        match self {
            Self::Plane(grid) => vec![(*grid).into()],
            Self::Surface(surface) => vec![(*surface).into()],
            Self::Volume(volume) => (0..volume.nz).map(|k| volume.slice(k).into()).collect(),
        }
    }
}

/// L of a flight on a scene, by the engines of `acerra-imaging`.
///
/// Forward and adjoint keep the relative error `accuracy` against the double-precision sums each, and
/// ⟨Lσ, d⟩ = ⟨σ, L⁺d⟩ holds within it. On uneven ground the forward operator sums pixels into range bins
/// in double precision, some ten times slower than on planes.
pub struct SceneOperator<'a> {
    flight: &'a Flight,
    grids: Vec<ImageGrid<'a>>,
    forward: Modelled<'a>,
    options: PlanOptions,
    pixels: usize,
    /// The engine of the first adjoint, taken by all others.
    engine: OnceLock<Engine>,
}

/// The forward operator of a ground.
enum Modelled<'a> {
    Planar(Box<Forward<'a>>),
    Uneven(&'a SurfaceGrid),
    Volume(VolumeGrid, Box<ForwardVolume<'a>>),
}

impl<'a> SceneOperator<'a> {
    /// Plans the operator; `data` are weighted data of the flight ([`Flight::weighted`]), of which only the
    /// length counts. Spreading and incidence follow the flight's settings.
    ///
    /// # Errors
    /// Pixels that the engines refuse, single precision that does not keep the accuracy, cancellation.
    pub fn new(
        flight: &'a Flight,
        data: &'a [Complex64],
        ground: Ground<'a>,
        options: PlanOptions,
        control: Control,
    ) -> Result<Self, InvertError> {
        let options = options
            .with_spreading(flight.spreading())
            .with_incidence(flight.incidence());
        let pulses = flight.pulses(data)?;
        let kept = |engine: Engine| match engine {
            Engine::Reference if options.engine != Engine::Reference => {
                Err(InvertError::Inaccurate {
                    accuracy: options.accuracy,
                })
            }
            _ => Ok(()),
        };
        let forward = match ground {
            Ground::Plane(grid) => {
                let planned = Forward::with_control(pulses, grid, &options, control)?;
                kept(planned.engine())?;
                Modelled::Planar(Box::new(planned))
            }
            Ground::Surface(surface) => Modelled::Uneven(surface),
            Ground::Volume(volume) => {
                let planned = ForwardVolume::new(&volume, pulses, &options, control)?;
                planned.reports().try_for_each(|plan| kept(plan.engine))?;
                Modelled::Volume(volume, Box::new(planned))
            }
        };
        let grids = ground.grids();
        Ok(Self {
            flight,
            pixels: grids.iter().map(ImageGrid::len).sum(),
            grids,
            forward,
            options,
            engine: OnceLock::new(),
        })
    }

    /// The flight.
    #[must_use]
    pub fn flight(&self) -> &'a Flight {
        self.flight
    }

    /// The grids that hold the pixels, in their order.
    #[must_use]
    pub fn grids(&self) -> &[ImageGrid<'a>] {
        &self.grids
    }

    /// The place of pixel `index`, m.
    #[must_use]
    pub fn point_m(&self, index: usize) -> [f64; 3] {
        let mut at = index;
        for grid in &self.grids {
            if at < grid.len() {
                return grid.point_m(at % grid.columns(), at / grid.columns());
            }
            at -= grid.len();
        }
        [f64::NAN; 3]
    }

    /// Reports of the plans of the forward operator.
    #[must_use]
    pub fn explained(&self) -> String {
        match &self.forward {
            Modelled::Planar(forward) => forward.report().to_string(),
            Modelled::Uneven(_) => "forward: range bins in double precision".to_owned(),
            Modelled::Volume(_, forward) => forward
                .reports()
                .next()
                .map(ToString::to_string)
                .unwrap_or_default(),
        }
    }

    /// The image of `data` on one grid, at the tightest accuracy that single precision keeps.
    fn image(
        &self,
        grid: ImageGrid<'_>,
        data: &[Complex64],
        out: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        let pulses = self.flight.pulses(data)?;
        let mut image = vec![Complex32::ZERO; grid.len()];
        for factor in RELAXED {
            let engine = self.engine.get().copied();
            let options = self.relaxed(factor);
            let options = options.with_engine(engine.unwrap_or(self.options.engine));
            let plan = ImagingPlan::with_control(pulses, grid, &options, control)?;
            if self.is_too_slow(plan.engine()) {
                continue;
            }
            plan.run(&mut image, control)?;
            let _ = self.engine.set(plan.engine());
            widen(&image, out);
            return Ok(());
        }
        Err(InvertError::Inaccurate {
            accuracy: WORST_ACCURACY,
        })
    }

    /// As above for the slices of a volume, with one plan for as many of them as possible.
    fn image_slices(
        &self,
        volume: &VolumeGrid,
        data: &[Complex64],
        out: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        let pulses = self.flight.pulses(data)?;
        let pixels = volume.base.len();
        for factor in RELAXED {
            let options = self.relaxed(factor);
            let take = |k: usize, _: &PlaneGrid, image: &[Complex32]| {
                widen(image, &mut out[k * pixels..(k + 1) * pixels]);
                Ok::<_, ImagingError>(())
            };
            let run = image_volume_planned_once(volume, pulses, &options, control, take)?;
            if !self.is_too_slow(run.report.engine) {
                return Ok(());
            }
        }
        Err(InvertError::Inaccurate {
            accuracy: WORST_ACCURACY,
        })
    }

    /// The options of an adjoint whose accuracy is relaxed by `factor`.
    fn relaxed(&self, factor: f64) -> PlanOptions {
        let accuracy = (self.options.accuracy * factor).min(WORST_ACCURACY);
        self.options
            .with_accuracy(accuracy)
            .with_check_pixels(CHECK_PIXELS)
    }

    /// Whether an engine chooses double precision by itself: inversion applies the operator many times, so
    /// that single precision alone is used.
    fn is_too_slow(&self, engine: Engine) -> bool {
        matches!(engine, Engine::Double | Engine::Reference)
            && self.options.engine != Engine::Reference
    }
}

/// A scene in single precision.
fn narrow(scene: &[Complex64], out: &mut [Complex32]) {
    for (narrow, wide) in out.iter_mut().zip(scene) {
        *narrow = Complex32::new(wide.re as f32, wide.im as f32);
    }
}

/// An image in double precision.
fn widen(image: &[Complex32], out: &mut [Complex64]) {
    for (wide, narrow) in out.iter_mut().zip(image) {
        *wide = Complex64::new(f64::from(narrow.re), f64::from(narrow.im));
    }
}

impl LinearOperator for SceneOperator<'_> {
    fn pixels(&self) -> usize {
        self.pixels
    }

    fn samples(&self) -> usize {
        self.flight.samples()
    }

    fn forward(
        &self,
        scene: &[Complex64],
        data: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        check_length("scene", self.pixels, scene.len())?;
        check_length("data", self.samples(), data.len())?;
        match &self.forward {
            Modelled::Uneven(surface) => {
                data.fill(Complex64::ZERO);
                relief::add_echoes(self.flight, surface, scene, data, control);
            }
            Modelled::Planar(forward) => {
                let mut image = vec![Complex32::ZERO; scene.len()];
                narrow(scene, &mut image);
                forward.run(&image, data, control)?;
            }
            Modelled::Volume(volume, forward) => {
                let pixels = volume.base.len();
                let give = |k: usize, image: &mut [Complex32]| {
                    narrow(&scene[k * pixels..(k + 1) * pixels], image);
                };
                forward.run(give, data, control)?;
            }
        }
        Ok(control.check()?)
    }

    fn adjoint(
        &self,
        data: &[Complex64],
        scene: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        check_length("scene", self.pixels, scene.len())?;
        check_length("data", self.samples(), data.len())?;
        if let Modelled::Volume(volume, _) = &self.forward {
            return self.image_slices(volume, data, scene, control);
        }
        let mut at = 0;
        for grid in &self.grids {
            let out = &mut scene[at..at + grid.len()];
            at += grid.len();
            self.image(*grid, data, out, control)?;
        }
        Ok(())
    }

    fn working_bytes(&self) -> u128 {
        let image = self.grids.iter().map(|grid| grid.len() as u128 * 8).max();
        match &self.forward {
            Modelled::Planar(forward) => forward.memory_bytes() + image.unwrap_or(0),
            Modelled::Uneven(surface) => surface.len() as u128 * 40 + image.unwrap_or(0),
            Modelled::Volume(_, forward) => forward.memory_bytes(),
        }
    }
}
