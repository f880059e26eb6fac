//! Whole streams through every estimator: segments, bad samples, delays; solved at once, deferred, and in steps.

use bearing_watch::model::{Channel, Forgetting, Regression};
use bearing_watch::plan::{Cells, Layout, Memory, Method, Plan, RegressionLayout, Structure};
use bearing_watch::recursive::RecursiveEstimator;
use bearing_watch::{Counts, Estimate};

use super::support::hash::Hash;
use super::support::numbers::Numbers;

/// Samples a segment.
const SEGMENT: usize = 1200;
const SEGMENTS: usize = 4;

/// How a closed segment is solved.
#[derive(Clone, Copy, Debug)]
enum Way {
    Inline,
    Whole,
    Steps,
}

/// The hash of all results of a stream of segments, and how many of them have an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    pub bits: u32,
    pub solved: usize,
}

/// A stream of one structure with each memory.
#[derive(Clone, Copy, Debug)]
pub struct Outcomes {
    pub plain: Outcome,
    pub fading: Outcome,
}

/// A plan whose sample consists of output and two inputs.
trait Three: Plan {
    fn sample(values: [f32; 3]) -> Self::Sample;
}

#[cfg(feature = "alloc")]
impl Three for bearing_watch::plan::RunTime {
    fn sample(values: [f32; 3]) -> Self::Sample {
        bearing_watch::plan::RunTimeSample { values: values.to_vec(), angle: bearing_watch::Angle::ZERO }
    }
}

/// A plan of one structure and memory.
macro_rules! planned {
    ($plan:ident $sample:ident $method:ident $memory:ident $structure:expr) => {
        bearing_watch::plan! {
            /// The plan.
            struct $plan;
            /// Its sample.
            struct $sample { y: "A", u1: "rad/s", u2: "N·m" }
            layout: Layout {
                regression: Some(RegressionLayout {
                    structure: $structure,
                    method: Method::$method,
                    memory: Memory::$memory,
                    y,
                    u1,
                    u2,
                }),
                features: 1,
                coordinates: 1,
                classes: 1,
                ..Layout::EMPTY
            }
        }

        impl Three for $plan {
            fn sample([y, u1, u2]: [f32; 3]) -> Self::Sample {
                $sample { y, u1, u2 }
            }
        }
    };
}

/// Hands number and outcomes of each stream to `report`. Panics if two ways of a stream differ by a bit.
pub fn run(report: impl Fn(usize, &Outcomes)) {
    macro_rules! streams {
        ($($number:literal $method:ident $structure:expr;)+) => { $({
            const STRUCTURE: Structure = $structure;
            planned!(Plain PlainSample $method Segment STRUCTURE);
            planned!(Faded FadedSample $method Fading STRUCTURE);
            let (plain, fading) = (outcome_of(Plain), outcome_of(Faded));
            report($number, &Outcomes { plain, fading });
        })+ };
    }
    streams! {
        1 Instruments Structure::new(1, 1, 1, 1, 1);
        2 Instruments Structure::new(1, 2, 1, 3, 0).with_offset();
        3 Instruments Structure::new(2, 3, 3, 1, 1);
        4 Instruments Structure::new(2, 1, 2, 1, 4).with_offset();
        5 Instruments Structure::new(3, 2, 2, 2, 1);
        6 Instruments Structure::new(3, 2, 1, 1, 5).with_offset();
        7 Instruments Structure::new(4, 2, 2, 1, 2);
        8 Instruments Structure::new(4, 2, 1, 0, 1).with_offset();
        9 LeastSquares Structure::new(2, 2, 2, 1, 3).with_offset();
    }
}

/// The outcome, the same however segments are solved; with the feature `alloc` also by the plan of host programs.
fn outcome_of<P: Three>(plan: P) -> Outcome {
    let inline = outcome(plan, Way::Inline);
    for way in [Way::Whole, Way::Steps] {
        assert_eq!(outcome(plan, way), inline, "{way:?}");
        #[cfg(feature = "alloc")]
        if let Some(plan) = bearing_watch::plan::RunTime::of(plan.layout()) {
            assert_eq!(outcome(plan, way), inline, "{way:?}, layout at run time");
        }
    }
    inline
}

