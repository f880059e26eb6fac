//! Models that watch the shaft and its bearing, and a motion for them.

use bearing_watch::model::{
    Blocks, Channel, Constants, EvidenceConstants, Feature, Lags, Regression, Sampling, ShaftConstants, StateVariable,
    TERMS, TorqueBalance, TrackedOrder, Tracking, q16,
};
use bearing_watch::plan::{Kind, Layout, Load, Memory, Method, RegressionLayout, ShaftLayout};
use bearing_watch::{Angle, FrictionTerm, Model};

use super::classifier::classifier;
use super::law::LAW;
use super::numbers::Numbers;
use super::refined::{FORGETTING, LABELS, STRUCTURE};

bearing_watch::plan! {
    /// Eight parameters by least squares, friction, and four bearing orders of three harmonics.
    pub struct Watched;
    /// One sample of the drive.
    pub struct Sample with angle {
        current_a: "A", velocity_ref_rad_s: "rad/s", load_nm: "N·m", velocity_rad_s: "rad/s",
    }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: STRUCTURE,
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y: current_a,
            u1: velocity_ref_rad_s,
            u2: load_nm,
        }),
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Measured(load_nm),
            orders: 4,
            harmonics: 3,
            decimation: 2,
        }),
        features: 9,
        coordinates: 3,
        rising: 1,
        classes: 3,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    }
}

bearing_watch::plan! {
    /// What `train` chooses for a drive with a load sensor: friction, and the orders of both races; no regression.
    pub struct Chosen;
    /// One sample of the drive.
    pub struct ChosenSample with angle {
        current_a: "A", velocity_rad_s: "rad/s", load_nm: "N·m",
    }
    layout: Layout {
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Measured(load_nm),
            orders: 2,
            harmonics: 3,
            decimation: 2,
        }),
        features: 9,
        coordinates: 3,
        rising: 1,
        classes: 3,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    }
}

bearing_watch::plan! {
    /// One bearing order of one harmonic, and friction without a measured load; no regression.
    pub struct Loadless;
    /// One sample of the drive.
    pub struct LoadlessSample with angle {
        current_a: "A", velocity_rad_s: "rad/s",
    }
    layout: Layout {
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Unknown,
            orders: 1,
            harmonics: 1,
            decimation: 1,
        }),
        features: 9,
        coordinates: 3,
        rising: 1,
        classes: 3,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    }
}

bearing_watch::plan! {
    /// The same with a weight on an axis, of one turn in 50 of the motor, whose payload changes at rests.
    pub struct Weighing;
    /// One sample of the drive.
    pub struct WeighingSample with angle {
        current_a: "A", velocity_rad_s: "rad/s",
    }
    layout: Layout {
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Weight { axis_q32: 85_899_346, changes: true },
            orders: 1,
            harmonics: 1,
            decimation: 1,
        }),
        features: 9,
        coordinates: 3,
        rising: 1,
        classes: 3,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    }
}

const INTERVAL_S: f32 = 0.002;

/// p₀ … p₆ of the healthy shaft; load friction and Stribeck friction are zero.
const NOMINAL: [f32; TERMS] = [5e-3, 2e-3, 0.1, 20.0, 0.05, 0.0, 0.0];

const CURRENT: Channel = Channel::within("current_a", "A", 100.0);
const REFERENCE: Channel = Channel::within("velocity_ref_rad_s", "rad/s", 500.0);
const LOAD: Channel = Channel::within("load_nm", "N·m", 2.0);
const VELOCITY: Channel = Channel::within("velocity_rad_s", "rad/s", 500.0);

const SAMPLING: Sampling = Sampling { interval_s: INTERVAL_S, park: None, block_mean: 1, segment_samples: 2000 };

/// The torque balance.
pub const BALANCE: TorqueBalance = TorqueBalance {
    interval_s: INTERVAL_S,
    // 8 Hz.
    filter: StateVariable::new(0.050_307, INTERVAL_S),
    row_interval: 8,
    settle: 100,
    sign_velocity_rad_s: 2.0,
    stribeck_velocity_rad_s: 6.0,
    usual_velocity_rad_s: 28.0,
    usual_load_nm: 0.1,
    // 1/(2.22 · 8 Hz · 16 ms).
    row_spread: 3.5,
    scale: [0.007_812_5, 0.031_25, 1.0, 8.0, 1.0, 8.0, 2.0, 0.5],
    nominal: NOMINAL,
    prior: [5e-3, 0.02, 1.0, 20.0, 1.0, 10.0, 1.0],
    deviation: 0.1,
    adapt_after_rows: 48,
    largest_change_rad: f32::INFINITY,
};

