use super::*;
use crate::plan::{Layout, Load, Plan as _, RunTime, RunTimeSample, ShaftLayout, Signal};
use crate::reason::Reason;
use crate::shaft::{Blocks, Friction, ShaftEstimate, ShaftSolve, StateVariable, TrackedOrder};
use std::vec;

/// Current, velocity, load.
fn plan(decimation: u8) -> RunTime {
    let [current, velocity, load] = [0, 1, 2].map(Signal::channel);
    let shaft = ShaftLayout {
        current,
        velocity: Some(velocity),
        load: Load::Measured(load),
        orders: 0,
        harmonics: 1,
        decimation,
    };
    let layout = Layout { channels: 3, shaft: Some(shaft), features: 1, coordinates: 1, classes: 1, ..Layout::EMPTY };
    RunTime::of(layout).unwrap()
}

pub fn balance() -> TorqueBalance {
    TorqueBalance {
        interval_s: 0.001,
        filter: StateVariable::new(0.05, 0.001),
        row_interval: 4,
        settle: 50,
        sign_velocity_rad_s: 1.0,
        stribeck_velocity_rad_s: 4.0,
        usual_velocity_rad_s: 20.0,
        usual_load_nm: 0.0,
        row_spread: 1.0,
        scale: [0.015_625, 0.062_5, 1.0, 8.0, 1.0, 8.0, 1.0, 1.0],
        nominal: [0.005, 0.002, 0.1, 20.0, 0.05, 0.0, 0.0],
        prior: [0.05, 0.02, 1.0, 200.0, 1.0, 20.0, 1.0],
        deviation: 0.001,
        adapt_after_rows: 48,
        largest_change_rad: f32::INFINITY,
    }
}

fn constants(current_lag: f32, decimation: u8) -> ShaftConstants<RunTime> {
    let mut balance = balance();
    if decimation == 2 {
        let filter = StateVariable::new(0.1, 0.002);
        balance = TorqueBalance { interval_s: 0.002, filter, row_interval: 2, settle: 25, ..balance };
    }
    let tracking = Tracking { orders: vec![], blocks: Blocks::EMPTY };
    ShaftConstants { lags: Lags { current: current_lag, ..Lags::default() }, balance, tracking }
}

/// The friction of a shaft whose current lags by `lag` samples.
fn friction(lag: f64, current_lag: f32, decimation: u8, good: impl Fn(u32) -> bool) -> Result<Friction, Reason> {
    let (plan, constants) = (plan(decimation), constants(current_lag, decimation));
    let (mut shaft, mut sums) = (Shaft::new(plan, &constants), ShaftSums::new(plan, &constants));
    let signals = |t: f64| {
        let w = 30.0 * (4.0 * t).sin() + 8.0 * (17.0 * t).sin();
        let dw = 120.0 * (4.0 * t).cos() + 136.0 * (17.0 * t).cos();
        let load = 0.1 * (9.0 * t).sin();
        (w, load, 0.006 * dw + 0.003 * w + 0.15 * w.clamp(-1.0, 1.0) + 18.0 * load + 0.02)
    };
    for k in 0..4000_u32 {
        let t = f64::from(k) * 0.001;
        let ((w, load, _), (.., current)) = (signals(t), signals(t - 0.001 * lag));
        let values = [current, w, load].map(|x| x as f32).to_vec();
        let sample = RunTimeSample { values, ..RunTimeSample::default() };
        shaft.step(&mut sums, plan, &constants, (&sample, good(k)));
    }
    let (mut solve, mut estimate) = (ShaftSolve::new(), ShaftEstimate::empty(plan));
    while !solve.advance(plan, &constants, &mut sums, &mut estimate) {}
    estimate.friction_reason.map_or(Ok(estimate.friction), Err)
}

#[test]
fn the_lag_of_the_current_is_compensated() {
    for (lag, decimation) in [0.0, 1.0, 1.5, 2.5].into_iter().flat_map(|lag| [(lag, 1), (lag, 2)]) {
        let friction = friction(lag, lag as f32, decimation, |_| true).unwrap();
        // Linear interpolation over a sample: (17 · 0.001)²/8 of the signal; the filter's derivative is 2e-5.
        assert!((friction.drag.value / 0.21 - 1.0).abs() < 5e-3, "{lag} {decimation}: {friction:?}");
        assert!((friction.inertia.value / 0.006 - 1.0).abs() < 5e-3, "{lag} {decimation}: {friction:?}");
    }
    // A lag of 2.5 ms that is not compensated turns the rate of the velocity into friction.
    let blind = friction(2.5, 0.0, 1, |_| true).unwrap();
    assert!((blind.viscous.value / 0.003 - 1.0).abs() > 0.3, "{blind:?}");
}

