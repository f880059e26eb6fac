//! Physical constants of a drive from its signals, with standard deviations.
//!
//! [`linear`]: mass, friction and offset of a linear drive from force and position. [`motor`]: inertia, friction and
//! torque constant of a motor from the torque balance. [`physical`]: R, L, Ke, J, B from the five-parameter difference
//! model of the current (thesis Eq. 2.41).

pub mod filter;
pub mod linear;
pub mod motor;
pub(crate) mod normal;
pub mod physical;
pub(crate) mod regression;

use nalgebra::DMatrix;

/// One physical constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Symbol.
    pub name: &'static str,
    /// Unit, SI.
    pub unit: &'static str,
    /// Estimate.
    pub value: f64,
    /// Standard deviation of the estimate.
    pub sd: f64,
}

impl Quantity {
    /// |sd / value|.
    #[must_use]
    pub fn relative_sd(&self) -> f64 {
        (self.sd / self.value).abs()
    }
}

/// Result of a grey-box estimation.
#[derive(Clone, Debug)]
pub struct GreyBox {
    /// The constants.
    pub quantities: Vec<Quantity>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// 100 ‖residual‖ / ‖regressed signal‖.
    pub relative_error_percent: f64,
    /// Rows of the regression.
    pub rows: usize,
    /// Assumptions, and quantities that the data do not determine.
    pub notes: Vec<String>,
}

impl GreyBox {
    /// The constant with this symbol.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Quantity> {
        self.quantities.iter().copied().find(|quantity| quantity.name == name)
    }

    /// Combines names, units and values with the standard deviations from the covariance.
    fn new(
        names: &[(&'static str, &'static str)],
        values: &[f64],
        covariance: DMatrix<f64>,
        (relative_error, rows): (f64, usize),
    ) -> Self {
        let named = names.iter().zip(values).enumerate();
        let quantities = named.map(|(k, (&(name, unit), &value))| {
            let sd = covariance[(k, k)].sqrt();
            Quantity { name, unit, value, sd }
        });
        let quantities = quantities.collect();
        Self { quantities, covariance, relative_error_percent: 100.0 * relative_error, rows, notes: vec![] }
    }

    /// Adds a note for the quantities whose standard deviation exceeds a third of their value.
    fn note_undetermined(&mut self) {
        let loose = self.quantities.iter().filter(|q| q.relative_sd() > 1.0 / 3.0 || q.relative_sd().is_nan());
        let loose: Vec<String> = loose.map(|q| format!("{} ± {:.0} %", q.name, 100.0 * q.relative_sd())).collect();
        if !loose.is_empty() {
            let said = loose.join(", ");
            self.notes.push(format!("hardly told from zero by these data (standard deviation): {said}"));
        }
    }
}