/// A slow pole with quick ones, in δ-form, and small inputs; the nominal model is a tenth off.
fn regression<P: Plan>(plan: P, layout: &RegressionLayout) -> Regression<P> {
    let Structure { na, nb, nc, .. } = layout.structure;
    let t: &[f32] = match na {
        1 => &[-0.1],
        2 => &[-0.1, 0.5],
        3 => &[-0.08, 0.4, 0.1],
        _ => &[-0.08, 0.4, 0.1, 0.02],
    };
    let mut constants = Regression::new(plan);
    let nominal = constants.nominal.cells_mut();
    nominal.iter_mut().zip(t).for_each(|(cell, t)| *cell = 1.1 * t);
    let inputs = nominal.iter_mut().skip(na as usize).take((nb + nc) as usize);
    inputs.zip([0.5, -0.2, 0.25, 0.1, -0.1, 0.05]).for_each(|(cell, gain)| *cell = gain);
    (constants.settle, constants.handover) = (50, 20);
    if layout.memory == Memory::Fading {
        (constants.forgetting, constants.rest) = (Forgetting { lambda: 0.999, floor: 1.0 }, 1e-4);
    }
    constants
}

/// All results of a stream of segments.
fn outcome<P: Three>(plan: P, way: Way) -> Outcome {
    let (mut hash, mut solved) = (Hash::new(), 0);
    let Some(layout) = plan.layout().regression else { return Outcome { bits: hash.bits(), solved } };
    let constants = regression(plan, &layout);
    let named = [
        Channel { stuck_samples: 40, ..Channel::within("y", "A", 30.0) },
        Channel::within("u1", "rad/s", 30.0),
        Channel::within("u2", "N·m", 30.0),
    ];
    let [y, ..] = named;
    let channels = Cells::from_fn(named.len(), |place| named.get(place).copied().unwrap_or(y));
    let mut stream = RecursiveEstimator::new(plan, &channels, &constants);
    let mut plant = Plant::new(layout.structure);
    for _ in 0..SEGMENTS {
        (0..SEGMENT).for_each(|_| stream.step(&P::sample(plant.sample())));
        let counts = stream.counts();
        let estimate = match way {
            Way::Inline => stream.close(),
            Way::Whole => stream.detach().finish(&constants),
            Way::Steps => {
                let mut segment = stream.detach();
                loop {
                    if let Some(estimate) = segment.advance(&constants) {
                        break estimate.clone();
                    }
                }
            }
        };
        if !matches!(way, Way::Inline) {
            stream.adopt(&estimate);
        }
        solved += usize::from(estimate.reason.is_none());
        add(&mut hash, &estimate, counts);
    }
    Outcome { bits: hash.bits(), solved }
}

fn add<P: Plan>(hash: &mut Hash, estimate: &Estimate<P>, counts: Counts) {
    let Counts { rejected, saturated, resting, refused, .. } = counts;
    hash.add(&[rejected, saturated, resting, u32::from(refused)].map(f32::from_bits));
    match estimate.reason {
        None => hash.add_estimate(estimate),
        // Which reason is told by the verdicts of other examples; here that there is one.
        Some(_) => hash.add(&[f32::NAN]),
    }
}

/// Simulated output of the structures above with noise, levels away from zero, an outlier and a lost sample now and
/// then.
struct Plant {
    numbers: Numbers,
    y: [f32; 2],
    inputs: [[f32; 6]; 2],
    delays: [usize; 2],
    time: u32,
}

impl Plant {
    fn new(structure: Structure) -> Self {
        let delays = [structure.nkb as usize, structure.nkc as usize];
        Self { numbers: Numbers(23), y: [0.0; 2], inputs: [[0.0; 6]; 2], delays, time: 0 }
    }

    fn sample(&mut self) -> [f32; 3] {
        let [u1, u2, noise] = self.numbers.array();
        for (history, newest) in self.inputs.iter_mut().zip([u1 + 0.5, u2 - 0.25]) {
            history.rotate_right(1);
            history[0] = newest;
        }
        let [[u1, ..], [u2, ..]] = self.inputs;
        let [nkb, nkc] = self.delays;
        let delayed = |history: &[f32; 6], delay: usize| history.get(delay).copied().unwrap_or(0.0);
        let [first, second] = &self.inputs;
        let y = 1.5 * self.y[0] - 0.6 * self.y[1] + 0.3 * delayed(first, nkb) + 0.25 * delayed(second, nkc);
        self.y = [y, self.y[0]];
        self.time += 1;
        let measured = match self.time % 1009 {
            500 => f32::NAN,
            700 => 1e3,
            900 => y + 8.0,
            _ => y + 0.1 * noise,
        };
        [measured, u1, u2]
    }
}
