//! A drive in use for a day: raw samples of healthy actuators through front end, detector, solver and alarm, with
//! faults of the electronics at random times. The usual run takes 6e6 samples; `cargo xtask long` takes 1e9, and its
//! rows are kept in docs/endurance.md.
//!
//! The records of the actuators follow each other in random order, with noise of their own, and sampling instants are
//! missed between them. A segment is *undisturbed* if neither it nor the one before it met a fault or an end of a
//! record.

use bearing_watch::drive::{FrontEnd, FrontEndConstants, Lock};
use bearing_watch::{Evidence, FrictionTerm, Monitor, Report, Verdict};
use host_tests::halves::Interrupt;

use crate::faults::electronics::actuator::{Drive, FURTHER, MODEL, Sample};
use crate::faults::electronics::{FAULTS, Inject, ROWS, Raw, ZERO, constants, counts, raw, scattered, trace};

#[path = "../../../../attack/src/finite.rs"]
mod finite;

/// Parts into which the samples are divided.
const PARTS: usize = 10;
/// Samples of the control loop a clean one, and clean ones a segment.
const FACTOR: usize = 10;
const SEGMENT: u32 = 2400;

/// Random numbers of 32 bits.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        scattered((self.0 >> 32) as u32)
    }

    fn below(&mut self, end: u32) -> u32 {
        self.roll() % end
    }
}

/// Values of load and reference that are no numbers, at an instant of seven.
fn not_finite(sample: &mut Raw, k: u32) -> bool {
    if k.is_multiple_of(7) {
        sample.further = [[f32::NAN, f32::INFINITY], [-f32::INFINITY, f32::NAN]][(k % 2) as usize];
    }
    true
}

/// A record whose currents have no offset.
fn record(seed: u64, amplitude_m: f64) -> (FrontEndConstants, Vec<Raw>) {
    let trace = trace(seed, amplitude_m);
    let mut own = constants(&trace);
    let offsets = own.sensors.map(|sensor| sensor.offset_counts - f32::from(ZERO));
    own.sensors.iter_mut().for_each(|sensor| sensor.offset_counts = f32::from(ZERO));
    let rows = (0..ROWS).map(|k| {
        let mut sample = raw(&trace, k);
        for (count, offset) in counts(&mut sample).iter_mut().zip(offsets) {
            *count = (f32::from(*count) - offset).round() as u16;
        }
        sample
    });
    (own, rows.collect())
}

/// Raw samples without end.
struct Source {
    records: Vec<Vec<Raw>>,
    dice: Dice,
    /// The record, the next row in it, and the number of the sample.
    record: usize,
    row: usize,
    number: u32,
    /// The fault, the rows since its start, and its length; and the rows until the next one.
    fault: Option<(Inject, u32, u32)>,
    until: u32,
    faults: u32,
    /// Whether a fault or the end of a record was met since this was cleared.
    disturbed: bool,
}

impl Source {
    fn next(&mut self) -> Option<Raw> {
        let dice = &mut self.dice;
        if self.row == ROWS {
            (self.row, self.record, self.disturbed) = (0, dice.below(self.records.len() as u32) as usize, true);
            self.number = self.number.wrapping_add(1 + dice.below(5000));
        }
        let mut sample = self.records[self.record][self.row];
        self.row += 1;
        self.number = self.number.wrapping_add(1);
        sample.number = self.number;
        let noise = dice.roll();
        for (k, count) in counts(&mut sample).iter_mut().enumerate() {
            *count = count.wrapping_add_signed((noise >> (8 * k) & 0xff) as i16 % 3 - 1);
        }
        self.until = self.until.saturating_sub(1);
        if self.until == 0 && self.fault.is_none() {
            let kind = dice.below(FAULTS.len() as u32 + 1) as usize;
            let inject: Inject = FAULTS.get(kind).map_or(not_finite, |fault| fault.inject);
            // From one row to three segments, each octave alike.
            let octave = dice.below(16);
            let length = 1 + dice.below(2 << octave);
            self.fault = Some((inject, 0, length));
            // 6 segments on average.
            self.until = 1 + dice.below(288_000);
            self.faults += 1;
        }
        if let Some((inject, since, length)) = &mut self.fault {
            self.disturbed = true;
            let there = inject(&mut sample, *since);
            *since += 1;
            if since == length {
                self.fault = None;
            }
            if !there {
                return None;
            }
        }
        Some(sample)
    }
}

/// What a part of the soak found.
#[derive(Clone, Debug, Default)]
struct Part {
    /// Undisturbed segments, and those of them that are called healthy.
    undisturbed: u32,
    healthy: u32,
    /// Sums and sums of squares of what is estimated in undisturbed segments: friction of the drag, distance from
    /// healthy.
    sums: [[f64; 2]; 2],
    /// Disturbed segments, those of them without a verdict, and those called defective or novel.
    disturbed: u32,
    undetermined: u32,
    wrong: u32,
    alarms: u32,
}

