//! Rates of samples that recordings of drives have.
//!
//! ```text
//! least and largest rate that rounded times allow ─► the usual rate between them, if it is no coincidence
//! ```
//!
//! A rate of few digits lies in an interval of the relative width w by chance with about w·10ⁿ for n digits. It is
//! taken only where this is small.

/// Rows a second that a recording of a drive may have.
const PLAUSIBLE_HZ: [f64; 2] = [5.0, 2e6];
/// Largest relative widths of an interval in which a rate of one digit, and a power of two, is no coincidence.
const ONE_DIGIT: f64 = 0.05;
const POWER_OF_TWO: f64 = 0.01;
/// Largest probability by which a rate of more digits lies in the interval by chance, and the most digits.
const CHANCE: f64 = 0.2;
const DIGITS: i32 = 5;

/// Whether a recording of a drive may have so many rows a second.
pub(crate) fn is_plausible(rate_hz: f64) -> bool {
    (PLAUSIBLE_HZ[0]..=PLAUSIBLE_HZ[1]).contains(&rate_hz)
}

/// The usual rate between two rates.
pub(crate) fn between(low: f64, high: f64) -> Option<f64> {
    let middle = 0.5 * (low + high);
    let width = (high - low) / middle;
    if !(low > 0.0 && width >= 0.0) {
        return None;
    }
    let of_digits = |digits: i32| {
        let limit = if digits == 1 { ONE_DIGIT } else { CHANCE * 0.1_f64.powi(digits) };
        let unit = 10_f64.powi(middle.log10().floor() as i32 + 1 - digits);
        let rate = (middle / unit).round() * unit;
        (width <= limit && is_within(rate, low, high)).then_some(rate)
    };
    let of_two = || {
        let rate = middle.log2().round().exp2();
        (width <= POWER_OF_TWO && is_within(rate, low, high)).then_some(rate)
    };
    of_digits(1).or_else(of_two).or_else(|| (2..=DIGITS).find_map(of_digits))
}

/// Whether a rate is between two, but for the rounding of doubles.
fn is_within(rate: f64, low: f64, high: f64) -> bool {
    const ROUNDING: f64 = 1e-12;
    rate >= low * (1.0 - ROUNDING) && rate <= high * (1.0 + ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_rates_are_those_of_few_digits_and_powers_of_two() {
        // Steps with half a unit of their last digit.
        for (step, half, rate) in [
            (1.25e-4, 5e-7, Some(8000.0)),
            (0.000_333, 5e-7, Some(3000.0)),
            (0.000_33, 5e-6, Some(3000.0)),
            (1.2207e-4, 5e-10, Some(8192.0)),
            (1.22e-4, 5e-7, Some(8192.0)),
            (6.25e-5, 5e-8, Some(16_000.0)),
            (5.2083e-5, 5e-10, Some(19_200.0)),
            (5.2e-5, 5e-7, None),
            (1.2345e-4, 5e-9, None),
        ] {
            assert_eq!(between(1.0 / (step + half), 1.0 / (step - half)), rate, "{step}");
        }
        assert_eq!((between(f64::NAN, 1.0), between(0.0, 1.0), between(2.0, 1.0)), (None, None, None));
    }
}
