//! Faults of the electronics that leave signals plausible, on both rigs, healthy and with a spall, with and without a
//! load sensor: none of them leaves a verdict without a flag. The table of the book names these tests.

use std::fs;
use std::path::Path;

use bearing_watch::drive::{
    Alignment, BalanceLimits, By, Factor, Faults, FrontEnd, FrontEndConstants, Imbalance, PhaseCounts, PhaseSensor,
    Position, RawSample, TrackingConstants,
};
use bearing_watch::model::{Balance, Feature, Lags};
use bearing_watch::plan::{Layout, Plan, RunTime, RunTimeSample, ShaftLayout, Signal};
use bearing_watch::shaft::Friction;
use bearing_watch::{Angle, Detector, FrictionTerm, Implausible, Model, Monitor, RateCheck, Reason, Verdict};
use host_tests::plans::constants;
use rig::DefectKind;
use rig::ema::{EmaDefect, EmaScenario, Logging, Race};

use super::drive_faults::{actuator, scattered};
use super::rig as dc_motor;

/// What the converters see at one instant of the control loop.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    phases_a: [f64; 3],
    turns: f64,
    load_nm: f64,
}

/// Passes readings with a fault through a front end.
type Watch = fn(&FrontEndConstants, &[Reading], &Fault<'_>) -> (Vec<Clean>, Faults);

/// A rig with the electronics in front of it.
pub struct Drive {
    name: &'static str,
    constants: FrontEndConstants,
    base: Balance,
    lags: Lags,
    record: fn(DefectKind, u64) -> Vec<Reading>,
    watch: Watch,
}

/// Current, velocity, load and angle; `late` says that what was before is not to be used.
#[derive(Clone, Copy, Debug)]
pub struct Clean {
    values: [f32; 3],
    angle: Angle,
    late: bool,
}

/// Changes a row and its counts of the angle, of 14 bits.
pub type Fault<'a> = dyn Fn(usize, &mut [f64; 3], &mut u32) + 'a;

impl Clean {
    pub fn is_missing(&self) -> bool {
        self.values.iter().any(|x| x.is_nan())
    }
}

const KINDS: [DefectKind; 2] = [DefectKind::Healthy, DefectKind::Spall];
const COUNTS: f64 = 16_384.0;
/// More samples than a record has.
const LONG: u32 = 60_000;
/// 1/64 turn.
const SLIP: u32 = 256;
/// 16 bits, 2 mA.
const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 32_768.0, gain_a: 0.002, usable: [100, 65_000] };

