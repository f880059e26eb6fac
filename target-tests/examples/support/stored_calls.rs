//! Calls of the storage and of signatures for the example `panic_free`, which is too long for them.

use core::fmt;
use core::hint::black_box as opaque;

use bearing_watch::model::Label;
use bearing_watch::signature::{SignatureError, StateKey, Trust, head, key_id};
use bearing_watch::storage::{Record, RecordKind, RecordLabel, SlotPair, StorageError};
use embedded_storage::nor_flash::NorFlashErrorKind;

use super::flash::Flash;

/// Every public function of the storage; `show` writes an error.
pub fn storage(mut show: impl FnMut(&dyn fmt::Display)) {
    let mut flash = Flash::new();
    Flash::power_up(&mut flash);
    Flash::fail_after(&mut flash, opaque(100_000));
    for kind in opaque([RecordKind::Model, RecordKind::State]) {
        match SlotPair::<64>::new(&flash, opaque(0), opaque(2048), kind) {
            Ok(pair) => calls(opaque(pair), &mut flash, &mut show),
            Err(error) => show(&error),
        }
    }
}

fn calls(pair: SlotPair<64>, flash: &mut Flash, show: &mut impl FnMut(&dyn fmt::Display)) {
    let label = opaque(RecordLabel { model: 7, drive: Label::constant("drive") });
    let (payload, mut buffer) = (opaque([1; 300]), opaque([0; 400]));
    opaque(SlotPair::capacity::<Flash>(&pair));
    opaque(SlotPair::prepare(&pair, flash).is_ok());
    let stored = SlotPair::store(&pair, flash, &label, payload.get(..opaque(200)).unwrap_or_default());
    let newest = opaque(SlotPair::newest(&pair, flash));
    opaque(newest.as_ref().ok().copied().flatten().and_then(|record| Record::passed_over(&record)));
    let loaded =
        SlotPair::load(&pair, flash, &mut buffer, |record, bytes| opaque(record.label == label).then_some(bytes.len()));
    for error in [stored.err(), newest.err(), loaded.err(), SlotPair::erase(&pair, flash).err()].into_iter().flatten() {
        opaque(StorageError::<NorFlashErrorKind>::message(&error));
        show(&error);
    }
}

/// Every public function of signatures but `Trust::verify`; `show` writes an error. The crate that verifies indexes
/// arrays, which the compiler cannot prove. All around its arithmetic is here: `Trust::verify` is
/// `Trust::verify_with` by that crate.
pub fn signatures(mut show: impl FnMut(&dyn fmt::Display)) {
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
