//! Models of every kind with segments of few samples, so that a short input closes several.

#[path = "../../examples/support/classifier.rs"]
mod classifier;
#[path = "../../target-tests/examples/support/law.rs"]
mod law;
#[path = "../../examples/support/numbers.rs"]
pub mod numbers;
#[allow(dead_code, reason = "the hash of its outputs is not wanted here")]
#[path = "../../target-tests/examples/support/raw.rs"]
pub mod raw;
#[path = "../../examples/support/refined.rs"]
pub mod refined;
#[path = "../../target-tests/examples/support/shaft.rs"]
pub mod shaft;
#[path = "../../examples/support/standard_rig/mod.rs"]
pub mod standard_rig;

#[allow(dead_code, reason = "streams of estimators are not wanted here")]
#[path = "../../host-tests/src/plans.rs"]
pub mod run_time;

use std::sync::LazyLock;

use bearing_watch::Model;
use bearing_watch::model::{EvidenceConstants, Feature};
use bearing_watch::plan::Structure;
use bearing_watch::plan::{Cells, Memory, Method, Plan, RunTime};

/// Samples of a segment of [`RIG`] and [`REFINED`].
pub const SHORT: u32 = 64;
/// Samples of a segment of [`WATCHED`] and [`LOADLESS`].
pub const LONG: u32 = 128;

/// The standard rig: least squares.
pub static RIG: LazyLock<Model<standard_rig::model::Drive>> =
    LazyLock::new(|| shortened(&standard_rig::model::MODEL, SHORT));
/// Instrumental variables, the auxiliary model of a nominal one.
pub static REFINED: LazyLock<Model<refined::Refined>> = LazyLock::new(|| shortened(&refined::MODEL, SHORT));
/// Least squares, torque balance and bearing orders.
pub static WATCHED: LazyLock<Model<shaft::Watched>> = LazyLock::new(|| shortened(&shaft::MODEL, LONG));
/// Torque balance and a bearing order without regression and load.
pub static LOADLESS: LazyLock<Model<shaft::Loadless>> = LazyLock::new(|| shortened(&shaft::LOADLESS, LONG));

/// Returns the model with segments of `segment_samples` samples, short times to settle, and an alarm.
///
/// # Panics
/// If it has no such segments.
#[must_use]
pub fn shortened<P: Plan>(model: &Model<P>, segment_samples: u32) -> Model<P> {
    let mut constants = model.constants().clone();
    constants.sampling.segment_samples = segment_samples;
    if let Some(regression) = constants.regression.part_mut() {
        (regression.settle, regression.handover) = (8, 8);
    }
    if let Some(shaft) = constants.shaft.part_mut() {
        (shaft.balance.settle, shaft.balance.row_interval) = (16, 2);
    }
    constants.evidence = EvidenceConstants { limit: 12.0, cap: 5.0, ..EvidenceConstants::NONE };
    Model::new(model.plan(), constants).expect("segments of this length")
}

/// Number of kinds of regressions of [`regression`].
pub const KINDS: usize = 60;

/// A regression alone whose structure, method and memory are those of a number below [`KINDS`]; `None` if they do not
/// fit each other.
#[must_use]
pub fn regression(kind: usize) -> Option<Model<RunTime>> {
    const STRUCTURES: [Structure; 10] = [
        Structure::new(1, 1, 0, 1, 1),
        Structure::new(2, 1, 2, 1, 1),
        Structure::new(2, 3, 3, 1, 1),
        Structure::new(4, 4, 3, 7, 3),
        Structure::new(1, 0, 0, 0, 0),
        Structure::new(0, 1, 1, 0, 0),
        Structure::new(2, 1, 2, 1, 1).with_offset(),
        Structure::new(0, 4, 0, 0, 0).with_offset(),
        Structure::new(4, 0, 0, 0, 0).with_offset(),
        Structure::new(3, 2, 1, 0, 4).with_offset(),
    ];
    let structure = STRUCTURES[kind % STRUCTURES.len()];
    let method = [Method::LeastSquares, Method::Instruments][kind / STRUCTURES.len() % 2];
    let memory = [Memory::Segment, Memory::Fading][kind / (2 * STRUCTURES.len()) % 2];
    let plan = RunTime::of(run_time::layout(structure, method, memory))?;
    let features: Vec<Feature> = (0..structure.parameters() as u8).map(Feature::Parameter).collect();
    let mut constants = run_time::constants(plan, SHORT, &[32.0, 32.0, 32.0], &features, None);
    let own = constants.regression.part_mut()?;
    (own.settle, own.handover, own.rest) = (4, 4, 1e-6);
    own.forgetting = bearing_watch::model::Forgetting { lambda: 0.98, floor: 1.0 };
    Model::new(plan, constants).ok()
}

/// All models of [`regression`].
pub static REGRESSIONS: LazyLock<Vec<Model<RunTime>>> = LazyLock::new(|| (0..KINDS).filter_map(regression).collect());

/// The binary form of a model, without notes.
///
/// # Panics
/// If it is longer than 64 kB.
#[must_use]
pub fn bytes<P: Plan>(model: &Model<P>) -> Vec<u8> {
    let mut buffer = vec![0; 1 << 16];
    let length = model.to_bytes("", &mut buffer).expect("64 kB");
    buffer.truncate(length);
    buffer
}

/// The binary forms of models of every kind.
pub static BYTES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let fixed = [bytes(&*RIG), bytes(&*REFINED), bytes(&*WATCHED), bytes(&*LOADLESS)];
    let loose = REGRESSIONS.iter().step_by(5).map(bytes);
    fixed.into_iter().chain(loose).collect()
});
