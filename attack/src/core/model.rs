//! Bytes of a model: refused, or a model whose detector gives finite results.

use bearing_watch::model::{layout, notes, stored_len};
use bearing_watch::plan::{Plan, RunTime};
use bearing_watch::{Detector, Evidence, Model};

use crate::input::Input;
use crate::models::{BYTES, refined, shaft, standard_rig};
use crate::{checksum, finite, session};

/// Header of a model, and its checksum.
const FRAME: usize = 20;
/// Samples of a run.
const SAMPLES: usize = 80;

/// Any bytes, or those of a good model with changes behind a right checksum.
pub fn attack(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    match input.byte() % 4 {
        0 => read(input.bytes(usize::MAX), &[]),
        1 => forged(&mut input),
        _ => changed(&mut input),
    }
}

/// A payload of any bytes under a right header and checksum.
fn forged(input: &mut Input<'_>) {
    let samples = input.array::<16>();
    let payload = input.bytes(usize::MAX);
    let mut model = BYTES[0][..8].to_vec();
    model.extend((payload.len() as u32).to_le_bytes());
    model.extend([0; 4]);
    model.extend(payload);
    model.extend([0; 4]);
    checksum::put(&mut model);
    read(&model, &samples);
}

/// A good model with some bytes changed, as a rule under a right checksum.
fn changed(input: &mut Input<'_>) {
    let mut model = BYTES[input.below(BYTES.len())].clone();
    let (changes, samples) = (1 + input.byte() % 8, input.array::<16>());
    for _ in 0..changes {
        let place = usize::from(input.half()) % model.len();
        match input.byte() % 4 {
            0 => model[place] = input.byte(),
            1 => model[place] ^= 1 << (input.byte() % 8),
            // Numbers are not aligned to the start of the payload.
            _ => {
                let number = input.number().to_le_bytes();
                model.iter_mut().skip(place).zip(number).for_each(|(cell, byte)| *cell = byte);
            }
        }
    }
    if !input.byte().is_multiple_of(8) {
        checksum::put(&mut model);
    }
    read(&model, &samples);
}

/// Reads the bytes for several plans, and runs what is read.
pub fn read(bytes: &[u8], samples: &[u8]) {
    let (length, own, text) = (stored_len(bytes), layout(bytes), notes(bytes));
    let sector = Model::<RunTime>::from_sector(bytes);
    if length.is_err() {
        assert!(own.is_err() && text.is_err() && sector.is_err());
    }
    if let Ok(model) = sector {
        run(&model, samples);
    }
    run_fixed::<standard_rig::model::Drive>(bytes, samples);
    run_fixed::<refined::Refined>(bytes, samples);
    run_fixed::<shaft::Watched>(bytes, samples);
    run_fixed::<shaft::Loadless>(bytes, samples);
}

fn run_fixed<P: Plan>(bytes: &[u8], samples: &[u8]) {
    if let Ok(model) = Model::<P>::from_bytes(bytes) {
        run(&model, samples);
    }
}

/// Runs a model: it is written as it was read, and its results are finite.
fn run<P: Plan>(model: &Model<P>, samples: &[u8]) {
    let mut buffer = [0; 4096];
    if let Ok(length) = model.to_bytes("", &mut buffer) {
        assert!(length > FRAME && Model::<P>::from_bytes(&buffer[..length]).is_ok(), "what is written is read");
    }
    let mut detector = Detector::new(model);
    let mut evidence = Evidence::new(model);
    let mut wild = Input::new(samples);
    let mut ordinary = crate::models::numbers::Numbers(u32::from(wild.byte()));
    for k in 0..SAMPLES {
        let sample = if k % 16 == 15 && !wild.is_empty() {
            session::wild::<P>(&mut wild)
        } else {
            let angle = bearing_watch::Angle::from_bits((k as u32).wrapping_mul(200_000_000));
            bearing_watch::plan::Signals::of(&ordinary.array::<16>(), angle)
        };
        if let Some(report) = detector.step(&sample) {
            finite::report(&report);
            evidence.observe(report.decision.as_ref());
            finite::evidence(&evidence);
        }
    }
    finite::report(&detector.preview());
    finite::report(&detector.finish());
}
