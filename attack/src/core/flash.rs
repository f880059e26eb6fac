//! Flash of any content, whose power fails anywhere: a load gives the newest record that was stored, or none.

use bearing_watch::model::Label;
use bearing_watch::storage::{RecordKind, RecordLabel, SlotPair};

use crate::checksum;
use crate::input::Input;
use nor::Flash;

#[path = "../../../host-tests/src/flash.rs"]
mod nor;

const LABEL: RecordLabel = RecordLabel { model: 7, drive: Label::constant("drive") };
/// Longest payload.
const LONGEST: usize = 160;
/// Header of a record, with its checksum.
const HEADER: usize = 44;

/// Flashes of several geometries.
pub fn attack(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    match input.byte() % 3 {
        0 => run::<1, 1, 64, 48>(&mut input),
        1 => run::<1, 4, 128, 64>(&mut input),
        _ => run::<8, 8, 256, 64>(&mut input),
    }
}

fn run<const READ: usize, const WRITE: usize, const ERASE: usize, const PAGE: usize>(input: &mut Input<'_>) {
    let slot = 256;
    let mut flash = Flash::<READ, WRITE, ERASE>::new(2 * slot / ERASE, u64::from(input.byte()));
    let pair = SlotPair::<PAGE>::new(&flash, 0, slot as u32, RecordKind::State).expect("a geometry that fits");
    // Every payload that was handed to a store, and the one that a load must give.
    let mut stored: Vec<Vec<u8>> = Vec::new();
    let mut newest: Option<Vec<u8>> = None;
    // Whether a cut, or changed cells, may have left something else than the newest record.
    let mut disturbed = true;
    forge(&mut flash.bytes, slot, input);
    stored.extend(load(&pair, &mut flash));
    while !input.is_empty() {
        match input.byte() % 8 {
            0..=2 => {
                let payload = payload(input);
                stored.push(payload.clone());
                if pair.store(&mut flash, &LABEL, &payload).is_ok() {
                    (newest, disturbed) = (Some(payload), false);
                }
            }
            3 | 4 => {
                let payload = payload(input);
                stored.push(payload.clone());
                flash.fail_after(u64::from(input.half() % 1024));
                let outcome = pair.store(&mut flash, &LABEL, &payload);
                let failed = flash.power_up();
                assert!(outcome.is_ok() || failed || disturbed, "a store fails with the power only");
                if outcome.is_ok() {
                    (newest, disturbed) = (Some(payload), false);
                } else if !disturbed {
                    // The old record or the new one.
                    newest = either(&pair, &mut flash, newest.as_deref(), &payload);
                }
            }
            5 => {
                let place = usize::from(input.half()) % flash.bytes.len();
                flash.bytes[place] ^= input.byte();
                disturbed = true;
            }
            6 => {
                let _erased = pair.erase(&mut flash);
                (newest, disturbed) = (None, false);
                assert_eq!(pair.newest(&mut flash), Ok(None));
            }
            _ => {
                let mut short = [0; 32];
                let _short =
                    pair.load(&mut flash, &mut short, |record, bytes| (record.length > 3).then_some(bytes.len()));
            }
        }
        let found = load(&pair, &mut flash);
        match &found {
            Some(bytes) => assert!(stored.contains(bytes), "what is loaded was stored"),
            None => assert!(disturbed || newest.is_none(), "a stored record is loaded"),
        }
        assert!(disturbed || found == newest, "the newest record is loaded");
    }
}

fn payload(input: &mut Input<'_>) -> Vec<u8> {
    let length = usize::from(input.byte()) % LONGEST;
    input.bytes(length).to_vec()
}

/// Puts a record of any length and counter into a slot, as a rule under right checksums.
fn forge(cells: &mut [u8], slot: usize, input: &mut Input<'_>) {
    let kind = input.byte();
    if kind.is_multiple_of(2) {
        return;
    }
    let start = if kind & 2 == 0 { 0 } else { slot };
    let mut header = [0; HEADER];
    header[..6].copy_from_slice(b"BWSL\x01\x02");
    header[8..16].copy_from_slice(&input.array::<8>());
    if kind & 4 == 0 {
        header[12..16].copy_from_slice(&u32::from(input.byte()).to_le_bytes());
    }
    for _ in 0..kind >> 6 {
        header[usize::from(input.byte()) % HEADER] = input.byte();
    }
    checksum::put(&mut header);
    cells[start..start + HEADER].copy_from_slice(&header);
}

fn load<const READ: usize, const WRITE: usize, const ERASE: usize, const PAGE: usize>(
    pair: &SlotPair<PAGE>,
    flash: &mut Flash<READ, WRITE, ERASE>,
) -> Option<Vec<u8>> {
    pair.load(flash, &mut [0; 256], |record, bytes| {
        assert_eq!(record.length as usize, bytes.len());
        Some(bytes.to_vec())
    })
    .ok()
}

/// What is there after a cut: the old record or the new one.
fn either<const READ: usize, const WRITE: usize, const ERASE: usize, const PAGE: usize>(
    pair: &SlotPair<PAGE>,
    flash: &mut Flash<READ, WRITE, ERASE>,
    old: Option<&[u8]>,
    new: &[u8],
) -> Option<Vec<u8>> {
    let found = load(pair, flash);
    assert!(found.as_deref() == old || found.as_deref() == Some(new), "a cut leaves the old record or the new one");
    found
}
