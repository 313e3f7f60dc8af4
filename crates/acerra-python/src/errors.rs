//! Exceptions by kind, with the command's messages.

use acerra_chain::ChainError;
use acerra_chain::campaign::CampaignError;
use acerra_chain::focus::plan::ImageError;
use acerra_chain::measure::MeasureError;
use acerra_imaging::ImagingError as Refused;
use acerra_products::RunError;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;

/// Makes exceptions, and the function that adds them to the module under their names in Python.
macro_rules! exceptions {
    ($($name:ident($base:ident): $what:literal),+ $(,)?) => {
        $(create_exception!(acerra, $name, $base, $what);)+

        /// Adds the exceptions to the module, under their names in Python.
        pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
            let py = module.py();
            $(module.add(stringify!($name), py.get_type::<$name>())?;)+
            Ok(())
        }
    };
}

exceptions! {
    AcerraError(PyException): "Whatever Acerra cannot do.",
    SettingsError(AcerraError): "A campaign, scene or plan that cannot be.",
    ReadError(AcerraError): "A file that cannot be read, or holds something else.",
    PositionError(AcerraError): "Positions that cannot be had.",
    AlignError(AcerraError): "Radar and positions that do not fit together.",
    CleanError(AcerraError): "Traces that cannot be cleaned.",
    ImagingError(AcerraError): "Data or pixels that cannot be imaged.",
    EvidenceError(AcerraError): "The findings contradict the settings.",
}

/// A failure to be raised in Python.
#[derive(Debug)]
pub enum Failure {
    /// The caller asked to stop.
    Cancelled,
    /// An exception of this kind.
    Raised(PyErr),
}

impl Failure {
    /// An [`ImagingError`] with this message.
    pub fn imaging(message: impl ToString) -> Self {
        Self::Raised(ImagingError::new_err(message.to_string()))
    }

    /// A [`SettingsError`] with this message.
    pub fn settings(message: impl ToString) -> Self {
        Self::Raised(SettingsError::new_err(message.to_string()))
    }

    /// A [`ReadError`] with this message.
    pub fn read(message: impl ToString) -> Self {
        Self::Raised(ReadError::new_err(message.to_string()))
    }

    /// A [`PositionError`] with this message.
    pub fn position(message: impl ToString) -> Self {
        Self::Raised(PositionError::new_err(message.to_string()))
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Cancelled => PyKeyboardInterrupt::new_err("cancelled"),
            Failure::Raised(error) => error,
        }
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Raised(error)
    }
}

impl From<Refused> for Failure {
    fn from(error: Refused) -> Self {
        match error {
            Refused::Cancelled => Self::Cancelled,
            error => Self::imaging(error),
        }
    }
}

impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::Cancelled(_) => Self::Cancelled,
            error => Self::imaging(error),
        }
    }
}

impl From<MeasureError> for Failure {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Cancelled(_) => Self::Cancelled,
            error => Self::imaging(error),
        }
    }
}

impl From<CampaignError> for Failure {
    fn from(error: CampaignError) -> Self {
        Self::settings(error)
    }
}

impl From<ChainError> for Failure {
    fn from(error: ChainError) -> Self {
        let text = error.to_string();
        Self::Raised(match error {
            ChainError::Cancelled(_) => return Self::Cancelled,
            ChainError::Read(_) => ReadError::new_err(text),
            ChainError::Position(_) => PositionError::new_err(text),
            ChainError::Align(_) | ChainError::Ground(_) => AlignError::new_err(text),
            ChainError::Clean(_) | ChainError::Calibration(_) | ChainError::Frequencies { .. } => {
                CleanError::new_err(text)
            }
            ChainError::Scene(_) | ChainError::NoTrack => SettingsError::new_err(text),
            ChainError::Image(_) | ChainError::Measure(_) => ImagingError::new_err(text),
            _ => AcerraError::new_err(text),
        })
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        let text = error.to_string();
        Self::Raised(match error {
            RunError::Chain(error) => return error.into(),
            RunError::Image(error) => return error.into(),
            RunError::Measure(error) => return error.into(),
            RunError::Cancelled(_) => return Self::Cancelled,
            RunError::Survey(_) | RunError::Geoid(_) => ReadError::new_err(text),
            RunError::Contradicted { .. } => EvidenceError::new_err(text),
            _ => AcerraError::new_err(text),
        })
    }
}

impl From<anyhow::Error> for Failure {
    /// The kind of the first cause that has one, with the whole chain as message.
    fn from(error: anyhow::Error) -> Self {
        let text = acerra_products::failure_text(&error);
        let error = match error.downcast::<RunError>() {
            Ok(error) => return error.into(),
            Err(error) => error,
        };
        Self::Raised(if error.is::<CampaignError>() {
            SettingsError::new_err(text)
        } else if error.is::<std::io::Error>() {
            ReadError::new_err(text)
        } else {
            AcerraError::new_err(text)
        })
    }
}
