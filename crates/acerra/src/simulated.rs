//! A simulated campaign in its folder.

use acerra_products::staging::Staging;
use acerra_simulate::scene::Scene;
use acerra_simulate::write::{Simulated, simulate_campaign};

/// Simulates `scene` and writes its logs and campaign file into `staging`.
///
/// # Errors
/// A scene that cannot be, or a directory that cannot be written.
pub fn write_campaign(scene: &Scene, staging: &Staging) -> anyhow::Result<Simulated> {
    let campaign = simulate_campaign(scene)?;
    for file in &campaign.files {
        staging.write(&file.name, &file.bytes)?;
    }
    Ok(campaign.summary)
}
