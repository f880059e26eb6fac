//! The instruction counts, cycles, stack depths and sizes that must be kept.

use crate::measure::Figure;

/// What is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    Instructions,
    /// With the wait states of the drive's chip.
    Cycles,
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
pub const BOUNDS: [Bound; 120] = [
    bound("LS update", Some(8), 285),
    bound("LS update", Some(15), 735),
    bound("LS update, lambda 1", Some(8), 245),
    bound("LS update, lambda 1", Some(15), 650),
    bound("IV update", Some(8), 395),
    bound("IV update", Some(15), 985),
    bound("LS sample, stuck sensor and outliers told", Some(8), 450),
    bound("SRIV sample, stuck sensor and outliers told", Some(8), 560),
    bound("SRIV sample, stuck sensor and outliers told, worst of 64", Some(8), 566),
    // What runs once a segment goes in steps, straight functions, whose frames a step alone has on the stack.
    bound("LS solve + covariance", Some(8), 9200),
    bound("SRIV solve + covariance", Some(8), 12_000),
    bound("projection 9 to 3", None, 810),
    // With the coordinate that departs most, and falls.
    bound("quadratic discriminant with posteriors and costs", None, 1650),
    bound("quadratic discriminant of coordinates with errors", None, 2760),
    bound("half-band decimation, 3 channels, mean sample", Some(8), 160),
    bound("half-band decimation, 3 channels, worst sample", Some(8), 205),
    bound("sin_cos + Clarke + Park", None, 60),
    // With the direction of the current vector, which needs no noise, offsets, levels and half waves of a phase, and
    // readings of the angle that are stale, have slipped, or have a bit that is stuck: no plan without a load would
    // find them otherwise.
    bound("front end, converter, 2 currents, mean sample", Some(8), 535),
    bound("front end, converter, 2 currents, worst sample", Some(8), 730),
    bound("front end, converter, 2 currents, mean sample", Some(10), 516),
    bound("front end, converter, 2 currents, worst sample", Some(10), 832),
    bound("front end, resolver, 3 currents, 2 further, mean sample", Some(8), 706),
    bound("front end, resolver, 3 currents, 2 further, worst sample", Some(8), 928),
    bound("LS detector, collect, mean sample", Some(8), 460),
    bound("LS detector, collect, mean sample, on a Cortex-M0", Some(8), 27_900),
    // Rounding and subnormals are tested with the sample that closes: the settings of the interrupt can change. The
    // sums are neither copied nor cleared; `discard` clears them in the interrupt.
    bound("LS detector, collect, sample that closes", Some(8), 640),
    bound("LS detector, conclude", Some(8), 13_700),
    bound("LS detector, longest step", Some(8), 1880),
    bound("SRIV detector, collect, mean sample", Some(8), 560),
    bound("SRIV detector, collect, sample that closes", Some(8), 770),
    bound("SRIV detector, conclude", Some(8), 16_500),
    bound("SRIV detector, longest step", Some(8), 4000),
    bound("LS and shaft, 4 orders of 3 harmonics, collect, mean sample", Some(4), 1050),
    bound("LS and shaft, 4 orders of 3 harmonics, collect, longest sample", Some(4), 1235),
    bound("LS and shaft, 4 orders of 3 harmonics, collect, sample that closes", Some(4), 1350),
    // The model has a gate with a rising coordinate, which takes 2000 of them; the smallest defects that the segment
    // would have shown take 3000.
    bound("LS and shaft, 4 orders of 3 harmonics, conclude", Some(4), 49_800),
    bound("LS and shaft, 4 orders of 3 harmonics, longest step", Some(4), 4750),
    // A sample of the shaft is a function of its own: its call takes ten here, and saves forty a row of a drive.
    bound("shaft alone, 1 order without load, collect, mean sample", Some(1), 685),
    bound("shaft alone, 1 order without load, longest step", Some(1), 3010),
    // The most that a search over damaged streams finds.
    bound("LS detector, collect, longest sample, any data", Some(8), 590),
    bound("LS detector, collect, sample that closes, any data", Some(8), 640),
    bound("LS detector, conclude, any data", Some(8), 14_000),
    bound("LS detector, longest step, any data", Some(8), 2030),
    bound("LS detector, adopt, any data", Some(8), 200),
    bound("LS detector, discard, any data", Some(8), 510),
    bound("SRIV detector, collect, longest sample, any data", Some(8), 600),
    bound("SRIV detector, collect, sample that closes, any data", Some(8), 770),
    bound("SRIV detector, conclude, any data", Some(8), 16_900),
    bound("SRIV detector, longest step, any data", Some(8), 4010),
    bound("LS and shaft, 4 orders of 3 harmonics, collect, longest sample, any data", Some(4), 1305),
    bound("LS and shaft, 4 orders of 3 harmonics, collect, sample that closes, any data", Some(4), 1425),
    bound("LS and shaft, 4 orders of 3 harmonics, conclude, any data", Some(4), 49_800),
    bound("LS and shaft, 4 orders of 3 harmonics, longest step, any data", Some(4), 4750),
    bound("LS and shaft, 4 orders of 3 harmonics, discard, any data", Some(4), 1500),
    bound("shaft alone, 1 order without load, collect, longest sample, any data", Some(1), 1225),
    // With the place of the segment, which the interrupt cleared before.
    bound("shaft alone, 1 order without load, conclude, any data", Some(1), 24_400),
    bound("shaft alone, 1 order without load, longest step, any data", Some(1), 3150),
    bound("front end, converter, 2 currents, worst sample, any data", Some(8), 735),
    bound("front end, converter, 2 currents, worst sample, any data", Some(10), 843),
    bound("front end, resolver, 3 currents, 2 further, worst sample, any data", Some(8), 950),
    bound("current loop of a drive, mean row", Some(10), 655),
    bound("current loop of a drive, longest row", Some(10), 1420),
    bound("below the current loop, mean sample", Some(10), 1500),
    bound("below the current loop, longest sample", Some(10), 1880),
    bound("below the current loop, sample that closes", Some(10), 2140),
    bound("below the current loop, sample that discards", Some(10), 2000),
    // What runs in the interrupt, 3 % above the estimate.
    cycles("front end, converter, 2 currents, mean sample", Some(8), 1065),
    cycles("front end, converter, 2 currents, worst sample", Some(8), 1460),
    cycles("front end, converter, 2 currents, mean sample", Some(10), 1030),
    cycles("front end, converter, 2 currents, worst sample", Some(10), 1665),
    cycles("front end, resolver, 3 currents, 2 further, mean sample", Some(8), 1405),
    cycles("front end, resolver, 3 currents, 2 further, worst sample", Some(8), 1900),
    cycles("LS detector, collect, mean sample", Some(8), 1150),
    cycles("LS detector, collect, longest sample", Some(8), 1150),
    cycles("LS detector, collect, sample that closes", Some(8), 1550),
    cycles("SRIV detector, collect, mean sample", Some(8), 1420),
    cycles("SRIV detector, collect, longest sample", Some(8), 1520),
    // Wait states depend on where the linker puts the code.
    cycles("SRIV detector, collect, sample that closes", Some(8), 1900),
    cycles("LS and shaft, 4 orders of 3 harmonics, collect, mean sample", Some(4), 2340),
    cycles("LS and shaft, 4 orders of 3 harmonics, collect, longest sample", Some(4), 2720),
    cycles("LS and shaft, 4 orders of 3 harmonics, collect, sample that closes", Some(4), 3010),
    cycles("shaft alone, 1 order without load, collect, mean sample", Some(1), 1345),
    // The sample that closes a part divides by the response of the filter.
    cycles("shaft alone, 1 order without load, collect, longest sample", Some(1), 2280),
    cycles("shaft alone, 1 order without load, collect, sample that closes", Some(1), 1750),
    cycles("current loop of a drive, mean row", Some(10), 1285),
    cycles("current loop of a drive, longest row", Some(10), 3060),
    cycles("below the current loop, mean sample", Some(10), 3230),
    cycles("below the current loop, sample that closes", Some(10), 4540),
    // With the gate, its counts and the limits of the channels.
    bytes("SRIV sample, stuck sensor and outliers told", Some(8), 620),
    // The sums are in the segment.
    // With the 23 samples that a filter before each second one reads.
    bytes("LS and shaft, 4 orders of 3 harmonics, collect, mean sample", Some(4), 1890),
    bytes("LS and shaft, 4 orders of 3 harmonics, collect, sample that closes", Some(4), 1350),
    // With the marks of the model and the gates of all classes, without which reports of two models mix.
    bytes("stack, detector sample", None, 307),
    bytes("stack, detector segment end", None, 1490),
    bytes("stack, detector collect", None, 320),
    bytes("stack, detector conclude", None, 690),
    bytes("stack, SRIV detector sample", None, 436),
    bytes("stack, SRIV detector segment end", None, 1910),
    bytes("stack, SRIV detector collect", None, 420),
    bytes("stack, SRIV detector conclude", None, 980),
    bytes("stack, SRIV detector step of the solve", None, 714),
    bytes("stack, detector with shaft of 4 orders sample", None, 960),
    bytes("stack, detector with shaft of 4 orders segment end", None, 4040),
    bytes("stack, detector with shaft of 4 orders collect", None, 385),
    bytes("stack, detector with shaft of 4 orders conclude", None, 2540),
    // With gates, arithmetic test, marks and silence: a verdict that nothing supports is told as none. Straight steps
    // took 1 to 2 % more than steps of a few instructions, for a quarter fewer instructions and half of the stack. The
    // numbers of directions are constants of each model.
    // Two callers of the verdict have a copy each where the compiler finds it small enough. With a shaft, the smallest
    // defects of orders and frictions, rest, falls and steps of the angle take 6 kB, of which the limits of a verdict
    // are more than half.
    bytes("flash of the whole detector, LS", Some(8), 15_450),
    bytes("flash of the whole detector, SRIV", Some(8), 18_200),
    bytes("flash of the whole detector, LS and shaft", Some(8), 42_900),
    // With growth and silence, and the offsets that last from run to run.
    bytes("flash of the evidence of runs, its reason and its growth", Some(5), 7500),
    bytes("evidence of runs, longest segment", Some(5), 940),
    bound("evidence of runs, longest segment", Some(5), 3680),
    bound("evidence of runs, longest end of a run", Some(5), 9900),
    // What the start of a resolver's angle takes, and what it would take otherwise.
    bytes("flash of an arctangent, micromath, for a resolver's start", None, 200),
    bytes("flash of an arctangent, libm", None, 750),
    bound("signed model of the standard rig, verified", None, 1_960_000),
    bound("saved state, sealed", None, 16_300),
    bound("sealed state, opened", None, 16_500),
    bytes("stack, signed model, verified", None, 5700),
    bytes("stack, sealed state, opened", None, 1300),
    bytes("flash of a verification of a signed model", None, 28_300),
    bytes("flash of sealing and opening of a saved state", None, 13_300),
];

