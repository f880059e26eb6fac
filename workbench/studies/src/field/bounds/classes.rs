//! Three classes in one record: the least error of a detector that decides by the bearing's order and by the friction.
//!
//! ```text
//! error = min over f, g of [1 − (1 − f)(1 − g) + M(f) + N(g)]/3                                             (1)
//! ```
//!
//! f and g are the parts of the healthy records that exceed a limit of the order and of the friction, M and N the parts
//! of the spalls and of the roughness that do not. Each limit is the best for the size of the defects, which a detector
//! that was trained with others does not know; a healthy record is wrong if it exceeds either limit, a defect only if
//! it does not exceed its own. What the other limit does to defects is left out, so no detector makes fewer errors.

use super::energy::Spall;
use super::power::order_power;
use crate::field::bounds::roughness::Population;
use crate::field::bounds::search::Search;
use model::evaluate::Rate;

/// f and g that are tried.
const RATES: [f64; 16] =
    [0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.015, 0.02, 0.03, 0.04, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3];

/// The bound and what is found, for defects of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassBound {
    /// Size of the defects.
    pub severity: f64,
    /// By an ideal detector of the order and an exact viscous friction.
    pub ideal: f64,
    /// By the core's statistic of the order and a viscous friction with the error that the core has.
    pub of_core: f64,
    /// Error of the discriminant of the table.
    pub found: Option<Rate>,
}

impl ClassBound {
    /// Bounds for one size; without a population the friction tells roughness from healthy drives.
    pub(super) fn of(
        severity: f64,
        (spalls, search): (&[Spall], &Search<'_>),
        friction: Option<(&Population, &[f64])>,
        found: Option<Rate>,
    ) -> Self {
        let by_friction = |errors: &[f64]| {
            let missed = |drives: &Population| missed(drives.powers(severity, errors, &RATES));
            friction.map_or_else(|| vec![0.0; RATES.len()], |(drives, _)| missed(drives))
        };
        let ideal = |rate: f64| {
            spalls.iter().map(|spall| order_power(spall, severity, rate)).sum::<f64>() / spalls.len() as f64
        };
        let ideal = missed(RATES.iter().map(|rate| ideal(*rate)).collect());
        Self {
            severity,
            ideal: least_error(&ideal, &by_friction(&[0.0])),
            of_core: least_error(
                &missed(search.powers(severity, &RATES)),
                &by_friction(friction.map_or(&[0.0], |(_, errors)| errors)),
            ),
            found,
        }
    }
}

fn missed(powers: Vec<f64>) -> Vec<f64> {
    powers.into_iter().map(|power| 1.0 - power).collect()
}

/// (1); the friction may need no limit that healthy records exceed.
fn least_error(by_order: &[f64], by_friction: &[f64]) -> f64 {
    let free = by_friction.iter().all(|missed| *missed <= 0.0);
    let each = RATES.iter().zip(by_order).flat_map(|(f, m)| {
        RATES.iter().zip(by_friction).map(move |(g, n)| {
            let g = if free { 0.0 } else { *g };
            (1.0 - (1.0 - f) * (1.0 - g) + m + n) / 3.0
        })
    });
    each.fold(1.0, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_limits_have_the_least_error() {
        let none = [0.0; RATES.len()];
        // Missed for certain below 5 %, then never: 5 % of a third of the records.
        let order = RATES.map(|rate| if rate < 0.05 { 1.0 } else { 0.0 });
        assert!((least_error(&order, &none) - 0.05 / 3.0).abs() < 1e-12);
        let both = least_error(&order, &order);
        assert!((both - (1.0 - 0.95 * 0.95) / 3.0).abs() < 1e-12, "{both}");
        // Nothing tells the classes: all are called healthy but for the least rate.
        let blind = least_error(&[1.0; RATES.len()], &[1.0; RATES.len()]);
        assert!((blind - 2.0 / 3.0).abs() < 1e-3, "{blind}");
    }
}
