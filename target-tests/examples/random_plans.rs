//! Random plans on damaged streams of raw samples, from the front end to the alarm: equal lines on host and target mean
//! that every digit of every report is equal. Run by `cargo xtask test`.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(
    clippy::cast_possible_truncation,
    clippy::indexing_slicing,
    reason = "a comparison of small drawn numbers, no firmware"
)]

#[macro_use]
mod support;

#[path = "support/any_plan.rs"]
mod any_plan;

use core::fmt::{self, Write as _};

use bearing_watch::drive::{By, CleanSample, Factor, FrontEnd, RawSample};
use bearing_watch::plan::Signals;
use bearing_watch::{Angle, Detector, Exchange, Model, Monitor, Report, Segment, Verdict};

use any_plan::{AnyPlan, Values};
use support::damage::{CHANNELS, Damage, Dice, Recipe};
use support::raw::{CONSTANTS, Motor, Sensors};
use support::raw_damage::RawDamage;
use support::shaft::{Motion, Plant};

/// Plans that are drawn; those whose parts do not fit each other have no line.
const DRAWN: u32 = 100;
/// Segments of each.
const SEGMENTS: u32 = 5;
/// Streams of samples with damage between good ones, in samples.
const PERIOD: u32 = 1600;
/// Channels behind current and velocity.
const FURTHER: usize = 2;

main!(run);

fn run() {
    let mut lines = 0_u32;
    for number in 0..DRAWN {
        let mut dice = Dice(number);
        let Some(model) = any_plan::model(&mut dice) else { continue };
        lines += 1;
        match dice.below(7) {
            0 => chain::<1>(number, &model, &mut dice),
            1 => chain::<2>(number, &model, &mut dice),
            2 => chain::<8>(number, &model, &mut dice),
            3 => chain::<10>(number, &model, &mut dice),
            4 => chain::<12>(number, &model, &mut dice),
            // Samples at the rate of identification, whose motion excites everything.
            _ => plain(number, &model, &mut dice),
        }
    }
    say!("{lines} plans of {DRAWN} fit");
}

/// A hash of a text. The text of a report has all digits of its numbers, and one text for every NaN, whose bits differ
/// between processors.
struct Text(u32);

impl Text {
    fn number(&mut self, number: f32) {
        let bits = if number.is_nan() { u32::MAX } else { number.to_bits() };
        self.0 = (self.0 ^ bits).wrapping_mul(0x0100_0193);
    }
}

impl fmt::Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
        Ok(())
    }
}

/// What is behind the front end.
struct Rest<'m> {
    model: &'m Model<AnyPlan>,
    detector: Detector<'m, AnyPlan, &'m mut Segment<AnyPlan>>,
    spare: Option<&'m mut Segment<AnyPlan>>,
    monitor: Monitor<'m, AnyPlan>,
    /// The report of the last segment, and the number of samples until it is handed over.
    late: Option<(Report<AnyPlan>, u32)>,
    dice: Dice,
    text: Text,
    segments: u32,
    decided: u32,
}

impl<'m> Rest<'m> {
    fn new(model: &'m Model<AnyPlan>, [first, second]: &'m mut [Segment<AnyPlan>; 2], dice: Dice) -> Self {
        let (detector, monitor) = (Detector::with_place(model, first), Monitor::new(model));
        let spare = Some(second);
        Self { model, detector, spare, monitor, late: None, dice, text: Text(0x811c_9dc5), segments: 0, decided: 0 }
    }

    fn take(&mut self, sample: &Values) {
        match self.detector.exchange(sample, &mut self.spare) {
            Exchange::Open => {}
            Exchange::Lost => self.add(format_args!("lost")),
            Exchange::Closed(place) => self.conclude(place),
        }
        match self.late.take() {
            Some((report, 0)) => {
                let adopted = self.detector.adopt(&report);
                self.add(format_args!("{adopted}"));
            }
            Some((report, left)) => self.late = Some((report, left - 1)),
            None => {}
        }
    }

