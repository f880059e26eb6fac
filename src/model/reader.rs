//! The payload of a stored model → its layout and constants, in the order in which [`super::stored`] writes them.
//!
//! Lengths are those of the plan; ranges are checked later, except for bytes that select one of a few variants.

use super::{
    Blocks, Channel, Classifier, Constants, Covariate, Covariates, Direction, Directions, Discriminant,
    EvidenceConstants, Feature, Field, Forgetting, KNOTS, Lags, Law, Name, Novelty, Projection, Regression, Rise,
    Sampling, ShaftConstants, TorqueBalance, TrackedOrder, Tracking,
};
use crate::plan::{
    Cells, Kind, Layout, Load, Memory, Method, Plan, Presence as _, RegressionLayout, ShaftLayout, Signal, Structure,
};
use crate::record::{Fault, Input, NONE, WEIGHT};
use crate::signal::Park;

fn floats<C: Cells<f32>>(input: &mut Input<'_>, length: usize) -> C {
    C::from_fn(length, |_| input.f32())
}

fn law(input: &mut Input<'_>) -> Law {
    [[0.0; 2]; KNOTS].map(|_| [input.f32(), input.f32()])
}

fn name<const N: usize>(input: &mut Input<'_>, field: Field) -> Name<N> {
    Name::from_bytes(input.array()).unwrap_or_else(|| {
        input.refuse(Fault::OutOfRange(field));
        Name::EMPTY
    })
}

/// Three signals of one part; a channel that a signal does not have is `NONE`.
fn signals(input: &mut Input<'_>) -> [Signal; 3] {
    core::array::from_fn(|_| {
        let [channel, minus] = input.array();
        Signal { channel, minus: (minus != NONE).then_some(minus) }
    })
}

/// The layout.
///
/// # Errors
/// The first fault.
pub(super) fn read_layout(input: &mut Input<'_>) -> Result<Layout, Fault> {
    let mut layout = Layout { channels: input.u8(), ..Layout::EMPTY };
    if input.flag(Field::Layout) {
        let structure = Structure { offset: input.flag(Field::Layout), ..Structure::from_orders(input.array()) };
        let method = if input.flag(Field::Layout) { Method::Instruments } else { Method::LeastSquares };
        let memory = match input.u8() {
            0 => Memory::Segment,
            2 => Memory::Fading,
            _ => {
                input.refuse(Fault::OutOfRange(Field::Layout));
                Memory::Segment
            }
        };
        let [y, u1, u2] = signals(input);
        layout.regression = Some(RegressionLayout { structure, method, memory, y, u1, u2 });
    }
    if input.flag(Field::Layout) {
        let [current, velocity, load] = signals(input);
        let measured = |signal: Signal| (signal.channel != NONE).then_some(signal);
        let load = match (measured(load), load.minus) {
            (Some(load), _) => Load::Measured(load),
            (None, None) => Load::Unknown,
            (None, Some(WEIGHT)) => Load::Weight { axis_q32: input.u32(), changes: input.flag(Field::Layout) },
            (None, Some(_)) => {
                input.refuse(Fault::OutOfRange(Field::Layout));
                Load::Unknown
            }
        };
        let velocity = measured(velocity);
        let (orders, steps) = (input.u8(), input.u8());
        let (harmonics, decimation) = (steps & 0xF, (steps >> 4).wrapping_add(1));
        layout.shaft = Some(ShaftLayout { current, velocity, load, orders, harmonics, decimation });
    }
    layout.averaged = input.u16();
    [layout.features, layout.covariates, layout.coordinates, layout.rising] = input.array();
    [layout.directions, layout.classes] = input.array();
    layout.discriminant = if input.flag(Field::Layout) { Kind::Quadratic } else { Kind::Linear };
    input.so_far().map(|()| layout)
}

/// The constants; [`Input::finish`] says whether they mean something.
pub(super) fn read<P: Plan>(input: &mut Input<'_>, plan: P) -> Constants<P> {
    let layout = plan.layout();
    let sampling = Sampling {
        interval_s: input.f32(),
        park: match input.choice(2, Field::SamplingInterval) {
            0 => None,
            1 => Some(Park::Standard),
            _ => Some(Park::Thesis),
        },
        block_mean: input.u16(),
        segment_samples: input.u32(),
    };
    Constants {
        sampling,
        channels: Cells::from_fn(layout.channels as usize, |_| Channel {
            name: name(input, Field::ChannelName),
            unit: name(input, Field::ChannelName),
            limit: input.f32(),
            saturation: input.f32(),
            stuck_samples: input.u16(),
        }),
        regression: P::Regressed::part(layout.regressed() == 1, || read_regression(input, plan)),
        shaft: P::Watched::part(layout.watched() == 1, || ShaftConstants {
            lags: Lags::get(input),
            balance: TorqueBalance::get(input),
            tracking: Tracking {
                orders: Cells::from_fn(layout.orders(), |_| TrackedOrder::get(input)),
                blocks: Blocks::get(input),
            },
        }),
        classifier: read_classifier(input, plan),
        evidence: EvidenceConstants::get(input),
        labels: Cells::from_fn(layout.classes as usize, |_| name(input, Field::Label)),
    }
}

fn read_regression<P: Plan>(input: &mut Input<'_>, plan: P) -> Regression<P> {
    let layout = plan.layout();
    Regression {
        scale: floats(input, layout.columns()),
        nominal: floats(input, layout.parameters()),
        forgetting: Forgetting::get(input),
        rest: input.f32(),
        settle: input.u16(),
        handover: input.u16(),
    }
}

fn read_classifier<P: Plan>(input: &mut Input<'_>, plan: P) -> Classifier<P> {
    let layout = plan.layout();
    let (features, classes) = (layout.features as usize, layout.classes as usize);
    Classifier {
        features: Cells::from_fn(features, |_| Feature::get(input)),
        covariates: Covariates {
            list: Cells::from_fn(layout.covariates as usize, |_| Covariate::get(input)),
            map: Cells::from_fn(layout.covariate_map_len(), |_| [input.f32(), input.f32()]),
        },
        projection: Projection {
            matrix: floats(input, layout.map()),
            mean: floats(input, features),
            usual: floats(input, features),
        },
        discriminant: Discriminant {
            means: floats(input, layout.means()),
            factors: floats(input, layout.densities()),
            log_prior: floats(input, classes),
            costs: floats(input, layout.costs()),
            reject_cost: input.f32(),
        },
        novelty: read_novelty(input, plan),
    }
}

fn read_novelty<P: Plan>(input: &mut Input<'_>, plan: P) -> Novelty<P> {
    let (layout, class) = (plan.layout(), input.u8());
    let mut novelty = Novelty { class: (class != NONE).then_some(class), ..Novelty::none(plan) };
    if novelty.class.is_none() {
        return novelty;
    }
    novelty.mean = floats(input, layout.coordinates as usize);
    novelty.factor = floats(input, layout.density());
    novelty.knots = law(input);
    novelty.limit = input.f32();
    if layout.rising > 0 {
        (novelty.freedom, novelty.acceptable) = (input.f32(), input.f32());
        novelty.rises = Cells::from_fn(layout.laws(), |_| Rise::get(input));
        novelty.laws = Cells::from_fn(layout.laws(), |_| law(input));
    }
    if layout.directions > 0 {
        novelty.directions = Directions {
            usual_segments: input.f32(),
            margin: input.f32(),
            most_runs: input.u16(),
            list: Cells::from_fn(layout.directions as usize, |_| Direction::get(input)),
        };
    }
    novelty
}

#[cfg(test)]
mod tests;
