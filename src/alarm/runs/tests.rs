use super::scores::normal_score;
use super::*;
use crate::alarm::evidence::{Alarm, Cause, Evidence, EvidenceConstants};
use crate::decide::{Decision, Fall};
use crate::plan::{Layout, Memory, Method, RunTime, Structure, testing};
use std::vec;
use std::vec::Vec;

mod promises;

const LIMIT: f32 = 9.0;
/// 0.62 (9 − ln 4).
const CAP: f32 = 4.7205;
const RUN: u32 = 4;

fn plan(directions: u8) -> RunTime {
    let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
    RunTime::of(Layout { classes: 1, directions, ..plain }).unwrap()
}

/// Drives differ by 1, runs by 1/2, segments of a run by 1.
const DIRECTION: Direction = Direction { between: 1.0, run: 0.25, segment: 1.0, ..Direction::UNIT };

fn evidence_of(list: Vec<Direction>, margin: f32, segments_a_run: u32) -> Evidence<RunTime> {
    let plan = plan(u8::try_from(list.len()).unwrap());
    let constants = EvidenceConstants { limit: LIMIT, cap: CAP, segments_a_run, ..EvidenceConstants::NONE };
    let directions = Directions { list, usual_segments: RUN as f32, margin, most_runs: 60 };
    Evidence::empty(plan, constants, &directions, Some(0))
}

fn decision(values: &[f32]) -> Decision<RunTime> {
    let directed = values.iter().map(|value| FeatureValue { value: *value, variance: 0.0 }).collect();
    Decision { directed, ..Decision::empty(plan(u8::try_from(values.len()).unwrap())) }
}

/// Takes a run of equal segments.
fn run(evidence: &mut Evidence<RunTime>, values: &[f32]) -> Option<Alarm> {
    (0..RUN).for_each(|_| {
        evidence.observe(Some(&decision(values)));
    });
    evidence.end_run()
}

/// (2) … (6) of a run of n₀ segments: s² = 1/4 + 1/4, so a = δ, and t = (x − r)/√½.
#[test]
fn scores_by_hand() {
    let mut evidence = evidence_of(vec![DIRECTION], 0.0, 100);
    assert_eq!(run(&mut evidence, &[1.0]), None);
    // t = √2: 1.414214 − 1/2, 2.828427 − 2 and 5.656854 − 8; ln 4 = 1.386294 stands for the segments so far.
    assert!((evidence.score() - (1.386_294 + 0.914_214)).abs() < 1e-5, "{}", evidence.score());
    let main = evidence.contribution(0).unwrap();
    assert!((main.deviations - 2.0_f32.sqrt()).abs() < 1e-5 && main.since == 0, "{main:?}");
    // û = (1/½)/(1 + 1/½) = 2/3, and the next run adds to the score of the last.
    run(&mut evidence, &[1.0]);
    let t = (1.0 - 2.0 / 3.0) * 2.0_f32.sqrt();
    assert!((evidence.score() - (1.386_294 + 0.914_214 + t - 0.5)).abs() < 1e-5, "{}", evidence.score());
    assert_eq!(evidence.learned_runs(), 2);
}

#[test]
fn one_wild_run_raises_no_alarm_and_two_do() {
    for wild in [6.0, 1e3, 1e18, f32::MAX] {
        let mut evidence = evidence_of(vec![DIRECTION, Direction { coordinate: 1, ..DIRECTION }], 1.645, 100);
        run(&mut evidence, &[0.0, 0.0]);
        assert_eq!(run(&mut evidence, &[0.0, wild]), None, "{wild}");
        assert!(evidence.score() < LIMIT - 1.0);
        let alarm = Some(Alarm { segment: 3 * RUN, cause: Cause::Coordinate(1) });
        assert_eq!(run(&mut evidence, &[0.0, wild]), alarm, "{wild}");
        let main = evidence.main_contribution().unwrap();
        assert!(main.direction == 1 && main.since == RUN && main.deviations > 5.0, "{main:?}");
        assert_eq!(evidence.learned_runs(), 1, "a defect is not learned");
    }
}

#[test]
fn of_directions_at_the_cap_the_alarm_names_the_one_that_has_risen_most() {
    for (values, expected) in [([9.0, 12.0], 1), ([12.0, 9.0], 0)] {
        let mut evidence = evidence_of(vec![DIRECTION, Direction { coordinate: 1, ..DIRECTION }], 1.645, 100);
        run(&mut evidence, &values);
        let alarm = Alarm { segment: 2 * RUN, cause: Cause::Coordinate(expected) };
        assert_eq!(run(&mut evidence, &values), Some(alarm));
    }
}

