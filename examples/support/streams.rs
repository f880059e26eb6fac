//! Whole streams through every estimator: segments, bad samples, delays; forms known when running and when compiling;
//! solved at once, deferred, and by pieces.

use bearing_watch::estimate::{
    Accumulator, Fading, Forgetting, Form, Memory, Method, Nominal, Rows, Shape, Solver, Triangle, TwoLevel,
};
use bearing_watch::{Counts, Estimate, Estimator, Guard, Instruments, Order, Reason, Regression, Regressor, Sample};

use super::hash::Hash;
use super::numbers::Numbers;

/// Samples a segment: more than two blocks of two levels.
const SEGMENT: usize = 1200;
const SEGMENTS: usize = 4;

/// Who solves a closed segment.
#[derive(Clone, Copy, Debug)]
enum Way {
    Inline,
    Whole,
    Pieces,
}

/// The hash of all that a stream of segments gives, and how many of them have an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    pub bits: u32,
    pub solved: usize,
}

/// A stream of one form: without a memory that differs, with two levels, and with fading memory.
#[derive(Clone, Copy, Debug)]
pub struct Outcomes {
    pub plain: Outcome,
    pub two_level: Outcome,
    pub fading: Outcome,
}

/// Hands number and outcomes of each stream to `report`. Panics where the six ways to the plain one differ by a bit.
pub fn run(report: impl Fn(usize, &Outcomes)) {
    macro_rules! forms {
        ($($number:literal $m:literal $form:expr;)+) => { $({
            /// The form of this stream.
            #[derive(Clone, Copy, Debug, PartialEq)]
            struct Fixed;
            impl Shape for Fixed {
                const FIXED: Option<Form> = Some($form);
            }
            stream::<$m, { $m * ($m - 1) / 2 }, Fixed>($number, $form, &report);
        })+ };
    }
    const fn form(na: u8, nb: u8, nc: u8, [nkb, nkc]: [u8; 2], offset: bool) -> Form {
        Form { order: Order::new(na, nb, nc, nkb, nkc), offset, method: Method::Instruments }
    }
    forms! {
        1 5 form(1, 1, 1, [1, 1], false);
        2 7 form(1, 2, 1, [3, 0], true);
        3 11 form(2, 3, 3, [1, 1], false);
        4 9 form(2, 1, 2, [1, 4], true);
        5 11 form(3, 2, 2, [2, 1], false);
        6 11 form(3, 2, 1, [1, 5], true);
        7 13 form(4, 2, 2, [1, 2], false);
        8 13 form(4, 2, 1, [0, 1], true);
        9 8 Form { method: Method::LeastSquares, ..form(2, 2, 2, [1, 3], true) };
    }
}

fn stream<const M: usize, const P: usize, S: Shape>(number: usize, form: Form, report: &impl Fn(usize, &Outcomes)) {
    let outcomes = match form.method {
        Method::LeastSquares => outcomes::<M, P, Regressor<M, 5>, Regressor<M, 5, S>>(form),
        Method::Instruments => outcomes::<M, P, Instruments<M, 5>, Instruments<M, 5, S>>(form),
    };
    report(number, &outcomes);
}

/// `R` knows the form when running, `S` when compiling.
fn outcomes<const M: usize, const P: usize, R: Rows<M>, S: Rows<M>>(form: Form) -> Outcomes {
    let regression = regression::<M>(form);
    let plain = outcome::<M, P, S, Triangle<M, P>>(&regression, Way::Inline);
    for way in [Way::Inline, Way::Whole, Way::Pieces] {
        assert_eq!(outcome::<M, P, R, Triangle<M, P>>(&regression, way), plain, "{way:?}, form at run time");
        assert_eq!(outcome::<M, P, S, Triangle<M, P>>(&regression, way), plain, "{way:?}, form fixed");
    }
    let two_level = outcome::<M, P, S, TwoLevel<M, P>>(&regression, Way::Inline);
    assert_eq!(outcome::<M, P, R, TwoLevel<M, P>>(&regression, Way::Pieces), two_level, "two levels");
    let forgetting = Forgetting { lambda: 0.999, floor: 1.0 };
    let regression = Regression { memory: Memory::Fading(forgetting), still: 1e-4, ..regression };
    let fading = outcome::<M, P, S, Fading<M, P>>(&regression, Way::Inline);
    assert_eq!(outcome::<M, P, R, Fading<M, P>>(&regression, Way::Pieces), fading, "fading");
    Outcomes { plain, two_level, fading }
}

