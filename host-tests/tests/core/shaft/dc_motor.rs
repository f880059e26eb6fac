//! The standard rig: its traces as a drive has them, and models that watch its shaft.

use bearing_watch::model::{
    Blocks, Feature, Lags, ShaftConstants, StateVariable, TERMS, TorqueBalance, TrackedOrder, Tracking, q16,
};
use bearing_watch::plan::{Array, Cells, Layout, Load, Plan, RunTime, RunTimeSample, ShaftLayout, Signal};
use bearing_watch::shaft::{Friction, LoadTerms, Parameter};
use bearing_watch::{Angle, Detector, FrictionTerm, Model, Report};
use host_tests::plans::constants;
use rig::{BearingGeometry, Defect, DefectKind, RigTrace, Scenario, simulate};

/// Healthy standard rig: J/Kt, B/Kt, Tc/Kt, 1/Kt, offset, load friction, Stribeck friction.
pub const NOMINAL: [f32; TERMS] = [5e-3, 2e-3, 0.0, 20.0, 0.0, 0.0, 0.0];
/// Largest plausible current, velocity, reference and load.
pub const LIMITS: [f32; 4] = [100.0, 400.0, 400.0, 5.0];

/// What a drive samples of the shaft.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    pub current_a: f32,
    pub velocity_rad_s: f32,
    pub reference_rad_s: f32,
    pub load_nm: f32,
    pub angle: Angle,
}

impl Motion {
    /// Current, velocity and load, as far as the plan has channels.
    pub fn sample(&self, channels: usize) -> RunTimeSample {
        let mut values = vec![self.current_a, self.velocity_rad_s, self.load_nm];
        values.truncate(channels);
        RunTimeSample { values, angle: self.angle }
    }
}

/// Only the current lags.
pub fn lag(current: f32) -> Lags {
    Lags { current, ..Lags::default() }
}

/// Constants of a shaft. Its first orders, up to the number in the plan: outer and inner ring with three harmonics, the
/// shaft's own, which does not slip.
pub fn shaft<P: Plan>(plan: P, lags: Lags) -> ShaftConstants<P> {
    let orders = BearingGeometry::THESIS.orders();
    let inner = -orders.outer / orders.inner;
    let all =
        [(orders.outer, [1.0, 0.4, 0.2], 1.0), (orders.inner, [1.0, 0.4, 0.2], inner), (1.0, [1.0, 0.0, 0.0], 0.0)];
    let order = |k: usize| {
        let (order, weights, ratio) = all[k];
        TrackedOrder { slip_ratio: ratio as f32, ..TrackedOrder::new(order as f32, weights) }
    };
    ShaftConstants {
        lags,
        balance: TorqueBalance {
            interval_s: 0.002,
            filter: StateVariable::new((std::f64::consts::PI * 8.0 * 0.002).tan() as f32, 0.002),
            row_interval: 8,
            settle: 100,
            sign_velocity_rad_s: 2.0,
            stribeck_velocity_rad_s: 6.0,
            usual_velocity_rad_s: 28.0,
            usual_load_nm: 0.1,
            // 1/(2.22 · 8 Hz · 16 ms).
            row_spread: 3.5,
            scale: [0.015_625, 0.031_25, 1.0, 8.0, 1.0, 8.0, 2.0, 0.25],
            nominal: NOMINAL,
            prior: [5e-3, 0.02, 0.5, 20.0, 0.5, 5.0, 0.5],
            deviation: 0.1,
            adapt_after_rows: 48,
            // 10 A accelerate by 2000 rad/s²: twice 8 mrad in 2 ms.
            largest_change_rad: 0.016,
        },
        tracking: Tracking {
            orders: Array::<P::Orders, TrackedOrder>::from_fn(plan.layout().orders(), order),
            blocks: Blocks {
                controls: [1.45, 2.55, 6.45, 14.5].map(q16),
                cell_turns_log2: 0,
                slip: 0.022,
                slowest_rad_s: 2.4,
                pole: 0.85,
                high_pass: 0.02,
            },
        },
    }
}

/// A model that watches the shaft alone, with or without a measured load; segments of the given length.
pub fn model(lags: Lags, load: bool, segment_samples: u32) -> Model<RunTime> {
    let [current, velocity, _, limit] = LIMITS;
    let all = [(true, current), (true, velocity), (load, limit)];
    let limits: Vec<f32> = all.into_iter().filter_map(|(measured, limit)| measured.then_some(limit)).collect();
    let signal = Signal::channel;
    of_signals([signal(0).into(), signal(1).into(), load.then(|| signal(2))], &limits, lags, segment_samples)
}

