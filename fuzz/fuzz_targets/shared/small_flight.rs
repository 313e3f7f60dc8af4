//! A flight of a few traces, imaged as a campaign asks for: an image or an error, whatever its numbers.

use acerra_chain::campaign::Campaign;
use acerra_chain::{
    Control, ImageRequest, MemorySink, Prepared, Recording, Scene, Warnings, prepare_as_stated,
};
use acerra_radar::{Radargram, Samples};

/// Pixels and slices that are worth a run's time.
const MOST_PIXELS: usize = 4_096;

/// Six traces of 96 samples, placed along a line 4 m up.
fn flight() -> Recording {
    let time_s: Vec<f64> = (0..6).map(f64::from).collect();
    let samples = (0..6 * 96).map(|k| ((k * k) % 17) as f32 - 8.0).collect();
    let radargram = Radargram::new(time_s, 0.0, 61e-12, Samples::Real(samples)).expect("traces");
    let places: Vec<[f64; 3]> = (0..6).map(|k| [0.1 * f64::from(k), 0.0, 4.0]).collect();
    Recording::new("flight", radargram, places)
}

/// The flight, cleaned as the campaign asks for; none where it refuses.
pub fn prepared(campaign: &Campaign) -> Option<Prepared> {
    let survey = campaign.survey();
    // Files of terrain and geoid are other targets' matter.
    if campaign.image.terrain.is_some() || campaign.image.geoid.is_some() {
        return None;
    }
    let mut recording = flight();
    recording.options = survey.tracks.first()?.options.clone();
    let warnings = &mut Warnings::default();
    let scene = Scene::find(&survey.scene, &[&recording.positions], warnings).ok()?;
    let control = Control::default();
    prepare_as_stated(&[recording], scene, &survey.calibration, warnings, &control).ok()
}

/// Makes an image, if it is small.
pub fn image(prepared: &Prepared, request: &ImageRequest) {
    let pixels = &request.pixels;
    let slices = pixels.volume.as_ref().map_or(1, |volume| volume.nz);
    if pixels.grid.len().saturating_mul(slices) > MOST_PIXELS {
        return;
    }
    let _ = prepared.image(request, &mut MemorySink::default(), &Control::default());
}