    fn conclude(&mut self, place: &'m mut Segment<AnyPlan>) {
        self.monitor.take_from(place);
        if self.dice.below(2) == 0 {
            self.monitor.complete();
        } else {
            while self.monitor.is_solving() {
                self.monitor.advance();
            }
        }
        self.spare = Some(place);
        let (alarm, score) = (self.monitor.evidence().alarm(), self.monitor.evidence().score());
        let Some(report) = self.monitor.report().cloned() else { return };
        self.segments += 1;
        self.decided += u32::from(!matches!(report.verdict, Verdict::Undetermined(_)));
        self.add(format_args!("{report:?} {alarm:?} {score:?}"));
        for direction in 0..3 {
            let evidence = self.monitor.evidence();
            let (contribution, growth) = (evidence.contribution(direction), evidence.growth_to(direction, 9.0));
            self.add(format_args!("{contribution:?} {growth:?}"));
        }
        self.late = Some((report, self.dice.below(40)));
    }

    fn add(&mut self, words: fmt::Arguments<'_>) {
        // The text takes everything.
        let _ = self.text.write_fmt(words);
    }

    fn line(&self, number: u32, factor: usize) {
        let layout = self.model.plan().layout();
        let (parameters, columns, orders) = (layout.parameters(), layout.columns(), layout.orders());
        let (watched, block) = (layout.watched(), self.model.constants().sampling.block_mean);
        let Self { segments, decided, text: Text(bits), .. } = self;
        say!(
            "plan {number:3}: {parameters:2} parameters in {columns:2} columns, shafts {watched} with {orders} orders, \
             decimated by {factor:2} and {block}; {segments} reports, {decided} decided, {bits:08x}"
        );
    }
}

/// Raw samples with damage, decimated.
fn chain<const FACTOR: usize>(number: u32, model: &Model<AnyPlan>, dice: &mut Dice)
where
    By<FACTOR>: Factor,
{
    let Ok(mut front_end) = FrontEnd::<FURTHER, FACTOR>::new(&CONSTANTS) else { return };
    let sensors = if dice.below(2) == 0 { Sensors::Resolver } else { Sensors::Converter };
    let mut motor = Motor::<FURTHER>::new(sensors);
    let mut places = [(); 2].map(|()| Segment::new(model));
    let mut rest = Rest::new(model, &mut places, *dice);
    let mut damage = RawDamage::new(&Recipe::random(dice));
    let mut count = 0_u32;
    while rest.segments < SEGMENTS {
        count += 1;
        if count.is_multiple_of(PERIOD * FACTOR as u32) {
            damage = RawDamage::new(&Recipe::random(dice));
        }
        let good = motor.sample();
        let raw: RawSample<FURTHER> = damage.spoil(good).unwrap_or(good);
        let Some(clean) = front_end.push(&raw) else { continue };
        let CleanSample { current_a, velocity_rad_s, angle, further: [load_nm, reference_rad_s], found_late, .. } =
            clean;
        rest.text.number(current_a);
        rest.text.number(velocity_rad_s);
        if found_late {
            let doubtful = rest.detector.is_in_first_half();
            rest.detector.discard();
            rest.add(format_args!("{doubtful}"));
        }
        rest.take(&Values::of(&[current_a, velocity_rad_s, load_nm, reference_rad_s], angle));
    }
    let faults = front_end.faults();
    rest.add(format_args!("{faults:?}"));
    rest.line(number, FACTOR);
}

/// Samples of a moving shaft with damage.
fn plain(number: u32, model: &Model<AnyPlan>, dice: &mut Dice) {
    const LIMITS: [f32; CHANNELS] = [100.0, 500.0, 2.0, 500.0];
    let mut plant = Plant::new(number);
    let mut places = [(); 2].map(|()| Segment::new(model));
    let mut rest = Rest::new(model, &mut places, *dice);
    let mut damage = Damage::new(&Recipe::GOOD);
    let mut count = 0_u32;
    while rest.segments < SEGMENTS {
        count += 1;
        if count.is_multiple_of(PERIOD) {
            damage = Damage::new(&Recipe::random(dice));
        }
        let Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle } = plant.motion();
        let mut values = [current_a, velocity_rad_s, load_nm, reference_rad_s];
        let mut angle: Angle = angle;
        if let Some(kind) = damage.next() {
            damage.spoil(kind, &LIMITS, &mut values, &mut angle);
        }
        rest.take(&Values::of(&values, angle));
    }
    rest.line(number, 1);
}
