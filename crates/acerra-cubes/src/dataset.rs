//! Variables over named dimensions.

use std::borrow::Cow;
use std::collections::BTreeSet;

use num_complex::Complex32;

use crate::error::CubeError;

/// A property of a variable or a dataset.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A text.
    Text(String),
    /// A number.
    Number(f64),
    /// Several numbers.
    Numbers(Vec<f64>),
    /// Several whole numbers.
    WholeNumbers(Vec<i32>),
}

impl Attribute {
    /// A text.
    #[must_use]
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::text(text)
    }
}

impl From<String> for Attribute {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Attribute {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// The values of a variable, row-major.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<'a> {
    /// Single precision.
    Real32(Cow<'a, [f32]>),
    /// Double precision.
    Real64(Cow<'a, [f64]>),
    /// Complex numbers of two single-precision numbers.
    Complex32(Cow<'a, [Complex32]>),
    /// Whole numbers.
    Whole(Cow<'a, [i32]>),
}

impl Values<'_> {
    /// Number present.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Real32(v) => v.len(),
            Self::Real64(v) => v.len(),
            Self::Complex32(v) => v.len(),
            Self::Whole(v) => v.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl From<Vec<f32>> for Values<'_> {
    fn from(values: Vec<f32>) -> Self {
        Self::Real32(values.into())
    }
}

impl From<Vec<f64>> for Values<'_> {
    fn from(values: Vec<f64>) -> Self {
        Self::Real64(values.into())
    }
}

impl From<Vec<Complex32>> for Values<'_> {
    fn from(values: Vec<Complex32>) -> Self {
        Self::Complex32(values.into())
    }
}

impl<'a> From<&'a [Complex32]> for Values<'a> {
    fn from(values: &'a [Complex32]) -> Self {
        Self::Complex32(values.into())
    }
}

impl<'a> From<&'a [f32]> for Values<'a> {
    fn from(values: &'a [f32]) -> Self {
        Self::Real32(values.into())
    }
}

impl From<Vec<i32>> for Values<'_> {
    fn from(values: Vec<i32>) -> Self {
        Self::Whole(values.into())
    }
}

/// An array over dimensions, or a single value without dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable<'a> {
    /// Name.
    pub name: String,
    /// Names of its dimensions, the slowest first.
    pub dimensions: Vec<String>,
    /// Values.
    pub values: Values<'a>,
    /// Attributes, in order.
    pub attributes: Vec<(String, Attribute)>,
}

impl<'a> Variable<'a> {
    /// A variable without attributes.
    #[must_use]
    pub fn new(name: impl Into<String>, dimensions: &[&str], values: Values<'a>) -> Self {
        Self {
            name: name.into(),
            dimensions: dimensions.iter().map(|&d| d.to_owned()).collect(),
            values,
            attributes: Vec::new(),
        }
    }

    /// This variable with one more attribute.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Attribute>) -> Self {
        self.attributes.push((name.to_owned(), value.into()));
        self
    }
}

/// Images, rows and columns of a stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StackShape {
    /// Images.
    pub images: usize,
    /// Rows of each.
    pub rows: usize,
    /// Columns of each.
    pub columns: usize,
}

impl StackShape {
    pub(crate) fn lengths(self) -> [usize; 3] {
        [self.images, self.rows, self.columns]
    }

    /// Refuses an image of another number of values, and one too many after `written`.
    pub(crate) fn check_image(
        self,
        name: &str,
        written: usize,
        image: &[Complex32],
    ) -> Result<(), CubeError> {
        if image.len() != self.rows * self.columns {
            return Err(CubeError::Length {
                variable: name.to_owned(),
                expected: self.rows * self.columns,
                found: image.len(),
            });
        }
        if written == self.images {
            return Err(self.wrong_count(name, written + 1));
        }
        Ok(())
    }

    /// Refuses a stack of fewer images than announced.
    pub(crate) fn check_complete(self, name: &str, written: usize) -> Result<(), CubeError> {
        if written == self.images {
            Ok(())
        } else {
            Err(self.wrong_count(name, written))
        }
    }

