//! The structures of a search, and whether the traces are long enough for them.

use crate::Error;
use crate::identify::Structure;
use crate::trace::Trace;

/// Upper limit on the number of structures; a larger grid is probably a mistake.
const MOST: usize = 200_000;

/// Every structure between two order vectors, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Minimum numbers of terms (from 1) and delays (from 0).
    pub min: Structure,
    /// Maximum numbers.
    pub max: Structure,
    /// Whether a constant term is estimated.
    pub offset: bool,
}

impl Grid {
    /// Terms and delays from 1 to these maxima: `4,4,4,4,4` is 1024 structures.
    #[must_use]
    pub const fn up_to(max: Structure, offset: bool) -> Self {
        Self { min: Structure::new(1, 1, 1, 1, 1), max, offset }
    }

    /// The structures of the grid; the last number varies fastest. Without a second input, nc = 0 in the maximum, its
    /// terms and delay do not vary.
    ///
    /// # Errors
    /// An empty range, a number of terms below 1, or more structures than the upper limit.
    pub fn structures(&self) -> Result<Vec<Structure>, Error> {
        let (mut min, mut max) = (self.min.orders(), self.max.orders());
        let single = max[2] == 0;
        if single {
            (min[2], min[4], max[4]) = (0, 0, 0);
        }
        for (k, name) in ["na", "nb", "nc", "nkb", "nkc"].into_iter().enumerate() {
            if k < 3 && min[k] == 0 && !(single && k == 2) {
                return Err(Error::Usage(format!(
                    "--min starts {name} at 0; every signal needs a term, give 1 or more"
                )));
            }
            if min[k] > max[k] {
                let (low, high) = (min[k], max[k]);
                let problem = format!("no {name} from {low} to {high}: raise it in --max, or lower it in --min");
                return Err(Error::Usage(problem));
            }
        }
        let count: usize = min.iter().zip(max).map(|(low, high)| usize::from(high - low) + 1).product();
        if count > MOST {
            return Err(Error::Usage(format!("{count} structures are more than {MOST}; lower --max or raise --min")));
        }
        let mut structures = Vec::with_capacity(count);
        for index in 0..count {
            let mut rest = index;
            let mut numbers = [0; 5];
            for k in (0..5).rev() {
                let values = usize::from(max[k] - min[k]) + 1;
                numbers[k] = min[k] + (rest % values) as u8;
                rest /= values;
            }
            structures.push(Structure { offset: self.offset, ..Structure::from_orders(numbers) });
        }
        Ok(structures)
    }
}

/// Rejects traces that are too short for the deepest structure, constant or not finite.
pub(super) fn check(train: &[Trace], validate: &[Trace], structures: &[Structure]) -> Result<(), Error> {
    let deepest = structures.iter().map(|s| s.depth()).max();
    let (Some(deepest), false, false) = (deepest, train.is_empty(), validate.is_empty()) else {
        return Err(Error::Usage("a search needs a structure, a training and a validation trace".into()));
    };
    if let Some(empty) = structures.iter().find(|s| s.terms() == 0) {
        return Err(Error::Usage(format!("order {:?} has no terms", empty.orders())));
    }
    let most = structures.iter().map(|s| s.parameters()).max().unwrap_or(0);
    // If structures are estimated without scoring, both arguments are the same traces; checking them twice would take
    // half of the computing time.
    let other = if std::ptr::eq(train, validate) { &[] } else { validate };
    for (traces, least) in [(train, deepest + most + 1), (other, deepest + 1)] {
        for trace in traces {
            let samples = trace.y.len();
            if samples < least {
                let problem = format!(
                    "{samples} samples, but lags back to {deepest} and {most} parameters need {least}; \
                     record more or lower --max"
                );
                return Err(Error::trace(&trace.id, problem));
            }
            for (signal, name) in [(&trace.y, "y"), (&trace.u1, "u1"), (&trace.u2, "u2")] {
                if signal.iter().all(|x| *x == signal[0]) {
                    let problem = format!("{name} is constant: nothing can be told of a structure; check --{name}");
                    return Err(Error::trace(&trace.id, problem));
                }
                // Without an early exit the loop is limited only by memory bandwidth.
                if !signal.iter().fold(true, |all, x| all & x.is_finite()) {
                    let problem = format!(
                        "{name} has missing samples; cut the recording there or resample it, since all structures share \
                         their rows"
                    );
                    return Err(Error::trace(&trace.id, problem));
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_is_every_structure_once() {
        let all = Grid::up_to(Structure::new(4, 4, 4, 4, 4), false).structures().expect("a grid");
        assert_eq!(all.len(), 1024);
        assert_eq!(all[1], Structure::new(1, 1, 1, 1, 2));
        let distinct: std::collections::HashSet<_> = all.iter().map(|s| s.orders()).collect();
        assert_eq!(distinct.len(), 1024);
        let narrow = Grid { min: Structure::new(2, 1, 1, 0, 3), max: Structure::new(2, 2, 1, 1, 3), offset: true };
        let orders: Vec<_> = narrow.structures().expect("a grid").iter().map(|s| s.orders()).collect();
        assert_eq!(orders, [[2, 1, 1, 0, 3], [2, 1, 1, 1, 3], [2, 2, 1, 0, 3], [2, 2, 1, 1, 3]]);
    }

    #[test]
    fn empty_ranges_are_refused() {
        let refused = |max| Grid::up_to(max, false).structures().expect_err("no grid").to_string();
        assert_eq!(
            refused(Structure::new(4, 4, 4, 0, 3)),
            "no nkb from 1 to 0: raise it in --max, or lower it in --min"
        );
        assert!(refused(Structure::new(0, 4, 4, 1, 3)).contains("no na from 1 to 0"));
        assert!(refused(Structure::new(32, 32, 32, 32, 32)).contains("33554432 structures"));
    }
}
