//! The binary model: what is written is read back, and nothing altered passes.

use bearing_watch::decide::{EvidencePlan, Novelty};
use bearing_watch::estimate::{Fading, Forgetting, Instruments, Memory, Method, Nominal, Regressor, TwoLevel};
use bearing_watch::{Detector, Model, ModelError, Sample};
use proptest::prelude::*;

#[path = "../../../examples/support/standard_rig/model.rs"]
mod exported;

type Exact = Model<6, 5, 5, 3>;

static FILE: &[u8] = include_bytes!("../../../examples/support/standard_rig/model.bwm");

#[test]
fn binary_and_rust_exports_are_the_same_model() {
    let read = Exact::from_bytes(FILE).expect("good model");
    assert_eq!(read, exported::MODEL);
    assert!(exported::Monitor::new(&exported::MODEL).is_ok());
    let notes = bearing_watch::model::notes(FILE).expect("notes");
    assert!(notes.contains("velocity_ref_rad_s"), "{notes}");
    let mut buffer = vec![0; FILE.len()];
    let length = read.to_bytes(notes, &mut buffer).expect("fits");
    assert_eq!(&buffer[..length], FILE);
    assert_eq!(read.to_bytes(notes, &mut buffer[..FILE.len() - 1]), Err(ModelError::Buffer));
}

#[test]
fn every_corrupted_byte_is_found() {
    for place in 0..FILE.len() {
        for change in (0..8).map(|bit| 1 << bit).chain([0xFF, 0x55]) {
            let mut bytes = FILE.to_vec();
            bytes[place] ^= change;
            assert!(Exact::from_bytes(&bytes).is_err(), "byte {place} ^ {change:#x}");
        }
    }
}

#[test]
fn truncation_extension_other_versions_and_other_files_are_told_apart() {
    for length in 0..FILE.len() {
        assert!(Exact::from_bytes(&FILE[..length]).is_err(), "{length} bytes");
    }
    let longer = [FILE, &[0]].concat();
    assert_eq!(Exact::from_bytes(&longer), Err(ModelError::Length));
    let mut newer = FILE.to_vec();
    newer[4] = 4;
    assert_eq!(Exact::from_bytes(&newer), Err(ModelError::Version(4)));
    let mut flagged = FILE.to_vec();
    flagged[6] = 1;
    assert_eq!(Exact::from_bytes(&flagged), Err(ModelError::Value("flags")));
    assert_eq!(Exact::from_bytes(b"PK\x03\x04 not a model"), Err(ModelError::Magic));
    assert_eq!(Exact::from_bytes(&[]), Err(ModelError::Magic));
}

#[test]
fn a_model_too_large_for_its_detector_is_refused_with_the_reason() {
    assert_eq!(Model::<5, 5, 5, 3>::from_bytes(FILE), Err(ModelError::Capacity("regressor columns")));
    assert_eq!(Model::<6, 4, 5, 3>::from_bytes(FILE), Err(ModelError::Capacity("features")));
    assert_eq!(Model::<6, 5, 4, 3>::from_bytes(FILE), Err(ModelError::Capacity("projected coordinates")));
    assert_eq!(Model::<6, 5, 5, 2>::from_bytes(FILE), Err(ModelError::Capacity("classes")));
    let model = Exact::from_bytes(FILE).expect("good model");
    let small = Detector::<'_, 6, 15, 0, 5, 5, 3>::new(&model);
    assert_eq!(small.err(), Some(ModelError::Capacity("delays")));
}

