//! Why a rig cannot be built or run, and the checks of single parameters.

/// Reason why a rig cannot be built or run; each error contains the name of the invalid parameter.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The value is NaN or infinite.
    #[error("{name} must be finite, got {value}")]
    NotFinite {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
    },
    /// The value must be positive, but is zero or negative.
    #[error("{name} must be positive, got {value}")]
    NotPositive {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
    },
    /// The value must not be negative.
    #[error("{name} must not be negative, got {value}")]
    Negative {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
    },
    /// The value lies outside its range.
    #[error("{name} must lie between {from} and {to}, got {value}")]
    OutOfRange {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
        /// Smallest value.
        from: f64,
        /// Largest value.
        to: f64,
    },
    /// A trace needs at least one sample.
    #[error("samples must be at least 1")]
    NoSamples,
    /// The fluctuation's AR(1) pole lies on or outside the unit circle.
    #[error("load_fluctuation_pole must lie strictly between -1 and 1, got {0}")]
    UnstableFluctuation(f64),
    /// The loop is unstable: gains, motor and sampling time are not compatible.
    #[error("the closed loop diverges: state no longer finite at t = {t_s} s")]
    Diverged {
        /// Time of the first sample that is not finite.
        t_s: f64,
    },
}

/// Returns `value` if it is finite.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<f64, RigError> {
    if value.is_finite() { Ok(value) } else { Err(RigError::NotFinite { name, value }) }
}

/// Returns `value` if it is finite and positive.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, RigError> {
    if finite(name, value)? > 0.0 { Ok(value) } else { Err(RigError::NotPositive { name, value }) }
}

/// Returns `value` if it is finite and not negative.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, RigError> {
    if finite(name, value)? >= 0.0 { Ok(value) } else { Err(RigError::Negative { name, value }) }
}

/// Returns `value` if it lies between the limits, both included.
pub(crate) fn within(name: &'static str, value: f64, [from, to]: [f64; 2]) -> Result<f64, RigError> {
    if (from..=to).contains(&value) { Ok(value) } else { Err(RigError::OutOfRange { name, value, from, to }) }
}

/// Returns `value` if it lies between 0 and 1.
pub(crate) fn fraction(name: &'static str, value: f64) -> Result<f64, RigError> {
    within(name, value, [0.0, 1.0])
}