impl Part {
    fn mean(&self, k: usize) -> f64 {
        self.sums[k][0] / f64::from(self.undisturbed)
    }

    /// Variance of the mean.
    fn variance(&self, k: usize) -> f64 {
        let n = f64::from(self.undisturbed);
        (self.sums[k][1] / n - self.mean(k).powi(2)) / n
    }

    fn take(&mut self, report: &Report<Drive>, disturbed: bool) {
        if disturbed {
            self.disturbed += 1;
            match report.verdict {
                Verdict::Undetermined(_) => self.undetermined += 1,
                Verdict::Class(0) => {}
                _ => self.wrong += 1,
            }
            return;
        }
        self.undisturbed += 1;
        self.healthy += u32::from(report.verdict == Verdict::Class(0));
        let shaft = report.shaft().expect("a shaft");
        let drag = shaft.friction.parameter(FrictionTerm::Drag).expect("estimated").value;
        let distance = report.decision.as_ref().expect("an undisturbed segment is decided").distance;
        for (sums, value) in self.sums.iter_mut().zip([drag, distance].map(f64::from)) {
            sums[0] += value;
            sums[1] += value * value;
        }
    }
}

/// Whether each channel can be used: current, velocity, load and reference.
fn usable(sample: &Sample) -> [bool; 4] {
    let Sample { current_a, velocity_rad_s, load_torque_nm, velocity_ref_rad_s, .. } = *sample;
    let values = [current_a, velocity_rad_s, load_torque_nm, velocity_ref_rad_s];
    let limits = MODEL.constants().channels.map(|channel| channel.limit);
    std::array::from_fn(|k| values[k].abs() <= limits[k])
}

/// What is known of a segment besides its sums.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// Clean samples, those of them with a value that cannot be used, and those with such a value of the regression.
    samples: u32,
    unusable: u32,
    without_row: u32,
    disturbed: bool,
}

/// The drive behind its sensors.
struct Watch {
    front_end: FrontEnd<FURTHER, FACTOR>,
    interrupt: Interrupt<'static, Drive>,
    evidence: Evidence<Drive>,
    monitor: Monitor<'static, Drive>,
    /// What is known of the segment that is being solved.
    solving: Option<Known>,
    /// The report of the last segment, which is kept until the next one closes.
    held: Option<(Report<Drive>, Known)>,
    open: Known,
    /// Whether the segment before the open one was disturbed.
    before: bool,
    /// Whether the current could not be known at the clean sample before.
    flagged: bool,
    clean: u64,
}

impl Watch {
    fn new(constants: &FrontEndConstants) -> Self {
        Self {
            front_end: FrontEnd::new(constants).expect("good constants"),
            interrupt: Interrupt::new(&MODEL),
            monitor: Monitor::new(&MODEL),
            evidence: Evidence::new(&MODEL),
            solving: None,
            held: None,
            open: Known::default(),
            before: true,
            flagged: false,
            clean: 0,
        }
    }

    /// Takes a raw sample; `disturbed` says whether there was a disturbance since the segment started.
    fn take(&mut self, raw: &Raw, disturbed: bool, part: &mut Part) -> bool {
        let Some(clean) = self.front_end.push(raw) else { return false };
        self.clean += 1;
        let faults = self.front_end.faults();
        let flagged = faults.imbalance.is_some() || faults.lock != Lock::Locked;
        // The newest taps of a filter may be zero: from the second output on it has met the missing samples.
        assert!(!(flagged && self.flagged) || clean.current_a.is_nan(), "{faults:?}: {clean:?}");
        self.flagged = flagged;
        if clean.found_late {
            if self.interrupt.detector.is_in_first_half() {
                (self.held, self.solving) = (None, None);
            }
            self.interrupt.detector.discard();
        }
        let sample: Sample = clean.into();
        self.open.samples += 1;
        let [current, velocity, load, reference] = usable(&sample);
        let row = current && load && reference;
        self.open.unusable += u32::from(!(row && velocity));
        self.open.without_row += u32::from(!row);
        let segment = self.interrupt.collect(&sample);
        // One piece a clean sample, as in a main loop.
        if let Some(known) = self.solving
            && let Some(now) = self.monitor.advance()
        {
            check(now.report, &known);
            self.held = Some((now.report.clone(), known));
            self.solving = None;
        }
        let Some(mut segment) = segment else { return false };
        assert_eq!(self.open.samples, SEGMENT, "a segment has its number of samples");
        if let Some((report, known)) = self.held.take() {
            part.alarms += u32::from(self.evidence.observe(report.decision.as_ref()).is_some());
            finite::evidence(&self.evidence);
            part.take(&report, known.disturbed);
        }
        let known = Known { disturbed: disturbed || self.before, ..self.open };
        self.monitor.take_from(&mut segment);
        self.solving = Some(known);
        (self.open, self.before) = (Known::default(), disturbed);
        true
    }
}