/// A spall raises drag as well, but drag raises no order.
#[test]
fn an_order_that_has_risen_is_named_before_friction() {
    let order = Direction { coordinate: 1, order: true, ..DIRECTION };
    for (order_value, expected) in [(9.0, 1), (3.0, 1), (0.0, 0)] {
        let mut evidence = evidence_of(vec![DIRECTION, order], 1.645, 100);
        let alarm = (0..2).find_map(|_| run(&mut evidence, &[12.0, order_value]));
        assert_eq!(alarm, Some(Alarm { segment: 2 * RUN, cause: Cause::Coordinate(expected) }), "{order_value}");
        // (3 − 1.645)/√½: twice 2.33 nats, and ln 4 at first. Its own score is told.
        let main = evidence.main_contribution().unwrap();
        assert!(main.direction == expected && (main.score < LIMIT) == (order_value == 3.0), "{main:?}");
    }
}

#[test]
fn a_long_run_speaks_before_it_ends() {
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 1000);
    run(&mut evidence, &[5.0]);
    let alarm = (0..100).find_map(|_| evidence.observe(Some(&decision(&[5.0]))));
    assert_eq!(alarm, Some(Alarm { segment: 2 * RUN, cause: Cause::Coordinate(0) }));
    // But no run alone.
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 1000);
    assert!((0..900).all(|_| evidence.observe(Some(&decision(&[50.0]))).is_none()));
}

#[test]
fn falls_of_two_runs_raise_an_alarm_of_their_own() {
    let fallen = |surprise: f32| Decision { fall: Fall { surprise, coordinate: 3 }, ..decision(&[0.0]) };
    let of_run = |evidence: &mut Evidence<RunTime>, surprise: f32| {
        for _ in 0..RUN {
            evidence.observe(Some(&fallen(surprise)));
        }
        evidence.end_run().map(|alarm| alarm.cause)
    };
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
    let causes = [0.0, 30.0, 30.0].map(|surprise| of_run(&mut evidence, surprise));
    assert_eq!(causes, [None, None, Some(Cause::Fallen(3))]);
    assert_eq!(evidence.main_contribution(), None);
    // A run between them without a fall starts afresh, and a fall as rare as one in twenty is none.
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
    assert_eq!([30.0, 0.0, 30.0, 0.0].map(|surprise| of_run(&mut evidence, surprise)), [None; 4]);
    assert_eq!((0..100).find_map(|_| of_run(&mut evidence, 0.5)), None);
}

#[test]
fn falling_and_missing_values_add_nothing() {
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
    for value in [-30.0, f32::MIN] {
        run(&mut evidence, &[value]);
        assert_eq!(evidence.score(), 0.0, "{value}");
    }
    let fresh = evidence_of(vec![DIRECTION], 1.645, 100);
    let mut missing = fresh.clone();
    let nothing = Decision { directed: vec![FeatureValue::MISSING], ..decision(&[0.0]) };
    (0..RUN).for_each(|_| {
        missing.observe(Some(&nothing));
    });
    missing.end_run();
    assert_eq!((missing.score(), missing.contribution(0)), (0.0, fresh.contribution(0)));
}

#[test]
fn a_defect_that_is_denied_again_and_again_is_alarmed_again_and_again() {
    let mut evidence = evidence_of(vec![DIRECTION, Direction { coordinate: 1, ..DIRECTION }], 1.645, 100);
    assert!(!evidence.deny(), "nothing to deny");
    (0..60).for_each(|_| {
        run(&mut evidence, &[0.0, 0.0]);
    });
    // The drive is known; the offset of a run has a deviation of ½, and this is eight of them.
    let mut alarms = vec![];
    for k in 1..=200_u32 {
        if run(&mut evidence, &[0.0, 4.0]).is_some() {
            alarms.push(k);
            assert!(evidence.deny() && evidence.alarm().is_none() && evidence.score() == 0.0);
        }
    }
    let between: Vec<u32> = alarms.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(alarms[0] == 2 && between.iter().all(|runs| (2..=6).contains(runs)), "{alarms:?}");
    // What only the narrow law told is not told any more.
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
    (0..60).for_each(|_| {
        run(&mut evidence, &[0.0]);
    });
    let until = |evidence: &mut Evidence<RunTime>, most: u32| (1..=most).find(|_| run(evidence, &[1.2]).is_some());
    let mut denied = evidence.clone();
    // (1.2 − 1.645/√121)/√½ − ½ = 0.99 a run, of 9 − ln 4; with 2.25 B 0.67, and with 11.4 B 0.1.
    assert_eq!(until(&mut denied, 40), Some(8));
    assert!(denied.deny());
    assert_eq!(until(&mut denied, 40), Some(12));
    assert!(denied.deny() && until(&mut denied, 40).is_some() && denied.deny());
    assert_eq!(until(&mut denied, 40), None);
}