/// The same of a current and a load with the velocity of the angle.
pub fn model_of_angle(lags: Lags, segment_samples: u32) -> Model<RunTime> {
    let [current, _, _, load] = LIMITS;
    of_signals([Some(Signal::channel(0)), None, Some(Signal::channel(1))], &[current, load], lags, segment_samples)
}

/// A model of current, velocity and load, as far as there are channels.
fn of_signals(signals: [Option<Signal>; 3], limits: &[f32], lags: Lags, segment_samples: u32) -> Model<RunTime> {
    let [current, velocity, load] = signals;
    let current = current.expect("a current");
    let watched = ShaftLayout { current, velocity, load: Load::of(load), orders: 3, harmonics: 3, decimation: 1 };
    let channels = limits.len() as u8;
    let layout = Layout { channels, shaft: Some(watched), features: 1, coordinates: 1, classes: 1, ..Layout::EMPTY };
    let plan = RunTime::of(layout).expect("a plan");
    let mut shaft = shaft(plan, lags);
    if load.is_none() {
        shaft.balance.nominal[3] = 0.0;
    }
    let features = [Feature::Friction(FrictionTerm::Drag)];
    Model::new(plan, constants(plan, segment_samples, limits, &features, Some(&shaft))).expect("a good model")
}

/// The same model with a step at each second sample, and the same rates of filter and rows.
pub fn halved(model: &Model<RunTime>) -> Model<RunTime> {
    let layout = model.plan().layout();
    let shaft = layout.shaft.map(|shaft| ShaftLayout { decimation: 2, ..shaft });
    let plan = RunTime::of(Layout { shaft, ..layout }).expect("a plan");
    let mut constants = model.constants().clone();
    for ShaftConstants { balance, .. } in &mut constants.shaft {
        let cutoff_hz = f64::from(balance.filter.gain).atan() / (std::f64::consts::PI * f64::from(balance.interval_s));
        balance.interval_s *= 2.0;
        let half = std::f64::consts::PI * cutoff_hz * f64::from(balance.interval_s);
        balance.filter = StateVariable::new(half.tan() as f32, balance.interval_s);
        (balance.row_interval, balance.settle) = (balance.row_interval / 2, balance.settle / 2);
    }
    Model::new(plan, constants).expect("a good model")
}

/// The standard rig with a defect of full size.
pub fn trace(kind: DefectKind, seed: u64) -> RigTrace {
    simulate(&Scenario::STANDARD.with_defect(Defect::full(kind)), seed).expect("simulates")
}

/// The trace as a drive has it, its angle to so many bits.
pub fn motions(trace: &RigTrace, bits: u32) -> Vec<Motion> {
    let turn = f64::from(bits).exp2();
    let angle = |rad: f64| Angle::from_counts((rad / std::f64::consts::TAU * turn).floor() as i64 as u32, bits);
    (0..trace.t_s.len())
        .map(|k| Motion {
            current_a: trace.current_a[k] as f32,
            velocity_rad_s: trace.velocity_rad_s[k] as f32,
            reference_rad_s: trace.velocity_ref_rad_s[k] as f32,
            load_nm: trace.load_torque_nm[k] as f32,
            angle: angle(trace.angle_rad[k]),
        })
        .collect()
}

/// What all samples together give.
pub fn run(model: &Model<RunTime>, motions: &[Motion]) -> Report<RunTime> {
    let mut detector = Detector::new(model);
    let channels = model.constants().channels.len();
    let differenced = model.plan().layout().shaft.is_some_and(|shaft| shaft.velocity.is_none());
    let sample = |motion: &Motion| match motion {
        Motion { current_a, load_nm, angle, .. } if differenced => {
            RunTimeSample { values: vec![*current_a, *load_nm], angle: *angle }
        }
        _ => motion.sample(channels),
    };
    assert!(motions.iter().all(|motion| detector.step(&sample(motion)).is_none()), "longer than a segment");
    detector.finish()
}

/// The parameters that the plan estimates, p₀ … p₇, and the amplitude of a weight.
pub fn parameters(friction: &Friction) -> Vec<Parameter> {
    let weight = match friction.load {
        LoadTerms::Weight(weight) => Some(weight),
        LoadTerms::Unknown | LoadTerms::Measured { .. } => None,
    };
    FrictionTerm::ALL.into_iter().filter_map(|term| friction.parameter(term)).chain(weight).collect()
}
