//! Every factor of decimation gives the bits of the core, through faults of every kind.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "readings of converters")]

use std::boxed::Box;

use bearing_watch::drive::{By, CleanSample, Factor, Faults, FrontEnd, PhaseCounts, Position, RawSample};
use bearing_watch::plan::Signals as _;
use bearing_watch::watch::Source as _;
use bearing_watch::{Angle, Model};

use super::*;
use crate::plan::Sample;
use drive::{CONSTANTS, for_c, raw, raw_for_c};

#[path = "../../tests/support/drive.rs"]
mod drive;

/// A model of current, velocity and two further channels.
static FILE: &[u8] = include_bytes!("../../../examples/support/actuator/model.bwm");

/// A front end as C makes it.
fn made(factor: u16, further: u16) -> *mut BwFrontEnd {
    let memory = Box::leak(Box::new([0_u64; BW_FRONT_END_SIZE / 8]));
    let (mut front_end, constants) = (core::ptr::null_mut(), for_c(&CONSTANTS, factor, further));
    // SAFETY: the memory is there for ever.
    let code =
        unsafe { bw_front_end_init(memory.as_mut_ptr().cast(), size_of_val(memory), &constants, &raw mut front_end) };
    assert_eq!(code, BwCode::Ok);
    front_end
}

/// The front end as a state has it.
fn front(factor: u16, further: u16) -> Front {
    let front_end = made(factor, further);
    // SAFETY: it was made, and is there for ever.
    unsafe {
        let (taken, _) = Front::take(front_end, &Model::from_bytes(FILE).unwrap()).unwrap();
        assert!(at(front_end).is_err(), "it belongs to the state");
        taken
    }
}

/// The reading as C gives it.
fn pushed(front: &mut Front, raw: &RawSample<2>) -> Option<bearing_watch::watch::Sampled<Sample>> {
    let own = raw_for_c(raw);
    // SAFETY: both are there for the call.
    let reading = unsafe { sample::read(&raw const own, (raw.further.as_ptr(), 2), 2) }.unwrap();
    front.push(&reading)
}

fn same_clean(c: Option<bearing_watch::watch::Sampled<Sample>>, rust: Option<CleanSample<2>>) {
    // In the order of the model: load torque and reference are the further ones.
    let c = c.map(|own| {
        let values = [0, 1, 2, 3].map(|channel| own.clean.value(channel).to_bits());
        (values, own.clean.angle(), own.found_late, own.alignment)
    });
    let rust = rust.map(|own| {
        let values = [own.current_a, own.velocity_rad_s, own.further[0], own.further[1]].map(f32::to_bits);
        (values, own.angle, own.found_late, own.alignment)
    });
    assert_eq!(c, rust);
}

/// What the drive reads of two or three phases, by a converter of the angle or a resolver.
fn read(number: u32, resolver: bool, two: bool) -> RawSample<2> {
    let mut sample = raw(number);
    if let (PhaseCounts::Three([a, b, _]), true) = (sample.currents, two) {
        sample.currents = PhaseCounts::Two([a, b]);
    }
    if let (Position::Absolute(angle), true) = (sample.position, resolver) {
        let signals = angle.sin_cos();
        sample.position = Position::Resolver { sin: signals.sin, cos: signals.cos };
    }
    sample
}

/// Puts in faults by a random number; returns whether the interrupt is missed.
fn disturb(sample: &mut RawSample<2>, random: u32) -> bool {
    match (random >> 8) % 1500 {
        0 => sample.currents = PhaseCounts::Three([40, 65_100, 32_768]),
        1 => sample.position = Position::Missing,
        2 => sample.position = Position::Absolute(Angle::from_bits(random)),
        3 => sample.position = Position::Resolver { sin: f32::NAN, cos: 2.0 },
        4 => sample.position = Position::Resolver { sin: 1.0, cos: 2.0 },
        5 => sample.further = [f32::NAN, f32::INFINITY],
        6 => return true,
        _ => {}
    }
    // A broken sensor for a while, and a position that is lost.
    if let (PhaseCounts::Three([_, b, _]), 6000..9000) = (&mut sample.currents, sample.number) {
        *b = 32_760;
    }
    if (9500..9600).contains(&sample.number) {
        sample.position = Position::Missing;
    }
    false
}

/// A stream with every fault that there is, at random; returns the last counts of faults.
fn compare<const FACTOR: usize>(resolver: bool, two: bool) -> Faults
where
    By<FACTOR>: Factor,
{
    let mut rust = FrontEnd::<2, FACTOR>::new(&CONSTANTS).expect("good constants");
    let mut c = front(FACTOR as u16, 2);
    // Samples, and the number of the reading with the first one, from which on none is left out.
    let (mut random, mut clean, mut first) = (7_u32, 0, None);
    for number in 0..12_000 {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let mut sample = read(number, resolver, two);
        // Behind the longest filters, the first sample needs so many readings without a fault.
        if number > 2000 && disturb(&mut sample, random) {
            continue;
        }
        let (own, other) = (pushed(&mut c, &sample), rust.push(&sample));
        clean += usize::from(own.is_some());
        first = first.or(own.is_some().then_some(number as usize));
        same_clean(own, other);
        assert_eq!(c.faults(), Some(rust.faults()));
    }
    let first = first.expect("a clean sample");
    // Readings that are missing shift the outputs, by at most one of them.
    assert!(first < 2000 && clean + 60 > (12_000 - first) / FACTOR, "by {FACTOR}: {clean} from {first} on");
    let last = rust.faults();
    c.clear_faults();
    rust.clear_faults();
    assert_eq!(c.faults(), Some(rust.faults()));
    last
}

#[test]
fn every_factor_gives_the_bits_of_rust_through_faults() {
    let all = [
        compare::<1>(false, false),
        compare::<2>(true, false),
        compare::<4>(false, true),
        compare::<8>(true, true),
        compare::<16>(false, false),
        compare::<32>(true, false),
        compare::<6>(false, true),
        compare::<12>(true, true),
        compare::<24>(false, false),
        compare::<48>(true, false),
        compare::<10>(false, true),
        compare::<20>(true, true),
        compare::<40>(false, false),
    ];
    let sum = |of: fn(&Faults) -> u32| all.iter().map(of).sum::<u32>();
    assert!(sum(|own| own.gaps) > 50 && sum(|own| own.unbalanced_windows) > 6);
    assert!(sum(|own| own.currents[0].saturated) > 50 && sum(|own| own.currents[1].stuck) > 1000);
    assert!(sum(|own| own.position.missing) > 1300 && sum(|own| own.position.losses) >= 13);
    assert!(sum(|own| own.position.strayed) > 20 && sum(|own| own.position.resolver.lost) > 20);
    assert!(sum(|own| own.position.resolver.too_high) > 20);
}

#[test]
fn a_front_end_of_other_channels_than_the_model_is_refused() {
    let model = Model::<Own>::from_bytes(FILE).unwrap();
    for further in [0, 1, 3] {
        let front_end = made(10, further);
        // SAFETY: it was made, and is there for ever.
        unsafe {
            assert_eq!(at(front_end).unwrap().check(&model), Err(BwCode::FrontEndFurther));
            let refused = Front::take(front_end, &model).is_err();
            assert!(refused && at(front_end).is_ok(), "it may be used for another model");
        }
    }
}
