use std::f64::consts::TAU;

use super::*;
use bearing_watch::drive::{Alignment, FrontEnd, PhaseCounts, Position, RawSample};

/// A drive that turns to and fro, with friction, and how it records.
#[derive(Clone, Copy)]
struct Drive {
    pole_pairs: f64,
    offset_rad: f64,
    /// Counts of the position a turn; 0 for an angle in rad.
    turn: f64,
    reversed: bool,
    /// Phases that have a column, by their place.
    phases: &'static [usize],
    /// Amperes a count, and counts at no current; 0 for amperes as they are.
    gain_a: f64,
    zero: f64,
    /// The current in parts of that of the others, the deviation of each sensor's noise, A, and a seed of it.
    load: f64,
    noise_a: f64,
    seed: u32,
}

const DRIVE: Drive = Drive {
    pole_pairs: 4.0,
    offset_rad: 1.0,
    turn: 4096.0,
    reversed: false,
    phases: &[0, 1, 2],
    gain_a: 0.01,
    zero: 2048.0,
    load: 1.0,
    noise_a: 0.006,
    seed: 7,
};
const RATE_HZ: f64 = 8000.0;
const PHASES: [&str; 3] = ["adc_a", "adc_b", "adc_c"];

impl Drive {
    /// Seconds ─► angle, velocity, quadrature current.
    fn truth(t: f64) -> [f64; 3] {
        let omega = TAU * 0.7;
        let (angle, velocity) = (2.0 + 30.0 * (omega * t).sin(), 30.0 * omega * (omega * t).cos());
        let acceleration = -30.0 * omega * omega * (omega * t).sin();
        [angle, velocity, 0.004 * acceleration + 1.5 * (velocity / 5.0).tanh()]
    }

    fn recorded(self) -> (Vec<String>, Vec<Vec<f64>>) {
        let mut names: Vec<String> = self.phases.iter().map(|k| PHASES[*k].into()).collect();
        names.extend(["enc_pos", "velocity_ref_rad_s"].map(String::from));
        let mut columns = vec![vec![]; names.len()];
        let mut state = self.seed;
        // Of four uniform ones.
        let mut noise = || {
            let mut sum = -2.0;
            for _ in 0..4 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += f64::from(state >> 8) / f64::from(1_u32 << 24);
            }
            sum * 3.0_f64.sqrt()
        };
        for row in 0..24_000 {
            let t = f64::from(row) / RATE_HZ;
            let [angle, velocity, q] = Self::truth(t);
            let electrical = self.pole_pairs * angle + self.offset_rad;
            for (place, k) in self.phases.iter().enumerate() {
                let a = -self.load * q * (electrical - *k as f64 * TAU / 3.0).sin() + self.noise_a * noise();
                columns[place].push(if self.gain_a > 0.0 { (self.zero + a / self.gain_a).round() } else { a });
            }
            let shown = if self.reversed { -angle } else { angle };
            let counts = (shown / TAU * self.turn).floor().rem_euclid(self.turn);
            columns[self.phases.len()].push(if self.turn > 0.0 { counts } else { shown });
            columns[self.phases.len() + 1].push(velocity);
        }
        (names, columns)
    }

    fn found(self) -> RawFrontEnd {
        let (names, columns) = self.recorded();
        front_end((&names, &columns), Some(RATE_HZ), Extremes::default()).unwrap_or_else(|problem| panic!("{problem}"))
    }

    /// The largest errors of quadrature current and velocity behind the front end, and its samples.
    fn errors(self, found: &RawFrontEnd) -> ([f64; 2], usize) {
        assert_eq!(found.file.factor, 8, "{}", found.text);
        let (names, columns) = self.recorded();
        let place = |name: &&str| names.iter().position(|own| own == name).expect("a column");
        let recorded: Vec<&[f64]> = found.file.columns().iter().map(|name| &columns[place(name)][..]).collect();
        let mut front_end = FrontEnd::<8, 8>::new(&found.file.constants()).expect("good constants");
        let (mut worst, mut samples) = ([0.0_f64; 2], 0);
        for row in 0..columns[0].len() {
            let raw: RawSample<8> = crate::front_end::raw_sample(&found.file, &recorded, &[], None, row);
            let Some(clean) = front_end.push(&raw) else { continue };
            let [_, velocity, q] = Self::truth((row as f64 - FrontEnd::<8, 8>::DELAY as f64) / RATE_HZ);
            let gain = if self.gain_a > 0.0 { self.gain_a } else { 1.0 };
            let errors = [f64::from(clean.current_a) * gain - q, f64::from(clean.velocity_rad_s) - velocity];
            worst.iter_mut().zip(errors).for_each(|(worst, error)| *worst = worst.max(error.abs()));
            samples += 1;
        }
        assert!(front_end.faults().is_clear(), "{:?}", front_end.faults());
        (worst, samples)
    }
}

