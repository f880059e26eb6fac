//! Labelled sets of traces; each trace has its own seed.
//!
//! A seed encodes the purpose and the conditions of its trace ([`SeedKey`]), so two different traces never have the
//! same seed.
//!
//! A trace of the standard rig needs 240 kB; [`map_traces`] stores only the result of its closure for each trace.
//!
//! ```
//! use bearing_watch_studies::campaign::{Cell, Purpose, record};
//! use rig::{Condition, Defect, DefectKind, Scenario};
//!
//! let cell = Cell {
//!     purpose: Purpose::Training,
//!     repetition: 0,
//!     condition: Condition::MIX,
//!     defect: Defect { kind: DefectKind::Spall, severity: 0.5 },
//! };
//! let short = Scenario { samples: 100, ..Scenario::STANDARD };
//! let set = record(&short, &[cell, Cell { purpose: Purpose::Validation, ..cell }], 3)?;
//! assert_eq!(set.len(), 6);
//! assert_ne!(set[0].seed, set[3].seed);
//! # Ok::<(), model::Error>(())
//! ```

use std::collections::HashSet;

use rayon::prelude::*;

use super::seeds::{Purpose, SeedKey};
use model::Error;
use rig::{Condition, Defect, RigTrace, Scenario, simulate};

/// A group of traces that differ only in their random draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Purpose of the traces.
    pub purpose: Purpose,
    /// Number of the repetition of the campaign, below 65 536.
    pub repetition: u32,
    /// Operating condition.
    pub condition: Condition,
    /// Defect; its severity is a multiple of 1/1920 and at most 2.13.
    pub defect: Defect,
}

impl Cell {
    /// The seed of trace `number`.
    ///
    /// # Errors
    /// [`Error::Usage`] if a field does not fit its bits: the seed would then equal that of another cell.
    pub fn seed(&self, number: u32) -> Result<u64, Error> {
        let Self { purpose, repetition, condition, defect } = *self;
        SeedKey { purpose, repetition, condition: condition.number, defect }.seed(number)
    }

    /// The scenario of the trace with this seed: `base` with the defect and under the condition.
    #[must_use]
    pub fn scenario(&self, base: &Scenario, seed: u64) -> Scenario {
        self.condition.apply(base.with_defect(self.defect), seed)
    }
}

/// One trace with its labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The cell it belongs to; `cell.defect.kind` is its class.
    pub cell: Cell,
    /// Its number in the cell.
    pub number: u32,
    /// Its seed.
    pub seed: u64,
    /// Reference, velocity, current, load and angle.
    pub trace: RigTrace,
}

/// Records traces 0…`count` of each cell in parallel, cell by cell in the order given.
///
/// # Errors
/// Returns an error if a cell has no seed, if two cells share a seed, or if the rig rejects a scenario.
pub fn record(base: &Scenario, cells: &[Cell], count: u32) -> Result<Vec<Recording>, Error> {
    map_traces(base, cells, count, Ok)
}