#[test]
fn a_shaft_that_only_trembles_is_at_rest() {
    let (plan, constants) = (plan(1), constants(0.0, 1));
    let reason = |velocity_rad_s: f32| {
        let (mut shaft, mut sums) = (Shaft::new(plan, &constants), ShaftSums::new(plan, &constants));
        let mut state = 3_u32;
        for k in 0..4000_u16 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Noise of a third of the sign's velocity, as training chooses it, beside a slow motion.
            let noise = f32::from((state >> 16) as i16) / 32_768.0 * 0.58;
            let w = velocity_rad_s * libm::sinf(0.004 * f32::from(k)) + noise;
            let values = vec![0.1 * libm::sinf(0.009 * f32::from(k)), w, 0.01];
            shaft.step(&mut sums, plan, &constants, (&RunTimeSample { values, ..RunTimeSample::default() }, true));
        }
        let (mut solve, mut estimate) = (ShaftSolve::new(), ShaftEstimate::empty(plan));
        while !solve.advance(plan, &constants, &mut sums, &mut estimate) {}
        estimate.friction_reason
    };
    assert_eq!([0.0, 0.2].map(reason), [Some(Reason::AtRest); 2]);
    assert_ne!(reason(1.0), Some(Reason::AtRest));
}

#[test]
fn after_a_gap_filters_start_anew() {
    for decimation in [1, 2] {
        let whole = friction(0.0, 0.0, decimation, |_| true).unwrap();
        let gap = friction(0.0, 0.0, decimation, |k| !(2000..2010).contains(&k)).unwrap();
        // Ten samples, the ring and the settling are withheld, a row every fourth sample.
        let missing = (10 + u32::from(FILLING * decimation) + 51) / 4;
        assert!((missing - 1..=missing + 1).contains(&(whole.rows - gap.rows)), "{} {}", whole.rows, gap.rows);
        assert!((gap.drag.value / whole.drag.value - 1.0).abs() < 2e-3, "{gap:?}");
    }
}

#[test]
fn nothing_sampled_is_a_reason() {
    let reason = friction(0.0, 0.0, 1, |_| false);
    assert_eq!(reason, Err(Reason::ShortSegment { rows: 0 }));
}

#[test]
fn a_turn_within_lost_samples_is_counted() {
    let mut shaft = Shaft::new(plan(1), &constants(0.0, 1));
    shaft.lost = 5;
    // 300 rad/s for six samples of 2 ms: 3.6 rad, more than half a turn.
    for (velocity_rad_s, held) in [(300.0, 290.0), (-300.0, -290.0), (40.0, 60.0)] {
        let torques = Torques { velocity_rad_s: held, ..Torques::default() };
        let last = Moment { torques, angle: Angle::ZERO };
        let turns = f64::from(velocity_rad_s) * 0.012 / core::f64::consts::TAU;
        let angle = Angle::from_bits((((turns - turns.round()) * 4_294_967_296.0) as i32).cast_unsigned());
        // Single precision of a turn.
        assert!((shaft.mean_velocity_rad_s(0.002, angle, &last) / velocity_rad_s - 1.0).abs() < 1e-5, "{held}");
    }
}

#[test]
fn eight_lost_samples_in_a_row_are_bridged_and_nine_are_not() {
    let (plan, constants) = (plan(1), constants(0.0, 1));
    let (mut shaft, mut sums) = (Shaft::new(plan, &constants), ShaftSums::new(plan, &constants));
    let sample = RunTimeSample { values: vec![1.0, 20.0, 0.1], ..RunTimeSample::default() };
    for _ in 0..20 {
        shaft.step(&mut sums, plan, &constants, (&sample, true));
    }
    for lost in 1..=9 {
        assert_eq!(shaft.filling, 0, "{lost}");
        shaft.lose(false);
    }
    assert_eq!((shaft.filling, BRIDGE), (FILLING, 8), "all filters start anew");
}

#[test]
fn a_renewed_shaft_is_a_new_one() {
    [1, 2].into_iter().for_each(renewed_is_new);
}

fn renewed_is_new(decimation: u8) {
    let layout = plan(decimation).layout();
    let shaft = layout.shaft.map(|shaft| ShaftLayout { orders: 1, harmonics: 3, ..shaft });
    let plan = RunTime::of(Layout { shaft, ..layout }).unwrap();
    let mut constants = constants(1.5, decimation);
    constants.tracking.orders = vec![TrackedOrder::new(3.7, [1.0; 3])];
    let signal = |k: u32| {
        let t = f64::from(k) * 0.001;
        let values = [(3.0 * t).sin(), 30.0 * (4.0 * t).sin(), 0.1 * (9.0 * t).sin()].map(|x| x as f32).to_vec();
        RunTimeSample { values, angle: Angle::from_radians((7.5 * (1.0 - (4.0 * t).cos())) as f32) }
    };
    // The first eight after the renewal are lost, too.
    let good = |k: u32| k % 535 > 7;
    let start = || (Shaft::new(plan, &constants), ShaftSums::new(plan, &constants));
    let step = |(shaft, sums): &mut (Shaft<RunTime>, ShaftSums<RunTime>), k| {
        shaft.step(sums, plan, &constants, (&signal(k), good(k)));
    };
    let mut renewed = start();
    (0..3210).for_each(|k| step(&mut renewed, k));
    renewed.0.renew(&constants);
    renewed.1.clear(plan, &constants);
    let mut new = start();
    for k in 3210..9000 {
        step(&mut renewed, k);
        step(&mut new, k);
    }
    assert_eq!(renewed.1, new.1);
}

