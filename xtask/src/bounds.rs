//! The instruction counts that the kernels must keep.

use crate::measure::Figure;

/// One promise: a call takes at most so many instructions.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub name: &'static str,
    /// The size it holds for; none where the kernel has one size only.
    pub n: Option<u64>,
    pub most: u64,
}

/// What is promised.
pub const BOUNDS: [Bound; 6] = [
    bound("LS update", Some(8), 285),
    bound("LS update", Some(15), 735),
    bound("LS update, lambda 1", Some(8), 245),
    bound("LS update, lambda 1", Some(15), 650),
    bound("sin_cos + Clarke + Park", None, 60),
    bound("projection 9 to 3 + quadratic discriminant 3 classes", None, 200),
];

const fn bound(name: &'static str, n: Option<u64>, most: u64) -> Bound {
    Bound { name, n, most }
}

impl Bound {
    /// The bound as a line of a table.
    pub fn title(&self) -> String {
        let size = self.n.map_or_else(String::new, |n| format!(" n={n}"));
        format!("{}{size} ≤ {}", self.name, self.most)
    }

    /// The count that was measured, or why the bound does not hold. Less than half of it does not
    /// hold either: then the optimiser has removed work that was to be measured.
    pub fn check(&self, figures: &[Figure]) -> Result<u64, String> {
        let counted = figures
            .iter()
            .find(|f| f.name == self.name && (self.n.is_none() || f.n == self.n))
            .and_then(|f| f.instructions)
            .ok_or_else(|| "not measured".to_owned())?;
        if counted > self.most {
            Err(format!("{counted} instructions"))
        } else if counted < self.most / 2 {
            Err(format!("{counted} instructions: was the work optimised away?"))
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
    fn what_is_not_measured_does_not_hold() {
        assert!(bound("a", Some(8), 100).check(&[]).is_err());
    }
}
