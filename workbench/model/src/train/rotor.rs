//! Bearing orders that cannot be told from what turns with the rotor.
//!
//! ```text
//! L = 2ⁿ ≤ min(0.5/(O_max s), turns/16, 64)                                        (1)
//! |O − n| ≤ O |q| s + 1/(7 L)                                                      (2)
//! ```
//!
//! Cogging, unbalance and errors of the angle are at whole orders n. The core compares phases of blocks of L turns up
//! to six blocks apart, which tells orders apart that differ by 1/(7 L), and searches slips up to s, by which an order
//! O changes by O q s. The highest order limits L, since its phase must not turn by more than half a turn in a block.

use bearing_watch::model::LAGS;
use bearing_watch::model::{TrackedOrder, Tracking};
use bearing_watch::plan::RunTime;

use super::shaft_plan::{BLOCKS_A_RECORD, CELLS_LOG2, cell_turns_log2};

/// Blocks over which phases are compared.
const COMPARED: f64 = LAGS as f64 + 1.0;

/// An order next to one of the rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextToRotor {
    /// Place of the bearing order.
    pub place: usize,
    /// O, in events a turn.
    pub order: f64,
    /// n of (2).
    pub rotor: f64,
    /// What tells them apart.
    pub remedy: Remedy,
}

/// What tells an order from one of the rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Records of so many turns.
    Turns(f64),
    /// A search over slips up to `slip` only, and records of so many turns.
    Slip {
        /// Largest slip.
        slip: f64,
        /// Turns of a record.
        turns: f64,
    },
    /// No record: the longest blocks do not resolve the difference.
    None,
}

/// Returns 7 L of (2), the turns over which phases are compared.
#[must_use]
pub fn compared_turns(tracking: &Tracking<RunTime>) -> f64 {
    compared(tracking.blocks.cell_turns_log2)
}

fn compared(log2: i8) -> f64 {
    COMPARED * f64::from(log2).exp2()
}

/// Returns the orders for which (2) holds.
#[must_use]
pub fn next_to_rotor(tracking: &Tracking<RunTime>) -> Vec<NextToRotor> {
    let searched = f64::from(tracking.blocks.slip);
    let orders = || tracking.orders.iter().map(|own| f64::from(own.order()));
    let each = |(place, own): (usize, &TrackedOrder)| {
        let order = f64::from(own.order());
        let rotor = order.round().max(1.0);
        let apart = |slip: f64| (order - rotor).abs() - order * f64::from(own.slip_ratio.abs()) * slip;
        // Turns of a record whose blocks resolve the difference at this slip.
        let needed = |slip: f64| {
            let longest = cell_turns_log2(orders(), slip, f64::INFINITY);
            let mut enough = (CELLS_LOG2[0]..=longest).filter(|log2| apart(slip) * compared(*log2) > 1.0);
            enough.next().map(|log2| BLOCKS_A_RECORD * f64::from(log2).exp2())
        };
        let remedy = || match needed(searched) {
            Some(turns) => Remedy::Turns(turns),
            None => smaller(searched, &needed),
        };
        let hidden = apart(searched) * compared_turns(tracking) <= 1.0;
        hidden.then(|| NextToRotor { place, order, rotor, remedy: remedy() })
    };
    tracking.orders.iter().enumerate().filter_map(each).collect()
}

/// Returns the largest slip, in tenths of the searched one, at which a record is long enough.
fn smaller(searched: f64, needed: &dyn Fn(f64) -> Option<f64>) -> Remedy {
    let mut slips = (0..10).rev().map(|tenths| searched * f64::from(tenths) / 10.0);
    let found = slips.find_map(|slip| needed(slip).map(|turns| Remedy::Slip { slip, turns }));
    found.unwrap_or(Remedy::None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::ShaftPlan;

    #[test]
    fn an_order_next_to_a_whole_one_needs_turns_or_less_slip() {
        let at = |order: f64, slip: f64, turns: f64| {
            let plan = ShaftPlan { slip, ..ShaftPlan::new(vec![("outer".into(), order)]) };
            next_to_rotor(&plan.tracking(turns, 1.0)).first().map(|found| (found.rotor, found.remedy))
        };
        assert_eq!(at(3.72, 0.008, 40.0), None);
        // 4.1 slips by 0.033: 0.067 apart, which blocks of two turns do not resolve (0.071), but blocks of four do.
        assert_eq!(at(4.1, 0.008, 40.0), Some((4.0, Remedy::Turns(64.0))));
        assert_eq!(at(4.1, 0.008, 64.0), None);
        // 4.04 slips by 0.032: 0.008 apart, for which blocks of 15.5 turns at most, 8, are too short. At nine tenths of
        // the slip it is 0.0109 apart, and blocks of 16 turns resolve 0.0089.
        let Some((4.0, Remedy::Slip { slip, turns })) = at(4.04, 0.008, 1000.0) else { panic!("a smaller slip") };
        assert!((slip - 0.0072).abs() < 1e-6 && (turns - 256.0).abs() < 1e-9, "{slip} {turns}");
        // Slips of 2.2 % reach 0.09 turns; those of 1.54 % leave 0.017, but blocks of 4 turns resolve 0.036 only.
        let Some((4.0, Remedy::Slip { slip, .. })) = at(4.08, 0.022, 1000.0) else { panic!("a smaller slip") };
        assert!((slip - 0.0132).abs() < 1e-6, "{slip}");
        assert_eq!(at(4.08, 0.0, 1000.0), None);
        // Blocks of 64 turns resolve 0.0022.
        assert_eq!(at(4.001, 0.0, 1e5), Some((4.0, Remedy::None)));
        // No rotor order is below one.
        assert_eq!(at(0.4, 0.008, 40.0), None);
    }
}