/// Takes a run of a drive whose runs have this mean, with offsets and segments as in [`DIRECTION`].
fn random_run(evidence: &mut Evidence<RunTime>, random: &mut Random, means: &[f64]) -> Option<Alarm> {
    let offsets: Vec<f64> = means.iter().map(|mean| mean + 0.5 * random.normal()).collect();
    for _ in 0..RUN {
        let values: Vec<f32> = offsets.iter().map(|offset| (offset + random.normal()) as f32).collect();
        evidence.observe(Some(&decision(&values)));
    }
    evidence.end_run()
}

/// The numbers of the runs that raise an alarm, of which each is denied.
fn denied(evidence: &mut Evidence<RunTime>, random: &mut Random, means: &[f64], runs: u32) -> Vec<u32> {
    let mut alarms = vec![];
    for k in 1..=runs {
        if random_run(evidence, random, means).is_some() {
            alarms.push(k);
            assert!(evidence.deny());
        }
    }
    alarms
}

/// Drives differ by 1. With no run learned (9) ends at 1.645 √(1 + 11.4/4 + 1/4) = 3.3.
#[test]
fn a_denied_defect_is_never_learned_on_a_drive_of_any_age() {
    for (healthy, size) in [0, 1, 3, 5, 20, 60].into_iter().flat_map(|k| [(k, 4.5), (k, 6.0), (k, 12.0)]) {
        for seed in 0..8 {
            let mut random = Random(100 * seed + healthy);
            let mut evidence = evidence_of(vec![DIRECTION, Direction { coordinate: 1, ..DIRECTION }], 1.645, 100);
            (0..healthy).for_each(|_| {
                random_run(&mut evidence, &mut random, &[0.0, 0.0]);
            });
            let alarms = denied(&mut evidence, &mut random, &[0.3 * size, size], 300);
            let thirds: Vec<usize> = [100, 200, 300]
                .iter()
                .map(|end| alarms.iter().filter(|k| (end - 99..=*end).contains(*k)).count())
                .collect();
            assert!(thirds.iter().all(|count| *count >= 5), "{healthy} runs, {size}, seed {seed}: {alarms:?}");
        }
    }
}

/// A defect that grows so slowly that no run has evidence against what was learned before it is learned up to 3.33
/// only.
#[test]
fn a_denied_defect_that_grows_slowly_is_learned_up_to_its_limit() {
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
    for _ in 0..3 {
        assert!((0..9).any(|_| run(&mut evidence, &[12.0]).is_some()) && evidence.deny());
    }
    (0..27_u8).for_each(|k| {
        run(&mut evidence, &[2.0 + 0.05 * f32::from(k)]);
    });
    // What a run deviates from the reference, which the run before it has moved if it was learned.
    let mut twice = |size: f32| {
        [size; 2].map(|size| {
            assert_eq!(run(&mut evidence, &[size]), None);
            evidence.contribution(0).unwrap().deviations
        })
    };
    let [first, second] = twice(3.32);
    assert!(second < first, "{first} {second}");
    let [first, second] = twice(3.34);
    assert!(first == second, "{first} {second}");
}

/// An offset of 2.4 is one drive in 120, and (9) lets it be learned.
#[test]
fn the_denied_alarms_of_a_sound_drive_end() {
    let mut late = 0;
    for seed in 0..50 {
        let mut random = Random(1000 + seed);
        let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
        let alarms = denied(&mut evidence, &mut random, &[2.4], 600);
        late += alarms.iter().filter(|k| **k > 100).count();
    }
    // 25 000 runs, and the set time of e⁹/3 segments is 675 runs: by the widened law fewer.
    assert!(late < 25, "{late} alarms");
}

