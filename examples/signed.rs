//! A signed model at start: it is read only if an accepted key has signed it and it is not older than the last one.
//! `cargo run --features signature --example signed`
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[allow(dead_code, reason = "the model comes from the signed bytes")]
#[path = "support/standard_rig/model.rs"]
mod model;

use bearing_watch::Model;
use bearing_watch::signature::{PublicKey, Trust};

use model::Drive;

main!(run);

/// The model of the standard rig, signed with a key of the tests.
static SIGNED: &[u8] = include_bytes!("support/standard_rig/signed.bwm");

/// As `bearing-watch sign --key FILE` prints it.
const KEY: PublicKey = [
    0x8a, 0x88, 0xe3, 0xdd, 0x74, 0x09, 0xf1, 0x95, 0xfd, 0x52, 0xdb, 0x2d, 0x3c, 0xba, 0x5d, 0x72, 0xca, 0x67, 0x09,
    0xbf, 0x1d, 0x94, 0x12, 0x1b, 0xf3, 0x74, 0x88, 0x01, 0xb4, 0x0f, 0x6f, 0x5c,
];
/// Counter of the newest model that has run. A drive stores it in memory that cannot be set back.
const LEAST_COUNTER: u32 = 5;

fn run() {
    // What follows the signature is erased flash.
    let (mut sector, length) = ([0xFF; 4096], SIGNED.len());
    sector.iter_mut().zip(SIGNED).for_each(|(cell, byte)| *cell = *byte);
    verify("flash", &sector, KEY, LEAST_COUNTER);
    verify("next counter", &sector, KEY, LEAST_COUNTER + 1);
    verify("other key", &sector, [7; 32], LEAST_COUNTER);
    verify("cut short", sector.get(..length - 1).unwrap_or_default(), KEY, LEAST_COUNTER);
    flip(&mut sector, 100);
    verify("changed model", &sector, KEY, LEAST_COUNTER);
    flip(&mut sector, 100);
    flip(&mut sector, length - 1);
    verify("changed signature", &sector, KEY, LEAST_COUNTER);
}

fn flip(bytes: &mut [u8], place: usize) {
    if let Some(byte) = bytes.get_mut(place) {
        *byte ^= 1;
    }
}

fn verify(what: &str, bytes: &[u8], key: PublicKey, least_counter: u32) {
    match (Trust { keys: &[key], least_counter }).verify(bytes) {
        Ok(signed) => {
            let read = Model::<Drive>::from_bytes(signed.model).map_or_else(|error| error.message(), |_| "read");
            say!("{what}: model of {} bytes, counter {}, {read}", signed.model.len(), signed.counter);
        }
        Err(error) => say!("{what}: {}", error.message()),
    }
}
