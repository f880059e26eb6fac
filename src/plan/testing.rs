//! Plans for the unit tests.

use super::{Layout, Memory, Method, Plan, RegressionLayout, RunTime, Signal, Structure};

/// A plan with a regression alone; each signal with terms has its own channel.
#[must_use]
pub fn regression(structure: Structure, method: Method, memory: Memory) -> RunTime {
    let inputs = u8::from(structure.nb > 0);
    let regression = RegressionLayout {
        structure,
        method,
        memory,
        y: Signal::channel(0),
        u1: Signal::channel(1),
        u2: Signal::channel(1 + inputs),
    };
    let channels = 1 + inputs + u8::from(structure.nc > 0);
    let regression = Some(regression);
    let layout = Layout { channels, regression, features: 1, coordinates: 1, classes: 1, ..Layout::EMPTY };
    RunTime::of(layout).unwrap()
}