/// The torque balance of each second sample, with a filter of 4 Hz and the same steps from row to row.
pub const HALVED: TorqueBalance =
    TorqueBalance { interval_s: 2.0 * INTERVAL_S, filter: StateVariable::new(0.050_307, 2.0 * INTERVAL_S), ..BALANCE };

/// The orders of outer ring, inner ring, ball and cage, all harmonics with the same weight.
pub const ORDERS: [TrackedOrder; 4] = [
    TrackedOrder::new(3.717_94, [1.0; 3]),
    TrackedOrder { slip_ratio: -3.717_94 / 5.282_06, ..TrackedOrder::new(5.282_06, [1.0; 3]) },
    TrackedOrder::new(2.747_73, [1.0; 3]),
    TrackedOrder::new(0.413_1, [1.0; 3]),
];

const RACES: [TrackedOrder; 2] = {
    let [outer, inner, ..] = ORDERS;
    [outer, inner]
};

/// Cells of half a turn: the motion turns to and fro by two turns.
pub const BLOCKS: Blocks = Blocks {
    controls: [q16(2.37), q16(3.33), q16(4.55), q16(6.45)],
    cell_turns_log2: -1,
    slip: 0.008,
    slowest_rad_s: 2.4,
    pole: 0.9,
    high_pass: 0.0,
};

/// The model of a drive with a load sensor.
pub static MODEL: Model<Watched> = match Watched::model(Constants {
    sampling: SAMPLING,
    channels: [CURRENT, REFERENCE, LOAD, VELOCITY],
    regression: [Regression {
        scale: [1.0, 2.0, 0.031_25, 0.5, 0.5, 4.0, 4.0, 4.0, 2.0],
        nominal: [-0.5, 0.2, 0.01, 0.1, 0.0, 10.0, 0.0, 0.0],
        forgetting: FORGETTING,
        rest: 1e-6,
        settle: 100,
        handover: 0,
    }],
    shaft: [ShaftConstants {
        lags: Lags { current: 0.7, velocity: 0.0, load: 0.0 },
        balance: HALVED,
        tracking: Tracking { orders: ORDERS, blocks: BLOCKS },
    }],
    classifier: classifier!(
        [
            Feature::Parameter(0),
            Feature::Parameter(1),
            Feature::Parameter(2),
            Feature::Friction(FrictionTerm::Viscous),
            Feature::FrictionScore(FrictionTerm::Drag),
            Feature::LogFrictionVariance,
            Feature::OrderScore(0),
            Feature::OrderScore(1),
            Feature::LogOrderAmplitude(0),
        ],
        Some(0),
        LAW,
        [LAW; 2]
    ),
    evidence: EvidenceConstants::NONE,
    labels: LABELS,
}) {
    Ok(model) => model,
    Err(error) => panic!("{}", error.message()),
};

/// The model of a plan without a regression: channels, constants of the shaft, and the last feature.
macro_rules! shaft_alone {
    ($plan:ident, $channels:expr, $shaft:expr, $last:expr) => {
        match $plan::model(Constants {
            sampling: SAMPLING,
            channels: $channels,
            regression: [],
            shaft: [$shaft],
            classifier: classifier!(
                [
                    Feature::Friction(FrictionTerm::Inertia),
                    Feature::Friction(FrictionTerm::Viscous),
                    Feature::Friction(FrictionTerm::Coulomb),
                    Feature::FrictionScore(FrictionTerm::Viscous),
                    Feature::FrictionScore(FrictionTerm::Offset),
                    Feature::FrictionScore(FrictionTerm::Drag),
                    Feature::LogFrictionVariance,
                    Feature::OrderScore(0),
                    $last,
                ],
                Some(0),
                LAW,
                [LAW; 2]
            ),
            evidence: EvidenceConstants::NONE,
            labels: LABELS,
        }) {
            Ok(model) => model,
            Err(error) => panic!("{}", error.message()),
        }
    };
}

/// The model of a drive with a load sensor, as `train` writes it.
pub static CHOSEN: Model<Chosen> = shaft_alone!(
    Chosen,
    [CURRENT, VELOCITY, LOAD],
    ShaftConstants {
        lags: Lags { current: 0.7, velocity: 0.0, load: 0.0 },
        balance: HALVED,
        tracking: Tracking { orders: RACES, blocks: BLOCKS },
    },
    Feature::OrderScore(1)
);

/// The model of a drive without a load sensor.
pub static LOADLESS: Model<Loadless> = shaft_alone!(
    Loadless,
    [CURRENT, VELOCITY],
    ShaftConstants {
        lags: Lags { current: 0.0, velocity: 0.0, load: 0.0 },
        balance: BALANCE,
        tracking: Tracking { orders: [TrackedOrder::new(3.717_94, [1.0, 0.0, 0.0])], blocks: BLOCKS },
    },
    Feature::LogOrderAmplitude(0)
);

