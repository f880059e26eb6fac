//! Two slots of a flash in RAM: which record serves, what it says of the other slot, and what a failing store leaves.

#[path = "../../examples/support/flash.rs"]
mod flash;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use super::*;
use crate::model::Label;
use flash::Flash;

const SLOT: u32 = 2048;
const LABEL: RecordLabel = RecordLabel { model: 5, drive: Label::constant("rig") };
/// More than a page, and no multiple of a word.
const OLD: [u8; 101] = [1; 101];
const NEW: [u8; 150] = [2; 150];

fn pair(flash: &Flash, kind: RecordKind) -> SlotPair<64> {
    SlotPair::new(flash, 2 * SLOT, SLOT, kind).unwrap()
}

/// A flash with two records: the first slot has the older one.
fn two() -> (Flash, SlotPair<64>) {
    let mut flash = Flash::new();
    let pair = pair(&flash, RecordKind::State);
    for (payload, counter) in [(&OLD[..], 1), (&NEW[..], 2)] {
        assert_eq!(pair.store(&mut flash, &LABEL, payload).unwrap().counter, counter);
    }
    (flash, pair)
}

/// First byte and length of the record that serves, its number, and what it passes over.
fn loaded(flash: &mut Flash, pair: &SlotPair<64>) -> Option<(u8, usize, u32, Option<PassedOver>)> {
    let take = |record: &Record, bytes: &[u8]| Some((bytes[0], bytes.len(), record.counter, record.passed_over()));
    pair.load(flash, &mut [0; 256], take).ok()
}

/// Clears a word of a slot.
fn damage(flash: &mut Flash, second: bool, index: u32) {
    flash.write(2 * SLOT + if second { SLOT } else { 0 } + index, &[0; 4]).unwrap();
}

#[test]
fn the_newest_record_serves_and_each_store_replaces_the_older_one() {
    let (mut flash, pair) = two();
    assert_eq!(loaded(&mut flash, &pair), Some((2, 150, 2, None)));
    assert_eq!(pair.newest(&mut flash).unwrap().map(|record| (record.counter, record.label)), Some((2, LABEL)));
    let mut second = [0; 4];
    pair.store(&mut flash, &LABEL, &[3; 9]).unwrap();
    assert_eq!(loaded(&mut flash, &pair), Some((3, 9, 3, None)));
    // The payload of the second record is where it was.
    flash.read(3 * SLOT + 60, &mut second).unwrap();
    assert_eq!(second, [2; 4]);
    pair.erase(&mut flash).unwrap();
    assert_eq!((loaded(&mut flash, &pair), pair.newest(&mut flash).unwrap()), (None, None));
}

#[test]
fn a_damaged_newer_record_is_told_with_its_number() {
    // In the payload, at its last bytes, and in the header.
    for (index, passed_over) in
        [(80, PassedOver::Damaged { counter: 2 }), (180, PassedOver::Damaged { counter: 2 }), (8, PassedOver::Unknown)]
    {
        let (mut flash, pair) = two();
        damage(&mut flash, true, index);
        assert_eq!(loaded(&mut flash, &pair), Some((1, 101, 1, Some(passed_over))), "{index}");
        assert_eq!(pair.newest(&mut flash).unwrap().and_then(|record| record.passed_over()), Some(passed_over));
        // The next store replaces the damaged one, and nothing is passed over.
        pair.store(&mut flash, &LABEL, &[3; 9]).unwrap();
        assert_eq!(loaded(&mut flash, &pair), Some((3, 9, 2, None)), "{index}");
    }
    // An older one that is damaged hides nothing.
    let (mut flash, pair) = two();
    damage(&mut flash, false, 80);
    assert_eq!(loaded(&mut flash, &pair), Some((2, 150, 2, None)));
}

#[test]
fn a_refused_newer_record_is_told_to_who_gets_the_older_one() {
    let (mut flash, pair) = two();
    let older = |record: &Record, bytes: &[u8]| (bytes[0] == 1).then_some((record.counter, record.passed_over()));
    let loaded = pair.load(&mut flash, &mut [0; 256], older);
    assert_eq!(loaded, Ok((1, Some(PassedOver::Refused { counter: 2 }))));
    assert_eq!(pair.load(&mut flash, &mut [0; 256], |_, _| None::<()>), Err(StorageError::NoRecord));
    assert_eq!(
        pair.load(&mut flash, &mut [0; 149], |_, bytes| (bytes[0] == 2).then_some(())),
        Err(StorageError::BufferTooSmall { needed: 150 })
    );
}

#[test]
fn records_of_another_kind_are_none_and_hide_none() {
    let (mut flash, states) = two();
    let models = pair(&flash, RecordKind::Model);
    assert_eq!((models.newest(&mut flash).unwrap(), loaded(&mut flash, &models)), (None, None));
    models.store(&mut flash, &LABEL, &[7; 4]).unwrap();
    assert_eq!(loaded(&mut flash, &models), Some((7, 4, 1, None)));
    assert_eq!(loaded(&mut flash, &states), Some((2, 150, 2, None)));
}