#[test]
fn no_order_contains_what_replaces_a_lost_sample() {
    for (at, lag, whole) in [(500, 0.0, 0), (501, 0.0, 0), (500, 4.6, 4), (501, 5.0, 5)] {
        let layout = plan(2).layout();
        let shaft = layout.shaft.map(|shaft| ShaftLayout { orders: 1, harmonics: 3, ..shaft });
        let plan = RunTime::of(Layout { shaft, ..layout }).unwrap();
        let mut constants = constants(lag, 2);
        constants.tracking.orders = vec![TrackedOrder::new(3.7, [1.0; 3])];
        // The balance's filters remember the sample, the nominal parameters do not.
        constants.balance.adapt_after_rows = u16::MAX;
        let sums = |held: f32| {
            let (mut shaft, mut sums) = (Shaft::new(plan, &constants), ShaftSums::new(plan, &constants));
            for k in 0..600_u32 {
                let t = k as f32 * 0.001;
                let values = vec![(3.0 * t).sin(), 30.0, 0.1];
                let sample = RunTimeSample { values, angle: Angle::from_radians(30.0 * t) };
                shaft.step(&mut sums, plan, &constants, (&sample, k != at));
                if k == at {
                    let index = usize::from(shaft.index);
                    for cell in [index, index + usize::from(FILTERED_RING)] {
                        if let Some(moment) = shaft.ring.cells_mut().get_mut(cell) {
                            moment.torques.current_a += held;
                        }
                    }
                }
            }
            sums
        };
        let (same, other) = (sums(0.0), sums(7.0));
        assert_eq!(same.orders, other.orders, "{at} {lag}");
        // From the lost sample on a step reads it for 8 samples and the lag, and the next one its residual.
        let missing = 300 - u32::from(FILLING) - 1 - same.usage.used;
        let expected = (8 + whole + 2) / 2;
        assert!((expected..=expected + 1).contains(&missing), "{at} {lag}: {missing}");
    }
}

/// 1/8 turn, a block of the travel, is 40 samples of 1 ms at 20 rad/s.
#[test]
fn no_block_of_the_motion_goes_on_over_a_lost_sample() {
    let (plan, constants) = (plan(1), constants(0.0, 1));
    let ratio = |every: u32, lost: u32| {
        let (mut shaft, mut sums) = (Shaft::new(plan, &constants), ShaftSums::new(plan, &constants));
        for k in 0..4000_u32 {
            let angle = Angle::from_radians(0.02 * k as f32);
            let sample = RunTimeSample { values: vec![1.0, 20.0, 0.1], angle };
            shaft.step(&mut sums, plan, &constants, (&sample, k % every >= lost));
        }
        sums.travel.ratio(0.001)
    };
    assert_eq!([ratio(38, 1), ratio(38, 8), ratio(55, 10)], [None; 3]);
    assert!((ratio(90, 10).unwrap() - 1.0).abs() < 1e-3);
}

/// Steps that are counted in 200 samples of a motion by sample, of which the 100th may be lost, and steps of the shaft
/// that are left out.
fn steps(current_a: f32, lost: bool, angle_rad: impl Fn(u32) -> f32) -> (u32, u32) {
    let (plan, mut constants) = (plan(1), constants(0.0, 1));
    constants.balance.largest_change_rad = 0.016;
    let (mut shaft, mut sums) = (Shaft::new(plan, &constants), ShaftSums::new(plan, &constants));
    for k in 0..200 {
        let sample = RunTimeSample { values: vec![current_a, 20.0, 0.1], angle: Angle::from_radians(angle_rad(k)) };
        shaft.step(&mut sums, plan, &constants, (&sample, !lost || k != 100));
    }
    (sums.steps(), sums.usage.seen - sums.usage.used)
}

#[test]
fn only_a_change_of_the_motion_that_no_motor_makes_is_a_step() {
    let steady = |k: u32| 0.02 * k as f32;
    let jump = |k: u32| steady(k) + if k < 100 { 0.0 } else { 0.5 };
    let faster = |by: f32| move |k: u32| steady(k) + by * k.saturating_sub(100) as f32;
    let (none, left_out) = steps(1.0, false, steady);
    let of_one = (1, left_out + 3);
    assert_eq!((none, steps(1.0, false, jump)), (0, of_one));
    // A motion that stays is one of the shaft.
    assert_eq!([steps(1.0, false, faster(0.015)), steps(1.0, false, faster(0.2))], [(0, left_out), of_one]);
    // Twice i T²/J: 0.03 rad of 75 A.
    assert_eq!([steps(76.0, false, faster(0.03)), steps(74.0, false, faster(0.03))], [(0, left_out), of_one]);
    // Behind a lost sample the motion is that of two.
    assert_eq!(steps(1.0, true, steady), (0, left_out + 3));
}
