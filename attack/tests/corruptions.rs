//! Corrupted models: every single byte with every value, and a million random changes of several bytes, are refused or
//! harmless. The checksum is left as it was.

use attack::models::{BYTES, numbers::Numbers};
use bearing_watch::plan::{RunTime, RunTimeSample};
use bearing_watch::{Detector, Model, Report};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Random corruptions of several bytes.
const RANDOM: u32 = 1_000_000;

/// What a detector of a model reports of a stream.
fn reports(model: &Model<RunTime>) -> Vec<Report<RunTime>> {
    let channels = usize::from(model.plan().layout().channels);
    let (mut detector, mut numbers) = (Detector::new(model), Numbers(3));
    let mut sample = || RunTimeSample { values: numbers.array::<16>()[..channels].to_vec(), ..Default::default() };
    (0..300).filter_map(|_| detector.step(&sample())).collect()
}

/// Counts a corruption as refused, or compares what it does with what the good model does.
fn refused(bytes: &[u8], good: &[Report<RunTime>]) -> bool {
    let Ok(model) = Model::<RunTime>::from_bytes(bytes) else { return true };
    assert!(reports(&model) == good, "a corruption that is accepted changes nothing");
    false
}

#[test]
fn every_single_byte_is_refused_or_harmless() {
    let (mut corrupted, mut refusals) = (0_u64, 0);
    for file in BYTES.iter() {
        let good = reports(&Model::from_bytes(file).expect("a good model"));
        let mut bytes = file.clone();
        for place in 0..file.len() {
            for change in 1..=255 {
                bytes[place] = file[place] ^ change;
                corrupted += 1;
                refusals += u64::from(refused(&bytes, &good));
            }
            bytes[place] = file[place];
        }
    }
    println!("{corrupted} corruptions of one byte of {} models, {refusals} refused", BYTES.len());
    // The checksum changes for every burst of up to 32 bits.
    assert_eq!(corrupted, refusals);
}

#[test]
fn a_million_random_corruptions_are_refused_or_harmless() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let good: Vec<_> = BYTES.iter().map(|file| reports(&Model::from_bytes(file).expect("a good model"))).collect();
    let mut refusals = 0;
    for k in 0..RANDOM {
        let which = k as usize % BYTES.len();
        let mut bytes = BYTES[which].clone();
        for _ in 0..random.random_range(2..32) {
            let place = random.random_range(0..bytes.len());
            bytes[place] = random.random();
        }
        refusals += u32::from(refused(&bytes, &good[which]));
    }
    println!("{RANDOM} random corruptions of several bytes, {refusals} refused");
    assert!(refusals > RANDOM - 10, "{refusals}");
}