/// A slow pole with quick ones, in δ-form, and small inputs; the nominal model is a tenth off.
fn regression<const M: usize>(form: Form) -> Regression<M> {
    let t: &[f32] = match form.order.na {
        1 => &[-0.1],
        2 => &[-0.1, 0.5],
        3 => &[-0.08, 0.4, 0.1],
        _ => &[-0.08, 0.4, 0.1, 0.02],
    };
    let mut delta = [0.0; M];
    delta.iter_mut().zip(t).for_each(|(cell, t)| *cell = 1.1 * t);
    let inputs = delta.iter_mut().skip(form.order.na as usize).take((form.order.nb + form.order.nc) as usize);
    inputs.zip([0.5, -0.2, 0.25, 0.1, -0.1, 0.05]).for_each(|(cell, gain)| *cell = gain);
    Regression {
        method: form.method,
        nominal: Nominal { delta, deviation: 0.2 },
        guard: Guard { stuck_samples: [40, 0, 0], huber: 4.0, ..Guard::within([30.0; 3]) },
        settle: 50,
        handover: 20,
        ..Regression::new(form.order, form.offset)
    }
}

/// Everything that a stream of segments gives.
fn outcome<const M: usize, const P: usize, R: Rows<M>, A: Accumulator<M, P>>(
    regression: &Regression<M>,
    way: Way,
) -> Outcome {
    assert!(Estimator::<M, P, 5, R, A>::fits(regression), "the stream has no estimator");
    let (mut hash, mut solved) = (Hash::new(), 0);
    let mut estimator = Estimator::<M, P, 5, R, A>::new(regression);
    let mut plant = Plant::new(regression.order);
    for _ in 0..SEGMENTS {
        (0..SEGMENT).for_each(|_| estimator.step(&plant.sample()));
        let counts = estimator.counts();
        let result = match way {
            Way::Inline => estimator.close(),
            Way::Whole | Way::Pieces => {
                let solver = Solver::new(regression, estimator.detach());
                let result = if matches!(way, Way::Whole) { solver.finish() } else { by_pieces(solver) };
                if let Ok(estimate) = &result {
                    estimator.adopt(estimate);
                }
                result
            }
        };
        solved += usize::from(result.is_ok());
        add(&mut hash, result, counts);
    }
    Outcome { bits: hash.bits(), solved }
}

fn by_pieces<const M: usize, const P: usize, S: Shape>(
    mut solver: Solver<'_, M, P, S>,
) -> Result<Estimate<M, P>, Reason> {
    loop {
        if let Some(result) = solver.advance() {
            return result;
        }
    }
}

fn add<const M: usize, const P: usize>(hash: &mut Hash, result: Result<Estimate<M, P>, Reason>, counts: Counts) {
    let Counts { rejected, saturated, downweighted, still, refused, .. } = counts;
    hash.add(&[rejected, saturated, downweighted, still, u32::from(refused)].map(f32::from_bits));
    match result {
        Ok(estimate) => hash.add_estimate(&estimate),
        // Which reason is told by the verdicts of other examples; here that there is one.
        Err(_) => hash.add(&[f32::NAN]),
    }
}

/// Simulated output of the orders above with noise, levels away from zero, an outlier and a lost sample now and then.
struct Plant {
    numbers: Numbers,
    y: [f32; 2],
    inputs: [[f32; 6]; 2],
    delays: [usize; 2],
    time: u32,
}

impl Plant {
    fn new(order: Order) -> Self {
        let delays = [order.nkb as usize, order.nkc as usize];
        Self { numbers: Numbers(23), y: [0.0; 2], inputs: [[0.0; 6]; 2], delays, time: 0 }
    }

    fn sample(&mut self) -> Sample {
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
        Sample { y: measured, u1, u2 }
    }
}
