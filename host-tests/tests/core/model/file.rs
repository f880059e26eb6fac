//! The binary model: what is written is read back, and nothing altered passes.

use bearing_watch::drive::RotorFrame;
use bearing_watch::model::{Field, layout, notes, stored_len};
use bearing_watch::plan::{Plan, RunTime, RunTimeSample};
use bearing_watch::{Angle, Detector, Model, ModelError, Park};
use proptest::prelude::*;

use crate::exported::{Drive, MODEL, Sample};

static FILE: &[u8] = include_bytes!("../../../../examples/support/standard_rig/model.bwm");

/// Reads the bytes as a drive does.
fn read(bytes: &[u8]) -> Result<Model<Drive>, ModelError> {
    Model::from_bytes(bytes)
}

#[test]
fn binary_and_rust_exports_are_the_same_model() {
    let model = read(FILE).expect("good model");
    assert_eq!(model, MODEL);
    assert_eq!(layout(FILE), Ok(Drive.layout()));
    let notes = notes(FILE).expect("notes");
    assert!(notes.contains("velocity_ref_rad_s"), "{notes}");
    let mut buffer = vec![0; FILE.len()];
    let length = model.to_bytes(notes, &mut buffer).expect("fits");
    assert_eq!(&buffer[..length], FILE);
    assert_eq!(model.to_bytes(notes, &mut buffer[..FILE.len() - 1]), Err(ModelError::BufferTooSmall));
}

#[test]
fn the_convention_of_the_current_is_kept_and_another_one_refused() {
    let mut buffer = vec![0; FILE.len() + 64];
    for park in [None, Some(Park::Standard), Some(Park::Thesis)] {
        let mut constants = MODEL.constants().clone();
        constants.sampling.park = park;
        let length = Model::new(Drive, constants).expect("good model").to_bytes("", &mut buffer).expect("fits");
        let model = read(&buffer[..length]).expect("good model");
        assert_eq!(model.constants().sampling.park, park);
        for given in [Park::Standard, Park::Thesis] {
            let frame = RotorFrame { pole_pairs: 4, electrical_offset: Angle::from_bits(0), park: given };
            let refused = park.filter(|trained| *trained != given);
            let expected = refused.map_or(Ok(()), |trained| Err(ModelError::Park { trained, given }));
            assert_eq!(model.check_rotor_frame(&frame), expected);
        }
    }
}

#[test]
fn the_id_is_that_of_the_numbers() {
    assert_eq!(read(FILE).expect("good model").id(), MODEL.id());
    assert_eq!(Model::<RunTime>::from_bytes(FILE).expect("good model").id(), MODEL.id());
    let mut constants = MODEL.constants().clone();
    constants.classifier.discriminant.reject_cost = 0.5;
    assert_ne!(Model::new(Drive, constants).expect("good model").id(), MODEL.id());
}

#[test]
fn another_sampling_interval_is_refused_where_both_are_known() {
    for (interval_s, good) in [(0.002, true), (0.00199, true), (0.00202, true), (0.0, true), (-1.0, true)]
        .into_iter()
        .chain([(0.00197, false), (0.00203, false), (0.001, false), (0.004, false), (f32::NAN, false)])
    {
        let found = MODEL.check_interval(interval_s);
        let refused = matches!(found, Err(ModelError::Interval { trained_s: 0.002, .. }));
        assert_eq!((found.is_ok(), refused), (good, !good), "{interval_s}");
    }
    let mut constants = MODEL.constants().clone();
    constants.sampling.interval_s = 0.0;
    assert_eq!(Model::new(Drive, constants).expect("good model").check_interval(0.004), Ok(()));
}

#[test]
fn every_corrupted_byte_is_found() {
    for place in 0..FILE.len() {
        for change in (0..8).map(|bit| 1 << bit).chain([0xFF, 0x55]) {
            let mut bytes = FILE.to_vec();
            bytes[place] ^= change;
            assert!(read(&bytes).is_err(), "byte {place} ^ {change:#x}");
            assert!(Model::<RunTime>::from_bytes(&bytes).is_err(), "byte {place} ^ {change:#x}");
            assert!(notes(&bytes).is_err() && layout(&bytes).is_err(), "byte {place} ^ {change:#x}");
        }
    }
}

#[test]
fn truncation_extension_other_versions_and_other_files_are_told_apart() {
    for length in 0..FILE.len() {
        assert!(read(&FILE[..length]).is_err(), "{length} bytes");
    }
    let longer = [FILE, &[0]].concat();
    assert_eq!(read(&longer), Err(ModelError::Truncated));
    let mut flagged = FILE.to_vec();
    flagged[6] = 1;
    assert_eq!(read(&flagged), Err(ModelError::OutOfRange(Field::Flags)));
    assert_eq!(read(b"PK\x03\x04 not a model"), Err(ModelError::NotAModel));
    assert_eq!(read(&[]), Err(ModelError::NotAModel));
}

