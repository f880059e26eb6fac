use super::*;
use crate::plan::{Method, Plan as _, RunTime, testing};

fn plan() -> RunTime {
    RunTime::of(testing::regression(Structure::new(2, 2, 1, 1, 2), Method::Instruments, Memory::Segment)).unwrap()
}

/// A model with the poles 0.8 and 0.7, and the gain of u1.
fn constants(gain: f32) -> Regression<RunTime> {
    let mut constants = Regression::new(plan());
    constants.nominal.copy_from_slice(&[-0.06, 0.56, gain, 0.0, -0.1]);
    constants
}

/// Two square waves, and an output that follows neither.
fn inputs(t: usize) -> Inputs {
    let wave = |period: usize| if t % (2 * period) < period { 1.0 } else { -1.0 };
    Inputs { y: wave(7), u1: wave(5), u2: wave(3) }
}

#[test]
fn a_bad_sample_restarts_the_filters() {
    let constants = constants(0.06);
    let mut rows = Instruments::new(plan(), &constants);
    let mut given = 0;
    for t in 0..500 {
        if t == 250 {
            rows.flush(plan());
        }
        given += usize::from(rows.push(plan(), &constants, inputs(t), 100.0).is_some());
    }
    assert_eq!(given, 500 - 2 * 103);
}

#[test]
fn the_row_holds_filtered_signals() {
    // With t = [−1, 0] the filter passes its input: f + (f − in)·(−1) = in.
    let mut constants = constants(0.5);
    constants.nominal.copy_from_slice(&[-1.0, 0.0, 0.5, 0.0, 0.25]);
    constants.settle = 0;
    let mut rows = Instruments::new(plan(), &constants);
    for t in 0..40 {
        let row = rows.push(plan(), &constants, inputs(t), 100.0).map(|row| row.cells.to_vec());
        let Some(row) = row.filter(|_| t > 10) else { continue };
        let (now, before) = (inputs(t - 1), inputs(t - 2));
        assert_eq!(row[..3], [now.u1, now.u1 - before.u1, inputs(t - 2).u2], "t = {t}: u1, its difference, u2");
        // Simulated output one sample ago, and the measured one with its difference.
        let simulated = |t: usize| 0.5 * inputs(t - 1).u1 + 0.25 * inputs(t - 2).u2;
        assert_eq!((row[3], row[5], row[6]), (simulated(t - 1), now.y, now.y - before.y), "t = {t}");
        assert_eq!(row[7], inputs(t).y - simulated(t), "t = {t}: prediction error");
    }
}

#[test]
fn the_motion_is_that_of_the_scaled_inputs() {
    let mut constants = constants(0.5);
    constants.nominal.copy_from_slice(&[-1.0, 0.0, 0.5, 0.0, 0.25]);
    constants.settle = 0;
    constants.scale[2..5].copy_from_slice(&[4.0, 1.0, 2.0]);
    let mut rows = Instruments::new(plan(), &constants);
    for t in 0..40 {
        let motion = rows.push(plan(), &constants, inputs(t), 100.0).map(|row| row.motion);
        let Some(motion) = motion.filter(|_| t > 10) else { continue };
        let u1 = 4.0 * (inputs(t - 1).u1 - inputs(t - 2).u1);
        let u2 = 2.0 * (inputs(t - 2).u2 - inputs(t - 3).u2);
        assert_eq!(motion, u1 * u1 + u2 * u2, "t = {t}");
    }
}

/// Signals far from zero, of the nominal model itself, which rest at one level after the other: what the constant and
/// the levels explain is no error, also after the origin has moved with a new segment. At rest the simulated output is
/// the measured one, and both are zero from a move until the level changes. Without terms, an input has no effect, and
/// without a constant there is no origin.
#[test]
fn levels_and_constant_leave_no_prediction_error() {
    for (nb, nc, offset) in [(1, 0, true), (1, 1, true), (1, 1, false), (0, 1, true)] {
        let structure = Structure { offset, ..Structure::new(1, nb, nc, 1, 1) };
        let plan = RunTime::of(testing::regression(structure, Method::Instruments, Memory::Segment)).unwrap();
        let mut constants = Regression::<RunTime>::new(plan);
        let (t, gain, second) = (-0.5, 0.25 * f32::from(nb), 0.125 * f32::from(nc));
        let constant = if offset { 3.0 } else { 0.0 };
        let terms = [&[t][..], &[gain][..usize::from(nb)], &[second][..usize::from(nc)]].concat();
        let nominal = [&terms[..], &[constant][..usize::from(offset)]].concat();
        constants.nominal.copy_from_slice(&nominal);
        constants.settle = 0;
        let mut rows = Instruments::new(plan, &constants);
        let mut y = (gain * 40.0 + second * 7.0 + constant) / -t;
        let (mut given, mut moved, mut at_origin) = (0, 0, false);
        for k in 0..800 {
            // After some segments without an estimate the nominal model is in use anew.
            if k % 100 == 99 {
                let before = rows.origin;
                rows.next_segment(plan, &constants);
                at_origin = rows.origin != before;
                moved += usize::from(at_origin);
            }
            // A level until it changes with some motion, 29 samples before the next segment.
            let (level, resting) = ((k + 50) / 100, k % 100 < 50);
            at_origin &= resting || k % 100 == 99;
            let moving = if (50..70).contains(&(k % 100)) { 1.0 } else { 0.0 };
            let (u1, u2) = (40.0 + level as f32 + moving * inputs(k).u1, 7.0 + level as f32 + moving * inputs(k).u2);
            if let Some(row) = rows.push(plan, &constants, Inputs { y, u1, u2 }, 1000.0) {
                let [error, measured, simulated] = [1, 2, 3].map(|from_end| row.cells[row.cells.len() - from_end]);
                // Roundings of numbers up to fifty.
                assert!(error.abs() < 5e-5, "{k}: {error}");
                assert!(!resting || (measured - simulated).abs() < 5e-5, "{k}: {measured} {simulated}");
                assert!(!at_origin || measured.abs() < 5e-5, "{k}: {measured}");
                given += 1;
            }
            y += t * y + gain * u1 + second * u2 + constant;
        }
        assert!(given > 790 && (moved > 0) == offset, "{given} {moved}");
    }
}

#[test]
fn an_exploding_simulation_starts_anew() {
    // Stable, but the gain of u1 is absurd: the simulated output leaves every bound.
    let wild = constants(1e30);
    let mut rows = Instruments::new(plan(), &wild);
    for t in 0..2000 {
        let row = rows.push(plan(), &wild, inputs(t), 100.0);
        assert!(row.is_none_or(|row| row.cells.iter().all(|x| x.abs() < 1e5)));
        assert!(rows.cells.iter().all(|x| x.is_finite()));
    }
}