#[test]
fn a_denial_takes_back_what_supported_the_alarm() {
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
    (0..10).for_each(|_| {
        run(&mut evidence, &[0.0]);
    });
    // (1.6 − 1.645/√21)/√½ − ½ = 1.25 a run at first: some are learned before T is half of the limit.
    assert_eq!((1..20).find(|_| run(&mut evidence, &[1.6]).is_some()), Some(8));
    let learned = evidence.learned_runs();
    assert!(learned > 11, "{learned}");
    let standing = evidence.clone();
    (0..5).for_each(|_| {
        run(&mut evidence, &[0.0]);
    });
    assert_eq!(evidence.learned_runs(), learned, "nothing is learned while an alarm stands");
    let deviations = |mut evidence: Evidence<RunTime>, denied: bool| {
        assert_eq!(denied, denied && evidence.deny());
        run(&mut evidence, &[0.0]);
        evidence.contribution(0).unwrap().deviations
    };
    assert!(deviations(standing.clone(), false) < -0.1 && deviations(standing, true) == 0.0);
}

#[test]
fn a_drive_unlike_the_fleet_is_told() {
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100);
    (0..2).for_each(|_| {
        run(&mut evidence, &[-6.0]);
    });
    assert_eq!(evidence.unlike_the_fleet(), None, "two runs");
    run(&mut evidence, &[-6.0]);
    assert_eq!(evidence.unlike_the_fleet(), Some(0));
    evidence.reset();
    assert_eq!(evidence, evidence_of(vec![DIRECTION], 1.645, 100));
}

/// Normal numbers by Box and Muller.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (core::f64::consts::TAU * self.uniform()).cos()
    }
}

/// ρ of the model and of the drive, and whether its runs are skewed.
#[derive(Clone, Copy, Default)]
struct Drawn {
    assumed: f32,
    lasting: f64,
    skewed: bool,
}

/// Segments until the alarm of a drive, whose runs from `onset` on are raised by `shift` deviations of a usual run.
fn segments(random: &mut Random, drawn: Drawn, onset: u32, shift: f64, most: u32) -> Option<u32> {
    let Drawn { assumed, lasting, skewed } = drawn;
    let mut evidence = evidence_of(vec![Direction { correlation: assumed, ..DIRECTION }; 3], 1.645, 100);
    let drive: Vec<f64> = (0..3).map(|_| random.normal()).collect();
    let mut offsets: Vec<f64> = vec![];
    for number in 0..most {
        let mut of_run = || {
            let normal = random.normal();
            // A squared normal number has the skewness √8: 0.4 in a mixture with a normal one.
            if skewed { 0.85 * normal + 0.53 * (random.normal().powi(2) - 1.0) / 2.0_f64.sqrt() } else { normal }
        };
        let raised = if number >= onset { shift * 0.5_f64.sqrt() } else { 0.0 };
        let next: Vec<f64> = (0..3).map(|_| of_run()).collect();
        offsets = match offsets.as_slice() {
            [] => next,
            last => last.iter().zip(next).map(|(b, e)| lasting * b + (1.0 - lasting * lasting).sqrt() * e).collect(),
        };
        let runs: Vec<f64> = drive.iter().zip(&offsets).map(|(u, b)| u + 0.5 * b + raised).collect();
        for _ in 0..RUN {
            let values: Vec<f32> = runs.iter().map(|b| (b + random.normal()) as f32).collect();
            evidence.observe(Some(&decision(&values)));
        }
        if let Some(alarm) = evidence.end_run() {
            return Some(alarm.segment);
        }
    }
    None
}

/// limit = ln T + ln 9: T = e⁹/9 = 900 segments. Exponential times of mean T end within 450 in 39 % of drives, and
/// the bound is far from tight: 8.5 % were found in ten times as many drives; 3 deviations of 400 drives are 4 %.
#[test]
fn the_set_time_between_false_alarms_is_kept() {
    let mut random = Random(17);
    let mut early = |drawn: Drawn| (0..400).filter(|_| segments(&mut random, drawn, 0, 0.0, 112).is_some()).count();
    for skewed in [false, true] {
        let early = early(Drawn { skewed, ..Drawn::default() });
        assert!(early < 52, "{early} of 400 drives within half of the set time");
        assert!(early > 0, "no alarm at all: the test shows nothing");
    }
    for lasting in [0.5, 0.8] {
        let of = |assumed| Drawn { assumed, lasting, skewed: false };
        let (known, unknown) = (early(of(lasting as f32)), early(of(0.0)));
        assert!(known < 52 && known > 0, "{known} of 400 drives at {lasting}");
        assert!(unknown > 65, "{unknown} of 400 drives whose lasting offsets are not known");
    }
}

