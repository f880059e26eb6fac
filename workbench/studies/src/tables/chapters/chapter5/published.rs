//! Published figures of chapter 5, as printed: the actuator on the rigs at Moog and at RIT.

use model::identify::Structure;

/// u1 of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Position command.
    Position,
    /// Position command − measured position.
    Error,
    /// Velocity command, the output of the position loop.
    Velocity,
}

impl Input {
    /// Name as in the titles of the source.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Position => "reference position",
            Self::Error => "position error",
            Self::Velocity => "reference velocity",
        }
    }
}

/// One of Tables 5.2–5.15; rates in %, training and validation. Tables 5.6 and 5.8 have a fit only, because the source
/// did not use these models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    /// Number of the table.
    pub number: &'static str,
    /// Number of the table with the rates with PCA, if it is another one.
    pub with: Option<&'static str>,
    /// Name of the rig's condition.
    pub condition: &'static str,
    /// u1.
    pub input: Input,
    /// Structure vector.
    pub order: Structure,
    /// Fit.
    pub fit_percent: f64,
    /// Misclassified without PCA.
    pub without_pca: Option<[f64; 2]>,
    /// Misclassified with PCA.
    pub with_pca: Option<[f64; 2]>,
}

const fn moog(
    (number, condition): (&'static str, &'static str),
    input: Input,
    [na, nb, nc, nkb, nkc]: [u8; 5],
    fit_percent: f64,
    rates: Option<[[f64; 2]; 2]>,
) -> Published {
    let order = Structure::new(na, nb, nc, nkb, nkc);
    let (without_pca, with_pca) = match rates {
        Some([without, with]) => (Some(without), Some(with)),
        None => (None, None),
    };
    Published { number, with: None, condition, input, order, fit_percent, without_pca, with_pca }
}

const fn rit(number: &'static str, with: &'static str, input: Input, fit_percent: f64) -> Published {
    let rates = Some([[50.0, 50.0], [18.75, 0.0]]);
    Published { with: Some(with), ..moog((number, "rit"), input, [3, 1, 1, 2, 2], fit_percent, rates) }
}

/// Tables 5.2–5.15.
pub const CHAPTER_5: [Published; 12] = {
    use Input::{Error, Position, Velocity};
    [
        moog(("5.2", "moog-1"), Position, [1, 2, 1, 1, 1], 93.24, Some([[50.0, 40.0], [40.0, 35.0]])),
        moog(("5.3", "moog-1"), Error, [3, 4, 4, 3, 3], 89.21, Some([[50.0, 60.0], [35.0, 35.0]])),
        moog(("5.4", "moog-2"), Position, [2, 4, 6, 2, 1], 80.10, Some([[60.0, 50.0], [35.0, 40.0]])),
        moog(("5.5", "moog-2"), Error, [3, 3, 3, 1, 2], 80.12, Some([[45.0, 35.0], [10.0, 10.0]])),
        moog(("5.6", "moog-3"), Position, [2, 2, 2, 4, 4], 48.50, None),
        moog(("5.7", "moog-3"), Error, [3, 2, 2, 1, 2], 83.34, Some([[40.0, 45.0], [40.0, 15.0]])),
        moog(("5.8", "moog-4"), Position, [2, 2, 2, 2, 1], 69.52, None),
        moog(("5.9", "moog-4"), Error, [3, 2, 3, 1, 2], 80.37, Some([[45.0, 40.0], [30.0, 10.0]])),
        moog(("5.10", "moog-5"), Position, [1, 2, 1, 1, 1], 87.52, Some([[15.0, 50.0], [10.0, 50.0]])),
        moog(("5.11", "moog-5"), Error, [3, 2, 1, 1, 1], 89.08, Some([[65.0, 70.0], [50.0, 35.0]])),
        rit("5.12", "5.14", Velocity, 99.124),
        rit("5.13", "5.15", Error, 99.125),
    ]
};

/// Data sets per class in each of the two sets at Moog: all rates are multiples of 1/20 (§5.1).
pub const TRACES_MOOG: u32 = 10;
/// Data sets per class in each of the two sets at RIT (§5.2).
pub const TRACES_RIT: u32 = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use rig::ema::EmaCondition;

    #[test]
    fn rates_are_counts_of_the_data_sets() {
        for table in CHAPTER_5 {
            let sets = if table.condition == "rit" { 2 * TRACES_RIT } else { 2 * TRACES_MOOG };
            for rate in [table.without_pca, table.with_pca].into_iter().flatten().flatten() {
                let count = rate / 100.0 * f64::from(sets);
                assert!((count - count.round()).abs() < 1e-12, "{}: {rate}", table.number);
            }
            assert_eq!(table.without_pca.is_none(), table.fit_percent < 70.0, "{}", table.number);
        }
    }

    #[test]
    fn conditions_and_orders_are_those_of_the_source() {
        for (table, (condition, order)) in CHAPTER_5.iter().zip([
            ("moog-1", [1, 2, 1, 1, 1]),
            ("moog-1", [3, 4, 4, 3, 3]),
            ("moog-2", [2, 4, 6, 2, 1]),
            ("moog-2", [3, 3, 3, 1, 2]),
            ("moog-3", [2, 2, 2, 4, 4]),
            ("moog-3", [3, 2, 2, 1, 2]),
            ("moog-4", [2, 2, 2, 2, 1]),
            ("moog-4", [3, 2, 3, 1, 2]),
            ("moog-5", [1, 2, 1, 1, 1]),
            ("moog-5", [3, 2, 1, 1, 1]),
            ("rit", [3, 1, 1, 2, 2]),
            ("rit", [3, 1, 1, 2, 2]),
        ]) {
            assert_eq!((table.condition, table.order.orders()), (condition, order));
            assert!(EmaCondition::named(condition).is_some());
            // The source gives position error in the second of two tables.
            assert_eq!(
                table.input == Input::Error,
                ["5.3", "5.5", "5.7", "5.9", "5.11", "5.13"].contains(&table.number)
            );
        }
    }
}
