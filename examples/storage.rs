//! Alarm and model survive power-off: a drive boots, watches, saves, loses power while it saves or takes a new model,
//! and boots again. The flash is one in RAM, so that the same file runs on the host and on a chip; on a board its
//! driver takes this place.
//!
//! ```text
//! 0x0000  two slots for the model      0x1000  two slots for the state of the alarm
//! ```
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "support/flash.rs"]
mod flash;
#[path = "support/standard_rig/mod.rs"]
mod standard_rig;

use bearing_watch::model::Label;
use bearing_watch::storage::{RecordKind, RecordLabel, SlotPair, StorageError};
use bearing_watch::{Detector, Evidence, Model};
use embedded_storage::nor_flash::NorFlashErrorKind;

use flash::Flash;
use standard_rig::model::{Drive, MODEL};

main!(run);

type Error = StorageError<NorFlashErrorKind>;

/// A slot is one sector, and a page of 64 bytes is on the stack while records are read and written.
const SLOT: u32 = 2048;
const DRIVE: Label = Label::constant("standard rig");
/// Room for the model and for the state.
const BUFFER: usize = 1792;

fn run() {
    let mut flash = Flash::new();
    if let Err(error) = lives(&mut flash) {
        say!("error: {error}");
    }
}

fn lives(flash: &mut Flash) -> Result<(), Error> {
    say!("first boot");
    let (model, mut evidence) = boot(flash)?;
    watch(&model, &mut evidence);
    save(flash, &model, &evidence)?;

    say!("second boot: continues, and loses power while it saves");
    let (model, mut evidence) = boot(flash)?;
    watch(&model, &mut evidence);
    flash.fail_after(20);
    report(save(flash, &model, &evidence));
    flash.power_up();

    say!("third boot: with the state before that, and loses power while it takes a new model");
    let (model, _) = boot(flash)?;
    let Some(newer) = trained_again(&model) else { return Ok(()) };
    flash.fail_after(100);
    report(install(flash, &newer));
    flash.power_up();

    say!("fourth boot: with the old model, then takes the new one");
    boot(flash)?;
    install(flash, &newer)?;

    say!("fifth boot: with the new model, whose evidence starts afresh");
    boot(flash)?;
    Ok(())
}

/// The model in flash, or that of the program; and the saved state, if it is of this model.
fn boot(flash: &mut Flash) -> Result<(Model<Drive>, Evidence<Drive>), Error> {
    let mut buffer = [0; BUFFER];
    let models = SlotPair::<64>::new(flash, 0, SLOT, RecordKind::Model)?;
    let found = models.load(flash, &mut buffer, |record, bytes| {
        // A model for another type of drive is not taken.
        let model = Model::from_bytes(bytes).ok().filter(|_| record.label.drive == DRIVE)?;
        Some((model, record.counter))
    });
    let model = match found {
        Ok((model, counter)) => {
            say!("  model {:08x}, record {counter}", model.id());
            model
        }
        Err(StorageError::NoRecord) => {
            say!("  no model in flash: that of the program, {:08x}", MODEL.id());
            install(flash, &MODEL)?;
            MODEL.clone()
        }
        Err(error) => return Err(error),
    };
    let mut evidence = Evidence::new(&model);
    let states = SlotPair::<64>::new(flash, 2 * SLOT, SLOT, RecordKind::State)?;
    let restored = states.load(flash, &mut buffer, |record, bytes| {
        if let Some(newer) = record.passed_over() {
            // An older state may lack an alarm: a drive tells it, and has the machine inspected.
            say!("  the newest record is not used: {newer:?}");
        }
        Some((record.counter, evidence.restore(&model, bytes)))
    });
    match restored {
        Ok((counter, Ok(()))) => say!("  state of record {counter}: {} segments", evidence.segments().0),
        Ok((counter, Err(error))) => say!("  state of record {counter}: {error}"),
        Err(StorageError::NoRecord) => say!("  no state"),
        Err(error) => return Err(error),
    }
    Ok((model, evidence))
}

/// Observes the segments of the recording.
fn watch(model: &Model<Drive>, evidence: &mut Evidence<Drive>) {
    let mut detector = Detector::new(model);
    for sample in standard_rig::samples() {
        if let Some(report) = detector.step(&sample) {
            evidence.observe(report.decision.as_ref());
        }
    }
    say!("  watched: {} segments", evidence.segments().0);
}

/// Saves the state at power-down.
fn save(flash: &mut Flash, model: &Model<Drive>, evidence: &Evidence<Drive>) -> Result<(), Error> {
    let mut buffer = [0; 256];
    let Ok(length) = evidence.save(model, &mut buffer) else { return Err(StorageError::NoRecord) };
    let states = SlotPair::<64>::new(flash, 2 * SLOT, SLOT, RecordKind::State)?;
    let label = RecordLabel { model: model.id(), drive: DRIVE };
    states.store(flash, &label, buffer.get(..length).unwrap_or_default())?;
    say!("  state of {length} bytes saved");
    Ok(())
}

fn install(flash: &mut Flash, model: &Model<Drive>) -> Result<(), Error> {
    let mut buffer = [0; BUFFER];
    let Ok(length) = model.to_bytes("", &mut buffer) else { return Err(StorageError::NoRecord) };
    let models = SlotPair::<64>::new(flash, 0, SLOT, RecordKind::Model)?;
    let label = RecordLabel { model: model.id(), drive: DRIVE };
    let record = models.store(flash, &label, buffer.get(..length).unwrap_or_default())?;
    say!("  model {:08x} of {length} bytes stored as record {}", model.id(), record.counter);
    Ok(())
}

/// The model with another cost of no decision, as another training may give.
fn trained_again(model: &Model<Drive>) -> Option<Model<Drive>> {
    let mut constants = model.constants().clone();
    constants.classifier.discriminant.reject_cost = 0.5;
    Model::new(model.plan(), constants).ok()
}

fn report(outcome: Result<(), Error>) {
    match outcome {
        Ok(()) => say!("  done"),
        Err(error) => say!("  {error}"),
    }
}