/// The model of a drive that moves a weight.
pub static WEIGHING: Model<Weighing> = shaft_alone!(
    Weighing,
    [CURRENT, VELOCITY],
    ShaftConstants {
        lags: Lags { current: 0.0, velocity: 0.0, load: 0.0 },
        balance: TorqueBalance { adapt_after_rows: 8, ..BALANCE },
        tracking: Tracking { orders: [TrackedOrder::new(3.717_94, [1.0, 0.0, 0.0])], blocks: BLOCKS },
    },
    Feature::LogOrderAmplitude(0)
);

/// The motion at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    pub current_a: f32,
    pub velocity_rad_s: f32,
    pub reference_rad_s: f32,
    pub load_nm: f32,
    pub angle: Angle,
}

impl From<Motion> for Sample {
    fn from(motion: Motion) -> Self {
        let Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle } = motion;
        Self { current_a, velocity_ref_rad_s: reference_rad_s, load_nm, velocity_rad_s, angle }
    }
}

impl From<Motion> for ChosenSample {
    fn from(motion: Motion) -> Self {
        let Motion { current_a, velocity_rad_s, load_nm, angle, .. } = motion;
        Self { current_a, velocity_rad_s, load_nm, angle }
    }
}

impl From<Motion> for LoadlessSample {
    fn from(motion: Motion) -> Self {
        let Motion { current_a, velocity_rad_s, load_nm, angle, .. } = motion;
        let [_, _, _, load, ..] = NOMINAL;
        Self { current_a: current_a - load * load_nm, velocity_rad_s, angle }
    }
}

impl From<Motion> for WeighingSample {
    fn from(motion: Motion) -> Self {
        let Motion { current_a, velocity_rad_s, load_nm, angle, .. } = motion;
        let [_, _, _, load, ..] = NOMINAL;
        Self { current_a: current_a - load * load_nm, velocity_rad_s, angle }
    }
}

/// Turns to and fro by 40 rad/s against a load, the bearing dragging at its outer ring; one sample in 701 is lost.
pub struct Plant {
    numbers: Numbers,
    /// Phases of reference and load, and the angle of the shaft, as binary fractions of a turn.
    reference: Angle,
    load: Angle,
    shaft: Angle,
    /// Turns times the order of the outer ring, and the state of the current's lag.
    drag: f32,
    last_current_a: f32,
    last_velocity_rad_s: f32,
    time: u32,
}

impl Plant {
    /// At rest.
    #[must_use]
    pub const fn new(seed: u32) -> Self {
        Self {
            numbers: Numbers(seed),
            reference: Angle::ZERO,
            load: Angle::ZERO,
            shaft: Angle::ZERO,
            drag: 0.0,
            last_current_a: 0.0,
            last_velocity_rad_s: 0.0,
            time: 0,
        }
    }

    /// The next sample.
    pub fn motion(&mut self) -> Motion {
        // 0.9 and 1.7 Hz.
        self.reference = self.reference.plus(Angle::from_bits(7_730_941));
        self.load = self.load.plus(Angle::from_bits(14_602_888));
        let smooth_rad_s = 40.0 * self.reference.sin_cos().sin;
        let [noise, fluctuation, current_noise, jitter] = self.numbers.array();
        let velocity_rad_s = smooth_rad_s + 0.5 * noise;
        // A sine alone does not excite three lags.
        let reference_rad_s = smooth_rad_s + jitter;
        let load_nm = 0.15 * self.load.sin_cos().sin + 0.06 * fluctuation;
        let turned = Angle::from_radians(velocity_rad_s * INTERVAL_S);
        self.shaft = self.shaft.plus(turned);
        self.drag += 3.717_94 * velocity_rad_s * INTERVAL_S;
        let sign = (velocity_rad_s / 2.0).clamp(-1.0, 1.0);
        let [inertia, viscous, coulomb, load, offset, ..] = NOMINAL;
        let slope = (velocity_rad_s - self.last_velocity_rad_s) / INTERVAL_S;
        self.last_velocity_rad_s = velocity_rad_s;
        let drag = 0.3 * sign * Angle::from_radians(self.drag).sin_cos().cos;
        let torque = inertia * slope + viscous * velocity_rad_s + coulomb * sign + load * load_nm + offset + drag;
        let current_a = 0.7 * self.last_current_a + 0.3 * torque + 0.1 * current_noise;
        self.last_current_a = torque;
        self.time = self.time.wrapping_add(1);
        let current_a = if self.time.is_multiple_of(701) { f32::NAN } else { current_a };
        Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle: self.shaft }
    }
}
