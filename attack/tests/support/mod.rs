//! What the tests share: kept corpora, and changes of their inputs.

use std::io::Read as _;
use std::path::Path;

use attack::Door;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Longest input.
const LONGEST: usize = 4096;

/// The kept inputs of a door.
///
/// # Panics
/// If there are none.
pub fn kept(door: &Door) -> Vec<Vec<u8>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(format!("{}.zip", door.name));
    let file = std::fs::File::open(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut archive = zip::ZipArchive::new(file).expect("an archive");
    let count = archive.len();
    let read = |place: usize| {
        let mut bytes = Vec::new();
        archive.by_index(place).expect("a file").read_to_end(&mut bytes).expect("readable");
        bytes
    };
    (0..count).map(read).collect()
}

/// Attacks a door with its kept inputs, and with so many changes of them, the same in every run.
pub fn attack(door: &Door, changes: usize) {
    let kept = kept(door);
    kept.iter().for_each(|bytes| (door.attack)(bytes));
    let mut random = ChaCha8Rng::seed_from_u64(door.name.bytes().map(u64::from).sum());
    for _ in 0..changes {
        let mut bytes = kept[random.random_range(0..kept.len())].clone();
        for _ in 0..random.random_range(1..6) {
            change(&mut bytes, &kept, &mut random);
        }
        bytes.truncate(LONGEST);
        (door.attack)(&bytes);
    }
    println!("{}: {} kept inputs, {changes} changes", door.name, kept.len());
}

/// Changes, adds, removes or repeats bytes, or takes the rest of another input.
fn change(bytes: &mut Vec<u8>, kept: &[Vec<u8>], random: &mut ChaCha8Rng) {
    let place = random.random_range(0..=bytes.len());
    let end = (place + random.random_range(0..32_usize)).min(bytes.len());
    match random.random_range(0..6) {
        0 => bytes.iter_mut().skip(place).take(1).for_each(|byte| *byte ^= 1 << random.random_range(0..8)),
        1 => bytes.iter_mut().skip(place).take(1).for_each(|byte| *byte = random.random()),
        2 => bytes.insert(place, random.random()),
        3 => drop(bytes.drain(place..end)),
        4 => {
            let copy = bytes[place..end].to_vec();
            let to = random.random_range(0..=bytes.len());
            drop(bytes.splice(to..to, copy));
        }
        _ => {
            let other = &kept[random.random_range(0..kept.len())];
            bytes.truncate(place);
            bytes.extend(other.iter().skip(place));
        }
    }
}
