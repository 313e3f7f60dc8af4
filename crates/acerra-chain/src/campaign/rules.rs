//! Which keys of a campaign exclude or need each other.

use acerra_settings::{Rule, check};

use super::error::exclude_if;
use super::sections::TrajectorySection;
use super::values::{self, is_volume, rule};
use super::{Campaign, CampaignError};
use crate::choices::{GroundSurface, Sum, Values};
use crate::focus::inversion::options::Method;

impl Campaign {
    /// Refuses values that are impossible, and keys that exclude each other.
    pub(super) fn check(&self) -> Result<(), CampaignError> {
        self.check_sources()?;
        for track in &self.track {
            values::track(track)?;
            let present = !track.radar.is_absent();
            check(
                "track.radar",
                &[Rule::new("file", present, "a radar log", "none")],
            )?;
        }
        values::tracks(&self.tracks)?;
        values::autofocus(&self.autofocus)?;
        self.check_looks_and_volumes()?;
        self.check_ground()?;
        for track in self.each_track() {
            track.check_one()?;
        }
        Ok(())
    }

    /// One flight here, or several in `[[track]]`.
    fn check_sources(&self) -> Result<(), CampaignError> {
        if self.track.is_empty() {
            let expected = "a radar log, here or in [[track]]";
            let present = !self.radar.is_absent();
            check("radar", &[Rule::new("file", present, expected, "none")])?;
            return Ok(());
        }
        exclude_if(
            !self.radar.is_absent(),
            ["[radar]", "[[track]]"],
            "both give radar logs",
        )?;
        exclude_if(
            self.gnss.is_some() || self.trajectory != TrajectorySection::default(),
            ["[trajectory] or [gnss]", "[[track]]"],
            "each track has its own: [track.trajectory], [track.gnss]",
        )?;
        exclude_if(
            self.image.looks.is_some(),
            ["[image] looks", "[[track]]"],
            "looks cut a single track",
        )?;
        Ok(())
    }

    /// The ground is one soil or layers, below a plane or a volume.
    fn check_ground(&self) -> Result<(), CampaignError> {
        let Some(ground) = &self.ground else {
            return Ok(());
        };
        values::ground(ground)?;
        if let Some((last, above)) = ground.layer.split_last() {
            let thick = above
                .iter()
                .all(|l| l.thickness_m.is_some_and(|t| t.is_finite() && t > 0.0));
            let rules = [rule(
                "thickness_m",
                thick && last.thickness_m.is_none(),
                "above 0 in every layer but the last, which has no thickness",
                ground
                    .layer
                    .iter()
                    .map(|l| l.thickness_m)
                    .collect::<Vec<_>>(),
            )];
            check("ground.layer", &rules)?;
        }
        let follows_terrain = ground.surface == GroundSurface::Terrain;
        exclude_if(
            self.image.terrain.is_some() != follows_terrain,
            ["[ground] surface", "[image] terrain"],
            "surface = \"terrain\" needs the terrain, and a level surface has none",
        )?;
        let is_uneven = ground.surface != GroundSurface::Level;
        exclude_if(
            is_uneven && self.image.z_m.is_none(),
            ["[ground] surface", "[image] z_m"],
            "below uneven ground the image has heights of its own: state z_m",
        )?;
        exclude_if(
            is_uneven && !ground.layer.is_empty(),
            ["[ground] surface", "[[ground.layer]]"],
            "layers are level, below a level surface",
        )?;
        exclude_if(
            self.image.method != Method::Adjoint,
            ["[ground]", "[image] method"],
            "the scene below ground is not solved for",
        )?;
        exclude_if(
            self.autofocus.enabled,
            ["[ground]", "[autofocus] enabled"],
            "positions are corrected by echoes through air",
        )?;
        Ok(())
    }

    fn check_looks_and_volumes(&self) -> Result<(), CampaignError> {
        let image = &self.image;
        exclude_if(
            image.terrain.is_some() && image.incidence().is_some(),
            [
                "[image] max_incidence_deg and antenna_cosine_power",
                "[image] terrain",
            ],
            "incidence is counted from the vertical of a level plane",
        )?;
        values::looks(image)?;
        self.check_method()?;
        if !is_volume(image) {
            return Ok(());
        }
        exclude_if(
            image.looks.is_some(),
            ["[image] looks", "[image] z_m = [from, to]"],
            "looks are planes",
        )?;
        exclude_if(
            self.tracks.sum == Sum::Incoherent,
            ["[tracks] sum = \"incoherent\"", "[image] z_m = [from, to]"],
            "a volume is resolved by coherence alone",
        )?;
        Ok(())
    }

    /// Products that `[image] method` excludes.
    fn check_method(&self) -> Result<(), CampaignError> {
        let image = &self.image;
        values::inversion(&image.inversion)?;
        self.check_values()?;
        if image.method == Method::Adjoint {
            return Ok(());
        }
        exclude_if(
            image.looks.is_some(),
            ["[image] looks", "[image] method"],
            "looks are adjoints of a part of the pulses",
        )?;
        exclude_if(
            image.method == Method::Clean && is_volume(image),
            ["[image] method = \"clean\"", "[image] z_m = [from, to]"],
            "points are put back on one plane or terrain",
        )?;
        exclude_if(
            self.tracks.sum == Sum::Incoherent && image.method != Method::Sparse,
            ["[tracks] sum = \"incoherent\"", "[image] method"],
            "all tracks explain one scene (but with method = \"sparse\")",
        )?;
        Ok(())
    }

    /// Reflectivities require an adjoint on a plane or terrain in air.
    fn check_values(&self) -> Result<(), CampaignError> {
        let image = &self.image;
        if image.values == Values::Sum {
            return Ok(());
        }
        let others = [
            (is_volume(image), "[image] z_m = [from, to]"),
            (image.looks.is_some(), "[image] looks"),
            (image.method != Method::Adjoint, "[image] method"),
            (self.ground.is_some(), "[ground]"),
            (
                self.tracks.sum == Sum::Incoherent,
                "[tracks] sum = \"incoherent\"",
            ),
        ];
        match others.iter().find(|(is_asked, _)| *is_asked) {
            Some((_, other)) => exclude_if(
                true,
                ["[image] values = \"reflectivity\"", other],
                "only an adjoint on a plane or terrain in air is divided by the image of a unit point",
            ),
            None => Ok(()),
        }
    }
}
