//! The instruction counts, stack depths and sizes that must be kept.

use crate::measure::Figure;

/// What is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    Instructions,
    Bytes,
}

/// One promise: a call takes at most so much.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub name: &'static str,
    /// The size it holds for; none where the kernel has one size only.
    pub n: Option<u64>,
    pub most: u64,
    pub unit: Unit,
}

/// What is promised.
pub const BOUNDS: [Bound; 31] = [
    bound("LS update", Some(8), 285),
    bound("LS update", Some(15), 735),
    bound("LS update, lambda 1", Some(8), 245),
    bound("LS update, lambda 1", Some(15), 650),
    bound("IV update", Some(8), 395),
    bound("IV update", Some(15), 985),
    bound("LS sample, stuck sensor and outliers told", Some(8), 450),
    bound("SRIV sample, stuck sensor and outliers told", Some(8), 560),
    bound("SRIV sample, stuck sensor and outliers told, worst of 64", Some(8), 566),
    bound("LS theta read", Some(8), 150),
    bound("SRIV solve + covariance", Some(8), 2400),
    bound("half-band decimation, 3 channels, mean sample", Some(8), 160),
    bound("half-band decimation, 3 channels, worst sample", Some(8), 205),
    bound("sin_cos + Clarke + Park", None, 60),
    bound("projection 9 to 3 + quadratic discriminant 3 classes", None, 200),
    bound("shaft, 4 orders, mean sample", Some(4), 400),
    bound("shaft, 4 orders, sample with a row that ends a block", Some(4), 780),
    bound("shaft, 4 orders, segment end", Some(4), 8600),
    bytes("shaft, 4 orders, mean sample", Some(4), 640),
    bytes("SRIV sample, stuck sensor and outliers told", Some(8), 512),
    bytes("stack, detector sample", None, 600),
    bytes("stack, detector segment end", None, 1800),
    bytes("stack, SRIV detector sample", None, 1000),
    bytes("stack, SRIV detector segment end", None, 2000),
    bytes("stack, SRIV detector collect", None, 1000),
    // Its report holds a place for what the shaft says, watched or not.
    bytes("stack, SRIV detector conclude", None, 2150),
    bytes("stack, shaft of 4 orders, sample", None, 256),
    bytes("stack, shaft of 4 orders, segment end", None, 2350),
    // The goal is 8 KiB; README says where the rest goes. These keep it from growing.
    bytes("flash of the whole detector, LS", Some(8), 21_504),
    bytes("flash of the whole detector, SRIV", Some(8), 23_040),
    bytes("flash of the whole detector, LS and shaft", Some(8), 41_984),
];

const fn bound(name: &'static str, n: Option<u64>, most: u64) -> Bound {
    Bound { name, n, most, unit: Unit::Instructions }
}

const fn bytes(name: &'static str, n: Option<u64>, most: u64) -> Bound {
    Bound { name, n, most, unit: Unit::Bytes }
}

impl Bound {
    /// The bound as a line of a table.
    pub fn title(&self) -> String {
        let size = self.n.map_or_else(String::new, |n| format!(" n={n}"));
        format!("{}{size} ≤ {}", self.name, self.most)
    }

    /// What was measured, or why the bound does not hold. Less than half of it does not hold either: then the
    /// optimiser has removed work that was to be measured, or the promise should be a better one.
    pub fn check(&self, figures: &[Figure]) -> Result<u64, String> {
        let counted = figures
            .iter()
            .find(|f| f.name == self.name && (self.n.is_none() || f.n == self.n))
            .and_then(|f| match self.unit {
                Unit::Instructions => f.instructions,
                Unit::Bytes => f.bytes,
            })
            .ok_or_else(|| "not measured".to_owned())?;
        let unit = match self.unit {
            Unit::Instructions => "instructions",
            Unit::Bytes => "bytes",
        };
        if counted > self.most {
            Err(format!("{counted} {unit}"))
        } else if counted < self.most / 2 {
            Err(format!("{counted} {unit}: was the work optimised away?"))
        } else {
            Ok(counted)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(counted: u64) -> bool {
        let figure = Figure { name: "a".to_owned(), n: Some(8), instructions: Some(counted), bytes: None };
        bound("a", Some(8), 100).check(&[figure]).is_ok()
    }

    #[test]
    fn a_bound_has_two_sides() {
        assert!(holds(100) && holds(50));
        assert!(!holds(101) && !holds(49));
    }

    #[test]
    fn size_is_bounded_in_bytes() {
        let figure = Figure { name: "a".to_owned(), n: Some(8), instructions: None, bytes: Some(90) };
        assert_eq!(bytes("a", None, 100).check(std::slice::from_ref(&figure)), Ok(90));
        assert!(bound("a", None, 100).check(&[figure]).is_err());
    }

    #[test]
    fn what_is_not_measured_does_not_hold() {
        assert!(bound("a", Some(8), 100).check(&[]).is_err());
    }
}
