//! Calls of signatures for the example `panic_free`, which is too long for them.

use core::fmt;
use core::hint::black_box as opaque;

use bearing_watch::signature::{SignatureError, StateKey, Trust, head, key_id};

/// Every public function; `show` writes an error.
pub fn run(mut show: impl FnMut(&dyn fmt::Display)) {
    let mut bytes = opaque([0x42; 400]);
    let keys = opaque([[7; 32], [8; 32]]);
    opaque(key_id(opaque(&keys[0])));
    opaque(head(opaque(100), opaque(&keys[1]), opaque(3)));
    let trust = opaque(Trust { keys: &keys, least_counter: 3 });
    let verified = Trust::verify(&trust, bytes.get(..opaque(300)).unwrap_or_default()).map(|signed| signed.counter);
    let key = opaque(StateKey::new(opaque([9; 32])));
    let sealed = StateKey::seal(&key, &mut bytes, opaque(200), opaque(5));
    let opened =
        StateKey::open(&key, bytes.get(..opaque(248)).unwrap_or_default(), opaque(5)).map(|sealed| sealed.sequence);
    for error in [verified.err(), sealed.err(), opened.err()].into_iter().flatten() {
        opaque(SignatureError::message(&error));
        show(&error);
    }
}
