//! Both rigs as drives: phase currents and angle, with a fault, pass a front end, and models judge the samples.

use bearing_watch::drive::{
    BalanceLimits, By, Factor, Faults, FrontEnd, FrontEndConstants, PhaseCounts, PhaseSensor, Position, RawSample,
    TrackingConstants,
};
use bearing_watch::model::{Feature, Lags, TorqueBalance};
use bearing_watch::plan::{Layout, Load, Plan, RunTime, RunTimeSample, ShaftLayout, Signal};
use bearing_watch::shaft::Friction;
use bearing_watch::{Angle, Detector, FrictionTerm, Model, Reason, Verdict};
use host_tests::plans::constants;
use rig::DefectKind;
use rig::ema::{EmaDefect, EmaScenario, Logging, Race};

use super::electronics::actuator;
use crate::shaft::dc_motor;

/// What the converters see at one instant of the control loop.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    phases_a: [f64; 3],
    pub turns: f64,
    load_nm: f64,
}

/// Passes readings with a fault through a front end.
pub type Watch = fn(&FrontEndConstants, &[Reading], &Fault<'_>) -> (Vec<Clean>, Faults);

/// A rig with the electronics in front of it.
pub struct Drive {
    pub name: &'static str,
    pub constants: FrontEndConstants,
    pub base: TorqueBalance,
    pub lags: Lags,
    pub record: fn(DefectKind, u64) -> Vec<Reading>,
    pub watch: Watch,
}

/// Current, velocity, load and angle; `late` says that what was before is not to be used.
#[derive(Clone, Copy, Debug)]
pub struct Clean {
    pub values: [f32; 3],
    pub angle: Angle,
    pub late: bool,
}

/// Changes a row and its counts of the angle, of 14 bits.
pub type Fault<'a> = dyn Fn(usize, &mut [f64; 3], &mut u32) + 'a;

impl Clean {
    pub fn is_missing(&self) -> bool {
        self.values.iter().any(|x| x.is_nan())
    }
}

pub const KINDS: [DefectKind; 2] = [DefectKind::Healthy, DefectKind::Spall];
pub const COUNTS: f64 = 16_384.0;
/// More samples than a record has.
const LONG: u32 = 60_000;
/// 16 bits, 2 mA.
const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 32_768.0, gain_a: 0.002, usable: [100, 65_000] };

pub fn front_end(control_rate_hz: f32, bandwidth_hz: f32, noise_a: f32) -> FrontEndConstants {
    FrontEndConstants {
        control_rate_hz,
        sensors: [SENSOR; 3],
        balance: BalanceLimits { noise_a, offset_a: 2.0 * noise_a, gain_tolerance: 0.02, window: 128 },
        tracking: TrackingConstants { bandwidth_hz, ..actuator::FRONT_END.tracking },
        ..actuator::FRONT_END
    }
}

/// The actuator at 10 kHz between springs, two and a half seconds.
fn actuator_record(kind: DefectKind, seed: u64) -> Vec<Reading> {
    let defect = EmaDefect::of(kind, 1.0, Race::Inner);
    readings(&EmaScenario { rows: 25_000, defect, ..EmaScenario::RIT }, seed)
}

fn readings(scenario: &EmaScenario, seed: u64) -> Vec<Reading> {
    let trace = rig::ema::simulate(scenario, seed).expect("simulates");
    let row = |k: usize| Reading {
        phases_a: [trace.phase_a_a[k], trace.phase_b_a[k], trace.phase_c_a[k]],
        turns: trace.angle_rad[k] / std::f64::consts::TAU,
        load_nm: trace.load_torque_nm[k],
    };
    (0..trace.len()).map(row).collect()
}

/// The actuator at 12 kHz under a load sine, which separates inertia and torque constant.
pub fn loaded_record(kind: DefectKind, seed: u64) -> Vec<Reading> {
    let defect = EmaDefect::of(kind, 1.0, Race::Inner);
    let logging = Logging { every: 1, hold: 1 };
    readings(&EmaScenario { rows: 31_200, defect, logging, ..EmaScenario::STANDARD }, seed)
}

/// The DC-motor rig at 500 Hz as a drive of three phases and two pole pairs, ten seconds.
fn dc_motor_record(kind: DefectKind, seed: u64) -> Vec<Reading> {
    let trace = dc_motor::trace(kind, seed);
    let row = |k: usize| {
        let electrical = 2.0 * trace.angle_rad[k];
        let phase = |third: f64| -trace.current_a[k] * (electrical - third * std::f64::consts::TAU / 3.0).sin();
        Reading {
            phases_a: [0.0, 1.0, 2.0].map(phase),
            turns: trace.angle_rad[k] / std::f64::consts::TAU,
            load_nm: trace.load_torque_nm[k],
        }
    };
    (0..trace.t_s.len()).map(row).collect()
}

pub fn drives() -> [Drive; 2] {
    let shaft = &actuator::MODEL.constants().shaft[0];
    let dc_plan = dc_motor::model(dc_motor::lag(0.7), true, 5000);
    let mut dc_front_end = front_end(500.0, 50.0, 0.3);
    dc_front_end.frame.pole_pairs = 2;
    [
        Drive {
            name: "actuator",
            constants: front_end(10_000.0, 300.0, 0.45),
            base: shaft.balance,
            lags: shaft.lags,
            record: actuator_record,
            watch: watch::<10>,
        },
        Drive {
            name: "DC motor",
            constants: dc_front_end,
            base: dc_plan.constants().shaft[0].balance,
            lags: dc_motor::lag(0.7),
            record: dc_motor_record,
            watch: watch::<1>,
        },
    ]
}