#[test]
fn values_out_of_range_are_named() {
    let refused = |change: fn(&mut Exact)| {
        let mut model = exported::MODEL;
        change(&mut model);
        model.validate().expect_err("out of range")
    };
    use bearing_watch::Order;
    assert_eq!(refused(|m| m.regression.order = Order::new(0, 0, 0, 1, 1)), ModelError::Value("order"));
    assert_eq!(refused(|m| m.sampling.segment_samples = 0), ModelError::Value("segment length"));
    assert_eq!(refused(|m| m.sampling.segment_samples = 1_000_001), ModelError::Value("segment length"));
    assert_eq!(refused(|m| m.sampling.block_mean = 0), ModelError::Value("block mean"));
    assert_eq!(refused(|m| m.sampling.segment_samples = 8), ModelError::Value("segment length"));
    assert_eq!(refused(|m| m.sampling.block_mean = 1001), ModelError::Value("block mean"));
    assert_eq!(refused(|m| m.regression.scale[0] = 2.0_f32.powi(61)), ModelError::Value("column scale"));
    assert_eq!(refused(|m| m.classifier.discriminant.cost[0][1] = -1.0), ModelError::Value("cost"));
    // What a narrower model leaves unused must be neutral, or a wider detector would decide otherwise.
    assert_eq!(refused(|m| m.classifier.features.count = 4), ModelError::Value("projection"));
    assert_eq!(refused(|m| m.classifier.projection.count = 4), ModelError::Value("projection"));
    assert_eq!(refused(|m| m.regression.scale[0] = 3.0), ModelError::Value("column scale"));
    let three_terms = |m: &mut Exact| {
        m.regression.order = Order::new(3, 1, 1, 1, 1);
        m.regression.scale = [1.0, 2.0, 4.0, 1.0, 1.0, 1.0];
    };
    assert_eq!(refused(three_terms), ModelError::Value("column scale"));
    assert_eq!(refused(|m| m.regression.guard.limit[1] = f32::NAN), ModelError::Value("signal limit"));
    assert_eq!(refused(|m| m.regression.guard.saturation[0] = 1e9), ModelError::Value("saturation"));
    assert_eq!(refused(|m| m.regression.guard.stuck_samples[0] = 1), ModelError::Value("stuck samples"));
    assert_eq!(refused(|m| m.regression.guard.huber = f32::NAN), ModelError::Value("outlier threshold"));
    assert_eq!(refused(|m| m.regression.nominal.deviation = -1.0), ModelError::Value("nominal model"));
    let out_of_reach = |m: &mut Exact| {
        m.regression.guard.limit[0] = 1e18;
        m.regression.guard.saturation[0] = 1e18;
    };
    assert_eq!(refused(out_of_reach), ModelError::Value("signal limit beside the column scale"));
    fn fading(m: &mut Exact, lambda: f32, floor: f32) {
        m.regression.still = 1e-4;
        m.regression.memory = Memory::Fading(Forgetting { lambda, floor });
    }
    assert_eq!(refused(|m| fading(m, 1.0, 1.0)), ModelError::Value("forgetting factor"));
    assert_eq!(refused(|m| fading(m, 0.99995, 1.0)), ModelError::Value("forgetting factor"));
    assert_eq!(refused(|m| fading(m, 0.999, 0.0)), ModelError::Value("forgetting floor"));
    assert_eq!(
        refused(|m| fading(m, 0.9, 1.0)),
        ModelError::Value("forgetting factor"),
        "ten rows for five parameters"
    );
    assert_eq!(refused(|m| m.regression.handover = 2501), ModelError::Value("handover"));
    assert_eq!(refused(|m| m.classifier.features.index[0] = 6), ModelError::Value("feature index"));
    assert_eq!(refused(|m| m.classifier.projection.mean[0] = f32::INFINITY), ModelError::Value("projection"));
    assert_eq!(
        refused(|m| m.classifier.discriminant.whitening[0][0][0] = f32::NAN),
        ModelError::Value("class density")
    );
    assert_eq!(refused(|m| m.classifier.discriminant.log_prior[0] = f32::NEG_INFINITY), ModelError::Value("prior"));
    assert_eq!(refused(|m| m.classifier.discriminant.reject_cost = -1.0), ModelError::Value("reject cost"));
    assert_eq!(refused(|m| m.classifier.discriminant.reject_cost = f32::NAN), ModelError::Value("reject cost"));
    assert_eq!(refused(|m| m.classifier.discriminant.classes = 4), ModelError::Capacity("classes"));
    assert_eq!(refused(|m| m.classifier.discriminant.classes = 0), ModelError::Value("classes"));
}

/// The model with a gate on its first class, and an alarm.
fn watched() -> Exact {
    let mut model = exported::MODEL;
    let knots = std::array::from_fn(|k| [2.0 * k as f32, k as f32]);
    let whitening =
        std::array::from_fn(|i| std::array::from_fn(|j| if j > i { 0.0 } else { 1.0 / (1 + i + j) as f32 }));
    model.classifier.novelty = Novelty { class: 0, mean: [0.5, -1.0, 2.0, 0.0, 1.0], whitening, knots, limit: 4.6 };
    model.classifier.discriminant.reject_cost = 0.25;
    model.evidence = EvidencePlan { bet: 0.2, limit: 13.9, cap: 6.95 };
    model
}

#[test]
fn gate_and_alarm_are_read_back_by_any_capacity() {
    let model = watched();
    let mut buffer = vec![0; 4096];
    let length = model.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Exact::from_bytes(&buffer[..length]), Ok(model));
    let wide = Model::<9, 8, 7, 4>::from_bytes(&buffer[..length]).expect("fits");
    assert_eq!((wide.evidence, wide.classifier.discriminant.reject_cost), (model.evidence, 0.25));
    let z = [0.3, -0.2, 1.0, 0.7, -1.5];
    let padded = [z[0], z[1], z[2], z[3], z[4], 0.0, 0.0];
    assert_eq!(wide.classifier.novelty.judge(&padded), model.classifier.novelty.judge(&z), "the same bits");
    let mut again = vec![0; length];
    assert_eq!(wide.to_bytes("", &mut again), Ok(length));
    assert_eq!(again, buffer[..length]);
}