    fn wrong_count(self, name: &str, found: usize) -> CubeError {
        CubeError::Slices {
            variable: name.to_owned(),
            expected: self.images,
            found,
        }
    }
}

/// Variables, their shared dimensions, and attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dataset<'a> {
    /// Dimensions with their lengths, in order.
    pub dimensions: Vec<(String, usize)>,
    /// Variables, in order.
    pub variables: Vec<Variable<'a>>,
    /// Attributes of the whole, in order.
    pub attributes: Vec<(String, Attribute)>,
}

impl<'a> Dataset<'a> {
    /// Declares a dimension.
    pub fn dimension(&mut self, name: impl Into<String>, length: usize) {
        self.dimensions.push((name.into(), length));
    }

    /// Adds a variable.
    pub fn variable(&mut self, variable: Variable<'a>) {
        self.variables.push(variable);
    }

    /// Adds an attribute of the whole.
    pub fn attribute(&mut self, name: impl Into<String>, value: impl Into<Attribute>) {
        self.attributes.push((name.into(), value.into()));
    }

    /// The lengths of a variable's dimensions.
    ///
    /// # Errors
    /// A dimension that is not declared, another number of values than they hold.
    pub fn shape(&self, variable: &Variable<'_>) -> Result<Vec<usize>, CubeError> {
        let length = |dimension: &String| {
            let declared = self.dimensions.iter().find(|(name, _)| name == dimension);
            declared
                .map(|(_, length)| *length)
                .ok_or_else(|| CubeError::Dimension {
                    variable: variable.name.clone(),
                    dimension: dimension.clone(),
                })
        };
        let shape: Vec<usize> = variable
            .dimensions
            .iter()
            .map(length)
            .collect::<Result<_, _>>()?;
        let (expected, found) = (shape.iter().product(), variable.values.len());
        if expected != found {
            return Err(CubeError::Length {
                variable: variable.name.clone(),
                expected,
                found,
            });
        }
        Ok(shape)
    }

    /// Refuses names that clash or that programs cannot open, and arrays of another length than their
    /// dimensions.
    pub(crate) fn check(&self) -> Result<(), CubeError> {
        let (mut variables, mut dimensions) = (BTreeSet::new(), BTreeSet::new());
        for variable in &self.variables {
            check_name(&variable.name)?;
            if !variables.insert(&variable.name) {
                return Err(CubeError::SameName {
                    name: variable.name.clone(),
                });
            }
            self.shape(variable)?;
        }
        for (name, _) in &self.dimensions {
            check_name(name)?;
            if !dimensions.insert(name) {
                return Err(CubeError::SameName { name: name.clone() });
            }
        }
        Ok(())
    }
}

/// Refuses names that are no file names everywhere.
pub(crate) fn check_name(name: &str) -> Result<(), CubeError> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let begins = name.starts_with(|c: char| c.is_ascii_alphabetic());
    if begins && name.chars().all(is_word) && name.len() <= 64 {
        return Ok(());
    }
    Err(CubeError::Name {
        name: name.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut data = Dataset::default();
        data.dimension("x", 2);
        let of = |name, dimensions: &[&str], n: usize| {
            let mut data = data.clone();
            data.variable(Variable::new(name, dimensions, Values::from(vec![0.0; n])));
            data.check().map_err(|error| error.to_string())
        };
        assert_eq!(of("power", &["x"], 2), Ok(()));
        assert_eq!(of("level", &[], 1), Ok(()));
        assert_eq!(of("power", &["x", "x"], 4), Ok(()));
        assert!(of("power", &["x"], 3).unwrap_err().contains("expected 2"));
        assert!(of("power", &["y"], 2).unwrap_err().contains("\"y\""));
        assert!(of("../power", &["x"], 2).unwrap_err().contains("letters"));
        let mut twice = data.clone();
        for _ in 0..2 {
            twice.variable(Variable::new("a", &["x"], Values::from(vec![1, 2])));
        }
        assert!(matches!(twice.check(), Err(CubeError::SameName { .. })));
    }
}