pub fn watch<const FACTOR: usize>(
    constants: &FrontEndConstants,
    rows: &[Reading],
    fault: &Fault<'_>,
) -> (Vec<Clean>, Faults)
where
    By<FACTOR>: Factor,
{
    let mut front_end = FrontEnd::<1, FACTOR>::new(constants).expect("good constants");
    let mut clean = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let (mut phases, mut counts) = (row.phases_a, (row.turns.rem_euclid(1.0) * COUNTS) as u32);
        fault(k, &mut phases, &mut counts);
        let raw = RawSample {
            number: k as u32,
            currents: PhaseCounts::Three(phases.map(|a| (32_768.0 + a / 0.002).round() as u16)),
            position: Position::Absolute(Angle::from_counts(counts, 14)),
            further: [row.load_nm as f32],
        };
        let sample = front_end.push(&raw).map(|own| Clean {
            values: [own.current_a, own.velocity_rad_s, own.further[0]],
            angle: own.angle,
            late: own.found_late,
        });
        clean.extend(sample);
    }
    (clean, front_end.faults())
}

/// A model of the balance with these constants, of one class: every segment that can be judged is healthy.
pub fn model(balance: TorqueBalance, lags: Lags, load: bool, segment: u32) -> Model<RunTime> {
    let signal = Signal::channel;
    let watched = ShaftLayout {
        load: Load::of(load.then(|| signal(2))),
        velocity: Some(signal(1)),
        ..dc_motor::model(lags, true, 5000).plan().layout().shaft.expect("a shaft")
    };
    let channels = 2 + u8::from(load);
    let layout = Layout { channels, shaft: Some(watched), features: 1, coordinates: 1, classes: 1, ..Layout::EMPTY };
    let plan = RunTime::of(layout).expect("a plan");
    let mut shaft = dc_motor::shaft(plan, lags);
    shaft.balance = balance;
    let features = [Feature::Friction(FrictionTerm::Drag)];
    let mut trained = constants(plan, segment, &[1e3, 1e4, 1e3][..channels as usize], &features, Some(&shaft));
    trained.sampling.interval_s = balance.interval_s;
    Model::new(plan, trained).expect("a good model")
}

/// The verdict of a record and its estimates.
pub fn judge(model: &Model<RunTime>, samples: &[Clean]) -> (Verdict, Friction, Vec<f32>) {
    let mut detector = Detector::new(model);
    let channels = model.constants().channels.len();
    for sample in samples {
        if sample.late {
            detector.discard();
        }
        let sample = RunTimeSample { values: sample.values[..channels].to_vec(), angle: sample.angle };
        assert!(detector.step(&sample).is_none(), "longer than a segment");
    }
    // A record of samples that are missing is shorter than half a segment, but not half of this record.
    let used = samples.iter().filter(|sample| sample.values.iter().all(|x| x.is_finite())).count();
    let report = detector.finish();
    let shaft = report.shaft().expect("watched");
    let orders = shaft.orders().iter().map(|order| order.amplitude).collect();
    let verdict = if 2 * used < samples.len() { Verdict::Undetermined(Reason::AtRest) } else { report.verdict };
    (verdict, shaft.friction, orders)
}

impl Drive {
    pub fn clean(&self, kind: DefectKind, seed: u64, fault: &Fault<'_>) -> (Vec<Clean>, Faults) {
        (self.watch)(&self.constants, &(self.record)(kind, seed), fault)
    }

    /// A model whose healthy values are those of a few healthy records.
    pub fn trained(&self, load: bool) -> Model<RunTime> {
        let weak = TorqueBalance {
            nominal: [0.0; 7],
            prior: [0.1, 0.1, 5.0, 100.0, 5.0, 5.0, 5.0],
            adapt_after_rows: u16::MAX,
            ..self.base
        };
        let untrained = model(weak, self.lags, load, LONG);
        let frictions: Vec<Friction> =
            (0..6).map(|k| judge(&untrained, &self.clean(DefectKind::Healthy, 100 + k, &|_, _, _| ()).0).1).collect();
        let spread = |of: &dyn Fn(&Friction) -> f32| {
            let mean = frictions.iter().map(of).sum::<f32>() / frictions.len() as f32;
            let square = frictions.iter().map(|own| (of(own) - mean).powi(2)).sum::<f32>() / frictions.len() as f32;
            (mean, square.sqrt())
        };
        let mut balance = weak;
        for (k, term) in FrictionTerm::ALL.into_iter().take(7).enumerate() {
            let (mean, deviation) = spread(&|own| own.parameter(term).map_or(0.0, |parameter| parameter.value));
            balance.nominal[k] = mean;
            balance.prior[k] = (3.0 * deviation).max(0.02 * mean.abs()).max(1e-6);
        }
        balance.deviation = spread(&|own| own.variance).0.sqrt();
        model(balance, self.lags, load, LONG)
    }

    /// Verdict and faults of healthy and spalled records, with and without a load.
    pub fn all(&self, fault: &Fault<'_>, mut check: impl FnMut(&str, Verdict, &Faults)) {
        for load in [true, false] {
            let model = self.trained(load);
            for kind in KINDS {
                let (samples, faults) = self.clean(kind, 7, fault);
                let name = format!("{}, load {load}, {kind:?}", self.name);
                check(&name, judge(&model, &samples).0, &faults);
            }
        }
    }
}
