//! Records in flash: power that fails at every byte of an update, sizes of flashes, and what is refused.

use bearing_watch::model::Label;
use bearing_watch::storage::{Record, RecordKind, RecordLabel, SlotPair, StorageError};
use bearing_watch::{Evidence, Model};
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind};
use host_tests::flash::Flash;

use super::saved::evidence_after;
use crate::exported::{Drive, MODEL};

const DRIVE: Label = Label::constant("standard rig");
/// Number of power cuts of the long test.
const CUTS: usize = 10_000;

/// What a drive stores: two models in turn, and the state of the alarm.
struct Stored<const PAGE: usize> {
    models: SlotPair<PAGE>,
    states: SlotPair<PAGE>,
}

impl<const PAGE: usize> Stored<PAGE> {
    /// Both pairs one after the other, each slot so long.
    fn new<F: NorFlash<Error = NorFlashErrorKind>>(flash: &F, slot_bytes: u32) -> Self {
        let pair = |start, kind| SlotPair::new(flash, start, slot_bytes, kind).expect("fits");
        Self { models: pair(0, RecordKind::Model), states: pair(2 * slot_bytes, RecordKind::State) }
    }
}

/// The model's binary form with other costs.
fn model(cost: f32) -> (Model<Drive>, Vec<u8>) {
    let mut constants = MODEL.constants().clone();
    constants.classifier.discriminant.costs[1] = cost;
    let model = Model::new(MODEL.plan(), constants).expect("a good model");
    let mut bytes = vec![0; 4096];
    let length = model.to_bytes("", &mut bytes).expect("fits");
    bytes.truncate(length);
    (model, bytes)
}

fn saved(model: &Model<Drive>, evidence: &Evidence<Drive>) -> Vec<u8> {
    let mut bytes = vec![0; Evidence::saved_len(model)];
    assert_eq!(evidence.save(model, &mut bytes), Ok(bytes.len()));
    bytes
}

/// What is stored, byte by byte.
fn load<F: NorFlash<Error = NorFlashErrorKind>, const PAGE: usize>(
    pair: &SlotPair<PAGE>,
    flash: &mut F,
) -> (Record, Vec<u8>) {
    let mut buffer = [0; 4096];
    pair.load(flash, &mut buffer, |record, bytes| Some((*record, bytes.to_vec()))).expect("a record is always there")
}

/// Cuts the power of updates of model and state in turn, each `stride` bytes later than the one before; returns how
/// often the old and the new record was found.
fn cuts<const READ: usize, const WRITE: usize, const ERASE: usize, const PAGE: usize>(
    count: usize,
    stride: u64,
) -> [usize; 2] {
    let slot = 2048.max(ERASE as u32);
    let mut flash = Flash::<READ, WRITE, ERASE>::new(4 * slot as usize / ERASE, 7);
    let stored = Stored::<PAGE>::new(&flash, slot);
    let models = [model(1.0), model(2.0)];
    let states = [3, 30].map(|segments| saved(&models[0].0, &evidence_after(&models[0].0, segments)));
    let label = RecordLabel { model: 1, drive: DRIVE };
    stored.models.store(&mut flash, &label, &models[0].1).expect("stores");
    stored.states.store(&mut flash, &label, &states[0]).expect("stores");
    // Neither the newest record nor the one that is begun depends on what earlier cuts left.
    let (mut found, mut at) = ([0; 2], [0; 2]);
    for cut in 0..count {
        let which = cut % 2;
        let (pair, kinds) = match which {
            0 => (&stored.models, [&models[0].1, &models[1].1]),
            _ => (&stored.states, [&states[0], &states[1]]),
        };
        let (before, old) = load(pair, &mut flash);
        let new = if old == *kinds[0] { kinds[1] } else { kinds[0] };
        flash.fail_after(at[which]);
        let outcome = pair.store(&mut flash, &label, new);
        let failed = flash.power_up();
        // Once an update ends before the cut, the cuts start again at the first byte.
        at[which] = if failed { at[which] + stride } else { 0 };
        let (after, bytes) = load(pair, &mut flash);
        let is_new = bytes == *new;
        assert!(is_new || (bytes == old && after == before), "cut {cut} at {at:?}");
        assert!(is_new || failed, "cut {cut} at {at:?}");
        assert!(outcome.is_err() || (is_new && after.counter == before.counter.wrapping_add(1)));
        found[usize::from(is_new)] += 1;
        // Both boot, whatever happened to one.
        let booted = stored.models.load(&mut flash, &mut [0; 4096], |_, bytes| Model::<Drive>::from_bytes(bytes).ok());
        let booted = booted.expect("a model");
        assert!(booted == models[0].0 || booted == models[1].0);
        let (_, state) = load(&stored.states, &mut flash);
        let mut evidence = Evidence::new(&models[0].0);
        evidence.restore(&models[0].0, &state).expect("a state");
        assert!([3, 30].contains(&evidence.segments().0));
    }
    found
}

#[test]
fn power_that_fails_at_any_byte_leaves_the_old_record_or_the_new_one() {
    // Byte-wise flash of small sectors; words and sectors of an STM32F4; of an STM32H7; of an STM32G4.
    let found = [
        cuts::<1, 1, 256, 48>(CUTS, 1),
        cuts::<1, 4, 16384, 64>(CUTS / 5, 37),
        cuts::<1, 32, 2048, 256>(CUTS / 5, 7),
        cuts::<8, 8, 2048, 64>(CUTS / 5, 7),
    ];
    println!("old and new records after the cuts: {found:?}");
    for [old, new] in found {
        assert!(old > 10 && new > 0, "{found:?}");
    }
}