#[test]
fn gates_and_alarms_out_of_range_are_named() {
    let refused = |change: fn(&mut Exact)| {
        let mut model = watched();
        change(&mut model);
        model.validate().expect_err("out of range")
    };
    for (what, change) in [
        ("healthy class", (|m| m.classifier.novelty.class = 3) as fn(&mut Exact)),
        ("healthy density", |m| m.classifier.novelty.mean[2] = f32::NAN),
        ("healthy density", |m| m.classifier.novelty.whitening[4][0] = f32::INFINITY),
        ("surprise curve", |m| m.classifier.novelty.knots[3][0] = 4.0),
        ("surprise curve", |m| m.classifier.novelty.knots[3][1] = 2.0),
        ("surprise curve", |m| m.classifier.novelty.knots[0][0] = -1.0),
        ("surprise curve", |m| m.classifier.novelty.knots[23][1] = f32::NAN),
        ("novelty limit", |m| m.classifier.novelty.limit = 0.0),
        ("novelty limit", |m| m.classifier.novelty.limit = f32::NAN),
        ("evidence bet", |m| m.evidence.bet = 1.0),
        ("evidence bet", |m| m.evidence.bet = f32::NAN),
        ("evidence limit", |m| m.evidence.limit = 0.0),
        ("evidence cap", |m| m.evidence.cap = f32::INFINITY),
        ("evidence cap", |m| m.evidence.cap = -1.0),
        // Without a healthy class all else is neutral.
        ("healthy density", |m| m.classifier.novelty.class = u8::MAX),
        ("surprise curve", |m| {
            m.classifier.novelty = Novelty { knots: m.classifier.novelty.knots, ..Novelty::NONE };
        }),
        ("novelty limit", |m| m.classifier.novelty = Novelty { limit: 4.6, ..Novelty::NONE }),
    ] {
        assert_eq!(refused(change), ModelError::Value(what));
    }
    let mut never = watched();
    (never.classifier.novelty.limit, never.evidence.limit) = (f32::INFINITY, f32::INFINITY);
    assert_eq!(never.validate(), Ok(()), "a distance without a gate, and no alarm");
}

#[test]
fn sums_that_would_degrade_are_refused() {
    type Segments<'m> = Detector<'m, 6, 15, 1, 5, 5, 3>;
    type Long<'m> = Detector<'m, 6, 15, 1, 5, 5, 3, Regressor<6, 1>, TwoLevel<6, 15>>;
    type Endless<'m> = Detector<'m, 6, 15, 1, 5, 5, 3, Regressor<6, 1>, Fading<6, 15>>;
    let mut model = exported::MODEL;
    model.sampling.segment_samples = 100_001;
    assert_eq!(Segments::new(&model).err(), Some(ModelError::Value("segment length")));
    assert!(Long::new(&model).is_ok());
    assert!(Endless::new(&model).is_err(), "its segments do not fade");
    let forgetting = Forgetting { lambda: 0.999, floor: 10.0 };
    model.regression.memory = Memory::Fading(forgetting);
    model.regression.still = 0.0;
    assert_eq!(model.validate(), Err(ModelError::Value("excitation threshold")), "it would forget at rest");
    model.regression.still = 1e-4;
    assert!(Segments::new(&model).is_err() && Long::new(&model).is_err() && Endless::new(&model).is_ok());
}

#[test]
fn instruments_need_a_stable_nominal_model_and_the_columns() {
    type Wide = Model<8, 5, 5, 3>;
    let mut model = Wide::from_bytes(FILE).expect("good model");
    model.regression.method = Method::Instruments;
    model.regression.nominal.delta[0] = 0.1;
    assert_eq!(model.validate(), Err(ModelError::Value("nominal model, which must be stable,")));
    model.regression.nominal = Nominal { delta: [-0.1, 0.2, 0.1, 0.1, 0.1, 0.0, 0.0, 0.0], deviation: 0.5 };
    assert_eq!(model.validate(), Ok(()));
    assert!(Detector::<'_, 8, 28, 1, 5, 5, 3, Instruments<8, 1>>::new(&model).is_ok());
    assert!(Detector::<'_, 8, 28, 1, 5, 5, 3>::new(&model).is_err(), "rows of least squares");
    let mut buffer = [0; 4096];
    let length = model.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Wide::from_bytes(&buffer[..length]), Ok(model));
    assert_eq!(Model::<7, 5, 5, 3>::from_bytes(&buffer[..length]), Err(ModelError::Capacity("regressor columns")));
    model.sampling.segment_samples = 399;
    assert_eq!(model.validate(), Err(ModelError::Value("segment length beside settling and handover")));
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
        if let Ok(model) = Exact::from_bytes(&bytes)
            && let Ok(mut detector) = Detector::<'_, 6, 15, 8, 5, 5, 3>::new(&model)
        {
            for (y, u1, u2) in samples {
                let _ = detector.step(Sample { y: f32::from_bits(y), u1: f32::from_bits(u1), u2: f32::from_bits(u2) });
            }
            let _ = detector.finish();
        }
    }

    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(Exact::from_bytes(&bytes).is_err());
    }
}