fn front_end(control_rate_hz: f32, bandwidth_hz: f32, noise_a: f32) -> FrontEndConstants {
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
fn loaded_record(kind: DefectKind, seed: u64) -> Vec<Reading> {
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

fn watch<const FACTOR: usize>(
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
fn model(balance: Balance, lags: Lags, load: bool, segment: u32) -> Model<RunTime> {
    let signal = Signal::channel;
    let watched = ShaftLayout {
        load: load.then(|| signal(2)),
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
fn judge(model: &Model<RunTime>, samples: &[Clean]) -> (Verdict, Friction, Vec<f32>) {
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
    fn trained(&self, load: bool) -> Model<RunTime> {
        let weak = Balance {
            nominal: [0.0; 7],
            prior: [0.1, 0.1, 5.0, 100.0, 5.0, 5.0, 5.0],
            own_from_rows: u16::MAX,
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
    fn all(&self, fault: &Fault<'_>, mut check: impl FnMut(&str, Verdict, &Faults)) {
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

#[test]
fn without_a_fault_there_is_a_verdict_and_no_flag() {
    for drive in drives() {
        drive.all(&|_, _, _| (), |name, verdict, faults| {
            assert_eq!(verdict, Verdict::Class(0), "{name}");
            assert!(
                faults.is_clear() && faults.alignment == Alignment::Aligned && faults.offsets_a == [0.0; 3],
                "{name}: {faults:?}"
            );
        });
    }
}

#[test]
fn exchanged_phases_and_a_reversed_angle_have_no_verdict() {
    let faults: [(&str, &Fault<'_>); 2] = [
        ("phases exchanged", &|_, phases, _| phases.swap(1, 2)),
        ("angle reversed", &|_, _, counts| *counts = (16_384 - *counts) % 16_384),
    ];
    for drive in drives() {
        for (fault, inject) in faults {
            drive.all(inject, |name, verdict, faults| {
                assert_eq!(faults.imbalance, Some(Imbalance::Misaligned), "{fault}, {name}");
                assert!(matches!(verdict, Verdict::Undetermined(_)), "{fault}, {name}: {verdict:?}");
                assert!(faults.alignment == Alignment::Misaligned && !faults.is_clear(), "{fault}, {name}");
            });
        }
    }
}

/// The drive's own transform: its currents have the opposite sign, or velocity and angle have.
#[test]
fn a_sign_without_a_load_is_found_where_the_motion_explains_the_current() {
    for drive in drives() {
        let model = drive.trained(false);
        for kind in KINDS {
            let (mut samples, _) = drive.clean(kind, 7, &|_, _, _| ());
            let right = judge(&model, &samples);
            for sample in &mut samples {
                sample.values[0] = -sample.values[0];
            }
            let (verdict, _, orders) = judge(&model, &samples);
            println!("{}, {kind:?}: {verdict:?}, orders {:?} {orders:?}", drive.name, right.2);
            let refused = verdict == Verdict::Undetermined(Reason::Implausible(Implausible::Sign));
            // The load of the DC motor is most of its current; the bearing orders do not depend on the sign.
            assert!(refused || drive.name == "DC motor", "{}, {kind:?}: {verdict:?}", drive.name);
            for (own, other) in right.2.iter().zip(&orders).filter(|_| !refused) {
                assert!((own - other).abs() < 0.15 * own.abs() + 0.01, "{}: {own} {other}", drive.name);
            }
        }
    }
}

#[test]
fn an_offset_is_removed_and_beyond_its_limit_refused() {
    for drive in drives() {
        drive.all(&|_, phases, _| phases[0] += 0.5, |name, verdict, faults| {
            println!("{name}: {:?}", faults.offsets_a);
            assert_eq!((verdict, faults.imbalance), (Verdict::Class(0), None), "{name}");
            let [a, b, c] = faults.offsets_a;
            // Down to 0.2 σ and three deviations of the last windows, and with the rig's own offsets of 0.1 A.
            assert!((0.2..0.6).contains(&a) && b.abs() < 0.15 && c.abs() < 0.15, "{name}: {:?}", faults.offsets_a);
        });
        drive.all(&|_, phases, _| phases[0] += 2.0, |name, verdict, faults| {
            assert!(matches!(faults.imbalance, Some(Imbalance::Offset { .. })), "{name}: {faults:?}");
            assert!(matches!(verdict, Verdict::Undetermined(_)), "{name}: {verdict:?}");
        });
    }
}

#[test]
fn slips_of_the_angle_are_counted() {
    for drive in drives() {
        for slips in [1, 20] {
            let every = 8_000 / slips;
            let inject = |k: usize, _: &mut [f64; 3], counts: &mut u32| {
                let done = (k / every.min(200)).min(slips) as u32 * u32::from(k >= 200);
                *counts = (*counts + done * SLIP) % 16_384;
            };
            drive.all(&inject, |name, _, faults| {
                // A step during the search for the angle, or while the shaft is at rest and turns back, may pass.
                let least = (slips as u32).saturating_sub(4).max(1);
                assert!(faults.position.slipped + faults.position.strayed >= least, "{name}, {slips}: {faults:?}");
                assert!(!faults.is_clear(), "{name}");
            });
        }
    }
}

#[test]
fn stale_angles_are_missing_and_counted() {
    for drive in drives() {
        for length in [1, 3, 10] {
            let rows = (drive.record)(DefectKind::Healthy, 7);
            let inject = |k: usize, _: &mut [f64; 3], counts: &mut u32| {
                if k > 100 && k % 100 < length {
                    *counts = (rows[k - k % 100 - 1].turns.rem_euclid(1.0) * COUNTS) as u32;
                }
            };
            let (samples, faults) = drive.clean(DefectKind::Healthy, 7, &inject);
            println!("{}, {length}: {:?}", drive.name, faults.position);
            assert!(faults.position.stale > 10 && !faults.is_clear(), "{}, {length}", drive.name);
            for load in [true, false] {
                let (verdict, ..) = judge(&drive.trained(load), &samples);
                assert!(!matches!(verdict, Verdict::Novel | Verdict::Ambiguous), "{}: {verdict:?}", drive.name);
            }
        }
    }
}

/// Instants of the angle that scatter by up to 0.6 of an interval about those of the currents.
#[test]
fn angles_at_unequal_times_are_counted() {
    let [drive, _] = drives();
    for kind in KINDS {
        let rows = (drive.record)(kind, 7);
        let inject = |k: usize, _: &mut [f64; 3], counts: &mut u32| {
            if k > 0 && k + 1 < rows.len() {
                let late = 0.6 * (f64::from(scattered(k as u32)) / 2_147_483_648.0 - 1.0);
                let turns = rows[k].turns + 0.5 * late * (rows[k + 1].turns - rows[k - 1].turns);
                *counts = (turns.rem_euclid(1.0) * COUNTS) as u32;
            }
        };
        let (_, faults) = drive.clean(kind, 7, &inject);
        println!("{kind:?}: {:?}", faults.position);
        assert!(faults.position.unsteady_windows > 5 && !faults.is_clear(), "{kind:?}: {faults:?}");
    }
}

/// All gains, or the scale of the load, changed by a fifth: neither a verdict nor a defect, whatever the bearing is.
#[test]
fn gains_and_loads_that_are_wrong_by_a_fifth_are_named() {
    let [springs, dc_motor] = drives();
    let loaded = Drive {
        name: "actuator under a load sine",
        constants: front_end(12_000.0, 300.0, 0.45),
        record: loaded_record,
        watch: watch::<12>,
        ..springs
    };
    for drive in [loaded, dc_motor] {
        let model = drive.trained(true);
        for kind in KINDS {
            let (samples, _) = drive.clean(kind, 7, &|_, _, _| ());
            for [current, load] in [[1.2, 1.0], [0.8, 1.0], [1.0, 1.2], [1.0, 0.8]] {
                let scale = |own: &Clean| {
                    let [i, w, t] = own.values;
                    Clean { values: [i * current, w, t * load], ..*own }
                };
                let scaled: Vec<Clean> = samples.iter().map(scale).collect();
                let (verdict, friction, _) = judge(&model, &scaled);
                println!(
                    "{}, {kind:?}, {current} {load}: {verdict:?} {:?}",
                    drive.name, friction.inverse_torque_constant
                );
                let named = verdict == Verdict::Undetermined(Reason::Implausible(Implausible::TorqueConstant));
                assert!(named, "{}, {kind:?}, {current} {load}: {verdict:?}", drive.name);
            }
        }
    }
}

/// Every row twice: the velocity, which is of the same rows, agrees with the angle. A clock does not.
#[test]
fn rows_that_come_twice_are_found_by_a_clock() {
    for drive in drives() {
        for load in [true, false] {
            let balance = drive.trained(load).constants().shaft[0].balance;
            for kind in KINDS {
                let (samples, _) = drive.clean(kind, 7, &|_, _, _| ());
                let model = model(balance, drive.lags, load, samples.len() as u32);
                let channels = model.constants().channels.len();
                let rows_hz = 1.0 / drive.base.interval_s;
                let verdict_of = |times: usize| {
                    let mut rate = RateCheck::new(rows_hz, 1000.0, 0.02, 2000);
                    let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
                    let (mut rows, mut last) = (0_u32, None);
                    for (k, sample) in samples.iter().enumerate() {
                        let now = (k as f32 * 1000.0 / rows_hz) as u32;
                        if let Some(right) = rate.push(rows, now) {
                            monitor.refuse((!right).then_some(Implausible::Rate));
                        }
                        for _ in 0..times {
                            let values = sample.values[..channels].to_vec();
                            let sample = RunTimeSample { values, angle: sample.angle };
                            last = monitor.step(&mut detector, &sample).map(|now| now.report.verdict).or(last);
                            rows += 1;
                        }
                    }
                    last
                };
                assert_eq!(verdict_of(1), Some(Verdict::Class(0)), "{}, load {load}, {kind:?}", drive.name);
                let refused = Verdict::Undetermined(Reason::Implausible(Implausible::Rate));
                assert_eq!(verdict_of(2), Some(refused), "{}, load {load}, {kind:?}", drive.name);
            }
        }
    }
}

#[test]
fn every_row_of_the_book_names_a_requirement_or_a_limit() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("../book/src/faults.md")).expect("the page");
    // Generated tables are compared with the test that prints them.
    let by_hand = page.split("## What a segment says").next().unwrap_or_default();
    let rows: Vec<&str> =
        by_hand.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| fault ")).collect();
    assert!(rows.len() >= 15, "{}", rows.len());
    for row in rows {
        let cell = row.trim_end_matches(" |").rsplit(" | ").next().unwrap_or_default();
        // `cargo xtask trace` looks the requirements up.
        assert!(cell.contains("REQ-") || cell.contains("*limit*"), "{row}");
    }
}
