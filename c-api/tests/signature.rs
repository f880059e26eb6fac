//! A model is verified as in Rust: what no accepted key has signed, or what is older, is refused by its code.
#![cfg(feature = "signature")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::ffi::CStr;
use core::ptr::{null, null_mut};
use std::path::Path;
use std::{env, fs};

use bearing_watch::signature::{BLOCK, PublicKey, SignatureError, head};
use bearing_watch_c::*;
use ed25519_compact::{KeyPair, Seed};

use support::{FILE, Memory};

/// If set, the test writes the signed model of the examples instead of comparing it.
const WRITE: &str = "BEARING_WATCH_WRITE_SIGNED_MODEL";
const COUNTER: u32 = 5;
/// What a refusal must leave as it is.
const UNTOUCHED: BwSigned = BwSigned { model_length: 1, length: 2, counter: 3 };

fn pair(seed: u8) -> KeyPair {
    KeyPair::from_seed(Seed::new([seed; 32]))
}

/// The model of the standard rig with the signature of a key.
fn signed(pair: &KeyPair) -> Vec<u8> {
    let mut bytes = FILE.to_vec();
    bytes.extend(head(bytes.len() as u32, &pair.pk, COUNTER));
    bytes.extend(*pair.sk.sign(&bytes, None));
    bytes
}

fn verify(bytes: &[u8], keys: &[PublicKey], least: u32) -> Result<BwSigned, BwCode> {
    let mut told = UNTOUCHED;
    // SAFETY: bytes and keys are there for the whole call.
    let code = unsafe { bw_verify_model(bytes.as_ptr(), bytes.len(), keys.as_ptr(), keys.len(), least, &raw mut told) };
    if code == BwCode::Ok {
        return Ok(told);
    }
    assert_eq!(told, UNTOUCHED, "{code:?}");
    Err(code)
}

#[test]
fn what_a_key_has_signed_starts() {
    let (pair, mut memory) = (pair(1), Memory::new());
    let mut bytes = signed(&pair);
    let expected = BwSigned { model_length: FILE.len(), length: FILE.len() + BLOCK, counter: COUNTER };
    assert_eq!(verify(&bytes, &[[9; 32], *pair.pk], COUNTER), Ok(expected), "the second key");
    bytes.extend([0xFF; 300]);
    assert_eq!(verify(&bytes, &[*pair.pk], 0), Ok(expected), "a sector of flash");
    assert!(memory.state(&bytes[..expected.model_length]).is_ok() && memory.again(&bytes).is_ok());
}

#[test]
fn every_changed_byte_and_every_shorter_length_is_refused() {
    let pair = pair(1);
    let (good, keys) = (signed(&pair), [*pair.pk]);
    for place in 0..good.len() {
        let mut bytes = good.clone();
        bytes[place] ^= 1 << (place % 8);
        assert!(verify(&bytes, &keys, 0).is_err(), "byte {place}");
        assert!(verify(&good[..place], &keys, 0).is_err(), "{place} bytes");
    }
}

#[test]
fn each_refusal_has_its_code_and_the_text_of_rust() {
    let (own, other) = (pair(1), pair(2));
    let (good, key) = (signed(&own), *own.pk);
    let changed = |place: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[place] = byte;
        verify(&bytes, &[key], 0).expect_err("a change")
    };
    // Of the block behind the model: version, algorithm, reserved bytes, length, id of the key, signature.
    let block = FILE.len();
    let refusals = [
        (verify(FILE, &[key], 0), BwCode::SignatureMissing, SignatureError::Unsigned),
        (Err(changed(block + 4, 2)), BwCode::SignatureVersion, SignatureError::Version { given: 2, supported: 1 }),
        (Err(changed(block + 6, 1)), BwCode::SignatureFormat, SignatureError::Format),
        (verify(&good[..good.len() - 1], &[key], 0), BwCode::SignatureTruncated, SignatureError::Truncated),
        (verify(&good, &[*other.pk], 0), BwCode::SignatureKey, SignatureError::UnknownKey),
        (verify(&good, &[], 0), BwCode::SignatureKey, SignatureError::UnknownKey),
        (Err(changed(block + 30, !good[block + 30])), BwCode::SignatureMismatch, SignatureError::Mismatch),
        (
            verify(&good, &[key], COUNTER + 1),
            BwCode::SignatureOlder,
            SignatureError::Older { given: COUNTER, least: COUNTER + 1 },
        ),
    ];
    for (found, code, error) in refusals {
        assert_eq!(found, Err(code), "{error}");
        // SAFETY: the library gives texts that end in a zero byte.
        let text = unsafe { CStr::from_ptr(bw_error_text(code as i32)) };
        assert_eq!(text.to_str(), Ok(error.message()));
    }
    assert_eq!(changed(block, 0), BwCode::SignatureMissing, "no block");
    assert_eq!(changed(block + 5, 2), BwCode::SignatureVersion, "another algorithm");
    assert_eq!(changed(block + 16, !key[0]), BwCode::SignatureKey, "the id of another key");
    assert_eq!(changed(0, 0), BwCode::NotAModel);
    assert_eq!(changed(4, 0xFF), BwCode::ModelVersion);
    // Only the signature tells it: nothing else of the model is read.
    assert_eq!(changed(100, !good[100]), BwCode::SignatureMismatch);
    assert_eq!(verify(&good[..FILE.len() - 1], &[key], 0), Err(BwCode::ModelTruncated));
    assert_eq!(verify(&[], &[key], 0), Err(BwCode::NotAModel));
}

#[test]
fn wrong_pointers_are_refused() {
    let pair = pair(1);
    let (bytes, keys) = (signed(&pair), [*pair.pk]);
    let mut told = [UNTOUCHED; 2];
    let place = told.as_mut_ptr();
    let verify = |bytes: *const u8, length: usize, keys: *const PublicKey, place: *mut BwSigned| {
        // SAFETY: every pointer is NULL, misaligned, or that of memory that the test owns.
        unsafe { bw_verify_model(bytes, length, keys, 1, 0, place) }
    };
    assert_eq!(verify(null(), bytes.len(), keys.as_ptr(), place), BwCode::Null);
    assert_eq!(verify(bytes.as_ptr(), bytes.len(), null(), place), BwCode::Null);
    assert_eq!(verify(bytes.as_ptr(), bytes.len(), keys.as_ptr(), null_mut()), BwCode::Null);
    for byte in 1..align_of::<BwSigned>() {
        let place = place.wrapping_byte_add(byte);
        assert_eq!(verify(bytes.as_ptr(), bytes.len(), keys.as_ptr(), place), BwCode::Misaligned, "{byte}");
    }
    assert_eq!(told, [UNTOUCHED; 2]);
}

#[test]
fn the_signed_model_of_the_examples_is_that_of_their_key() {
    let pair = pair(1);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/support/standard_rig/signed.bwm");
    if env::var_os(WRITE).is_some() {
        fs::write(&path, signed(&pair)).expect("writable");
        return;
    }
    let way_out = format!("{WRITE}=1 cargo test -p bearing-watch-c --features signature --test signature");
    let committed = fs::read(&path).expect("the file is there");
    assert!(committed == signed(&pair), "the signed model is old; write it anew: {way_out}");
}