#[test]
fn a_store_without_power_leaves_the_record_before_it() {
    // 150 bytes of payload are 38 words, and the header 11.
    for words in 0..49 {
        let (mut flash, pair) = two();
        flash.fail_after(words);
        assert!(pair.store(&mut flash, &LABEL, &[3; 150]).is_err(), "{words}");
        flash.power_up();
        let Some((2, 150, 2, passed_over)) = loaded(&mut flash, &pair) else { panic!("{words} words") };
        // Words of the payload without a header look erased; a header that has begun is no header.
        assert_eq!(passed_over, (words > 38).then_some(PassedOver::Unknown), "{words}");
    }
    let (mut flash, pair) = two();
    flash.fail_after(49);
    assert_eq!(pair.store(&mut flash, &LABEL, &[3; 150]).unwrap().counter, 3);
}

#[test]
fn what_does_not_fit_is_refused() {
    let (mut flash, pair) = two();
    let capacity = pair.capacity::<Flash>();
    assert!((2000..2048).contains(&capacity));
    let long = [4; 2048];
    assert_eq!(
        pair.store(&mut flash, &LABEL, &long[..=capacity]),
        Err(StorageError::TooLong { capacity: u32::try_from(capacity).unwrap() })
    );
    assert_eq!(loaded(&mut flash, &pair), Some((2, 150, 2, None)));
    assert!(pair.store(&mut flash, &LABEL, &long[..capacity]).is_ok());
    for (start, slot) in [(1024, SLOT), (0, 1024), (0, 3 * SLOT), (3 * SLOT, SLOT), (u32::MAX - 2047, SLOT)] {
        let refused = SlotPair::<64>::new(&flash, start, slot, RecordKind::State).err();
        assert_eq!(refused, Some(StorageError::Geometry), "{start} {slot}");
    }
    assert!(SlotPair::<40>::new(&flash, 0, SLOT, RecordKind::State).is_err(), "a page shorter than a header");
}

/// The words that a store of 150 bytes writes: 38 of its payload, and 11 of the header.
const WORDS: u32 = 49;

#[test]
fn a_prepared_store_only_writes() {
    let (mut flash, pair) = two();
    assert_eq!((pair.prepare(&mut flash), pair.prepare(&mut flash)), (Ok(true), Ok(false)));
    assert_eq!(loaded(&mut flash, &pair), Some((2, 150, 2, None)), "the newest record is there");
    let before = flash.erasures();
    assert_eq!(pair.store(&mut flash, &LABEL, &[3; 150]).unwrap().counter, 3);
    assert_eq!((flash.erasures(), loaded(&mut flash, &pair)), (before, Some((3, 150, 3, None))));
    // The other slot is not prepared, and a slot that is written is none.
    assert_eq!(pair.store(&mut flash, &LABEL, &[4; 150]).unwrap().counter, 4);
    assert_eq!(flash.erasures(), before + 1);
    assert_eq!(pair.prepare(&mut flash), Ok(true));
    // A payload as long as the slot has no room for the mark.
    let long = [5; 2048];
    pair.store(&mut flash, &LABEL, &long[..pair.capacity::<Flash>()]).unwrap();
    assert_eq!(flash.erasures(), before + 3);
    assert_eq!(pair.newest(&mut flash).unwrap().map(|record| record.counter), Some(5));
    // An empty pair may be prepared, too.
    pair.erase(&mut flash).unwrap();
    assert_eq!(pair.prepare(&mut flash), Ok(true));
    let before = flash.erasures();
    pair.store(&mut flash, &LABEL, &[6; 9]).unwrap();
    assert_eq!((flash.erasures(), loaded(&mut flash, &pair)), (before, Some((6, 9, 1, None))));
}

#[test]
fn an_erasure_that_was_cut_off_or_a_store_into_it_is_erased_again() {
    let (mut flash, pair) = two();
    flash.fail_after(0);
    assert!(pair.prepare(&mut flash).is_err(), "no mark");
    flash.power_up();
    let before = flash.erasures();
    pair.store(&mut flash, &LABEL, &[3; 150]).unwrap();
    assert_eq!(flash.erasures(), before + 1, "cells without a mark are not trusted");
    for words in 0..WORDS {
        let (mut flash, pair) = two();
        pair.prepare(&mut flash).unwrap();
        flash.fail_after(words);
        assert!(pair.store(&mut flash, &LABEL, &[3; 150]).is_err(), "{words}");
        flash.power_up();
        assert!(matches!(loaded(&mut flash, &pair), Some((2, 150, 2, _))), "{words}");
        assert_eq!(pair.store(&mut flash, &LABEL, &[4; 150]).unwrap().counter, 3, "{words}");
        assert_eq!(loaded(&mut flash, &pair), Some((4, 150, 3, None)), "{words}");
    }
}
