//! A saved state is sealed and opened as in Rust: what another key has sealed, what was changed or is older is refused.
#![cfg(feature = "signature")]
#![allow(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

use core::ptr::{null, null_mut};

use bearing_watch::signature::{SEAL, StateKey};
use bearing_watch_c::*;

static KEY: [u8; BW_STATE_KEY_SIZE] = [0x5A; 32];
const STATE: [u8; 52] = [7; 52];
const UNTOUCHED: BwSealed = BwSealed { state_length: 1, sequence: 2 };

fn seal(buffer: &mut [u8], length: usize, capacity: usize, sequence: u32) -> Result<usize, BwCode> {
    assert!(capacity <= buffer.len());
    let mut sealed = 0;
    // SAFETY: the buffer has the capacity, and lives longer than the call.
    let code = unsafe { bw_seal(buffer.as_mut_ptr(), length, capacity, &raw const KEY, sequence, &raw mut sealed) };
    if code == BwCode::Ok { Ok(sealed) } else { Err(code) }
}

fn open(bytes: &[u8], key: [u8; BW_STATE_KEY_SIZE], least: u32) -> Result<BwSealed, BwCode> {
    let mut told = UNTOUCHED;
    // SAFETY: bytes and key are there for the whole call.
    let code = unsafe { bw_open(bytes.as_ptr(), bytes.len(), &raw const key, least, &raw mut told) };
    if code == BwCode::Ok {
        return Ok(told);
    }
    assert_eq!(told, UNTOUCHED, "{code:?}");
    Err(code)
}

fn sealed(sequence: u32) -> Vec<u8> {
    let mut buffer = vec![0; STATE.len() + BW_SEAL_SIZE];
    buffer[..STATE.len()].copy_from_slice(&STATE);
    let (length, capacity) = (STATE.len(), buffer.len());
    assert_eq!(seal(&mut buffer, length, capacity, sequence), Ok(capacity));
    buffer
}

#[test]
fn a_sealed_state_has_the_bytes_of_rust_and_opens() {
    assert_eq!(BW_SEAL_SIZE, SEAL);
    let mut expected = [STATE.as_slice(), &[0; SEAL]].concat();
    StateKey::new(KEY).seal(&mut expected, STATE.len(), 9).expect("room");
    assert_eq!(sealed(9), expected);
    assert_eq!(open(&expected, KEY, 9), Ok(BwSealed { state_length: STATE.len(), sequence: 9 }));
}

#[test]
fn changed_older_and_foreign_states_are_refused() {
    let good = sealed(9);
    for bit in 0..8 * good.len() {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(open(&bytes, KEY, 0).is_err(), "bit {bit}");
    }
    for length in 0..good.len() {
        assert!(open(&good[..length], KEY, 0).is_err(), "{length} bytes");
    }
    assert_eq!(open(&good, KEY, 10), Err(BwCode::SignatureOlder));
    assert_eq!(open(&good, [0x5B; 32], 0), Err(BwCode::SignatureMismatch));
    assert_eq!(open(&STATE, KEY, 0), Err(BwCode::SignatureMissing));
}

#[test]
fn small_buffers_and_wrong_pointers_are_refused() {
    let mut buffer = [3; STATE.len() + BW_SEAL_SIZE];
    for (length, capacity) in [(STATE.len() + 1, buffer.len()), (STATE.len(), buffer.len() - 1), (usize::MAX, 4)] {
        assert_eq!(seal(&mut buffer, length, capacity, 1), Err(BwCode::BufferTooSmall));
        assert_eq!(buffer, [3; STATE.len() + BW_SEAL_SIZE], "nothing is written");
    }
    let (bytes, length) = (buffer.as_mut_ptr(), buffer.len());
    let (mut size, mut told) = (0, UNTOUCHED);
    // SAFETY: every pointer is NULL or that of memory that the test owns.
    unsafe {
        assert_eq!(bw_seal(null_mut(), 1, 1, &raw const KEY, 1, &raw mut size), BwCode::Null);
        assert_eq!(bw_seal(bytes, 1, length, null(), 1, &raw mut size), BwCode::Null);
        assert_eq!(bw_seal(bytes, 1, length, &raw const KEY, 1, null_mut()), BwCode::Null);
        assert_eq!(bw_open(null(), length, &raw const KEY, 1, &raw mut told), BwCode::Null);
        assert_eq!(bw_open(bytes, length, null(), 1, &raw mut told), BwCode::Null);
        assert_eq!(bw_open(bytes, length, &raw const KEY, 1, null_mut()), BwCode::Null);
    }
    assert_eq!((size, told, buffer[0]), (0, UNTOUCHED, 3));
}