/// (10) by hand: ρ = ½, B = 1/4, W/N = 1/4. The first run at 1 has the gain ½, with c = ½ and P = 1/8; so α = ¼, c = ¼
/// and P = 1/32 + 3/16 are expected of the second one, which says y = ¾ and h = ¾ with s² = 15/32.
#[test]
fn an_offset_that_lasts_is_expected() {
    let mut evidence = evidence_of(vec![Direction { correlation: 0.5, ..DIRECTION }], 0.0, 100);
    run(&mut evidence, &[1.0]);
    let first = 1.386_294 + 0.914_214;
    assert!((evidence.score() - first).abs() < 1e-5, "{}", evidence.score());
    // r = û = 2/3 as without ρ: z = ¾ (1 − 2/3)/√(15/32).
    run(&mut evidence, &[1.0]);
    let z = 0.75 / 3.0 / (15.0_f32 / 32.0).sqrt();
    assert!((evidence.score() - (first + z - 0.5)).abs() < 1e-5, "{} {}", evidence.score(), first + z - 0.5);
    // Runs without a value leave little of an offset: the second run at 1.2 then surprises as the first one did.
    let mut evidence = evidence_of(vec![Direction { correlation: 0.8, ..DIRECTION }], 0.0, 100);
    (0..10).for_each(|_| {
        run(&mut evidence, &[0.0]);
    });
    let gained = |evidence: &mut Evidence<RunTime>| {
        let before = evidence.score();
        run(evidence, &[1.2]);
        evidence.score() - before
    };
    let first = gained(&mut evidence) - 1.386_294;
    let mut rested = evidence.clone();
    let nothing = Decision { directed: vec![FeatureValue::MISSING], ..decision(&[0.0]) };
    for _ in 0..40 {
        (0..RUN).for_each(|_| {
            rested.observe(Some(&nothing));
        });
        rested.end_run();
    }
    let [at_once, later] = [&mut evidence, &mut rested].map(gained);
    assert!(first > 0.8 && (later - first).abs() < 0.1 && at_once < 0.6 * first, "{first} {later} {at_once}");
}

#[test]
fn a_change_is_found_sooner_the_larger_it_is() {
    let mut random = Random(5);
    let mut median = |shift: f64, assumed: f32| {
        let drawn = Drawn { assumed, ..Drawn::default() };
        let mut delays: Vec<u32> = (0..101)
            .filter_map(|_| segments(&mut random, drawn, 20, shift, 200))
            .map(|segment| segment.saturating_sub(20 * RUN).div_ceil(RUN))
            .collect();
        delays.sort_unstable();
        delays.get(50).copied().unwrap_or(u32::MAX)
    };
    let delays = [8.0, 4.0, 2.0].map(|shift| median(shift, 0.0));
    assert!(delays[0] == 2 && (2..=3).contains(&delays[1]) && (3..=8).contains(&delays[2]), "{delays:?}");
    // A large defect is not taken for an offset that lasts.
    assert_eq!([16.0, 8.0].map(|shift| median(shift, 0.9)), [2, 2]);
}

#[test]
fn a_skewed_law_is_made_normal() {
    assert_eq!(normal_score(3.0, 0.0), 3.0);
    // (6/½)(∛(1 + ¾) − 1) + 1/12, and the end of the law.
    assert!((normal_score(3.0, 0.5) - 2.544_19).abs() < 1e-4, "{}", normal_score(3.0, 0.5));
    assert_eq!(normal_score(-100.0, 0.5), -12.0 + 0.5 / 6.0);
}

#[test]
fn the_size_is_told_in_deviations_of_usual_runs_and_forgotten_with_a_reset() {
    let mut evidence = evidence_of(vec![DIRECTION], 1.645, 100).of_model(1, 360.0);
    assert_eq!(evidence.growth(1), None, "no such direction");
    // s₀² = 1/4 + 1/4; four deviations of U + B + W = 9/4 are plain in a segment; four segments last 0.4 h.
    let first = evidence.growth(0).unwrap();
    assert!((first.named - 6.0 * 2.0_f32.sqrt()).abs() < 1e-4 && (first.run_hours - 0.4).abs() < 1e-6, "{first:?}");
    assert_eq!(evidence.growth_to(0, 5.0).unwrap().named, 5.0);
    for step in 0..90_u8 {
        run(&mut evidence, &[0.05 * f32::from(step.saturating_sub(20)) + if step % 2 == 0 { 0.5 } else { -0.5 }]);
    }
    // 70 runs of 0.05 √2 each; two more until it is plain.
    let grown = evidence.growth_to(0, 6.0).unwrap();
    assert!(grown.size.low < 4.88 && grown.size.high > 4.0 && grown.slope.high > 0.07, "{grown:?}");
    assert!(grown.is_growing() && grown.left_hours().unwrap().low < 8.0, "{grown:?}");
    evidence.reset();
    assert_eq!(evidence.growth(0), Some(first));
}