/// Same as [`record`], but stores only the result of `keep` for each trace; `keep` runs in parallel.
///
/// # Errors
/// Same as [`record`]; also if `keep` fails.
pub fn map_traces<T: Send>(
    base: &Scenario,
    cells: &[Cell],
    count: u32,
    keep: impl Fn(Recording) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let mut seen = HashSet::new();
    for cell in cells {
        if !seen.insert(cell.seed(0)?) {
            let name = cell.condition.name;
            return Err(Error::Usage(format!("two cells of a campaign share their seeds; the second is of {name}")));
        }
    }
    let jobs: Vec<(&Cell, u32)> = cells.iter().flat_map(|cell| (0..count).map(move |k| (cell, k))).collect();
    jobs.par_iter()
        .map(|&(cell, number)| {
            let seed = cell.seed(number)?;
            let trace = simulate(&cell.scenario(base, seed), seed).map_err(Error::other)?;
            keep(Recording { cell: *cell, number, seed, trace })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::seeds::NUMBERS;
    use rig::{DefectKind, trace_seed};

    const CELL: Cell = Cell {
        purpose: Purpose::Training,
        repetition: 0,
        condition: Condition::STANDARD,
        defect: Defect::full(DefectKind::Spall),
    };

    /// All purposes, classes, severities and conditions in 25 repetitions: 264 600 cells.
    fn all_cells() -> impl Iterator<Item = Cell> {
        let defects = DefectKind::ALL
            .into_iter()
            .flat_map(|kind| rig::SEVERITIES.into_iter().map(move |severity| Defect { kind, severity }));
        let conditions =
            defects.flat_map(|defect| Condition::all().map(move |condition| Cell { condition, defect, ..CELL }));
        conditions.flat_map(|cell| {
            Purpose::ALL
                .into_iter()
                .flat_map(move |purpose| (0..25).map(move |repetition| Cell { purpose, repetition, ..cell }))
        })
    }

    #[test]
    fn a_seed_tells_its_trace_so_no_two_traces_share_one() {
        let mut cells = HashSet::new();
        for cell in all_cells() {
            for number in [0, 1, 999, NUMBERS - 1] {
                let seed = cell.seed(number).expect("fits");
                // Decode each field from the seed: if every field can be recovered, no two traces have the same seed.
                let bits = |from: u32, count: u32| (seed >> from) & ((1 << count) - 1);
                assert_eq!(bits(0, 22), u64::from(number));
                assert_eq!(bits(22, 12) as f64, cell.defect.severity * 1920.0);
                assert_eq!(bits(34, 3), u64::from(cell.defect.kind.number()));
                assert_eq!(bits(37, 8), u64::from(cell.condition.number));
                assert_eq!(bits(45, 16), u64::from(cell.repetition));
                assert_eq!(bits(61, 2), cell.purpose.number());
                assert_eq!(seed >> 63, 1);
            }
            assert!(cells.insert(cell.seed(0).expect("fits")), "{cell:?}");
        }
        assert_eq!(cells.len(), 4 * 25 * 52 * 6 * 9);
    }

    #[test]
    fn seeds_of_other_sets_are_apart() {
        let last = trace_seed(u32::MAX >> 1, DefectKind::WeakMagnet, u32::MAX);
        assert!(all_cells().all(|cell| cell.seed(0).expect("fits") > last));
        // No two seeds of neighbouring sets are equal, for every class and for both ends of the number range.
        let mut seen = HashSet::new();
        for set in 0..20 {
            for kind in DefectKind::ALL {
                for k in (0..300).chain((1 << 29) - 300..1 << 29) {
                    assert!(seen.insert(trace_seed(set, kind, k)), "{set} {kind:?} {k}");
                }
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refused = |cell: Cell, number: u32| cell.seed(number).expect_err("does not fit").to_string();
        for severity in [0.3337, 3.0, -0.5, f64::NAN, f64::INFINITY] {
            let cell = Cell { defect: Defect { severity, ..CELL.defect }, ..CELL };
            assert!(refused(cell, 0).contains("severity"));
        }
        assert!(refused(Cell { repetition: 1 << 16, ..CELL }, 0).contains("repetition 65536"));
        assert!(refused(CELL, 1 << 22).contains("trace 4194304"));
        let other = Cell { condition: Condition { name: "another", resistance: 2.0, ..Condition::STANDARD }, ..CELL };
        let error = record(&Scenario::STANDARD, &[CELL, other], 1).expect_err("one number, two conditions");
        assert!(error.to_string().contains("share their seeds; the second is of another"));
    }

    #[test]
    fn traces_come_in_order_with_their_cell_and_their_own_draws() {
        let short = Scenario { samples: 200, ..Scenario::STANDARD };
        let healthy = Cell { purpose: Purpose::Validation, condition: Condition::MIX, defect: Defect::HEALTHY, ..CELL };
        let set = record(&short, &[CELL, healthy], 5).expect("valid");
        for (k, recording) in (0..).zip(&set) {
            let cell = if k < 5 { CELL } else { healthy };
            assert_eq!(
                (recording.cell, recording.number, recording.seed),
                (cell, k % 5, cell.seed(k % 5).expect("fits"))
            );
            let scenario = if k < 5 { short.with_defect(CELL.defect) } else { short.mixed(recording.seed) };
            assert_eq!(recording.trace, simulate(&scenario, recording.seed).expect("valid"));
        }
        // The fluctuation is a continuous random variable: its first value is equal only in traces with the same seed.
        let firsts: HashSet<u64> = set.iter().map(|r| r.trace.load_torque_nm[0].to_bits()).collect();
        assert_eq!(firsts.len(), 10);
        let kept = map_traces(&short, &[CELL, healthy], 5, |r| Ok(r.trace.current_a[199])).expect("valid");
        assert!(kept.iter().zip(&set).all(|(kept, r)| *kept == r.trace.current_a[199]));
    }
}
