//! Calls of signatures for the example `panic_free`, which is too long for them. `Trust::verify` is not among them: the
//! crate that verifies indexes arrays, which the compiler cannot prove. All around its arithmetic is: `Trust::verify`
//! is `Trust::verify_with` by that crate.

use core::fmt;
use core::hint::black_box as opaque;

use bearing_watch::signature::{SignatureError, StateKey, Trust, head, key_id};

/// Every other public function; `show` writes an error.
pub fn run(mut show: impl FnMut(&dyn fmt::Display)) {
    let mut bytes = opaque([0x42; 400]);
    let keys = opaque([[7; 32], [8; 32]]);
    opaque(key_id(opaque(&keys[0])));
    opaque(head(opaque(100), opaque(&keys[1]), opaque(3)));
    let key = opaque(StateKey::new(opaque([9; 32])));
    let sealed = StateKey::seal(&key, &mut bytes, opaque(200), opaque(5));
    let opened =
        StateKey::open(&key, bytes.get(..opaque(248)).unwrap_or_default(), opaque(5)).map(|sealed| sealed.sequence);
    let trust = opaque(Trust { keys: &keys, least_counter: opaque(2) });
    let verified =
        Trust::verify_with(&trust, &bytes, |key, message, signature| opaque((key, message, signature)).1.len() > 3);
    for error in [sealed.err(), opened.err(), verified.err()].into_iter().flatten() {
        opaque(SignatureError::message(&error));
        show(&error);
    }
}