#[test]
fn updates_alternate_and_erase_one_slot_once() {
    let mut flash = Flash::<1, 4, 512>::new(8, 3);
    let pair = SlotPair::<64>::new(&flash, 1024, 1024, RecordKind::Model).expect("fits");
    assert_eq!(pair.newest(&mut flash), Ok(None));
    for counter in 1..=6 {
        let label = RecordLabel { model: counter, drive: DRIVE };
        let record = pair.store(&mut flash, &label, &[counter as u8; 600]).expect("stores");
        assert_eq!((record.counter, record.length, record.label), (counter, 600, label));
        assert_eq!(pair.newest(&mut flash), Ok(Some(record)));
    }
    assert_eq!(flash.erasures, [0, 0, 3, 3, 3, 3, 0, 0]);
    // A short record erases no more than it needs.
    let label = RecordLabel { model: 7, drive: DRIVE };
    pair.store(&mut flash, &label, b"short").expect("stores");
    assert_eq!(flash.erasures, [0, 0, 4, 3, 3, 3, 0, 0]);
    assert_eq!(load(&pair, &mut flash).1, b"short");
}

#[test]
fn lengths_up_to_the_capacity_are_read_back() {
    let mut flash = Flash::<2, 8, 128>::new(8, 5);
    let pair = SlotPair::<56>::new(&flash, 0, 384, RecordKind::State).expect("fits");
    // 384 bytes less a header of 44, rounded up to 48.
    assert_eq!(pair.capacity::<Flash<2, 8, 128>>(), 336);
    let label = RecordLabel { model: 1, drive: DRIVE };
    for length in [0, 1, 7, 8, 9, 47, 48, 49, 55, 56, 57, 200, 335, 336] {
        let payload: Vec<u8> = (0..length).map(|k| (k * 7 + length) as u8).collect();
        pair.store(&mut flash, &label, &payload).expect("stores");
        assert_eq!(load(&pair, &mut flash).1, payload, "{length}");
    }
    assert_eq!(pair.store(&mut flash, &label, &[0; 337]), Err(StorageError::TooLong { capacity: 336 }));
}

#[test]
fn nothing_is_erased_if_the_flash_cannot_be_read() {
    let mut flash = Flash::<1, 1, 64>::new(8, 9);
    let pair = SlotPair::<64>::new(&flash, 0, 256, RecordKind::Model).expect("fits");
    let label = RecordLabel { model: 1, drive: DRIVE };
    pair.store(&mut flash, &label, b"kept").expect("stores");
    flash.fail_after(0);
    assert_eq!(pair.newest(&mut flash), Err(StorageError::Flash(NorFlashErrorKind::Other)));
    assert_eq!(pair.store(&mut flash, &label, b"lost"), Err(StorageError::Flash(NorFlashErrorKind::Other)));
    assert!(flash.power_up());
    assert_eq!(load(&pair, &mut flash).1, b"kept");
}

#[test]
fn slots_that_do_not_fit_are_refused() {
    let flash = Flash::<1, 8, 256>::new(4, 1);
    let refused = |start, slot| SlotPair::<64>::new(&flash, start, slot, RecordKind::Model).is_err();
    assert!(!refused(0, 512) && !refused(512, 256));
    for (start, slot) in [(1, 256), (0, 255), (0, 768), (1024, 256), (0, 0), (u32::MAX - 255, 256), (256, 512)] {
        assert!(refused(start, slot), "{start} {slot}");
    }
    // A page shorter than a header, or than a write.
    assert!(SlotPair::<47>::new(&flash, 0, 256, RecordKind::Model).is_err());
    let wide = Flash::<1, 64, 256>::new(4, 1);
    assert!(SlotPair::<48>::new(&wide, 0, 256, RecordKind::Model).is_err());
    // Sizes that are no multiples of each other.
    let odd = Flash::<3, 4, 256>::new(4, 1);
    assert!(SlotPair::<64>::new(&odd, 0, 256, RecordKind::Model).is_err());
}

#[test]
fn flash_that_takes_nothing_is_an_error_and_keeps_the_record() {
    /// A flash whose upper half is worn out: bits stay erased.
    #[derive(Clone)]
    struct Worn(Flash<1, 4, 256>);
    use embedded_storage::nor_flash::{ErrorType, ReadNorFlash};
    impl ErrorType for Worn {
        type Error = NorFlashErrorKind;
    }
    impl ReadNorFlash for Worn {
        const READ_SIZE: usize = 1;
        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
            self.0.read(offset, bytes)
        }
        fn capacity(&self) -> usize {
            self.0.capacity()
        }
    }
    impl NorFlash for Worn {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 256;
        fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
            self.0.erase(from, to)
        }
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
            if offset < 256 { self.0.write(offset, bytes) } else { Ok(()) }
        }
    }
    let mut flash = Worn(Flash::new(2, 1));
    let pair = SlotPair::<64>::new(&flash, 0, 256, RecordKind::State).expect("fits");
    let label = RecordLabel { model: 1, drive: DRIVE };
    pair.store(&mut flash, &label, b"first").expect("stores");
    for _ in 0..3 {
        assert_eq!(pair.store(&mut flash, &label, b"second"), Err(StorageError::NotWritten));
        assert_eq!(load(&pair, &mut flash).1, b"first");
    }
}
