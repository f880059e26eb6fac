//! The most instructions of each call for any data, one JSON object a line: run it by `cargo xtask measure`.
//!
//! A seeded search over recipes of damage ([`support::damage`]): every second one is random, every other one is the
//! worst so far of one of the calls with a few other pieces. Segments are short, so that a stream of some hundred
//! samples closes several of them, with handovers, at any state of the data. `trial` is the number of the stream that
//! was found worst.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use core::hint::black_box;

use bearing_watch::drive::{By, Factor, FrontEnd, RawSample};
use bearing_watch::plan::{Cells, Plan, Signals};
use bearing_watch::{Angle, Detector, Exchange, Model, Monitor, Segment};

use support::count::Counter;
use support::damage::{CHANNELS, Damage, Dice, Recipe};
use support::raw::{CONSTANTS, Motor, Sensors};
use support::raw_damage::RawDamage;
use support::{refined, shaft, squares};

/// Samples of the good stream, which repeats.
const GOOD: u32 = 400;
/// Streams of a search.
const TRIALS: u32 = 400;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask measure");
        return;
    };
    let counter = &mut counter;
    let mut plant = refined::Plant::new(5);
    let samples: [refined::Sample; GOOD as usize] = core::array::from_fn(|_| plant.sample());
    detector(counter, "SRIV detector", 8, &refined::MODEL, &samples);
    let samples = samples.map(|refined::Sample { y, u1, u2 }| squares::Sample { y, u1, u2 });
    detector(counter, "LS detector", 8, &squares::MODEL, &samples);
    let mut plant = shaft::Plant::new(6);
    let motions: [shaft::Motion; GOOD as usize] = core::array::from_fn(|_| plant.motion());
    let name = "LS and shaft, 4 orders of 3 harmonics";
    detector(counter, name, 4, &shaft::MODEL, &motions.map(shaft::Sample::from));
    let name = "shaft alone, 2 orders of 3 harmonics";
    detector(counter, name, 2, &shaft::CHOSEN, &motions.map(shaft::ChosenSample::from));
    front_end::<2, 8>(counter, Sensors::Resolver, "resolver, 3 currents, 2 further");
    front_end::<0, 8>(counter, Sensors::Converter, "converter, 2 currents");
    front_end::<0, 10>(counter, Sensors::Converter, "converter, 2 currents");
}

/// The most instructions of one kind of calls.
#[derive(Clone, Copy, Debug)]
struct Worst {
    instructions: u32,
    trial: u32,
    recipe: Recipe,
}

impl Worst {
    const NONE: Self = Self { instructions: 0, trial: 0, recipe: Recipe::GOOD };
}

/// The largest counts of each kind of calls over all recipes; `run` returns those of one.
fn search<const KINDS: usize>(mut run: impl FnMut(&Recipe) -> [u32; KINDS]) -> [Worst; KINDS] {
    let mut worst = [Worst::NONE; KINDS];
    let mut dice = Dice(1);
    for trial in 0..TRIALS {
        let parent = worst.get(trial as usize / 2 % KINDS).filter(|_| !trial.is_multiple_of(2));
        let recipe = match parent {
            Some(parent) => parent.recipe.changed(&mut dice),
            None => Recipe::random(&mut dice),
        };
        for (worst, instructions) in worst.iter_mut().zip(run(&recipe)) {
            if instructions > worst.instructions {
                *worst = Worst { instructions, trial, recipe };
            }
        }
    }
    worst
}

/// Calls of a detector whose instructions are counted.
const CALLS: [&str; 6] =
    ["collect, longest sample", "collect, sample that closes", "conclude", "longest step", "adopt", "discard"];

fn detector<P: Plan>(counter: &mut Counter, name: &str, n: usize, model: &Model<P>, good: &[P::Sample]) {
    let Some(model) = shortened(model) else { return say!("{name}: no model with short segments") };
    let model = &model;
    let worst = search(|recipe| stream(counter, model, good, recipe));
    for (call, Worst { instructions, trial, .. }) in CALLS.into_iter().zip(worst) {
        line(format_args!("{name}, {call}"), n, instructions, trial);
    }
}

/// The model with segments of few samples. What a sample does is that of the model.
fn shortened<P: Plan>(model: &Model<P>) -> Option<Model<P>> {
    let mut constants = model.constants().clone();
    // A shaft needs some turns.
    constants.sampling.segment_samples = if constants.shaft.part().is_some() { GOOD } else { GOOD / 4 };
    if let Some(regression) = constants.regression.part_mut() {
        (regression.settle, regression.handover) = (8, 8);
    }
    if let Some(shaft) = constants.shaft.part_mut() {
        (shaft.balance.settle, shaft.balance.adapt_after_rows) = (16, 4);
    }
    Model::new(model.plan(), constants).ok()
}