/// The currents of `rows` through the front end, wired otherwise: whether they turn with the rotor, and whether the last
/// sample has one.
fn wired(found: &RawFrontEnd, drive: Drive, change: impl Fn(&mut RawSample<8>)) -> (Alignment, bool) {
    let (names, columns) = drive.recorded();
    let place = |name: &&str| names.iter().position(|own| own == name).expect("a column");
    let recorded: Vec<&[f64]> = found.file.columns().iter().map(|name| &columns[place(name)][..]).collect();
    let mut front_end = FrontEnd::<8, 8>::new(&found.file.constants()).expect("good constants");
    let mut last = f32::NAN;
    for row in 0..columns[0].len() {
        let mut raw: RawSample<8> = crate::front_end::raw_sample(&found.file, &recorded, &[], None, row);
        change(&mut raw);
        last = front_end.push(&raw).map_or(last, |clean| clean.current_a);
    }
    (front_end.faults().alignment, last.is_finite())
}

/// Drives of 10 A, whose converters of 12 bits reach 20 A, with noise of half a count to two counts a sensor.
fn at_five_per_cent(k: u32) -> Drive {
    Drive {
        pole_pairs: [4.0, 7.0, 2.0, 11.0, 5.0][k as usize % 5],
        offset_rad: f64::from(k),
        phases: [&[0, 1, 2][..], &[0, 1], &[1, 2], &[0, 2]][k as usize % 4],
        reversed: k % 3 == 1,
        gain_a: 40.0 / 4096.0,
        zero: 2048.0 + f64::from(k % 7),
        // Of 2.7 A at most.
        load: 0.5 / 2.7,
        noise_a: [0.005, 0.01, 0.02][k as usize % 3],
        seed: 100 + k,
        ..DRIVE
    }
}

#[test]
fn the_noise_is_that_of_the_sensors_at_any_current() {
    for (load, noise_a) in [(0.5 / 2.7, 0.02), (1.0, 0.02), (4.0, 0.02), (1.0, 0.1), (4.0, 0.004)] {
        for phases in [&[0, 1, 2][..], &[1, 2]] {
            let drive = Drive { load, noise_a, phases, ..DRIVE };
            let balance = drive.found().file.constants().balance;
            // Counts of 0.01 A round the current; noise of less than a count is not white.
            let expected = 3.0_f64.sqrt() * noise_a.hypot(0.01 / 12.0_f64.sqrt()) / 0.01;
            let ratio = f64::from(balance.noise_a) / expected;
            assert!((0.9..1.25).contains(&ratio), "{load} {noise_a} {phases:?}: {ratio}");
            assert!(balance.offset_a >= 6.0 * balance.noise_a * 0.999, "{balance:?}");
        }
    }
}

#[test]
fn the_wiring_is_decided_from_five_per_cent_of_the_rated_current_on() {
    for k in 0..30 {
        let drive = at_five_per_cent(k);
        assert_eq!(wired(&drive.found(), drive, |_| ()), (Alignment::Aligned, true), "{k}");
    }
    for k in 0..6 {
        let drive = at_five_per_cent(k);
        let found = drive.found();
        let refused = (Alignment::Misaligned, false);
        let reverse = |raw: &mut RawSample<8>| {
            if let Position::Absolute(angle) = raw.position {
                raw.position = Position::Absolute(angle.negated());
            }
        };
        assert_eq!(wired(&found, drive, reverse), refused, "angle reversed, {k}");
        let exchange = |raw: &mut RawSample<8>| match &mut raw.currents {
            PhaseCounts::Three([_, b, c]) => std::mem::swap(b, c),
            PhaseCounts::Two([a, b]) => std::mem::swap(a, b),
            PhaseCounts::Quadrature(_) => {}
        };
        assert_eq!(wired(&found, drive, exchange), refused, "phases exchanged, {k}");
        for by in [-1.0, 1.0] {
            let from = format!("pole_pairs = {} ", drive.pole_pairs);
            let text = found.text.replace(&from, &format!("pole_pairs = {} ", drive.pole_pairs + by));
            let file = FrontEndFile::parse(&text).expect("a front end");
            let other = RawFrontEnd { text, file, said: vec![] };
            assert_eq!(wired(&other, drive, |_| ()), refused, "pole pairs, {k} {by}");
        }
    }
}

