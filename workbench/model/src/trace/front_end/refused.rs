//! What a front end refused of a recording, in words.

use std::fmt;

use bearing_watch::drive::{Faults, Imbalance};

/// Samples that are missing behind a front end, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refused {
    /// Number of missing samples.
    pub missing: usize,
    /// Number of all samples, from the first one that is not missing.
    pub samples: usize,
    /// What the front end counted.
    pub faults: Faults,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { missing, samples, faults } = self;
        write!(f, "{missing} of {samples} samples are missing behind the front end: {}", words(faults))
    }
}

/// What was wrong, in words.
#[must_use]
pub fn words(faults: &Faults) -> String {
    let mut words = Vec::new();
    for (phase, own) in ["a", "b", "c"].iter().zip(&faults.currents) {
        let counted = [(own.saturated, "saturated"), (own.stuck, "stuck")];
        words.extend(counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("phase {phase} {what} {n} times")));
    }
    if let Some(imbalance) = &faults.imbalance.or(faults.last_imbalance) {
        let cause = match imbalance {
            Imbalance::Open(phase) => format!(": phase {phase:?} is open"),
            Imbalance::Silent(phase) => format!(": the sensor of phase {phase:?} reads nothing"),
            Imbalance::Gain { phase, error } => {
                format!(": the gain of phase {phase:?} is wrong by {:.1} %", 100.0 * error)
            }
            Imbalance::Unnamed => String::new(),
            Imbalance::Clipped(phase) => format!(": phase {phase:?} is clipped"),
            Imbalance::HalfWave(phase) => format!(": phase {phase:?} has no current in one direction"),
            Imbalance::Offset { phase, offset_a } => format!(": the offset of phase {phase:?} is {offset_a:.2} A"),
            Imbalance::Misaligned => {
                " or the rotor, with which they do not turn (phase order, direction of the angle, pole pairs)".into()
            }
        };
        let windows = faults.unbalanced_windows;
        words.push(format!("the currents do not fit each other{cause}, in {windows} windows"));
    }
    let position = &faults.position;
    let resolver = &position.resolver;
    for (count, what) in [
        (position.missing, "angles missing"),
        (position.strayed, "angles strayed"),
        (position.losses, "losses of the angle"),
        (position.stale, "angles repeated while the shaft turns"),
        (position.slipped, "slips of the angle"),
        (position.unsteady_windows, "windows of angles at unequal times"),
        (resolver.lost, "resolver signals too small"),
        (resolver.too_high, "resolver signals too large"),
        (resolver.mismatched, "resolver signals unequal"),
        (faults.gaps, "gaps in time"),
    ] {
        if count > 0 {
            words.push(format!("{count} {what}"));
        }
    }
    for bit in (0..32).filter(|bit| position.stuck_bits >> bit & 1 == 1) {
        words.push(format!("the bit of 1/{} turn in the angle is stuck", 1_u64 << (32 - bit)));
    }
    if words.is_empty() { "the angle was not found".into() } else { words.join(", ") }
}
