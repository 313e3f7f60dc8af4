//! Errors of a viewer: opening a run, serving it, answering a request.

use std::path::PathBuf;

use acerra_chain::ChainError;
use acerra_chain::autofocus::AutofocusFailure;
use acerra_chain::campaign::CampaignError;
use acerra_chain::focus::plan::ImageError;
use acerra_imaging::ImagingError;

/// Reason why runs are not shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A product is absent or broken.
    #[error("{}: {cause:#}", path.display())]
    Product {
        /// The product.
        path: PathBuf,
        /// Why.
        cause: anyhow::Error,
    },
    /// Axes that are not those of a grid of square pixels.
    #[error("{}: {axis}: expected evenly spaced pixels of one size, found {found}", path.display())]
    Grid {
        /// The image.
        path: PathBuf,
        /// The axis.
        axis: &'static str,
        /// Fault of the input.
        found: String,
    },
    /// No directory is named.
    #[error("expected the directory of a run, found none")]
    NoRun,
    /// The address of the server cannot be had.
    #[error("127.0.0.1:{port}: {cause}")]
    Bind {
        /// The requested port; 0 for any.
        port: u16,
        /// What the system says.
        cause: std::io::Error,
    },
    /// The server stops.
    #[error("the server stopped: {0}")]
    Serve(std::io::Error),
    /// The system gives no random numbers for the address.
    #[error("no random numbers for the address of the page: {0}")]
    Random(String),
    /// Map tiles that cannot be used.
    #[error(
        "--basemap {found}: expected an address such as https://tiles.example/{{z}}/{{x}}/{{y}}.png, or a \
         directory with files such as 17/70400/48900.png"
    )]
    Basemap {
        /// Value given.
        found: String,
    },
}

/// Reason why the data of a run cannot be imaged again.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// `run.json` holds no campaign that this version understands.
    #[error("run.json: configuration: {0}")]
    Configuration(String),
    /// An input is not there any more.
    #[error("{}: {cause}; the logs of a run are needed for its radargram and for new images", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: String,
    },
    /// An input is not the file that the run read.
    #[error("{}: expected the file that the run read (SHA-256 {expected:.12}…), found another", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
        /// The digest in `run.json`.
        expected: String,
    },
    /// A stage of the chain refuses the data.
    #[error("{0}")]
    Chain(String),
    /// The logs are being read and cleaned.
    #[error("the logs of the run are still being read")]
    NotReady,
}

/// Reason why a request is not answered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// There is no such run, raster, tile, file or place.
    #[error("{what}: there is none")]
    Absent {
        /// Request.
        what: &'static str,
    },
    /// A value that cannot be.
    #[error("{what}: expected {expected}, found {found}")]
    Invalid {
        /// Value given.
        what: &'static str,
        /// Possible values.
        expected: String,
        /// What it was.
        found: String,
    },
    /// A newer request took its place.
    #[error("a newer request took the place of this one")]
    Superseded,
    /// The data cannot be imaged again.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The requested settings are impossible.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// A stage of the chain refuses the settings.
    #[error(transparent)]
    Chain(ChainError),
    /// The positions cannot be corrected.
    #[error(transparent)]
    Autofocus(AutofocusFailure),
    /// The image cannot be made.
    #[error(transparent)]
    Image(ImageError),
    /// A grid that cannot be held.
    #[error(transparent)]
    Grid(#[from] ImagingError),
    /// A file of the run cannot be read.
    #[error("{name}: {cause}")]
    File {
        /// The product.
        name: String,
        /// What the system says.
        cause: std::io::Error,
    },
    /// The volume of the run cannot be read.
    #[error("{0:#}")]
    Volume(#[from] anyhow::Error),
    /// The campaign cannot be written as TOML.
    #[error("the campaign cannot be written: {0}")]
    Write(#[from] toml::ser::Error),
    /// The work was given up.
    #[error("the work was given up")]
    GivenUp,
}

impl From<ChainError> for RequestError {
    fn from(error: ChainError) -> Self {
        match error {
            ChainError::Cancelled(_) => Self::Superseded,
            error => Self::Chain(error),
        }
    }
}

impl From<AutofocusFailure> for RequestError {
    fn from(failure: AutofocusFailure) -> Self {
        match failure {
            AutofocusFailure::Cancelled(_) => Self::Superseded,
            failure => Self::Autofocus(failure),
        }
    }
}

impl From<ImageError> for RequestError {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::Cancelled(_) => Self::Superseded,
            error => Self::Image(error),
        }
    }
}
