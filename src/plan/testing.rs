//! Layouts for the unit tests.

use super::{Layout, Memory, Method, RegressionLayout, Signal, Structure};

/// A regression alone; each signal with terms has its own channel.
#[must_use]
pub fn regression(structure: Structure, method: Method, memory: Memory) -> Layout {
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
    Layout { channels, regression, features: 1, coordinates: 1, classes: 1, ..Layout::EMPTY }
}