const fn bound(name: &'static str, n: Option<u64>, most: u64) -> Bound {
    Bound { name, n, most, unit: Unit::Instructions }
}

const fn cycles(name: &'static str, n: Option<u64>, most: u64) -> Bound {
    Bound { name, n, most, unit: Unit::Cycles }
}

const fn bytes(name: &'static str, n: Option<u64>, most: u64) -> Bound {
    Bound { name, n, most, unit: Unit::Bytes }
}

impl Unit {
    const fn name(self) -> &'static str {
        match self {
            Self::Instructions => "instructions",
            Self::Cycles => "cycles",
            Self::Bytes => "bytes",
        }
    }
}

impl Bound {
    /// The bound as a line of a table.
    pub fn title(&self) -> String {
        let size = self.n.map_or_else(String::new, |n| format!(" n={n}"));
        format!("{}{size} ≤ {} {}", self.name, self.most, self.unit.name())
    }

    /// What was measured, or why the bound does not hold. Less than half of it does not hold either: then the
    /// optimiser has removed work that was to be measured, or the promise should be a better one.
    pub fn check(&self, figures: &[Figure]) -> Result<u64, String> {
        let counted = figures
            .iter()
            .find(|f| f.name == self.name && (self.n.is_none() || f.n == self.n))
            .and_then(|f| match self.unit {
                Unit::Instructions => f.instructions,
                Unit::Cycles => f.cycles[1],
                Unit::Bytes => f.bytes,
            })
            .ok_or_else(|| "not measured".to_owned())?;
        let unit = self.unit.name();
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
        let figure = Figure { name: "a".to_owned(), n: Some(8), instructions: Some(counted), ..Figure::default() };
        bound("a", Some(8), 100).check(&[figure]).is_ok()
    }

    #[test]
    fn a_bound_has_two_sides() {
        assert!(holds(100) && holds(50));
        assert!(!holds(101) && !holds(49));
    }

    #[test]
    fn size_is_bounded_in_bytes() {
        let figure = Figure { name: "a".to_owned(), n: Some(8), bytes: Some(90), ..Figure::default() };
        assert_eq!(bytes("a", None, 100).check(std::slice::from_ref(&figure)), Ok(90));
        assert!(bound("a", None, 100).check(&[figure]).is_err());
    }

    #[test]
    fn time_is_bounded_in_cycles_with_wait_states() {
        let figure = Figure { name: "a".to_owned(), cycles: [Some(10), Some(90)], ..Figure::default() };
        assert_eq!(cycles("a", None, 100).check(std::slice::from_ref(&figure)), Ok(90));
        assert!(cycles("a", None, 80).check(&[figure]).is_err());
    }

    #[test]
    fn what_is_not_measured_does_not_hold() {
        assert!(bound("a", Some(8), 100).check(&[]).is_err());
    }
}
