//! Published figures of the source, as printed.
//!
//! Table 2.2 describes a laboratory motor module in open loop: a first-order model of its step response, with brake
//! positions 1 to 4 for increasing friction. Tables 3.1–3.2 and 4.1–4.4 describe a simulated motor under velocity
//! control.

use crate::demo::FirstInput;
use model::identify::Structure;

/// A column of Table 2.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Heading of the column.
    pub name: &'static str,
    /// a.
    pub a: f64,
    /// σ_a².
    pub a_variance: f64,
    /// b.
    pub b: f64,
    /// σ_b².
    pub b_variance: f64,
    /// Fit, %.
    pub fit_percent: f64,
}

const fn brake(name: &'static str, [a, a_variance, b, b_variance, fit_percent]: [f64; 5]) -> Brake {
    Brake { name, a, a_variance, b, b_variance, fit_percent }
}

/// Table 2.2.
pub const TABLE_2_2: [Brake; 5] = [
    brake("no brake", [-0.9565, 0.0002, 0.05275, 0.0003, 96.84]),
    brake("brake 1", [-0.9554, 0.0001, 0.05382, 0.0002, 96.68]),
    brake("brake 2", [-0.9485, 0.0004, 0.05353, 0.0003, 96.68]),
    brake("brake 3", [-0.9429, 0.0003, 0.05467, 0.0003, 95.91]),
    brake("brake 4", [-0.94044, 0.0003, 0.05194, 0.0002, 96.54]),
];

/// Table 3.1: eigenvalue and contribution, %, of each component of the a-parameters of [`ORDER_WITH_PCA`].
pub const TABLE_3_1: [(f64, f64); 3] = [(0.0015, 80.57), (3.6167e-4, 19.43), (1.0872e-7, 0.00584)];

/// Table 3.2, first line: features a₁ and a₂.
pub const ORDER_WITHOUT_PCA: Structure = Structure::new(2, 2, 2, 1, 1);
/// Its misclassification, %.
pub const ERROR_WITHOUT_PCA: f64 = 30.0;
/// Table 3.2, second line: features are two principal components of a₁, a₂, a₃.
pub const ORDER_WITH_PCA: Structure = Structure::new(3, 6, 3, 1, 2);
/// Its misclassification, %.
pub const ERROR_WITH_PCA: f64 = 6.0;
/// Number of data sets per class in the example of chapter 3 (Figs 3.8, 3.9).
pub const TRACES_CHAPTER_3: u32 = 25;
/// Number of data sets per class of chapter 4, in training and again in validation.
pub const TRACES_CHAPTER_4: u32 = 20;

/// One of Tables 4.1–4.4; rates in %.
#[derive(Clone, Copy, Debug)]
pub struct Simulation {
    /// Number of the table.
    pub number: &'static str,
    /// u1.
    pub input: FirstInput,
    /// Structure vector.
    pub order: Structure,
    /// Fit.
    pub fit_percent: f64,
    /// Misclassified, features a₁ and a₂: training, validation.
    pub without_pca: [f64; 2],
    /// Misclassified, features z₁ and z₂: training, validation.
    pub with_pca: [f64; 2],
}

/// Tables 4.1–4.4.
pub const CHAPTER_4: [Simulation; 4] = [
    Simulation {
        number: "4.1",
        input: FirstInput::Reference,
        order: Structure::new(2, 1, 2, 1, 1),
        fit_percent: 86.58,
        without_pca: [13.33, 33.33],
        with_pca: [13.33, 28.33],
    },
    Simulation {
        number: "4.2",
        input: FirstInput::Reference,
        order: Structure::new(3, 1, 2, 1, 1),
        fit_percent: 86.48,
        without_pca: [13.33, 21.67],
        with_pca: [13.33, 15.0],
    },
    Simulation {
        number: "4.3",
        input: FirstInput::Error,
        order: Structure::new(2, 2, 2, 1, 1),
        fit_percent: 92.05,
        without_pca: [13.33, 21.67],
        with_pca: [15.0, 18.33],
    },
    Simulation {
        number: "4.4",
        input: FirstInput::Error,
        order: Structure::new(3, 3, 3, 1, 1),
        fit_percent: 93.45,
        without_pca: [13.33, 18.33],
        with_pca: [16.67, 15.0],
    },
];

/// A structure vector in the notation of the source.
pub(super) fn written_order(order: Structure) -> String {
    let numbers = order.orders().map(|n| n.to_string()).join(" ");
    format!("[{numbers}]")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_the_published_counts_of_traces() {
        // Wrong traces of 60: training and validation without PCA, then with PCA.
        let counts = [[8, 20, 8, 17], [8, 13, 8, 9], [8, 13, 9, 11], [8, 11, 10, 9]];
        for (table, counts) in CHAPTER_4.iter().zip(counts) {
            let rates = [table.without_pca, table.with_pca].concat();
            for (rate, count) in rates.into_iter().zip(counts) {
                // Printed to two decimals.
                assert!((rate - 100.0 * f64::from(count) / 60.0).abs() < 0.0051, "{}: {rate}", table.number);
            }
        }
        assert_eq!((ERROR_WITHOUT_PCA, ERROR_WITH_PCA), (100.0 * 15.0 / 50.0, 100.0 * 3.0 / 50.0));
    }

    #[test]
    fn contributions_are_those_of_the_eigenvalues() {
        let total: f64 = TABLE_3_1.iter().map(|(value, _)| value).sum();
        for (value, contribution) in TABLE_3_1 {
            // The eigenvalues are printed to two to five digits; the rounding hardly affects the first one.
            assert!((100.0 * value / total / contribution - 1.0).abs() < 1e-3, "{value}");
        }
    }

    #[test]
    fn orders_inputs_and_fits_of_chapter_4() {
        let orders = CHAPTER_4.map(|t| t.order.orders());
        assert_eq!(orders, [[2, 1, 2, 1, 1], [3, 1, 2, 1, 1], [2, 2, 2, 1, 1], [3, 3, 3, 1, 1]]);
        assert_eq!(ORDER_WITH_PCA.orders(), [3, 6, 3, 1, 2]);
        for (first, second) in [(0, 1), (2, 3)] {
            assert_eq!(CHAPTER_4[first].input, CHAPTER_4[second].input);
        }
        // The model of the error has a better fit than that of the reference, and a approaches 0 with more friction.
        assert!(
            CHAPTER_4[..2].iter().all(|t| t.fit_percent < 87.0) && CHAPTER_4[2..].iter().all(|t| t.fit_percent > 92.0)
        );
        assert!(TABLE_2_2.windows(2).all(|pair| pair[0].a < pair[1].a));
    }
}
