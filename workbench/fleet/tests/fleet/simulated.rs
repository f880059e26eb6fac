//! A simulated fleet, as features: the rig's classes, with offsets of drives and of runs.
//!
//! ```text
//! f = μ_c + L (√0.3 b_drive + √0.2 b_run + √0.5 e),   L Lᵀ = Σ,   b, e ~ N(0, I)              (1)
//! ```
//!
//! μ_c and Σ are mean and pooled covariance of the features of traces of the DC rig, whose detector is the plan: a
//! model of such a fleet runs on traces of the rig.

use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use bearing_watch_fleet::{Origin, Plan, Row};
use model::Error;
use model::identify::Structure;
use model::trace::{Channels, Preparation};
use model::train::statistics::ClassStatistics;
use model::train::{self, FeatureTable, Recipe};
use rig::{Condition, Defect, DefectKind};
use studies::campaign::experiments::Training;
use studies::campaign::run::{class_names, training_set};

/// Traces of each class from which (1) is.
const TRACES: u32 = 12;
/// Of ten drives, one is of each defect.
const TENTHS: u64 = 10;
const SHARES: [f64; 3] = [0.3, 0.2, 0.5];

/// The fleet to simulate.
#[derive(Clone, Debug)]
pub struct Fleet {
    /// The detector.
    pub plan: Plan,
    classes: Vec<String>,
    means: Vec<DVector<f64>>,
    root: nalgebra::DMatrix<f64>,
    /// Segments of each drive, and runs in which they are.
    segments: u32,
    runs: u32,
    seed: u64,
}

impl Fleet {
    /// Prepares a fleet whose drives have so many segments in so many runs.
    ///
    /// # Errors
    /// Numbers that make no run.
    pub fn new(segments: u32, runs: u32, seed: u64) -> Result<Self, Error> {
        if runs == 0 || segments < runs {
            return Err(Error::Usage(format!("{segments} segments in {runs} runs: give at least one for each run")));
        }
        let defects = vec![Defect::HEALTHY, Defect::full(DefectKind::Spall), Defect::full(DefectKind::Roughness)];
        let classes = class_names(&defects);
        let set = Training { condition: Condition::STANDARD, classes: defects, count: TRACES };
        let traces = training_set(&set, 1)?;
        let channels = Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm");
        let recipe = Recipe { columns: channels.clone(), ..Recipe::new(Structure::new(2, 1, 2, 1, 1)) };
        let found = train::estimating(&traces, &classes, &recipe)?;
        let origin = Origin {
            channels,
            preparation: Preparation::NONE,
            recorded_interval_s: found.interval_s,
            unit: Some("drive".into()),
            group: Some("session".into()),
        };
        let plan = Plan::new(&found, &classes, origin)?;
        let (estimator, catalogue) = (plan.estimator()?, plan.catalogue());
        let row = |own: &model::trace::labels::LabelledTrace| {
            estimator.run(&own.trace).first().map(|segment| train::features_of(segment, &catalogue).0)
        };
        let rows: Vec<DVector<f64>> = traces.iter().filter_map(row).collect();
        let table = FeatureTable::exact(rows, traces.iter().map(|own| own.class).collect(), classes.clone());
        let ClassStatistics { means, pooled, .. } = ClassStatistics::new(&table);
        let singular = || Error::Training("the rig's features are singular".into());
        let root = pooled.cholesky().ok_or_else(singular)?.l();
        Ok(Self { plan, classes, means, root, segments, runs, seed })
    }

    /// The rows of one drive.
    pub fn drive(&self, drive: u64) -> impl Iterator<Item = Row> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(drive);
        let mut normal =
            move |size: usize| DVector::from_fn(size, |_, _| -> f64 { StandardNormal.sample(&mut random) });
        let size = self.root.nrows();
        let class = match drive % TENTHS {
            8 => 1,
            9 => 2,
            _ => 0,
        };
        let of_drive = normal(size) * SHARES[0].sqrt();
        let mut of_run = (u32::MAX, DVector::zeros(size));
        (0..self.segments).map(move |segment| {
            let run = (u64::from(segment) * u64::from(self.runs) / u64::from(self.segments)) as u32;
            if of_run.0 != run {
                of_run = (run, normal(size) * SHARES[1].sqrt());
            }
            let standard = &of_drive + &of_run.1 + normal(size) * SHARES[2].sqrt();
            let value = &self.means[class] + &self.root * standard;
            let unit = format!("drive{drive:09}");
            let texts = [format!("{unit}_{run}"), self.classes[class].clone(), unit, format!("session{run}")];
            let values = value.iter().map(|x| f64::from(*x as f32)).collect();
            Row { texts, segment, usable: 1.0, values, variances: vec![0.0; size], labels: vec![] }
        })
    }
}