/// Of 2.7 A and 130 rad/s: noise of 0.006 A, a count of 0.01 A, an offset of 0.01 rad, and counts of the position in the
/// velocity, 2π/4096 a sample of 8 kHz behind filters.
const TOLERANCES: [f64; 2] = [0.06, 2.0];

#[test]
fn the_front_end_of_a_recording_makes_its_quadrature_current_and_velocity() {
    let drives = [
        DRIVE,
        Drive { reversed: true, ..DRIVE },
        Drive { phases: &[1, 2], ..DRIVE },
        Drive { phases: &[0, 2], reversed: true, offset_rad: 4.5, ..DRIVE },
        Drive { turn: 8000.0, pole_pairs: 7.0, ..DRIVE },
        Drive { turn: 0.0, gain_a: 0.0, zero: 0.0, pole_pairs: 1.0, ..DRIVE },
        Drive { turn: 65_536.0, gain_a: 0.001, zero: 32_700.0, pole_pairs: 21.0, offset_rad: 0.0, ..DRIVE },
    ];
    for drive in drives {
        let found = drive.found();
        let text = &found.text;
        assert!(text.contains(&format!("pole_pairs = {}", drive.pole_pairs)), "{text}");
        assert_eq!(text.contains("reversed = true"), drive.reversed, "{text}");
        let (errors, samples) = drive.errors(&found);
        assert!(errors.iter().zip(TOLERANCES).all(|(error, most)| *error < most), "{errors:?} {text}");
        assert!(samples > 2900, "{samples}");
    }
}

#[test]
fn what_a_recording_tells_is_written_as_it_is() {
    let text = DRIVE.found().text;
    assert!(
        text.contains("bits = 12") && text.contains("of 12 bits") && text.contains("control_rate_hz = 8000"),
        "{text}"
    );
    let text = Drive { turn: 8000.0, ..DRIVE }.found().text;
    assert!(text.contains("counts_per_turn = 8000"), "{text}");
    let text = Drive { phases: &[2, 0], ..DRIVE }.found().text;
    assert!(text.contains("columns = [\"adc_c\", \"adc_a\"]") && text.contains("phases = \"ca\""), "{text}");
    let drive_front_end = DRIVE.found();
    let said = drive_front_end.said.concat();
    assert!(said.contains("gain_a is 1"), "{said}");
    // The noise follows the gain that a user sets.
    let set = FrontEndFile::parse(&drive_front_end.text.replace("1.000000e0", "0.25")).expect("a front end");
    assert!(drive_front_end.text.contains("1.000000e0"), "{}", drive_front_end.text);
    assert!(set.constants().balance.noise_a == 0.25 * drive_front_end.file.constants().balance.noise_a);
    // The largest current of all recordings, and the longest rest.
    let (names, columns) = DRIVE.recorded();
    let others = Extremes::default().with(&[&[4000.0], &[2048.0; 101]]).with(&[&[16_000.0]]);
    let text = front_end((&names, &columns), Some(RATE_HZ), others).expect("a front end").text;
    assert!(text.contains("of 14 bits") && text.contains("stuck_samples = 2000"), "{text}");
    assert_eq!(phase_names(&names, &columns).expect("three phases"), PHASES);
    let said = Drive { gain_a: 0.0, zero: 0.0, ..DRIVE }.found().said.concat();
    assert!(said.contains("16 bits is assumed"), "{said}");
}

#[test]
fn recordings_that_tell_too_little_say_what_is_missing() {
    let (names, columns) = DRIVE.recorded();
    let problem = |names: &[String], columns: &[Vec<f64>], rate_hz| {
        front_end((names, columns), rate_hz, Extremes::default()).map(|found| found.text).expect_err("too little")
    };
    assert!(problem(&names, &columns, None).contains("--rate-hz"));
    assert!(problem(&names[1..2], &columns[1..2], Some(RATE_HZ)).contains("no columns of two or three"));
    assert!(problem(&names[..3], &columns[..3], Some(RATE_HZ)).contains("no column of the position"));
    let mut on = columns.clone();
    on[3] = (0..on[3].len()).map(|k| k as f64).collect();
    assert!(problem(&names, &on, Some(RATE_HZ)).contains("never starts anew"));
    let mut other = columns.clone();
    other[3] = (0..other[3].len()).map(|k| (13.0 * k as f64).rem_euclid(4096.0)).collect();
    assert!(problem(&names, &other, Some(RATE_HZ)).contains("do not turn with the position"));
    let mut degrees = columns;
    degrees[3] = degrees[3].iter().map(|counts| counts * 360.0 / 4096.0 + 1e-3).collect();
    assert!(problem(&names, &degrees, Some(RATE_HZ)).contains("degrees"));
}