/// What holds for every report.
fn check(report: &Report<Drive>, known: &Known) {
    finite::report(report);
    assert_eq!(report.counts.rejected, known.unusable, "{report:?}");
    // Of samples that cannot be used none is in the sums.
    assert!(report.rows + known.without_row <= SEGMENT, "{known:?}: {report:?}");
    let undetermined = matches!(report.verdict, Verdict::Undetermined(_));
    assert!(undetermined || 2 * known.without_row <= SEGMENT, "{known:?}: {report:?}");
    assert_eq!(report.decision.is_none(), undetermined);
}

/// Runs the drive; returns what each part found.
fn soak(samples: u64, records: u64) -> Vec<Part> {
    let made: Vec<_> = (0..records).map(|k| record(0x50a0 + k, 0.025 + 0.002 * k as f64)).collect();
    let mut watch = Watch::new(&made[0].0);
    let records = made.into_iter().map(|(_, rows)| rows).collect();
    let dice = Dice(1);
    let mut source =
        Source { records, dice, record: 0, row: 0, number: 0, fault: None, until: 50_000, faults: 0, disturbed: true };
    let mut parts = vec![Part::default(); PARTS];
    let mut taken = 0;
    for number in 0..samples {
        let part = &mut parts[(number * PARTS as u64 / samples) as usize];
        let Some(sample) = source.next() else { continue };
        taken += 1;
        if watch.take(&sample, source.disturbed, part) {
            source.disturbed = source.fault.is_some();
        }
    }
    // Those that fill the filters are no clean samples.
    let filling = taken / FACTOR as u64 - watch.clean;
    assert!(filling <= 32, "{filling} clean samples fewer than there must be");
    println!("{taken} samples, {} clean ones, {} faults; {parts:#?}", watch.clean, source.faults);
    parts
}

fn row(what: &str, step: &str, cells: impl Iterator<Item = String>) {
    println!("| {what} | {step} | {} |", cells.collect::<Vec<_>>().join(" | "));
}

/// Prints the rows, and checks that the last part is like the first.
fn judge(samples: u64, parts: &[Part]) {
    let step = format!("{:.0e} samples", samples as f64 / PARTS as f64);
    let rate = |part: &Part| f64::from(part.healthy) / f64::from(part.undisturbed);
    row("soak: undisturbed segments", &step, parts.iter().map(|part| part.undisturbed.to_string()));
    row("soak: of these healthy, %", &step, parts.iter().map(|part| format!("{:.1}", 100.0 * rate(part))));
    row("soak: mean friction of these, A", &step, parts.iter().map(|part| format!("{:.4}", part.mean(0))));
    row("soak: mean distance from healthy", &step, parts.iter().map(|part| format!("{:.3}", part.mean(1))));
    row("soak: segments with a fault", &step, parts.iter().map(|part| part.disturbed.to_string()));
    row("soak: of these without a verdict", &step, parts.iter().map(|part| part.undetermined.to_string()));
    row("soak: of these not healthy", &step, parts.iter().map(|part| part.wrong.to_string()));
    row("soak: alarms", &step, parts.iter().map(|part| part.alarms.to_string()));
    let (first, last) = (&parts[0], &parts[PARTS - 1]);
    for k in 0..2 {
        let spread = (first.variance(k) + last.variance(k)).sqrt();
        let change = last.mean(k) - first.mean(k);
        assert!(change.abs() < 4.0 * spread, "{k}: {change} of {spread}");
    }
    let pooled = f64::from(first.healthy + last.healthy) / f64::from(first.undisturbed + last.undisturbed);
    let counts = 1.0 / f64::from(first.undisturbed) + 1.0 / f64::from(last.undisturbed);
    let change = rate(last) - rate(first);
    assert!(change.abs() <= 4.0 * (pooled * (1.0 - pooled) * counts).sqrt(), "{change}");
    assert!(parts.iter().all(|part| part.alarms == 0), "a healthy drive");
}

#[test]
fn a_drive_soaks_short() {
    let samples = 6_000_000;
    judge(samples, &soak(samples, 2));
}

#[test]
#[ignore = "1e9 samples: minutes"]
fn a_drive_soaks_long() {
    let samples = 1_000_000_000;
    judge(samples, &soak(samples, 6));
}
