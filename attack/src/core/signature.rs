//! Signed models and sealed states of any bytes: what is accepted is what the key has signed, and not older than asked.

use std::sync::LazyLock;

use bearing_watch::signature::{BLOCK, HEAD, PublicKey, SEAL, SignatureError, Signed, StateKey, Trust, head, key_id};
use bearing_watch_c::{BwCode, BwSigned, bw_verify_model};
use ed25519_compact::{KeyPair, Seed};

use crate::input::Input;
use crate::models::BYTES;

const COUNTER: u32 = 1000;
const STATE: [u8; 40] = [0x37; 40];
const KEY: StateKey = StateKey::new([9; 32]);

/// A signed model, its key, and a sealed state.
struct Good {
    key: PublicKey,
    model: Vec<u8>,
    state: Vec<u8>,
}

static GOOD: LazyLock<Good> = LazyLock::new(|| {
    let pair = KeyPair::from_seed(Seed::new([3; 32]));
    let mut model = BYTES[0].clone();
    model.extend(head(model.len() as u32, &pair.pk, COUNTER));
    model.extend(*pair.sk.sign(&model, None));
    let mut state = STATE.to_vec();
    state.resize(STATE.len() + SEAL, 0);
    KEY.seal(&mut state, STATE.len(), COUNTER).expect("a buffer that fits");
    Good { key: *pair.pk, model, state }
});

/// Bytes of either kind.
pub fn attack(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    match input.byte() % 8 {
        0 => {
            let any = input.bytes(usize::MAX);
            model(any, &[GOOD.key], 0);
            state(any, 0);
        }
        1 => forged(&mut input),
        2 | 3 => {
            let (changed, least) = (changed(&GOOD.model, &mut input), least(&mut input));
            model(&changed, &[GOOD.key, [0; 32]], least);
        }
        4 => keys(&mut input),
        _ => {
            let (changed, least) = (changed(&GOOD.state, &mut input), least(&mut input));
            state(&changed, least);
        }
    }
}

/// A model with a right head, of any key, before any signature.
fn forged(input: &mut Input<'_>) {
    let key = if input.byte().is_multiple_of(2) { GOOD.key } else { input.array() };
    let mut bytes = BYTES[input.below(BYTES.len())].clone();
    bytes.extend(head(bytes.len() as u32, &key, input.word()));
    bytes.extend(input.array::<{ BLOCK - HEAD }>());
    model(&bytes, &[key, GOOD.key], 0);
}

/// Good bytes under keys of any bits, as a rule with the id of the good one.
fn keys(input: &mut Input<'_>) {
    let mut key: PublicKey = input.array();
    if input.byte() < 200 {
        key[..8].copy_from_slice(&key_id(&GOOD.key));
    }
    model(&GOOD.model, &[key], 0);
}

fn least(input: &mut Input<'_>) -> u32 {
    match input.byte() % 4 {
        0 => COUNTER,
        1 => COUNTER + 1,
        2 => input.word(),
        _ => 0,
    }
}

/// Good bytes with up to seven changes, cut short or continued.
fn changed(good: &[u8], input: &mut Input<'_>) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..input.byte() % 8 {
        // More of them at the end, where the signature is.
        let place = usize::from(input.half()) % bytes.len();
        let place = if input.byte().is_multiple_of(2) { place } else { bytes.len() - 1 - place % 88.min(bytes.len()) };
        bytes[place] = input.byte();
    }
    match input.byte() % 8 {
        0 => bytes.truncate(usize::from(input.half()) % (good.len() + 1)),
        1 => bytes.extend(input.bytes(16)),
        _ => {}
    }
    bytes
}

fn model(bytes: &[u8], keys: &[PublicKey], least_counter: u32) {
    in_c(bytes, keys, least_counter);
    let good = &GOOD.model;
    let is_good = bytes.get(..good.len()) == Some(good) && keys.contains(&GOOD.key);
    match (Trust { keys, least_counter }).verify(bytes) {
        Ok(signed) => {
            assert!(is_good && least_counter <= COUNTER, "only what was signed, and not older");
            assert_eq!((signed.counter, signed.length), (COUNTER, good.len()));
            assert_eq!(signed.model, &good[..good.len() - BLOCK]);
        }
        Err(SignatureError::Older { given, least }) => {
            assert!(is_good && (given, least) == (COUNTER, least_counter) && given < least);
        }
        Err(error) => assert!(!is_good, "{error}"),
    }
}

/// The C interface says the same, and writes nothing with a refusal.
fn in_c(bytes: &[u8], keys: &[PublicKey], least_counter: u32) {
    let untouched = BwSigned { model_length: 1, length: 2, counter: 3 };
    let mut told = untouched;
    // SAFETY: bytes and keys are there for the whole call, and the place is writable.
    let code = unsafe {
        bw_verify_model(bytes.as_ptr(), bytes.len(), keys.as_ptr(), keys.len(), least_counter, &raw mut told)
    };
    match (Trust { keys, least_counter }).verify(bytes) {
        Ok(Signed { model, length, counter }) => {
            assert_eq!((code, told), (BwCode::Ok, BwSigned { model_length: model.len(), length, counter }));
        }
        Err(error) => assert_eq!((code, told), (error.into(), untouched)),
    }
}

fn state(bytes: &[u8], least: u32) {
    let is_good = bytes == GOOD.state;
    match KEY.open(bytes, least) {
        Ok(sealed) => {
            assert!(is_good && least <= COUNTER);
            assert_eq!((sealed.state, sealed.sequence), (&STATE[..], COUNTER));
        }
        Err(SignatureError::Older { .. }) => assert!(is_good && least > COUNTER),
        Err(error) => assert!(!is_good, "{error}"),
    }
}