/// Runs a stream; returns the most instructions of each of [`CALLS`].
fn stream<P: Plan>(counter: &mut Counter, model: &Model<P>, good: &[P::Sample], recipe: &Recipe) -> [u32; CALLS.len()] {
    let [mut sample_most, mut close_most, mut conclude_most, mut step_most, mut adopt_most, mut discard_most] =
        [0; CALLS.len()];
    let limits: [f32; CHANNELS] =
        core::array::from_fn(|k| model.constants().channels.cells().get(k).map_or(0.0, |channel| channel.limit));
    let mut damage = Damage::new(recipe);
    let mut choices = Dice(recipe.seed() ^ 0x5555_5555);
    let [mut one, mut other] = [(); 2].map(|()| Segment::new(model));
    let (mut detector, mut spare) = (Detector::with_place(model, &mut one), Some(&mut other));
    if choices.below(4) != 0 {
        // With filters and lags filled, at the start of a segment.
        good.iter().for_each(|sample| {
            if let Exchange::Closed(place) = detector.exchange(sample, &mut spare) {
                place.clone_from(&Segment::new(model));
                spare = Some(place);
            }
        });
    }
    let mut monitor = Monitor::new(model);
    // The report of the last segment, and the number of samples until it is handed over.
    let mut late = None;
    let mut next = good.iter().cycle().skip(choices.below(GOOD) as usize);
    while let Some(kind) = damage.next() {
        let Some(sample) = next.next() else { break };
        let mut values: [f32; CHANNELS] = core::array::from_fn(|k| sample.value(k));
        let mut angle: Angle = sample.angle();
        damage.spoil(kind, &limits, &mut values, &mut angle);
        let sample = P::Sample::of(&values, angle);
        let mut closed = Exchange::Open;
        let one = counter.instructions_per_call(1, |_| {
            closed = black_box(&mut detector).exchange(black_box(&sample), black_box(&mut spare));
        });
        if matches!(closed, Exchange::Closed(_)) {
            close_most = one.max(close_most);
        } else {
            sample_most = one.max(sample_most);
        }
        if let Exchange::Closed(place) = closed {
            if choices.below(3) > 0 {
                let whole = counter.instructions_once(|| {
                    black_box(&mut monitor).take_from(black_box(place));
                    black_box(black_box(&mut monitor).complete().is_some());
                });
                conclude_most = whole.max(conclude_most);
            } else {
                monitor.take_from(place);
                while monitor.is_solving() {
                    let step = counter.instructions_once(|| {
                        black_box(black_box(&mut monitor).advance().is_some());
                    });
                    step_most = step.max(step_most);
                }
            }
            spare = Some(place);
            late = monitor.report().map(|report| (report.clone(), choices.below(12)));
        }
        match &mut late {
            Some((report, 0)) => {
                let adopt = counter.instructions_per_call(1, |_| {
                    black_box(black_box(&mut detector).adopt(black_box(report)));
                });
                adopt_most = adopt.max(adopt_most);
                late = None;
            }
            Some((_, left)) => *left -= 1,
            None => {}
        }
        if choices.below(256) == 0 {
            let discard = counter.instructions_per_call(1, |_| {
                black_box(&mut detector).discard();
            });
            discard_most = discard.max(discard_most);
        }
    }
    [sample_most, close_most, conclude_most, step_most, adopt_most, discard_most]
}

fn front_end<const FURTHER: usize, const FACTOR: usize>(counter: &mut Counter, sensors: Sensors, name: &str)
where
    By<FACTOR>: Factor,
{
    let Ok(fresh) = FrontEnd::<FURTHER, FACTOR>::new(black_box(&CONSTANTS)) else { return };
    let mut motor = Motor::<FURTHER>::new(sensors);
    let good: [RawSample<FURTHER>; GOOD as usize] = core::array::from_fn(|_| motor.sample());
    // In lock, and with filters filled.
    let mut locked = fresh.clone();
    good.iter().for_each(|sample| {
        black_box(locked.push(sample));
    });
    let worst = search(|recipe| {
        let mut damage = RawDamage::new(recipe);
        let mut front_end = if recipe.seed().is_multiple_of(4) { fresh.clone() } else { locked.clone() };
        let (mut most, mut number) = (0, GOOD);
        for sample in good.iter().cycle() {
            let Some(sample) = damage.spoil(RawSample { number, ..*sample }) else { break };
            number = number.wrapping_add(1);
            let one = counter.instructions_per_call(1, |_| {
                black_box(black_box(&mut front_end).push(black_box(&sample)));
            });
            most = one.max(most);
        }
        [most]
    });
    for Worst { instructions, trial, .. } in worst {
        line(format_args!("front end, {name}, worst sample"), FACTOR, instructions, trial);
    }
}

fn line(name: core::fmt::Arguments<'_>, n: usize, instructions: u32, trial: u32) {
    say!(r#"{{"name":"{name}, any data","n":{n},"instructions":{instructions},"bytes":null,"trial":{trial}}}"#);
}