#[test]
fn models_of_other_versions_say_what_is_to_be_renewed() {
    for version in [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 13] {
        let mut bytes = FILE.to_vec();
        bytes[4] = version;
        let end = bytes.len() - 4;
        let check = crc(&bytes[..end]).to_le_bytes();
        bytes[end..].copy_from_slice(&check);
        let error = ModelError::Version { given: version.into(), supported: 12 };
        assert_eq!(read(&bytes), Err(error));
        assert_eq!((Model::<RunTime>::from_sector(&bytes).err(), stored_len(&bytes)), (Some(error), Err(error)));
        let text = error.to_string();
        let cure = if version > 12 { "newer format version 13" } else { "train the model again" };
        assert!(text.contains(&format!("version {version};")) && text.contains(cure), "{text}");
    }
}

#[test]
fn a_flash_sector_is_read_whatever_follows_the_model() {
    assert_eq!(stored_len(FILE), Ok(FILE.len()));
    for tail in [&[0xFF; 300][..], &[0; 7], FILE] {
        let sector = [FILE, tail].concat();
        assert_eq!(stored_len(&sector), Ok(FILE.len()));
        assert_eq!(Model::<Drive>::from_sector(&sector), Ok(MODEL.clone()));
        assert_eq!(read(&sector), Err(ModelError::Truncated), "more bytes than a file of this model has");
    }
    assert_eq!(Model::<Drive>::from_sector(FILE), Ok(MODEL.clone()));
    assert_eq!(stored_len(&FILE[..FILE.len() - 1]), Err(ModelError::Truncated));
    assert_eq!(Model::<Drive>::from_sector(&FILE[..FILE.len() - 1]), Err(ModelError::Truncated));
    assert_eq!(stored_len(&[0xFF; 4096]), Err(ModelError::NotAModel), "an erased sector");
    // Lengths that no memory has.
    let mut endless = FILE.to_vec();
    endless[8..16].fill(0xFF);
    assert_eq!(stored_len(&endless), Err(ModelError::Truncated));
}

#[test]
fn errors_name_what_is_wrong() {
    for (error, text) in [
        (ModelError::OutOfRange(Field::NominalStability), "nominal model (it must be stable) is out of range"),
        (ModelError::OutOfRange(Field::ForgettingFactor), "forgetting factor is out of range"),
        (ModelError::Length(Field::BearingOrder), "bearing order or its weights has the wrong length"),
        (ModelError::Channel { index: 2 }, "channel 3 of the model has another name or unit than in the plan"),
        (ModelError::Interval { trained_s: 0.002, given_s: 0.001 }, "every 2000 µs, not every 1000 µs"),
        (ModelError::OtherPlan, "for another plan"),
        (ModelError::Checksum, "checksum"),
    ] {
        assert!(error.to_string().contains(text), "{error}");
    }
}

/// CRC-32/ISO-HDLC by its defining polynomial division, apart from the core's.
fn crc(bytes: &[u8]) -> u32 {
    let mut remainder = 0xFFFF_FFFF_u32;
    for byte in bytes {
        for bit in 0..8 {
            let next = (remainder & 1) ^ u32::from((byte >> bit) & 1);
            remainder = (remainder >> 1) ^ if next == 1 { 0xEDB8_8320 } else { 0 };
        }
    }
    !remainder
}

/// Runs what was read, whatever it is.
fn run<P: Plan>(read: Result<Model<P>, ModelError>, samples: impl Iterator<Item = P::Sample>) {
    let Ok(model) = read else { return };
    let mut detector = Detector::new(&model);
    samples.for_each(|sample| {
        let _ = detector.step(&sample);
    });
    let _ = detector.finish();
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Whatever a payload says under a good checksum, reading it and running what was read never panics.
    #[test]
    fn a_forged_payload_is_refused_or_runs(
        changes in prop::collection::vec((16..FILE.len() - 4, any::<u8>()), 1..6),
        samples in prop::collection::vec(any::<(u32, u32, u32)>(), 0..40),
    ) {
        let mut bytes = FILE.to_vec();
        for (place, value) in changes {
            bytes[place] = value;
        }
        let end = bytes.len() - 4;
        let check = crc(&bytes[..end]).to_le_bytes();
        bytes[end..].copy_from_slice(&check);
        let samples = || samples.iter().map(|(y, u1, u2)| [*y, *u1, *u2].map(f32::from_bits));
        let fixed = |[current_a, velocity_ref_rad_s, load_torque_nm]: [f32; 3]| Sample {
            current_a,
            velocity_ref_rad_s,
            load_torque_nm,
        };
        run(read(&bytes), samples().map(fixed));
        let loose = |values: [f32; 3]| RunTimeSample { values: values.to_vec(), ..RunTimeSample::default() };
        run(Model::<RunTime>::from_bytes(&bytes), samples().map(loose));
    }

    /// The layout at the payload's beginning, forged: any layout that fits the rest runs.
    #[test]
    fn a_forged_layout_is_refused_or_runs(changes in prop::collection::vec((16..45_usize, 0..6_u8), 1..4)) {
        let mut bytes = FILE.to_vec();
        for (place, value) in changes {
            bytes[place] = value;
        }
        let end = bytes.len() - 4;
        let check = crc(&bytes[..end]).to_le_bytes();
        bytes[end..].copy_from_slice(&check);
        let sample = |k: u8| RunTimeSample { values: vec![f32::from(k % 7); 5], ..RunTimeSample::default() };
        run(Model::<RunTime>::from_bytes(&bytes), (0..40).map(sample));
    }

    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(read(&bytes).is_err() && Model::<RunTime>::from_sector(&bytes).is_err());
    }
}
