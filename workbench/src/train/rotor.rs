//! Bearing orders that cannot be told from what turns with the rotor.
//!
//! ```text
//! |O − n| ≤ O |q| s + 1/(7 L)                                                        (1)
//! L ≥ 1/(7 (|O − n| − O |q| s)),   turns ≥ 16 L                                      (2)
//! ```
//!
//! Cogging, unbalance and errors of the angle are at whole orders n. The core compares phases of blocks of L turns up
//! to six blocks apart, which tells orders apart that differ by 1/(7 L), and searches slips up to s, by which an order
//! O changes by O q s. Training widens L to a sixteenth of a record's turns at most, hence (2).

use bearing_watch::internals::LAGS;
use bearing_watch::model::{TrackedOrder, Tracking};
use bearing_watch::plan::RunTime;

use super::shaft::BLOCKS_A_RECORD;

/// Blocks over which phases are compared.
const COMPARED: f64 = LAGS as f64 + 1.0;

/// An order next to one of the rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextToRotor {
    /// Place of the bearing order.
    pub place: usize,
    /// O, in events a turn.
    pub order: f64,
    /// n of (1).
    pub rotor: f64,
    /// Turns of a record from which they can be told apart (2); `None` if the slips that are searched reach n.
    pub turns: Option<f64>,
}

/// Returns 7 L of (1), the turns over which phases are compared.
#[must_use]
pub fn compared_turns(tracking: &Tracking<RunTime>) -> f64 {
    COMPARED * f64::from(tracking.blocks.cell_turns_log2).exp2()
}

/// Returns the orders for which (1) holds.
#[must_use]
pub fn next_to_rotor(tracking: &Tracking<RunTime>) -> Vec<NextToRotor> {
    let resolved = 1.0 / compared_turns(tracking);
    let each = |(place, own): (usize, &TrackedOrder)| {
        let order = f64::from(own.order());
        let rotor = order.round().max(1.0);
        let slip = order * f64::from(own.slip_ratio.abs() * tracking.blocks.slip);
        let apart = (order - rotor).abs() - slip;
        // Blocks are powers of two wide.
        let needed = || BLOCKS_A_RECORD * (1.0 / (COMPARED * apart)).log2().ceil().exp2();
        let turns = (apart > 0.0).then(needed);
        (apart <= resolved).then_some(NextToRotor { place, order, rotor, turns })
    };
    tracking.orders.iter().enumerate().filter_map(each).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::ShaftPlan;

    #[test]
    fn an_order_next_to_a_whole_one_needs_turns_or_less_slip() {
        let at = |order: f64, slip: f64, turns: f64| {
            let plan = ShaftPlan { slip, ..ShaftPlan::new(vec![("outer".into(), order)]) };
            next_to_rotor(&plan.tracking(turns, 1.0)).first().map(|found| (found.rotor, found.turns))
        };
        assert_eq!(at(3.72, 0.008, 40.0), None);
        // 4.1 slips by 0.033: 0.067 apart, which blocks of two turns do not resolve (0.071), but blocks of four do.
        assert_eq!(at(4.1, 0.008, 40.0), Some((4.0, Some(64.0))));
        assert_eq!(at(4.1, 0.008, 64.0), None);
        // Slips of 2.2 % reach 0.09.
        assert_eq!(at(4.08, 0.022, 1000.0), Some((4.0, None)));
        assert_eq!(at(4.08, 0.0, 1000.0), None);
        // No rotor order is below one.
        assert_eq!(at(0.4, 0.008, 40.0), None);
    }
}
